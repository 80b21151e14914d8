"""Stacks the cubes of franka-stack with a py_trees tree: for each cube, in order, "it is
in place, or pick it and place it".

    robocell run franka-stack --task stack_tree.py
    robocell bt show --live
"""

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence

from robocell.task import Arm, TaskCell, policy, skills
from robocell.task.trees import Condition, SkillLeaf, TreePolicy

CLEARANCE_M = 0.15


@policy
class StackTree(TreePolicy):
    """Starts at the first cube again when one that was placed is not in place."""

    def build(self, cell: TaskCell) -> Behaviour:
        order = cell.task["order"]
        x, y = cell.task["stack_position_m"]
        height = cell.task["layer_height_m"]
        cell.add_place("stack", (x, y, 0.0), layers=len(order), layer_height=height)
        cubes = [self.cube(cell, name) for name in order]
        return Sequence("stack", memory=False, children=[*cubes, self.home(cell.arm)])

    def home(self, arm: Arm) -> Behaviour:
        """The arm is at home, or moves there."""
        is_home = Condition("is home", lambda: arm.is_home)
        go_home = SkillLeaf("go home", arm, skills.home())
        return Selector("at home", memory=False, children=[is_home, go_home])

    def cube(self, cell: TaskCell, name: str) -> Behaviour:
        """The branch of one cube."""

        def is_placed() -> bool:
            return cell.arm.held != name and name in cell.placed("stack")

        def is_held() -> bool:
            return cell.arm.held == name

        arm = cell.arm
        pick = SkillLeaf(f"pick {name}", arm, skills.pick(name, clearance_m=CLEARANCE_M))
        place = SkillLeaf(
            f"place {name}", arm, skills.place(name, "stack", clearance_m=CLEARANCE_M)
        )
        take = Selector(
            f"hold {name}", memory=False, children=[Condition(f"has {name}", is_held), pick]
        )
        move = Sequence(f"move {name}", memory=True, children=[take, place])
        return Selector(
            f"{name} in place",
            memory=False,
            children=[Condition(f"{name} is placed", is_placed), move],
        )

    def after(self, cell: TaskCell, status: Status) -> None:
        cell.report(status == Status.SUCCESS, cell.placed("stack"))
