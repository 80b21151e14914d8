"""Stacks the cubes of franka-stack with the skills pick and place.

robocell run franka-stack --task stack_skills.py
"""

from robocell.task import FAILURE, SUCCESS, TaskCell, policy, skills

CLEARANCE_M = 0.15


@policy
class Stack:
    """Places one cube after the other; a cube that left the stack is picked again."""

    phases = ("PICK", "PLACE", "HOME")

    def __init__(self, cell: TaskCell) -> None:
        self.order = cell.task["order"]
        x, y = cell.task["stack_position_m"]
        height = cell.task["layer_height_m"]
        cell.add_place("stack", (x, y, 0.0), layers=len(self.order), layer_height=height)
        self.phase = "HOME"
        self.cube: str | None = None
        self.skill = skills.home()

    def decide(self, cell: TaskCell) -> None:
        placed = cell.placed("stack")
        result = cell.arm.do(self.skill)
        done = len(placed) == len(self.order) and self.phase == "HOME" and result == SUCCESS
        if result in (SUCCESS, FAILURE) and not done:
            self.choose(cell, placed, failed=result == FAILURE)
        cell.report(done, placed)

    def choose(self, cell: TaskCell, placed: list[str], failed: bool) -> None:
        """The next skill: place the held cube, pick the next one, or move home."""
        held = cell.arm.held
        missing = [name for name in self.order if name not in placed]
        if held is not None and not (failed and self.phase == "PLACE"):
            self.cube, self.phase = held, "PLACE"
            self.skill = skills.place(held, "stack", clearance_m=CLEARANCE_M)
        elif missing:
            self.cube, self.phase = missing[0], "PICK"
            self.skill = skills.pick(missing[0], clearance_m=CLEARANCE_M)
        else:
            self.cube, self.phase = None, "HOME"
            self.skill = skills.home()
