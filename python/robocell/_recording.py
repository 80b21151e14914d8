"""Recordings of a cell as arrays and tables."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from robocell import _core, wire

if TYPE_CHECKING:
    import pandas as pd

Array = npt.NDArray[np.float64]


class RecordedArm:
    """An arm: a row for each time of :attr:`Recording.time_s`."""

    def __init__(self, about: dict[str, Any], states: Any, statuses: Any) -> None:
        self.name: str = about["name"]
        #: Names of the controlled joints, in the order of the columns.
        self.joint_names: list[str] = about["joint_names"]
        #: All ``ArmState``.
        self.states = states
        #: All ``ArmStatus`` of the controller; their times are in ``header.tick`` (ms).
        self.statuses = statuses
        count = len(self.joint_names)
        #: Measured, rows x joints (rad or m; per second; N m or N).
        self.joint_positions: Array = states["joint_positions"][:, :count]
        self.joint_velocities: Array = states["joint_velocities"][:, :count]
        self.joint_efforts: Array = states["joint_efforts"][:, :count]
        #: Of the TCP, world frame: rows x 3 (m), rows x 4 (w x y z).
        self.tcp_position: Array = states["tcp"]["position"]
        self.tcp_orientation: Array = states["tcp"]["orientation_wxyz"]
        #: ``GripperState``.
        self.gripper = states["gripper"]


class RecordedObject:
    """An object: a row for each time of :attr:`Recording.time_s`."""

    def __init__(self, name: str, states: Any) -> None:
        self.name = name
        #: All ``ObjectState``.
        self.states = states
        #: World frame: rows x 3 (m), rows x 4 (w x y z), rows x 3 (m/s).
        self.position: Array = states["pose"]["position"]
        self.orientation: Array = states["pose"]["orientation_wxyz"]
        self.velocity: Array = states["twist"]["linear"]


@dataclass(frozen=True)
class Event:
    """A line of the log of the task."""

    time_s: float
    #: ``drop``, ``recover``, ... for the counts of programs, too.
    kind: str | None
    text: str


class Recording:
    """The result of :func:`read`."""

    def __init__(self, about: dict[str, Any], arrays: dict[str, Any]) -> None:
        self.demo: str = about["demo"]
        self.policy: str = about["policy"]
        self.seed: int = about["seed"]
        #: Why the recording ends early; ``None`` where its file was closed.
        self.cut: str | None = about["cut"]
        #: Parts that cannot be read.
        self.problems: list[str] = about["problems"]
        #: Times of the rows of arms and objects (s).
        self.time_s: Array = arrays["ticks"] / 1000.0
        #: When the states of these rows were sent: monotonic clock of their machine (ns),
        #: as ``header.publish_ns`` of all messages.
        self.published_ns: npt.NDArray[np.uint64] = arrays["published_ns"]
        rows = len(self.time_s)
        arms = arrays["arms"].view(wire.dtype("ArmState")).reshape(rows, about["arm_count"])
        statuses = [part.view(wire.dtype("ArmStatus")) for part in arrays["statuses"]]
        none = np.empty(0, wire.dtype("ArmStatus"))
        #: By name.
        self.arms: dict[str, RecordedArm] = {
            arm["name"]: RecordedArm(
                arm, arms[:, index], statuses[index] if index < len(statuses) else none
            )
            for index, arm in enumerate(about["arms"][: about["arm_count"]])
        }
        objects = arrays["objects"].view(wire.dtype("ObjectState"))
        objects = objects.reshape(rows, about["object_count"])
        #: By name.
        self.objects: dict[str, RecordedObject] = {
            name: RecordedObject(name, objects[:, index])
            for index, name in enumerate(about["objects"][: about["object_count"]])
        }
        #: All ``Decision``; their times are in ``header.tick`` (ms).
        self.decisions: Any = arrays["decisions"].view(wire.dtype("Decision"))
        #: Lines of the log.
        self.events: list[Event] = [
            Event(tick / 1000.0, kind, text) for tick, kind, text in arrays["log"]
        ]

    def joints_table(self) -> pd.DataFrame:
        """Joint positions (rad or m), columns ``ARM/JOINT``, by time (s)."""
        return self._table(
            {
                f"{arm.name}/{joint}": arm.joint_positions[:, index]
                for arm in self.arms.values()
                for index, joint in enumerate(arm.joint_names)
            }
        )

    def objects_table(self) -> pd.DataFrame:
        """Positions of objects (m), columns ``OBJECT/x``, ``/y``, ``/z``, by time (s)."""
        return self._table(
            {
                f"{one.name}/{axis}": one.position[:, index]
                for one in self.objects.values()
                for index, axis in enumerate("xyz")
            }
        )

    def decisions_table(self) -> pd.DataFrame:
        """Policy, phase and outcome of each decision, by time (s)."""
        outcomes = {code: name for name, code in wire.schema()["codes"]["Outcome"].items()}
        columns = {
            "policy": [_text(value) for value in self.decisions["policy"]],
            "phase": [_text(value) for value in self.decisions["phase"]],
            "outcome": [outcomes[int(code)] for code in self.decisions["outcome"]],
        }
        return _framed(columns, self.decisions["header"]["tick"] / 1000.0)

    def events_table(self) -> pd.DataFrame:
        """Lines of the log, by time (s)."""
        columns = {
            "kind": [event.kind for event in self.events],
            "text": [event.text for event in self.events],
        }
        return _framed(columns, [event.time_s for event in self.events])

    def _table(self, columns: dict[str, Any]) -> pd.DataFrame:
        return _framed(columns, self.time_s)

    def __repr__(self) -> str:
        to = self.time_s[-1] if len(self.time_s) else 0.0
        return f"<recording of '{self.demo}', policy '{self.policy}', to {to:.2f} s>"


def read(path: str | os.PathLike[str], every: int = 10) -> Recording:
    """Reads a recording of ``robocell run --record`` or ``robocell record``, or the
    directory of a flight recorder: the newest history, if physics was restarted.

    Of arms and objects it has the states of each ``every``th tick of 1 ms; each tick takes
    about 4 kB of memory. Tables need pandas.

    Raises:
        ValueError: for a file that is not a recording, or one of another version.
    """
    about, arrays = _core.read_recording(os.fspath(path), every)
    return Recording(json.loads(about), arrays)


def _text(value: Any) -> str:
    return bytes(value).split(b"\0")[0].decode(errors="replace")


def _pandas() -> Any:
    try:
        import pandas
    except ImportError as error:
        raise ImportError("tables need pandas: pip install pandas") from error
    return pandas


def _framed(columns: dict[str, Any], times: Any) -> pd.DataFrame:
    pandas = _pandas()
    table: pd.DataFrame = pandas.DataFrame(columns, index=pandas.Index(times, name="time_s"))
    return table
