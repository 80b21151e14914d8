"""The view that tasks and programs have of a cell."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from robocell import _core, wire

Vector = npt.NDArray[np.float64]
#: Values that are accepted as a vector.
Numbers: TypeAlias = Sequence[float] | npt.NDArray[Any]
#: A joint nearer to its position at the start of the run is there (rad or m).
HOME_TOLERANCE = 0.05


class Object:
    """A movable object. Positions are in the world frame, in metres."""

    def __init__(self, name: str, half_height_m: float, view: Any) -> None:
        self.name = name
        #: Half of its height when it is upright (m).
        self.half_height_m = half_height_m
        #: Its ``ObjectState``, as a view on shared memory of this decision.
        self.state = view
        self._position: Vector = view["pose"]["position"]
        self._orientation: Vector = view["pose"]["orientation_wxyz"]
        self._velocity: Vector = view["twist"]["linear"]

    @property
    def position(self) -> Vector:
        """Centre (m)."""
        return self._position

    @property
    def orientation(self) -> Vector:
        """w x y z."""
        return self._orientation

    @property
    def velocity(self) -> Vector:
        """Of the centre (m/s)."""
        return self._velocity

    @property
    def is_present(self) -> bool:
        """Whether it is in the cell now: a bin that has not arrived is not."""
        return bool(int(self.state["flags"]) & 1)

    def __repr__(self) -> str:
        return f"<object '{self.name}' at {np.round(self._position, 4).tolist()}>"


class Arm:
    """An arm. Positions are in the world frame, in metres."""

    def __init__(self, core: _core.Arm, about: dict[str, Any], view: Any) -> None:
        self._core = core
        self.name: str = about["name"]
        #: Names of the controlled joints.
        self.joint_names: list[str] = about["joint_names"]
        #: Joint positions at the start of the run (rad or m).
        self.home: list[float] = about["home"]
        #: The TCP there (m; w x y z).
        self.home_position: Vector = np.array(about["home_position"])
        self.home_orientation: Vector = np.array(about["home_orientation"])
        #: Its ``ArmState``, as a view on shared memory of this decision.
        self.state = view
        count = len(self.joint_names)
        #: Measured joint positions (rad or m), velocities and efforts.
        self.joint_positions: Vector = view["joint_positions"][:count]
        self.joint_velocities: Vector = view["joint_velocities"][:count]
        self.joint_efforts: Vector = view["joint_efforts"][:count]

    @property
    def tcp_position(self) -> Vector:
        """Measured position of the TCP (m)."""
        position: Vector = self.state["tcp"]["position"]
        return position

    @property
    def tcp_orientation(self) -> Vector:
        """Measured orientation of the TCP, w x y z."""
        orientation: Vector = self.state["tcp"]["orientation_wxyz"]
        return orientation

    @property
    def gripper(self) -> Any:
        """``GripperState`` as measured."""
        return self.state["gripper"]

    @property
    def held(self) -> str | None:
        """Name of the object in the gripper."""
        return self._core.held

    @property
    def is_open(self) -> bool:
        """Whether the gripper is open."""
        return self._core.is_open

    @property
    def is_alive(self) -> bool:
        """Whether the arm has no fault and its controller answers."""
        return self._core.is_alive

    @property
    def is_home(self) -> bool:
        """Whether all joints are within 0.05 rad (or m) of where they were at the start."""
        return bool(np.max(np.abs(self.joint_positions - self.home)) < HOME_TOLERANCE)

    def reaches(self, position: Numbers) -> bool:
        """Whether the arm reaches a point with the tool straight down (m)."""
        return self._core.reaches(three(position))

    def down(self, yaw: float = 0.0) -> tuple[float, float, float, float]:
        """Orientation of the TCP with the tool straight down, turned by ``yaw``."""
        w, x, y, z = self._core.down(float(yaw))
        return w, x, y, z

    def is_at_rest(self, name: str) -> bool:
        """Whether an object is at rest."""
        return self._core.is_at_rest(name)

    def is_covered(self, name: str) -> bool:
        """Whether an object has another on top of it."""
        return self._core.is_covered(name)

    def grip_pose(self, name: str, above: float = 0.0) -> tuple[Vector, Vector] | None:
        """Position and orientation of the TCP with which the arm grips an object as it
        is now, or ``above`` that; ``None`` where the object is not in the cell."""
        pose = self._core.grip_pose(name, float(above))
        if pose is None:
            return None
        return np.array(pose[0]), np.array(pose[1])

    def distance_to(self, position: Numbers) -> float:
        """From the measured TCP (m)."""
        return float(np.linalg.norm(self.tcp_position - np.asarray(position)))

    def send(
        self,
        position: Numbers,
        orientation: Numbers | None = None,
        *,
        yaw: float = 0.0,
        gripper: str = "keep",
        approach: Numbers = (0.0, 0.0, 0.0),
        approach_std_dev: float = 0.0,
        ignore: Sequence[str] = (),
        guides: Sequence[str] = (),
        posture: Numbers | None = None,
    ) -> None:
        """Sends the TCP to a pose, tool straight down unless an orientation is given.

        ``gripper`` is ``"open"``, ``"close"`` or ``"keep"``. ``approach`` is the
        direction of the last part of the motion times its length, for a corridor of
        the width ``approach_std_dev``. Objects and fixtures in
        ``ignore`` are no obstacles; fixtures in ``guides``, which the cell file does not
        count as solid, are. ``posture`` are joint positions to stay near. A task
        repeats it in each decision.
        """
        turn = self.down(yaw) if orientation is None else orientation
        self._core.send(
            three(position),
            floats(turn),
            gripper,
            three(approach),
            float(approach_std_dev),
            list(ignore),
            list(guides),
            None if posture is None else floats(posture),
        )

    def send_joints(
        self,
        positions: Numbers,
        *,
        gripper: str = "keep",
        avoid_obstacles: bool = True,
    ) -> None:
        """Sends the joints to positions (rad or m): past obstacles, or straight."""
        self._core.send_joints(floats(positions), gripper, avoid_obstacles)

    def grip(self, gripper: str) -> None:
        """Opens, closes or keeps the gripper; the arm stays where it was sent."""
        self._core.grip(gripper)

    def hold(self) -> None:
        """Stops the arm where it is."""
        self._core.hold()

    def begin(self, skill: _core.Skill) -> None:
        """Moves the arm by a skill, for a :class:`robocell.Cell` without a policy."""
        self._core.begin(skill)

    @property
    def skill_status(self) -> _core.Status | None:
        """How the skill of :meth:`begin` ended; ``None`` without one."""
        return self._core.skill_status

    def do(self, skill: _core.Skill) -> _core.Status:
        """One decision of a skill; the same as ``skill.step(arm)``."""
        if not hasattr(skill, "step"):
            raise TypeError(f"do() needs a skill, as skills.home(), not {skill!r}")
        return skill.step(self._core)

    def __repr__(self) -> str:
        return f"<arm '{self.name}'>"


class Objects(Mapping[str, Object]):
    def __init__(self, objects: list[Object]) -> None:
        self._by_name = {one.name: one for one in objects}

    def __getitem__(self, name: str) -> Object:
        try:
            return self._by_name[name]
        except KeyError:
            known = ", ".join(self._by_name)
            raise KeyError(f"unknown object '{name}'; known are: {known}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self._by_name)


class View:
    """Names, numbers and the state of a cell.

    Arrays are views that show the newest state; ``.copy()`` keeps a value.
    """

    def __init__(self, core: _core.Moment) -> None:
        self._core = core
        about = json.loads(core.about)
        self.name: str = about["name"]
        #: The table ``[task]`` of the cell file.
        self.task: dict[str, Any] = about["task"]
        #: The whole ``WorldState``.
        self.state: Any = core.state.view(wire.dtype("WorldState"))[0]
        self.arms: list[Arm] = [
            Arm(core.arm(index), arm, self.state["arms"][index])
            for index, arm in enumerate(about["arms"])
        ]
        self.objects: Mapping[str, Object] = Objects(
            [
                Object(one["name"], one["half_height_m"], self.state["objects"][index])
                for index, one in enumerate(about["objects"])
            ]
        )
        self._sensors: list[str] = about["sensors"]

    @property
    def arm(self) -> Arm:
        """The first arm."""
        return self.arms[0]

    @property
    def tick(self) -> int:
        """Number of the state that is shown."""
        return int(self.state["header"]["tick"])

    def sensor(self, name: str) -> bool:
        """Whether a sensor detects something."""
        if name not in self._sensors:
            known = ", ".join(self._sensors)
            raise KeyError(f"unknown sensor '{name}'; known are: {known}")
        return bool(self.state["equipment"]["sensors"][self._sensors.index(name)])

    def add_place(
        self,
        name: str,
        position: Numbers,
        *,
        yaw: float = 0.0,
        layers: int = 1,
        layer_height: float = 0.0,
    ) -> None:
        """Adds a place for the skill ``place``: a point of the surface below the centre
        of the first object, and ``layers`` on top of each other."""
        self._core.add_place(name, three(position), float(yaw), layers, float(layer_height))

    def placed(self, place: str, tolerance: float = 0.02) -> list[str]:
        """Names of the objects in the slots of a place."""
        return self._core.placed(place, float(tolerance))

    def conveyor(self, run: bool) -> None:
        """Runs or stops the belt."""
        self._core.conveyor(run)

    def add_bin(self) -> None:
        """Asks for another bin."""
        self._core.add_bin()

    def drop_parts(self) -> None:
        """Asks the dispenser for parts."""
        self._core.drop_parts()


def floats(values: Numbers) -> list[float]:
    """As the native part takes them."""
    return [float(value) for value in values]


def three(values: Numbers) -> tuple[float, float, float]:
    """A point or a direction."""
    try:
        x, y, z = floats(values)
    except (TypeError, ValueError):
        raise ValueError(f"three numbers (x y z) are needed, not {values!r}") from None
    return x, y, z
