#!/usr/bin/env bash
# Slurm as it is: munge, slurmctld and slurmd from Debian's packages on this machine, an array of four shards, of which
# one is killed and requeued and one is told to stop; the merged dataset equals the single run's byte for byte.
#
#     tests/slurm.sh SATSEED FOLDER
set -euo pipefail
cd "$(dirname "$0")/.."
satseed=$(realpath "$1")
mkdir -p "$2"
folder=$(realpath "$2")

skip() { echo "slurm.sh: skipped: $1"; exit 0; }

[ "$(id -u)" = 0 ] || skip "slurmd needs root"
if ! command -v slurmctld slurmd munged sbatch >/dev/null; then
    command -v apt-get >/dev/null || skip "there is no apt-get, and Slurm is not installed"
    { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends slurm-wlm munge; } \
        >/dev/null 2>&1 || skip "Debian's slurm-wlm and munge cannot be installed"
fi

rm -rf "${folder:?}"/*
mkdir -p "$folder/state" "$folder/spool" "$folder/logs"
# A socket's path is short.
run=$(mktemp -d /tmp/satseed-slurm.XXXXXX)
daemons=()
end() {
    for ((i = ${#daemons[@]} - 1; i >= 0; i--)); do
        kill "${daemons[i]}" 2>/dev/null || true
        wait "${daemons[i]}" 2>/dev/null || true
    done
    rm -rf "$run"
}
trap end EXIT

head -c 1024 /dev/urandom >"$run/munge.key"
chmod 400 "$run/munge.key"
munged --foreground --force --socket "$run/munge.sock" --key-file "$run/munge.key" --pid-file "$run/munge.pid" \
    --log-file "$folder/logs/munged" --seed-file "$run/munge.seed" >"$folder/logs/munged.out" 2>&1 &
daemons+=($!)

host=$(hostname -s)
port=$((20000 + $$ % 20000))
cat >"$run/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$run/munge.sock,cred_expire=5
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$run/slurmctld.pid
SlurmdPidFile=$run/slurmd.pid
SlurmctldLogFile=$folder/logs/slurmctld
SlurmdLogFile=$folder/logs/slurmd
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SlurmdParameters=config_overrides
SchedulerParameters=sched_min_interval=100000,bf_interval=1
ReturnToService=2
KillWait=2
MinJobAge=600
NodeName=$host NodeAddr=127.0.0.1 CPUs=4 RealMemory=4000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$run/slurm.conf"

# What a machine does not let us start is told, not failed on: containers differ.
waits() { # WHAT SECONDS COMMAND...
    local what=$1 until=$((SECONDS + $2))
    shift 2
    until "$@"; do
        [ "$SECONDS" -lt "$until" ] || { echo "slurm.sh: no $what" >&2; tail -n 5 "$folder"/logs/* >&2; return 1; }
        sleep 0.1
    done
}
waits "munged" 10 test -S "$run/munge.sock" || skip "munged does not start here"
slurmctld -D >"$folder/logs/slurmctld.out" 2>&1 &
daemons+=($!)
slurmd -D -N "$host" >"$folder/logs/slurmd.out" 2>&1 &
daemons+=($!)
idle() { sinfo -h -o %T 2>/dev/null | grep -q '^idle$'; }
waits "idle node" 20 idle || skip "slurmctld and slurmd do not come up here"

# Long enough to be met in the middle.
recipe=tests/cluster/recipe.toml
slow=("--set=camera.size_px=[96, 96]" "--set=camera.gsd_m=0.4" "--set=sensor.samples_per_pixel=4")
"$satseed" generate "$recipe" --out "$folder/single" --quiet "${slow[@]}" >"$folder/root"

export SATSEED=$satseed
out=$folder/out
submitted=$(sbatch --parsable --array=1-4 --cpus-per-task=1 --mem=100M --chdir="$PWD" --output="$folder/logs/task-%a" \
    examples/cluster/slurm.sh "$recipe" "$out" "${slow[@]}")
state() { squeue -h -j "$submitted" -t all -O "ArrayTaskID:8,State:16" | sort -u; }
field() { scontrol show job "${submitted}_$1" | grep -o "$2=[^ ]*" | head -n 1 | cut -d= -f2; }
is_running() { [ "$(field "$1" JobState)" = RUNNING ]; }
recorded() { [ -n "$(find "$out" -name sample.json -print -quit 2>/dev/null)" ]; }

waits "sample" 60 recorded
waits "running task 2" 20 is_running 2
scontrol requeue "${submitted}_2"
waits "running task 3" 20 is_running 3
scancel --batch --signal=TERM "${submitted}_3"
finished() { ! state | grep -qvE ' (COMPLETED|FAILED|TIMEOUT|NODE_FAIL|OUT_OF_MEMORY|CANCELLED) *$'; }
waits "end of the array" 120 finished
for task in 1 2 3 4; do
    [ "$(field "$task" JobState)" = COMPLETED ] || { state; cat "$folder/logs/task-$task"; exit 1; } >&2
done
[ "$(field 2 Restarts)" = 1 ] || { echo "slurm.sh: task 2 was not requeued" >&2; exit 1; }
[ "$(field 3 Restarts)" = 1 ] || { echo "slurm.sh: task 3 was not requeued: it ended before it was told to" >&2; exit 1; }

[ ! -e "$out/manifest.jsonl" ] || { echo "slurm.sh: a shard wrote the manifest" >&2; exit 1; }
"$satseed" merge "$out" >"$folder/merged"
cmp "$folder/root" "$folder/merged"
diff -r "$folder/single" "$out"
echo "slurm.sh: array of 4, one killed and requeued, one stopped and requeued: the merged dataset is the single run's"
