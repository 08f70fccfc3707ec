#!/usr/bin/env python3
"""Holds the pairs of a dataset against what their regions should measure like, from its files alone.

    pip install numpy scipy pillow tifffile imagecodecs
    satseed generate satunreal --seeds LIST --set acquisition.baseline_m=200 --set acquisition.azimuth_deg=35 \\
        --set acquisition.pairs_per_pivot=1 --set 'labels.write=["class", "instance"]' --out DATASET
    python examples/acceptance.py DATASET [--twin NOISELESS]

One line a measure: what was found, what is asked, `in` or `out` (`-` where a variant has no range of its own); exit code 1
where any is out. Frames should be as large as published, 614 m, and natural regions seen from 200 m apart. NOISELESS is the
same dataset made with `--set sensor.snr=none --set sensor.read_noise=0 --set sensor.column_gain=0`: the difference of both is
the noise. `--labels` leaves the image's own statistics out, for datasets of larger pixels or fewer samples.
"""

import argparse
import json
import pathlib
import sys

import numpy as np
import tifffile
from PIL import Image
from scipy.ndimage import maximum_filter, uniform_filter

ROOF, FACADE, BRIDGE, TREE, WATER = 3, 4, 5, 7, 8
# Ground, carriageway, roof, bridge, low plants, water, rock, sand.
SURFACES = (1, 2, 3, 5, 6, 8, 12, 13)
VALID, OCCLUDED = 1, 2
# docs/venice.md
VENICE_WATER_M = -0.8


