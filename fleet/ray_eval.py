"""One task of Ray is one shard: ray_eval.py DEMO SEEDS SHARDS [OPTION..]

The rows go to the working directory, which all nodes share; ROBOCELL names the program."""

import os
import subprocess
import sys

import ray


@ray.remote(num_cpus=1, max_retries=3, retry_exceptions=True)
def shard(command: list[str], directory: str) -> None:
    subprocess.run(command, cwd=directory, check=True)


def main() -> None:
    demo, seeds, shards, *options = sys.argv[1:]
    program = os.environ.get("ROBOCELL", "robocell")
    ray.init()
    tasks = [
        shard.remote(
            [program, "eval", demo, "--seeds", seeds, "--shard", f"{i}/{shards}"]
            + ["--out", f"rows.{i}.jsonl", *options],
            os.getcwd(),
        )
        for i in range(1, int(shards) + 1)
    ]
    ray.get(tasks)


if __name__ == "__main__":
    main()
