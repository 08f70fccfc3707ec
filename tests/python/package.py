#!/usr/bin/env python3
"""Tests the Python package: the same arrays as the files, refusals, threads, pickling, fork; with torch, the data sets.

    python tests/python/package.py DATASET [torch]     (satseed importable; NumPy, Pillow, tifffile; torch where it is there)

`torch` runs the tests of the torch data sets alone.
"""

import concurrent.futures
import json
import multiprocessing
import pathlib
import pickle
import subprocess
import sys

import numpy as np

import satseed

root = pathlib.Path(sys.argv[1])
checks = 0
SMALL = {"camera.size_px": [64, 48], "scene.canyon.radius_m": 60, "acquisition.pairs_per_pivot": 3,
         "sensor.samples_per_pixel": 1, "light.ambient": "per-sample"}
CANYONS = "extends = 'quickstart'\n[[scene]]\ncanyon = {}\npivots = 2\n"


def check(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"package.py: {what}")


def refused(error, told, call):
    try:
        call()
    except error as e:
        check(told in str(e), f"{e!r} does not say {told!r}")
    except BaseException as e:
        sys.exit(f"package.py: {e!r} instead of {error.__name__} with {told!r}")
    else:
        sys.exit(f"package.py: nothing refused where {told!r} was to be said")


def same(a, b):
    if set(a.arrays) != set(b.arrays):
        return False
    return all(x.dtype == b.arrays[k].dtype and x.shape == b.arrays[k].shape and x.tobytes() == b.arrays[k].tobytes() for k, x in a.arrays.items())


def against_files():
    try:
        import tifffile
        from PIL import Image
    except ImportError:
        print("package.py: the files' arrays are left out, since tifffile and Pillow are not here")
        return
    dataset = satseed.open(root)
    check(dataset.root_hash == (root / "manifest.blake3").read_text()[:64] and len(dataset) > 0, "the dataset opens")
    for index, scene in enumerate(satseed.plan(root / "recipe.toml")):
        with satseed.Scene(root / "recipe.toml", index=index) as built:
            check(built.pairs == [p["id"] for p in scene["pairs"]], "a scene's pairs are the plan's")
            for pair in built.pairs:
                made, read = built.sample(pair), dataset.sample(pair)
                check(same(made, read) and made.camera == read.camera, f"{pair}: made and read differ")
                check((made.id, made.split, made.baseline_m) == (read.id, read.split, read.baseline_m), f"{pair}: facts differ")
                folder = root / pair
                check(made.camera == json.loads((folder / "camera.json").read_text()), f"{pair}: cameras differ")
                for name, array in made.arrays.items():
                    file = next(folder.glob(f"{name}.*"))
                    found = np.asarray(Image.open(file)) if file.suffix == ".png" else tifffile.imread(file)
                    check(found.dtype == array.dtype and found.tobytes() == array.tobytes(), f"{file} is not the array")
    check(dataset.filter(region="canyon").records == [r for r in dataset.records if r["region"] == "canyon"], "filter")
    check(len(dataset[:1]) == 1 and same(dataset[-1], dataset[len(dataset) - 1]), "slices and negative numbers")
    check(same(pickle.loads(pickle.dumps(dataset))[0], dataset[0]), "a dataset is pickled by its folder")
    few = satseed.open(root, arrays=["left", "disparity_left"])[0]
    check(set(few.arrays) == {"left", "disparity_left"}, "only what is asked for is read")


def refusals():
    R, D = satseed.RecipeError, satseed.DatasetError
    refused(R, "neither a preset", lambda: satseed.generate("nothing"))
    refused(R, "unknown key `gsdm`", lambda: satseed.generate(set={"camera.gsdm": 1}))
    refused(R, "must lie", lambda: satseed.generate(set={"scene.canyon.relief_m": 1e9}))
    refused(R, "none of index 9", lambda: satseed.generate(index=9))
    refused(R, "no pair 'b99'", lambda: satseed.generate(CANYONS, set=SMALL, pair="b99"))
    refused(R, "none of index 77", lambda: satseed.generate(CANYONS, set=SMALL, pair=77))
    refused(R, "key=value", lambda: satseed.generate(set="camera.gsd_m=1"))
    refused(R, "not TOML", lambda: satseed.plan("seed = \n"))
    refused(D, "cannot open", lambda: satseed.open("/nowhere"))
    refused(D, "no sample", lambda: satseed.open(root).sample("a/b"))
    refused(IndexError, "", lambda: satseed.open(root)[10**6])
    for bad in (-1, 1.5, "1", None, True, 2**64, [], {}, b"1", float("nan"), object()):
        refused(R, "whole number", lambda: satseed.generate(CANYONS, set=SMALL, index=bad))
        refused(R, "whole number", lambda: satseed.generate(CANYONS, set=SMALL, pair=bad) if not isinstance(bad, str) else satseed._whole("pair", bad))
        if bad is not None:
            refused(R, "whole number", lambda: satseed.plan(CANYONS, seed=bad))
            refused(R, "whole number", lambda: satseed.Scene(CANYONS, threads=bad))
        if not isinstance(bad, (str, bytes)):
            refused(R, "a recipe is", lambda: satseed.plan(bad))
            refused(TypeError, "folder", lambda: satseed.open(bad))
            refused(TypeError, "id", lambda: satseed.open(root).sample(bad))
    for bad in (3, [3], {"a": object()}, {"camera.gsd_m": None}, {"camera.gsd_m": b"1"}, ["camera"], {"": 1}):
        refused((R, TypeError), "", lambda: satseed.plan(CANYONS, set=bad))


