"""The motions of palletize.py: where the cup goes, and on which way."""

import numpy as np

from robocell import rotation
from robocell.task import Arm

AT_BELT = [-1.2654, -2.9708, -2.2197, 0.6446, 1.5186, 0.3010]  # joints to stay near (rad)
AT_JIG = [-2.1273, -3.0046, -1.0576, -0.5194, -1.0809, 2.0418]
HALF_M, FLOOR_M, GAP_M = 0.0675, 0.005, 0.002  # half a bin's height, its floor, cup to bin
LEAD_M = 0.08  # a target that rises is so far before the tool


class Motions:
    """Steps that move the arm with the bin ``self.bin`` of ``self.cell``; ``self.start`` is the
    pose the arm was sent to before the step."""

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

    def lift(self, arm: Arm) -> bool:
        height = 0.5 if self.state == "picking" and self.is_upright() else 0.28
        risen = arm.tcp_position[2] - self.start[0][2]
        goal = self.start[0] + (0, 0, min(height, max(0.0, risen) + LEAD_M)), self.start[1]
        self.go(arm, goal, 0.02, posture=AT_BELT if self.state == "picking" else arm.home)
        return risen > height - 0.03

    def home(self, arm: Arm) -> bool:
        goal = arm.home_position, arm.home_orientation
        return self.go(arm, goal, 0.02, approach=(0.0, -0.0894, -0.1789), width=0.05)

    def joints_home(self, arm: Arm) -> bool:
        arm.send_joints(arm.home)
        return arm.is_home

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

    def go(self, arm, goal, near, *, approach=(0, 0, 0), width=0.0, posture=None) -> bool:
        """Sends the arm to a pose; whether it is there."""
        position, orientation = self.sent = goal
        guides = self.guides(arm.tcp_position, position)
        corridor = {"approach": approach, "approach_std_dev": width, "guides": guides}
        arm.send(
            position, orientation, posture=arm.home if posture is None else posture, **corridor
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
