#!/usr/bin/env python3
"""Embree and satseed on the same scenes and the same rays, in alternating rounds.

    benches/peers/compare.py [--scenes toronto,forest] [--rounds 7] [--out benches/runs/NAME.json]

Brings Embree 4 (the shared library inside the `embreex` wheel) into a virtual environment under target/, compiles
embree.cpp, builds the bench `trace`, lets it export each scene with its rays, and checks that both sides say the same before
anything is timed. Both sides trace on one thread; what counts is processor time. The table gives medians over rounds of
our speed over Embree's in the same round.
"""

import argparse
import glob
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "target" / "peers"
FAMILIES = ["primary", "primary4", "label", "sun", "ambient"]
# Of rays, the share on which both sides must agree. Embree's rays and triangles are of f32, and its rays start 2 mm off their
# surface: what grazes an edge, and what stands nearer than that, may differ. In crowns, where leaves run into each other,
# that is 1.3 % of the rays into the dome.
AGREE = {"closest": 0.985, "any": 0.995}


def run(*command, **more):
    return subprocess.run([str(c) for c in command], check=True, cwd=ROOT, **more)


def embree_library():
    """The library's path, in a virtual environment that is made where there is none."""
    venv = WORK / "venv"
    if not (venv / "bin" / "python").exists():
        run(sys.executable, "-m", "venv", venv)
    run(venv / "bin" / "pip", "install", "--quiet", "--disable-pip-version-check", "embreex", "numpy")
    found = glob.glob(str(venv / "lib" / "python3*" / "site-packages" / "embreex.libs" / "libembree4*"))
    if len(found) != 1:
        sys.exit(f"compare: expected one libembree4 in the embreex wheel, found {found}")
    # Its neighbour, the threading library, must be found too.
    os.environ["LD_LIBRARY_PATH"] = str(Path(found[0]).parent)
    return found[0], venv / "bin" / "python"


def build(bench):
    """The driver of Embree and, unless there is one, the bench."""
    driver = WORK / "embree"
    source = ROOT / "benches" / "peers" / "embree.cpp"
    run("g++", "-std=c++17", "-O3", "-march=native", "-Wall", "-Wextra", "-o", driver, source, "-ldl")
    if bench:
        return driver, bench
    built = run("cargo", "bench", "--bench", "trace", "--no-run", "--message-format=json", stdout=subprocess.PIPE, text=True)
    messages = [json.loads(line) for line in built.stdout.splitlines()]
    benches = [m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == "trace"]
    return driver, benches[-1]


class Side:
    """A process that builds a scene's trees once and traces what it is asked for."""

    def __init__(self, *command):
        self.process = subprocess.Popen(
            [str(c) for c in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT
        )
        self.start = self.answer()

    def answer(self):
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"compare: {self.process.args[0]} ended with {self.process.wait()}")
        return json.loads(line)

    def ask(self, what):
        self.process.stdin.write(what + "\n")
        self.process.stdin.flush()
        return self.answer()

    def end(self):
        self.process.stdin.close()
        self.process.wait()


def agreement(python, folder, family):
    """The share of a family's rays on which both sides agree, as Embree's last checked answer has it."""
    code = """
import numpy, sys
folder, family = sys.argv[1:]
ours = numpy.load(f"{folder}/{family}-answers.npy")
theirs = numpy.fromfile(f"{folder}/{family}-embree.f32", "<f4")
assert ours.shape == theirs.shape
# 1 cm, and what a ray's start of 2 mm off its surface and f32 add over a long way.
with numpy.errstate(invalid="ignore"):
    same = (ours == theirs) | (abs(ours - theirs) <= 0.01 + 2e-5 * ours)
print(same.mean())
"""
    out = run(python, "-c", code, folder, family, stdout=subprocess.PIPE, text=True).stdout
    return float(out)


