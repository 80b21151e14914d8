"""A robot cell: physics, 1 kHz control and tasks, from one wheel.

``robocell.task`` is for tasks in Python, ``robocell.wire`` for programs that read the
messages of a cell.
"""

from robocell._core import __version__

__all__ = ["__version__"]
