"""Environments for the evaluation of LeRobot, as its hub loads them. Needs ``robocell[learn]``.

A file ``env.py`` in a repository of the hub::

    from robocell.lerobot import maker

    make_env = maker("franka-stack", cameras=("front", "wrist"))

Nothing here imports lerobot or torch.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from robocell.gym import CellVectorEnv

__all__ = ["make_env", "maker"]


def maker(
    demo: str, *, cameras: Sequence[str] = ("front", "wrist"), max_episode_steps: int | None = None
) -> Callable[..., CellVectorEnv]:
    """A function ``make_env`` for a demo.

    The environments have the observations ``pixels``, ``agent_pos`` and
    ``environment_state`` of :class:`robocell.gym.CellEnv`, the reward 1 for each object in its
    place, ``info["is_success"]`` in every step, and the attributes ``task_description``,
    ``task`` and ``_max_episode_steps``. A copy whose episode has ended costs nothing until the
    next reset.
    ``reset(seed=[7, 8])`` starts the scenes of ``robocell run --seed 7`` and ``--seed 8``.
    """

    def make_env(n_envs: int = 1, use_async_envs: bool = False, cfg: Any = None) -> CellVectorEnv:
        # The cells of one environment are stepped and drawn on all cores: processes of their
        # own, which `use_async_envs` asks for, would only cost memory.
        return CellVectorEnv(
            n_envs,
            demo=demo,
            reward="sparse",
            cameras=cameras,
            max_episode_steps=max_episode_steps,
            autoreset=False,
        )

    return make_env


#: ``make_env`` of ``franka-stack``.
make_env = maker("franka-stack")
