#!/usr/bin/env python3
"""Reads a dataset with the libraries that its users have, and compares what they give with the recorded hashes.

    pip install blake3 numpy pillow opencv-python-headless tifffile imagecodecs rasterio
    python tests/python/read_back.py DATASET

A library that is not installed is skipped with a message; `--all` makes that an error.
"""

import argparse
import importlib
import json
import pathlib
import sys

import numpy as np
from blake3 import blake3

READERS = {}


def reader(module):
    def register(function):
        READERS[function.__name__] = (module, function)
        return function

    return register


@reader("cv2")
def opencv(path):
    cv2 = importlib.import_module("cv2")
    array = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if array is None:
        raise ValueError("imread gave nothing")
    return array[..., ::-1] if array.ndim == 3 else array  # OpenCV has blue first


@reader("PIL.Image")
def pillow(path):
    image = importlib.import_module("PIL.Image").open(path)
    return np.array(image)


@reader("tifffile")
def tifffile(path):
    return importlib.import_module("tifffile").imread(path)


@reader("rasterio")
def rasterio(path):
    with importlib.import_module("rasterio").open(path) as file:
        array = file.read()
    return array[0] if array.shape[0] == 1 else np.moveaxis(array, 0, -1)


# What each library can read at all. OpenCV and Pillow know no 32-bit unsigned or signed three-channel TIFF.
def can_read(name, path, dtype, channels):
    if path.suffix == ".png":
        return name != "tifffile"
    if name in ("opencv", "pillow"):
        return dtype == np.float32 and channels == 1
    return True


DTYPES = {
    "disparity": (np.float32, 1),
    "elevation": (np.float32, 1),
    "instance": (np.uint32, 1),
    "normal": (np.int16, 3),
    "left": (np.uint8, 3),
    "right": (np.uint8, 3),
    "dsm": (np.float32, 1),
    "dtm": (np.float32, 1),
    "ndsm": (np.float32, 1),
}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("dataset", type=pathlib.Path)
    parser.add_argument("--all", action="store_true", help="fail where a library is missing")
    arguments = parser.parse_args()

    missing = []
    for name, (module, _) in READERS.items():
        try:
            importlib.import_module(module)
        except ImportError:
            missing.append(name)
    if missing:
        print(f"skipped, not installed: {', '.join(missing)}", file=sys.stderr)
        if arguments.all:
            return 1

    files, reads, failures = {}, 0, []
    manifest = (arguments.dataset / "manifest.jsonl").read_bytes()
    root = (arguments.dataset / "manifest.blake3").read_text().split()[0]
    if blake3(manifest).hexdigest() != root:
        failures.append("manifest.jsonl has not the hash in manifest.blake3")
    for line in manifest.decode().splitlines():
        record = json.loads(line)
        files.update({entry["path"]: (name, entry) for name, entry in record["files"].items()})

    for relative, (name, entry) in files.items():
        path = arguments.dataset / relative
        if blake3(path.read_bytes()).hexdigest() != entry["blake3"]:
            failures.append(f"{relative}: its bytes have not the recorded hash")
        if "pixels_blake3" not in entry:
            continue
        dtype, channels = DTYPES.get(name.split("_")[0], (np.uint8, 1))
        for library, (_, read) in READERS.items():
            if library in missing or not can_read(library, path, dtype, channels):
                continue
            try:
                array = read(path)
            except Exception as error:  # any failure of any library is one line of the report
                failures.append(f"{relative}: {library} cannot read it: {error}")
                continue
            reads += 1
            if array.dtype != dtype or array.ndim != (3 if channels == 3 else 2):
                failures.append(f"{relative}: {library} gives {array.dtype} {array.shape}")
                continue
            pixels = np.ascontiguousarray(array.astype(np.dtype(dtype).newbyteorder("<")))
            if blake3(pixels.tobytes()).hexdigest() != entry["pixels_blake3"]:
                failures.append(f"{relative}: {library} gives other pixels than were written")

    if "rasterio" not in missing:
        failures += check_frames(arguments.dataset, files)
    for failure in failures:
        print(failure, file=sys.stderr)
    print(f"{len(files)} files, {reads} arrays read: {len(failures)} failures")
    return 1 if failures or not reads else 0


def check_frames(dataset, files):
    """The surface models lie where scene.json says: square cells, north up, the pivot in the middle."""
    failures = []
    rasterio_module = importlib.import_module("rasterio")
    for relative, (name, _) in files.items():
        if name not in ("dsm", "dtm", "ndsm"):
            continue
        scene = json.loads((dataset / relative).with_name("scene.json").read_text())
        with rasterio_module.open(dataset / relative) as file:
            t, bounds = file.transform, file.bounds
            ok = t.a > 0 and t.e == -t.a and t.b == 0 and t.d == 0
            ok &= abs(bounds.left + bounds.right) < 1e-6 and abs(bounds.bottom + bounds.top) < 1e-6
            ok &= bounds.right >= scene["full_detail_radius_m"] - t.a
            row, column = file.index(1e-9, -1e-9)
            height = file.read(1)[row, column]
            ok &= np.isnan(file.nodata)
        if name == "dtm":
            ok &= abs(height - scene["pivot_height_m"]) < 2 * t.a + 0.5
        if not ok:
            failures.append(f"{relative}: its frame is {t}, bounds {bounds}")
    return failures


if __name__ == "__main__":
    sys.exit(main())
