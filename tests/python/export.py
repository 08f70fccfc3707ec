#!/usr/bin/env python3
"""Exports a dataset to every layout and reads it back: with torchvision's own loaders where it has them (if torch is
installed; a plain message tells what was left out), else as the layout's loaders glob and decode.

    python tests/python/export.py DATASET WORK_FOLDER [DATASET_WITH_ONE_BAND]

What must come out is worked out here again with NumPy from the native files.
"""

import io
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile

import numpy as np
from PIL import Image

dataset, work = map(pathlib.Path, sys.argv[1:3])
one_band = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else None
checks = 0
MISS, VALID, OCCLUDED, OUT = range(4)
TILE = 80


def check(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"export.py: {what}")


def export(layout, *options, source=dataset, code=0):
    """The folder, after the program has ended with the exit code; of a refusal, its sentence."""
    out = work / f"{layout}{len(list(work.iterdir()))}"
    command = ["target/debug/satseed", "export", str(source), "--layout", layout]
    run = subprocess.run([*command, "--out", str(out), *options], capture_output=True, text=True)
    check(run.returncode == code, f"{layout} {options}: exit {run.returncode}, {run.stderr}")
    if code:
        check(not out.exists() and not list(work.glob("*unfinished*")), f"{layout}: a refusal leaves something behind")
        return run.stderr
    return out


def read(path):
    return np.array(Image.open(path))


def native(sample):
    """Arrays of a sample: images, disparities, validity maps, left and right."""
    folder = dataset / sample
    pick = lambda name, end: [read(folder / f"{name}_{v}.{end}") for v in ("left", "right")]
    images = [read(folder / f"{v}.png") for v in ("left", "right")]
    return images, pick("disparity", "tif"), pick("validity", "png"), json.loads((folder / "camera.json").read_text())


def window(images, disparities, maps, columns, rows, width, height):
    """Windows of both views from columns (left, right): disparity loses their difference, and what has its match beyond the
    other window is out of frame."""
    shift = columns[0] - columns[1]
    out = [[], [], []]
    for k in (0, 1):
        cut = np.s_[rows : rows + height, columns[k] : columns[k] + width]
        d = (disparities[k][cut].astype(np.float64) - shift).astype(np.float32)
        there = np.arange(width)[None, :] + (-d if k == 0 else d).astype(np.float64)
        m = maps[k][cut].copy()
        m[(m != MISS) & ~((there >= -0.5) & (there < width - 0.5))] = OUT
        for store, value in zip(out, (images[k][cut], d, m)):
            store.append(value)
    return out


def lowest(images, disparities, maps):
    """What `--crop overlap:lowest` leaves."""
    shift = int(np.floor(min(np.nanmin(d) for d in disparities)))
    height, width = maps[0].shape
    return window(images, disparities, maps, (max(shift, 0), max(-shift, 0)), 0, width - abs(shift), height)


def pfm(path):
    data = path.read_bytes()
    head = re.match(rb"Pf\n(\d+) (\d+)\n(-[\d.]+)\n", data)
    check(head is not None, f"{path} is no little-endian PFM")
    width, height = int(head[1]), int(head[2])
    return np.frombuffer(data[head.end() :], "<f4").reshape(height, width)[::-1]


shutil.rmtree(work, ignore_errors=True)
work.mkdir(parents=True)
records = [json.loads(line) for line in (dataset / "manifest.jsonl").read_text().splitlines()]
ids = [r["id"] for r in records]
flat = {i: i.replace("/", "__") for i in ids}
whole = {i: native(i) for i in ids}
crops = {i: lowest(*whole[i][:3]) for i in ids}
negative = any(np.nanmin(whole[i][1][0]) < 0 for i in ids)
check(negative, "the dataset tests the refusals only if it has negative disparities: camera.datum = \"pivot\"")


def of(path):
    """The sample whose flat name stands in a path."""
    found = [i for i in ids if flat[i] in str(path) or i in str(path).replace("/frame_", "/")]
    check(len(found) == 1, f"{path} names no sample, or several")
    return found[0]


def cropped(path):
    """What stands in a file of `--crop overlap:lowest`, perhaps a tile of TILE px."""
    truth = crops[of(path)]
    tile = re.search(r"_t(\d+)-(\d+)", str(path))
    if tile is None:
        return truth
    row, column = int(tile[1]) * TILE, int(tile[2]) * TILE
    return window(*truth, (column, column), row, TILE, TILE)


def expect(what, found, truth, seen, quantum):
    worst = np.abs(found[seen].astype(np.float64) - truth[seen]).max()
    check(seen.sum() > 100, f"{what}: {seen.sum()} pixels test nothing")
    check(worst <= quantum, f"{what}: off by {worst} px, at most {quantum} is its quantum")


