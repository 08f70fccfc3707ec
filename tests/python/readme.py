#!/usr/bin/env python3
"""Runs the README's Python lines on every sample of a dataset, and checks what they show.

    python tests/python/readme.py README.md DATASET

Warped by its disparity, the right image must fit the left clearly better than unwarped, or warped with the wrong sign.
"""

import contextlib
import io
import pathlib
import re
import sys

import cv2
import numpy as np

readme, dataset = map(pathlib.Path, sys.argv[1:3])
code = re.search(r"```python\n(.*?)```", readme.read_text(), re.S).group(1)
samples = sorted(p.parent for p in dataset.glob("*/*/sample.json"))
if not samples:
    sys.exit(f"readme.py: {dataset} holds no sample")
for sample in samples:
    sys.argv = ["readme", str(sample)]
    names = {}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(compile(code, str(readme), "exec"), names)
    left, right, valid = names["left"], names["right"], names["valid"]

    def fit(image):
        return np.abs(left.astype(float) - image)[valid].mean()

    wrong = cv2.remap(right, names["u"] + names["disparity"], names["v"], cv2.INTER_LINEAR)
    good, unwarped, mirrored = fit(names["warped"]), fit(right), fit(wrong)
    print(f"{sample.parent.name}/{sample.name}: {good:.2f} warped, {unwarped:.2f} unwarped, {mirrored:.2f} wrong sign")
    if not good < 0.75 * min(unwarped, mirrored):
        sys.exit(f"readme.py: {sample} does not register")
    if not (names["depth_m"][valid] > 100).all():
        sys.exit(f"readme.py: {sample} has impossible depths")
print(f"{len(samples)} passed, 0 failed")
