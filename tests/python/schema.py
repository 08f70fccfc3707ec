#!/usr/bin/env python3
"""Holds the JSON schema of recipes against the presets, a dataset's own recipe, and mistakes that both it and the program refuse.

    pip install jsonschema
    python tests/python/schema.py DATASET
"""

import json
import pathlib
import subprocess
import sys
import tomllib

import jsonschema

home = pathlib.Path(__file__).resolve().parents[2]
checks = 0


def check(condition, what):
    global checks
    checks += 1
    if not condition:
        sys.exit(f"schema.py: {what}")


def satseed(*arguments):
    return subprocess.run(["target/debug/satseed", *arguments], capture_output=True, text=True)


schema = json.loads(satseed("presets", "schema").stdout)
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)
for file in [*sorted((home / "presets").glob("*.toml")), pathlib.Path(sys.argv[1]) / "recipe.toml"]:
    found = [e.message for e in validator.iter_errors(tomllib.loads(file.read_text()))]
    check(not found, f"{file.name}: {found}")

# Every key of a resolved recipe is in the schema, so that none is added to the one and forgotten in the other.
resolved = tomllib.loads((pathlib.Path(sys.argv[1]) / "recipe.toml").read_text())
for name, table in resolved.items():
    if isinstance(table, dict) and name not in ("stages", "generators"):
        missing = set(table) - set(schema["properties"][name]["properties"])
        check(not missing, f"{name} lacks {missing}")

TAIL = "\n[[scene]]\ncanyon = {}\n"
for bad in (
    "sead = 1", "seed = -1", "[camera]\ngsd_m = 0", "[camera]\nsize_px = [4, 512]", "[camera]\ndatum = 'lower'",
    "[acquisition]\nbaseline_m = { from = 1, to = 2 }", "[acquisition]\nazimuth_deg = [400]", "[light]\nsun = { elevation = 3 }",
    "[sensor]\npreset = 'hubble'", "[sensor]\nmtf_at_nyquist = 'some'", "[labels]\nwrite = ['depth']", "[split]\nrule = 'none'",
    "extends = 'nothing'", "[[scene]]\ncanyon = { relief = 3 }", "[[scene]]\natlantis = {}", "[[scene]]\ndesert = { variant = 'snow' }",
):
    text = bad + TAIL
    check(list(validator.iter_errors(tomllib.loads(text))), f"the schema lets pass: {bad}")
    recipe = pathlib.Path(sys.argv[1]).parent / "check-bad.toml"
    recipe.write_text(text)
    check(satseed("plan", str(recipe)).returncode == 2, f"the program lets pass: {bad}")
    recipe.unlink()
print(f"{checks} passed, 0 failed")
