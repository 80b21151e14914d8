"""Building blocks of tasks: the skills of the Rust crate ``robocell-skills``.

Each function returns a skill under way. ``skill.step(arm)`` does one decision of work
and returns ``RUNNING``, ``SUCCESS`` or ``FAILURE``; ``skill.reset()`` begins it again.
A skill is pickled with its progress, so a task that keeps skills in its attributes
resumes them after a restart. Lengths are in metres, angles in radians, times in
seconds; positions are in the world frame, quaternions are w x y z.
"""

from __future__ import annotations

from robocell._core import Skill
from robocell._view import Numbers, three

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


def move_to(
    position: Numbers,
    orientation: Numbers | None = None,
    *,
    yaw: float = 0.0,
    precise: bool = False,
    gripper: str | None = None,
    holding: str | None = None,
    timeout_s: float = 10.0,
) -> Skill:
    """Brings the TCP to a position; tool straight down, turned by ``yaw``, unless an
    orientation is given.

    With ``precise`` exactly and in a straight line. Fails when the position is out of
    reach or not reached within ``timeout_s``, and when the object ``holding`` is lost.
    """
    turn = None if orientation is None else [float(value) for value in orientation]
    return Skill.move_to(
        ("pose", three(position), turn, float(yaw)),
        precise=precise,
        gripper=gripper,
        holding=holding,
        timeout_s=timeout_s,
    )


def move_to_object(
    name: str, above: float = 0.0, *, gripper: str | None = None, timeout_s: float = 10.0
) -> Skill:
    """Brings the TCP to the grip of an object, or ``above`` it; follows the object."""
    goal = ("object", name, float(above))
    return Skill.move_to(goal, gripper=gripper, timeout_s=timeout_s)


def move_to_place(name: str, place: str, above: float = 0.0, *, timeout_s: float = 10.0) -> Skill:
    """Brings an object in the gripper to the next free slot of a place, or ``above``."""
    return Skill.move_to(("place", name, place, float(above)), timeout_s=timeout_s)


def move_up(by: float, *, timeout_s: float = 10.0) -> Skill:
    """Lifts the TCP straight up."""
    return Skill.move_to(("up", float(by)), timeout_s=timeout_s)


def home() -> Skill:
    """Brings the joints to where they were at the start of the run."""
    return Skill.home()


def pick(name: str, *, clearance: float = 0.1, max_attempts: int = 5) -> Skill:
    """Picks an object up from above: above it, down, close, lift.

    Fails when the object is not caught; after ``max_attempts`` failures in a row the
    job fails.
    """
    return Skill.pick(name, float(clearance), max_attempts)


def place(
    name: str,
    place: str,
    *,
    clearance: float = 0.1,
    tolerance: float = 0.02,
    max_attempts: int = 5,
) -> Skill:
    """Sets the object in the gripper down in the next free slot of a place."""
    return Skill.place(name, place, float(clearance), float(tolerance), max_attempts)


def open() -> Skill:
    """Opens the gripper, or switches suction off."""
    return Skill.open()


def close(name: str | None = None) -> Skill:
    """Closes the gripper, or switches suction on; fails without the object, or with
    no name without any object, in it."""
    return Skill.close(name)


def wait(seconds: float) -> Skill:
    """Waits; the arm stays where it was sent."""
    return Skill.wait(float(seconds))


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
