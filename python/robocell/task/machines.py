"""Tasks as state machines of ``transitions``. Needs ``pip install robocell[machines]``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from transitions import State
from transitions.extensions.nesting import NestedState

from robocell.task import _machine_parts
from robocell.task._cell import TaskCell
from robocell.task._machine import make_machine
from robocell.task._memory import Part, Remembers
from robocell.task._refuse import Refused, line_of

#: Attributes of every state; the rest is memory.
_COMMON = frozenset(vars(State("common"))) | frozenset(vars(NestedState("common")))


class MachinePolicy(Remembers):
    """A policy that is a machine: a subclass has ``states``, ``transitions`` and
    ``initial`` in the form of the package ``transitions``, and ``decide(self, cell)``,
    which fires triggers: ``self.grasped()``.

    States are names, members of an ``Enum``, state objects, or dicts with ``children`` (then
    the machine is a ``HierarchicalMachine``). Conditions and callbacks are methods of the
    subclass. Arguments of ``transitions.Machine`` are attributes of the class of the same
    name: ``queued``, ``send_event``, ``on_exception``, ``before_state_change`` and so on;
    ``auto_transitions`` is off unless it is set. ``machine_class`` replaces the class.

    The states and the last transition are shown on the page and by ``robocell fsm show
    --live``; each change of the state is in the log, those of triggers that callbacks fire,
    too. The checkpoint holds the state and the attributes of the policy, as far as they can be
    pickled.
    """

    states: Sequence[Any] = ()
    transitions: Sequence[Any] = ()
    initial: Any = ""
    #: A subclass of ``transitions.Machine``; by default chosen by the states.
    machine_class: Any = None
    #: A name, a member of the ``Enum``, or a list of them in parallel states.
    state: Any

    _memory_hooks: ClassVar[frozenset[str]] = frozenset({"setup"})

    def __init__(self, cell: TaskCell) -> None:
        if type(self).decide is MachinePolicy.decide:
            raise Refused(
                line_of(type(self)), f"{type(self).__name__} needs a method decide(self, cell)"
            )
        self._cell = cell
        #: Until the first decision nothing is reported.
        self._shown: list[str] = []
        before = set(vars(self))
        self._machine = make_machine(self, self._changed)
        self._names = _machine_parts.state_names(self._machine)
        self._own = frozenset(set(vars(self)) - before) | {"_own", "_cell", "_shown"}
        self.setup(cell)
        _machine_parts.check_callbacks(self._machine, self)
        self._shown = self._active()

    def setup(self, cell: TaskCell) -> None:
        """Called once, with the machine in its first state."""

    def decide(self, cell: TaskCell) -> None:
        """One decision."""
        raise NotImplementedError

    @property
    def phase(self) -> str:
        """Name of the state; of parallel ones all, with a plus sign between them."""
        return "+".join(self._active())

    def _active(self) -> list[str]:
        return _machine_parts.active(self._machine, self.state)

    def _changed(self, trigger: str) -> None:
        """The state is another one; callbacks of the new state were not called yet."""
        if not self._shown:
            return
        core = self._cell._core
        before, after = self._shown, self._active()
        self._shown = after
        left, entered = self._with_parents(before), self._with_parents(after)
        for name in [one for one in left if one not in entered] or before:
            core.status(0, self._names.index(name), (1, 0), trigger)
        for name in [one for one in entered if one not in left] or after:
            core.status(0, self._names.index(name), (0, 1), trigger)
        core.transition(f"{'+'.join(before)} -> {'+'.join(after)} ({trigger})")

    def _with_parents(self, names: Sequence[str]) -> list[str]:
        separator = self._machine.state_cls.separator if self._is_nested() else ""
        return [
            one
            for one in self._names
            if one in names
            or (separator and any(name.startswith(one + separator) for name in names))
        ]

    def _is_nested(self) -> bool:
        return issubclass(self._machine.state_cls, NestedState)

    def graphs(self, name: str) -> list[dict[str, Any]]:
        nodes = [
            {"id": state, "kind": "state", "name": state, "parent": None, "detail": ""}
            for state in self._names
        ]
        return [{"kind": "machine", "name": name, "nodes": nodes, "edges": self._edges()}]

    def _edges(self) -> list[dict[str, Any]]:
        edges = []
        for prefix, event in _machine_parts.events_of(self._machine):
            rows = [one for found in event.transitions.values() for one in found]
            for transition in rows:
                guards = [
                    f"{'' if guard.target else '!'}{_named(guard.func)}"
                    for guard in transition.conditions
                ]
                label = f"{event.name} [{', '.join(guards)}]" if guards else str(event.name)
                source = f"{prefix}{transition.source}"
                dest = transition.dest or transition.source
                # Of a nested state: one beside it, or the full name.
                dest = f"{prefix}{dest}" if f"{prefix}{dest}" in self._names else dest
                if source in self._names and dest in self._names:
                    ends = (self._names.index(source), self._names.index(dest))
                    edges.append({"from": ends[0], "to": ends[1], "label": label})
        return edges

    def statuses(self, _graph: int) -> list[int]:
        now = self._with_parents(self._active())
        return [int(name in now) for name in self._names]

    def _memory_missing(self) -> str:
        if hasattr(self, "_machine"):
            return ""
        return f"the constructor of {type(self).__name__} does not call super().__init__(cell)"

    def _memory_skip(self) -> frozenset[str]:
        return self._own

    def _memory_handles(self) -> dict[tuple[Any, ...], Any]:
        return {("machine",): self._machine}

    def _memory_parts(self) -> list[Part]:
        """The attributes of states of a class of their own."""
        return [
            Part(f"state {name}", f"state {name}: ", vars(state), state, _COMMON, self, name)
            for name, state in _machine_parts.states_of(self._machine).items()
            if not set(vars(state)) <= _COMMON
        ]

    def _memory_engine(self) -> Any:
        return self._kept(self.state)

    def _kept(self, state: Any) -> Any:
        if isinstance(state, (list, tuple)):
            return [self._kept(one) for one in state]
        return _machine_parts.active(self._machine, state)[0]

    def _memory_restore(self, state: Any, _paths: list[str]) -> None:
        names = _machine_parts.active(self._machine, state)
        gone = [name for name in names if name not in self._names]
        if gone:
            raise ValueError(f"the checkpoint is of another machine: no state {gone[0]}")
        self._machine.set_state(state, model=self)
        self._shown = self._active()


def _named(function: Any) -> str:
    return function if isinstance(function, str) else getattr(function, "__name__", "?")
