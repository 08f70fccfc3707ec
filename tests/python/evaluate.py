#!/usr/bin/env python3
"""Holds `satseed evaluate` against plain NumPy, and against what is known of OpenCV's semi-global matcher.

    pip install numpy opencv-python-headless tifffile imagecodecs
    python tests/python/evaluate.py DATASET WORK_FOLDER

The metrics are worked out here again from their definitions (docs/evaluate.md), with nothing in common but the files.
"""

import json
import math
import pathlib
import shutil
import subprocess
import sys

import cv2
import numpy as np
import tifffile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples"))
import sgbm  # noqa: E402

TOLERANCE = 1e-9
dataset, work = map(pathlib.Path, sys.argv[1:3])
checks = 0


def check(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"evaluate.py: {what}")


def evaluate(predictions, *options, code=0):
    """The report, after the program has ended with the exit code."""
    file = work / "report.json"
    command = ["target/debug/satseed", "evaluate", str(dataset)]
    command += ["--predictions", str(predictions), "--json", str(file), *options]
    ended = subprocess.run(command, capture_output=True, text=True)
    check(ended.returncode == code, f"exit code {ended.returncode}, not {code}: {ended.stdout}{ended.stderr}")
    return json.loads(file.read_text()), ended.stdout


def samples():
    for line in (dataset / "manifest.jsonl").read_text().splitlines():
        record = json.loads(line)
        folder = dataset / record["id"]
        yield record, {
            "disparity": tifffile.imread(folder / "disparity_left.tif").astype(np.float64),
            "validity": cv2.imread(str(folder / "validity_left.png"), cv2.IMREAD_UNCHANGED),
            "left": cv2.imread(str(folder / "left.png")),
            "class": cv2.imread(str(folder / "class_left.png"), cv2.IMREAD_UNCHANGED),
            "elevation": tifffile.imread(folder / "elevation_left.tif").astype(np.float64),
            "normal": tifffile.imread(folder / "normal_left.tif").astype(np.float64),
            "shadow": cv2.imread(str(folder / "shadow_left.png"), cv2.IMREAD_UNCHANGED),
            "camera": json.loads((folder / "camera.json").read_text()),
            "ground": folder.parent / "dtm.tif",
        }


# --- what each file format gives back ------------------------------------------------------------------------------------

def write_pfm(path, array):
    path.write_bytes(b"Pf\n%d %d\n-1.0\n" % array.shape[::-1] + array[::-1].astype("<f4").tobytes())
    return array.astype(np.float32)


def write_tif(path, array):
    tifffile.imwrite(path, array.astype(np.float32), compression="deflate", predictor=True)
    return array.astype(np.float32)


def write_npy(path, array):
    np.save(path, np.asfortranarray(array))
    return array


def write_png(path, array):
    coded = np.where(np.isfinite(array) & (array > 0), np.round(array * 256), 0).astype(np.uint16)
    cv2.imwrite(str(path), coded)
    return np.where(coded > 0, coded / 256.0, np.nan)


FORMATS = {"pfm": write_pfm, "tif": write_tif, "npy": write_npy, "png": write_png}


# --- the metrics again ---------------------------------------------------------------------------------------------------

def scores(error, truth):
    n = error.size
    if n == 0:
        return {"pixels": 0}
    there = error[np.isfinite(error)]
    size = np.abs(there)
    out = {"pixels": n, "unpredicted": (n - there.size) / n}
    if there.size:
        out |= {"epe_px": size.mean(), "bias_px": there.mean()}
    for t in (1, 2, 3):
        out[f"within_{t}"] = (size <= t).sum() / n
        out[f"bad_{t}"] = 1 - out[f"within_{t}"]
    known = np.abs(truth[np.isfinite(error)])
    out["d1"] = ((size > 3) & (size > 0.05 * known)).sum() / n + out["unpredicted"]
    return out


def same(ours, theirs, where):
    for key, value in ours.items():
        told = theirs[key]
        check(told is not None and abs(told - value) <= TOLERANCE * max(1, abs(value)), f"{where}.{key}: {told}, not {value}")


def compare(told, error, truth, visibility, mask, where):
    for name, part in (("noc", visibility == 1), ("occ", visibility == 2), ("all", np.isin(visibility, (1, 2)))):
        same(scores(error[mask & part], truth[mask & part]), told[name], f"{where}.{name}")


