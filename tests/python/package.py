#!/usr/bin/env python3
"""Tests the Python package: the same arrays as the files, refusals, threads, pickling, fork; with torch, the data sets.

    python tests/python/package.py DATASET [torch | long]     (satseed importable; NumPy, Pillow, tifffile, Rerun; torch where
                                                               they are there)

`torch` runs the tests of the torch data sets alone. `long` runs what takes long alone: crops of every region against the
whole scene, memory over 1,000 crops.
"""

import concurrent.futures
import ctypes
import doctest
import gc
import json
import multiprocessing
import pathlib
import pickle
import re
import subprocess
import sys
import tempfile

import numpy as np

import satseed

root = pathlib.Path(sys.argv[1])
checks = 0
# Toronto, whose small scenes are built in no time.
SMALL = {"camera.size_px": [64, 48], "scene.toronto.radius_m": 60, "acquisition.pairs_per_pivot": 3,
         "sensor.samples_per_pixel": 1, "light.ambient": "per-sample"}
TOWNS = "extends = 'quickstart'\n[[scene]]\ntoronto = {}\npivots = 2\n"


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
    refused(R, "no pair 'b99'", lambda: satseed.generate(TOWNS, set=SMALL, pair="b99"))
    refused(R, "none of index 77", lambda: satseed.generate(TOWNS, set=SMALL, pair=77))
    refused(R, "key=value", lambda: satseed.generate(set="camera.gsd_m=1"))
    refused(R, "not TOML", lambda: satseed.plan("seed = \n"))
    refused(D, "cannot open", lambda: satseed.open("/nowhere"))
    refused(D, "no sample", lambda: satseed.open(root).sample("a/b"))
    refused(IndexError, "", lambda: satseed.open(root)[10**6])


def bad_arguments():
    """Every argument with every value that it cannot have: an exception with a sentence, never a crash or a scene."""
    numbers = (-1, 1.5, "1", True, 2**64, -(2**70), [], {}, b"1", float("nan"), np.float32(1), object())
    texts = (3, 1.5, True, [], {}, b"text", None, object())
    mappings = (3, "camera.gsd_m=1", [3], ["camera"], {"a": object()}, {"camera.gsd_m": None}, {"camera.gsd_m": b"1"}, {"": 1},
                {3: 1}, {"camera.gsd_m": float("nan")}, {"camera.gsd_m": "far"}, {"camera.size_px": [64]}, {"camera": 1}, {1, 2})
    opened = satseed.open(root)
    pair = lambda v: satseed.generate(TOWNS, set=SMALL, pair=v)
    table = {
        "generate(index)": (lambda v: satseed.generate(TOWNS, index=v), (*numbers, None, 99)),
        "generate(pair)": (pair, [v for v in numbers if not isinstance(v, str)]),
        "generate(seed)": (lambda v: satseed.generate(TOWNS, seed=v), numbers),
        "Scene(threads)": (lambda v: satseed.Scene(TOWNS, threads=v), (*numbers, 0)),
        "Scene(crop)": (lambda v: satseed.Scene(TOWNS, crop=v), (*texts[:2], "yes", None)),
        "plan(recipe)": (satseed.plan, (*texts, "", "no such preset", "seed = \n", "[camera]\ngsd_m = 'far'\n", "/", "a\0b")),
        "plan(set)": (lambda v: satseed.plan(TOWNS, set=v), mappings),
        "plan(seed)": (lambda v: satseed.plan(TOWNS, seed=v), numbers),
        "crops(region)": (lambda v: satseed.plan(satseed.crops(v)), (*texts, "", "atlantis")),
        "crops(size_px)": (lambda v: satseed.plan(satseed.crops(size_px=v)), ((0, 4), (1.5, 2), ("4", 4), (10**9, 10**9))),
        "crops(baseline_m)": (lambda v: satseed.plan(satseed.crops(baseline_m=v)), ((0, 1), (5, 1), (1, 1e9))),
        "open(folder)": (satseed.open, (*[v for v in texts if not isinstance(v, bytes)], "/nowhere", __file__, "a\0b")),
        "Dataset.sample(id)": (opened.sample, (*texts, "", "a/b", "../..", "\0")),
        "Dataset[i]": (opened.__getitem__, ("1", 1.5, None, True, 10**6, -(10**6), b"1", object())),
        "view(sample)": (satseed.view, (*texts, opened)),
    }
    told = 0
    for what, (call, values) in table.items():
        for value in values:
            try:
                call(value)
            except Exception as e:
                words = re.findall(r"[A-Za-z]+", str(e))
                check(len(words) >= 4 and type(e).__name__ != "PanicException" and not isinstance(e, (SystemError, AttributeError)),
                      f"{what} of {value!r} is told by {e!r}, which is no sentence")
                told += 1
            else:
                sys.exit(f"package.py: {what} takes {value!r}")
    check(told >= 100, f"{told} bad arguments are too few")
    no_name = (lambda: satseed.generate("quickstart", 1), lambda: satseed.Scene("quickstart", 1), lambda: satseed.plan("quickstart", {}))
    for call in no_name:
        refused(TypeError, "positional", call)


