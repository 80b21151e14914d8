"""Puts a cube on a mark: pick it, place it, go home; and again when it is moved away."""

from robocell.task import RUNNING, SUCCESS, TaskCell, policy, skills


@policy
class CubeOnMark:
    phases = ("PICK", "PLACE", "HOME")

    def __init__(self, cell: TaskCell) -> None:
        self.phase = "HOME"
        self.skill = skills.home()

    def decide(self, cell: TaskCell) -> None:
        is_placed = "cube" in cell.placed("mark") and cell.arm.held is None
        result = cell.arm.do(self.skill)
        done = is_placed and self.phase == "HOME" and result == SUCCESS
        if result != RUNNING and not done:
            self.choose(cell, is_placed)
        cell.report(done)

    def choose(self, cell: TaskCell, is_placed: bool) -> None:
        """What is done next follows from what is seen."""
        if cell.arm.held == "cube":
            self.phase, self.skill = "PLACE", skills.place("cube", "mark")
        elif is_placed:
            self.phase, self.skill = "HOME", skills.home()
        else:
            self.phase, self.skill = "PICK", skills.pick("cube")
