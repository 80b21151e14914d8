"""Stacks the cubes of franka-stack with a state machine of the package transitions.

robocell run franka-stack --task stack_fsm.py
robocell fsm show --live
"""

from robocell.task import FAILURE, RUNNING, TaskCell, policy, skills
from robocell.task.machines import MachinePolicy

CLEARANCE_M = 0.15


@policy
class StackMachine(MachinePolicy):
    """Pick, place, and once more while a cube is missing."""

    states = ("CHOOSE", "PICK", "PLACE", "HOME", "DONE")
    initial = "CHOOSE"
    transitions = (
        {"trigger": "chosen", "source": "CHOOSE", "dest": "PLACE", "conditions": "is_holding"},
        {"trigger": "chosen", "source": "CHOOSE", "dest": "PICK", "conditions": "is_missing"},
        {"trigger": "chosen", "source": "CHOOSE", "dest": "HOME"},
        {"trigger": "picked", "source": "PICK", "dest": "PLACE"},
        {"trigger": "placed", "source": "PLACE", "dest": "CHOOSE"},
        {"trigger": "failed", "source": ["PICK", "PLACE"], "dest": "CHOOSE"},
        {"trigger": "arrived", "source": "HOME", "dest": "DONE"},
        {"trigger": "disturbed", "source": ["HOME", "DONE"], "dest": "CHOOSE"},
    )

    def setup(self, cell: TaskCell) -> None:
        self.order = cell.task["order"]
        x, y = cell.task["stack_position_m"]
        height = cell.task["layer_height_m"]
        cell.add_place("stack", (x, y, 0.0), layers=len(self.order), layer_height=height)
        self.cell = cell
        self.skill = skills.home()

    def is_holding(self) -> bool:
        return self.cell.arm.held is not None

    def missing(self) -> list[str]:
        return [name for name in self.order if name not in self.cell.placed("stack")]

    def is_missing(self) -> bool:
        return bool(self.missing())

    def on_enter_PICK(self) -> None:
        self.skill = skills.pick(self.missing()[0], clearance_m=CLEARANCE_M)

    def on_enter_PLACE(self) -> None:
        self.skill = skills.place(self.cell.arm.held, "stack", clearance_m=CLEARANCE_M)

    def on_enter_HOME(self) -> None:
        self.skill = skills.home()

    def decide(self, cell: TaskCell) -> None:
        if self.state == "CHOOSE":
            self.chosen()
        if self.state in ("HOME", "DONE") and self.is_missing():
            self.disturbed()
        elif self.state != "DONE":
            self.work(cell)
        cell.report(self.state == "DONE", cell.placed("stack"))

    def work(self, cell: TaskCell) -> None:
        """One decision of the skill of the state."""
        result = cell.arm.do(self.skill)
        if result == RUNNING:
            return
        if self.state == "HOME":
            self.arrived()
        elif result == FAILURE:
            self.failed()
        elif self.state == "PICK":
            self.picked()
        else:
            self.placed()
