"""Tasks as py_trees behaviour trees. Needs ``pip install robocell[trees]``."""

from __future__ import annotations

from typing import Any

import py_trees
from py_trees.common import Status as Ended

from robocell._core import Skill, Status
from robocell.task._cell import Arm, TaskCell
from robocell.task._memory import Keepable

_NUMBERS = {Ended.INVALID: 0, Ended.RUNNING: 1, Ended.SUCCESS: 2, Ended.FAILURE: 3}
_ENDED = {Status.RUNNING: Ended.RUNNING, Status.SUCCESS: Ended.SUCCESS}

#: What every behaviour has; the rest of its attributes is its memory.
_COMMON = frozenset(vars(py_trees.behaviours.Success("common")))


class SkillLeaf(py_trees.behaviour.Behaviour):
    """A leaf that works off a skill with an arm; entered again, it begins the skill."""

    def __init__(self, name: str, arm: Arm, skill: Skill) -> None:
        super().__init__(name)
        self.arm = arm
        self.skill = skill

    def initialise(self) -> None:
        self.skill.reset()

    def update(self) -> Ended:
        return _ENDED.get(self.arm.do(self.skill), Ended.FAILURE)


class Condition(py_trees.behaviour.Behaviour):
    """A leaf that succeeds while ``holds()`` is true, and fails otherwise."""

    def __init__(self, name: str, holds: Any) -> None:
        super().__init__(name)
        self._holds = holds

    def update(self) -> Ended:
        return Ended.SUCCESS if self._holds() else Ended.FAILURE


class TreePolicy:
    """A policy that is a tree: a subclass has ``build(self, cell)``, which returns the
    root, and may have ``after(self, cell, status)``, called after each tick.

    The tree is ticked in each decision, also after it succeeded: conditions in front of
    its skills keep finished work from being done twice, and let the job start again when
    it is disturbed. Statuses and the blackboard are shown on the page and by
    ``robocell bt show --live``. The checkpoint holds the status of each node, the
    attributes of behaviours and the blackboard, as far as they can be pickled.
    Behaviours that read a clock (``Timeout``) make a run unrepeatable.
    """

    def __init__(self, cell: TaskCell) -> None:
        py_trees.blackboard.Blackboard.clear()
        self._root = self.build(cell)
        self._tree = py_trees.trees.BehaviourTree(self._root)
        self._nodes: list[Any] = []
        self._parents: list[int | None] = []
        self._list(self._root, None)
        self._index = {node.id: index for index, node in enumerate(self._nodes)}
        self._shown = [0] * len(self._nodes)
        self._keys: dict[str, Any] = {}
        self._keepable = Keepable(cell)

    def build(self, cell: TaskCell) -> Any:
        """The root of the tree."""
        raise NotImplementedError(f"{type(self).__name__} needs a method build(self, cell)")

    def after(self, cell: TaskCell, status: Ended) -> None:
        """Called after each tick with the status of the root."""
        cell.report(status == Ended.SUCCESS)

    @property
    def phase(self) -> str:
        """Name of the leaf that runs."""
        if self._root.status == Ended.SUCCESS:
            return "DONE"
        tip = self._root.tip()
        return "" if tip is None else str(tip.name)

    def decide(self, cell: TaskCell) -> None:
        self._tree.tick()
        self._tell(cell)
        self.after(cell, self._root.status)

    def _list(self, node: Any, parent: int | None) -> None:
        index = len(self._nodes)
        self._nodes.append(node)
        self._parents.append(parent)
        for child in node.children:
            self._list(child, index)

    def _tell(self, cell: TaskCell) -> None:
        """Traces what changed."""
        core = cell._core
        for index, node in enumerate(self._nodes):
            now = _NUMBERS[node.status]
            if now != self._shown[index]:
                core.status(0, index, (self._shown[index], now), node.feedback_message)
                self._shown[index] = now
        for key, value in py_trees.blackboard.Blackboard.storage.items():
            # Quantities change with every look and are left out.
            if isinstance(value, (str, bool, int)) and self._keys.get(key) != value:
                self._keys[key] = value
                core.key(0, "blackboard", key.lstrip("/"), str(value))

    def graphs(self, name: str) -> list[dict[str, Any]]:
        nodes = [self._drawn(index) for index in range(len(self._nodes))]
        return [{"kind": "tree", "name": name, "nodes": nodes, "edges": []}]

    def _drawn(self, index: int) -> dict[str, Any]:
        node = self._nodes[index]
        same = [other for other in self._nodes[:index] if other.name == node.name]
        kind = "Skill" if isinstance(node, SkillLeaf) else type(node).__name__
        return {
            "id": f"{node.name}#{len(same)}" if same else str(node.name),
            "kind": kind.lower() if node.children else kind,
            "name": str(node.name),
            "parent": self._parents[index],
            "detail": repr(node.skill) if isinstance(node, SkillLeaf) else "",
        }

    def statuses(self, _graph: int) -> list[int]:
        return [_NUMBERS[node.status] for node in self._nodes]

    def save(self) -> dict[str, Any]:
        nodes = []
        for index, node in enumerate(self._nodes):
            child = getattr(node, "current_child", None)
            nodes.append(
                {
                    "status": _NUMBERS[node.status],
                    "child": None if child is None else self._index[child.id],
                    "memory": self._keepable.of(index, node, _COMMON | {"current_child"}),
                }
            )
        board = py_trees.blackboard.Blackboard.storage
        return {
            "nodes": nodes,
            "board": self._keepable.values("board", board),
        }

    def restore(self, state: dict[str, Any]) -> None:
        names = [node.name for node in self._nodes]
        if len(state["nodes"]) != len(names):
            raise ValueError(f"the checkpoint is of another tree: {len(names)} nodes here")
        by_number = {number: status for status, number in _NUMBERS.items()}
        for node, saved in zip(self._nodes, state["nodes"], strict=True):
            node.status = by_number[saved["status"]]
            vars(node).update(saved["memory"])
            if saved["child"] is not None:
                node.current_child = self._nodes[saved["child"]]
        self._shown = [_NUMBERS[node.status] for node in self._nodes]
        py_trees.blackboard.Blackboard.storage.update(state["board"])
