"""Environments of Gymnasium."""

from __future__ import annotations

import gc
import os
import warnings
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import robocell.gym  # noqa: E402
from robocell.task import skills  # noqa: E402

STACK = robocell.gym.IDS["franka-stack"]


def vector(num_envs: int, **options):
    return gymnasium.make_vec(
        STACK, num_envs=num_envs, vectorization_mode="vector_entry_point", **options
    )


@pytest.mark.sample
@pytest.mark.parametrize("name", robocell.gym.IDS.values())
def test_every_environment_passes_the_checks_of_gymnasium(name: str):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(name).unwrapped)
        env = gymnasium.make(name, render_mode="rgb_array")
        env.reset(seed=1)
        for _ in range(5):
            env.step(env.action_space.sample())
        assert env.render().shape == (480, 640, 3)


@pytest.mark.sample
def test_seeds_give_the_same_episode_bit_for_bit():
    def episode(seed: int) -> list[bytes]:
        env = gymnasium.make(STACK)
        observation, _ = env.reset(seed=seed)
        env.action_space.seed(1)
        seen = [observation.tobytes()]
        for _ in range(30):
            observation, reward, *_ = env.step(env.action_space.sample())
            seen += [observation.tobytes(), float(reward).hex()]
        return seen

    assert episode(7) == episode(7)
    assert episode(7)[0] != episode(8)[0]


@pytest.mark.sample
def test_the_vector_environment_gives_what_single_ones_give():
    actions = np.random.default_rng(0).uniform(-1, 1, (40, 3, 7)).astype(np.float32)
    many = vector(3)
    observations, _ = many.reset(seed=5)
    singles = [gymnasium.make(STACK) for _ in range(3)]
    for index, env in enumerate(singles):
        assert (env.reset(seed=5 + index)[0] == observations[index]).all()
    for step in actions:
        observations, rewards, *_ = many.step(step)
        for index, env in enumerate(singles):
            observation, reward, *_ = env.step(step[index])
            assert (observation == observations[index]).all()
            assert reward == rewards[index]


@pytest.mark.sample
@pytest.mark.parametrize("demo", robocell.gym.IDS)
def test_an_observation_is_one_array_of_its_own(demo: str):
    many = gymnasium.make_vec(
        robocell.gym.IDS[demo], num_envs=2, vectorization_mode="vector_entry_point"
    )
    first, _ = many.reset(seed=5)
    kept = first.copy()
    second = many.step(many.action_space.sample())[0]
    assert (first == kept).all()
    for seen in (first, second):
        assert seen.dtype == np.float32
        assert seen.flags.owndata
        assert seen in many.observation_space
    assert not np.shares_memory(first, second)


def test_the_vector_environment_resets_an_episode_with_the_next_step():
    many = vector(2, max_episode_steps=3)
    many.reset(seed=1)
    still = np.zeros((2, 7), dtype=np.float32)
    ended = [many.step(still)[3].tolist() for _ in range(4)]
    assert ended == [[False, False], [False, False], [True, True], [False, False]]
    _, _, terminated, truncated, info = many.step(still)
    assert not (terminated | truncated).any()
    assert info["time_s"].tolist() == pytest.approx([0.05, 0.05])


def test_a_cube_in_its_place_is_worth_one_in_both_rewards():
    dense = gymnasium.make(STACK).unwrapped
    dense.reset(seed=3)
    cell, job = dense.cell, dense.job
    first = job.progress()
    assert first[0] == 0
    cell.do(skills.pick("red_cube"))
    held = job.progress()
    assert held[0] == 0
    assert held[1] > first[1] + 0.1
    x, y = cell.task["stack_position_m"]
    cell.add_place("stack", (x, y, 0.0), layers=4, layer_height=cell.task["layer_height_m"])
    cell.do(skills.place("red_cube", "stack"))
    assert job.progress()[0] == 1


def test_reach_ends_at_its_goal():
    env = gymnasium.make(robocell.gym.IDS["reach"], reward="sparse")
    observation, _ = env.reset(seed=4)
    steps, terminated, truncated, total = 0, False, False, 0.0
    while not (terminated or truncated):
        goal, at = observation[-3:], observation[14:17]
        action = np.zeros(7, dtype=np.float32)
        action[:3] = np.clip((goal - at) / 0.03, -1, 1)
        observation, reward, terminated, truncated, info = env.step(action)
        steps, total = steps + 1, total + float(reward)
    assert terminated
    assert info["is_success"]
    assert total == 1.0
    assert steps < 60


@pytest.mark.sample
@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_an_action_that_is_not_finite_is_refused_by_name_and_the_next_one_works(number: float):
    env, other = (gymnasium.make(STACK).unwrapped for _ in range(2))
    env.reset(seed=1)
    other.reset(seed=1)
    good = np.full(7, 0.5, dtype=np.float32)
    bad = good.copy()
    bad[4] = number
    env.step(good)
    with pytest.raises(ValueError, match=r"action\[4\], rotation y of arm 'panda', is .*(nan|inf)"):
        env.step(bad)
    other.step(good)
    assert (env.step(good)[0] == other.step(good)[0]).all()


@pytest.mark.sample
def test_a_finite_action_is_clipped():
    env, other = (gymnasium.make(STACK).unwrapped for _ in range(2))
    env.reset(seed=1)
    other.reset(seed=1)
    one, huge = np.ones(7, dtype=np.float32), np.full(7, 1e30, dtype=np.float32)
    assert (env.step(huge)[0] == other.step(one)[0]).all()
    with pytest.raises(ValueError, match="the action has 3 numbers; 7 for each arm, 7 in all"):
        env.step(one[:3])


@pytest.mark.sample
def test_a_bad_action_of_one_cell_of_a_vector_changes_no_cell():
    many, single = vector(2), gymnasium.make(STACK)
    many.reset(seed=5)
    single.reset(seed=6)
    good = np.full((2, 7), 0.5, dtype=np.float32)
    bad = good.copy()
    bad[0, 6] = np.nan
    with pytest.raises(
        ValueError, match=r"environment 0: action\[6\], gripper of arm 'panda', is nan"
    ):
        many.step(bad)
    assert (many.step(good)[0][1] == single.step(good[1])[0]).all()


@pytest.mark.sample
def test_wrong_options_are_refused():
    with pytest.raises(ValueError, match="'dense' and 'sparse' are allowed"):
        gymnasium.make(STACK, reward="sparce")


def test_a_thousand_resets_keep_memory_and_descriptors():
    def resident_kb() -> int:
        pages = Path("/proc/self/statm").read_text().split()[1]
        return int(pages) * os.sysconf("SC_PAGESIZE") // 1024

    def held() -> tuple[int, int]:
        shared = Path("/proc/self/maps").read_text().count("/dev/shm/")
        return len(os.listdir("/proc/self/fd")), shared

    env = gymnasium.make(STACK)
    for _ in range(100):
        env.reset()
    gc.collect()
    before, files = resident_kb(), held()
    for _ in range(1000):
        env.reset()
    gc.collect()
    assert resident_kb() <= 1.01 * before
    assert held() == files
