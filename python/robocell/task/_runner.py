"""What the native part calls: one policy of a user, whatever its kind."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, TypeAlias

from robocell import _core
from robocell.task._cell import TaskCell
from robocell.task._explain import explain
from robocell.task._memory import SAVED, Made, Memory, Part, Remembers, attributes
from robocell.task._merge import Merge

_INVALID, _RUNNING = 0, 1

Maker = Callable[[_core.Moment], "Runner"]
#: Lines for the log, with their kinds.
Lines: TypeAlias = list[tuple[str, str]]


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
        self._made: Made | None = None
        self._begin()

    def _begin(self) -> None:
        self._job = self._new()
        self._engine = self._job if isinstance(self._job, Remembers) else Remembers()
        more = {("policy",): self._job, **self._engine._memory_handles()}
        parts = [self._policy_part(), *self._engine._memory_parts()]
        self._memory = Memory(self._cell, parts, more, self._made)
        self._made = self._memory.made
        #: Of the newest decision.
        self._kept: bytes | None = None

    def _new(self) -> Any:
        target = self._target
        if not inspect.isclass(target):
            return _Function(target)
        make: Callable[..., Any] = target
        return make(self._cell) if _takes(make, 1) else make()

    def _policy_part(self) -> Part:
        job = self._job
        if isinstance(job, _Function):
            return Part("", "memory.", vars(job.memory), self._target)
        return Part("", "self.", attributes(job), job, self._engine._memory_skip())

    def reset(self) -> None:
        """Back to the state before the first decision."""
        self._begin()

    def decide(self) -> tuple[str, Lines]:
        """One decision; the name of the phase, and lines for the log."""
        self._job.decide(self._cell)
        # Now, so that what cannot be kept is told in the decision that made it so.
        self._kept = self._save()
        return self._phase(), self._memory.take_lines()

    def reconcile(self) -> tuple[str, Lines]:
        """Decisions were missed, or the operator led the arm."""
        reconcile = getattr(self._job, "reconcile", None)
        self._kept = None
        if reconcile is not None:
            reconcile(self._cell)
        return self._phase(), self._memory.take_lines()

    def _phase(self) -> str:
        phase = getattr(self._job, "phase", "")
        return phase if isinstance(phase, str) else str(phase)

    def save(self) -> bytes:
        """The memory of the policy."""
        return self._save() if self._kept is None else self._kept

    def _save(self) -> bytes:
        own = getattr(self._job, "save", None)
        saved = None
        if own is not None:
            values = {}
            try:
                values[SAVED] = own()
            except Exception as error:  # Of the user's method: the task continues without.
                self._memory.say("warning", f"{explain(error)}; nothing is kept over a restart")
            saved = Part("", "self.", values, self._job)
        return self._memory.save(self._engine._memory_engine(), saved)

    def restore(self, state: bytes) -> tuple[str, bool]:
        """Takes back what :meth:`save` gave, after :meth:`reset`; the name of the phase, and
        whether anything was kept."""
        saved = self._memory.read(state)
        merge = Merge(self._memory, saved)
        merge.run()
        self._made = self._memory.made
        own = getattr(self._job, "restore", None)
        if ("", SAVED) in saved.values:
            value = saved.values["", SAVED]
            if own is not None:
                own(value)
            else:
                self._memory.parts[0].values.update(value)
        if saved.engine is not None:
            self._engine._memory_restore(saved.engine, list(saved.made))
        had_memory = bool(saved.values or saved.unread or saved.lost or saved.has_own)
        is_resumed = bool(merge.kept or ("", SAVED) in saved.values or saved.engine is not None)
        return self._phase(), is_resumed or not had_memory

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
