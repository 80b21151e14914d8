"""A machine to derive those of tests from."""

from __future__ import annotations

from typing import Any

import robocell
from robocell.task import TaskCell
from robocell.task.machines import MachinePolicy


class Base(MachinePolicy):
    """Fires the triggers of its list, one in each decision."""

    states: Any = ("a", "b", "c")
    initial: Any = "a"
    transitions: Any = (["go", "a", "b"], ["next", "b", "c"], ["back", "c", "a"])
    fires: Any = ("go",)

    def setup(self, cell: TaskCell) -> None:
        self.count = 0
        self.seen: list[Any] = []

    def wait(self) -> None:
        pass

    def decide(self, cell: TaskCell) -> None:
        if self.count < len(self.fires):
            getattr(self, self.fires[self.count])()
        self.count += 1


def make(policy: Any, decisions: int = 1) -> robocell.Cell:
    cell = robocell.Cell("franka-stack", 1, policy=policy)
    # The first decision belongs to the first state.
    cell.step(10 * (decisions - 1))
    return cell
