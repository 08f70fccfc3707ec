"""What the examples for clusters say: `cluster.py SATSEED RECIPE FOLDER`.

The manifests parse and have the fields that an Indexed Job needs, the N of `--shard auto/N` is the number of completions,
and the commands in them are ones that the program takes. The Ray example runs with threads in Ray's place, and with Ray
itself where it is installed.
"""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

SATSEED, RECIPE, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), Path(sys.argv[3])
EXAMPLES = Path(__file__).parents[2] / "examples" / "cluster"
checks = 0


def check(truth, what):
    global checks
    checks += 1
    if not truth:
        sys.exit(f"cluster.py: {what}")


def job(name):
    found = yaml.safe_load((EXAMPLES / name).read_text())
    check(found["apiVersion"] == "batch/v1" and found["kind"] == "Job", f"{name} is a job")
    pod = found["spec"]["template"]["spec"]
    check(pod["restartPolicy"] == "Never" and len(pod["containers"]) == 1, name)
    container = pod["containers"][0]
    check(all(isinstance(word, str) for word in container["command"]), f"{name}: a command is texts")
    check(container["command"][0] == "satseed", name)
    return found["spec"], pod, container


spec, pod, container = job("kubernetes.yaml")
command = container["command"]
check(spec["completionMode"] == "Indexed" and 0 < spec["parallelism"] <= spec["completions"], "an Indexed Job")
check(f"auto/{spec['completions']}" == command[command.index("--shard") + 1], "as many shards as completions")
check("backoffLimit" not in spec and spec["backoffLimitPerIndex"] > 0, "retries are counted by index")
check(pod["terminationGracePeriodSeconds"] >= 60, "time for a pair after SIGTERM")
rules = {tuple(rule.get("onExitCodes", {}).get("values", [])): rule["action"] for rule in spec["podFailurePolicy"]["rules"]}
check(rules == {(75,): "Ignore", (): "Ignore", (2,): "FailIndex"}, f"rules: {rules}")
for rule in spec["podFailurePolicy"]["rules"]:
    check(rule.get("onExitCodes", {}).get("containerName", container["name"]) == container["name"], "the container's name")
cores = int(container["resources"]["requests"]["cpu"])
check(command[command.index("--jobs") + 1] == str(cores), "as many threads as cores")
out = command[command.index("--out") + 1]

# The program takes the command: with a folder of ours, and without making anything.
dry = [str(SATSEED), *command[1:], "--dry-run"]
dry[dry.index(out)] = str(FOLDER / "dry")
done = subprocess.run(dry, env=os.environ | {"JOB_COMPLETION_INDEX": "0"}, capture_output=True, text=True)
check(done.returncode == 0 and "core-hours" in done.stdout, f"{dry}: {done.stderr}")

merge = job("kubernetes-merge.yaml")[2]
check(merge["command"] == ["satseed", "merge", out] and merge["envFrom"] == container["envFrom"], "the merge of the same dataset")

# The Slurm script.
script = (EXAMPLES / "slurm.sh").read_text()
subprocess.run(["bash", "-n", EXAMPLES / "slurm.sh"], check=True)
for option in ("--requeue", "--array=", "--signal=B:TERM@120", "--open-mode=append"):
    check(f"#SBATCH {option}" in script, option)

# Ray: the same tree as one run.
def tree(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


shutil.rmtree(FOLDER, ignore_errors=True)
FOLDER.mkdir(parents=True)
subprocess.run([SATSEED, "generate", RECIPE, "--out", FOLDER / "single", "--quiet"], check=True, stdout=subprocess.DEVNULL)
(FOLDER / "bin").mkdir()
(FOLDER / "bin" / "satseed").symlink_to(SATSEED)
env = os.environ | {"PATH": f"{(FOLDER / 'bin').resolve()}:{os.environ['PATH']}", "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0"}
engines = {"threads": ["--local", "2"]}
if importlib.util.find_spec("ray"):
    engines["ray"] = []
for name, options in engines.items():
    place = (FOLDER / name).resolve()
    run = [sys.executable, EXAMPLES / "ray_shards.py", RECIPE, place, "--shards", "4", "--jobs", "1", *options]
    done = subprocess.run(run, env=env, capture_output=True, text=True)
    check(done.returncode == 0 and "12 samples" in done.stdout, f"{name}: {done.stdout} {done.stderr}")
    check(tree(place) == tree(FOLDER / "single"), f"{name}: the same tree as one run")
shutil.rmtree(FOLDER)
print(f"cluster.py: {checks} checks, with {' and '.join(engines)}")
