"""Reads the OpenEXR images of a dataset of the preset `linear` with OpenCV: read_exr.py DATASET"""

import pathlib
import sys

import cv2
import numpy as np

files = sorted(pathlib.Path(sys.argv[1]).rglob("left.exr")) + sorted(pathlib.Path(sys.argv[1]).rglob("right.exr"))
assert files, "no OpenEXR image in the dataset"
for file in files:
    image = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    assert image is not None, f"{file}: OpenCV cannot read it"
    assert image.dtype == np.float32 and image.shape == (96, 128, 3), f"{file}: {image.dtype} {image.shape}"
    assert np.isfinite(image).all() and (image > 0).all(), f"{file}: radiance is positive"
    blue, green, red = (float(image[..., k].mean()) for k in range(3))
    # Sunlit ground of reflectance 0.02 to 0.5 under 2005, 1830 and 1535 W / (m^2 um) at the top of the air.
    assert all(5.0 < band < 250.0 for band in (blue, green, red)), f"{file}: {blue} {green} {red}"
    print(f"{file.parent.name}/{file.name}: blue {blue:.1f}, green {green:.1f}, red {red:.1f} W / (m^2 sr um)")
