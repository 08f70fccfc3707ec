"""PyTorch data sets: over a dataset's files, and an endless stream of fresh pairs. Needs torch, which `satseed` does not."""

from __future__ import annotations

import hashlib
import itertools
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import torch
from torch.utils.data import Dataset as TorchDataset
from torch.utils.data import IterableDataset, get_worker_info

import satseed

_MOST_SEED = 900_000_000_000_000


def tensors(sample: satseed.Sample) -> dict[str, Any]:
    """A pair as tensors: ``left``, ``right`` uint8 (3, rows, columns), ``disparity`` float32 px and ``valid`` bool (rows, columns)."""
    return {
        "left": _image(sample.left),
        "right": _image(sample.right),
        "disparity": torch.from_numpy(sample.disparity),
        "valid": torch.from_numpy(sample.valid),
        "id": sample.id,
    }


def _image(array: Any) -> Any:
    image = torch.from_numpy(array)
    return image.movedim(-1, 0).contiguous() if array.ndim == 3 else image[None]


class StereoDataset(TorchDataset):
    """A finished dataset, map-style. Opened anew in every worker."""

    def __init__(
        self,
        folder: str | os.PathLike[str],
        *,
        split: str | None = None,
        region: str | None = None,
        transform: Callable[[dict[str, Any]], Any] | None = None,
    ) -> None:
        names = ["left", "right", "disparity_left", "validity_left"]
        self.dataset = satseed.open(folder, arrays=names).filter(split=split, region=region)
        self.transform = transform

    def __len__(self) -> int:
        return len(self.dataset)

    def __getitem__(self, index: int) -> Any:
        made = tensors(self.dataset[index])
        return self.transform(made) if self.transform else made


class StereoStream(IterableDataset):
    """Fresh pairs without files: sample i is a function of (seed, epoch, i) alone.

    Blocks of ``pairs_per_scene`` samples share a scene; blocks are dealt over ranks and workers, so that no sample comes
    twice. Each block takes the next scene of the recipe's plan, grown from a seed of its own: the recipe must give its
    scenes by ``pivots``, not by ``seeds``. Only what the frames of its pairs see is built, whatever ``radius_m`` the recipe
    has; labels are those of the whole scene. A block's pairs are spread over the recipe's baselines and azimuths. ``set`` may
    be a function of the sample's index, for a curriculum; it is asked once a block.

    >>> import satseed
    >>> from satseed.torch import StereoStream
    >>> stream = StereoStream(satseed.crops("toronto", size_px=(64, 48)), seed=1, samples=2, pairs_per_scene=2)
    >>> [(pair["index"], tuple(pair["left"].shape)) for pair in stream]
    [(0, (3, 48, 64)), (1, (3, 48, 64))]
    """

    def __init__(
        self,
        recipe: str | os.PathLike[str],
        *,
        seed: int,
        samples: int | None = None,
        epoch: int = 0,
        start: int = 0,
        pairs_per_scene: int = 64,
        set: Mapping[str, Any] | Callable[[int], Mapping[str, Any]] | None = None,
        rank: int = 0,
        world_size: int = 1,
        threads: int | None = None,
        transform: Callable[[dict[str, Any]], Any] | None = None,
    ) -> None:
        """``samples``: how many an epoch has, endless where none; ``start``: the first that is still wanted."""
        whole = {"seed": seed, "epoch": epoch, "start": start, "rank": rank, "samples": samples or 0}
        for name, value in whole.items():
            satseed._whole(name, value)
        satseed._whole("pairs_per_scene", pairs_per_scene, 1)
        if not rank < satseed._whole("world_size", world_size, 1):
            raise satseed.RecipeError(f"rank is 0 to {world_size - 1} with a world_size of {world_size}, but {rank} is not")
        self.recipe, self.seed, self.samples, self.epoch, self.start = recipe, seed, samples, epoch, start
        self.pairs_per_scene, self.set, self.rank, self.world_size = pairs_per_scene, set, rank, world_size
        self.threads, self.transform = threads, transform
        first, other = (satseed.plan(recipe, set=self._changes(0), seed=s) for s in (1, 2))
        self.scenes = len(first)
        fixed = [a["name"] for a, b in zip(first, other) if a["seed"] == b["seed"]]
        if fixed:
            raise satseed.RecipeError(f"scene {fixed[0]} has a seed of its own in the recipe: a stream needs `pivots` instead of `seeds`")

    def set_epoch(self, epoch: int) -> None:
        """Another epoch: other scenes."""
        self.epoch = satseed._whole("epoch", epoch)

    def _changes(self, index: int) -> Mapping[str, Any]:
        given = (self.set(index) if callable(self.set) else self.set) or {}
        if not isinstance(given, Mapping):
            raise satseed.RecipeError(f"set is a mapping, such as {{'camera.gsd_m': 0.5}}, or a function of an index that gives one, but {given!r} is not")
        changes = dict(given)
        if "acquisition.pairs_per_pivot" not in changes:
            most = max(len(scene["pairs"]) for scene in satseed.plan(self.recipe, set=changes, seed=1))
            if most > self.pairs_per_scene:
                # As many as a block asks for, spread over all baselines and azimuths.
                changes["acquisition.pairs_per_pivot"] = self.pairs_per_scene
        return changes

    def block_seed(self, block: int) -> int:
        """The recipe's seed in a block, from (seed, epoch, block)."""
        text = f"satseed stream {self.seed} {self.epoch} {block}".encode()
        return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest(), "little") % _MOST_SEED

    def __len__(self) -> int:
        if self.samples is None:
            raise TypeError("an endless stream has no length")
        return max(0, self.samples - self.start)

    def __iter__(self) -> Iterator[Any]:
        worker = get_worker_info()
        workers, own = (worker.num_workers, worker.id) if worker else (1, 0)
        threads = self.threads or (1 if worker else None)
        # Block by block over the ranks, and what a rank has over its workers: how many those are is each rank's own affair.
        turn = -1
        for block in itertools.count(self.start // self.pairs_per_scene):
            if self.samples is not None and block * self.pairs_per_scene >= self.samples:
                return
            if block % self.world_size != self.rank:
                continue
            turn += 1
            if turn % workers != own:
                continue
            first = block * self.pairs_per_scene
            wanted = range(max(first, self.start), min(first + self.pairs_per_scene, self.samples or first + self.pairs_per_scene))
            with satseed.Scene(
                self.recipe, index=block % self.scenes, set=self._changes(first), seed=self.block_seed(block), threads=threads,
                crop=True,
            ) as scene:
                pairs = len(scene.pairs)
                for i in wanted:
                    # The plan spreads a pivot's pairs over baselines and azimuths; a block walks through them.
                    made = tensors(scene.sample((i - first) % pairs))
                    made["index"] = i
                    yield self.transform(made) if self.transform else made
