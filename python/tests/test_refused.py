"""What can be no policy is refused at the start, with the line of its file."""

from __future__ import annotations

import functools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import robocell

pytestmark = pytest.mark.sample

HERE = Path(__file__)


def line_of(text: str) -> str:
    """``FILE:LINE`` of the first line of this file that has that text."""
    lines = HERE.read_text().splitlines()
    return f"{HERE}:{1 + next(i for i, line in enumerate(lines) if text in line)}: "


def make(policy: Any, decisions: int = 1) -> robocell.Cell:
    cell = robocell.Cell("franka-stack", 1, policy=policy)
    # The first decision belongs to the first state.
    cell.step(10 * (decisions - 1))
    return cell


class Asynchronous:
    async def decide(self, cell):  # async decide
        cell.report(True)


class Generates:
    def decide(self, cell):  # yields
        yield


class AsyncGenerates:
    async def decide(self, cell):  # async yields
        yield


async def async_function(cell):
    cell.report(True)


def generator_function(cell, memory):
    yield


class NoCell:
    def decide(self):
        pass


class TooMuch:
    def decide(self, cell, memory):
        pass


class NoDecide:
    def decides(self, cell):
        pass


class Number:
    decide = 7


class OfInstance:
    def __init__(self):
        self.decide = self.generates

    def generates(self, cell):  # of the instance
        yield


class AsyncReconcile:
    def decide(self, cell):
        pass

    async def reconcile(self, cell):
        pass


class BadRestore:
    def decide(self, cell):
        pass

    def restore(self):
        pass


class NeedsTwo:
    def __init__(self, cell, name):  # needs two
        pass

    def decide(self, cell):
        pass


class AsyncInit:
    async def __init__(self, cell):  # async init
        pass

    def decide(self, cell):
        pass


def three(cell, memory, more):
    pass


def none_at_all():
    pass


@pytest.mark.parametrize(
    ("policy", "line", "what"),
    [
        (Asynchronous, "# async decide", "decide is an async function"),
        (Generates, "# yields", "decide is a generator function"),
        (AsyncGenerates, "# async yields", "decide is an async generator"),
        (async_function, "async def async_function", "async_function is an async function"),
        (generator_function, "def generator_function", "generator_function is a generator"),
        (NoCell, "def decide(self):", "decide(self) has other arguments than decide(self, cell)"),
        (TooMuch, "def decide(self, cell, memory)", "has other arguments than decide(self, cell)"),
        (NoDecide, "class NoDecide", "has no method decide(self, cell); is it 'decides'?"),
        (OfInstance, "# of the instance", "decide is a generator function"),
        (AsyncReconcile, "async def reconcile", "reconcile is an async function"),
        (BadRestore, "def restore(self)", "has other arguments than restore(self, state)"),
        (NeedsTwo, "# needs two", "the constructor of NeedsTwo needs more than one argument"),
        (AsyncInit, "# async init", "AsyncInit.__init__ is an async function"),
        (three, "def three", "three cannot be a policy"),
        (none_at_all, "def none_at_all", "a function none_at_all(cell) or"),
    ],
)
def test_a_mistake_is_refused_at_the_start_with_its_line(policy: Any, line: str, what: str):
    with pytest.raises(ValueError) as raised:
        make(policy)
    text = str(raised.value)
    assert line_of(line) in text
    assert what in text


def test_what_is_not_a_function_is_refused():
    with pytest.raises(ValueError, match="decide is 7; a function is needed"):
        make(Number)
    with pytest.raises(ValueError, match="a policy is a class or a function, not 7"):
        make(7)


def plainly(function: Any) -> Any:
    @functools.wraps(function)
    def call(*words: Any) -> Any:
        return function(*words)

    return call


class HidesAsync:
    @plainly
    async def decide(self, cell):
        pass


class HidesGenerator:
    @plainly
    def decide(self, cell):
        yield


@pytest.mark.parametrize("policy", [HidesAsync, HidesGenerator])
def test_a_result_of_which_nothing_was_run_is_refused_in_the_first_decision(policy: Any):
    cell = None
    with pytest.raises(ValueError, match=r"test_refused.py:\d+: decide returned a (coro|gen)"):
        cell = make(policy)
    assert cell is None


class InLibrary:
    def decide(self, cell):
        if cell.time_s > 0:
            json.loads("{")  # in a library


class InNumpy:
    def decide(self, cell):
        if cell.time_s > 0:
            np.linalg.inv(np.zeros((2, 2)))  # in numpy


@pytest.mark.parametrize(
    ("policy", "line", "what"),
    [
        (InLibrary, "# in a library", "in decide: JSONDecodeError"),
        (InNumpy, "# in numpy", "in decide: LinAlgError: Singular matrix"),
    ],
)
def test_an_exception_of_a_library_is_reported_with_the_line_of_the_task(policy, line, what):
    cell = make(policy)
    with pytest.raises(ValueError):
        cell.step(10)
    (fault,) = [line for _, line in cell.log()]
    assert line_of(line) in fault
    assert what in fault


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "from robocell.task import policy\n\n@policy\nclass A:\n    def decide(self, cell):\n"
            "        yield\n",
            "mine.py:5: decide is a generator function",
        ),
        (
            "from robocell.task import policy\n@policy('other')\nasync def f(cell):\n    pass\n"
            "@policy\ndef g(cell):\n    pass\n",
            "mine.py:3: f is an async function",
        ),
        (
            "from robocell.task import policy\n@policy\ndef f(cell):\n    pass\n"
            "@policy\ndef g(cell):\n    pass\n",
            "mine.py:6: this is a second policy 'mine'",
        ),
        ("from robocell.task import policy\npolicy(7)\n", "mine.py:2: in <module>: ValueError"),
    ],
)
def test_a_file_with_a_mistake_is_refused_before_anything_starts(run, task, text, message):
    ended = run("franka-stack", task(text))
    assert ended.code == 3, ended.text
    assert message in ended.text
