"""What a policy remembers over a restart."""

from __future__ import annotations

import random
import threading
from pathlib import Path
from typing import Any, ClassVar

import pytest

import robocell
from robocell.task import TaskCell, skills

pytestmark = pytest.mark.sample

HERE = Path(__file__)


def line_of(text: str) -> str:
    """``FILE:LINE`` of the first line of this file that ends so."""
    lines = HERE.read_text().splitlines()
    return f"{HERE}:{1 + next(i for i, line in enumerate(lines) if line.endswith(text))}"


def make(policy: Any, ticks: int = 0) -> robocell.Cell:
    cell = robocell.Cell("franka-stack", 1, policy=policy)
    cell.step(ticks)
    return cell


def log_of(cell: robocell.Cell) -> list[str]:
    return [line for _, line in cell.log()]


def restarted(old: Any, new: Any, ticks: int = 100) -> tuple[Any, list[str]]:
    """A task of the class ``new`` that resumes from the checkpoint of one of the class
    ``old``, as after an edit of its file: the policy after one more decision, and what the
    log says then."""
    made: list[Any] = []

    class Made(new):  # type: ignore[misc]
        def __init__(self, cell: TaskCell) -> None:
            super().__init__(cell)
            made.append(self)

    cell = make(Made)
    cell.log()
    cell.restore(make(old, ticks).snapshot())
    cell.step(10)
    return made[-1], log_of(cell)


class Counts:
    """Counts decisions, in its own attribute and in an object with two owners."""

    target = 0.25

    def __init__(self, cell: TaskCell) -> None:
        self.y = self.target
        self.shared = {"count": 0}
        self.again = [self.shared]
        self.count = 0

    def decide(self, cell: TaskCell) -> None:
        self.count += 1
        self.shared["count"] += 1


class Edited(Counts):
    target = -0.25


class Shorter(Counts):
    def __init__(self, cell: TaskCell) -> None:
        super().__init__(cell)
        del self.again


def test_an_object_that_two_attributes_share_is_one_object_after_a_restart():
    policy, log = restarted(Counts, Counts)
    assert policy.again[0] is policy.shared
    assert policy.count == policy.shared["count"] == 12
    assert log == []


def test_an_edited_constant_is_that_of_the_file_and_the_rest_that_of_the_checkpoint():
    policy, log = restarted(Counts, Edited)
    assert (policy.y, policy.count) == (-0.25, 12)
    where = line_of("self.y = self.target")
    assert log[0].startswith("[task] self.y is that of the edited file: -0.25 (")
    assert where in log[0]
    assert log[1] == "[task] from the checkpoint: self.again, self.count, self.shared"


def test_an_attribute_that_the_edited_file_does_not_set_is_gone():
    policy, log = restarted(Counts, Shorter)
    assert not hasattr(policy, "again")
    assert policy.count == 12
    assert log[0] == "[task] self.again is not set by the edited file"


class Locked(Counts):
    def __init__(self, cell: TaskCell) -> None:
        super().__init__(cell)
        self.lock = threading.Lock()


def test_an_attribute_that_cannot_be_kept_is_named_in_the_first_decision_and_the_rest_is_kept():
    cell = make(Locked)
    (line,) = log_of(cell)
    where = line_of("self.lock = threading.Lock()")
    assert line.startswith(f"[warning] {where}: self.lock is not kept over a restart: TypeError")
    cell.step(100)
    assert cell.log() == []
    policy, _ = restarted(Locked, Locked)
    assert policy.count == 12
    assert policy.lock.acquire(blocking=False)


class Later(Counts):
    """From the third decision to the fifth its attribute cannot be kept."""

    def decide(self, cell: TaskCell) -> None:
        super().decide(cell)
        if self.count == 3:
            self.shared["steps"] = (n for n in range(3))
        if self.count == 6:
            del self.shared["steps"]


def test_an_attribute_that_stops_being_kept_is_named_in_that_decision_and_kept_again_later():
    cell = make(Later, 10)
    assert cell.log() == []
    cell.step(10)
    lines = log_of(cell)
    # Both owners of the object.
    assert [line.split(": ")[1].split(" is")[0] for line in lines] == ["self.shared", "self.again"]
    assert "'generator'" in lines[0]
    policy, _ = restarted(Later, Later, 20)
    assert policy.count == 4
    assert policy.shared == {"count": 1}
    policy, _ = restarted(Later, Later, 100)
    assert policy.count == policy.shared["count"] == 12
    assert policy.again[0] is policy.shared


class Random(Counts):
    made: ClassVar[list[float]] = []
    used: ClassVar[list[float]] = []

    def __init__(self, cell: TaskCell) -> None:
        super().__init__(cell)
        self.number = random.random()
        self.made.append(self.number)

    def decide(self, cell: TaskCell) -> None:
        self.used.append(self.number)


def test_a_value_that_is_another_one_in_each_constructor_is_not_an_edit():
    _, log = restarted(Random, Random)
    before, after = Random.used[-2:]
    assert before == after != Random.made[-1]
    assert log == []


class Bad:
    """Can be pickled, but not be read again."""

    def __reduce__(self) -> Any:
        return (int, ("no number",))


class Unreadable(Counts):
    def __init__(self, cell: TaskCell) -> None:
        super().__init__(cell)
        self.bad = [self.shared, Bad()]
        self.last = [self.shared, "kept"]


def test_an_attribute_that_cannot_be_read_is_named_and_the_others_are_restored():
    policy, log = restarted(Unreadable, Unreadable)
    where = line_of("self.bad = [self.shared, Bad()]")
    (line,) = log
    assert line.startswith(f"[warning] {where}: self.bad is not restored: ValueError: invalid")
    assert policy.count == policy.shared["count"] == 12
    assert policy.last[0] is policy.shared


