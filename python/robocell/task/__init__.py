"""Tasks in Python.

A task is a class with ``decide(self, cell)``, or a function, marked with
:func:`policy`. It is called every 10 ms and decides the motion of the arms until the next
call; an arm without a command stays where it was sent. ``robocell run CELL --task
FILE.py`` runs it.
"""

from robocell._core import Status
from robocell.task import skills
from robocell.task._cell import Arm, Object, TaskCell
from robocell.task._registry import policy

RUNNING = Status.RUNNING
SUCCESS = Status.SUCCESS
FAILURE = Status.FAILURE

__all__ = [
    "FAILURE",
    "RUNNING",
    "SUCCESS",
    "Arm",
    "Object",
    "Status",
    "TaskCell",
    "policy",
    "skills",
]
