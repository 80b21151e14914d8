"""The interface of the native part: one policy of a user, of any kind."""

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
from robocell.task._refuse import (
    Refused,
    check_call,
    check_kind,
    check_result,
    did_you_mean,
    line_of,
    takes,
)

_INVALID, _RUNNING = 0, 1

Maker = Callable[[_core.Moment], "Runner"]
#: Lines for the log, with their kinds.
Lines: TypeAlias = list[tuple[str, str]]


def maker(target: Callable[..., Any]) -> Maker:
    """A function that makes the runner of a class or function for a cell.

    Raises:
        Refused: for an object that cannot be a policy.
    """
    _check_target(target)

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
        self._rules = ""
        self._begin()

    def _begin(self) -> None:
        self._job = self._new()
        if self._rules:
            self._job.replace(self._rules)
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
        job = make(self._cell) if takes(make, 1) else make()
        _check_job(job)
        return job

    def _policy_part(self) -> Part:
        job = self._job
        if isinstance(job, _Function):
            return Part("", "memory.", vars(job.memory), self._target)
        return Part("", "self.", attributes(job), job, self._engine._memory_skip())

    def replace(self, rules: str) -> None:
        """Makes leaves answer without being run, by rules as JSON; before the first decision."""
        # A tree of py_trees is code: its author replaces a leaf in it.
        from robocell.task.files import TreeFile

        if not isinstance(self._job, TreeFile):
            raise ValueError(
                "it is not a tree in a file (TreeFile), and only leaves of such trees are replaced"
            )
        self._rules = rules
        self._job.replace(rules)

    def reset(self) -> None:
        """Back to the state before the first decision."""
        self._begin()

    def decide(self) -> tuple[str, Lines]:
        """One decision; the name of the phase, and lines for the log."""
        check_result(self._job.decide(self._cell), self._decider(), "decide")
        # Now, so that a value that cannot be kept is reported in the decision that set it.
        self._kept = self._save()
        return self._phase(), self._memory.take_lines()

    def _decider(self) -> Any:
        """The function of the user that decides."""
        return self._target if isinstance(self._job, _Function) else self._job.decide

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
        """Restores the value of :meth:`save`, after :meth:`reset`; the name of the phase, and
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


#: The methods of a policy that are called, with their arguments.
_METHODS = {
    "decide": (1, "decide(self, cell)"),
    "reconcile": (1, "reconcile(self, cell)"),
    "save": (0, "save(self)"),
    "restore": (1, "restore(self, state)"),
    "setup": (1, "setup(self, cell)"),
    "build": (1, "build(self, cell)"),
    "after": (2, "after(self, cell, status)"),
}
#: Those of every policy; a tree and a machine have more.
_OF_ALL = frozenset({"decide", "reconcile", "save", "restore"})


def _check_target(target: Any) -> None:
    """Refuses objects that cannot be a policy, before any call of them."""
    if not inspect.isclass(target):
        if not callable(target):
            raise Refused("", f"a policy is a class or a function, not {target!r}")
        name = getattr(target, "__name__", type(target).__name__)
        check_kind(target, name)
        if not (takes(target, 1) or takes(target, 2)):
            raise Refused(
                line_of(target),
                f"{name} cannot be a policy: that is a class with decide(self, cell), or a "
                f"function {name}(cell) or {name}(cell, memory)",
            )
        return
    check_kind(target.__init__, f"{target.__name__}.__init__")
    if not (takes(target, 0) or takes(target, 1)):
        raise Refused(
            line_of(target.__init__),
            f"the constructor of {target.__name__} needs more than one argument; it is called as "
            f"{target.__name__}(cell) or {target.__name__}()",
        )
    called = _OF_ALL | (target._memory_hooks if issubclass(target, Remembers) else frozenset())
    for name, (count, usage) in _METHODS.items():
        function = inspect.getattr_static(target, name, None)
        if inspect.isfunction(function) and name in called:
            check_call(function, 1 + count, name, usage)


def _check_job(job: Any) -> None:
    """Refuses a policy that was just made: methods may be attributes, too."""
    kind = type(job)
    missing = job._memory_missing() if isinstance(job, Remembers) else ""
    if missing:
        raise Refused(line_of(kind), missing)
    if not hasattr(job, "decide"):
        names = [name for name in dir(kind) if not name.startswith("_")]
        found = did_you_mean("decide", names).replace("did you mean", "is it")
        raise Refused(
            line_of(kind), f"the class {kind.__name__} has no method decide(self, cell){found}"
        )
    for name, (count, usage) in _METHODS.items():
        if name in _OF_ALL and (function := getattr(job, name, None)) is not None:
            check_call(function, count, name, usage)


class _Function:
    """A policy that is a function; its memory is a namespace."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self._with_memory = takes(function, 2)
        self.memory = SimpleNamespace()

    @property
    def phase(self) -> str:
        return str(getattr(self.memory, "phase", ""))

    def decide(self, cell: TaskCell) -> Any:
        return self._function(cell, self.memory) if self._with_memory else self._function(cell)
