"""One task of HyperQueue is one shard: hyperqueue_eval.py DEMO SEEDS SHARDS [SERVER_DIR]

Without the directory of a server it starts a cluster on this machine, with a worker for each
core. The rows go to the working directory, which all workers share; ROBOCELL names the program.
"""

import os
import sys
from contextlib import ExitStack

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.cluster import WorkerConfig

# HyperQueue starts a task again that lost its worker, but not one whose process was killed.
RETRY = 'for try in 1 2 3; do "$@" && exit 0; done; exit 1'


def main() -> None:
    demo, seeds, shards, *server = sys.argv[1:]
    program = os.environ.get("ROBOCELL", "robocell")
    job = Job()
    for i in range(1, int(shards) + 1):
        command = [program, "eval", demo, "--seeds", seeds, "--shard", f"{i}/{shards}"]
        command += ["--out", f"rows.{i}.jsonl"]
        job.program(["bash", "-c", RETRY, "shard", *command], cwd=os.getcwd())
    with ExitStack() as stack:
        if server:
            client = Client(server[0])
        else:
            cluster = stack.enter_context(LocalCluster())
            for _ in range(os.cpu_count() or 1):
                cluster.start_worker(WorkerConfig(cores=1))
            client = cluster.client()
        client.wait_for_jobs([client.submit(job)])


if __name__ == "__main__":
    main()
