"""Palletizes the bins of ur10-palletize with a state machine of the package transitions:
picks a bin from the belt, turns it over on the jig if it is upside down, sets it down.

robocell run ur10-palletize --task palletize.py
"""

import numpy as np

from robocell import rotation
from robocell.task import Arm, TaskCell, policy
from robocell.task.machines import MachinePolicy

AT_BELT = [-1.2654, -2.9708, -2.2197, 0.6446, 1.5186, 0.3010]  # joints to stay near (rad)
AT_JIG = [-2.1273, -3.0046, -1.0576, -0.5194, -1.0809, 2.0418]
HALF_M, FLOOR_M, GAP_M = 0.0675, 0.005, 0.002  # half a bin's height, its floor, cup to bin
LATE_S = 15.0
STEPS = {
    "picking": ["wait_for_bin", "reach_bin", "settle", "grip", "lift"],
    "flipping": ["home", "reach_jig", "drop", "settle", "back_off", "leave_jig", "joints_home"],
    "placing": ["swing_out", "reach_slot", "settle", "drop", "settle", "lift", "home"],
}
CARRY = ("reach_jig", "swing_out", "reach_slot")


@policy
class Palletizer(MachinePolicy):
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
        self.cell, self.bin, self.asked_s = cell, "", 0.0
        self.begin(0)

    def begin(self, step: int) -> None:
        """A step; each has its start and its goal, and is late after LATE_S."""
        self.at, self.start, self.goal, self.since_s = step, None, None, 0.0

    def decide(self, cell: TaskCell) -> None:
        self.run_belt()
        if self.state in STEPS:
            self.work(cell.arm, STEPS[self.state])
        elif self.state == "idle":
            self.bin = ""
            self.next()
        cell.report(self.state == "done", self.placed())

    def work(self, arm: Arm, steps: list[str]) -> None:
        """One decision of the step under way."""
        if self.start is None:
            self.start = arm.tcp_position.copy(), arm.tcp_orientation.copy()
            self.since_s = self.cell.time_s
        is_late = self.cell.time_s > self.since_s + LATE_S
        if (is_late or steps[self.at] in CARRY) and arm.held is None:
            self.lost()
            self.begin(0)
        elif is_late:
            self.begin(0)
        elif getattr(self, steps[self.at])(arm):
            is_last = self.at + 1 == len(steps)
            self.begin(0 if is_last else self.at + 1)
            if is_last:
                self.next()

    # What is seen.

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

    def slot_of(self, position: np.ndarray) -> bool:
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

    # Steps: each is called in every decision until it says that it has finished.

    def wait_for_bin(self, arm: Arm) -> bool:
        free = [o for o in self.present() if not self.slot_of(o.position)]
        still = [o for o in free if np.linalg.norm(o.velocity) < 0.02 and o.position[1] < 0.9]
        if not still:
            self.since_s = self.cell.time_s
            return False
        # One on the jig comes first.
        self.bin = max(still, key=lambda one: one.position[0]).name
        return self.cell.time_s > self.since_s + 1.0

    def reach_bin(self, arm: Arm) -> bool:
        one = self.cell.objects[self.bin]
        axes, up = rotation.matrix(one.orientation), np.sign(self.up(self.bin))
        # The floor: from inside where the bin opens upwards, else from outside.
        height = FLOOR_M + GAP_M - HALF_M if up > 0 else -HALF_M - GAP_M
        down = -up * axes[:, 2]
        goal = one.position + height * axes[:, 2], self.tool(down, axes[:, 0], up)
        return self.go(arm, goal, 0.005, approach=0.3 * down, width=0.005, posture=AT_BELT)

    def tool(self, down: np.ndarray, long: np.ndarray, up: float) -> np.ndarray:
        """The orientation with the cup along ``down`` that is nearest to the present one.
        The long side of a bin to be turned over has to be level on the jig."""
        jig = rotation.matrix(self.cell.task["jig"]["orientation_wxyz"])
        level = jig.T @ np.cross((0, 0, 1), jig[:, 0]) if up < 0 else np.array([0.0, 1.0, 0.0])
        across, x = level / np.linalg.norm(level), np.array([1.0, 0.0, 0.0])
        own = np.column_stack([x, across, np.cross(x, across)])
        short = np.cross(down, long)
        sides = [long, -long] if up < 0 else [long, -long, short, -short]
        world = [np.column_stack([down, side, np.cross(down, side)]) for side in sides]
        return self.nearest([rotation.of_matrix(axes @ own.T) for axes in world])

    def nearest(self, turns: list[np.ndarray]) -> np.ndarray:
        now = self.cell.arm.tcp_orientation
        return min(turns, key=lambda turn: rotation.angle_between(turn, now))

    def settle(self, arm: Arm) -> bool:
        return self.cell.time_s > self.since_s + 0.5

    def grip(self, arm: Arm) -> bool:
        arm.grip("close")
        return arm.held == self.bin

    def drop(self, arm: Arm) -> bool:
        arm.grip("open")
        return arm.held is None

    def lift(self, arm: Arm) -> bool:
        height = 0.5 if self.state == "picking" and self.is_upright() else 0.28
        risen = arm.tcp_position[2] - self.start[0][2]
        goal = self.start[0] + (0, 0, min(height, max(0.0, risen) + 0.1)), self.start[1]
        self.go(arm, goal, 0.02, posture=AT_BELT if self.state == "picking" else arm.home)
        return risen > height - 0.03

    def home(self, arm: Arm) -> bool:
        goal = arm.home_position, arm.home_orientation
        return self.go(arm, goal, 0.02, approach=(0.0, -0.0894, -0.1789), width=0.05)

    def joints_home(self, arm: Arm) -> bool:
        arm.send_joints(arm.home)
        return bool(np.max(np.abs(arm.joint_positions - arm.home)) < 0.05)

    def reach_jig(self, arm: Arm) -> bool:
        jig, way = self.cell.task["jig"], (0.224, -0.228, -0.24)
        goal = np.array(jig["position_m"]), np.array(jig["orientation_wxyz"])
        return self.go(arm, goal, 0.005, approach=way, width=0.05, posture=AT_JIG)

    def back_off(self, arm: Arm) -> bool:
        way = -0.3 * rotation.rotate(self.start[1], (1, 0, 0)) + (-0.035, 0.036, 0.0)
        goal = self.start[0] + way, self.start[1]
        return self.go(arm, goal, 0.15, approach=way, width=0.1, posture=AT_JIG)

    def leave_jig(self, arm: Arm) -> bool:
        return self.go(arm, (np.array([0.40, 0.93, 0.25]), self.start[1]), 0.1, posture=AT_JIG)

    def swing_out(self, arm: Arm) -> bool:
        """Half way around the arm's base, turned already as at the slot."""
        self.goal = self.goal or self.at_slot(arm)
        return self.go(arm, (np.array([0.62, 0.40, 0.35]), self.goal[1]), 0.15)

    def reach_slot(self, arm: Arm) -> bool:
        self.goal = self.goal or self.at_slot(arm)
        return self.go(arm, self.goal, 0.007, approach=(0.0, 0.0, -0.35), width=0.005)

    def at_slot(self, arm: Arm) -> tuple[np.ndarray, np.ndarray]:
        """The TCP with the bin in the first free slot, held as it is now."""
        taken = np.array([o.position for o in self.present()]).reshape(-1, 1, 3)
        is_free = np.all(np.linalg.norm(self.slots - taken, axis=2) > 0.1, axis=0)
        slot = self.slots[int(np.argmax(is_free))]
        one = self.cell.objects[self.bin]
        back = rotation.inverse(one.orientation)
        grip = rotation.product(back, arm.tcp_orientation)
        quarters = [rotation.about((0, 0, 1), angle) for angle in (np.pi / 2, -np.pi / 2)]
        turn = self.nearest([rotation.product(quarter, grip) for quarter in quarters])
        bin_ = rotation.product(turn, rotation.inverse(grip))
        offset = rotation.rotate(back, arm.tcp_position - one.position)
        return slot + rotation.rotate(bin_, offset) + (0, 0, GAP_M), turn

    def go(
        self, arm: Arm, goal: tuple, near: float, *, approach=(0, 0, 0), width=0.0, posture=None
    ):
        """Sends the arm to a pose; whether it is there."""
        position, orientation = goal
        arm.send(
            position,
            orientation,
            approach=approach,
            approach_std_dev=width,
            guides=self.guides(arm.tcp_position, position),
            posture=arm.home if posture is None else posture,
        )
        is_turned = rotation.angle_between(orientation, arm.tcp_orientation) < 0.05
        return arm.distance_to(position) < near and (is_turned or near > 0.02)

    def guides(self, tool: np.ndarray, target: np.ndarray) -> list[str]:
        """Fixtures that keep the arm on its way around the base, and off the jig."""
        jig, (x, y) = self.cell.task["jig"], self.cell.task["side_m"]
        ends = (tool, target)
        low = [at for at in ends if at[2] < jig["below_z_m"]]
        at_jig = any(np.hypot(*(at[:2] - jig["middle_m"])) < jig["radius_m"] for at in low)
        guides = {"navigation_dome", "navigation_barrier", "flip_sphere", "flip_barrier"}
        if self.state == "flipping" or at_jig:
            guides -= {"flip_sphere", "flip_barrier"}
        # The two sides of the line from the base through a point.
        if len({bool(x * at[1] > y * at[0]) for at in ends}) == 1:
            guides -= {"navigation_dome", "navigation_barrier", "flip_barrier"}
        return sorted(guides)
