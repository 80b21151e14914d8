"""Machines of the package transitions: faults that are refused at the start, with their lines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("transitions")

from machines import Base, make
from transitions import Machine
from transitions.extensions import GraphMachine, LockedMachine
from transitions.extensions.asyncio import AsyncMachine
from transitions.extensions.states import Retry, Timeout, add_state_features

from robocell.task import TaskCell
from robocell.task.machines import MachinePolicy

pytestmark = pytest.mark.sample

HERE = Path(__file__)


def refusal(policy: Any) -> str:
    with pytest.raises(ValueError) as raised:
        make(policy)
    return str(raised.value)


def line_of(text: str) -> str:
    """``FILE:LINE`` of the first line of this file that has that text."""
    lines = HERE.read_text().splitlines()
    return f"{HERE}:{1 + next(i for i, line in enumerate(lines) if text in line)}: "


class Asynchronous(Base):
    machine_class = AsyncMachine


class WithLocks(Base):
    machine_class = LockedMachine


class Drawn(Base):
    machine_class = GraphMachine


@add_state_features(Timeout)
class Timed(Machine):
    pass


class WithTimeouts(Base):
    machine_class = Timed


@add_state_features(Retry)
class Retrying(Machine):
    pass


class WithRetries(Base):
    machine_class = Retrying


class OtherAttribute(Base):
    model_attribute = "status"


@pytest.mark.parametrize(
    ("policy", "line", "what"),
    [
        (Asynchronous, "machine_class = AsyncMachine", "AsyncMachine of transitions is not supp"),
        (WithLocks, "machine_class = LockedMachine", "LockedMachine of transitions is not supp"),
        (Drawn, "machine_class = GraphMachine", "GraphMachine of transitions is not supported"),
        (WithTimeouts, "machine_class = Timed", "Timeout of transitions is not supported"),
        (WithRetries, "machine_class = Retrying", "Retry of transitions is not supported"),
        (OtherAttribute, 'model_attribute = "status"', "model_attribute is not supported: the st"),
    ],
)
def test_what_cannot_be_kept_is_refused_by_name_with_its_line(policy: Any, line: str, what: str):
    text = refusal(policy)
    assert line_of(line) in text
    assert what in text


class UnknownInitial(Base):
    initial = "aa"


class UnknownDest(Base):
    transitions = (
        ["go", "a", "b"],
        ["next", "b", "cc"],
    )


class UnknownSource(Base):
    transitions = ({"trigger": "go", "source": ["a", "bb"], "dest": "b"},)


class NumberState(Base):
    states = ("a", 7)


class ShortRow(Base):
    transitions = (["go", "a"],)


class HidesTrigger(Base):
    transitions = (["setup", "a", "b"],)


class NoCondition(Base):
    transitions = ({"trigger": "go", "source": "a", "dest": "b", "conditions": "is_redy"},)

    def is_ready(self) -> bool:
        return True


class AsyncCallback(Base):
    async def on_enter_b(self) -> None:
        pass


class GeneratorCondition(Base):
    transitions = ({"trigger": "go", "source": "a", "dest": "b", "conditions": "is_near"},)

    def is_near(self) -> Any:
        yield True


class ForgotReturn(Base):
    transitions = ({"trigger": "go", "source": "a", "dest": "b", "conditions": "is_there"},)

    def is_there(self) -> Any:
        self.count == 3  # noqa: B015


class TimeoutWithoutFeature(Base):
    states = ("a", {"name": "b", "timeout": 3.0, "on_timeout": "go"}, "c")


class NestedDest(Base):
    states = (  # nested
        {"name": "a", "children": ["x", "y"], "transitions": [["turn", "x", "yy"]]},
        "b",
        "c",
    )


class NestedTrigger(Base):
    states = (  # nested trigger
        {"name": "a", "children": ["x", "y"], "transitions": [["decide", "x", "y"]]},
        "b",
        "c",
    )


class WithoutEvent(Base):
    send_event = True

    def on_enter_b(self) -> None:  # without an event
        pass


class WithoutDecide(MachinePolicy):
    states = ("a",)
    initial = "a"


class WithoutSuper(Base):
    def __init__(self, cell: TaskCell) -> None:
        self.count = 0


@pytest.mark.parametrize(
    ("policy", "line", "what"),
    [
        (UnknownInitial, 'initial = "aa"', "initial aa is not a state; did you mean 'a'?"),
        (UnknownDest, '["next", "b", "cc"],', "dest cc is not a state; did you mean 'c'?"),
        (UnknownSource, '"source": ["a", "bb"]', "source bb is not a state"),
        (NumberState, 'states = ("a", 7)', "the state 7 is not a name"),
        (ShortRow, 'transitions = (["go", "a"],)', "needs a trigger, a source and a dest"),
        (HidesTrigger, '(["setup", "a", "b"],)', "the trigger 'setup' has the name of a method"),
        (NoCondition, '"conditions": "is_redy"', "did you mean 'is_ready'?"),
        (AsyncCallback, "async def on_enter_b", "on_enter 'on_enter_b' is an async function"),
        (GeneratorCondition, "def is_near", "condition 'is_near' is a generator function"),
        (ForgotReturn, "def is_there", "condition 'is_there' returns nothing; True or False"),
        (TimeoutWithoutFeature, '"timeout": 3.0', "timeout is not supported: it counts seconds"),
        (NestedDest, "# nested", "dest yy of the trigger 'turn' is not a state; did you mean 'y'"),
        (NestedTrigger, "# nested trigger", "the trigger 'decide' has the name of a method"),
        (WithoutEvent, "# without an event", "has other arguments than on_enter_b(self, event)"),
        (WithoutDecide, "class WithoutDecide", "WithoutDecide needs a method decide(self, cell)"),
        (WithoutSuper, "class WithoutSuper", "does not call super().__init__(cell)"),
    ],
)
def test_a_mistake_is_refused_at_the_start_with_its_line(policy: Any, line: str, what: str):
    text = refusal(policy)
    assert line_of(line) in text
    assert what in text


class ByName(Base):
    transitions = ({"trigger": "go", "source": "a", "dest": "b", "conditions": "held"},)

    def held(self) -> Any:
        return "red_cube"


class UnlessNone(Base):
    transitions = ({"trigger": "go", "source": "a", "dest": "b", "unless": "lost"},)

    def lost(self) -> Any:
        return self.seen[0] if self.seen else None


class OfAttribute(Base):
    transitions = ({"trigger": "go", "source": "a", "dest": "b", "conditions": "seen"},)

    def decide(self, cell: TaskCell) -> None:
        self.seen = ["a"]
        self.go()  # of an attribute


@pytest.mark.parametrize(
    ("policy", "line", "what"),
    [
        (ByName, "def held", "condition 'held' is 'red_cube'; True or False is needed"),
        (UnlessNone, "def lost", "condition 'lost' is None; True or False is needed"),
        (OfAttribute, "# of an attribute", "condition 'seen' is ['a']; True or False is needed"),
    ],
)
def test_a_condition_that_never_holds_is_refused(policy: Any, line: str, what: str):
    class Later(policy):  # type: ignore[misc]
        fires = ("wait", "go")

        def decide(self, cell: TaskCell) -> None:
            if cell.time_s > 0:
                super().decide(cell)
            else:
                self.count += 1

    cell = make(Later)
    with pytest.raises(ValueError):
        cell.step(10)
    (fault,) = [text for _, text in cell.log()]
    assert line_of(line).removesuffix(" ") in fault
    assert what in fault


class FalsyNone(Base):
    transitions = ({"trigger": "go", "source": "a", "dest": "b", "conditions": "held"},)

    def held(self) -> Any:
        return "red_cube" if self.count < 0 else None


def test_none_is_false_for_a_condition():
    assert make(FalsyNone, 2).phase == "a"
