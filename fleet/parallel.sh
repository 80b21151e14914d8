#!/usr/bin/env bash
# One job of GNU parallel is one shard. DEMO, SEEDS, SHARDS, ROBOCELL and ROWS come from the
# environment; options of `parallel`, such as --sshloginfile, from the command line.
set -euo pipefail
rows=$(cd "${ROWS:-.}" && pwd)
shards=${SHARDS:?how many, such as 100}
demo=${DEMO:?name a demo} seeds=${SEEDS:?such as 1..1000}
seq "$shards" | parallel --retries 3 --bar "$@" \
    "${ROBOCELL:-robocell} eval $demo --seeds $seeds --shard {}/$shards --out $rows/rows.{}.jsonl"
