"""Machines of the package ``transitions`` that report each change of the state, and what of
that package a policy has."""

from __future__ import annotations

import copy
import inspect
from collections.abc import Callable, Sequence
from enum import Enum, EnumMeta
from typing import Any

from transitions import Machine, State
from transitions.core import Condition
from transitions.extensions.nesting import HierarchicalMachine, NestedState

from robocell.task._machine_parts import (
    CALLBACKS,
    Guard,
    check_nested,
    check_trigger,
    state_names,
    states_of,
)
from robocell.task._refuse import (
    Refused,
    constant_line,
    did_you_mean,
)

#: Arguments of ``transitions.Machine`` that a policy may have as attributes of its class.
OPTIONS = (
    "queued",
    "send_event",
    "ignore_invalid_triggers",
    "auto_transitions",
    "model_override",
    *CALLBACKS,
)
#: Arguments that a policy cannot have, and why.
_REFUSED = {
    "model_attribute": "the state of a policy is self.state",
    "machine_context": "a policy is called by one thread, which needs no lock",
}
#: Classes of the package that cannot work in a policy.
_REFUSED_CLASSES = {
    "AsyncMachine": "nothing awaits its triggers; decide has to return in each decision",
    "LockedMachine": "a policy is called by one thread, which needs no lock",
    "GraphMachine": "the page and `robocell fsm show` draw the machine; use Machine or "
    "HierarchicalMachine",
    "Timeout": "it counts seconds of the wall clock in a thread, and is lost in a restart; "
    "compare cell.time_s in decide",
    "AsyncTimeout": "it counts seconds of the wall clock; compare cell.time_s in decide",
    "Retry": "its counts are lost in a restart; count in an attribute of the policy",
}


class _Fires:
    """A transition that reports to its machine which trigger changes the state."""

    def _change_state(self, event_data: Any) -> None:
        machine = event_data.machine
        machine._firing.append(event_data.event.name)
        try:
            super()._change_state(event_data)  # type: ignore[misc]
        finally:
            machine._firing.pop()


class _Reports:
    """A machine that reports a state when it is set, before callbacks of that state can fire
    the next trigger."""

    def __init__(self, changed: Callable[[str], None], **options: Any) -> None:
        self._on_change = changed
        #: Triggers that are being fired, the innermost last.
        self._firing: list[str] = []
        #: Names of states by their members of an Enum.
        self._members: dict[Any, str] = {}
        self._lost: BaseException | None = None
        super().__init__(**options)

    def set_state(self, state: Any, model: Any = None) -> None:
        super().set_state(state, model)  # type: ignore[misc]
        if self._firing:
            self._on_change(self._firing[-1])

    def callbacks(self, funcs: Any, event_data: Any) -> None:
        try:
            super().callbacks(funcs, event_data)  # type: ignore[misc]
        except BaseException as error:
            if funcs is self.finalize_event:  # type: ignore[attr-defined]
                self._lost = error
            raise

    def _process(self, trigger: Any) -> Any:
        # The package drops exceptions of `finalize_event`.
        self._lost = None
        result = super()._process(trigger)  # type: ignore[misc]
        lost, self._lost = self._lost, None
        if lost is not None:
            raise lost
        return result


def make_machine(policy: Any, changed: Callable[[str], None]) -> Any:
    """The machine of a policy, of its constants ``states``, ``transitions`` and so on.

    Raises:
        Refused: with the line of the mistake.
    """
    kind = type(policy)
    for name, why in _REFUSED.items():
        if getattr(policy, name, None) not in (None, "state"):
            raise Refused(constant_line(kind, name), f"{name} is not supported: {why}")
    # Each policy has its own state objects: they may have attributes.
    states = copy.deepcopy(list(policy.states), {id(policy): policy})
    base = _base(policy, states)
    options = {name: getattr(policy, name) for name in OPTIONS if hasattr(policy, name)}
    options.setdefault("auto_transitions", False)
    transition: Any = type("Transition", (_Fires, base.transition_cls), {})
    if transition.condition_cls is Condition:
        transition.condition_cls = Guard
    reporting = type(base.__name__, (_Reports, base), {"transition_cls": transition})
    machine: Any = reporting(changed, model=None, states=None, initial=None, **options)
    _add_states(machine, policy, states)
    _set_initial(machine, policy)
    _add_transitions(machine, policy)
    check_nested(machine, policy)
    machine.add_model(policy)
    return machine


