"""Synthetic satellite-stereo pairs from seeds, with exact labels, as NumPy arrays.

>>> import satseed
>>> pair = satseed.generate(satseed.crops("toronto", size_px=(64, 48)), crop=True)
>>> pair.left.shape, str(pair.disparity.dtype)
((48, 64, 3), 'float32')
>>> bool(pair.valid.any()), pair.region, pair.split
(True, 'toronto', 'train')
"""

from __future__ import annotations

import os

from . import _native
from ._native import DatasetError, GenerateError, RecipeError, __version__

# Importing takes under 5 ms: what only some functions or type checkers need is imported there.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from typing import Any, overload

    from numpy import bool_, float32, uint8
    from numpy.typing import NDArray
else:
    # As collections.abc has it; the interpreter itself has loaded this one, and all of collections takes 3 ms.
    from _collections_abc import Sequence

    def overload(_: object) -> None:
        """Of typing, which is not worth its import."""


__all__ = [
    "REGIONS", "Dataset", "DatasetError", "GenerateError", "RecipeError", "Sample", "Scene", "__version__", "crops", "generate",
    "open", "plan", "view",
]

MISS, VALID, OCCLUDED, OUT_OF_FRAME = 0, 1, 2, 3


class Sample:
    """A pair with its labels. Arrays have shape (rows, columns) or (rows, columns, bands), row 0 on top."""

    id: str
    """Scene and pair, such as ``toronto-core-7/b03-a17``."""
    region: str
    variant: str
    scene_seed: int
    split: str
    """``train``, ``val`` or ``test``."""
    baseline_m: float
    """Distance of the optical centres, m."""
    azimuth_deg: float
    """Direction of the baseline, clockwise from north, degrees."""
    camera: dict[str, Any]
    """Both cameras, as ``camera.json`` has them."""
    arrays: dict[str, NDArray[Any]]
    """Every array by its name: ``left``, ``right``, ``disparity_left``, ``validity_left``, ``class_left`` ..."""

    FACTS = ("id", "region", "variant", "scene_seed", "split", "baseline_m", "azimuth_deg")
    __slots__ = (*FACTS, "camera", "arrays")

    def __init__(self, facts: Mapping[str, Any], camera: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> None:
        for name in self.FACTS:
            setattr(self, name, facts[name])
        self.camera, self.arrays = camera, arrays

    def __repr__(self) -> str:
        facts = ", ".join(f"{name}={getattr(self, name)!r}" for name in self.FACTS)
        return f"Sample({facts}, arrays={sorted(self.arrays)})"

    @property
    def left(self) -> NDArray[Any]:
        """The left image: uint8 (rows, columns, 3) with the default sensor."""
        return self.arrays["left"]

    @property
    def right(self) -> NDArray[Any]:
        """The right image."""
        return self.arrays["right"]

    @property
    def disparity(self) -> NDArray[float32]:
        """u_L - u_R of the left view, px, float32, signed, also where it is occluded; NaN where nothing was hit."""
        return self.arrays["disparity_left"]

    @property
    def validity(self) -> NDArray[uint8]:
        """uint8: 0 nothing hit, 1 valid, 2 occluded, 3 out of frame."""
        return self.arrays["validity_left"]

    @property
    def valid(self) -> NDArray[bool_]:
        """Where both cameras see the point, bool."""
        valid: NDArray[bool_] = self.validity == VALID
        return valid


def _sample(made: tuple[str, dict[str, NDArray[Any]]]) -> Sample:
    import json

    facts, arrays = json.loads(made[0]), made[1]
    return Sample(facts["identity"], facts["camera"], arrays)


def _set(changes: Mapping[str, Any] | Sequence[str] | None) -> list[str]:
    """``key=value`` lines, as ``--set`` takes them."""
    if changes is None:
        return []
    if isinstance(changes, str):
        raise RecipeError(f"set is a mapping or a list of key=value, such as {{'camera.gsd_m': 0.5}}, but {changes!r} is one text")
    items = getattr(changes, "items", None)
    if items is not None:
        return [f"{_key(key)}={_toml(value)}" for key, value in items()]
    if not isinstance(changes, Sequence):
        raise RecipeError(f"set is a mapping or a list of key=value, such as {{'camera.gsd_m': 0.5}}, but {changes!r} is neither")
    for line in changes:
        if not isinstance(line, str):
            raise RecipeError(f"set holds key=value texts, but {line!r} is none")
    return list(changes)


def _key(key: Any) -> str:
    if not isinstance(key, str) or not key:
        raise RecipeError(f"a key of a recipe is a text such as 'camera.gsd_m', but {key!r} is none")
    return key


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _quoted(value)
    if hasattr(value, "items"):
        return "{" + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, (int, float)):
        return repr(value)
    raise RecipeError(f"{value!r} cannot stand in a recipe: numbers, texts, lists and mappings can")


