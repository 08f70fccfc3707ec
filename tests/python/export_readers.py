#!/usr/bin/env python3
"""Reads exports of a dataset with the packages that their users have: rasterio, webdataset, and Pandora where it is installed.

    pip install numpy pillow rasterio webdataset [pandora]
    python tests/python/export_readers.py DATASET WORK_FOLDER [--pandora | --shards N]

`--pandora` makes a missing Pandora an error. `--shards N` reads the webdataset layout alone, of a dataset that fills so many
shards. What must come out is taken from the native files, read with Pillow.
"""

import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import warnings

import numpy as np
import rasterio
import webdataset
from PIL import Image

dataset, work = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
MISS, VALID = 0, 1
# What US3D's tools call each of our classes: 0 to 14, see docs/dataset.md.
LAS = np.array([65, 2, 2, 6, 6, 17, 2, 5, 9, 65, 65, 2, 2, 2, 65], np.uint8)
checks = 0
warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)


def check(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"export_readers.py: {what}")


def export(layout, *options):
    out = work / f"{layout}{len(list(work.iterdir()))}"
    program = str(pathlib.Path("target/debug/satseed").resolve())
    command = [program, "export", str(dataset), "--layout", layout, "--out", str(out), *options]
    run = subprocess.run(command, capture_output=True, text=True)
    check(run.returncode == 0, f"{layout}: {run.stderr}")
    return out


def native(sample, name):
    return np.array(Image.open(dataset / sample / name))


def raster(path):
    """The only band of an exported raster, which lies in an image and not on a map."""
    with rasterio.open(path) as file:
        check(file.crs is None and file.transform.is_identity and file.nodata is None, f"{path.name}: a rectified image")
        check(file.count == 1, f"{path.name}: one band")
        return file.read(1)


def same(found, truth):
    return found.dtype == truth.dtype and found.shape == truth.shape and np.array_equal(found, truth, equal_nan=True)


shutil.rmtree(work, ignore_errors=True)
work.mkdir(parents=True)
records = [json.loads(line) for line in (dataset / "manifest.jsonl").read_text().splitlines()]
ids = [record["id"] for record in records]
flat = {sample.replace("/", "__"): sample for sample in ids}


def us3d():
    """US3D: every value of every raster, as its tools read them."""
    out = export("us3d")
    numbers = {}
    for record in records:
        sample = record["id"]
        number = numbers.setdefault(record["region"], 0)
        numbers[record["region"]] += 1
        name = f"{sample.split('/')[0]}_{number:03}_000_000"
        valid = native(sample, "validity_left.png") == VALID
        truth = np.where(valid, native(sample, "disparity_left.tif"), np.float32(-999))
        check(same(raster(out / f"{name}_LEFT_DSP.tif"), truth), f"us3d {sample}: disparities, -999 where one camera is blind")
        check(valid.any() and not valid.all(), f"us3d {sample}: some pixels are masked")
        check(same(raster(out / f"{name}_LEFT_CLS.tif"), LAS[native(sample, "class_left.png")]), f"us3d {sample}: classes")
        above = raster(out / f"{name}_LEFT_AGL.tif")
        hit = native(sample, "validity_left.png") != MISS
        roof = hit & (native(sample, "class_left.png") == 3)
        check(((above != -999) == hit).all(), f"us3d {sample}: heights wherever something was hit")
        check(not roof.any() or np.median(above[roof]) > 2.5, f"us3d {sample}: roofs stand above the ground")
        for side in ("LEFT", "RIGHT"):
            with rasterio.open(out / f"{name}_{side}_RGB.tif") as file:
                check(file.count == 3 and same(np.moveaxis(file.read(), 0, -1), native(sample, f"{side.lower()}.png")), "us3d: pictures")
    check(len(list(out.glob("*_LEFT_DSP.tif"))) == len(ids), "us3d: one raster a sample")


