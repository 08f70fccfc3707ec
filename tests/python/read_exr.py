"""Reads the OpenEXR images of a dataset of the preset `linear` with OpenEXR's own package: read_exr.py DATASET"""

import pathlib
import sys

import numpy as np
import OpenEXR

files = sorted(pathlib.Path(sys.argv[1]).rglob("left.exr")) + sorted(pathlib.Path(sys.argv[1]).rglob("right.exr"))
assert files, "no OpenEXR image in the dataset"
for file in files:
    channels = OpenEXR.File(str(file), separate_channels=True).channels()
    assert sorted(channels) == ["B", "G", "R"], f"{file}: {sorted(channels)}"
    for name, channel in channels.items():
        band = channel.pixels
        assert band.dtype == np.float32 and band.shape == (96, 128), f"{file} {name}: {band.dtype} {band.shape}"
        assert np.isfinite(band).all() and (band > 0).all(), f"{file} {name}: radiance is positive"
        # Sunlit ground of reflectance 0.02 to 0.5 under 2005, 1830 and 1535 W / (m^2 um) at the top of the air.
        assert 5.0 < float(band.mean()) < 250.0, f"{file} {name}: {band.mean()} W / (m^2 sr um)"
print(f"{len(files)} OpenEXR images read")
