"""What the native part calls: one policy of a user, whatever its kind."""

from __future__ import annotations

import inspect
import json
import pickle
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from robocell import _core
from robocell.task._cell import TaskCell
from robocell.task._memory import dump, load

_INVALID, _RUNNING = 0, 1

Maker = Callable[[_core.Moment], "Runner"]


def maker(target: Callable[..., Any]) -> Maker:
    """What makes the runner of a class or function for a cell."""

    def make(core: _core.Moment) -> Runner:
        return Runner(target, TaskCell(core), core)

    return make


class Runner:
    """A policy at work. Its methods are called by the native part."""

    def __init__(self, target: Callable[..., Any], cell: TaskCell, core: _core.Moment) -> None:
        self._target = target
        self._cell = cell
        self._core = core
        self._job = self._new()

    def _new(self) -> Any:
        target = self._target
        if not inspect.isclass(target):
            return _Function(target)
        make: Callable[..., Any] = target
        return make(self._cell) if _takes(make, 1) else make()

    def reset(self) -> None:
        """Back to the state before the first decision."""
        self._job = self._new()

    def decide(self) -> str:
        """One decision; the name of the phase."""
        self._job.decide(self._cell)
        return self._phase()

    def reconcile(self) -> str:
        """Decisions were missed, or the operator led the arm."""
        reconcile = getattr(self._job, "reconcile", None)
        if reconcile is not None:
            reconcile(self._cell)
        return self._phase()

    def _phase(self) -> str:
        phase = getattr(self._job, "phase", "")
        return phase if isinstance(phase, str) else str(phase)

    def save(self) -> bytes:
        """The memory of the policy; empty where it has none that can be kept."""
        save = getattr(self._job, "save", None)
        try:
            return dump(save() if save is not None else vars(self._job), self._cell)
        except (pickle.PicklingError, TypeError, AttributeError):
            if save is not None:
                raise
            return b""

    def restore(self, state: bytes) -> str:
        """Takes back what :meth:`save` gave; the name of the phase."""
        if state:
            value = load(state, self._cell)
            restore = getattr(self._job, "restore", None)
            if restore is not None:
                restore(value)
            else:
                vars(self._job).update(value)
        return self._phase()

    def graphs(self, name: str) -> str:
        """The pictures of the policy, as JSON."""
        graphs = getattr(self._job, "graphs", None)
        if graphs is not None:
            return json.dumps(graphs(name))
        phases = self._phases() or [name]
        nodes = [_node(phase) for phase in phases]
        count = len(phases) if len(phases) > 1 else 0
        edges = [{"from": i, "to": (i + 1) % count, "label": ""} for i in range(count)]
        return json.dumps([{"kind": "code", "nodes": nodes, "edges": edges}])

    def statuses(self, graph: int) -> bytes:
        """The status of each node of a picture."""
        statuses = getattr(self._job, "statuses", None)
        if statuses is not None:
            return bytes(statuses(graph))
        phases = self._phases()
        if not phases:
            return bytes([_RUNNING])
        active = self._phase()
        return bytes(_RUNNING if phase == active else _INVALID for phase in phases)

    def _phases(self) -> list[str]:
        return [str(phase) for phase in getattr(self._job, "phases", ())]


def _node(phase: str) -> dict[str, Any]:
    return {"id": phase, "kind": "phase", "name": phase, "parent": None, "detail": ""}


def _takes(target: Callable[..., Any], count: int) -> bool:
    """Whether a callable takes at least ``count`` arguments by position."""
    try:
        inspect.signature(target).bind(*([None] * count))
    except TypeError:
        return False
    except ValueError:
        return True
    return True


class _Function:
    """A policy that is a function; its memory is a namespace."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self._with_memory = _takes(function, 2)
        self.memory = SimpleNamespace()

    @property
    def phase(self) -> str:
        return str(getattr(self.memory, "phase", ""))

    def decide(self, cell: TaskCell) -> None:
        if self._with_memory:
            self._function(cell, self.memory)
        else:
            self._function(cell)

    def save(self) -> dict[str, Any]:
        return vars(self.memory)

    def restore(self, value: dict[str, Any]) -> None:
        self.memory = SimpleNamespace(**value)
