"""One task of Dask is one shard: dask_eval.py DEMO SEEDS SHARDS [SCHEDULER]

Without the address of a scheduler it starts a cluster on this machine. The rows go to the
working directory, which all workers share; ROBOCELL names the program."""

import os
import subprocess
import sys

from dask.distributed import Client


def shard(command: list[str], directory: str) -> None:
    subprocess.run(command, cwd=directory, check=True)


def main() -> None:
    demo, seeds, shards, *scheduler = sys.argv[1:]
    program = os.environ.get("ROBOCELL", "robocell")
    client = Client(*scheduler) if scheduler else Client(threads_per_worker=1)
    commands = [
        [program, "eval", demo, "--seeds", seeds, "--shard", f"{i}/{shards}"]
        + ["--out", f"rows.{i}.jsonl"]
        for i in range(1, int(shards) + 1)
    ]
    directory = os.getcwd()
    tasks = [client.submit(shard, c, directory, pure=False, retries=3) for c in commands]
    client.gather(tasks)


if __name__ == "__main__":
    main()
