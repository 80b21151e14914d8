"""Many cells for stable-baselines3, which refuses vector environments of Gymnasium::

    from robocell.sb3 import CellVecEnv

    PPO("MlpPolicy", CellVecEnv(8, demo="reach")).learn(100_000)

Needs ``pip install stable-baselines3``, which brings torch; the rest of robocell does not
import it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv

from robocell.gym import CellVectorEnv

__all__ = ["CellVecEnv"]


class CellVecEnv(VecEnv):  # type: ignore[misc] # unknown where it is not installed
    """``num_envs`` cells of a demo, stepped on all cores.

    With ``cameras`` an observation is a dictionary with a picture by the name of each camera,
    ``agent_pos`` and ``environment_state`` (``MultiInputPolicy``). The arguments are those of
    :class:`robocell.gym.CellVectorEnv`.
    """

    def __init__(self, num_envs: int = 1, **arguments: Any) -> None:
        self.cells = CellVectorEnv(num_envs, autoreset=False, **arguments)
        self._actions: Any = None
        space = self.cells.single_observation_space
        if isinstance(space, spaces.Dict):
            # Dictionaries inside dictionaries are refused.
            space = spaces.Dict(_flat(space.spaces))
        super().__init__(num_envs, space, self.cells.single_action_space)

    def reset(self) -> Any:
        observations, self.reset_infos = self._reset()
        self._reset_seeds()
        self._reset_options()
        return _flat(observations)

    def _reset(self) -> tuple[Any, list[dict[str, Any]]]:
        observations, infos = self.cells.reset(seed=list(self._seeds))
        return observations, self._by_cell(infos)

    def step_async(self, actions: Any) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        observations, rewards, terminated, truncated, all_infos = self.cells.step(self._actions)
        infos = self._by_cell(all_infos)
        ended = np.flatnonzero(terminated | truncated)
        if len(ended) > 0:
            last = _flat(observations)
            for index in ended.tolist():
                infos[index]["terminal_observation"] = _of(last, index)
                infos[index]["TimeLimit.truncated"] = bool(
                    truncated[index] and not terminated[index]
                )
                self.reset_infos[index] = self.cells.restart(index)
            observations = self.cells.observations()
        return _flat(observations), rewards.astype(np.float32), terminated | truncated, infos

    def _by_cell(self, infos: dict[str, Any]) -> list[dict[str, Any]]:
        names = [name for name in infos if not name.startswith("_")]
        return [{name: infos[name][index] for name in names} for index in range(self.num_envs)]

    def close(self) -> None:
        self.cells.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self._env(index), attr_name) for index in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        for index in self._get_indices(indices):
            setattr(self._env(index), attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        chosen = self._get_indices(indices)
        return [getattr(self._env(index), method_name)(*args, **kwargs) for index in chosen]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]

    def _env(self, index: int) -> Any:
        return self.cells.envs[index]


def _flat(observation: Any) -> Any:
    if not isinstance(observation, dict):
        return observation
    others = {name: part for name, part in observation.items() if name != "pixels"}
    pixels = observation["pixels"]
    return {**(pixels.spaces if isinstance(pixels, spaces.Dict) else pixels), **others}


def _of(observation: Any, index: int) -> Any:
    if not isinstance(observation, dict):
        return observation[index]
    return {name: part[index] for name, part in observation.items()}
