#!/usr/bin/env python3
"""Sweeps the texture contrast of a desert and the baseline over canyons, and holds the curves of OpenCV's matcher against what must be.

    pip install numpy opencv-python-headless tifffile imagecodecs
    python tests/python/sweep.py WORK_FOLDER
"""

import json
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples"))
import sgbm  # noqa: E402

work = pathlib.Path(sys.argv[1])
checks = 0
SMALL = ["camera.size_px=[192,192]", "acquisition.pairs_per_pivot=1", "acquisition.azimuth_deg=[20.0]"]


def check(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"sweep.py: {what}")


def satseed(*arguments, code=0):
    ended = subprocess.run(["target/debug/satseed", *arguments], capture_output=True, text=True)
    check(ended.returncode == code, f"exit code {ended.returncode}, not {code}: {ended.stdout}{ended.stderr}")
    return ended.stdout + ended.stderr


def sweep(name, scenes, vary, *more):
    out, seeds = work / name, work / f"{name}.txt"
    seeds.write_text("".join(f"{scene} radius_m=90\n" for scene in scenes))
    arguments = ["sweep", "quickstart", "--seeds", str(seeds), "--out", str(out), "--vary", vary, "--quiet"]
    arguments += [part for key in [*SMALL, *more] for part in ("--set", key)]
    told = satseed(*arguments)
    index = json.loads((out / "sweep.json").read_text())
    cells = [cell["name"] for cell in index["cells"]]
    roots = [(out / cell / "manifest.blake3").read_text()[:64] for cell in cells]
    check(told.split()[::2] == roots and told.split()[1::2] == cells, f"root hashes are printed: {told}")
    check(len(set(roots)) == len(cells), "every cell is another dataset")
    # The same command again finds everything done; another sweep is refused.
    check(satseed(*arguments) == told, "the sweep is resumed")
    other = [("camera.size_px=[160,160]" if a == SMALL[0] else a) for a in arguments]
    check("another sweep" in satseed(*other, code=2), "another sweep's folder is refused")
    seen = [
        [(r["region"], r["scene_seed"], r["id"].split("/")[1], r["split"]) for r in map(json.loads, lines)]
        for lines in ((out / cell / "manifest.jsonl").read_text().splitlines() for cell in cells)
    ]
    check(all(s == seen[0] for s in seen), "the cells have the same scenes and pairs")
    for cell in cells:
        subprocess.run([sys.executable, sgbm.__file__, str(out / cell), str(work / "predictions" / name / cell)], check=True)
    report, page = work / f"{name}.json", work / f"{name}.html"
    text = satseed("evaluate", str(out), "--predictions", str(work / "predictions" / name), "--json", str(report), "--report", str(page))
    curves = json.loads(report.read_text())
    check([s["cell"] for s in curves["scores"]] == cells, "every cell has its scores")
    check(all(cell in text for cell in cells), text)
    for scores in curves["scores"]:
        each = scores["evaluation"]["each"]
        check([s["samples"] for s in scores["scenes"]] == [1] * len(scenes), f"a pair each: {scores['scenes']}")
        check([s["noc_epe_px"] for s in scores["scenes"]] == [e["noc"]["epe_px"] for e in each], "a scene's scores are its samples'")
    check(page.read_text().count("<svg") == 3, "the page has a plot for each metric")
    noc = [s["evaluation"]["total"]["scores"]["noc"] for s in curves["scores"]]
    print(f"{vary}: SGBM's EPE", *(f"{n['epe_px']:.3f}" for n in noc), "px, bad 1", *(f"{n['bad_1']:.4f}" for n in noc))
    return noc


shutil.rmtree(work, ignore_errors=True)
work.mkdir(parents=True)
# Less to see, more errors: at 0 the sand shows its form alone, and where that is flat only the sensor's noise is left.
noc = sweep("contrast", ["desert 4"], "scene.desert.texture_contrast=0,0.4,1.5", "acquisition.baseline_m=[200.0]")
check(noc[0]["bad_1"] > 10 * noc[1]["bad_1"] and noc[0]["epe_px"] > noc[1]["epe_px"] > noc[2]["epe_px"], "less contrast, more errors")
# A longer baseline: a pixel of error is less height, and walls look less alike.
noc = sweep("baseline", ["canyon 7", "canyon 9"], "acquisition.baseline_m=50,100,200")
check(noc[0]["epe_px"] < noc[1]["epe_px"] < noc[2]["epe_px"], "a longer baseline, larger errors in pixels")
print(f"{checks} passed, 0 failed")
