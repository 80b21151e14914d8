"""One cell as a Gymnasium environment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from robocell import rotation
from robocell._sim import Cell
from robocell._view import Arm, Object
from robocell.gym._jobs import JOBS

#: Ticks of 1 ms in a step: 20 actions in a second.
TICKS = 50
#: Names of the actions of one arm.
_NAMES = (
    "translation x",
    "translation y",
    "translation z",
    "rotation x",
    "rotation y",
    "rotation z",
    "gripper",
)
#: Actions of one arm.
ACTIONS = len(_NAMES)
#: Translation (m) and rotation (rad) of the goal by an action of 1.
_STEP_M = 0.03
_STEP_RAD = 0.15
#: The goal stays this near to the measured TCP, so that it can be turned back (m).
_LEASH_M = 0.08
#: Observations are clipped to this.
_LIMIT = 10.0
#: Observation of an object that is not in the cell.
_ABSENT = (0.0,) * 7

Floats = npt.NDArray[np.float32]
Array = npt.NDArray[np.float64]
#: An array of numbers; with cameras a dictionary.
Observation = Any


class CellEnv(gymnasium.Env[Observation, Floats]):
    """A demo whose arms are moved by the actions.

    An action has seven numbers of -1 to 1 for each arm: translation (x y z, up to 3 cm)
    and rotation (a rotation vector, up to 0.15 rad) of the goal of its TCP in the world
    frame, and the gripper, which closes above 0. Numbers beyond -1 and 1 are clipped; NaN and
    infinity are refused, and the cell is as before. A step is 50 ms of the cell; RMPflow
    moves the arm to the goal, past obstacles and within the limits of its joints.

    An observation has, for each arm: joint positions and velocities, TCP position and
    orientation (w x y z), the goal's position, whether something is held, and the width of
    the gripper; for each object: position and orientation, all zero while it is not in the
    cell; then numbers of the demo (the goal of ``reach``, the share of parts in the bin
    and a hundredth of the suction force of ``ur10-fill-bin``).

    With ``cameras``, names of cameras of the cell file, an observation is a dictionary:
    ``pixels`` has a picture for each camera (height x width x 3, uint8), ``agent_pos`` the
    numbers of the arms, and ``environment_state`` those of the objects and of the demo.

    ``reset(seed=7)`` starts the scene of ``robocell run --seed 7``; without a seed the scene
    follows from the seed before. ``info`` has ``is_success``, ``placed``, ``seed`` and
    ``time_s``.

    The reward of ``"sparse"`` is 1 for each object that is put into its place and -1 for
    one that is taken out; that of ``"dense"`` also has what the transfer under way got
    further, up to 1 for a whole transfer. An episode terminates when all is in place.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as the base class declares it
        "render_modes": ["rgb_array"],
        "render_fps": 1000 // TICKS,
    }

    def __init__(
        self,
        demo: str,
        *,
        reward: str = "dense",
        render_mode: str | None = None,
        cameras: Sequence[str] = (),
    ) -> None:
        if reward not in ("dense", "sparse"):
            raise ValueError(f"reward is '{reward}'; 'dense' and 'sparse' are allowed")
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode is '{render_mode}'; 'rgb_array' and None are allowed")
        self.demo = self.task = demo
        self._max_episode_steps = JOBS[demo][1]
        self.reward = reward
        self.render_mode = render_mode
        self.cameras = tuple(cameras)
        self.cell = Cell(demo)
        self._new_episode(np.random.default_rng(0))
        #: The job, in a sentence.
        self.task_description = self.job.sentence
        #: Numbers of an observation, and how many of them, the first ones, are of the arms.
        self.observed = sum(np.size(part) for part in self._parts())
        self.of_arms = sum(np.size(part) for part in self._of_arms())
        self.observation_space = self._space()
        self.action_space = spaces.Box(-1.0, 1.0, (ACTIONS * len(self.cell.arms),), np.float32)

    def _space(self) -> spaces.Space[Any]:
        if not self.cameras:
            return spaces.Box(-_LIMIT, _LIMIT, (self.observed,), np.float32)
        pictures = self.cell.observe(self.cameras)
        pixels: dict[str, spaces.Space[Any]] = {
            name: spaces.Box(0, 255, picture.rgb.shape, np.uint8)
            for name, picture in pictures.items()
        }
        others = self.observed - self.of_arms
        return spaces.Dict(
            {
                "pixels": spaces.Dict(pixels),
                "agent_pos": spaces.Box(-_LIMIT, _LIMIT, (self.of_arms,), np.float32),
                "environment_state": spaces.Box(-_LIMIT, _LIMIT, (others,), np.float32),
            }
        )

    def _new_episode(self, rng: np.random.Generator) -> None:
        job, _ = JOBS[self.demo]
        self.job = job(self.cell, rng)
        self._goals = [
            (arm.tcp_position.copy(), arm.tcp_orientation.copy()) for arm in self.cell.arms
        ]
        self._before = self.job.progress()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts an episode of the scene ``seed``, or of one that follows from the seed before."""
        info = self.begin(seed)
        return self._observation(), info

    def begin(self, seed: int | None) -> dict[str, Any]:
        """As :meth:`reset`, without the observation."""
        super().reset(seed=seed)
        self.cell.reset(int(self.np_random.integers(1 << 31)) if seed is None else seed)
        self._new_episode(self.np_random)
        return self._info()

    def step(self, action: Floats) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Advances the cell by 50 ms.

        Raises:
            ValueError: for an action with NaN or infinity, or of another shape.
        """
        self.act(self.checked(action))
        self.cell.step(TICKS)
        return self.judge()

    def checked(self, action: Floats) -> Array:
        """An action, clipped: a row for each arm. A goal that was moved by NaN would stay
        NaN, so it is refused before anything changes."""
        arms = self.cell.arms
        numbers: Array = np.asarray(action, dtype=np.float64)
        if numbers.size != ACTIONS * len(arms):
            allowed = f"{ACTIONS} for each arm, {ACTIONS * len(arms)} in all, are needed"
            raise ValueError(f"the action has {numbers.size} numbers; {allowed}")
        parts = numbers.reshape(len(arms), ACTIONS)
        for index, number in np.argwhere(~np.isfinite(parts)):
            what = f"{_NAMES[number]} of arm '{arms[index].name}'"
            at = index * ACTIONS + number
            raise ValueError(
                f"action[{at}], {what}, is {parts[index, number]}; a finite number is needed, "
                "which is clipped to -1..1"
            )
        clipped: Array = np.clip(parts, -1.0, 1.0)
        return clipped

    def act(self, parts: Array) -> None:
        """The first half of a step: passes the result of :meth:`checked` to the arms."""
        for index, (arm, part) in enumerate(zip(self.cell.arms, parts, strict=True)):
            position, orientation = self._goals[index]
            position = position + _STEP_M * part[:3]
            off = position - arm.tcp_position
            position = arm.tcp_position + off * min(
                1.0, _LEASH_M / max(float(np.linalg.norm(off)), 1e-9)
            )
            turn = rotation.by_vector(_STEP_RAD * part[3:6])
            orientation = rotation.product(turn, orientation)
            self._goals[index] = (position, orientation)
            gripper = "close" if part[6] > 0.0 else "open"
            arm.send(list(position), list(orientation), gripper=gripper, ignore=_graspable(arm))
        self.job.tend()

    def judge(self) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """The second half: the result."""
        reward, terminated, info = self.outcome()
        return self._observation(), reward, terminated, False, info

    def outcome(self) -> tuple[float, bool, dict[str, Any]]:
        """As :meth:`judge`, without the observation: reward, terminated, and info."""
        filled, share = self.job.progress()
        reward = float(filled - self._before[0])
        if self.reward == "dense":
            reward += share - self._before[1]
        self._before = (filled, share)
        terminated = filled >= self.job.total or self.job.is_over()
        return reward, terminated, self._info()

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The cell as seen by its camera: height x width x RGB."""
        return self.cell.render() if self.render_mode == "rgb_array" else None

    def _info(self) -> dict[str, Any]:
        return {
            "placed": self._before[0],
            "is_success": self._before[0] >= self.job.total,
            "seed": self.cell.seed,
            "time_s": self.cell.time_s,
        }

    def _observation(self) -> Observation:
        row: Floats = np.empty(self.observed, np.float32)
        self.observe(row)
        if not self.cameras:
            return row
        seen = self.cell.observe(self.cameras)
        return self.split(row, {name: picture.rgb for name, picture in seen.items()})

    def split(self, rows: Floats, pixels: dict[str, npt.NDArray[np.uint8]]) -> Observation:
        """The observation of numbers, one row or one for each cell, and pictures."""
        arms, others = np.split(rows, [self.of_arms], axis=-1)
        return {"pixels": pixels, "agent_pos": arms, "environment_state": others}

    def observe(self, row: Floats) -> None:
        """Writes the observation into ``row``."""
        np.concatenate(self._parts(), out=row)
        np.clip(row, -_LIMIT, _LIMIT, out=row)

    def _parts(self) -> list[npt.ArrayLike]:
        parts = self._of_arms()
        for one in self.job.seen:
            parts += _of_object(one)
        parts.append(self.job.extra())
        return parts

    def _of_arms(self) -> list[npt.ArrayLike]:
        parts: list[npt.ArrayLike] = []
        for arm, (goal, _) in zip(self.cell.arms, self._goals, strict=True):
            parts += _of_arm(arm, goal)
        return parts


def _of_arm(arm: Arm, goal: Array) -> list[npt.ArrayLike]:
    width = float(arm.gripper["width"]) if "width" in arm.gripper.dtype.names else 0.0
    return [
        arm.joint_positions,
        arm.joint_velocities,
        arm.tcp_position,
        arm.tcp_orientation,
        goal,
        [float(arm.held is not None), width],
    ]


def _of_object(one: Object) -> list[npt.ArrayLike]:
    if not one.is_present:
        return [_ABSENT]
    return [one.position, one.orientation]


def _graspable(arm: Arm) -> list[str]:
    # The objects that the tool works with are not obstacles for it.
    return [] if arm.held is None else [arm.held]
