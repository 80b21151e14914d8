"""Steps a scene in MuJoCo and says how long each step took (ns).

Standard input: the length of the scene's text in bytes as a line, that text,
then requests, a line each. Output: the version as a line, then a line for each
request. A number of steps, with the controls of each step one after the other
or without any, is answered by their times; `blocks COUNT STEPS` by the times of
so many blocks of steps, each one call; `height BODY` by its z (m).
"""
import sys
import time

import mujoco
import numpy


def block(steps):
    """The time of so many steps in one call (ns)."""
    began = time.perf_counter_ns()
    mujoco.mj_step(model, data, nstep=steps)
    return time.perf_counter_ns() - began


text = sys.stdin.buffer.read(int(sys.stdin.buffer.readline()))
model = mujoco.MjModel.from_xml_string(text.decode())
data = mujoco.MjData(model)
print(mujoco.__version__, flush=True)
while words := sys.stdin.readline().split():
    if words[0] == "height":
        mujoco.mj_kinematics(model, data)
        print(data.body(words[1]).xpos[2], flush=True)
        continue
    if words[0] == "blocks":
        print(*(block(int(words[2])) for _ in range(int(words[1]))), flush=True)
        continue
    steps = int(words[0])
    controls = numpy.array(words[1:], float).reshape(steps, -1)
    times = []
    for control in controls:
        if control.size:
            data.ctrl[:] = control
        began = time.perf_counter_ns()
        mujoco.mj_step(model, data)
        times.append(time.perf_counter_ns() - began)
    print(*times, flush=True)