def _quoted(text: str) -> str:
    import json

    return json.dumps(text)


def _whole(name: str, value: Any, least: int = 0) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value < 2**63:
        raise RecipeError(f"{name} is a whole number from {least} up, but {value!r} is not")
    return value


def _text(name: str, value: Any) -> str:
    if not isinstance(value, str) or not value:
        raise RecipeError(f"{name} is a text, but {value!r} is none")
    return value


def _recipe(recipe: Any) -> str:
    if isinstance(recipe, (str, os.PathLike)):
        return os.fspath(recipe) if not isinstance(recipe, str) else recipe
    raise RecipeError(f"a recipe is a preset's name, a file's path or its text, but {recipe!r} is none")


def plan(recipe: str | os.PathLike[str], *, set: Mapping[str, Any] | Sequence[str] | None = None, seed: int | None = None) -> list[dict[str, Any]]:
    """The scenes of a recipe with their pairs; nothing is made.

    >>> import satseed
    >>> [(scene["name"], len(scene["pairs"])) for scene in satseed.plan("quickstart")][0]
    ('canyon-gorge-7-d9c8eae3', 4)
    """
    seed = None if seed is None else _whole("seed", seed)
    import json

    scenes: list[dict[str, Any]] = json.loads(_native.plan(_recipe(recipe), _set(set), seed))["scenes"]
    return scenes


class Scene:
    """A scene, built once and traced as often as one likes, also from several threads."""

    def __init__(
        self,
        recipe: str | os.PathLike[str],
        *,
        index: int = 0,
        set: Mapping[str, Any] | Sequence[str] | None = None,
        seed: int | None = None,
        threads: int | None = None,
        crop: bool = False,
    ) -> None:
        """Builds scene ``index`` of the recipe's plan, on ``threads`` threads (all cores).

        ``crop``: only what the frames of its pairs see is built, whatever the region's ``radius_m``: the smallest radius
        that the recipe's frames and baselines need. Labels are those of the same pairs of the whole scene, whose name the
        scene keeps; images differ where far ground shades or lights the crop. All pairs count as ``train``.
        """
        threads = os.cpu_count() or 1 if threads is None else _whole("threads", threads, 1)
        seed = None if seed is None else _whole("seed", seed)
        if not isinstance(crop, bool):
            raise RecipeError(f"crop is True or False, but {crop!r} is neither")
        self._native: _native.Scene | None = _native.Scene(_recipe(recipe), _set(set), seed, _whole("index", index), threads, crop)

    def _open(self) -> _native.Scene:
        if self._native is None:
            raise GenerateError("the scene is closed: build it again")
        return self._native

    @property
    def name(self) -> str:
        """Its name, the folder that it has in a dataset."""
        return self._open().name

    @property
    def radius_m(self) -> float:
        """How far from the pivot it stands in full detail, m."""
        return self._open().radius_m

    @property
    def pairs(self) -> list[str]:
        """Ids of its pairs in plan order."""
        return self._open().pairs

    def sample(self, pair: int | str = 0) -> Sample:
        """Traces, renders and labels a pair, by its number or its id (or the id's last part)."""
        scene = self._open()
        if isinstance(pair, str):
            names = scene.pairs
            found = [i for i, name in enumerate(names) if pair in (name, name.split("/")[1])]
            if not found:
                raise RecipeError(f"scene {scene.name} has no pair {pair!r}; the first is {names[0]}")
            pair = found[0]
        return _sample(scene.sample(_whole("pair", pair)))

    def close(self) -> None:
        """Frees the scene's memory."""
        self._native = None

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __reduce__(self) -> Any:
        raise TypeError("a scene cannot be pickled: send recipe, seed and index, and build it there")


REGIONS = ("canyon", "toronto", "desert", "field", "forest", "coast", "california", "venice")
"""All regions."""