# Torchvision's own loaders, over what both views show from the lowest point up.
LOADERS = {
    # layout: class, arguments, quantum, whether images are exact, what its mask (or what is finite) must equal
    "sceneflow": ("SceneFlowStereo", {"variant": "FlyingThings3D", "pass_name": "clean"}, 0, True, None),
    "eth3d": ("ETH3DStereo", {}, 0, True, (VALID,)),
    "middlebury2014": ("Middlebury2014Stereo", {"split": "train"}, 0, True, (VALID,)),
    "sintel": ("SintelStereo", {"pass_name": "final"}, 0.5 / 16384 + 1e-9, True, (VALID,)),
    "kitti": ("Kitti2015Stereo", {"split": "train"}, 1 / 256, True, None),
    "carla": ("CarlaStereo", {}, 0, True, None),
    "crestereo": ("CREStereo", {}, 1 / 32, False, None),
}
try:
    import torchvision.datasets
except ImportError as missing:
    torchvision = None
    print(f"export.py: torchvision's loaders are left out: {missing}")

for layout, (name, arguments, quantum, exact, mask) in LOADERS.items():
    # CREStereo's loader wants a pair in each of its four folders.
    tiles = ("--tile", str(TILE)) if layout == "crestereo" else ()
    out = export(layout, "--crop", "overlap:lowest", *tiles)
    if torchvision is None:
        continue
    loader = getattr(torchvision.datasets, name)(str(out), **arguments)
    check(len(loader) >= 4 if tiles else len(loader) == len(ids), f"{layout}: {len(loader)} pairs of {len(ids)}")
    for k in range(len(loader)):
        item = loader[k]
        sample = of(loader._images[k][0])
        check(of(loader._images[k][1]) == sample and of(loader._disparities[k][0]) == sample, f"{layout} mixes pairs up")
        images, disparities, maps = cropped(loader._images[k][0])
        for side in (0, 1):
            found = np.array(item[side]).astype(int)
            truth = images[side].astype(int)
            check(found.shape == truth.shape, f"{layout}: a picture of {found.shape}")
            off = np.abs(found - truth)
            check(off.max() == 0 if exact else off.mean() < 3, f"{layout}: a picture is not ours ({off.mean()})")
        found = item[2][0]
        expect(f"{layout} {sample}", found, disparities[0], maps[0] == VALID, quantum)
        if mask is not None:
            given = np.squeeze(item[3]).astype(bool)
            # A disparity of exactly 0 is invalid to Middlebury's loader.
            wrong = (given != np.isin(maps[0], mask)) & (disparities[0] != 0)
            check(not wrong.any(), f"{layout}: the mask is wrong at {wrong.sum()} pixels")
        elif layout == "kitti":
            check(((found > 0) == (maps[0] != MISS)).all(), "kitti: disp_occ holds what was hit")
        elif layout == "crestereo":
            check(((found > 0) == (maps[0] == VALID)).all(), "crestereo: only what both see has a value")
        else:
            check((np.isfinite(found) == (maps[0] == VALID)).all(), f"{layout}: infinite wherever one camera is blind")
        if layout in ("sceneflow", "carla", "middlebury2014", "crestereo"):
            right, _ = loader._read_disparity(loader._disparities[k][1])
            expect(f"{layout} {sample} right", right[0], disparities[1], maps[1] == VALID, quantum)
    if layout == "kitti":
        for path in out.glob("Kitti2015/training/disp_noc_0/*.png"):
            images, disparities, maps = crops[of(path)]
            check(((read(path) > 0) == (maps[0] == VALID)).all(), "kitti: disp_noc holds what both see")

# RAFT-Stereo's way to MiddEval3: names from the list, PFM, and 255 where both see.
out = export("middlebury", "--crop", "overlap:lowest")
names = (out / "MiddEval3/official_train.txt").read_text().split()
check(names == [flat[i] for i in ids], "middlebury: the list names all scenes")
for name in names:
    images, disparities, maps = crops[of(name)]
    folder = out / "MiddEval3/trainingF" / name
    found, nocc = pfm(folder / "disp0GT.pfm"), read(folder / "mask0nocc.png") == 255
    check((nocc == (maps[0] == VALID)).all() and np.isfinite(found[nocc]).all(), "middlebury: mask")
    expect("middlebury", found, disparities[0], maps[0] != MISS, 0)
    calibration = dict(line.split("=", 1) for line in (folder / "calib.txt").read_text().splitlines())
    f = float(calibration["cam0"][1:].split()[0])
    camera = whole[of(name)][3]
    depth = f * float(calibration["baseline"]) / 1000 / (found + float(calibration["doffs"]))
    truth = camera["left"]["fx_px"] * camera["baseline_m"] / (disparities[0].astype(np.float64) + float(calibration["doffs"]))
    check(np.nanmax(np.abs(depth - truth)[maps[0] == VALID]) < 1e-3, "middlebury: depth by its calibration")