def written():
    """Docstrings hold, importing is quick, nothing is copied, types are there."""
    found = doctest.testmod(satseed)
    check(found.attempted >= 6 and found.failed == 0, f"{found.failed} of {found.attempted} lines of docstrings do not hold")
    once = [sys.executable, "-X", "importtime", "-c", "import satseed"]
    times_us = []
    for _ in range(7):
        lines = subprocess.run(once, capture_output=True, text=True, check=True).stderr.splitlines()
        check(not any("numpy" in line for line in lines), "importing satseed imports NumPy")
        times_us.append(int(next(line for line in lines if line.split("|")[-1].strip() == "satseed").split("|")[1]))
    # The least of several: a busy machine must not fail it.
    check(min(times_us) < 5_000, f"importing takes {min(times_us)} us")
    print(f"package.py: importing satseed takes {sorted(times_us)[3] / 1000:.1f} ms (median of 7, {min(times_us) / 1000:.1f} at least)")
    for address, array in satseed._native._hand_over(2048, 2048):
        check(array.shape[:2] == (2048, 2048) and array.ctypes.data == address, "an array was copied on its way")
        array[7, 5] = 3
        row = (7 * 2048 + 5) * array[0, 0].nbytes
        kind = ctypes.c_uint8 if array.ndim == 3 else ctypes.c_float
        check(kind.from_address(address + row).value == 3 and not array.flags.owndata, "an array is no view of the library's memory")
    check((pathlib.Path(satseed.__file__).parent / "py.typed").exists(), "types are announced")


def viewed():
    sample = satseed.generate(TOWNS, set=SMALL, seed=5)
    from satseed._view import points

    where, known = points(sample)
    left = sample.camera["left"]
    # Through the right camera's own matrix: the points lie at u - d.
    p = np.c_[where, np.ones(len(where))] @ np.asarray(sample.camera["right"]["projection"]).T
    v, u = np.nonzero(known)
    gone = np.abs(np.c_[p[:, 0] / p[:, 2] - (u - sample.disparity[known]), p[:, 1] / p[:, 2] - v]).max()
    check(gone < 1e-3 and len(where) == left["width_px"] * left["height_px"], f"points are {gone} px beside the right camera's")
    try:
        import rerun
    except ImportError:
        refused(ImportError, "pip install rerun-sdk", lambda: satseed.view(sample))
        print("package.py: Rerun is not here, so nothing is logged into it")
        return
    refused(FileNotFoundError, "folder does not exist", lambda: satseed.view(sample, save="/nowhere/pair.rrd"))
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "pair.rrd"
        recording = satseed.view(sample, save=file)
        recording.disconnect()
        data = file.read_bytes()
        check(data[:4] in (b"RRF2", b"RRIO") and len(data) > sample.left.nbytes, "a recording is written")
        names = (b"/world/left/image", b"/world/right/image", b"/world/points", b"/disparity_px", b"/validity")
        check(all(name in data for name in names), "the recording holds images, cameras, points and maps")
    del rerun


def of_whole(region, crop, whole):
    """A crop's labels are those of the same pairs of the whole scene, bit for bit."""
    check(crop.name == whole.name and crop.pairs == whole.pairs and crop.radius_m < whole.radius_m, f"{region}: names and radii")
    for pair in crop.pairs:
        a, b = crop.sample(pair), whole.sample(pair)
        maps = [name for name in a.arrays if name not in ("left", "right") and not name.startswith("shadow")]
        check({"disparity_left", "validity_left", "class_left", "elevation_left", "normal_left"} <= set(maps), f"{region}: labels")
        for name in maps:
            check(a.arrays[name].tobytes() == b.arrays[name].tobytes(), f"{pair}: {name} of a crop is not that of the whole scene")
        check(a.camera == b.camera, f"{pair}: cameras of a crop are not those of the whole scene")
        gone = np.abs(a.left.astype(int) - b.left)
        print(f"package.py: {pair}: labels are the same; the left image differs by {gone.mean():.2f} of 255, {(gone > 2).mean():.2%} of its values by more than 2")


def crop_of(region, whole_m):
    labels = {"labels.write": ["disparity_right", "class", "elevation", "normal"], "acquisition.pairs_per_pivot": 2}
    small = {"camera.size_px": [96, 64], "acquisition.baseline_m": [60.0], "sensor.samples_per_pixel": 1, f"scene.{region}.radius_m": whole_m, **labels}
    recipe = satseed.crops(region)
    with satseed.Scene(recipe, set=small, seed=3, crop=True) as crop, satseed.Scene(recipe, set=small, seed=3) as whole:
        of_whole(region, crop, whole)


