"""Progress of the job of each demo, as the numbers that a reward is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from robocell import rotation
from robocell._sim import Cell
from robocell._view import Arm, Object

Array = npt.NDArray[np.float64]

#: An object that moves faster has not been put down (m/s).
_AT_REST_M_S = 0.05
#: Distances of this size count half for the share of a transfer (m).
_SCALE_M = 0.3


@dataclass
class Line:
    """Slots that one arm fills in their order."""

    arm: Arm
    slots: list[Array]
    #: By slot the object that belongs there; ``None`` for any.
    order: Sequence[Object] | None
    #: In the plane and in height (m).
    tolerance: tuple[float, float]
    #: The z axis of an object has to point up (1), down (-1), or anywhere (0).
    up: int = 0


class Job:
    """The job of a demo: objects that have to be in slots."""

    #: What there is to do.
    sentence = ""
    #: Numbers of the observation besides those of arms and objects.
    extras = 0

    def __init__(self, cell: Cell, rng: np.random.Generator) -> None:
        self.cell = cell
        self.seen = list(cell.objects.values())
        self.lines = self._lines()
        self.total = sum(len(line.slots) for line in self.lines)

    def _lines(self) -> list[Line]:
        return []

    def tend(self) -> None:
        """Actions of the equipment of the cell, before each step."""

    def extra(self) -> list[float]:
        """The numbers of :attr:`extras`."""
        return []

    def progress(self) -> tuple[int, float]:
        """How many slots are filled, and how far the transfers under way are, 0 to 1
        each."""
        filled, share = 0, 0.0
        taken = [o for line in self.lines for o in self._filled(line)]
        for line in self.lines:
            count = len(self._filled(line))
            filled += count
            if count < len(line.slots):
                share += self._share(line, count, taken)
        return filled, share

    def is_over(self) -> bool:
        """Whether the job has ended without all slots filled."""
        return False

    def _filled(self, line: Line) -> list[Object]:
        objects: list[Object] = []
        for index, slot in enumerate(line.slots):
            among = self.seen if line.order is None else [line.order[index]]
            found = [one for one in among if self._is_in(line, one, slot)]
            if not found:
                break
            objects.append(found[0])
        return objects

    def _is_in(self, line: Line, one: Object, slot: Array) -> bool:
        if not one.is_present:
            return False
        off = one.position - slot
        if np.hypot(off[0], off[1]) > line.tolerance[0] or abs(off[2]) > line.tolerance[1]:
            return False
        if line.up and line.up * upward(one) < 0.9:
            return False
        is_held = any(arm.held == one.name for arm in self.cell.arms)
        return not is_held and float(np.linalg.norm(one.velocity)) < _AT_REST_M_S

    def _share(self, line: Line, count: int, taken: list[Object]) -> float:
        slot, tcp = line.slots[count], line.arm.tcp_position
        names = [one.name for one in taken]
        among = self.seen if line.order is None else [line.order[count]]
        free = [one for one in among if one.is_present and one.name not in names]
        held = line.arm.held
        carried = [one for one in free if one.name == held]
        if carried:
            return 0.5 + 0.5 * nearness(carried[0].position - slot)
        if held is not None or not free:
            return 0.0
        return 0.4 * max(nearness(one.position - tcp) for one in free)


def nearness(off: Array) -> float:
    """1 at no distance, 0 far away."""
    return float(1.0 - np.tanh(np.linalg.norm(off) / _SCALE_M))


def upward(one: Object) -> float:
    """The height of the tip of an object's z axis of length 1."""
    _, x, y, _ = one.orientation
    return float(1.0 - 2.0 * (x * x + y * y))


class Stack(Job):
    """franka-stack: four cubes in the order of the task."""

    sentence = "Stack the red, yellow, green and blue cube."

    def _lines(self) -> list[Line]:
        task, objects = self.cell.task, self.cell.objects
        x, y = task["stack_position_m"]
        order = [objects[name] for name in task["order"]]
        slots = [
            np.array([x, y, task["base_height_m"] + layer * task["layer_height_m"]])
            for layer in range(len(order))
        ]
        return [Line(self.cell.arm, slots, order, (task["goal_tolerance_m"], 0.01))]


class OneCube(Job):
    """cube: one cube to its mark."""

    sentence = "Put the cube on the mark."

    def _lines(self) -> list[Line]:
        cube = next(iter(self.cell.objects.values()))
        x, y, z = self.cell.task["place"]["mark"]["position_m"]
        slot = np.array([x, y, z + cube.half_height_m])
        return [Line(self.cell.arm, [slot], [cube], (0.02, 0.01))]


class Pyramid(Job):
    """franka-pyramid: each arm makes a stack of any cubes."""

    sentence = "Build a stack of cubes with each arm."

    def _lines(self) -> list[Line]:
        task = self.cell.task
        lines = []
        for arm in self.cell.arms:
            x, y = task["robot"][arm.name]["goal_m"]
            slots = [
                np.array([x, y, task["base_height_m"] + layer * task["layer_height_m"]])
                for layer in range(task["required_count"])
            ]
            lines.append(Line(arm, slots, None, (task["goal_tolerance_m"], 0.01)))
        return lines