# The published layout: by region, numbered, 0 without a match.
out = export("satunreal")
for region in sorted({r["region"] for r in records}):
    mine = [r["id"] for r in records if r["region"] == region]
    check(len(list((out / region / "Color").glob("O*_L.png"))) == len(mine), "satunreal: pictures")
    for n, sample in enumerate(mine):
        images, disparities, maps, camera = whole[sample]
        check((read(out / region / f"Color/O{n}_R.png") == images[1]).all(), "satunreal: right picture")
        found = read(out / region / f"Disparity_raw/O{n}.tif")
        expect("satunreal", found, disparities[0], maps[0] == VALID, 0)
        check((found[maps[0] != VALID] == 0).all(), "satunreal: 0 where there is no match")
        seen = disparities[0][maps[0] == VALID]
        scaled = (disparities[0] - seen.min()) / (seen.max() - seen.min()) * 255
        grey = read(out / region / f"Disparity_Normalized/O{n}.png").astype(float)
        check(np.abs(grey - scaled)[maps[0] == VALID].max() <= 0.51, "satunreal: normalised")
        told = json.loads((out / region / f"Json/O{n}.json").read_text())
        check(told["baseline_m"] == camera["baseline_m"] and told["image_width_px"] == maps[0].shape[1], "satunreal: json")
        check(abs(told["lookAtT_Ratio"] - 0.5) < 1e-9 and told["camL"]["focal_length_mm"] == 20, "satunreal: json")
        target, left = np.array(told["target_pos_m"]), np.array(told["camL"]["world_location_m"])
        down = (target - left)[2] / np.linalg.norm(target - left)
        check(abs(np.degrees(np.arccos(-down)) - told["camL"]["tilt_deg"]) < 1e-9, "satunreal: tilt")

# US3D: signed floats, -999 where there is nothing; classes of LAS.
out = export("us3d", "--tile", "64", "--crop", "overlap")
tiles = sorted(out.glob("*_LEFT_DSP.tif"))
check(len(tiles) >= len(ids), f"us3d: {len(tiles)} tiles")
signs = set()
for path in tiles:
    found = read(path)
    signs |= set(np.sign(found[found != -999]))
    for other, shape in (("LEFT_RGB", (64, 64, 3)), ("RIGHT_RGB", (64, 64, 3)), ("LEFT_AGL", (64, 64))):
        check(read(str(path).replace("LEFT_DSP", other)).shape == shape, f"us3d: {other}")
    classes = read(str(path).replace("DSP", "CLS"))
    check(set(np.unique(classes)) <= {2, 5, 6, 9, 17, 65}, "us3d: classes")
check(signs >= {-1.0, 1.0}, "us3d: disparities of both signs")

# Pandora: the other sign.
out = export("pandora")
for sample in ids:
    images, disparities, maps, camera = whole[sample]
    folder = out / flat[sample]
    found = read(folder / "left_disparity.tif")
    expect("pandora", -found, disparities[0], maps[0] == VALID, 0)
    check((found[maps[0] != VALID] == -9999).all(), "pandora: invalid")
    check((read(folder / "left_mask.tif") == (maps[0] == MISS)).all(), "pandora: mask")
    low, high = json.loads((folder / "config.json").read_text())["input"]["left"]["disp"]
    seen = -disparities[0][maps[0] != MISS]
    check(low <= seen.min() and seen.max() <= high, "pandora: range")

