"""Building blocks of tasks: the skills of the Rust crate ``robocell-skills``.

Each function returns a skill under way. ``skill.step(arm)`` does one decision of work
and returns ``RUNNING``, ``SUCCESS`` or ``FAILURE``; ``skill.reset()`` restarts it.
A skill is pickled with its progress, so a task that keeps skills in its attributes
resumes them after a restart. Lengths are in metres, angles in radians, times in
seconds; positions are in the world frame, quaternions are w x y z. Arguments are called as
the ports of the same skills in files (``robocell schema tree``).
"""

from __future__ import annotations

import functools
import math
import warnings
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from robocell._core import Skill
from robocell._view import Numbers, floats, three

__all__ = [
    "Skill",
    "add_bin",
    "close",
    "conveyor",
    "drop_parts",
    "follow_operator",
    "home",
    "move_to",
    "move_to_object",
    "move_to_place",
    "move_up",
    "open",
    "pick",
    "place",
    "wait",
]

#: Start of a warning about a former name of an argument, as a pattern.
FORMER_NAME = r"\w+\(\w+=\) is now "

_Words = ParamSpec("_Words")
_Made = TypeVar("_Made")


def _renamed(**names: str) -> Callable[[Callable[_Words, _Made]], Callable[_Words, _Made]]:
    """Takes former names of arguments, too, for one release."""

    def decorate(function: Callable[_Words, _Made]) -> Callable[_Words, _Made]:
        @functools.wraps(function)
        def call(*words: Any, **named: Any) -> _Made:
            for old in names.keys() & named.keys():
                new = names[old]
                if new in named:
                    raise TypeError(f"{function.__name__}() got {new}= and {old}=, its former name")
                warnings.warn(
                    f"{function.__name__}({old}=) is now {function.__name__}({new}=), as in files; "
                    "the next release does not take the former name",
                    DeprecationWarning,
                    stacklevel=2,
                )
                named[new] = named.pop(old)
            return function(*words, **named)

        return call

    return decorate


def _pose(
    pose: Numbers, orientation: Numbers | None
) -> tuple[tuple[float, float, float], list[float] | None]:
    """Position and orientation of 3 or 7 numbers."""
    try:
        numbers = floats(pose)
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (3, 7) or not all(map(math.isfinite, numbers)):
        raise ValueError(
            f"pose is {pose!r}; 3 finite numbers (x y z, m) or 7 (with w x y z) are needed"
        )
    if len(numbers) == 7 and orientation is not None:
        raise ValueError("a pose of 7 numbers has its orientation; orientation= is one too many")
    turn = numbers[3:] or (None if orientation is None else floats(orientation))
    return three(numbers[:3]), turn


@_renamed(position="pose")
def move_to(
    pose: Numbers,
    orientation: Numbers | None = None,
    *,
    yaw: float = 0.0,
    above_m: float = 0.0,
    precise: bool = False,
    gripper: str | None = None,
    holding: str | None = None,
    timeout_s: float = 10.0,
) -> Skill:
    """Brings the TCP to a pose: x y z, or that and w x y z, or x y z and an orientation. With
    x y z alone the tool is straight down, turned by ``yaw``. Above the pose with ``above_m``.

    With ``precise`` exactly and in a straight line. Fails when the pose is out of
    reach or not reached within ``timeout_s``, and when the object ``holding`` is lost.
    """
    (x, y, z), turn = _pose(pose, orientation)
    return Skill.move_to(
        ("pose", (x, y, z + float(above_m)), turn, float(yaw)),
        precise=precise,
        gripper=gripper,
        holding=holding,
        timeout_s=timeout_s,
    )


@_renamed(name="object", above="above_m")
def move_to_object(
    object: str, above_m: float = 0.0, *, gripper: str | None = None, timeout_s: float = 10.0
) -> Skill:
    """Brings the TCP to the grip of an object, or ``above_m`` above it; follows the object."""
    goal = ("object", object, float(above_m))
    return Skill.move_to(goal, gripper=gripper, timeout_s=timeout_s)


@_renamed(name="object", above="above_m")
def move_to_place(
    object: str, place: str, above_m: float = 0.0, *, timeout_s: float = 10.0
) -> Skill:
    """Brings an object in the gripper to the next free slot of a place, or ``above_m`` above
    it."""
    return Skill.move_to(("place", object, place, float(above_m)), timeout_s=timeout_s)


@_renamed(by="by_m")
def move_up(by_m: float = 0.1, *, holding: str | None = None, timeout_s: float = 10.0) -> Skill:
    """Lifts the TCP straight up; fails when the object ``holding`` is lost. ``Up`` of the
    files."""
    return Skill.move_to(("up", float(by_m)), holding=holding, timeout_s=timeout_s)


def home() -> Skill:
    """Brings the joints to where they were at the start of the run."""
    return Skill.home()


@_renamed(name="object", clearance="clearance_m")
def pick(object: str, *, clearance_m: float = 0.1, max_attempts: int = 5) -> Skill:
    """Picks an object up by the best grasp that nothing excludes: before it, to it, close, lift.

    Fails when the object is not caught; after a failure the next grasp is taken, and after
    ``max_attempts`` failures in a row the job fails. An object without a grasp fails the job
    before the arm moves, with the reason.
    """
    return Skill.pick(object, float(clearance_m), max_attempts)


@_renamed(name="object", clearance="clearance_m", tolerance="tolerance_m")
def place(
    object: str,
    place: str,
    *,
    clearance_m: float = 0.1,
    tolerance_m: float = 0.02,
    max_attempts: int = 5,
) -> Skill:
    """Sets the object in the gripper down in the next free slot of a place."""
    return Skill.place(object, place, float(clearance_m), float(tolerance_m), max_attempts)


def open() -> Skill:
    """Opens the gripper, or switches suction off."""
    return Skill.open()


@_renamed(name="object")
def close(object: str | None = None) -> Skill:
    """Closes the gripper, or switches suction on; fails without that object in it, or, if
    none is given, without any."""
    return Skill.close(object)


@_renamed(seconds="for_s")
def wait(for_s: float) -> Skill:
    """Waits; the arm stays where it was sent. ``Stay`` of the files."""
    return Skill.wait(float(for_s))


def conveyor(run: bool) -> Skill:
    """Starts or stops the belt."""
    return Skill.conveyor(run)


def add_bin() -> Skill:
    """Asks for the next bin."""
    return Skill.add_bin()


def drop_parts() -> Skill:
    """Asks the dispenser for parts."""
    return Skill.drop_parts()


def follow_operator() -> Skill:
    """Follows the operator's target and gripper requests; never ends."""
    return Skill.follow_operator()