def crops():
    crop_of("toronto", 200.0)
    R = satseed.RecipeError
    refused(R, "whole scene", lambda: satseed.Scene(satseed.crops("toronto"), set={"camera.datum": "lowest"}, crop=True))
    refused(R, "at most 900 m", lambda: satseed.Scene(satseed.crops("toronto", size_px=(8192, 8192)), crop=True))


def resident_mib():
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 2**20


def in_a_fresh_process(mode, *numbers):
    """What the tests before have left in an allocator's pools would hide what is asked."""
    command = [sys.executable, __file__, str(root), mode, *map(str, numbers)]
    check(subprocess.run(command).returncode == 0, f"{mode} {numbers}")


def flat_memory(crops, scenes):
    """Crops, scene after scene: what is held after a few is held after all."""
    try:
        resident_mib()
    except OSError:
        print("package.py: this system tells no memory, so none is measured")
        return
    held = []
    for seed in range(scenes):
        with satseed.Scene(TOWNS, set={**SMALL, "acquisition.pairs_per_pivot": 16}, seed=seed, threads=1, crop=True) as scene:
            for pair in range(crops // scenes):
                scene.sample(pair % len(scene.pairs))
        gc.collect()
        held.append(resident_mib())
    # Scenes differ in size: the largest of the last half against the largest of the first, of which the first warms up.
    before, after = max(held[: len(held) // 2]), max(held[len(held) // 2 :])
    print(f"package.py: {crops} crops of {scenes} scenes: {before:.0f} MiB held in the first half, {after:.0f} in the second")
    check(after < before + 16, f"memory grows: {before:.0f} MiB, then {after:.0f}")


def scenes():
    scene = satseed.Scene(TOWNS, set=SMALL, seed=5)
    alone = scene.sample(0)
    check(alone.left.shape == (48, 64, 3) and alone.disparity.dtype == np.float32, "shapes")
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        check(all(same(alone, s) for s in pool.map(lambda _: scene.sample(0), range(8))), "threads get the same pair")
    check(same(alone, satseed.generate(TOWNS, set=SMALL, seed=5, threads=1)), "one thread makes the same")
    check(not same(alone, satseed.generate(TOWNS, set=SMALL, seed=6)), "another seed makes another pair")
    with multiprocessing.get_context("fork").Pool(1) as pool:
        forked = pool.apply(satseed.generate, (TOWNS,), {"set": SMALL, "seed": 5})
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

    import satseed.torch
    from satseed.torch import StereoDataset, StereoStream

    found = doctest.testmod(satseed.torch)
    check(found.attempted >= 4 and found.failed == 0, f"{found.failed} of {found.attempted} lines of docstrings do not hold")
    files = StereoDataset(root)
    one = files[0]
    check(one["left"].dtype == torch.uint8 and one["left"].shape[0] == 3 and one["disparity"].dtype == torch.float32, "tensors")
    loaded = [b["id"][0] for b in DataLoader(files, num_workers=1)]
    check(loaded == [r["id"] for r in files.dataset.records], "a worker reads all of a dataset")

    def stream(set=SMALL, **more):
        return StereoStream(TOWNS, seed=3, samples=5, pairs_per_scene=2, set=set, threads=1, **more)

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
    wider = content(stream(set=lambda i: {**SMALL, "camera.gsd_m": 0.3 if i < 2 else 0.6}))
    check(wider[:2] == alone[:2] and wider[2:] != alone[2:], "a curriculum changes what comes later")
    check({i["id"] for i in stream()} <= {p["id"] for b in range(3) for s in satseed.plan(TOWNS, set=SMALL, seed=stream().block_seed(b)) for p in s["pairs"]},
          "a stream's pairs are those of the recipe's whole scenes")
    refused(satseed.RecipeError, "seed of its own", lambda: StereoStream("quickstart", seed=1))
    refused(satseed.RecipeError, "set is a mapping", lambda: stream(set=["camera.gsd_m=1"]))
    refused(satseed.RecipeError, "rank is 0 to 1", lambda: stream(rank=2, world_size=2))


def long():
    for region in satseed.REGIONS:
        crop_of(region, 300.0)
    in_a_fresh_process("memory", 1000, 50)


if sys.argv[2:3] == ["memory"]:
    flat_memory(*map(int, sys.argv[3:]))
elif sys.argv[2:] == ["long"]:
    long()
else:
    if sys.argv[2:] != ["torch"]:
        against_files()
        refusals()
        bad_arguments()
        scenes()
        written()
        crops()
        viewed()
        in_a_fresh_process("memory", 60, 12)
    streams()
print(f"{checks} passed, 0 failed")