class Pair:
    """The files of one sample, read when asked for."""

    def __init__(self, root, folder, twin):
        self.folder, self.id = folder, str(folder.relative_to(root))
        self.scene = json.loads((self.folder.parent / "scene.json").read_text())
        self.camera = json.loads((self.folder / "camera.json").read_text())
        self.gsd_m = self.camera["gsd_m"]
        self.twin = twin / self.id if twin else None

    def label(self, name):
        path = next(self.folder.glob(f"{name}_left.*"))
        return np.array(Image.open(path)) if path.suffix == ".png" else tifffile.imread(path)

    def image(self, folder=None):
        return np.array(Image.open((folder or self.folder) / "left.png")).astype(np.float64)

    def heights(self, name):
        """A surface model within the frame's footprint, m."""
        z = tifffile.imread(self.folder.parent / f"{name}.tif")
        half = min(int(307.2 / self.gsd_m), z.shape[0] // 2)
        middle = z.shape[0] // 2
        return z[middle - half : middle + half, middle - half : middle + half]

    def above_ground(self):
        """What each pixel of the left view sees, and its height above the bare ground there: m, area it covers from above, m^2."""
        view, disparity_px = self.camera["left"], self.label("disparity").astype(np.float64)
        depth = view["fx_px"] * self.camera["baseline_m"] / (disparity_px + self.camera["doffs_px"])
        v, u = np.mgrid[: depth.shape[0], : depth.shape[1]]
        ray = np.stack([(u - view["cx_px"]) / view["fx_px"], (v - view["cy_px"]) / view["fy_px"]], -1)
        ray = ray @ np.array(view["world_from_camera"])[:2, :2].T
        at = ray * depth[..., None] + view["position_m"][:2]
        ground = tifffile.imread(self.folder.parent / "dtm.tif")
        side = ground.shape[0]
        cell = np.clip(np.floor(at / self.gsd_m + side / 2), 0, side - 1).astype(int)
        # Rows run from north to south.
        return view["position_m"][2] - depth - ground[side - 1 - cell[..., 1], cell[..., 0]], (depth / view["fx_px"]) ** 2

    def objects(self):
        """The kind of each pixel's object: the first part of its path."""
        table = np.array([o["path"].split("/")[0] for o in self.scene["objects"]])
        return table[self.label("instance")]


def slope_deg(pair, step_m):
    """The bare ground's slope over about a step."""
    every = max(round(step_m / pair.gsd_m), 1)
    dy, dx = np.gradient(pair.heights("dtm")[::every, ::every].astype(np.float64), every * pair.gsd_m)
    return np.degrees(np.arctan(np.hypot(dx, dy)))


def occluded(pair):
    validity = pair.label("validity")
    return (validity == OCCLUDED).sum() / np.isin(validity, (VALID, OCCLUDED)).sum()


def entropy_bits(pair):
    counts = np.bincount(pair.image()[..., 1].astype(int).ravel(), minlength=256)
    p = counts[counts > 0] / counts.sum()
    return -(p * np.log2(p)).sum()


def deviation(x, side=9):
    mean = uniform_filter(x, side)
    return np.sqrt(np.maximum(uniform_filter(x * x, side) - mean * mean, 0))


def over_noise(pair):
    """Share of 9 x 9 windows of the green band whose deviation is 1.5 times that of the noise there."""
    noisy, clean = pair.image()[..., 1], pair.image(pair.twin)[..., 1]
    noise = np.sqrt(uniform_filter((noisy - clean) ** 2, 9))
    return (deviation(noisy) >= 1.5 * noise)[4:-4:4, 4:-4:4].mean()


def repeats(pair):
    """The highest local peak of the green band's autocorrelation from 3 to 60 m; 0 where it has none."""
    x = pair.image()[..., 1]
    x = x - uniform_filter(x, 101)
    a = np.fft.irfft2(np.abs(np.fft.rfft2(x, [2 * n for n in x.shape])) ** 2)
    a /= a[0, 0]
    reach = int(60 / pair.gsd_m)
    a = np.roll(a, (reach, reach), (0, 1))[: 2 * reach + 1, : 2 * reach + 1]
    v, u = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    far = (np.hypot(v, u) > 3 / pair.gsd_m) & (np.hypot(v, u) < reach - 8)
    peaks = a[far & (a == maximum_filter(a, 15))]
    return max(peaks.max(initial=0), 0)


def statistics(pair):
    """Image statistics of the luma, after the definitions of docs/images.md."""
    x = pair.image() @ [0.299, 0.587, 0.114]
    low, high = np.percentile(x, [1, 99])
    x = (x - low) / (high - low)
    window = np.outer(np.hanning(x.shape[0]), np.hanning(x.shape[1]))
    power = np.abs(np.fft.fft2((x - x.mean()) * window)) ** 2
    f = np.hypot(np.fft.fftfreq(x.shape[0])[:, None], np.fft.fftfreq(x.shape[1])[None])
    edges = np.geomspace(0.02, 0.5, 41)
    which = np.digitize(f.ravel(), edges)
    sums, counts = (np.bincount(which, w, len(edges) + 1) for w in (power.ravel(), np.ones(f.size)))
    radial, centre = (sums / np.maximum(counts, 1))[1:-1], np.sqrt(edges[1:] * edges[:-1])

    def fall(a, b):
        at = (centre >= a) & (centre <= b)
        return -np.polyfit(np.log(centre[at]), np.log(radial[at]), 1)[0]

    g = np.hypot(x[1:-1, 2:] - x[1:-1, :-2], x[2:, 1:-1] - x[:-2, 1:-1])
    s9 = deviation(x)[4:-4, 4:-4]
    p = np.histogram(np.clip(x, 0, 1), 256)[0] / x.size
    found = {
        "power slope 0.02-0.2": fall(0.02, 0.2),
        "power slope 0.2-0.45": fall(0.2, 0.45),
        "kurtosis of gradients": ((g - g.mean()) ** 4).mean() / g.var() ** 2,
        "local deviation, median": np.median(s9),
        "windows without texture": (s9 < 0.02).mean(),
        "entropy of luma, bits": -(p[p > 0] * np.log2(p[p > 0])).sum(),
    }
    natural = [(2.0, 2.5), (5.3, 6.7), (5, 50), (0.05, 0.12), (0, 0.13), (7.4, 7.9)]
    city = [(2.4, 3.1), (3.7, 6.1), (5, 25), (0.04, 0.08), (0.015, 0.29), (7.2, 7.7)]
    asked = city if pair.scene["region"] in CITIES else natural
    return {name: (value, *r) for (name, value), r in zip(found.items(), asked, strict=True)}


def canyon(pair):
    z = pair.heights("dtm")
    return {
        "relief, m": (z.max() - z.min(), 120, 220),
        "steeper than 60 deg": ((slope_deg(pair, 0.9) > 60).mean(), 0.05, 0.15),
        "several layers": (pair.scene["multi_layer_fraction"], 0.005, 0.03),
        "occluded": (occluded(pair), 0.02, 0.08),
    }


def desert(pair):
    slope = slope_deg(pair, 0.6)
    bins = np.bincount(slope.astype(int).ravel(), minlength=91)
    found = {
        "slip faces' slope, deg": (20.5 + np.argmax(bins[20:]), 32, 34),
        "steeper than 35 deg": ((slope > 35).mean(), 0, 0.002),
        "entropy, bits": (entropy_bits(pair), 4.8, 6.3),
        "occluded": (occluded(pair), 0, 0.01),
    }
    if pair.twin:
        found["deviation over 1.5 noise"] = (over_noise(pair), 0.6, 1)
    return found


def forest(pair):
    z = pair.heights("ndsm")
    tall = np.sort(z[z > 2])
    return {
        "cover": (tall.size / z.size, 0.75, 0.95),
        "median height, m": (tall[tall.size // 2], 16, 26),
        "95 % height, m": (tall[int(0.95 * tall.size)], 24, 34),
        "gaps to the ground": ((z < 0.5).mean(), 0.05, 0.20),
        "several layers": (pair.scene["multi_layer_fraction"], 0.6, 1),
        "occluded": (occluded(pair), 0.10, 0.35),
    }


def field(pair):
    z = pair.heights("ndsm")
    hedges = (pair.objects() == "hedge") | (pair.label("class") == TREE)
    least = 0.03 if pair.scene["variant"] == "european" else 0.0
    return {
        "hedges and trees": (hedges.mean(), least, 0.10),
        "stands 0.2 to 2.8 m high": (((z > 0.2) & (z < 2.8)).mean(), 0.1, 1),
        "occluded": (occluded(pair), 0, 0.03),
    }


def coast(pair):
    classes = pair.label("class")
    image = pair.image()
    sea = classes == WATER
    found = {"land": (1 - sea.mean(), 0.35, 0.65)}
    slope = np.tan(np.radians(slope_deg(pair, 1.2)))
    every = max(round(1.2 / pair.gsd_m), 1)
    z = pair.heights("dtm")[::every, ::every]
    shore = slope[(z > 0.4) & (z < 1.1) & (slope < 0.3)]
    if pair.scene["variant"] == "beach":
        found["foreshore's slope, median"] = (np.median(shore), 0.05, 0.12)
    # Foam is bright in all bands, which no water is.
    bright = np.median(image[sea].min(axis=1))
    white = sea & (image.min(axis=2) > bright + 0.5 * (255 - bright))
    found["foam, share of the sea"] = (white.sum() / sea.sum(), 0.01, 0.06)
    return found


# Of a frame from 1 km, at these baselines: what boxes hide, by a simulation on a grid of 0.6 m.
BASELINES_M = [50, 100, 150, 200]
# How far above or below that, and other rough figures, a city may lie.
TO_BOXES = (0.7, 2.0)


def city(pair, boxes_hide, judged, at_most=TO_BOXES[1]):
    """What all cities are asked. Only the `judged` variant has the ranges of its city."""
    classes, validity = pair.label("class"), pair.label("validity")
    both = np.isin(validity, (VALID, OCCLUDED))
    hidden = validity == OCCLUDED
    # What boxes on a plain have: neither facades, which hide each other, nor crowns, vehicles, boats, poles.
    plain = np.isin(classes, SURFACES)
    boxes = np.interp(pair.camera["baseline_m"], BASELINES_M, boxes_hide) / 100
    low, high = (boxes * k for k in (TO_BOXES[0], at_most)) if judged else (None, None)
    return {
        "occluded ground, water and roofs": ((hidden & plain).sum() / both.sum(), low, high),
        "occluded": (hidden.sum() / both.sum(), None, None),
        "facade": ((classes == FACADE).mean(), None, None),
        "several layers": (pair.scene["multi_layer_fraction"], None, None),
    }


def roofs(pair):
    """Built share of what no wall hides, and the height of each building seen, m: what a tenth of its roof exceeds."""
    instance, classes = pair.label("instance"), pair.label("class")
    height, area = pair.above_ground()
    roof = classes == ROOF
    ids, z = instance[roof], height[roof]
    order = np.lexsort((z, ids))
    ids, z = ids[order], z[order]
    first = np.flatnonzero(np.r_[True, ids[1:] != ids[:-1]])
    count = np.diff(np.r_[first, ids.size])
    # Parts of a few pixels at the frame's border tell no height.
    heights = z[first + (count * 9) // 10][count * pair.gsd_m**2 > 30]
    # Walls lean over roofs and streets alike.
    return area[roof].sum() / area[classes != FACADE].sum(), heights[heights > 2]


def toronto(pair):
    core = pair.scene["variant"] == "core"
    built, heights = roofs(pair)
    z = pair.heights("ndsm")
    towers = heights[heights > 60]
    found = city(pair, [2.6, 4.8, 6.8, 9.0], core)
    return found | {
        "built": (built, 0.45 if core else None, 0.60),
        "stands over 60 m": ((z > 60).mean(), 0.05 if core else None, 0.12),
        "towers over 60 m, median, m": (np.median(towers) if towers.size else 0, 110 if core else None, 140),
        "facade": (found["facade"][0], 0.10 if core else None, 0.20),
        "heights, median, m": (np.median(heights), None, None),
    }


def california(pair):
    suburb = pair.scene["variant"] == "suburb"
    built, heights = roofs(pair)
    classes = pair.label("class")
    # Trees hide one to two and a half times as much as boxes.
    found = city(pair, [0.4, 0.8, 1.1, 1.5], suburb, 2.5)
    return found | {
        "built": (built, 0.28 if suburb else None, 0.38),
        "heights, 10 %, m": (np.percentile(heights, 10), None, None),
        "heights, median, m": (np.median(heights), 4.5 if suburb else None, 8.5),
        "heights, 90 %, m": (np.percentile(heights, 90), None, None),
        "trees": ((classes == TREE).mean(), 0.12 if suburb else None, 0.25),
        "water": ((classes == WATER).mean(), None, None),
        # How much lies below an interchange's decks is tested beside the generator: a scene's layers count trees, and more than a frame.
        "bridges": ((classes == BRIDGE).mean(), None, None),
    }


def venice(pair):
    built, heights = roofs(pair)
    # In the bare ground's model, which no boat, bridge or eaves hide.
    ground = pair.heights("dtm")
    water = np.isclose(ground, VENICE_WATER_M, atol=0.005).mean()
    seen_water = (pair.label("class") == WATER).mean()
    paths = [o["path"] for o in pair.scene["objects"]]
    seen = {paths[i] for i in np.unique(pair.label("instance"))}
    bridges = sum(path.startswith("bridge/") for path in seen)
    return city(pair, [0.8, 1.3, 1.9, 2.4], True) | {
        "built, of land": (built / (1 - seen_water), 0.65, 0.76),
        "water": (water, 0.12, 0.18),
        "water seen": (seen_water, None, None),
        "eaves and roofs, 10 %, m": (np.percentile(heights, 10), 7, 22),
        "eaves and roofs, 90 %, m": (np.percentile(heights, 90), 7, 22),
        "bridges": (bridges, *(20 * k for k in TO_BOXES)),
    }


CITIES = {f.__name__: f for f in (toronto, california, venice)}
REGIONS = {f.__name__: f for f in (canyon, desert, forest, field, coast)} | CITIES


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", type=pathlib.Path)
    parser.add_argument("--twin", type=pathlib.Path)
    parser.add_argument("--labels", action="store_true")
    arguments = parser.parse_args()
    outside = 0
    # The records rather than the manifest: a dataset that is still being made can be looked at.
    for path in sorted(arguments.dataset.glob("*/*/sample.json")):
        pair = Pair(arguments.dataset, path.parent, arguments.twin)
        region = pair.scene["region"]
        found = REGIONS[region](pair)
        if not arguments.labels:
            if region != "field" and region not in CITIES:
                found["autocorrelation's peak beyond 3 m"] = (repeats(pair), 0, 0.15)
            found |= statistics(pair)
        for name, (value, low, high) in found.items():
            # No range: the lower end is missing.
            verdict = "-" if low is None else "in" if low <= value <= high else "out"
            outside += verdict == "out"
            asked = "" if low is None else f"{low:g} to {high:g}"
            print(f"{pair.id:34} {name:36} {value:9.4g}   {asked:16} {verdict}", flush=True)
    sys.exit(1 if outside else 0)


if __name__ == "__main__":
    main()
