"""A cell in this process."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from robocell import _core, wire
from robocell._view import Numbers, View, floats


class CameraImage(NamedTuple):
    """What a camera sees; rows from the top."""

    rgb: npt.NDArray[np.uint8]
    """Height x width x 3, 0 to 255."""
    depth: npt.NDArray[np.float32]
    """Height x width: distance along the axis of view (m); 0 where nothing is seen."""
    mask: npt.NDArray[np.uint16]
    """Height x width: number in :attr:`Cell.instances`, from 1 on; 0 where nothing is seen."""


class Cell(View):
    """A cell in this process, stepped by the caller: physics, the 1 kHz controllers and
    the task, with the result of ``robocell run --one-process``.

    Without a policy the caller commands the arms: ``cell.arm.send(...)``,
    ``send_joints``, ``grip``, ``hold``, ``cell.arm.begin(skill)``. A command is passed on
    with the next decision, one in 10 ticks, and holds until the next command.

    Args:
        name: a demo (``robocell list``), or a cell of the folder ``data``.
        seed: of the scene.
        policy: the name of a built-in policy, ``"default"``, or a policy in Python: the
            argument of :func:`robocell.task.policy`.
        data: folder with ``cells/NAME.toml``.
        bins: how many of the bins of the cell are used.
        script: disturbances, in the form of ``robocell run --script``: JSON, a line each.
        time_limit_s: end of a run; that of the cell file with a policy, else none.
        set: numbers in place of those of the cell file, by keys as of ``robocell run --set``:
            ``{"object.*.mass_kg": 0.2, "disturbance.position_noise_m": 0.002}``.
        replace: leaves of the tree that answer without being run, as of ``robocell run
            --replace``: ``["grasp=failure:2"]``, or names of files with a rule a line.

    Raises:
        ValueError: for a cell, a policy or a script that does not exist or has mistakes.

    Warnings of ``robocell run``, as a corrected fault of a URDF, are a ``UserWarning``.
    """

    def __init__(
        self,
        name: str,
        seed: int = 0,
        *,
        policy: str | Callable[..., Any] | None = None,
        data: str | os.PathLike[str] | None = None,
        bins: int | None = None,
        script: str | None = None,
        time_limit_s: float | None = None,
        set: Mapping[str, float] | None = None,
        replace: Sequence[str] = (),
    ) -> None:
        named, maker = None, None
        if isinstance(policy, str):
            named = "" if policy == "default" else policy
        elif policy is not None:
            from robocell.task._runner import maker as maker_of

            maker = maker_of(policy)
        self._sim = _core.Sim(
            name,
            seed,
            named,
            maker,
            None if data is None else os.fspath(data),
            bins,
            script,
            time_limit_s,
            [f"{key}={value!r}" for key, value in (set or {}).items()],
            list(replace),
        )
        for warning in self._sim.warnings:
            warnings.warn(warning, stacklevel=2)
        super().__init__(self._sim.moment)
        #: Seed of the scene.
        self.seed = seed
        #: The newest ``Decision`` of the task.
        self.decision: Any = self._sim.decision.view(wire.dtype("Decision"))[0]

    def reset(self, seed: int | None = None) -> None:
        """Back to the start of the run, of another seed if one is given. Arrays and arms
        that were taken from the cell show the new run."""
        self._sim.reset(seed)
        if seed is not None:
            self.seed = seed

    def step(self, n: int = 1) -> int:
        """Advances ``n`` ticks of 1 ms; how many it were. A cell whose job has ended does
        not advance. Other threads run meanwhile.

        Raises:
            Exception: that of a policy in Python.
        """
        return self._sim.step(n)

    def run(self) -> dict[str, Any]:
        """Advances to the end of the job, or the time limit; its :meth:`summary`."""
        if bytes(self.decision["policy"]) == b"outside":
            raise ValueError("a cell without a policy has no end; use step()")
        while self.step(10_000):
            pass
        return self.summary()

    def do(self, skill: _core.Skill, arm: int = 0, timeout_s: float = 60.0) -> _core.Status:
        """Moves an arm by a skill and advances until the skill has ended; its result.

        Raises:
            TimeoutError: when it has not ended after ``timeout_s`` of simulated time.
            ValueError: for an object or a place that the cell does not have.
        """
        lead = self.arms[arm]
        if not isinstance(skill, _core.Skill):
            raise TypeError(f"do() needs a skill, as skills.home(), not {skill!r}")
        lead.begin(skill)
        for _ in range(round(timeout_s * 100)):
            self.step(10)
            if lead.skill_status not in (None, _core.Status.RUNNING):
                assert lead.skill_status is not None
                return lead.skill_status
        raise TimeoutError(f"{skill} has not ended after {timeout_s} s")

    @property
    def time_s(self) -> float:
        """Simulated time (s)."""
        return self.tick / 1000.0

    @property
    def state_hash(self) -> str:
        """Hash of the states of the whole run: equal for equal runs."""
        return f"{int(self.state['state_hash']):016x}"

    @property
    def is_done(self) -> bool:
        """Whether the task has reported its job done."""
        return int(self.decision["outcome"]) == wire.code("Outcome", "Done")

    @property
    def phase(self) -> str:
        """Phase of the task."""
        return bytes(self.decision["phase"]).split(b"\0")[0].decode()

    def summary(self) -> dict[str, Any]:
        """The summary of ``robocell run --json``, for the run so far: outcome,
        placed objects, drops, state hash."""
        summary: dict[str, Any] = json.loads(self._sim.summary())
        return summary

    def log(self) -> list[tuple[float, str]]:
        """Lines of the task since the last call, with their times (s)."""
        return [(tick / 1000.0, line) for tick, line in self._sim.take_log()]

    def snapshot(self) -> bytes:
        """All of the cell: world, controllers and task. See :meth:`restore`."""
        return self._sim.snapshot()

    def restore(self, snapshot: bytes) -> None:
        """Returns to a snapshot of the same cell, seed and policy. The same commands then
        give the same states, bit for bit.

        Raises:
            ValueError: for damaged bytes, and those of another cell or version.
        """
        self._sim.restore(snapshot)

    def render(
        self,
        width: int = 640,
        height: int = 480,
        *,
        eye: Numbers | None = None,
        target: Numbers | None = None,
    ) -> npt.NDArray[np.uint8]:
        """A picture of the shapes physics computes with: height x width x RGB, drawn by
        the CPU. ``eye`` and ``target`` are points in the world frame (m), by default
        those of the cell file."""
        return self._sim.render(
            width,
            height,
            None if eye is None else floats(eye),
            None if target is None else floats(target),
        )

    @property
    def cameras(self) -> list[str]:
        """Names of the cameras of the cell file; ``front`` is the view of the page."""
        return self._sim.cameras

    @property
    def instances(self) -> list[str]:
        """What the numbers of :attr:`CameraImage.mask` are: number ``i`` is
        ``instances[i - 1]``."""
        return self._sim.instances

    def observe(self, cameras: Sequence[str] = ("front",)) -> dict[str, CameraImage]:
        """What cameras of the cell file see now, drawn by the CPU: the same bits on every
        machine.

        Raises:
            ValueError: for a camera that the cell has not.
        """
        seen = self._sim.observe(list(cameras))
        return {name: CameraImage(*image) for name, image in zip(cameras, seen, strict=True)}

    def __repr__(self) -> str:
        return f"<cell '{self.name}', seed {self.seed}, at {self.time_s:.2f} s>"


def observe_all(
    cells: Sequence[Cell], cameras: Sequence[str], threads: int | None = None
) -> dict[str, npt.NDArray[np.uint8]]:
    """Colour of cameras of all cells, drawn on all cores: cells x height x width x 3."""
    seen = _core.observe_all([cell._sim for cell in cells], list(cameras), threads)
    return dict(zip(cameras, seen, strict=True))


def step_all(cells: Sequence[Cell], n: int = 1, threads: int | None = None) -> list[int]:
    """Advances cells on all cores, each as by :meth:`Cell.step`."""
    return _core.step_all([cell._sim for cell in cells], n, threads)