class _Belt(Job):
    """Bins arrive on a belt that stops when one is at its end."""

    #: No bin is asked for within this time of the one before (s).
    interval_s = 2.0

    def __init__(self, cell: Cell, rng: np.random.Generator) -> None:
        super().__init__(cell, rng)
        self._asked_s = -self.interval_s

    def tend(self) -> None:
        waiting = [one for one in self.seen if one.is_present and one.position[1] > 0.1]
        on_belt = [one for one in waiting if one.name != self.cell.arm.held]
        self.cell.conveyor(all(one.position[1] > self._end_y() for one in on_belt))
        if not on_belt and self.cell.time_s - self._asked_s >= self.interval_s:
            self._asked_s = self.cell.time_s
            self.cell.add_bin()

    def _end_y(self) -> float:
        raise NotImplementedError


class Palletize(_Belt):
    """ur10-palletize: nine bins on the pallet, open side up."""

    sentence = "Put the bins on the pallet, open side up."

    def _lines(self) -> list[Line]:
        task = self.cell.task
        slots = [
            np.array([x, y, task["slot_z_m"]]) for x in task["slot_x_m"] for y in task["slot_y_m"]
        ]
        tolerance = task["slot_tolerance_m"]
        return [Line(self.cell.arm, slots, None, (tolerance, tolerance), up=1)]

    def _end_y(self) -> float:
        return float(self.cell.task["belt_stop_y_m"])


class BinStack(_Belt):
    """ur10-bin-stack: 36 bins in columns of four, upside down."""

    sentence = "Stack the bins in columns of four, open side down."

    def _lines(self) -> list[Line]:
        stack = self.cell.task["stack"]
        height = 2.0 * self.seen[0].half_height_m
        first, i_step, j_step = (
            np.array(stack[key] + [0.0] * (3 - len(stack[key])))
            for key in ("first_m", "first_step_m", "second_step_m")
        )
        slots = [
            first + i * i_step + j * j_step + np.array([0.0, 0.0, height * (level + 0.5)])
            for i in range(3)
            for j in range(3)
            for level in range(stack["levels"])
        ]
        tolerance = (stack["tolerance_m"], stack["height_tolerance_m"])
        return [Line(self.cell.arm, slots, None, tolerance, up=-1)]

    def _end_y(self) -> float:
        return float(self.cell.task["belt_end_position_m"][1])


class FillBin(Job):
    """ur10-fill-bin: as many parts as possible in a bin on the cup. Parts fall while it
    is held; the job is over when it is lost with parts in it."""

    sentence = "Fill the bin with parts."

    extras = 2
    _INTERVAL_S = 0.5
    _HALF_M = (0.15, 0.10, 0.0675)

    def __init__(self, cell: Cell, rng: np.random.Generator) -> None:
        super().__init__(cell, rng)
        self.bin, *self.parts = self.seen
        self.seen = [self.bin]
        self.total = len(self.parts)
        self._most = 0
        self._dropped_s = 0.0
        self._above_m = float(self.cell.task["hold_position_m"][2]) - 0.3

    def tend(self) -> None:
        cell = self.cell
        is_up = self._is_held() and self.bin.position[2] > self._above_m
        if is_up and cell.time_s - self._dropped_s >= self._INTERVAL_S:
            self._dropped_s = cell.time_s
            cell.drop_parts()

    def extra(self) -> list[float]:
        force = float(self.cell.arm.gripper["suction_force"])
        return [self._inside() / self.total, force / 100.0]

    def progress(self) -> tuple[int, float]:
        if not self._is_held():
            return self._most, 0.4 * nearness(self.bin.position - self.cell.arm.tcp_position)
        self._most = max(self._most, self._inside())
        up = np.clip((self.bin.position[2] + 0.43) / (self._above_m + 0.43), 0.0, 1.0)
        return self._most, 0.5 + 0.5 * float(up)

    def is_over(self) -> bool:
        return self._most > 0 and not self._is_held()

    def _is_held(self) -> bool:
        return self.cell.arm.held == self.bin.name

    def _inside(self) -> int:
        own = rotation.matrix(self.bin.orientation)
        present = [part.position for part in self.parts if part.is_present]
        if not present:
            return 0
        off = np.abs((np.array(present) - self.bin.position) @ own)
        return int(np.count_nonzero(np.all(off <= self._HALF_M, axis=1)))


class Reach(Job):
    """reach: the TCP to a random point."""

    sentence = "Move the tool to the target."

    extras = 3
    _LOW_M = (0.30, -0.35, 0.15)
    _HIGH_M = (0.60, 0.35, 0.55)
    _NEAR_M = 0.02

    def __init__(self, cell: Cell, rng: np.random.Generator) -> None:
        super().__init__(cell, rng)
        self.total = 1
        self.goal: Array = rng.uniform(self._LOW_M, self._HIGH_M)

    def extra(self) -> list[float]:
        return [float(value) for value in self.goal]

    def progress(self) -> tuple[int, float]:
        off = self.cell.arm.tcp_position - self.goal
        if float(np.linalg.norm(off)) < self._NEAR_M:
            return 1, 0.0
        return 0, nearness(off)


#: By demo its job, and the steps of an episode.
JOBS: dict[str, tuple[type[Job], int]] = {
    "cube": (OneCube, 400),
    "franka-stack": (Stack, 2000),
    "franka-pyramid": (Pyramid, 3000),
    "reach": (Reach, 100),
    "ur10-palletize": (Palletize, 8000),
    "ur10-fill-bin": (FillBin, 2000),
    "ur10-bin-stack": (BinStack, 30000),
}
