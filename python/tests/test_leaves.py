"""Behaviours of py_trees whose results or methods are wrong are refused with their line."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import pytest

import robocell
from robocell.task import TaskCell, skills

pytest.importorskip("py_trees")

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.meta import create_behaviour_from_function

from robocell.task.trees import Condition, SkillLeaf, TreePolicy

pytestmark = pytest.mark.sample

HERE = Path(__file__)


def line_of(text: str) -> str:
    """``FILE:LINE`` of the first line of this file that has that text."""
    lines = HERE.read_text().splitlines()
    return f"{HERE}:{1 + next(i for i, line in enumerate(lines) if text in line)}: "


def tree(*leaves: Any) -> Any:
    """A policy of a sequence of leaves, each a class or a function that makes one."""

    class Tree(TreePolicy):
        def build(self, cell: TaskCell) -> Any:
            made = [leaf(cell) for leaf in leaves]
            return py_trees.composites.Sequence("root", True, made)

    return Tree


def make(policy: Any, decisions: int = 1) -> robocell.Cell:
    cell = robocell.Cell("franka-stack", 1, policy=policy)
    # The first decision belongs to the first state.
    cell.step(10 * (decisions - 1))
    return cell


class Leaf(Behaviour):  # type: ignore[misc]
    def __init__(self, cell: TaskCell) -> None:
        super().__init__(type(self).__name__)
        self.cell = cell
        self.result: Any = Status.SUCCESS

    def update(self) -> Any:
        return self.result


class ReturnsNothing(Leaf):
    def update(self) -> Any:  # nothing
        self.result = None


class Async(Leaf):
    async def update(self) -> Any:  # async
        return Status.SUCCESS


class Generates(Leaf):
    def update(self) -> Any:  # generates
        yield Status.RUNNING


class AsyncInitialise(Leaf):
    async def initialise(self) -> None:
        pass


class NoStatus(Leaf):
    def terminate(self) -> None:
        pass


def as_function(self: Any) -> Any:
    self.result = 1


def of_function(_cell: TaskCell) -> Any:
    return create_behaviour_from_function(as_function)()


def says_nothing() -> None:  # a condition
    pass


async def is_async() -> bool:
    return True


def needs_more(cell: TaskCell) -> bool:
    return True


@pytest.mark.parametrize(
    ("leaf", "line", "what"),
    [
        (ReturnsNothing, "# nothing", "update of 'ReturnsNothing' returns nothing; Status.RUNNI"),
        (Async, "# async", "update of 'Async' is an async function"),
        (Generates, "# generates", "update of 'Generates' is a generator function"),
        (AsyncInitialise, "async def initialise", "initialise of 'AsyncInitialise' is an async"),
        (NoStatus, "def terminate(self)", "has other arguments than terminate(self, new_status)"),
        (of_function, "def as_function", "update of 'As_function' returns nothing"),
        (lambda _: Condition("c", says_nothing), "# a condition", "holds of 'c' returns nothing"),
        (lambda _: Condition("c", is_async), "async def is_async", "holds of 'c' is an async"),
        (
            lambda _: Condition("c", needs_more),
            "def needs_more",
            "has other arguments than holds()",
        ),
    ],
)
def test_a_leaf_that_cannot_work_is_refused_at_the_start(leaf: Any, line: str, what: str):
    with pytest.raises(ValueError) as raised:
        make(tree(leaf))
    assert line_of(line) in str(raised.value)
    assert what in str(raised.value)


class Sometimes(Leaf):
    def update(self) -> Any:  # sometimes
        if self.cell.time_s < 0:
            return Status.SUCCESS


class OfSkill(Leaf):
    def update(self) -> Any:  # of a skill
        return self.cell.arm.do(skills.wait(1.0))


class Invalid(Leaf):
    def update(self) -> Any:  # invalid
        return Status.INVALID


def plainly(function: Any) -> Any:
    @functools.wraps(function)
    def call(*words: Any) -> Any:
        return function(*words)

    return call


class HidesAsync(Leaf):
    @plainly
    async def update(self) -> Any:  # hides
        return Status.SUCCESS


class Doubles(py_trees.decorators.Decorator):  # type: ignore[misc]
    def update(self) -> Any:  # decorates
        return self.decorated.status == Status.SUCCESS


@pytest.mark.parametrize(
    ("leaf", "line", "what"),
    [
        (Sometimes, "# sometimes", "update of 'Sometimes' returned None; Status.RUNNING, SUCCESS"),
        (OfSkill, "# of a skill", "SkillLeaf(name, arm, skill) translates the status of a skill"),
        (Invalid, "# invalid", "update of 'Invalid' returned <Status.INVALID"),
        (HidesAsync, "# hides", "returned a coroutine, of which nothing was run"),
        (lambda cell: Doubles("twice", Leaf(cell)), "# decorates", "update of 'twice' returned T"),
        (
            lambda cell: Condition("c", lambda: cell.arm.tcp_position),  # an array
            "# an array",
            "holds of 'c' returned array",
        ),
    ],
)
def test_a_wrong_result_is_refused_in_the_first_decision(leaf: Any, line: str, what: str):
    with pytest.raises(ValueError) as raised:
        make(tree(leaf))
    assert line_of(line) in str(raised.value)
    assert what in str(raised.value)


class WithoutBuild(TreePolicy):
    pass


class BuildsNothing(TreePolicy):
    def build(self, cell: TaskCell) -> Any:  # no root
        py_trees.composites.Sequence("root", True)


class ShortAfter(TreePolicy):
    def build(self, cell: TaskCell) -> Any:
        return Leaf(cell)

    def after(self, status: Any) -> None:
        pass


@pytest.mark.parametrize(
    ("policy", "line", "what"),
    [
        (WithoutBuild, "class WithoutBuild", "WithoutBuild needs a method build(self, cell)"),
        (BuildsNothing, "# no root", "build returned None; the root of a tree is needed"),
        (
            ShortAfter,
            "def after(self, status",
            "has other arguments than after(self, cell, status)",
        ),
        (
            tree(lambda cell: SkillLeaf("x", skills.home(), cell.arm)),  # swapped
            "# swapped",
            "SkillLeaf 'x' needs an arm, as cell.arm, not home()",
        ),
        (
            tree(lambda cell: SkillLeaf("x", cell.arm, skills.home)),  # not called
            "# not called",
            "SkillLeaf 'x' needs a skill, as skills.home(), not <function home",
        ),
    ],
)
def test_a_tree_that_cannot_work_is_refused_at_the_start(policy: Any, line: str, what: str):
    with pytest.raises(ValueError) as raised:
        make(policy)
    assert line_of(line) in str(raised.value)
    assert what in str(raised.value)


class SetsUp(Leaf):
    def setup(self, **kwargs: Any) -> None:
        self.result = Status.RUNNING
        self.name = kwargs["cell"].name


class SetsUpAlone(Leaf):
    def setup(self) -> None:
        self.name = "alone"


def test_setup_of_a_behaviour_is_called_with_the_cell():
    assert make(tree(SetsUpAlone, SetsUp)).phase == "franka-stack"
