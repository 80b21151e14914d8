"""Machines of the package transitions: what they may have, and what is refused."""

from __future__ import annotations

from enum import Enum, auto
from pathlib import Path
from typing import Any

import pytest

import robocell
from robocell.task import TaskCell

pytest.importorskip("transitions")

from transitions import Machine, State
from transitions.extensions import GraphMachine, HierarchicalMachine, LockedMachine
from transitions.extensions.asyncio import AsyncMachine
from transitions.extensions.states import Retry, Tags, Timeout, Volatile, add_state_features

from robocell.task.machines import MachinePolicy

pytestmark = pytest.mark.sample

HERE = Path(__file__)


class Base(MachinePolicy):
    """Fires the triggers of its list, one in each decision."""

    states: Any = ("a", "b", "c")
    initial: Any = "a"
    transitions: Any = (["go", "a", "b"], ["next", "b", "c"], ["back", "c", "a"])
    fires: Any = ("go",)

    def setup(self, cell: TaskCell) -> None:
        self.count = 0
        self.seen: list[Any] = []

    def wait(self) -> None:
        pass

    def decide(self, cell: TaskCell) -> None:
        if self.count < len(self.fires):
            getattr(self, self.fires[self.count])()
        self.count += 1


def make(policy: Any, decisions: int = 1) -> robocell.Cell:
    cell = robocell.Cell("franka-stack", 1, policy=policy)
    # The first decision belongs to the first state.
    cell.step(10 * (decisions - 1))
    return cell


def log_of(policy: Any, decisions: int = 4) -> list[str]:
    return [line for _, line in make(policy, decisions).log()]


def resumed(kind: Any, before: int, after: int) -> Any:
    """The policy of a process that resumes from the checkpoint of another one."""
    made: list[Any] = []

    class Made(kind):  # type: ignore[misc]
        def setup(self, cell: TaskCell) -> None:
            super().setup(cell)
            made.append(self)

    cell = make(Made)
    cell.log()
    cell.restore(make(kind, before).snapshot())
    cell.step(10 * after)
    return made[-1], [line for _, line in cell.log()]


def refusal(policy: Any) -> str:
    with pytest.raises(ValueError) as raised:
        make(policy)
    return str(raised.value)


def line_of(text: str) -> str:
    """``FILE:LINE`` of the first line of this file that has that text."""
    lines = HERE.read_text().splitlines()
    return f"{HERE}:{1 + next(i for i, line in enumerate(lines) if text in line)}: "


class Chain(Base):
    def on_enter_b(self) -> None:
        self.next()


@pytest.mark.parametrize("queued", [False, True])
def test_the_log_has_the_states_that_callbacks_leave_at_once(queued: bool):
    class Policy(Chain):
        pass

    Policy.queued = queued  # type: ignore[attr-defined]
    assert log_of(Policy) == ["a -> b (go)", "b -> c (next)"]


class FromExit(Base):
    """The trigger of an after callback, which comes when the state is set."""

    transitions = (
        {"trigger": "go", "source": "a", "dest": "b", "after": "next"},
        ["next", "b", "c"],
    )


def test_the_log_has_the_state_before_a_trigger_of_an_after_callback():
    assert log_of(FromExit) == ["a -> b (go)", "b -> c (next)"]


class Step(Enum):
    PICK = auto()
    PLACE = auto()


class ByEnum(Base):
    states = Step
    initial = Step.PICK
    transitions = (["go", Step.PICK, Step.PLACE], ["back", Step.PLACE, Step.PICK])
    fires = ("go", "back", "go")

    def on_enter_PLACE(self) -> None:
        self.seen.append(self.state)


def test_states_of_an_enum_are_logged_drawn_and_resumed():
    cell = make(ByEnum, 4)
    assert [line for _, line in cell.log()] == [
        "PICK -> PLACE (go)",
        "PLACE -> PICK (back)",
        "PICK -> PLACE (go)",
    ]
    assert cell.phase == "PLACE"
    policy, log = resumed(ByEnum, 1, 2)
    assert log == ["PLACE -> PICK (back)", "PICK -> PLACE (go)"]
    assert policy.state is Step.PLACE
    assert policy.seen == [Step.PLACE, Step.PLACE]


class Nested(Base):
    states = (
        "idle",
        {"name": "work", "initial": "near", "children": ["near", "far"]},
        {"name": "two", "parallel": ["left", {"name": "right", "children": ["up", "down"]}]},
    )
    initial = "idle"
    transitions = (
        ["go", "idle", "work"],
        ["next", "work_near", "work_far"],
        ["both", "work", "two"],
        ["down", "two_right", "two_right_down"],
        ["back", "two", "idle"],
    )
    fires = ("go", "next", "both", "down", "back")

    def on_enter_work_far(self) -> None:
        self.seen.append("far")


NESTED_LOG = [
    "idle -> work_near (go)",
    "work_near -> work_far (next)",
    "work_far -> two_left+two_right (both)",
    "two_left+two_right -> two_left+two_right_down (down)",
    "two_left+two_right_down -> idle (back)",
]


def test_nested_and_parallel_states_are_logged_by_their_names():
    assert log_of(Nested, 6) == NESTED_LOG


@pytest.mark.parametrize("before", [1, 2, 3, 4, 5])
def test_nested_and_parallel_states_are_resumed_at_any_decision(before: int):
    policy, log = resumed(Nested, before, 6 - before)
    assert log == NESTED_LOG[before:]
    assert (policy.state, policy.seen) == ("idle", ["far"])


