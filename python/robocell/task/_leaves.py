"""Checks of py_trees behaviours. The package takes a wrong result for INVALID, in silence."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

from py_trees.common import Status as Ended

from robocell._core import Status
from robocell.task._refuse import (
    Refused,
    check_call,
    check_kind,
    check_result,
    line_of,
    returns_nothing,
)

#: Methods of a behaviour that are called in a decision, with the number of their arguments.
_METHODS = {
    "initialise": (0, "initialise(self)"),
    "update": (0, "update(self)"),
    "terminate": (1, "terminate(self, new_status)"),
}
_ALLOWED = (Ended.RUNNING, Ended.SUCCESS, Ended.FAILURE)
_NEEDED = "Status.RUNNING, SUCCESS or FAILURE of py_trees.common is needed"
_SKILL_HINT = "; SkillLeaf(name, arm, skill) translates the status of a skill"


def check_nodes(nodes: Sequence[Any]) -> None:
    """Refuses methods that cannot be called, and has the results of the others checked."""
    for node in nodes:
        for name, (count, usage) in _METHODS.items():
            function = getattr(node, name)
            if not _is_of_package(function):
                check_call(function, count, f"{name} of '{node.name}'", usage)
        check_kind(node.setup, f"setup of '{node.name}'")
        if not _is_of_package(node.update):
            node.update = _checked(node.update, f"update of '{node.name}'")


def set_up(nodes: Sequence[Any], cell: Any) -> None:
    """Calls ``setup(cell=cell)`` of nodes that have one, as ``BehaviourTree.setup`` does."""
    for node in nodes:
        if not _is_of_package(node.setup):
            kinds = [one.kind for one in inspect.signature(node.setup).parameters.values()]
            takes_words = inspect.Parameter.VAR_KEYWORD in kinds
            node.setup(**({"cell": cell} if takes_words else {}))


def _is_of_package(function: Any) -> bool:
    module = str(getattr(function, "__module__", ""))
    return module.split(".")[0] in ("py_trees", "robocell")


def _checked(update: Callable[[], Any], called: str) -> Callable[[], Ended]:
    if returns_nothing(update):
        raise Refused(line_of(update), f"{called} returns nothing; {_NEEDED}")

    def call() -> Ended:
        status = update()
        if isinstance(status, Ended) and status in _ALLOWED:
            return status
        check_result(status, update, called)
        hint = _SKILL_HINT if isinstance(status, Status) else ""
        raise Refused(line_of(update), f"{called} returned {status!r}; {_NEEDED}{hint}")

    return call


def check_condition(holds: Any, name: str) -> None:
    """Refuses a function of a condition that says nothing."""
    called = f"holds of '{name}'"
    check_call(holds, 0, called, "holds()")
    if returns_nothing(holds):
        raise Refused(line_of(holds), f"{called} returns nothing; True or False is needed")


def truth(value: Any, holds: Any, name: str) -> bool:
    """Whether a condition holds, of the result of its function."""
    called = f"holds of '{name}'"
    check_result(value, holds, called)
    if isinstance(value, (Status, Ended)):
        raise Refused(line_of(holds), f"{called} returned {value!r}; True or False is needed")
    try:
        return bool(value)
    except Exception as error:  # As of an array with several elements.
        raise Refused(line_of(holds), f"{called} returned {value!r}: {error}") from error
