"""Steps a scene in MuJoCo and says how long each step took (ns).

Standard input: the length of the scene's text in bytes as a line, that text,
then lines with a number of steps. Output: the version, then the times of each
line's steps as a line.
"""
import sys
import time

import mujoco

text = sys.stdin.buffer.read(int(sys.stdin.buffer.readline()))
model = mujoco.MjModel.from_xml_string(text.decode())
data = mujoco.MjData(model)
print(mujoco.__version__, flush=True)
while line := sys.stdin.buffer.readline():
    times = []
    for _ in range(int(line)):
        began = time.perf_counter_ns()
        mujoco.mj_step(model, data)
        times.append(time.perf_counter_ns() - began)
    print(*times, flush=True)