class WithEvents(Base):
    send_event = True
    transitions = ({"trigger": "go", "source": "a", "dest": "b", "conditions": "may"},)

    def may(self, event: Any) -> bool:
        return event.event.name == "go"

    def on_enter_b(self, event: Any) -> None:
        self.seen.append(event.transition.dest)


def test_send_event_gives_callbacks_the_event():
    policy, log = resumed(WithEvents, 1, 1)
    assert (policy.seen, log) == (["b"], [])
    assert log_of(WithEvents) == ["a -> b (go)"]


class Hooks(Base):
    def prepare_event(self) -> None:
        self.seen.append("prepare")

    def before_state_change(self) -> None:
        self.seen.append("before " + self.state)

    def after_state_change(self) -> None:
        self.seen.append("after " + self.state)

    def finalize_event(self) -> None:
        self.seen.append("finalize")


def test_callbacks_of_the_machine_are_called_and_what_they_saw_is_resumed():
    policy, _ = resumed(Hooks, 2, 1)
    assert policy.seen == ["prepare", "before a", "after b", "finalize"]


class Excepts(Base):
    fires = ("go", "go", "next")

    def on_exception(self) -> None:
        self.seen.append("exception in " + self.state)


def test_on_exception_takes_the_exceptions_of_triggers():
    policy, log = resumed(Excepts, 2, 2)
    assert policy.seen == ["exception in b"]
    assert log == ["b -> c (next)"]


class FinalizeRaises(Base):
    def finalize_event(self) -> None:
        raise KeyError("lost")


def test_an_exception_of_finalize_event_is_not_dropped():
    with pytest.raises(KeyError, match="lost"):
        make(FinalizeRaises)


class BadTrigger(Base):
    fires = ("wait", "go", "go")


class BadCallback(Base):
    fires = ("wait", "go")

    def on_enter_b(self) -> None:
        raise_here = {}
        raise_here["nothing"]


@pytest.mark.parametrize(
    ("policy", "line", "what"),
    [
        (BadTrigger, "getattr(self, self.fires", "MachineError: \"Can't trigger event go from"),
        (BadCallback, 'raise_here["nothing"]', "KeyError: 'nothing'"),
    ],
)
def test_an_exception_is_reported_with_the_line_of_the_user(policy: Any, line: str, what: str):
    cell = make(policy)
    with pytest.raises(Exception, match=r".*"):
        cell.step(20)
    fault = [line for _, line in cell.log() if "[fault]" in line]
    assert len(fault) == 1
    assert f"[fault] {line_of(line)}in " in fault[0]
    assert what in fault[0]


@add_state_features(Tags, Volatile)
class Featured(Machine):
    pass


class WithFeatures(Base):
    machine_class = Featured
    states = ("a", {"name": "b", "tags": ["slow"], "volatile": dict, "hook": "scope"}, "c")
    fires = ("go", "note", "next")

    def note(self) -> None:
        self.scope["noted"] = self._machine.get_state("b").is_slow


def test_tags_and_volatile_objects_are_kept():
    policy, log = resumed(WithFeatures, 2, 0)
    assert policy.scope == {"noted": True}
    policy, log = resumed(WithFeatures, 2, 2)
    # That of the next state.
    assert not isinstance(policy.scope, dict)
    assert log == ["b -> c (next)"]


class Counting(State):
    entered = 0

    def __init__(self, *words: Any, **options: Any) -> None:
        super().__init__(*words, **options)
        self.entered = 0

    def enter(self, event_data: Any) -> None:
        self.entered += 1
        super().enter(event_data)


class WithStates(Base):
    states = (Counting("a"), Counting("b"), State("c"))
    initial = states[0]
    transitions = (["go", states[0], states[1]], ["back", "b", "a"])
    fires = ("go", "back", "go", "back")


def test_state_objects_are_of_one_policy_and_their_attributes_are_kept():
    policy, log = resumed(WithStates, 3, 1)
    found = policy._machine.states
    assert (found["a"].entered, found["b"].entered) == (2, 2)
    assert log == ["b -> a (back)"]
    assert [state.entered for state in WithStates.states[:2]] == [0, 0]


class Auto(Base):
    auto_transitions = True
    fires = ("to_c", "to_a")


def test_auto_transitions_may_be_switched_on():
    assert log_of(Auto) == ["a -> c (to_c)", "c -> a (to_a)"]
    with pytest.raises(AttributeError, match="has no attribute 'to_c'"):
        make(type("Off", (Auto,), {"auto_transitions": False}))


class Separated(HierarchicalMachine):
    class state_cls(HierarchicalMachine.state_cls):
        separator = "."


class WithDots(Base):
    machine_class = Separated
    states = ("a", {"name": "b", "initial": "x", "children": ["x", "y"]})
    transitions = (["go", "a", "b"], ["next", "b.x", "b.y"])
    fires = ("go", "next")


def test_a_machine_of_the_user_may_have_another_separator():
    assert log_of(WithDots) == ["a -> b.x (go)", "b.x -> b.y (next)"]


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
        (WithoutEvent, "# without an event", "has other arguments than on_enter_b(self, event)"),
        (WithoutDecide, "class WithoutDecide", "WithoutDecide needs a method decide(self, cell)"),
        (WithoutSuper, "class WithoutSuper", "does not call super().__init__(cell)"),
    ],
)
def test_a_mistake_is_refused_at_the_start_with_its_line(policy: Any, line: str, what: str):
    text = refusal(policy)
    assert line_of(line) in text
    assert what in text