def scenes():
    scene = satseed.Scene(CANYONS, set=SMALL, seed=5)
    alone = scene.sample(0)
    check(alone.left.shape == (48, 64, 3) and alone.disparity.dtype == np.float32, "shapes")
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        check(all(same(alone, s) for s in pool.map(lambda _: scene.sample(0), range(8))), "threads get the same pair")
    check(same(alone, satseed.generate(CANYONS, set=SMALL, seed=5, threads=1)), "one thread makes the same")
    check(not same(alone, satseed.generate(CANYONS, set=SMALL, seed=6)), "another seed makes another pair")
    with multiprocessing.get_context("fork").Pool(1) as pool:
        forked = pool.apply(satseed.generate, (CANYONS,), {"set": SMALL, "seed": 5})
    check(same(alone, forked), "a forked child makes the same")
    refused(TypeError, "cannot be pickled", lambda: pickle.dumps(scene))
    alone.left[0, 0] = 7
    check(alone.left[0, 0, 0] == 7 and not same(alone, scene.sample(0)), "arrays are the caller's own")
    scene.close()
    refused(satseed.GenerateError, "closed", lambda: scene.sample(0))
    # Ctrl-C ends a long build at once, with the exception that Python has for it.
    script = ("import os, signal, threading, time, satseed\nsignal.signal(signal.SIGINT, signal.default_int_handler)\nthreading.Timer(1, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
              "t = time.time()\ntry: satseed.Scene('desert')\nexcept KeyboardInterrupt: print('stopped', time.time() - t < 10, flush=True); os._exit(0)")
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    check(told.stdout.strip() == "stopped True", f"Ctrl-C: {told.stdout}{told.stderr}")


def streams():
    try:
        import torch
    except ImportError:
        print("package.py: torch is not here, so its data sets are left out")
        return
    from torch.utils.data import DataLoader

    from satseed.torch import StereoDataset, StereoStream

    files = StereoDataset(root)
    one = files[0]
    check(one["left"].dtype == torch.uint8 and one["left"].shape[0] == 3 and one["disparity"].dtype == torch.float32, "tensors")
    loaded = [b["id"][0] for b in DataLoader(files, num_workers=1)]
    check(loaded == [r["id"] for r in files.dataset.records], "a worker reads all of a dataset")

    def stream(**more):
        return StereoStream(CANYONS, seed=3, samples=5, pairs_per_scene=2, set=SMALL, threads=1, **more)

    def content(items):
        return sorted((i["index"], i["id"], i["left"].numpy().tobytes(), i["disparity"].numpy().tobytes()) for i in items)

    alone = content(stream())
    check([i for i, *_ in alone] == list(range(5)) and len({c for _, _, c, _ in alone}) == 5, "five samples, no two alike")
    unbatched = {"batch_size": None}
    check(content(DataLoader(stream(), num_workers=1, **unbatched)) == alone, "one worker gives the same samples")
    check(content(DataLoader(stream(), num_workers=2, **unbatched)) == alone, "two workers give the same samples")
    ranks = [*DataLoader(stream(rank=0, world_size=2), num_workers=2, **unbatched), *stream(rank=1, world_size=2)]
    check(content(ranks) == alone, "two ranks give the same samples")
    check(content(stream(start=3)) == alone[3:], "a stream is resumed by its index")
    check(content(stream(epoch=1)) != alone, "another epoch has other samples")
    refused(satseed.RecipeError, "seed of its own", lambda: StereoStream("quickstart", seed=1))
    refused(satseed.RecipeError, "rank is 0 to 1", lambda: stream(rank=2, world_size=2))


if sys.argv[2:] != ["torch"]:
    against_files()
    refusals()
    scenes()
streams()
print(f"{checks} passed, 0 failed")
