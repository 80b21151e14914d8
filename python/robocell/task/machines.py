"""Tasks as state machines of ``transitions``. Needs ``pip install robocell[machines]``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from transitions import Machine
from transitions.core import Event, EventData

from robocell.task._cell import TaskCell
from robocell.task._memory import Remembers


class _NamedEvent(Event):
    """Remembers which trigger is fired."""

    def _trigger(self, event_data: EventData) -> bool:
        model: Any = event_data.model
        model._trigger = self.name
        return bool(super()._trigger(event_data))


class _Machine(Machine):
    event_cls = _NamedEvent


class MachinePolicy(Remembers):
    """A policy that is a machine: a subclass has ``states``, ``transitions`` and
    ``initial`` in the form of the package ``transitions``, and ``decide(self, cell)``,
    which fires triggers: ``self.grasped()``.

    Conditions and callbacks are methods of the subclass. The states and the last
    transition are shown on the page and by ``robocell fsm show --live``. The checkpoint
    holds the state and the attributes of the policy, as far as they can be pickled.
    """

    states: Sequence[Any] = ()
    transitions: Sequence[Any] = ()
    initial: str = ""
    state: str

    def __init__(self, cell: TaskCell) -> None:
        self._cell = cell
        self._trigger = ""
        before = set(vars(self))
        self._machine = _Machine(
            model=self,
            states=list(self.states),
            transitions=list(self.transitions),
            initial=self.initial or None,
            auto_transitions=False,
            after_state_change="_changed",
        )
        self._own = frozenset(set(vars(self)) - before) | {"_own", "_cell", "_shown"}
        self._names = [str(name) for name in self._machine.states]
        self._own |= {"_names"}
        self._shown = self.state
        self.setup(cell)

    def setup(self, cell: TaskCell) -> None:
        """Called once, with the machine in its first state."""

    def decide(self, cell: TaskCell) -> None:
        """One decision."""
        raise NotImplementedError(f"{type(self).__name__} needs a method decide(self, cell)")

    @property
    def phase(self) -> str:
        """Name of the state."""
        return self.state

    def _changed(self, *_arguments: Any, **_keywords: Any) -> None:
        core = self._cell._core
        left, entered = self._names.index(self._shown), self._names.index(self.state)
        core.status(0, left, (1, 0), self._trigger)
        core.status(0, entered, (0, 1), self._trigger)
        core.transition(f"{self._shown} -> {self.state} ({self._trigger})")
        self._shown = self.state

    def graphs(self, name: str) -> list[dict[str, Any]]:
        nodes = [
            {"id": state, "kind": "state", "name": state, "parent": None, "detail": ""}
            for state in self._names
        ]
        return [{"kind": "machine", "name": name, "nodes": nodes, "edges": self._edges()}]

    def _edges(self) -> list[dict[str, Any]]:
        edges = []
        for trigger, event in self._machine.events.items():
            for source, transitions in event.transitions.items():
                for transition in transitions:
                    guards = [
                        f"{'' if guard.target else '!'}{_named(guard.func)}"
                        for guard in transition.conditions
                    ]
                    label = f"{trigger} [{', '.join(guards)}]" if guards else str(trigger)
                    edges.append(
                        {
                            "from": self._names.index(source),
                            "to": self._names.index(transition.dest or source),
                            "label": label,
                        }
                    )
        return edges

    def statuses(self, _graph: int) -> list[int]:
        return [int(name == self.state) for name in self._names]

    def _memory_skip(self) -> frozenset[str]:
        return self._own

    def _memory_handles(self) -> dict[tuple[Any, ...], Any]:
        return {("machine",): self._machine}

    def _memory_engine(self) -> str:
        return self.state

    def _memory_restore(self, state: str, _paths: list[str]) -> None:
        if state not in self._names:
            raise ValueError(f"the checkpoint is of another machine: no state {state}")
        self._machine.set_state(state, model=self)
        self._shown = state


def _named(function: Any) -> str:
    return function if isinstance(function, str) else getattr(function, "__name__", "?")
