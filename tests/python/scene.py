#!/usr/bin/env python3
"""Opens what `satseed scene` writes with other people's readers, and holds the three files of a scene against each other.

    pip install numpy pillow trimesh rasterio
    python tests/python/scene.py WORK_FOLDER DATASET RECIPE [--set KEY=VALUE]...

DATASET is what `satseed generate` makes of the recipe with these overrides; its files hold the same scenes. With node and npm on the path, Khronos' glTF validator judges the models too; otherwise it says that this is left out.
"""

import json
import pathlib
import shutil
import struct
import subprocess
import sys

import numpy as np
import rasterio
import trimesh
from PIL import Image

REGIONS = {"canyon": 80, "toronto": 80, "desert": 80}
# What f32 may do to a vertex 1 km away and to the matrix that places it.
GLB_M = 3e-4
POINT_M = 1e-3
work, dataset, recipe = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:]
checks = 0


def check(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"scene.py: {what}")


def satseed(*arguments, code=0):
    command = ["target/debug/satseed", *map(str, arguments)]
    ended = subprocess.run(command, capture_output=True, text=True)
    check(ended.returncode == code, f"exit code {ended.returncode}, not {code}, of {command[1:]}: {ended.stderr}")
    return ended.stderr


def scene(region, radius_m, file, *more, **kwargs):
    """A scene of the region's preset, small and quick to render."""
    settings = [f"scene.{region}.radius_m={radius_m}", "camera.size_px=[96,80]", 'camera.datum="pivot"']
    settings.append("sensor.samples_per_pixel=1")
    sets = [part for setting in settings for part in ("--set", setting)]
    return satseed("scene", region, "--region", region, "--seed", 3, *sets, "-o", file, *more, **kwargs)


# --- readers -------------------------------------------------------------------------------------------------------------