class Slotted:
    __slots__ = ("count", "steps", "unset")

    def __init__(self, cell: TaskCell) -> None:
        self.count = 0
        self.steps = {"pick", "place", "home"}

    def decide(self, cell: TaskCell) -> None:
        self.count += 1
        self.steps.discard("place")


def test_slots_and_sets_are_kept():
    policy, log = restarted(Slotted, Slotted)
    assert (policy.count, policy.steps) == (12, {"pick", "home"})
    assert log == []


class Saves(Counts):
    def save(self) -> Any:
        return {"count": self.count}

    def restore(self, state: Any) -> None:
        self.count = 1000 + state["count"]


class SavesLock(Saves):
    def save(self) -> Any:
        return threading.Lock()


class FailsToSave(Saves):
    def save(self) -> Any:
        return 1 / 0


def test_a_policy_may_save_and_restore_itself():
    policy, log = restarted(Saves, Saves)
    assert (policy.count, policy.y) == (1012, 0.25)
    assert log == []


@pytest.mark.parametrize(
    ("policy", "where", "why"),
    [
        (SavesLock, "class SavesLock(Saves):", "self.save() is not kept over a restart: TypeErr"),
        (FailsToSave, "class FailsToSave(Saves):", "in save: ZeroDivisionError: division by zero"),
    ],
)
def test_a_save_that_fails_is_named_once_and_the_task_continues(policy: Any, where: str, why: str):
    cell = make(policy, 100)
    (line,) = log_of(cell)
    path, number = line_of(where).rsplit(":", 1)
    # The line of the method, or of the statement that raised the exception.
    assert any(line.startswith(f"[warning] {path}:{int(number) + n}: ") for n in (1, 2)), line
    assert why in line
    again, _ = restarted(policy, policy)
    assert again.count == 1


class Watches(Counts):
    def __init__(self, cell: TaskCell) -> None:
        super().__init__(cell)
        self.position = cell.objects["red_cube"].position
        self.at = cell.arm.tcp_position[:2]

    def decide(self, cell: TaskCell) -> None:
        super().decide(cell)
        assert (self.position == cell.objects["red_cube"].position).all()
        assert (self.at == cell.arm.tcp_position[:2]).all()
        cell.arm.send((0.4, 0.1, 0.3))


def test_an_array_that_shows_the_newest_decision_does_so_after_a_restart():
    policy, log = restarted(Watches, Watches, 500)
    assert policy.count == 52
    assert log == []


def test_a_skill_is_resumed_where_it_was():
    class Picks:
        def __init__(self, cell: TaskCell) -> None:
            self.skill = skills.pick("red_cube")

        def decide(self, cell: TaskCell) -> None:
            cell.arm.do(self.skill)

    whole = make(Picks, 1500)
    cell = make(Picks)
    cell.restore(make(Picks, 700).snapshot())
    cell.step(800)
    assert cell.state_hash == whole.state_hash


def trees() -> Any:
    py_trees = pytest.importorskip("py_trees")
    from robocell.task.trees import Condition, TreePolicy

    class Note(py_trees.behaviour.Behaviour):  # type: ignore[misc]
        def __init__(self, name: str, shared: dict[str, int], most: int) -> None:
            super().__init__(name)
            self.shared, self.most, self.count = shared, most, 0

        def initialise(self) -> None:
            self.count = 0

        def update(self) -> Any:
            self.count += 1
            self.shared["sum"] += 1
            done = self.count >= self.most
            return py_trees.common.Status.SUCCESS if done else py_trees.common.Status.RUNNING

    class Tree(TreePolicy):
        names = ("a", "b")

        def build(self, cell: TaskCell) -> Any:
            self.shared = {"sum": 0}
            self.leaves = [Note(name, self.shared, 8) for name in self.names]
            first = Condition("always", lambda: True)
            return py_trees.composites.Sequence("root", True, [first, *self.leaves])

    class Longer(Tree):
        names = ("new", "a", "b")

    return Tree, Longer


def test_leaves_and_the_policy_of_a_tree_share_an_object_after_a_restart():
    tree, _ = trees()
    policy, log = restarted(tree, tree)
    a, b = policy.leaves
    assert policy.shared == {"sum": 13}
    assert (a.count, b.count) == (8, 5)
    assert a.shared is b.shared is policy.shared
    assert a is policy._nodes[2]
    assert log == []


def test_a_skill_of_an_edited_leaf_is_that_of_the_file_with_its_line():
    py_trees = pytest.importorskip("py_trees")
    from robocell.task.trees import SkillLeaf, TreePolicy

    class Tree(TreePolicy):
        y = 0.25

        def build(self, cell: TaskCell) -> Any:
            pick = SkillLeaf("pick it", cell.arm, skills.pick("red_cube"))
            there = skills.move_to((0.4, self.y, 0.4))
            stay = SkillLeaf("stay there", cell.arm, there)
            return py_trees.composites.Sequence("root", True, [pick, stay])

    class Moved(Tree):
        y = -0.25

    _, log = restarted(Tree, Moved, 1000)
    where = line_of('stay = SkillLeaf("stay there", cell.arm, there)')
    assert log[0].startswith("[task] /stay there: self.skill is that of the edited file: move_to((")
    assert f"-0.250, 0.400)) ({where})" in log[0]
    assert "/pick it: self.skill" in log[1]


def test_leaves_of_an_edited_tree_are_found_by_their_path():
    tree, longer = trees()
    policy, log = restarted(tree, longer)
    new, a, b = policy.leaves
    # The sequence continues with the leaf that it was at.
    assert (new.count, a.count, b.count) == (0, 8, 5)
    assert new.shared is a.shared is b.shared is policy.shared
    assert policy.shared == {"sum": 13}
    assert "[task] /new is new in the edited file" in log
