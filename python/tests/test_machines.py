"""Machines of the package transitions: what they may have."""

from __future__ import annotations

from enum import Enum, auto
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("transitions")

from machines import Base, make
from transitions import Machine, State
from transitions.extensions import HierarchicalMachine
from transitions.extensions.states import Tags, Volatile, add_state_features

from robocell import read
from robocell.task import TaskCell

pytestmark = pytest.mark.sample

HERE = Path(__file__)


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
    fires = ("wait", "go", "again")

    def again(self) -> None:
        self.go()  # in b


class BadCallback(Base):
    fires = ("wait", "go")

    def on_enter_b(self) -> None:
        raise_here = {}
        raise_here["nothing"]


@pytest.mark.parametrize(
    ("policy", "line", "what"),
    [
        (BadTrigger, "# in b", "MachineError: \"Can't trigger event go from"),
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


KILLED = """
from enum import Enum
from robocell.task import policy
from robocell.task.machines import MachinePolicy

class Side(Enum):
    LEFT = 1
    RIGHT = 2

class Step(Enum):
    IDLE = 1
    WORK = Side

@policy
class Nested(MachinePolicy):
    states = Step
    initial = Step.IDLE
    transitions = (
        ["go", Step.IDLE, Side.LEFT],
        ["turn", Side.LEFT, Side.RIGHT],
        ["end", Side.RIGHT, Step.IDLE],
    )

    def setup(self, cell):
        self.count = 0

    def on_enter_WORK_RIGHT(self):
        self.count += 100

    def decide(self, cell):
        self.count += 1
        for at, trigger in ((5, self.go), (10, self.turn), (130, self.end)):
            if self.count == at:
                trigger()
        cell.arm.send((0.4, 0.002 * self.count, 0.4))
        cell.report(self.state is Step.IDLE and self.count > 135)
"""


def test_a_nested_machine_of_enums_is_resumed_after_a_kill(run, task, tmp_path):
    file = task(KILLED)
    alone = run("franka-stack", file, "--one-process").summary
    kills = [{"at_s": at, "do": "kill", "process": "task"} for at in (0.06, 0.15)]
    recording = tmp_path / "run.mcap"
    killed = run("franka-stack", file, "--speed", "max", "--record", str(recording), script=kills)
    assert (killed.summary["outcome"], killed.summary["task_restarts"]) == ("done", 2), killed.text
    assert killed.summary["state_hash"] == alone["state_hash"]
    lines = [event.text for event in read(recording).events]
    assert [line for line in lines if " -> " in line] == [
        "IDLE -> WORK_LEFT (go)",
        "WORK_LEFT -> WORK_RIGHT (turn)",
        "WORK_RIGHT -> IDLE (end)",
    ]