def read_json(path):
    """The JSON chunk of a GLB."""
    data = path.read_bytes()
    magic, version, length, size, kind = struct.unpack_from("<4sIII4s", data)
    check((magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON"), f"{path}: no GLB 2.0")
    return json.loads(data[20 : 20 + size])


def read_triangles(path):
    """All triangles as trimesh places them, turned back to east, north, up."""
    loaded = trimesh.load(path, process=False, maintain_order=True)
    check(isinstance(loaded, trimesh.Scene), f"{path}: trimesh finds no scene in it")
    corners = []
    for name in loaded.graph.nodes_geometry:
        matrix, geometry = loaded.graph[name]
        mesh = loaded.geometry[geometry]
        vertices = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        corners.append(vertices[mesh.faces])
    triangles = np.concatenate(corners)
    return np.stack([triangles[..., 0], -triangles[..., 2], triangles[..., 1]], axis=-1)


def read_ply(path):
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode().splitlines()
    check(header[:2] == ["ply", "format binary_little_endian 1.0"], f"{path}: {header[:2]}")
    kinds = {"float": "<f4", "uchar": "u1"}
    fields = [(name, kinds[kind]) for word, kind, name in (line.split() for line in header if line.startswith("property"))]
    points = np.frombuffer(data[end:], dtype=fields)
    count = next(int(line.split()[2]) for line in header if line.startswith("element vertex"))
    check(len(points) == count, f"{path}: {len(points)} points, its header says {count}")
    return points


# --- geometry ------------------------------------------------------------------------------------------------------------

def distance(point, triangles):
    """From a point to the nearest of some triangles: to a face where the foot lies in it, else to an edge."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    best = np.inf
    for p, q in ((a, b), (b, c), (c, a)):
        along = q - p
        t = np.clip(np.einsum("ij,ij->i", point - p, along) / np.einsum("ij,ij->i", along, along), 0.0, 1.0)
        best = min(best, np.linalg.norm(point - p - t[:, None] * along, axis=1).min())
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal / np.where(length > 0, length, 1)
    inside = np.ones(len(a), bool)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ij,ij->i", np.cross(q - p, point - p), normal) >= 0
    if inside.any():
        best = min(best, np.abs(np.einsum("ij,ij->i", point - a, normal))[inside].min())
    return best


def highest(x, y, triangles):
    """Height of the uppermost triangle over a place, and 1 mm beside it on four sides: there it differs at an edge."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]

    def at(x, y):
        e = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        # Vertical triangles have no place in a plan: their numbers are no numbers, and hit nothing.
        with np.errstate(divide="ignore", invalid="ignore"):
            u = ((x - a[:, 0]) * (c[:, 1] - a[:, 1]) - (y - a[:, 1]) * (c[:, 0] - a[:, 0])) / e
            v = ((b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])) / e
            hit = (e != 0) & (u >= 0) & (v >= 0) & (u + v <= 1)
            z = a[:, 2] + u * (b[:, 2] - a[:, 2]) + v * (c[:, 2] - a[:, 2])
        return z[hit].max() if hit.any() else np.nan

    step = 1e-3
    return at(x, y), [at(x + dx, y + dy) for dx, dy in ((-step, -step), (step, -step), (-step, step), (step, step))]


def around(triangles, low, high, point, axes, reach):
    """The triangles whose box comes near a point."""
    near = np.ones(len(triangles), bool)
    for k in axes:
        near &= (low[:, k] <= point[k] + reach) & (high[:, k] >= point[k] - reach)
    return triangles[near]


# --- the checks ----------------------------------------------------------------------------------------------------------

def check_region(region, radius_m):
    glb, ply, tif = (work / f"{region}.{ending}" for ending in ("glb", "ply", "tif"))
    for file in (glb, ply, tif):
        scene(region, radius_m, file)
    dtm = work / f"{region}-dtm.tif"

    # The model, in a second reader.
    document = read_json(glb)
    nodes = document["nodes"]
    children = nodes[document["scenes"][0]["nodes"][0]]["children"]
    check(len(children) == len(nodes) - 1, f"{region}: every node but the root stands under it")
    shown = sum(len(document["meshes"][node["mesh"]]["primitives"]) for node in nodes if "mesh" in node)
    triangles = read_triangles(glb)
    counts = sum(
        document["accessors"][p["indices"]]["count"] // 3
        for node in nodes
        if "mesh" in node
        for p in document["meshes"][node["mesh"]]["primitives"]
    )
    check(len(triangles) == counts, f"{region}: trimesh places {len(triangles)} triangles, the file {counts}")
    extras = document["scenes"][0]["extras"]
    check((extras["region"], extras["seed"], extras["units"]) == (region, 3, "m"), f"{region}: extras {extras}")
    colours = [m["pbrMetallicRoughness"]["baseColorFactor"] for m in document["materials"]]
    check(all(0 <= x <= 0.95 + 1e-6 for c in colours for x in c[:3]), f"{region}: reflectances of 0 to 0.95")
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    rng = np.random.default_rng(7)

    # The height map: its frame, and the model's uppermost triangle under the centres of some cells.
    with rasterio.open(tif) as file, rasterio.open(dtm) as ground:
        heights, cell = file.read(1), file.res[0]
        check(ground.transform == file.transform and ground.shape == file.shape, f"{region}: DSM and DTM of one grid")
        check(np.isnan(file.nodata) and file.dtypes == ("float32",), f"{region}: 32-bit floats, NaN for none")
        check(abs(cell - 0.3) < 1e-12, f"{region}: cells of {cell} m")
        bounds = file.bounds
        check(abs(bounds.left + bounds.right) < 1e-6 and abs(bounds.top + bounds.bottom) < 1e-6, f"{region}: the pivot is its middle")
        check(radius_m <= bounds.right < radius_m + cell, f"{region}: it reaches {bounds.right} m")
        check(np.nanmin(heights - ground.read(1)) > -1e-3, f"{region}: no surface below the ground")
        cells = [(row, column, *file.xy(row, column)) for row, column in rng.integers(0, file.height, (300, 2))]
    edges = 0
    for row, column, x, y in cells:
        found, beside = highest(x, y, around(triangles, low, high, (x, y), (0, 1), 0.01))
        # Within 1 mm of an edge either side may be right.
        spread = [z for z in (found, *beside) if not np.isnan(z)]
        steep = max(spread) - min(spread)
        edges += steep > 0.05
        good = min(spread) - GLB_M <= heights[row, column] <= max(spread) + GLB_M
        check(good, f"{region}: the model is {found} m high at {x}, {y}, the DSM {heights[row, column]} m")
    check(edges < 15, f"{region}: {edges} of 300 cells at an edge say little")

    # The point cloud: on the model's triangles.
    points = read_ply(ply)
    check(len(points) == 2 * 96 * 80, f"{region}: a point for each pixel of both views")
    check(set(points.dtype.names) == {"x", "y", "z", "red", "green", "blue", "class"}, f"{region}: {points.dtype.names}")
    check(points["class"].min() >= 1 and points["class"].max() <= 14, f"{region}: classes 1 to 14")
    check(np.ptp(points["green"].astype(int)) > 30, f"{region}: colours differ")
    loaded = trimesh.load(ply)
    check(len(loaded.vertices) == len(points), f"{region}: trimesh reads {len(loaded.vertices)} points")
    worst = 0.0
    for point in rng.choice(points, 300, replace=False):
        xyz = np.array([point["x"], point["y"], point["z"]], float)
        near = around(triangles, low, high, xyz, (0, 1, 2), 0.01)
        check(len(near) > 0, f"{region}: no triangle near point {xyz}")
        worst = max(worst, distance(xyz, near))
    check(worst < POINT_M + GLB_M, f"{region}: a point lies {worst} m off the model")
    print(f"{region}: {len(children)} instances, {shown} primitives, {len(triangles)} triangles; points within {worst:.1e} m")
    return glb


def check_against_dataset():
    """A scene's files say what the dataset's say."""
    for line in (dataset / "manifest.jsonl").read_text().splitlines():
        record = json.loads(line)
        folder, name, pair = dataset / record["id"], record["region"], record["id"].split("/")[1]
        one = ("scene", *recipe, "--region", name, "--seed", record["scene_seed"], "-o")
        tif, ply = work / "of-dataset.tif", work / "of-dataset.ply"
        satseed(*one, tif)
        for file, same in ((tif, "dsm.tif"), (work / "of-dataset-dtm.tif", "dtm.tif")):
            check(file.read_bytes() == (folder.parent / same).read_bytes(), f"{name}: {file} is not the dataset's {same}")
        satseed(*one, ply, "--pair", pair)
        points = read_ply(ply)
        for part, view in zip(np.split(points, 2), ("left", "right")):
            rgb = np.stack([part["red"], part["green"], part["blue"]], axis=-1)
            image = np.array(Image.open(folder / f"{view}.png"))
            check((rgb == image.reshape(-1, 3)).all(), f"{record['id']}: colours of the {view} view")
            classes = np.array(Image.open(folder / f"class_{view}.png"))
            check((part["class"] == classes.ravel()).all(), f"{record['id']}: classes of the {view} view")
            elevation = np.array(Image.open(folder / f"elevation_{view}.tif"))
            worst = np.abs(part["z"] - elevation.ravel()).max()
            check(worst < POINT_M, f"{record['id']}: heights of the {view} view differ by {worst} m")


def check_refusals():
    """Bad input gets a sentence, and nothing is written."""
    folder = work / "refused"
    folder.mkdir()
    for file, more, parts in [
        ("a.gltf", (), [".glb is a 3-D model"]),
        ("no/a.glb", (), ["is no folder"]),
        ("a.glb", ("--pair", "b00-a00"), ["--pair", ".ply"]),
        ("a.ply", ("--pair", "b77-a77"), ["has no pair `b77-a77`", "the first is b"]),
        ("a.ply", ("--set", "camera.size_px=[2048,2048]"), ["sees as far as", "radius_m"]),
        ("a.tif", ("--set", "scene.canyon.radius=80"), ["radius"]),
        ("a.glb", ("--variant", "moon"), ["moon"]),
    ]:
        said = scene("canyon", 80, folder / file, *more, code=2)
        check(said.count("error") == 1 and "panicked" not in said, f"{file} {more}: {said}")
        for part in parts:
            check(part in said, f"{file} {more}: {said} lacks `{part}`")
    said = satseed("scene", "canyon", "--region", "desert", "-o", folder / "a.glb", code=2)
    check("has no scene of `desert`" in said and "--seed" in said, said)
    said = satseed("scene", "canyon", "--region", "sea", "-o", folder / "a.glb", code=2)
    check("`sea` is no region" in said, said)
    check(list(folder.iterdir()) == [], f"left behind: {list(folder.iterdir())}")


def validate(files):
    """Khronos' validator, where npm can bring it."""
    folder = work / "validator"
    folder.mkdir()
    if not shutil.which("npm") or subprocess.run(
        ["npm", "install", "--silent", "--no-audit", "--no-fund", "gltf-validator"], cwd=folder, capture_output=True
    ).returncode:
        print("scene.py: Khronos' glTF validator is left out, npm cannot bring it", file=sys.stderr)
        return
    script = """
const validator = require('gltf-validator'), fs = require('fs');
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[1])), { maxIssues: 5 })
  .then((report) => console.log(JSON.stringify(report.issues)));
"""
    for file in files:
        ended = subprocess.run(["node", "-e", script, str(file.absolute())], cwd=folder, capture_output=True, text=True)
        check(ended.returncode == 0, ended.stderr)
        issues = json.loads(ended.stdout)
        counts = [issues[kind] for kind in ("numErrors", "numWarnings", "numInfos", "numHints")]
        check(counts == [0, 0, 0, 0], f"{file}: {issues}")
    print(f"Khronos' validator has nothing to say to {len(files)} models")


if work.exists():
    shutil.rmtree(work)
work.mkdir(parents=True)
models = [check_region(region, radius_m) for region, radius_m in REGIONS.items()]
scene("desert", 80, work / "again.glb")
check((work / "again.glb").read_bytes() == (work / "desert.glb").read_bytes(), "the same scene gives the same bytes")
check_against_dataset()
check_refusals()
validate(models)
print(f"scene.py: {checks} checks")