def _base(policy: Any, states: Sequence[Any]) -> Any:
    """The class of the machine: with nested states if there are any."""
    kind, base = type(policy), policy.machine_class
    if base is None:
        return HierarchicalMachine if any(map(_is_nested, states)) else Machine
    where = constant_line(kind, "machine_class")
    if not (inspect.isclass(base) and issubclass(base, Machine)):
        raise Refused(where, f"machine_class is {base!r}; a subclass of Machine is needed")
    for one in (*base.__mro__, *base.state_cls.__mro__):
        if one.__module__.startswith("transitions.") and one.__name__ in _REFUSED_CLASSES:
            why = _REFUSED_CLASSES[one.__name__]
            raise Refused(where, f"{one.__name__} of transitions is not supported: {why}")
    return base


def _is_nested(state: Any) -> bool:
    if isinstance(state, dict):
        return any(state.get(key) for key in ("children", "states", "parallel"))
    value = state.value if isinstance(state, Enum) else state
    return isinstance(value, (EnumMeta, NestedState, HierarchicalMachine)) or (
        isinstance(state, Enum) and isinstance(value, dict)
    )


def _add_states(machine: Any, policy: Any, states: Sequence[Any]) -> None:
    kind = type(policy)
    for index, state in enumerate(states):
        where = constant_line(kind, "states", index)
        if not isinstance(state, (str, Enum, dict, State, HierarchicalMachine)):
            raise Refused(
                where, f"the state {state!r} is not a name, a member of an Enum, a dict or a State"
            )
        if policy.machine_class is None and isinstance(state, dict) and "timeout" in state:
            raise Refused(where, f"timeout is not supported: {_REFUSED_CLASSES['Timeout']}")
        try:
            machine.add_states([state])
        except Exception as error:  # Any exception of the package.
            raise Refused(where, f"the state {state!r} is refused: {error}") from error
    if not states:
        raise Refused(constant_line(kind, "states"), f"{kind.__name__} has no states")


def _set_initial(machine: Any, policy: Any) -> None:
    kind, initial = type(policy), policy.initial
    names = state_names(machine)
    where = constant_line(kind, "initial")
    if initial is None or initial == "":
        raise Refused(where, f"initial is not set; states are: {', '.join(names)}")
    _check_state(machine, initial, "initial", where)
    machine.initial = _plain(initial)


def _plain(state: Any) -> Any:
    """A name in place of a state object, of which the machine has a copy."""
    if isinstance(state, (list, tuple)):
        return [_plain(one) for one in state]
    return state.name if isinstance(state, State) else state


def _check_state(machine: Any, state: Any, called: str, where: str) -> None:
    """Refuses objects that are not states: the package adds unknown ones or searches them later."""
    if isinstance(state, (list, tuple)):
        for one in state:
            _check_state(machine, one, called, where)
        return
    names = state_names(machine)
    if isinstance(state, Enum):
        is_known = any(one.value is state for one in states_of(machine).values())
        shown = str(state)
    else:
        shown = str(getattr(state, "name", state))
        is_known = shown in names
    if not is_known:
        known = ", ".join(names)
        advice = did_you_mean(shown, names)
        raise Refused(where, f"{called} {shown} is not a state{advice}; states are: {known}")


def _add_transitions(machine: Any, policy: Any) -> None:
    kind = type(policy)
    for index, row in enumerate(policy.transitions):
        where = constant_line(kind, "transitions", index)
        cells = dict(zip(("trigger", "source", "dest"), row, strict=False)) if _is_row(row) else row
        if not isinstance(cells, dict) or not {"trigger", "source", "dest"} <= set(cells):
            raise Refused(
                where, f"the transition {row!r} needs a trigger, a source and a dest (list or dict)"
            )
        trigger = cells["trigger"]
        check_trigger(policy, trigger, where)
        if cells["source"] != machine.wildcard_all:
            _check_state(machine, cells["source"], "source", where)
        if cells["dest"] not in (None, machine.wildcard_same):
            _check_state(machine, cells["dest"], "dest", where)
        try:
            row = [_plain(cell) for cell in row] if _is_row(row) else {**row, **_ends(cells)}
            machine.add_transitions([row])
        except Exception as error:  # Any exception of the package.
            raise Refused(where, f"the transition {row!r} is refused: {error}") from error
    if getattr(policy, "ordered_transitions", False):
        machine.add_ordered_transitions()


def _ends(cells: dict[str, Any]) -> dict[str, Any]:
    return {name: _plain(cells[name]) for name in ("source", "dest")}


def _is_row(row: Any) -> bool:
    return isinstance(row, (list, tuple))