def contrast_steps(image):
    grey = image.astype(np.int64).sum(axis=2)
    rows, columns = grey.shape
    out = np.empty(grey.shape, dtype=int)
    for v in range(rows):
        for u in range(columns):
            w = grey[max(v - 4, 0) : v + 5, max(u - 4, 0) : u + 5]
            n = w.size
            out[v, u] = int(math.sqrt(n * int((w * w).sum()) - int(w.sum()) ** 2) / (3 * n) * 16)
    return out


def jump_marks(d):
    marks = np.zeros(d.shape, bool)
    across, down = np.abs(np.diff(d, axis=1)) > 3, np.abs(np.diff(d, axis=0)) > 3
    marks[:, :-1] |= across
    marks[:, 1:] |= across
    marks[:-1] |= down
    marks[1:] |= down
    return marks


def squared_distance(marks):
    if not marks.any():
        return np.full(marks.shape, 2**31)
    v, u = np.nonzero(marks)
    rows, columns = np.indices(marks.shape)
    out = np.full(marks.shape, 2**31)
    for a, b in zip(v, u):
        np.minimum(out, (rows - a) ** 2 + (columns - b) ** 2, out=out)
    return out


def soft_edge(d, predicted, marks, side):
    reach, out = side // 2, []
    for v, u in np.argwhere(marks & np.isfinite(predicted)):
        window = d[max(v - reach, 0) : v + reach + 1, max(u - reach, 0) : u + reach + 1]
        out.append(np.abs(window - predicted[v, u]).min())
    return out


def height_above_ground(maps):
    """From the elevation label, where the program goes by disparity and cameras."""
    left = maps["camera"]["left"]
    z = maps["elevation"]
    rows, columns = np.indices(z.shape)
    depth = left["position_m"][2] - z
    ray = np.stack([(columns - left["cx_px"]) / left["fx_px"], (rows - left["cy_px"]) / left["fy_px"], np.ones(z.shape)])
    world = np.tensordot(np.array(left["world_from_camera"]), ray * depth, axes=1)
    x, y = world[0] + left["position_m"][0], world[1] + left["position_m"][1]
    with tifffile.TiffFile(maps["ground"]) as file:
        ground, tags = file.asarray(), file.pages[0].tags
        cell, tie = tags[33550].value[0], tags[33922].value
    column, row = np.floor((x - tie[3]) / cell).astype(int), np.floor((tie[4] - y) / cell).astype(int)
    return z - ground[row, column], np.stack([(x - tie[3]) / cell, (tie[4] - y) / cell])


def reference():
    predictions = work / "noisy"
    shutil.rmtree(predictions, ignore_errors=True)
    everything, draws = [], np.random.default_rng(5)
    for i, (record, maps) in enumerate(samples()):
        d = maps["disparity"]
        made = d + draws.normal(0, 1.5, d.shape) + np.where(draws.random(d.shape) < 0.05, 20, 0)
        made[draws.random(d.shape) < 0.03] = [np.nan, np.inf, -np.inf][i % 3]
        extension = list(FORMATS)[i % 4]
        flat = i % 2 == 1
        path = predictions / f"{record['id'].replace('/', '__') if flat else record['id']}.{extension}"
        path.parent.mkdir(parents=True, exist_ok=True)
        predicted = np.where(np.isfinite(made), made, np.nan)
        everything.append((record, maps, FORMATS[extension](path, made if extension != "png" else predicted)))
    return predictions, everything