# Tar shards: cropped tiles of half size. Labels stand where the native ones do, and the camera knows it.
out = export("webdataset", "--downsample", "2", "--crop", "overlap", "--tile", "48")
shards = sorted(out.glob("shards/*.tar"))
check(len(shards) == (len(ids) + 7) // 8, f"webdataset: {len(shards)} shards")
entries = {}
for path in shards:
    check(path.read_bytes()[-1024:] == bytes(1024), "webdataset: a shard has its end")
    with tarfile.open(path) as tar:
        names = [m.name.split(".", 1)[0] for m in tar.getmembers()]
        check(names == sorted(names, key=names.index), "webdataset: a sample's files stand together")
        for member in tar.getmembers():
            key, ending = member.name.split(".", 1)
            entries.setdefault(key, {})[ending] = tar.extractfile(member).read()
check(len(entries) >= len(ids) and {of(key) for key in entries} == set(ids), f"webdataset: {len(entries)} samples")
for key, files in entries.items():
    camera = json.loads(files["camera.json"])
    found = np.array(Image.open(io.BytesIO(files["disparity.tif"])))
    check(found.shape == (48, 48) and camera["left"]["width_px"] == 48, "webdataset: tiles")
    images, disparities, maps, before = whole[of(key)]
    # The place of each pixel in the native frame, from the principal points alone.
    x = np.arange(48)
    u = 2 * (x - camera["left"]["cx_px"]) + before["left"]["cx_px"]
    v = 2 * (x - camera["left"]["cy_px"]) + before["left"]["cy_px"]
    check(np.allclose(u % 1, 0.5) and np.allclose(v % 1, 0.5), "webdataset: a pixel of half size lies between four")
    i, j = np.meshgrid(np.floor(u).astype(int), np.floor(v).astype(int))
    depth = camera["left"]["fx_px"] * camera["baseline_m"] / (found + camera["doffs_px"])
    native_depth = before["left"]["fx_px"] * before["baseline_m"] / (disparities[0].astype(np.float64) + before["doffs_px"])
    four = np.stack([native_depth[j, i], native_depth[j, i + 1], native_depth[j + 1, i], native_depth[j + 1, i + 1]])
    known = np.isfinite(found)
    check(known.sum() > 100, "webdataset: labels")
    inside = (depth >= four.min(0) - 1e-2) & (depth <= four.max(0) + 1e-2)
    check(inside[known].all(), f"webdataset: {(~inside[known]).sum()} depths are none of their four pixels'")
    picture = np.array(Image.open(io.BytesIO(files["left.png"]))).astype(float)
    mean = np.mean([images[0][j + b, i + a].astype(float) for a in (0, 1) for b in (0, 1)], axis=0)
    check(np.abs(picture - mean).max() <= 0.51, "webdataset: a picture of half size is the mean")
    right = np.array(Image.open(io.BytesIO(files["right.png"]))).astype(float)
    ur = np.floor(2 * (x - camera["right"]["cx_px"]) + before["right"]["cx_px"]).astype(int)
    i, j = np.meshgrid(ur, np.floor(v).astype(int))
    mean = np.mean([images[1][j + b, i + a].astype(float) for a in (0, 1) for b in (0, 1)], axis=0)
    check(np.abs(right - mean).max() <= 0.51, "webdataset: the right picture has a window of its own")

# WHU-Stereo: one band of 16 bits.
if one_band is not None:
    out = export("whu", "--crop", "overlap", source=one_band)
    ours = {json.loads(line)["id"]: json.loads(line)["split"] for line in (one_band / "manifest.jsonl").read_text().splitlines()}
    found = sorted(out.glob("*/disp/*_disparity_*.tiff"))
    check(len(found) == len(ours), "whu: pairs")
    for path in found:
        left = str(path).replace("/disp/", "/left/").replace("_disparity_", "_left_")
        right = str(path).replace("/disp/", "/right/").replace("_disparity_", "_right_")
        check(read(left).dtype == np.uint16 and read(right).shape == read(path).shape, "whu: pictures")
        d = read(path)
        check(((d == -999) | ((d >= -128) & (d < 64))).all() and (d != -999).sum() > 100, "whu: disparities")

# What a loader would read wrongly is refused, and nothing is left behind.
check("camera.datum" in export("sceneflow", code=2), "a negative disparity is refused with what to do")
check("camera.datum" in export("kitti", code=2), "KITTI has no sign")
check("gf7_pan" in export("whu", code=2), "WHU has one band")
check("at least 4" in export("crestereo", "--crop", "overlap:lowest", code=2), "fewer pairs than folders")
check("does not fit" in export("eth3d", "--crop", "overlap:lowest", "--tile", "4096", code=2), "a tile larger than the frame")
check("nothing in common" in export("pandora", "--crop", "overlap:899.9", code=2), "no overlap at the cameras")
check("split" in export("pandora", "--split", "nosuch", code=2), "an unknown split")
taken = work / "taken"
taken.mkdir()
(taken / "mine").write_text("mine")
for folder, word in ((taken, "folder of its own"), (work / "left" / "x", "without `left`")):
    layout = "sceneflow"
    run = subprocess.run(
        ["target/debug/satseed", "export", str(dataset), "--layout", layout, "--out", str(folder)],
        capture_output=True,
        text=True,
    )
    check(run.returncode == 2 and word in run.stderr, f"{folder}: {run.stderr}")
check((taken / "mine").read_text() == "mine", "what was there stays")

print(f"export.py: {checks} checks of {len(ids)} samples")