def shards():
    """webdataset, by its own pattern of shards: several samples in one, tiles too, and all values."""
    for options, tile in (((), None), (("--tile", "64"), 64)):
        out = export("webdataset", *options)
        names = sorted(path.name for path in (out / "shards").iterdir())
        check(names == [f"{k:06}.tar" for k in range((len(ids) + 7) // 8)], f"webdataset: shards {names}")
        urls = f"{out}/shards/{{000000..{len(names) - 1:06}}}.tar"
        samples = list(webdataset.WebDataset(urls, shardshuffle=False, empty_check=False))
        height, width = native(ids[0], "validity_left.png").shape
        tiles = (height // tile) * (width // tile) if tile else 1
        check(len(samples) == len(ids) * tiles > len(names), f"webdataset: {len(samples)} samples in {len(names)} shards")
        check(len({s["__key__"] for s in samples}) == len(samples), "webdataset: each has a key of its own")
        seen = 0
        for given in samples:
            name, _, place = given["__key__"].partition("_t")
            sample = flat[name]
            row, column = (int(k) * tile for k in place.split("-")) if tile else (0, 0)
            part = np.s_[row : row + tile, column : column + tile] if tile else np.s_[:, :]
            picture = lambda key: np.array(Image.open(io.BytesIO(given[key])))
            camera = json.loads(given["camera.json"])
            truth = native(sample, "disparity_left.tif")[part]
            check(same(picture("disparity.tif"), truth), f"webdataset {given['__key__']}: disparity")
            check(same(picture("disparity_right.tif"), native(sample, "disparity_right.tif")[part]), "webdataset: right disparity")
            for side in ("left", "right"):
                check(same(picture(f"{side}.png"), native(sample, f"{side}.png")[part]), f"webdataset: {side} picture")
            check(camera["left"]["width_px"] == truth.shape[1], "webdataset: the camera is the tile's")
            # A match beyond the tile is out of frame: what is valid has it inside.
            valid = picture("validity.png") == VALID
            whole = native(sample, "validity_left.png")[part] == VALID
            there = np.arange(truth.shape[1])[None, :] - truth.astype(np.float64)
            inside = (there >= -0.5) & (there < truth.shape[1] - 0.5)
            check(np.array_equal(valid, whole & inside), f"webdataset {given['__key__']}: validity")
            seen += int(valid.sum())
        check(seen > 10_000, f"webdataset: only {seen} valid pixels were compared")


def matched():
    """Pandora: its own check of the configuration, its own reader, and its own matcher, which tells the sign."""
    try:
        import pandora
        from pandora import check_configuration, img_tools, state_machine
    except ImportError as missing:
        pandora = None
        print(f"export_readers.py: Pandora is left out: {missing}")
        check("--pandora" not in sys.argv, "Pandora was asked for")
    out = export("pandora")
    for sample in ids:
        folder = out / sample.replace("/", "__")
        valid, truth = native(sample, "validity_left.png"), native(sample, "disparity_left.tif")
        found = raster(folder / "left_disparity.tif")
        check(same(found, np.where(valid == VALID, -truth, np.float32(-9999))), f"pandora {sample}: disparity, -9999 if masked")
        check(same(raster(folder / "left_mask.tif"), (valid == MISS).astype(np.uint8)), f"pandora {sample}: mask")
        if pandora is None:
            continue
        os.chdir(folder)
        machine = state_machine.PandoraMachine()
        config = check_configuration.check_conf(check_configuration.read_config_file("config.json"), machine)
        low, high = config["input"]["left"]["disp"]
        config["input"]["right"]["disp"] = [-high, -low]
        left, right = (img_tools.create_dataset_from_inputs(config["input"][side]) for side in ("left", "right"))
        check_configuration.check_datasets(left, right)
        grey = native(sample, "left.png").astype(np.float32).mean(-1, dtype=np.float32)
        check(np.abs(left["im"].data - grey).max() < 1e-4, f"pandora {sample}: picture")
        check(low <= found[valid == VALID].min() and found[valid == VALID].max() <= high, f"pandora {sample}: range")
        masked = left["msk"].data != 0 if "msk" in left else np.zeros(valid.shape, bool)
        check(np.array_equal(masked, valid == MISS), f"pandora {sample}: its mask")
        matched, _ = pandora.run(machine, left, right, config)
        off = np.abs(matched["disparity_map"].data - found)[valid == VALID]
        near = np.mean(off <= 1)
        print(f"export_readers.py: Pandora's own matches of {sample}: {near:.0%} lie within 1 px of the labels")
        check(near > 0.5, f"pandora {sample}: only {near:.0%} of its matches lie within 1 px of the labels")


if "--shards" in sys.argv:
    wanted = int(sys.argv[sys.argv.index("--shards") + 1])
    check((len(ids) + 7) // 8 == wanted, f"{len(ids)} samples do not fill {wanted} shards of 8")
    shards()
else:
    us3d()
    shards()
    matched()
print(f"export_readers.py: {checks} checks of {len(ids)} samples")
