"""The cell as a task sees it."""

from __future__ import annotations

from collections.abc import Sequence

from robocell._view import Arm, Object, View

__all__ = ["Arm", "Object", "TaskCell"]


class TaskCell(View):
    """The cell: the observations of a task, and its reports.

    Arrays are views that show the newest decision; ``.copy()`` keeps a value.
    """

    @property
    def time_s(self) -> float:
        """Simulated time without the time the task was paused (s)."""
        return self._core.time_s

    @property
    def resumed(self) -> bool:
        """Whether decisions were missed before this one."""
        return self._core.resumed

    @property
    def started(self) -> bool:
        """Whether the start event was given, for jobs that wait for one."""
        return self._core.started

    def report(self, done: bool, placed: Sequence[str] | None = None) -> None:
        """Says whether the job is done, and which objects are in place; without
        ``placed`` all that are in slots of places. To be repeated in each decision."""
        self._core.report(done, None if placed is None else list(placed))

    def fail(self, reason: str, why: str) -> None:
        """Gives the job up. ``reason`` is a stable name, ``why`` a line for the log."""
        self._core.fail(reason, why)

    def log(self, line: str) -> None:
        """Adds a line to the log of the task."""
        self._core.log(line)

    def count(self, what: str, line: str) -> None:
        """Counts a ``"drop"``, ``"resync"``, ``"abort"`` or ``"recovery"``; ``line`` is
        for the log."""
        self._core.count(what, line)

    def __repr__(self) -> str:
        return f"<cell '{self.name}' at {self.time_s:.2f} s>"
