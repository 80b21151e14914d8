"""Steps a cell of robocell and says how long each step took (ns).

Standard input: the length of a demo's name in bytes as a line, that name, then lines
with a number of steps. Output: the version, then the times of each line's steps as a
line.
"""
import sys
import time

import robocell

name = sys.stdin.buffer.read(int(sys.stdin.buffer.readline())).decode()
cell = robocell.Cell(name)
print(robocell.__version__, flush=True)
while line := sys.stdin.buffer.readline():
    times = []
    for _ in range(int(line)):
        began = time.perf_counter_ns()
        cell.step()
        times.append(time.perf_counter_ns() - began)
    print(*times, flush=True)
