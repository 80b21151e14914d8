"""Trees from files, whose leaves are classes and functions of this file.

A tree file declares the leaves that it needs; ``robocell bt import`` writes such files from
trees of BehaviorTree.CPP.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from robocell._core import FileTree, Status
from robocell.task._cell import TaskCell
from robocell.task._memory import Part, Remembers

__all__ = ["Leaf", "Ports", "TreeFile"]

#: Attributes of a policy besides its memory.
_OWN = frozenset({"_tree", "_nodes", "_leaves", "_shown", "_keys", "_cell"})


class Ports(Mapping[str, Any]):
    """The ports of a leaf in one call: reading gives the value of a literal or of a key,
    and setting one writes its key. A key without a value is not in it."""

    def __init__(self, values: dict[str, Any]) -> None:
        self._values = values
        self._writes: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __setitem__(self, name: str, value: Any) -> None:
        self._values[name] = self._writes[name] = value

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)


class Leaf:
    """A leaf. Its attributes are its memory; there is one object for each node."""

    def start(self, cell: TaskCell, ports: Ports) -> None:
        """Called before the first tick of each run."""

    def tick(self, cell: TaskCell, ports: Ports) -> Status | bool:
        """One tick of work: a status, or whether it succeeded."""
        raise NotImplementedError(f"{type(self).__name__} needs a method tick(self, cell, ports)")

    def halt(self, cell: TaskCell, ports: Ports) -> None:
        """Called when it is stopped while it runs."""

    def place(self) -> str:
        """``FILE:LINE`` of its code."""
        code = type(self).tick.__code__
        return f"{code.co_filename}:{code.co_firstlineno}"


class _Function(Leaf):
    """A leaf that is a function of the cell and the ports."""

    def __init__(self, function: Callable[[TaskCell, Ports], Status | bool]) -> None:
        self._function = function

    def tick(self, cell: TaskCell, ports: Ports) -> Status | bool:
        return self._function(cell, ports)

    def place(self) -> str:
        code = getattr(self._function, "__code__", None)
        return f"{code.co_filename}:{code.co_firstlineno}" if code else repr(self._function)


class TreeFile(Remembers):
    """A policy that is a tree in a file: a subclass names it, and has its leaves::

        @policy
        class Fetch(TreeFile):
            file = "fetch.tree.json"
            leaves = {"Grasp": Grasp, "IsHeld": lambda cell, ports: cell.arm.held is not None}

    The file is beside the file of the policy. A leaf is a subclass of :class:`Leaf`, or a
    function of the cell and the ports that answers a status or a truth value. The tree is
    ticked in each decision until it succeeds. The checkpoint holds the state of the tree,
    its blackboard, and the attributes of the policy and of its leaves.
    """

    #: Path of the tree file.
    file: ClassVar[str] = ""
    #: By type, the name of a leaf in the tree file.
    leaves: ClassVar[Mapping[str, Any]] = {}

    def __init__(self, cell: TaskCell) -> None:
        if not self.file:
            raise TypeError(f"{type(self).__name__} needs file = 'NAME.tree.json'")
        folder = Path(inspect.getfile(type(self))).parent

        def include(name: str) -> str:
            return ((folder / self.file).parent / name).read_text("utf-8")

        text = (folder / self.file).read_text("utf-8")
        self._tree = FileTree(self.file, text, list(self.leaves), include)
        self._nodes: list[dict[str, Any]] = json.loads(self._tree.graph())["nodes"]
        self._leaves: dict[str, Leaf] = {}
        for node in self._nodes:
            kind = node["kind"].removeprefix("condition ")
            if kind in self.leaves:
                self._leaves[node["id"]] = _made(self.leaves[kind])
        self._shown = bytes(len(self._nodes))
        self._keys: dict[str, str] = {}
        self._cell = cell
        self.done = False

    def replace(self, rules: str) -> None:
        """Makes leaves answer without being run, by rules as JSON."""
        self._tree.replace(rules)

    def after(self, cell: TaskCell, status: Status) -> None:
        """Called after each tick with the status of the root."""
        cell.report(status == Status.SUCCESS)

    @property
    def phase(self) -> str:
        """Name of the node that gave the answer."""
        tip = self._tree.tip()
        return "" if tip is None else str(self._nodes[tip]["name"])

    def decide(self, cell: TaskCell) -> None:
        status = Status.SUCCESS
        if not self.done:
            status = self._tree.tick(round(cell.time_s * 1000), self._call)
            self.done = status == Status.SUCCESS
        self._tell(cell)
        self.after(cell, status)

    def _call(self, node: str, what: str, values: dict[str, Any]) -> tuple[Status, dict[str, Any]]:
        leaf, ports = self._leaves[node], Ports(values)
        answer = getattr(leaf, what)(self._cell, ports)
        if what != "tick":
            return Status.SUCCESS, ports._writes
        if isinstance(answer, bool | np.bool_):
            answer = Status.SUCCESS if answer else Status.FAILURE
        if not isinstance(answer, Status):
            raise TypeError(
                f"{leaf.place()}: leaf '{node}' answered {answer!r}; RUNNING, SUCCESS, FAILURE, "
                "True or False is needed"
            )
        return answer, ports._writes

    def _tell(self, cell: TaskCell) -> None:
        """Traces the changes."""
        core = cell._core
        statuses = self._tree.statuses()
        for index, (before, now) in enumerate(zip(self._shown, statuses, strict=True)):
            if before != now:
                core.status(0, index, (before, now), "")
        self._shown = statuses
        for key, value in self._tree.values():
            if self._keys.get(key) != value:
                self._keys[key] = value
                core.key(0, "local", key, value)

    def graphs(self, name: str) -> list[dict[str, Any]]:
        return [{"kind": "tree", "name": name, "nodes": self._nodes, "edges": []}]

    def statuses(self, _graph: int) -> list[int]:
        return list(self._tree.statuses())

    def _memory_skip(self) -> frozenset[str]:
        return _OWN

    def _memory_parts(self) -> list[Part]:
        own = frozenset({"_function"})
        return [
            Part(f"leaf {node}", f"{node}: self.", vars(leaf), leaf, own, self, node)
            for node, leaf in self._leaves.items()
        ]

    def _memory_engine(self) -> bytes:
        return self._tree.save()

    def _memory_restore(self, engine: bytes, _paths: list[str]) -> None:
        self._tree.restore(engine)
        self._shown = self._tree.statuses()


def _made(kind: Any) -> Leaf:
    if inspect.isclass(kind):
        made = kind()
        if not isinstance(made, Leaf):
            raise TypeError(f"{kind.__name__} is not a subclass of robocell.task.files.Leaf")
        return made
    return _Function(kind)