def against_numpy():
    for extension, write in FORMATS.items():
        for record, maps in list(samples())[:1]:
            folder = work / "one"
            shutil.rmtree(folder, ignore_errors=True)
            path = folder / f"{record['id']}.{extension}"
            path.parent.mkdir(parents=True)
            back = write(path, maps["disparity"] + 0.25).astype(np.float64)
            told, _ = evaluate(folder, code=1 if len(list(samples())) > 1 else 0)
            error = back - maps["disparity"]
            mask = np.ones(error.shape, bool)
            compare(told["total"]["scores"], error, maps["disparity"], maps["validity"], mask, extension)

    predictions, everything = reference()
    told, _ = evaluate(predictions)
    check(told["evaluated"] == len(everything) and not told["missing"] and not told["strangers"], "all are evaluated")
    keys = ("disparity", "validity", "class", "shadow")
    maps = {k: np.concatenate([m[k].ravel() for _, m, _ in everything]) for k in keys}
    d, visibility = maps["disparity"], maps["validity"]
    predicted = [np.where(np.isfinite(p), p, np.nan).astype(np.float64) for _, _, p in everything]
    error = np.concatenate([p.ravel() for p in predicted]) - d
    region = np.concatenate([np.full(p.size, f"{r['region']}/{r['variant']}") for (r, _, p) in everything])
    baseline = np.concatenate([np.full(p.size, r["baseline_m"]) for (r, _, p) in everything])
    counted = np.isin(visibility, (1, 2))

    def groups(rows, masks, where):
        check(len(rows) == sum((m & counted).any() for m in masks), f"{where} has {len(rows)} rows")
        for row, mask in zip(rows, (m for m in masks if (m & counted).any())):
            compare(row, error, d, visibility, mask, f"{where}.{row['name']}")

    whole = np.ones(d.shape, bool)
    compare(told["total"]["scores"], error, d, visibility, whole, "total")
    for part, values in (("noc", (1,)), ("occ", (2,)), ("all", (1, 2))):
        means = []
        for (_, m, _), p in zip(everything, predicted):
            e = np.abs(p - m["disparity"])[np.isin(m["validity"], values)]
            means += [np.nanmean(e)] if np.isfinite(e).any() else []
        same({part: np.mean(means)}, told["total"]["epe_images_px"], "epe_images_px")

    by = told["total"]["by"]
    step = np.concatenate([contrast_steps(m["left"]).ravel() for _, m, _ in everything])
    counts = np.bincount(step[counted], minlength=2041)
    tenth_of_step = np.minimum((np.cumsum(counts) - counts) * 10 // counts.sum(), 9)
    tenth = tenth_of_step[step]
    groups(by["texture"]["rows"], [tenth == t for t in range(10)], "texture")
    for own in told["regions"]:
        name = f"{own['region']}/{own['variant']}"
        compare(own["scores"], error, d, visibility, region == name, name)
        rows = {row["name"]: row for row in own["by"]["texture"]["rows"]}
        for t in range(10):
            mask = (region == name) & (tenth == t)
            if (mask & counted).any():
                compare(rows[f"{t + 1} of 10"], error, d, visibility, mask, f"{name}.texture")
    low = min(r["disparity_min_px"] for r, _, _ in everything)
    high = max(r["disparity_max_px"] for r, _, _ in everything)
    low, high = float(np.float32(low)), float(np.float32(high))
    bin_ = np.minimum(((d - low) / ((high - low) / 16)).astype(int), 15)
    groups(by["disparity"]["rows"], [bin_ == b for b in range(16)], "disparity")
    groups(by["class"]["rows"], [maps["class"] == c for c in range(15)], "class")
    shadow = maps["shadow"]
    groups(by["shadow"]["rows"], [shadow == 0, (shadow > 0) & (shadow < 255), shadow == 255], "shadow")
    normal = np.concatenate([m["normal"].reshape(-1, 3) for _, m, _ in everything])
    slope = np.degrees(np.arccos(normal[:, 2] / np.sqrt((normal**2).sum(axis=1))))
    ends = [0, 5, 15, 30, 45, 60, 75, 181]
    groups(by["slope"]["rows"], [(slope >= a) & (slope < b) for a, b in zip(ends, ends[1:])], "slope")
    lengths = sorted(set(baseline))
    groups(by["baseline"]["rows"], [baseline == b for b in lengths], "baseline")

    marks = [jump_marks(m["disparity"]) for _, m, _ in everything]
    distance = np.concatenate([squared_distance(m).ravel() for m in marks])
    ends = [-1, 0, 4, 25, 100, 400, 2500, 2**32]
    groups(
        by["boundary_distance"]["rows"],
        [(distance > a) & (distance <= b) for a, b in zip(ends, ends[1:])],
        "boundary_distance",
    )
    boundary = told["total"]["boundary"]
    compare(boundary["within_5_px"], error, d, visibility, distance <= 25, "boundary")
    for side in (3, 5):
        every = [
            soft_edge(m["disparity"], p, k & np.isin(m["validity"], (1, 2)), side)
            for (_, m, _), p, k in zip(everything, predicted, marks)
        ]
        same({f"see_{side}_px": np.mean(np.concatenate(every))}, boundary, "boundary")

    # Heights come another way, from the elevation label: bins may differ where a pixel lies within rounding of a border
    # of a bin or of a ground cell, so counts are held to a thousandth.
    height, place = zip(*(height_above_ground(m) for _, m, _ in everything))
    height = np.concatenate([h.ravel() for h in height])
    ends = [-np.inf, 2.5, 10, 30, 60, np.inf]
    rows = {row["from"]: row["all"]["pixels"] for row in by["height"]["rows"]}
    for a, b in zip(ends, ends[1:]):
        ours = ((height >= a) & (height < b) & counted).sum()
        told_pixels = rows.get(None if a == -np.inf else a, 0)
        check(abs(ours - told_pixels) <= counted.sum() / 1000, f"height {a}: {told_pixels} pixels, not {ours}")


# --- what is wrong is said -------------------------------------------------------------------------------------------------

def against_mistakes():
    def with_change(name, change):
        folder = work / name
        shutil.rmtree(folder, ignore_errors=True)
        draws = np.random.default_rng(7)
        for record, maps in samples():
            path = folder / f"{record['id']}.pfm"
            path.parent.mkdir(parents=True, exist_ok=True)
            d = maps["disparity"] + draws.normal(0, 0.15, maps["disparity"].shape)
            write_pfm(path, change(d))
        return folder

    for mistake, change in {
        "sign": lambda d: -d,
        "scale": lambda d: d * 16,
        "half_pixel": lambda d: d + 0.5,
        "whole_pixel": lambda d: d - 1,
        "upside_down": lambda d: d[::-1],
        "mirrored": lambda d: d[:, ::-1],
    }.items():
        folder = with_change(mistake, change)
        told, text = evaluate(folder)
        first = told["likely_mistakes"][0] if told["likely_mistakes"] else {"mistake": "nothing", "samples": 0}
        check(first["mistake"] == mistake, f"{mistake} is taken for {first}")
        check("likely mistake in" in text, "the terminal says it too")
    told, _ = evaluate(with_change("fine", lambda d: d))
    check(told["likely_mistakes"] == [], f"nothing is wrong, but it says {told['likely_mistakes']}")
    evaluate(work / "fine", "--fail-above", "noc.epe_px=0.5")
    _, text = evaluate(work / "half_pixel", "--fail-above", "noc.epe_px=0.3", code=1)
    check("failed: noc.epe_px is 0." in text, text)


# --- OpenCV's matcher ------------------------------------------------------------------------------------------------------

def against_sgbm():
    predictions = work / "sgbm"
    shutil.rmtree(predictions, ignore_errors=True)
    script = pathlib.Path(sgbm.__file__)
    subprocess.run([sys.executable, str(script), str(dataset), str(predictions)], check=True)
    told, _ = evaluate(predictions)
    noc, occ = told["total"]["scores"]["noc"], told["total"]["scores"]["occ"]
    print(f"SGBM: EPE {noc['epe_px']:.3f} px, bad 1 {noc['bad_1']:.3f} where both see; {occ['epe_px']:.3f}, {occ['bad_1']:.3f} occluded")
    check(occ["epe_px"] > 2 * noc["epe_px"] and occ["bad_1"] > 2 * noc["bad_1"], "occluded pixels are far worse")
    kinds = {m["mistake"] for m in told["likely_mistakes"]}
    check(not kinds & {"sign", "half_pixel", "whole_pixel", "scale"}, f"a matcher's maps look like {kinds}")

    # The matcher's own bias, on pictures that are shifted by exactly 7 px; and on what both cameras see of the dataset.
    # Over all samples: the matcher pulls towards whole pixels, and a small picture has few roofs of few disparities.
    own, biases = [], []
    for record, maps in samples():
        left = maps["left"]
        shifted = sgbm.match(left, np.roll(left, -7, axis=1), 0, 16)[8:-8, 32:-32]
        own.append((shifted - 7).ravel())
        d = tifffile.imread(predictions / f"{record['id']}.tif").astype(np.float64)
        step = contrast_steps(left)
        valid = maps["validity"] == 1
        textured = valid & (step >= np.median(step[valid]))
        biases.append((d - maps["disparity"])[textured])
        print(f"{record['id']}: median bias {np.nanmedian(biases[-1]):+.4f} px, shifted picture {np.nanmedian(own[-1]):+.4f} px")
    bias, own = (np.nanmedian(np.concatenate(x)) for x in (biases, own))
    print(f"all: median bias {bias:+.4f} px, shifted pictures {own:+.4f} px")
    check(abs(bias - own) < 0.15, f"a bias of {bias} px, where the matcher's own is {own} px")


work.mkdir(parents=True, exist_ok=True)
against_numpy()
against_mistakes()
against_sgbm()
print(f"{checks} passed, 0 failed")
