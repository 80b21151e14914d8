"""A robot cell: physics, 1 kHz control and tasks, from one wheel.

:class:`Cell` is a cell in this process, :func:`read` reads a recording. ``robocell.task``
is for tasks in Python, ``robocell.gym`` for reinforcement learning, ``robocell.wire`` for
programs that read the messages of a cell.
"""

from robocell._core import Status, __version__
from robocell._recording import Recording, read
from robocell._sim import CameraImage, Cell, step_all

__all__ = ["CameraImage", "Cell", "Recording", "Status", "__version__", "read", "step_all"]
