"""Stacks the cubes of franka-stack in plain if/else: what is done next follows from
what is seen now, so the policy needs no memory and no checkpoint.

    robocell run franka-stack --task pick_place_ifelse.py
"""

import numpy as np

from robocell.task import TaskCell, policy

HOVER_M = 0.12
NEAR_M = 0.02
AT_M = 0.006


@policy
def stack(cell: TaskCell, memory) -> None:
    arm = cell.arm
    order = cell.task["order"]
    goals = [goal_of(cell, layer) for layer in range(len(order))]
    placed = []
    for name, goal in zip(order, goals):
        if arm.held == name or not is_at(cell, name, goal):
            break
        placed.append(name)
    cell.report(len(placed) == len(order) and arm.is_open, placed)

    if len(placed) == len(order):
        memory.phase = "DONE"
        if arm.tcp_position[2] < goals[-1][2] + HOVER_M - NEAR_M:
            release(arm, goals[-1])
        return
    name, goal = order[len(placed)], goals[len(placed)]
    if arm.held is None:
        pick(arm, cell, name, memory)
    elif arm.held == name:
        place(arm, goal, memory)
    else:
        memory.phase = "DROP"
        arm.grip("open")


def pick(arm, cell, name, memory):
    """Above the cube, down, close."""
    grip = arm.grip_pose(name)
    if grip is None:
        return
    position, orientation = grip
    off = np.linalg.norm((arm.tcp_position - position)[:2])
    height = arm.tcp_position[2] - position[2]
    if off < AT_M and abs(height) < AT_M:
        memory.phase = "CLOSE"
        arm.send(position, orientation, gripper="close", ignore=[name])
    elif off < NEAR_M and arm.is_open:
        memory.phase = "DOWN"
        arm.send(position, orientation, gripper="open", ignore=[name])
    else:
        memory.phase = "ABOVE"
        lift = height < HOVER_M / 2 and off > NEAR_M
        above = arm.tcp_position if lift else position
        target = (above[0], above[1], max(position[2], arm.tcp_position[2] if lift else 0) + HOVER_M)
        arm.send(target, orientation, gripper="open")


def place(arm, goal, memory):
    """Up, across, down, open."""
    off = np.linalg.norm((arm.tcp_position - goal)[:2])
    if off < AT_M and arm.tcp_position[2] - goal[2] < AT_M:
        memory.phase = "OPEN"
        arm.grip("open")
    elif off < AT_M * 2:
        memory.phase = "LOWER"
        arm.send(goal, gripper="close")
    elif arm.tcp_position[2] < goal[2] + HOVER_M - NEAR_M:
        memory.phase = "LIFT"
        x, y, _ = arm.tcp_position
        arm.send((x, y, goal[2] + HOVER_M), gripper="close")
    else:
        memory.phase = "CARRY"
        arm.send((goal[0], goal[1], goal[2] + HOVER_M), gripper="close")


def release(arm, goal):
    """Away from the last cube."""
    arm.send((goal[0], goal[1], goal[2] + HOVER_M), gripper="open")


def goal_of(cell, layer):
    """Where the cube of a layer belongs."""
    x, y = cell.task["stack_position_m"]
    z = cell.task["base_height_m"] + layer * cell.task["layer_height_m"]
    return np.array([x, y, z])


def is_at(cell, name, goal):
    cube = cell.objects[name]
    off = cube.position - goal
    return bool(np.linalg.norm(off[:2]) < cell.task["goal_tolerance_m"] and abs(off[2]) < 0.01)