def crops(
    *regions: str, size_px: tuple[int, int] = (512, 384), baseline_m: tuple[float, float] = (50.0, 100.0), samples_per_pixel: int = 1
) -> str:
    """The text of a recipe of small frames, for a stream: a scene of each region (all of them), left labels alone.

    Frames overlap fully at the pivot's height, so that disparities are signed: higher things have more than 0.

    >>> import satseed
    >>> [scene["region"] for scene in satseed.plan(satseed.crops("desert", "field"))]
    ['desert', 'field']
    """
    columns, rows = (_whole("size_px", size, 1) for size in size_px)
    low_m, high_m = (_toml(float(length)) for length in baseline_m)
    scenes = "".join(f"[[scene]]\n{_quoted(_text('region', region))} = {{}}\npivots = 1\n" for region in regions or REGIONS)
    return f"""extends = "satunreal"
[camera]
size_px = [{columns}, {rows}]
datum = "pivot"
[acquisition]
baseline_m = {{ from = {low_m}, to = {high_m}, steps = 16 }}
azimuth_deg = {{ from = -90.0, to = 90.0, draws = 16 }}
[sensor]
samples_per_pixel = {_whole("samples_per_pixel", samples_per_pixel, 1)}
[labels]
write = []
[split]
rule = "by-pivot"
{scenes}"""


def generate(
    recipe: str | os.PathLike[str] = "quickstart",
    *,
    index: int = 0,
    pair: int | str = 0,
    set: Mapping[str, Any] | Sequence[str] | None = None,
    seed: int | None = None,
    threads: int | None = None,
    crop: bool = False,
) -> Sample:
    """Makes one pair: the same arrays that ``satseed generate`` writes for the same recipe, bit for bit.

    With ``crop`` no more of the scene is built than a `Scene` made so: the same labels, sooner.
    """
    if not isinstance(pair, str):
        _whole("pair", pair)
    with Scene(recipe, index=index, set=set, seed=seed, threads=threads, crop=crop) as scene:
        return scene.sample(pair)


class Dataset(Sequence[Sample]):
    """A finished dataset in a folder. Only what is asked for is read."""

    def __init__(self, folder: str | os.PathLike[str], *, arrays: Sequence[str] | None = None) -> None:
        """Opens a folder; ``arrays`` names what a sample is to hold, such as ``["left", "right", "disparity_left"]``."""
        self._folder, self._names = os.fspath(folder), None if arrays is None else list(arrays)
        self._native = _native.Dataset(self._folder)
        import json

        self.records: list[dict[str, Any]] = json.loads(self._native.records)
        """The manifest's lines, of the samples that are left after filtering."""

    @property
    def root_hash(self) -> str:
        """BLAKE3 of the manifest, which stands for every byte."""
        return self._native.root_hash

    def filter(self, *, region: str | None = None, variant: str | None = None, split: str | None = None) -> Dataset:
        """The samples of a region, a variant, a split."""
        other = self.__class__.__new__(self.__class__)
        other.__dict__.update(self.__dict__)
        wanted = {"region": region, "variant": variant, "split": split}
        other.records = [r for r in self.records if all(v is None or r[k] == v for k, v in wanted.items())]
        return other

    def __len__(self) -> int:
        return len(self.records)

    @overload
    def __getitem__(self, index: int) -> Sample: ...
    @overload
    def __getitem__(self, index: slice) -> Dataset: ...
    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            other = self.filter()
            other.records = self.records[index]
            return other
        if isinstance(index, bool) or not hasattr(index, "__index__"):
            raise TypeError(f"a sample is asked for by its number, but {index!r} is none")
        return self.sample(self.records[index.__index__()]["id"])

    def __iter__(self) -> Iterator[Sample]:
        return (self[i] for i in range(len(self)))

    def sample(self, id: str) -> Sample:
        """A sample by its id."""
        if not isinstance(id, str):
            raise TypeError(f"an id is a text such as toronto-core-7/b03-a17, but {id!r} is none")
        return _sample(self._native.read(id, self._names))

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "_native"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._native = _native.Dataset(self._folder)


def view(sample: Sample, *, save: str | os.PathLike[str] | None = None, name: str = "satseed") -> Any:
    """Shows a pair in the Rerun viewer: both images in their cameras, disparity and validity, and the points in the world.

    ``save`` writes a ``.rrd`` file instead of starting a viewer. Returns Rerun's recording, to log more into it. Needs
    ``rerun-sdk``, the extra ``satseed[rerun]``.
    """
    from . import _view

    return _view.view(sample, save=save, name=name)


def open(folder: str | os.PathLike[str], *, arrays: Sequence[str] | None = None) -> Dataset:
    """Opens a finished dataset."""
    if not isinstance(folder, (str, os.PathLike)):
        raise TypeError(f"a dataset is a folder's path, but {folder!r} is none")
    return Dataset(folder, arrays=arrays)
