#!/usr/bin/env bash
# One task of a HyperQueue job is one shard. Needs a running server (`hq server start`) with
# workers. DEMO, SEEDS, SHARDS, ROBOCELL and ROWS come from the environment; further options of
# `robocell eval` from the command line.
set -euo pipefail
rows=$(cd "${ROWS:-.}" && pwd)
shards=${SHARDS:?how many, such as 100}
demo=${DEMO:?name a demo} seeds=${SEEDS:?such as 1..1000}
# shellcheck disable=SC2016 # HQ_TASK_ID is of the task.
hq submit --wait --array "1-$shards" --cpus 1 --crash-limit 3 -- bash -c '
    exec "$0" eval "$1" --seeds "$2" --shard "$HQ_TASK_ID/$3" --out "$4/rows.$HQ_TASK_ID.jsonl" "${@:5}"' \
    "${ROBOCELL:-robocell}" "$demo" "$seeds" "$shards" "$rows" "$@"
