"""Palletizes the bins of ur10-palletize with a machine of the package transitions: picks a
bin from the belt, turns it over on the jig if it is upside down, sets it down.

robocell run ur10-palletize --task palletize.py
"""

import numpy as np
from palletize_motions import Motions

from robocell import rotation
from robocell.task import Arm, TaskCell, policy
from robocell.task.machines import MachinePolicy

LATE_S = 15.0
STEPS = {
    "picking": ["wait_for_bin", "reach_bin", "settle", "grip", "lift"],
    "flipping": ["home", "reach_jig", "drop", "settle", "back_off", "leave_jig", "joints_home"],
    "placing": ["swing_out", "reach_slot", "settle", "drop", "settle", "lift", "home"],
}
# Steps in which a bin is held.
CARRY = {"picking": ["lift"], "flipping": ["home", "reach_jig"], "placing": STEPS["placing"][:2]}


@policy
class Palletizer(Motions, MachinePolicy):
    """A state does its steps; a step is called until it says that it has finished."""

    states = ("idle", "picking", "flipping", "placing", "done")
    initial = "idle"
    transitions = (
        {"trigger": "next", "source": "idle", "dest": "done", "conditions": "is_full"},
        {"trigger": "next", "source": "idle", "dest": "picking"},
        {"trigger": "next", "source": "picking", "dest": "flipping", "unless": "is_upright"},
        {"trigger": "next", "source": "picking", "dest": "placing"},
        {"trigger": "next", "source": "flipping", "dest": "picking"},
        {"trigger": "next", "source": "placing", "dest": "idle"},
        {"trigger": "lost", "source": list(STEPS), "dest": "idle"},
    )

    def setup(self, cell: TaskCell) -> None:
        x, y, z = (cell.task[f"slot_{axis}_m"] for axis in "xyz")
        self.slots = np.array([(a, b, z) for a in x for b in y])
        self.cell, self.bin, self.asked_s, self.sent = cell, "", 0.0, None
        self.begin(0)

    def begin(self, step: int) -> None:
        self.at, self.start, self.goal, self.since_s = step, None, None, 0.0

    def decide(self, cell: TaskCell) -> None:
        self.run_belt()
        if self.state in STEPS:
            self.work(cell.arm, STEPS[self.state])
        elif self.state == "idle":
            self.next()
        cell.report(self.state == "done", self.placed())

    def work(self, arm: Arm, steps: list[str]) -> None:
        """One decision of the step under way."""
        if self.start is None:
            self.start = self.sent or (arm.tcp_position.copy(), arm.tcp_orientation.copy())
            self.since_s = self.cell.time_s
        is_late = self.cell.time_s > self.since_s + LATE_S
        if is_lost := arm.held is None and (is_late or steps[self.at] in CARRY[self.state]):
            self.lost()
        if is_lost or is_late:
            self.begin(0)
        elif getattr(self, steps[self.at])(arm):
            is_last = self.at + 1 == len(steps)
            self.begin(0 if is_last else self.at + 1)
            if is_last:
                self.next()

    def up(self, name: str) -> float:
        """1 for a bin that opens upwards, -1 for one that opens downwards."""
        return float(rotation.matrix(self.cell.objects[name].orientation)[2, 2])

    def is_upright(self) -> bool:
        return self.up(self.bin) > 0.0

    def is_full(self) -> bool:
        return len(self.placed()) == len(self.slots)

    def placed(self) -> list[str]:
        """The bins in slots."""
        return [o.name for o in self.present() if self.slot_of(o.position) and self.up(o.name) > 0]

    def slot_of(self, position) -> bool:
        return bool(np.min(np.linalg.norm(self.slots - position, axis=1)) < 0.02)

    def present(self) -> list:
        """The bins in the cell that the arm does not hold."""
        held = self.cell.arm.held
        return [o for o in self.cell.objects.values() if o.is_present and o.name != held]

    def run_belt(self) -> None:
        """The belt stops when a bin is at its end; another one is asked for."""
        ys = [y for x, y, _ in (o.position for o in self.present()) if abs(x) < 0.4 and y > 0.05]
        self.cell.conveyor(all(y > self.cell.task["belt_stop_y_m"] for y in ys))
        if not ys and self.cell.time_s > self.asked_s + 2.0:
            self.asked_s = self.cell.time_s
            self.cell.add_bin()

    def wait_for_bin(self, arm: Arm) -> bool:
        arm.grip("open")
        free = [o for o in self.present() if not self.slot_of(o.position) and o.position[1] < 0.9]
        still = [o for o in free if np.linalg.norm(o.velocity) < 0.02]
        if not still:
            self.since_s = self.cell.time_s
            return False
        # One on the jig comes first.
        self.bin = max(still, key=lambda one: one.position[0]).name
        return self.cell.time_s > self.since_s + 1.0

    def grip(self, arm: Arm) -> bool:
        arm.grip("close")
        return arm.held == self.bin

    def drop(self, arm: Arm) -> bool:
        arm.grip("open")
        return arm.held is None
