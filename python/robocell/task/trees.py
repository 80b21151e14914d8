"""Tasks as py_trees behaviour trees. Needs ``pip install robocell[trees]``."""

from __future__ import annotations

from typing import Any, ClassVar

import py_trees
from py_trees.common import Status as Ended

from robocell._core import Skill, Status
from robocell.task._cell import Arm, TaskCell
from robocell.task._leaves import check_condition, check_nodes, set_up, truth
from robocell.task._memory import Part, Remembers
from robocell.task._refuse import Refused, line_of

_NUMBERS = {Ended.INVALID: 0, Ended.RUNNING: 1, Ended.SUCCESS: 2, Ended.FAILURE: 3}
_ENDED = {Status.RUNNING: Ended.RUNNING, Status.SUCCESS: Ended.SUCCESS}

#: Attributes of every behaviour; the rest is its memory.
_COMMON = frozenset(vars(py_trees.behaviours.Success("common"))) | {
    "current_child",
    "update",
}
#: Attributes of a policy besides its memory.
_OWN = frozenset({"_root", "_tree", "_nodes", "_parents", "_paths", "_shown", "_keys"})


class SkillLeaf(py_trees.behaviour.Behaviour):
    """A leaf that executes a skill with an arm; entered again, it restarts the skill."""

    def __init__(self, name: str, arm: Arm, skill: Skill) -> None:
        super().__init__(name)
        if not isinstance(arm, Arm):
            raise TypeError(f"SkillLeaf '{name}' needs an arm, as cell.arm, not {arm!r}")
        if not (hasattr(skill, "step") and hasattr(skill, "reset")):
            raise TypeError(f"SkillLeaf '{name}' needs a skill, as skills.home(), not {skill!r}")
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
        check_condition(holds, name)
        self._holds = holds

    def update(self) -> Ended:
        return Ended.SUCCESS if truth(self._holds(), self._holds, self.name) else Ended.FAILURE


class TreePolicy(Remembers):
    """A policy that is a tree: a subclass has ``build(self, cell)``, which returns the
    root, and may have ``after(self, cell, status)``, called after each tick.

    The tree is ticked in each decision, also after it succeeded: conditions in front of
    its skills keep finished work from being done twice, and let the job start again when
    it is disturbed. Statuses and the blackboard are shown on the page and by
    ``robocell bt show --live``. The checkpoint holds the status of each node, the
    attributes of the policy and of behaviours, and the blackboard, as far as they can be
    pickled. After an edit of the file nodes are found by their path of names. A behaviour that
    has ``setup(**kwargs)`` is given ``cell`` there, once. The result of ``update`` is checked.
    Behaviours that read a clock (``Timeout``) make a run unrepeatable.
    """

    _memory_hooks: ClassVar[frozenset[str]] = frozenset({"build", "after"})

    def __init__(self, cell: TaskCell) -> None:
        py_trees.blackboard.Blackboard.clear()
        kind = type(self)
        if kind.build is TreePolicy.build:
            raise Refused(line_of(kind), f"{kind.__name__} needs a method build(self, cell)")
        self._root = self.build(cell)
        if not isinstance(self._root, py_trees.behaviour.Behaviour):
            raise Refused(
                line_of(kind.build), f"build returned {self._root!r}; the root of a tree is needed"
            )
        self._tree = py_trees.trees.BehaviourTree(self._root)
        self._nodes: list[Any] = []
        self._parents: list[int | None] = []
        self._paths: list[str] = []
        self._list(self._root, None, "")
        self._shown = [0] * len(self._nodes)
        self._keys: dict[str, Any] = {}
        check_nodes(self._nodes)
        set_up(self._nodes, cell)

    def build(self, cell: TaskCell) -> Any:
        """The root of the tree."""
        raise NotImplementedError

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

    def _list(self, node: Any, parent: int | None, path: str) -> None:
        index = len(self._nodes)
        self._nodes.append(node)
        self._parents.append(parent)
        self._paths.append(path or "/")
        names: list[str] = []
        for child in node.children:
            # Those of equal names are counted.
            same = names.count(child.name)
            names.append(child.name)
            own = f"{child.name}#{same}" if same else child.name
            self._list(child, index, f"{path}/{own}")

    def _tell(self, cell: TaskCell) -> None:
        """Traces the changes."""
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

    def _memory_missing(self) -> str:
        if hasattr(self, "_root"):
            return ""
        return f"the constructor of {type(self).__name__} does not call super().__init__(cell)"

    def _memory_skip(self) -> frozenset[str]:
        return _OWN

    def _memory_parts(self) -> list[Part]:
        """The attributes of nodes, and the blackboard."""
        nodes = zip(self._paths, self._nodes, strict=True)
        parts = [
            Part(path, f"{path}: self.", vars(node), node, _COMMON, self, str(node.name))
            for path, node in nodes
        ]
        board = py_trees.blackboard.Blackboard.storage
        return [*parts, Part("blackboard", "blackboard ", board, self)]

    def _memory_handles(self) -> dict[tuple[Any, ...], Any]:
        handles: dict[tuple[Any, ...], Any] = {}
        for path, node in zip(self._paths, self._nodes, strict=True):
            handles["node", path] = node
            for index, client in enumerate(node.blackboards):
                handles["blackboard client", path, index] = client
        return handles

    def _memory_engine(self) -> list[tuple[int, int]]:
        """The status of each node, and the number of the child it is at, -1 for none."""
        numbers = {id(node): index for index, node in enumerate(self._nodes)}
        return [
            (_NUMBERS[node.status], numbers.get(id(getattr(node, "current_child", None)), -1))
            for node in self._nodes
        ]

    def _memory_restore(self, engine: list[tuple[int, int]], paths: list[str]) -> None:
        by_number = {number: status for status, number in _NUMBERS.items()}
        by_path = dict(zip(self._paths, self._nodes, strict=True))
        # The order of the nodes that were saved, each a part behind the policy.
        nodes = [by_path.get(path) for path in paths[1:]]
        for node, (status, at) in zip(nodes, engine, strict=False):
            child = nodes[at] if at >= 0 else None
            # Without the child it was at, a node of an edited tree restarts.
            if node is None or (at >= 0 and child is None):
                continue
            node.status = by_number[status]
            if child is not None:
                node.current_child = child
        self._shown = [_NUMBERS[node.status] for node in self._nodes]
