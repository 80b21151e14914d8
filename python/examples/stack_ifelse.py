"""Stacks the cubes of franka-stack in plain if/else, without skills: the next action
follows from the present observation, so the policy needs no memory.

    robocell run franka-stack --task stack_ifelse.py
"""

import numpy as np

from robocell.task import Arm, TaskCell, policy

TRAVEL_Z_M = 0.32
NEAR_M = 0.02
AT_M = 0.006


@policy
class Stack:
    phases = ("LIFT", "TRAVEL", "DOWN", "CLOSE", "OPEN", "LEAVE")
    phase = "LEAVE"

    def decide(self, cell: TaskCell) -> None:
        arm, order = cell.arm, cell.task["order"]
        goals = [goal_of(cell, layer) for layer in range(len(order))]
        placed = []
        for name, goal in zip(order, goals, strict=True):
            if arm.held == name or not is_at(cell, name, goal):
                break
            placed.append(name)
        has_left = arm.tcp_position[2] > TRAVEL_Z_M - NEAR_M
        cell.report(len(placed) == len(order) and has_left, placed)
        if len(placed) == len(order):
            self.phase = self.leave(arm)
        elif arm.held in (None, order[len(placed)]):
            self.phase = self.work(cell, arm, order[len(placed)], goals[len(placed)])
        else:
            arm.grip("open")
            self.phase = "OPEN"

    def work(self, cell: TaskCell, arm: Arm, name: str, goal: np.ndarray) -> str:
        """Fetches a cube, or brings it to its goal."""
        holds = arm.held == name
        grip = (goal, arm.down()) if holds else arm.grip_pose(name)
        if grip is None:
            return "LEAVE"
        position, orientation = grip
        gripper = "close" if holds else "open"
        off = np.linalg.norm((arm.tcp_position - position)[:2])
        above = arm.tcp_position[2] - position[2]
        # Fingers that close or open may move the tool a little.
        at = AT_M if arm.is_open or holds else 2 * AT_M
        if off > NEAR_M and arm.tcp_position[2] < TRAVEL_Z_M - NEAR_M:
            x, y, _ = arm.tcp_position
            arm.send((x, y, TRAVEL_Z_M), arm.tcp_orientation, gripper=gripper)
            return "LIFT"
        if off > NEAR_M or (above > at and not (holds or arm.is_open)):
            arm.send((position[0], position[1], TRAVEL_Z_M), orientation, gripper=gripper)
            return "TRAVEL"
        if off > at or above > at:
            arm.send(position, orientation, gripper=gripper, ignore=[name])
            return "DOWN"
        arm.send(position, orientation, gripper="open" if holds else "close", ignore=[name])
        return "OPEN" if holds else "CLOSE"

    def leave(self, arm: Arm) -> str:
        """Straight up from the finished stack."""
        x, y, _ = arm.tcp_position
        arm.send((x, y, TRAVEL_Z_M + NEAR_M), arm.tcp_orientation, gripper="open")
        return "LEAVE"


def goal_of(cell: TaskCell, layer: int) -> np.ndarray:
    """Where the centre of the cube of a layer belongs."""
    x, y = cell.task["stack_position_m"]
    z = cell.task["base_height_m"] + layer * cell.task["layer_height_m"]
    return np.array([x, y, z])


def is_at(cell: TaskCell, name: str, goal: np.ndarray) -> bool:
    """Whether a cube is in its place."""
    off = cell.objects[name].position - goal
    return bool(np.linalg.norm(off[:2]) < cell.task["goal_tolerance_m"] and abs(off[2]) < 0.01)
