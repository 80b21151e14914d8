"""Environments for tools of robot learning: pictures, LeRobot, stable-baselines3."""

from __future__ import annotations

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import robocell  # noqa: E402
import robocell.gym  # noqa: E402
from robocell.lerobot import make_env, maker  # noqa: E402

CAMERAS = ("front", "wrist")


def vector(num_envs: int, **options):
    return robocell.gym.CellVectorEnv(num_envs, demo="cube", cameras=CAMERAS, **options)


@pytest.mark.sample
def test_an_environment_with_cameras_passes_the_checks_of_gymnasium():
    env = robocell.gym.CellEnv("cube", cameras=CAMERAS)
    check_env(env, skip_render_check=True)
    observation, _ = env.reset(seed=3)
    numbers = robocell.gym.CellEnv("cube").reset(seed=3)[0]
    parts = [observation["agent_pos"], observation["environment_state"]]
    assert (np.concatenate(parts) == numbers).all()
    seen = env.cell.observe(CAMERAS)
    for name in CAMERAS:
        assert (observation["pixels"][name] == seen[name].rgb).all()


@pytest.mark.sample
def test_a_vector_environment_has_the_pictures_of_single_ones():
    actions = np.random.default_rng(0).uniform(-1, 1, (5, 2, 7)).astype(np.float32)
    many = vector(2)
    many.reset(seed=5)
    singles = [robocell.gym.CellEnv("cube", cameras=CAMERAS) for _ in range(2)]
    for index, env in enumerate(singles):
        env.reset(seed=5 + index)
    for step in actions:
        observations = many.step(step)[0]
        for index, env in enumerate(singles):
            observation = env.step(step[index])[0]
            for name in CAMERAS:
                assert (observation["pixels"][name] == observations["pixels"][name][index]).all()
            assert (observation["agent_pos"] == observations["agent_pos"][index]).all()
    assert observations in many.observation_space


@pytest.mark.sample
def test_a_seed_is_the_scene_of_that_seed():
    env = robocell.gym.CellEnv("franka-stack")
    _, info = env.reset(seed=7)
    assert info["seed"] == 7
    cell = robocell.Cell("franka-stack", 7)
    for name, one in cell.objects.items():
        assert (one.position == env.cell.objects[name].position).all()


@pytest.mark.sample
def test_lerobot_gets_what_it_asks_for():
    env = make_env(2, True)
    observation, infos = env.reset(seed=[7, 8])
    assert observation["pixels"]["wrist"].shape == (2, 224, 224, 3)
    assert observation["pixels"]["wrist"].dtype == np.uint8
    assert observation["agent_pos"].dtype == np.float32
    assert list(infos["is_success"]) == [False, False]
    assert env.call("_max_episode_steps") == (2000, 2000)
    assert all("cube" in sentence for sentence in env.call("task_description"))
    assert env.call("task") == ("franka-stack", "franka-stack")


@pytest.mark.sample
def test_a_copy_that_has_ended_stays_as_it_is():
    env = maker("cube", max_episode_steps=3)(2)
    env.reset(seed=[1, 2])
    still = np.zeros((2, 7), np.float32)
    for _ in range(3):
        observation, _, _, truncated, _ = env.step(still)
    assert truncated.all()
    later, rewards, _, truncated, infos = env.step(still + 1)
    assert truncated.all() and (rewards == 0).all()
    assert (later["agent_pos"] == observation["agent_pos"]).all()
    assert list(infos["time_s"]) == [0.15, 0.15]


def test_stable_baselines_learns_in_many_cells():
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    from robocell.sb3 import CellVecEnv

    env = CellVecEnv(2, demo="reach", max_episode_steps=5)
    env.seed(3)
    first = env.reset()
    assert first.shape[0] == 2
    for step in range(5):
        observations, _, dones, infos = env.step(np.zeros((2, 7), np.float32))
        assert dones.all() == (step == 4)
    for index in range(2):
        assert infos[index]["TimeLimit.truncated"]
        # The observation is that of the new episode.
        assert (infos[index]["terminal_observation"] != observations[index]).any()
    model = stable_baselines3.PPO("MlpPolicy", env, n_steps=16, batch_size=16, device="cpu")
    model.learn(64)
