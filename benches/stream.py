#!/usr/bin/env python3
"""How many crops a second and core `StereoStream` makes, scene building included, region by region.

    python benches/stream.py [--scenes 2] [--pairs-per-scene 64] [--set KEY=VALUE ...] [--json FILE]

One thread. CPU seconds of this process, so that other work on the machine does not count; the mix gives every region as many
crops as any other. The summary is in crops a second of CPU time, which is what a core gives when nothing else wants it.
"""

import argparse
import json
import resource
import time

import satseed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--regions", nargs="*", default=satseed.REGIONS)
    parser.add_argument("--scenes", type=int, default=2, help="scenes of each region")
    parser.add_argument("--pairs-per-scene", type=int, default=64)
    parser.add_argument("--set", nargs="*", default=[], metavar="KEY=VALUE")
    parser.add_argument("--json")
    a = parser.parse_args()
    rows = {}
    for region in a.regions:
        recipe = satseed.crops(region)
        build = trace = crops = 0.0
        for seed in range(1, a.scenes + 1):
            begun = time.process_time()
            with satseed.Scene(recipe, seed=seed, set=[f"acquisition.pairs_per_pivot={a.pairs_per_scene}", *a.set], threads=1, crop=True) as scene:
                built = time.process_time()
                for pair in range(len(scene.pairs)):
                    scene.sample(pair)
                build, trace, crops = build + built - begun, trace + time.process_time() - built, crops + len(scene.pairs)
                radius_m = scene.radius_m
        rows[region] = {
            "radius_m": radius_m, "scene_s": build / a.scenes, "crop_s": trace / crops, "crops_per_s": crops / (build + trace),
        }
        print(region, {k: round(v, 3) for k, v in rows[region].items()}, flush=True)
    mix = len(rows) / sum(1 / r["crops_per_s"] for r in rows.values())
    memory_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"mix: {mix:.3f} crops a CPU second; most memory {memory_mib:.0f} MiB")
    if a.json:
        with open(a.json, "w") as file:
            json.dump({"pairs_per_scene": a.pairs_per_scene, "set": a.set, "regions": rows, "mix_crops_per_s": mix, "memory_mib": memory_mib}, file, indent=1)


if __name__ == "__main__":
    main()
