"""The parts of a machine of ``transitions``, and its callbacks."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Sequence
from enum import Enum
from typing import Any

from transitions.core import Condition
from transitions.extensions.nesting import HierarchicalMachine

from robocell.task._refuse import (
    Refused,
    check_call,
    check_kind,
    constant_line,
    did_you_mean,
    line_of,
    returns_nothing,
)

#: Callbacks of a machine; those of its states and of its transitions are below.
CALLBACKS = (
    "prepare_event",
    "before_state_change",
    "after_state_change",
    "finalize_event",
    "on_exception",
    "on_final",
)
#: Attributes that the package adds to a policy.
_OF_PACKAGE = frozenset({"trigger", "may_trigger"})
_MISSING = object()
_OF_STATE = ("on_enter", "on_exit", "on_final")
_OF_TRANSITION = ("prepare", "before", "after")


class Guard(Condition):
    """The package compares a result with ``True`` or ``False``: neither ``None`` nor the name of
    an object is equal to one of them, and the condition never holds, in silence."""

    def check(self, event_data: Any) -> bool:
        machine = event_data.machine
        predicate = machine.resolve_callable(self.func, event_data)
        if machine.send_event:
            result = predicate(event_data)
        else:
            result = predicate(*event_data.args, **event_data.kwargs)
        try:
            is_same = bool(result == self.target) == (bool(result) == self.target)
        except ValueError:  # Of an array.
            is_same = False
        if not is_same:
            name = getattr(predicate, "__name__", str(self.func))
            shown = name if name != "func_wrapper" else str(self.func)
            where = line_of(predicate) if name == shown else ""
            raise Refused(where, f"condition '{shown}' is {result!r}; True or False is needed")
        return bool(result == self.target)


def check_trigger(policy: Any, trigger: Any, where: str) -> None:
    """The package does not bind a trigger whose name the policy already has."""
    kind = type(policy)
    if not isinstance(trigger, str):
        raise Refused(where, f"the trigger {trigger!r} is not a name")
    if trigger in _OF_PACKAGE:
        raise Refused(where, f"the trigger '{trigger}' has the name of a method of transitions")
    if hasattr(kind, trigger) and not getattr(policy, "model_override", False):
        place = line_of(getattr(kind, trigger)) or kind.__name__
        raise Refused(where, f"the trigger '{trigger}' has the name of a method ({place})")


def check_nested(machine: Any, policy: Any) -> None:
    """The transitions that states have of their own."""
    names = state_names(machine)
    where = constant_line(type(policy), "states")
    for prefix, event in events_of(machine):
        if not prefix:
            continue
        check_trigger(policy, event.name, where)
        for one in (one for rows in event.transitions.values() for one in rows):
            for called, name in (("source", one.source), ("dest", one.dest)):
                if name is not None and not {f"{prefix}{name}", str(name)} & set(names):
                    known = [name.removeprefix(prefix) for name in names if name.startswith(prefix)]
                    raise Refused(
                        where,
                        f"{called} {name} of the trigger '{event.name}' is not a state"
                        f"{did_you_mean(str(name), known)}; states are: {', '.join(known)}",
                    )


def check_callbacks(machine: Any, policy: Any) -> None:
    """Refuses callbacks that do not exist, or that a call does not run."""
    for name in CALLBACKS:
        _check_all(machine, policy, getattr(machine, name, ()), name)
    for state in states_of(machine).values():
        for name in _OF_STATE:
            _check_all(machine, policy, getattr(state, name, ()), name)
    for _, event in events_of(machine):
        for transition in (one for rows in event.transitions.values() for one in rows):
            for name in _OF_TRANSITION:
                _check_all(machine, policy, getattr(transition, name), name)
            guards = [guard.func for guard in transition.conditions]
            _check_all(machine, policy, guards, "condition")


def _check_all(machine: Any, policy: Any, functions: Sequence[Any], called: str) -> None:
    for function in functions:
        name = function if isinstance(function, str) else getattr(function, "__name__", "?")
        found = _found(policy, function) if isinstance(function, str) else function
        if found is _MISSING:
            where = _line_of_word(type(policy), function)
            advice = did_you_mean(function, dir(policy))
            raise Refused(where, f"{called} '{function}' is not a method of the policy{advice}")
        if callable(found):
            check_kind(found, f"{called} '{name}'")
            if called == "condition" and returns_nothing(found):
                raise Refused(
                    line_of(found), f"condition '{name}' returns nothing; True or False is needed"
                )
            if machine.send_event:
                check_call(found, 1, name, f"{name}(self, event), as send_event is set")


def _found(policy: Any, name: str) -> Any:
    """The object that a callback names, without a call of a property; ``True`` if imported."""
    static = inspect.getattr_static(policy, name, _MISSING)
    if isinstance(static, property) or (static is _MISSING and "." in name):
        return True
    return getattr(policy, name, _MISSING)


def _line_of_word(kind: type, word: str) -> str:
    """Of the first transition or state that names a callback, else of the class."""
    for constant in ("transitions", "states"):
        for index, row in enumerate(getattr(kind, constant, ())):
            if repr(word) in repr(row):
                return constant_line(kind, constant, index)
    return line_of(kind)


def states_of(machine: Any) -> dict[str, Any]:
    """All states by name: that of a nested one starts with those of its parents."""
    return dict(_states(machine, machine.states, []))


def _states(machine: Any, states: Any, path: list[str]) -> Iterator[tuple[str, Any]]:
    for name, state in states.items():
        yield machine.state_cls.separator.join([*path, name]) if path else name, state
        yield from _states(machine, getattr(state, "states", {}), [*path, name])


def state_names(machine: Any) -> list[str]:
    """Names of all states, parents before their children."""
    return list(states_of(machine))


def events_of(machine: Any) -> list[tuple[str, Any]]:
    """The events, each with the prefix of the names of its states."""
    found = [("", event) for event in machine.events.values()]
    if isinstance(machine, HierarchicalMachine):
        for name, state in states_of(machine).items():
            found += [
                (f"{name}{machine.state_cls.separator}", one) for one in state.events.values()
            ]
    return found


def active(machine: Any, state: Any) -> list[str]:
    """Names of the states that a policy is in: several of parallel ones."""
    if isinstance(state, (list, tuple)):
        return [name for one in state for name in active(machine, one)]
    if isinstance(state, Enum):
        if state not in machine._members:
            machine._members = {one.value: name for name, one in states_of(machine).items()}
        return [machine._members.get(state, state.name)]
    return [str(state)]
