"""Many cells as one Gymnasium environment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import Space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from robocell._sim import observe_all, step_all
from robocell.gym._env import TICKS, Array, CellEnv, Floats, Observation
from robocell.gym._jobs import JOBS

Flags = npt.NDArray[np.bool_]


class CellVectorEnv(VectorEnv[Observation, Floats, Any]):
    """``num_envs`` cells of a demo, stepped on all cores. Each gives what a
    :class:`CellEnv` of its seed gives, bit for bit.

    The step after the end of an episode ignores the action and resets that cell (autoreset
    mode ``NEXT_STEP``).

    Args:
        num_envs: number of cells.
        demo: its name.
        reward: ``"dense"`` or ``"sparse"``.
        render_mode: ``"rgb_array"`` for pictures of all cells.
        max_episode_steps: an episode is truncated after so many; by default as many as
            the environment of one cell has.
        threads: by default one for each core.
        cameras: as of :class:`CellEnv`.
        autoreset: without it a cell whose episode has ended stays as it is, at no cost, until
            the next ``reset`` (autoreset mode ``DISABLED``).
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as the base class declares it
        **CellEnv.metadata,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        *,
        demo: str,
        reward: str = "dense",
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
        threads: int | None = None,
        cameras: Sequence[str] = (),
        autoreset: bool = True,
    ) -> None:
        if num_envs < 1:
            raise ValueError(f"num_envs is {num_envs}; 1 and more are allowed")
        self.num_envs = num_envs
        self.render_mode = render_mode
        self.envs = [
            CellEnv(demo, reward=reward, render_mode=render_mode, cameras=cameras)
            for _ in range(num_envs)
        ]
        self._autoreset = autoreset
        if not autoreset:
            self.metadata = {**self.metadata, "autoreset_mode": AutoresetMode.DISABLED}
        self._cells = [env.cell for env in self.envs]
        self._threads = threads
        self._limit = JOBS[demo][1] if max_episode_steps is None else max_episode_steps
        for env in self.envs:
            # Where evaluation loops look for it; a wrapper of Gymnasium has the same name.
            env._max_episode_steps = self._limit
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._has_ended: Flags = np.zeros(num_envs, dtype=np.bool_)
        self.single_observation_space: Space[Any] = self.envs[0].observation_space
        self.single_action_space: Space[Floats] = self.envs[0].action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Starts an episode in every cell. One seed gives the cells it and the numbers
        after it."""
        seeds: list[int | None]
        if isinstance(seed, list):
            seeds = seed
        else:
            seeds = [None if seed is None else seed + index for index in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} environments")
        if isinstance(seed, int):
            super().reset(seed=seed)
        self._steps[:] = 0
        self._has_ended[:] = False
        infos: dict[str, Any] = {}
        for index, (env, own) in enumerate(zip(self.envs, seeds, strict=True)):
            infos = self._add_info(infos, env.begin(own), index)
        return self.observations(), infos

    def step(self, actions: Floats) -> tuple[Observation, Any, Flags, Flags, dict[str, Any]]:
        """Advances every cell by 50 ms; those whose episode has ended are reset.

        Raises:
            ValueError: for an action with NaN or infinity, or of another shape, with its
                environment; no cell has advanced then, and the next step continues.
        """
        if len(actions) != self.num_envs:
            raise ValueError(f"{len(actions)} actions for {self.num_envs} environments")
        going = [index for index in range(self.num_envs) if not self._has_ended[index]]
        checked = [self._checked(index, actions[index]) for index in going]
        for index, action in zip(going, checked, strict=True):
            self.envs[index].act(action)
        step_all([self._cells[index] for index in going], TICKS, self._threads)
        self._steps[going] += 1
        rewards = np.zeros(self.num_envs, dtype=np.float64)
        terminated: Flags = np.zeros(self.num_envs, dtype=np.bool_)
        infos: dict[str, Any] = {}
        for index, env in enumerate(self.envs):
            if self._has_ended[index] and self._autoreset:
                info = env.begin(None)
                self._steps[index] = 0
            else:
                rewards[index], terminated[index], info = env.outcome()
            infos = self._add_info(infos, info, index)
        truncated: Flags = self._steps >= self._limit
        self._has_ended = terminated | truncated
        return self.observations(), rewards, terminated, truncated, infos

    def restart(self, index: int) -> dict[str, Any]:
        """Starts another episode in one cell; its info."""
        self._steps[index] = 0
        self._has_ended[index] = False
        return self.envs[index].begin(None)

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """An attribute of each copy, or the result of calling it."""
        found = [getattr(env, name) for env in self.envs]
        return tuple(one(*args, **kwargs) if callable(one) else one for one in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each copy."""
        return tuple(getattr(env, name) for env in self.envs)

    def observations(self) -> Observation:
        """The newest observations of all cells."""
        # Every step has its own array: a caller may keep the one before.
        rows: Floats = np.empty((self.num_envs, self.envs[0].observed), np.float32)
        for env, row in zip(self.envs, rows, strict=True):
            env.observe(row)
        first = self.envs[0]
        if not first.cameras:
            return rows
        return first.split(rows, observe_all(self._cells, first.cameras, self._threads))

    def _checked(self, index: int, action: Floats) -> Array:
        try:
            return self.envs[index].checked(action)
        except ValueError as error:
            raise ValueError(f"environment {index}: {error}") from None

    def render(self) -> tuple[Any, ...] | None:
        """A picture of each cell."""
        if self.render_mode != "rgb_array":
            return None
        return tuple(env.render() for env in self.envs)
