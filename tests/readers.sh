#!/usr/bin/env bash
# What the program writes, read back by those who will: the Python readers, a browser, the Python package, loaders of other
# projects, object storage, clusters. `./check` runs it beside the tests, once the program and what Python needs are there.
#
#   tests/readers.sh [--long]
set -euo pipefail
cd "$(dirname "$0")/.."

long=0
[ "${1:-}" != --long ] || long=1
# The program as the tests have been built with it: built for itself alone, its dependencies would have other features and
# be built again.
satseed=target/debug/satseed
venv=target/check-venv

step() { printf '\n-- %s (%ss)\n' "$1" "$SECONDS"; }

step "Python readers"
rm -rf target/check-dataset target/check-exr target/check-one-band
"$satseed" generate quickstart --out target/check-dataset --quiet \
    --set camera.size_px=[256,256] --set acquisition.pairs_per_pivot=1 \
    --set scene.canyon.radius_m=130 --set scene.toronto.radius_m=130 \
    --set 'labels.write=["disparity_right", "class", "elevation", "normal", "shadow"]'
"$satseed" verify target/check-dataset
"$venv/bin/python" tests/python/read_back.py --all target/check-dataset
"$venv/bin/python" tests/python/readme.py README.md target/check-dataset
"$venv/bin/python" tests/python/evaluate.py target/check-dataset target/check-evaluate
"$venv/bin/python" tests/python/schema.py target/check-dataset
"$venv/bin/python" tests/python/card.py target/check-dataset
"$venv/bin/python" tests/python/sweep.py target/check-sweep

step "Gallery, in a browser"
"$venv/bin/python" tests/python/gallery.py target/check-dataset

step "Scenes as files"
"$venv/bin/python" tests/python/scene.py target/check-scene target/check-dataset quickstart \
    --set camera.size_px=[256,256] --set acquisition.pairs_per_pivot=1 \
    --set scene.canyon.radius_m=130 --set scene.toronto.radius_m=130

step "Python package"
"$venv/bin/python" -m compileall -q target/python-package
PYTHONPATH=target/python-package "$venv/bin/python" tests/python/package.py target/check-dataset
"$venv/bin/mypy" --strict --allow-subclassing-any --ignore-missing-imports --cache-dir target/mypy python/satseed tests/python/typed.py
if "$venv/bin/pyright" --version >/dev/null 2>&1; then
    "$venv/bin/pyright" --pythonpath "$venv/bin/python" --project python
else
    echo "check: Pyright cannot be started, so mypy alone has looked at the types"
fi

step "Exports, read back"
"$satseed" generate quickstart --out target/check-one-band --quiet \
    --set camera.size_px=[128,96] --set acquisition.pairs_per_pivot=1 --set scene.canyon.radius_m=80 \
    --set scene.toronto.radius_m=80 --set sensor.preset=gf7_pan
# A system that has no package of torch leaves its loaders out, and says so.
reader=/usr/bin/python3
"$reader" -c "import torchvision" 2>/dev/null || reader="$venv/bin/python"
PYTHONPATH=target/python-package "$reader" tests/python/package.py target/check-dataset torch
"$reader" tests/python/export.py target/check-dataset target/check-exports target/check-one-band
pandora=()
if [ "$long" = 1 ]; then
    "$venv/bin/pip" install --quiet --disable-pip-version-check pandora
    pandora=(--pandora)
fi
"$venv/bin/python" tests/python/export_readers.py target/check-dataset target/check-readers "${pandora[@]}"
# More than one shard's worth of samples: 18 in three shards, the last of them not full.
rm -rf target/check-several
"$satseed" generate quickstart --out target/check-several --quiet \
    --set camera.size_px=[128,96] --set acquisition.pairs_per_pivot=9 --set scene.canyon.radius_m=80 \
    --set scene.toronto.radius_m=80 --set 'labels.write=["disparity_right"]'
"$venv/bin/python" tests/python/export_readers.py target/check-several target/check-several-read --shards 3

step "OpenEXR"
"$satseed" generate quickstart --out target/check-exr --quiet \
    --set camera.size_px=[128,96] --set acquisition.pairs_per_pivot=1 --set scene.canyon.radius_m=80 \
    --set scene.toronto.radius_m=80 --set sensor.preset=linear
"$satseed" verify target/check-exr
"$venv/bin/python" tests/python/read_exr.py target/check-exr

step "Shards, object storage, clusters"
"$venv/bin/python" tests/python/s3.py "$satseed" tests/cluster/recipe.toml target/check-s3 \
    --conformance cargo test --workspace --locked --lib -- a_server_conforms
PYTHONPATH=target/python-package "$venv/bin/python" tests/python/cluster.py "$satseed" tests/cluster/recipe.toml target/check-cluster
