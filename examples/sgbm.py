#!/usr/bin/env python3
"""Predicts a dataset's disparities with OpenCV's semi-global matcher: a baseline that needs no net and no training.

    pip install numpy opencv-python-headless
    python examples/sgbm.py DATASET PREDICTIONS
    satseed evaluate DATASET --predictions PREDICTIONS

It searches the range that each sample's camera.json tells, which a user of real images does not know.
"""

import argparse
import json
import pathlib

import cv2
import numpy as np

BLOCK = 5


def match(left, right, low_px, high_px):
    """Disparity u_L - u_R of the left image, px; NaN where the matcher gives none."""
    first = int(np.floor(low_px)) - 1
    count = 16 * int(np.ceil((high_px + 2 - first) / 16))
    matcher = cv2.StereoSGBM_create(
        minDisparity=first,
        numDisparities=count,
        blockSize=BLOCK,
        P1=8 * left.shape[2] * BLOCK**2,
        P2=32 * left.shape[2] * BLOCK**2,
        disp12MaxDiff=1,
        uniquenessRatio=5,
        mode=cv2.STEREO_SGBM_MODE_HH,
    )
    # The matcher looks for a left pixel's match only where every disparity of the range lies in the right image. So both
    # images get room at both sides, as much as the range can ask for.
    room = max(abs(first), abs(first + count)) + BLOCK
    pad = [cv2.copyMakeBorder(image, 0, 0, room, room, cv2.BORDER_REPLICATE) for image in (left, right)]
    sixteenths = matcher.compute(*pad)[:, room:-room]
    disparity = sixteenths.astype(np.float32) / 16
    disparity[sixteenths < first * 16] = np.nan
    return disparity


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", type=pathlib.Path)
    parser.add_argument("predictions", type=pathlib.Path)
    arguments = parser.parse_args()
    manifest = (arguments.dataset / "manifest.jsonl").read_text()
    for sample in (json.loads(line)["id"] for line in manifest.splitlines()):
        folder = arguments.dataset / sample
        left, right = (cv2.imread(str(folder / f"{side}.png")) for side in ("left", "right"))
        camera = json.loads((folder / "camera.json").read_text())
        out = arguments.predictions / f"{sample}.tif"
        out.parent.mkdir(parents=True, exist_ok=True)
        if not cv2.imwrite(str(out), match(left, right, *camera["disparity_range_px"])):
            raise SystemExit(f"cannot write {out}")


if __name__ == "__main__":
    main()
