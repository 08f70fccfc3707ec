#!/bin/bash
# One shard a task: sbatch [--array=1-N] slurm.sh RECIPE OUT [more options of `satseed generate`]
# OUT is a folder that all nodes see, or s3://, gs://, az://. Afterwards, once: satseed merge OUT
#SBATCH --job-name=satseed
#SBATCH --array=1-64
#SBATCH --cpus-per-task=8
#SBATCH --mem=8G
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:TERM@120

# TERM comes two minutes before the time is over, and when the task has to make room: satseed then ends at the next
# sample's border with 75, and the task goes back into the queue. What stands is kept.
"${SATSEED:-satseed}" generate "$1" --out "$2" --shard auto --jobs "${SLURM_CPUS_PER_TASK:-1}" "${@:3}" &
child=$!
trap 'kill -TERM "$child" 2>/dev/null' TERM
# A signal ends a wait before the child does, so it is waited for until it is gone, and then asked how it ended.
while wait "$child"; kill -0 "$child" 2>/dev/null; do :; done
wait "$child"
status=$?

if [ "$status" = 75 ]; then
    exec scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}"
fi
exit "$status"
