#!/usr/bin/env bash
#SBATCH --job-name=robocell-eval
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --requeue
#SBATCH --open-mode=append
# One array task is one shard: sbatch --array=1-N fleet/slurm.sh. DEMO, SEEDS, ROBOCELL (the
# program) and ROWS (a shared directory) come from the environment; further options of
# `robocell eval` from the command line.
set -uo pipefail
shard="$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
rows=${ROWS:-.}
"${ROBOCELL:-robocell}" eval "${DEMO:?name a demo}" --seeds "${SEEDS:?such as 1..1000}" \
    --shard "$shard" --out "$rows/rows.$SLURM_ARRAY_TASK_ID.jsonl" "$@"
code=$?
# Killed on a node that lives: SLURM requeues for lost nodes alone. 3 is a mistake of the
# command, which would be made again.
if [ "$code" -gt 100 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 3 ]; then
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
