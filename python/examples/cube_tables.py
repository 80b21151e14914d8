"""The common parts of the six ways of cube_six_ways.py, and the two that are tables."""

from robocell.task import RUNNING, SUCCESS, Status, TaskCell, skills


def is_placed(cell: TaskCell) -> bool:
    return cell.arm.held is None and "cube" in cell.placed("mark")


def is_held(cell: TaskCell) -> bool:
    return cell.arm.held == "cube"


def skill_of(state: str) -> skills.Skill:
    return {
        "PICK": skills.pick("cube"),
        "PLACE": skills.place("cube", "mark"),
        "HOME": skills.home(),
    }[state]


class Table:
    """A state machine of rows: in a state, after an event, to another one."""

    phase = "PICK"

    def __init__(self) -> None:
        self.skill = skill_of(self.phase)

    def following(self, state: str, event: str) -> str:
        raise NotImplementedError

    def decide(self, cell: TaskCell) -> None:
        result = cell.arm.do(self.skill) if self.phase != "DONE" else RUNNING
        after = self.following(self.phase, event_of(cell, result))
        if after != self.phase or result != RUNNING:
            self.phase, self.skill = after, skill_of(after if after != "DONE" else "HOME")
        cell.report(self.phase == "DONE")


def event_of(cell: TaskCell, result: Status) -> str:
    if result == RUNNING:
        return "placed" if is_placed(cell) else "held" if is_held(cell) else "missing"
    return "success" if result == SUCCESS else "failure"


class Rows(Table):
    ROWS = (
        ("PICK", "success", "PLACE"),
        ("PICK", "held", "PLACE"),
        ("PLACE", "success", "HOME"),
        ("PLACE", "missing", "PICK"),
        ("PLACE", "failure", "PICK"),
        ("HOME", "success", "DONE"),
        ("HOME", "missing", "PICK"),
        ("DONE", "missing", "PICK"),
    )

    def following(self, state: str, event: str) -> str:
        rows = (to for at, on, to in self.ROWS if (at, on) == (state, event))
        return next(rows, state)


class Matrix(Table):
    EVENTS = ("success", "failure", "held", "placed", "missing")
    STATES = {  # noqa: RUF012 - a constant
        "PICK": ("PLACE", "PICK", "PLACE", "HOME", "PICK"),
        "PLACE": ("HOME", "PICK", "PLACE", "PLACE", "PICK"),
        "HOME": ("DONE", "HOME", "PLACE", "HOME", "PICK"),
        "DONE": ("DONE", "DONE", "PLACE", "DONE", "PICK"),
    }

    def following(self, state: str, event: str) -> str:
        return self.STATES[state][self.EVENTS.index(event)]
