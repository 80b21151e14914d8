"""Puts the cube of the cell `cube` on its mark, in six ways; `--policy NAME` chooses one.

robocell run cube --task cube_six_ways.py --policy ifelse
"""

from collections.abc import Iterator
from types import SimpleNamespace

from cube_tables import Matrix, Rows, is_held, is_placed, skill_of
from py_trees.behaviour import Behaviour
from py_trees.composites import Selector, Sequence

from robocell.task import RUNNING, SUCCESS, TaskCell, policy, skills
from robocell.task.machines import MachinePolicy
from robocell.task.trees import Condition, SkillLeaf, TreePolicy


@policy("ifelse")
def if_else(cell: TaskCell, memory: SimpleNamespace) -> None:
    """The next action follows from the observation."""
    phase = "PLACE" if is_held(cell) else "HOME" if is_placed(cell) else "PICK"
    if phase != getattr(memory, "phase", None):
        memory.phase, memory.skill = phase, skill_of(phase)
    result = cell.arm.do(memory.skill)
    if result not in (RUNNING, SUCCESS):
        memory.skill.reset()
    cell.report(phase == "HOME" and result == SUCCESS)


@policy("script")
class Script:
    """Straight on, as a generator. It cannot be pickled: a task that is started again
    starts the script, which looks at the cell before each step."""

    def __init__(self, cell: TaskCell) -> None:
        self.steps = self.script(cell)

    def script(self, cell: TaskCell) -> Iterator[None]:
        while not is_placed(cell):
            if not is_held(cell):
                yield from self.do(cell, skills.pick("cube"))
            if is_held(cell):
                yield from self.do(cell, skills.place("cube", "mark"))
        yield from self.do(cell, skills.home())

    def do(self, cell: TaskCell, skill: skills.Skill) -> Iterator[None]:
        while cell.arm.do(skill) == RUNNING:
            yield

    def decide(self, cell: TaskCell) -> None:
        cell.report(next(self.steps, "end") == "end")


@policy("fsm")
class Machine(MachinePolicy):
    states = ("PICK", "PLACE", "HOME", "DONE")
    initial = "PICK"
    transitions = (
        {"trigger": "success", "source": "PICK", "dest": "PLACE"},
        {"trigger": "success", "source": "PLACE", "dest": "HOME", "conditions": "placed"},
        {"trigger": "success", "source": "PLACE", "dest": "PICK"},
        {"trigger": "success", "source": "HOME", "dest": "DONE"},
        {"trigger": "failure", "source": ["PICK", "PLACE", "HOME"], "dest": "PICK"},
        {"trigger": "disturbed", "source": ["HOME", "DONE"], "dest": "PICK"},
    )

    def setup(self, cell: TaskCell) -> None:
        self.cell, self.skill = cell, skill_of("PICK")

    def placed(self) -> bool:
        return is_placed(self.cell)

    def decide(self, cell: TaskCell) -> None:
        if self.state in ("HOME", "DONE") and not is_placed(cell):
            self.disturbed()
            self.skill = skill_of(self.state)
        result = cell.arm.do(self.skill) if self.state != "DONE" else RUNNING
        if result != RUNNING:
            (self.success if result == SUCCESS else self.failure)()
            self.skill = skill_of(self.state) if self.state != "DONE" else None
        cell.report(self.state == "DONE")


@policy("tree")
class Tree(TreePolicy):
    def build(self, cell: TaskCell) -> Behaviour:
        arm = cell.arm
        take = Selector("take", memory=False)
        take.add_children([Condition("cube is held", lambda: is_held(cell)), leaf(arm, "PICK")])
        move = Sequence("move", memory=True, children=[take, leaf(arm, "PLACE")])
        put = Selector("put", memory=False)
        put.add_children([Condition("cube is placed", lambda: is_placed(cell)), move])
        home = Selector("at home", memory=False)
        home.add_children([Condition("arm is home", lambda: arm.is_home), leaf(arm, "HOME")])
        return Sequence("cube", memory=False, children=[put, home])


def leaf(arm: object, state: str) -> SkillLeaf:
    return SkillLeaf(state.lower(), arm, skill_of(state))


@policy("table")
class ByTable(Rows):
    """The rows of cube_tables.py."""


@policy("matrix")
class ByMatrix(Matrix):
    """The states and events of cube_tables.py."""
