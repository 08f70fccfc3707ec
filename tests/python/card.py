#!/usr/bin/env python3
"""Holds a dataset's card and its Croissant metadata against the files, counted here again.

    pip install numpy pillow tifffile imagecodecs mlcroissant blake3
    python tests/python/card.py DATASET
"""

import json
import pathlib
import re
import subprocess
import sys
import warnings

import blake3
import mlcroissant
import numpy as np
import tifffile
from PIL import Image

root = pathlib.Path(sys.argv[1])
checks = 0


def check(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"card.py: {what}")


def contrast(image):
    grey = image.astype(np.float64).mean(axis=2)
    rows, columns = grey.shape
    out = np.empty(grey.shape)
    for v in range(rows):
        for u in range(columns):
            out[v, u] = grey[max(v - 4, 0) : v + 5, max(u - 4, 0) : u + 5].std()
    return out


def histogram(line):
    """Borders and shares of a card's line."""
    return [(float(a), float(b), float(s) / 100) for a, b, s in re.findall(r"(-?[\d.]+) to (-?[\d.]+): ([\d.]+) %", line)]


card = (root / "README.md").read_text()
manifest = (root / "manifest.jsonl").read_text()
records = [json.loads(line) for line in manifest.splitlines()]
for name in ("manifest.jsonl", "recipe.toml", "croissant.json"):
    check(blake3.blake3((root / name).read_bytes()).hexdigest() in card, f"the card has the BLAKE3 of {name}")
check(f"{len(records)} pairs of {len({r['id'].split('/')[0] for r in records})} scenes" in card, "pairs and scenes")
for record in records:
    name = f"{record['region']}/{record['variant']}"
    check(re.search(rf"^- {name}: (.*, )?{record['scene_seed']}(,|$)", card, re.M), f"the seed of {record['id']}")

for name in sorted({f"{r['region']}/{r['variant']}" for r in records}):
    own = [r for r in records if f"{r['region']}/{r['variant']}" == name]
    row = re.search(rf"^\| {name} \| (.*) \|$", card, re.M)[1].split(" | ")
    check(int(row[1]) == len(own), f"pairs of {name}")
    for cell, key in zip(row[3:6], ("valid", "occluded", "out_of_frame")):
        mean = np.mean([r[f"{key}_fraction"] for r in own])
        seen = np.concatenate([np.asarray(Image.open(root / r["id"] / "validity_left.png")).ravel() for r in own])
        counted = (seen == {"valid": 1, "occluded": 2, "out_of_frame": 3}[key]).mean()
        check(abs(float(cell[:-2]) / 100 - mean) <= 0.51e-4 and abs(mean - counted) < 1e-9, f"{key} of {name}: {cell}, {counted}")
    disparity = np.concatenate([tifffile.imread(root / r["id"] / "disparity_left.tif").ravel() for r in own])
    low, high = map(float, row[6].split(" to "))
    check(abs(low - np.nanmin(disparity)) < 0.006 and abs(high - np.nanmax(disparity)) < 0.006, f"disparities of {name}: {row[6]}")
    texture = np.concatenate([contrast(np.asarray(Image.open(root / r["id"] / "left.png"))).ravel() for r in own])
    lines = re.findall(rf"^- {name}(?: \(px\))?: (.* %)$", card, re.M)
    check(len(lines) == 3, f"three histograms of {name}")
    for line, values, slack in ((lines[0], disparity, 0.006), (lines[1], [r["occluded_fraction"] for r in own], 1e-4), (lines[2], texture, 1 / 16)):
        values = np.asarray(values)
        values, bins = values[np.isfinite(values)], histogram(line)
        check(abs(sum(s for _, _, s in bins) - 1) < 2e-3, f"a histogram of {name} is whole")
        for a, b, share in bins:
            # Borders are rounded for people: what lies on them may fall to either side.
            inner, outer = ((values >= a + slack) & (values < b - slack)).mean(), ((values >= a - slack) & (values <= b + slack)).mean()
            check(inner - 1e-4 <= share <= outer + 1e-4, f"{name}, {a} to {b}: {share}, not {inner} to {outer}")

# Croissant: valid, and its records are the manifest's.
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    dataset = mlcroissant.Dataset(jsonld=root / "croissant.json")
    check(not dataset.metadata.ctx.issues.errors, f"Croissant: {dataset.metadata.ctx.issues.report()}")
    rows = list(dataset.records("pairs"))
check(len(rows) == len(records), "as many records as pairs")
for row, record in zip(rows, records):
    for key, value in row.items():
        value = value.decode() if isinstance(value, bytes) else value
        expected = record[key.removeprefix("pairs/")]
        same = abs(value - expected) < 1e-12 * max(1, abs(expected)) if isinstance(value, float) else value == expected
        check(same, f"{record['id']}: {key} is {value}, not {expected}")

# A changed or foreign page is named, a missing one is fine.
def verify():
    ended = subprocess.run(["target/debug/satseed", "verify", str(root), "--json"], capture_output=True, text=True)
    return {(f["path"], f["fault"]) for f in json.loads(ended.stdout)["findings"]}


check(verify() == set(), "the dataset is as recorded")
for name, fault in (("README.md", "changed"), ("croissant.json", "changed"), ("gallery.html", "changed")):
    whole = (root / name).read_bytes()
    (root / name).write_bytes(whole[:1000] + b"?" + whole[1001:])
    # Without its card nobody vouches for the metadata.
    more = {("croissant.json", "changed")} if name == "README.md" else set()
    check(verify() == {(name, fault)} | more, f"a changed {name} is found: {verify()}")
    (root / name).unlink()
    check(verify() == more, f"a missing {name} is none of verify's affair: {verify()}")
    (root / name).write_bytes(whole)
print(f"{checks} passed, 0 failed")
