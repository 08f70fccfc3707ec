"""A dataset on a Ray cluster: one shard a task, joined at the end, read with the Python package.

    python ray_shards.py quickstart s3://my-bucket/quickstart --shards 64
    python ray_shards.py quickstart /shared/quickstart --shards 4 --local 2     # threads of this machine, no Ray

OUT is a place that every worker sees: a folder on a shared file system, or object storage with the keys in the workers'
environment. The workers need the program `satseed` on their PATH. A worker that dies takes nothing with it: its task is
given to another one, which goes on after the last finished sample.
"""

import argparse
import subprocess
from concurrent.futures import ThreadPoolExecutor

import satseed


def shard(recipe: str, out: str, index: int, count: int, jobs: int, changes: list[str]) -> int:
    """Makes one shard; an error says what the program said."""
    command = ["satseed", "generate", recipe, "--out", out, "--shard", f"{index}/{count}", "--jobs", str(jobs)]
    command += [argument for change in changes for argument in ("--set", change)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"shard {index}/{count} ended with {done.returncode}: {done.stderr.strip()}")
    return index


def main() -> None:
    arguments = argparse.ArgumentParser(description="A dataset on a Ray cluster")
    arguments.add_argument("recipe")
    arguments.add_argument("out")
    arguments.add_argument("--shards", type=int, default=64, help="many more than machines: fast ones take more of them")
    arguments.add_argument("--jobs", type=int, default=8, help="cores a shard")
    arguments.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as of satseed generate")
    arguments.add_argument("--local", type=int, metavar="N", help="N shards at once on this machine, without Ray")
    args = arguments.parse_args()

    pairs = sum(len(scene["pairs"]) for scene in satseed.plan(args.recipe, set=args.set))
    count = min(args.shards, pairs)
    print(f"{pairs} pairs in {count} shards")
    tasks = [(args.recipe, args.out, index, count, args.jobs, args.set) for index in range(1, count + 1)]
    if args.local:
        with ThreadPoolExecutor(args.local) as pool:
            for done in pool.map(lambda task: shard(*task), tasks):
                print(f"shard {done}/{count}")
    else:
        import ray

        ray.init()
        # A worker that dies is replaced; an error of the program would be the same again, and ends the run.
        remote = ray.remote(num_cpus=args.jobs, max_retries=5)(shard)
        waiting = [remote.remote(*task) for task in tasks]
        while waiting:
            (done,), waiting = ray.wait(waiting)
            print(f"shard {ray.get(done)}/{count}")

    merged = subprocess.run(["satseed", "merge", args.out], check=True, capture_output=True, text=True)
    print(f"root hash {merged.stdout.strip()}")
    if "://" not in args.out:
        dataset = satseed.open(args.out)
        first = dataset[0]
        print(f"{len(dataset)} samples; {first.id}: {first.valid.mean():.1%} of its left view is seen by both cameras")


if __name__ == "__main__":
    main()
