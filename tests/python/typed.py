"""A program over all of the package, for type checkers alone: what is right passes, and what is wrong is told.

mypy --strict --warn-unused-ignores, and Pyright as python/pyproject.toml has it: each `type: ignore` stands where an error has to be.
"""

import pathlib

import numpy as np
from numpy.typing import NDArray

import satseed
from satseed import Dataset, DatasetError, GenerateError, RecipeError, Sample, Scene


def right() -> float:
    sample: Sample = satseed.generate(satseed.crops("desert"), index=0, pair="b00-a00", set={"camera.gsd_m": 0.5}, seed=1, threads=1)
    disparity: NDArray[np.float32] = sample.disparity
    valid: NDArray[np.bool_] = sample.valid
    with Scene("quickstart", crop=True) as scene:
        names: list[str] = scene.pairs
        again: Sample = scene.sample(names[0])
    dataset: Dataset = satseed.open(pathlib.Path("dataset"), arrays=["left"]).filter(split="test")
    first: Sample = dataset[0]
    few: Dataset = dataset[1:3]
    regions: list[str] = [found.region for found in few]
    errors: tuple[type[ValueError], type[OSError], type[RuntimeError]] = (RecipeError, DatasetError, GenerateError)
    satseed.view(again, save="pair.rrd")
    return float(disparity[valid].mean()) + first.baseline_m + len(regions) + len(errors)


def wrong() -> None:
    satseed.generate("quickstart", 1)  # type: ignore[call-arg]
    satseed.generate(3)  # type: ignore[arg-type]
    satseed.generate("quickstart", seed="1")  # type: ignore[arg-type]
    satseed.generate("quickstart", sed=1)  # type: ignore[call-arg]
    satseed.open("dataset")["b00"]  # type: ignore[call-overload]
    Scene("quickstart").sample(0.5)  # type: ignore[arg-type]
    satseed.generate().image  # type: ignore[attr-defined]
