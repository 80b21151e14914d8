"""Gymnasium environments, one for each demo. Needs ``pip install robocell[gym]``.

Importing this module registers them::

    import gymnasium
    import robocell.gym

    env = gymnasium.make("robocell/FrankaStack-v0")
    envs = gymnasium.make_vec(
        "robocell/FrankaStack-v0", num_envs=8, vectorization_mode="vector_entry_point"
    )

The vector environment steps its cells on all cores.
"""

from gymnasium.envs.registration import register, registry

from robocell.gym._env import CellEnv
from robocell.gym._jobs import JOBS
from robocell.gym._vector import CellVectorEnv

__all__ = ["IDS", "CellEnv", "CellVectorEnv"]

#: Names of the environments, by demo.
IDS = {demo: f"robocell/{demo.title().replace('-', '')}-v0" for demo in JOBS}

for _demo, _id in IDS.items():
    if _id not in registry:
        register(
            id=_id,
            entry_point="robocell.gym:CellEnv",
            vector_entry_point="robocell.gym:CellVectorEnv",
            max_episode_steps=JOBS[_demo][1],
            kwargs={"demo": _demo},
        )