def compare(scene, args, library, python, driver, bench):
    folder = WORK / scene
    folder.mkdir(parents=True, exist_ok=True)
    ours = Side(bench, "--peer", scene, "--export", folder, "--share", args.share)
    theirs = Side(driver, library, folder, args.quality, int(args.robust))
    result = {"scene": scene, "ours": ours.start, "embree": theirs.start, "families": {}}
    best = {}
    for family in FAMILIES:
        kind = "closest" if (folder / f"{family}-closest.npy").exists() else "any"
        shares, speeds = {}, {}
        for way in ["1", "16", "16c"]:
            speeds[way] = theirs.ask(f"{family} {way} check")["cpu_s"]
            shares[way] = agreement(python, folder, family)
            if not shares[way] >= AGREE[kind]:
                sys.exit(f"compare: {scene}, {family}, {way}: only {shares[way]:.5f} of the rays have one answer")
        ours.ask(family)
        # Embree may say whether its packets are coherent: as is better for it.
        best[family] = min(["16", "16c"], key=speeds.get)
        result["families"][family] = {"agreement": shares, "packets": best[family], "rounds": []}
        print(f"{scene} {family}: agreement {shares}", flush=True)
    for number in range(args.rounds):
        for family in FAMILIES:
            asks = {
                "ours": lambda: ours.ask(family),
                "single": lambda: theirs.ask(f"{family} 1"),
                "packets": lambda: theirs.ask(f"{family} {best[family]}"),
            }
            # Who begins changes from round to round.
            order = list(asks)[number % 3 :] + list(asks)[: number % 3]
            round_ = {who: asks[who]() for who in order}
            result["families"][family]["rounds"].append({w: r["cpu_s"] for w, r in round_.items()})
            result["families"][family]["rays"] = round_["ours"]["rays"]
    ours.end()
    theirs.end()
    for family, of in result["families"].items():
        speed = {w: of["rays"] / statistics.median(r[w] for r in of["rounds"]) / 1e6 for w in ["ours", "single", "packets"]}
        of["mrays_per_cpu_s"] = speed
        for other in ["single", "packets"]:
            of[f"ratio_{other}"] = statistics.median(r[other] / r["ours"] for r in of["rounds"])
    result["memory_ratio"] = result["ours"]["build"]["tree_bytes"] / result["embree"]["tree_bytes"]
    result["build_ratio"] = result["ours"]["build"]["cpu_s"] / result["embree"]["cpu_s"]
    return result


def table(result):
    print(f"\n{result['scene']}: {result['ours']['build']['triangles_placed']} triangles placed")
    print(f"{'rays':10} {'ours':>8} {'single':>8} {'packets':>8} {'/single':>8} {'/packets':>8}   M rays a CPU second")
    for family, of in result["families"].items():
        s = of["mrays_per_cpu_s"]
        print(
            f"{family:10} {s['ours']:8.2f} {s['single']:8.2f} {s['packets']:8.2f}"
            f" {of['ratio_single']:8.2f} {of['ratio_packets']:8.2f}"
        )
    mib = 1 / 2**20
    print(
        f"trees: {result['ours']['build']['tree_bytes'] * mib:.0f} MiB against {result['embree']['tree_bytes'] * mib:.0f} MiB,"
        f" ratio {result['memory_ratio']:.2f}; built in {result['ours']['build']['cpu_s']:.2f} s against"
        f" {result['embree']['cpu_s']:.2f} s"
    )


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default="toronto,forest", help="subjects of the bench `trace`")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--share", type=int, default=2, help="one in so many rows of the frame")
    parser.add_argument("--quality", type=int, default=1, choices=[0, 1, 2], help="Embree's build: low, medium, high")
    parser.add_argument("--robust", action="store_true", help="Embree's watertight mode")
    parser.add_argument("--bench", type=Path, help="the bench `trace`, where it is built already")
    parser.add_argument("--out", type=Path, help="where the raw results are written")
    args = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    library, python = embree_library()
    driver, bench = build(args.bench)
    everything = {
        "date": time.strftime("%Y-%m-%d %H:%M %Z"),
        "processor": processor(),
        "cores": os.cpu_count(),
        "load_before": os.getloadavg(),
        "quality": args.quality,
        "robust": args.robust,
        "scenes": [],
    }
    for scene in args.scenes.split(","):
        result = compare(scene, args, library, python, driver, bench)
        table(result)
        everything["scenes"].append(result)
    everything["load_after"] = os.getloadavg()
    if args.out:
        args.out.write_text(json.dumps(everything, indent=1) + "\n")


if __name__ == "__main__":
    main()
