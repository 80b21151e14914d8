"""A cell in this process."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES

import robocell
from robocell import Status
from robocell.task import skills

sys.path.insert(0, str(EXAMPLES))


@pytest.mark.sample
@pytest.mark.parametrize(
    ("demo", "policy"), [("cube", "default"), ("franka-stack", "bt"), ("franka-pyramid", "json")]
)
def test_has_the_state_hash_of_the_program(run: Callable[..., Any], demo: str, policy: str):
    summary = robocell.Cell(demo, 3, policy=policy).run()
    words = ["--one-process", "--seed", "3", "--until-done"]
    words += [] if policy == "default" else ["--policy", policy]
    program = run(demo, None, *words).summary
    for key in ("outcome", "ticks", "placed", "state_hash"):
        assert summary[key] == program[key], key
    assert summary["outcome"] == "done"


@pytest.mark.sample
def test_with_other_numbers_has_the_state_hash_of_the_program(run: Callable[..., Any]):
    numbers = {"object.*.mass_kg": 0.2, "disturbance.position_noise_m": 0.002}
    summary = robocell.Cell("cube", 3, policy="default", set=numbers).run()
    words = [word for key, value in numbers.items() for word in ("--set", f"{key}={value}")]
    program = run("cube", None, "--one-process", "--seed", "3", "--until-done", *words).summary
    assert summary["state_hash"] == program["state_hash"]
    with pytest.raises(ValueError, match="did you mean 'mass_kg'"):
        robocell.Cell("cube", set={"object.cube.mas_kg": 1.0})


def test_with_a_policy_in_python_has_the_state_hash_of_the_program(run: Callable[..., Any]):
    from stack_ifelse import Stack  # type: ignore[import-not-found]

    cell = robocell.Cell("franka-stack", 2, policy=Stack)
    file = EXAMPLES / "stack_ifelse.py"
    program = run("franka-stack", file, "--one-process", "--seed", "2").summary
    assert cell.run()["state_hash"] == program["state_hash"]
    assert cell.is_done


def test_a_bin_that_was_lost_is_palletized_all_the_same():
    pytest.importorskip("transitions")
    from palletize import Palletizer  # type: ignore[import-not-found]

    lost = []

    class Clumsy(Palletizer):
        def decide(self, cell: Any) -> None:
            super().decide(cell)
            if self.state == "placing" and not lost:
                lost.append(cell.arm.held)
                cell.arm.grip("open")

    cell = robocell.Cell("ur10-palletize", 1, policy=Clumsy)
    cell.step(60_000)
    assert lost == ["bin_01"]
    assert "bin_01" in cell.summary()["placed"]


def test_moves_its_arm_to_a_pose_and_to_joint_positions():
    cell = robocell.Cell("franka-stack", 1)
    cell.arm.send((0.4, 0.2, 0.3))
    assert cell.step(2000) == 2000
    np.testing.assert_allclose(cell.arm.tcp_position, (0.4, 0.2, 0.3), atol=2e-3)
    for avoid in (True, False):
        target = np.array(cell.arm.home) + 0.1
        cell.arm.send_joints(list(target), avoid_obstacles=avoid)
        cell.step(4000)
        np.testing.assert_allclose(cell.arm.joint_positions, target, atol=0.02)


@pytest.mark.sample
def test_does_skills_one_after_the_other():
    cell = robocell.Cell("franka-stack", 1)
    cell.add_place("spot", (0.5, -0.1, 0.0))
    assert cell.do(skills.pick("red_cube")) == Status.SUCCESS
    assert cell.arm.held == "red_cube"
    assert cell.do(skills.place("red_cube", "spot")) == Status.SUCCESS
    assert cell.placed("spot") == ["red_cube"]
    np.testing.assert_allclose(cell.objects["red_cube"].position[:2], (0.5, -0.1), atol=5e-3)


@pytest.mark.sample
def test_goes_back_to_a_snapshot_with_a_cube_in_the_gripper():
    cell = robocell.Cell("franka-stack", 1)
    cell.do(skills.pick("red_cube"))
    before, snapshot = cell.tick, cell.snapshot()

    def go() -> tuple[int, str]:
        cell.arm.send((0.4, 0.2, 0.3), gripper="close")
        cell.step(1000)
        assert cell.arm.held == "red_cube"
        return cell.tick, cell.state_hash

    after = go()
    cell.arm.grip("open")
    cell.step(500)
    assert cell.arm.held is None
    cell.restore(snapshot)
    assert (cell.tick, cell.arm.held) == (before, "red_cube")
    assert go() == after


@pytest.mark.sample
def test_refuses_a_snapshot_of_another_cell_and_is_unchanged():
    cell = robocell.Cell("franka-stack", 1)
    cell.step(100)
    before = cell.state_hash
    for bytes_ in (b"", b"nonsense", robocell.Cell("franka-pyramid").snapshot()):
        with pytest.raises(ValueError, match="snapshot"):
            cell.restore(bytes_)
    with pytest.raises(ValueError, match="snapshot"):
        cell.restore(robocell.Cell("franka-stack", 2).snapshot())
    assert cell.state_hash == before


@pytest.mark.sample
@pytest.mark.parametrize("demo", ["ur10-palletize", "franka-pyramid"])
def test_a_refused_snapshot_leaves_what_was_told_and_asked(demo: str):
    def told() -> robocell.Cell:
        cell = robocell.Cell(demo, 1)
        if demo == "ur10-palletize":
            cell.add_bin()
        else:
            for arm, cube in zip(cell.arms, ("cube_1", "cube_4"), strict=True):
                arm.begin(skills.pick(cube))
            cell.step(600)
        return cell

    calm, cell = told(), told()
    with pytest.raises(ValueError, match="snapshot"):
        cell.restore(robocell.Cell(demo, 2).snapshot())
    for one in (calm, cell):
        one.step(500)
    assert cell.state_hash == calm.state_hash


@pytest.mark.sample
def test_is_the_same_after_a_reset_and_another_with_another_seed():
    cell = robocell.Cell("franka-stack", 1)
    at = cell.objects["red_cube"].position

    def go(seed: int) -> tuple[str, list[float]]:
        cell.reset(seed)
        start = at.tolist()
        cell.arm.send((0.5, 0.0, 0.2))
        cell.step(300)
        return cell.state_hash, start

    first = go(1)
    other = go(2)
    assert go(1) == first
    assert other[0] != first[0]
    assert other[1] != first[1]


@pytest.mark.sample
def test_raises_what_its_policy_raised():
    def decide(cell: Any) -> None:
        if cell.time_s > 0.2:
            cell.objects["nothing"]

    cell = robocell.Cell("franka-stack", policy=decide)
    with pytest.raises(KeyError, match="unknown object 'nothing'; known are: red_cube"):
        cell.step(1000)
    assert cell.time_s < 0.3
    message = cell.summary()["message"]
    assert "test_cell.py" in message
    assert "unknown object 'nothing'" in message
    assert f"[fault] {message}"[:100] in cell.log()[-1][1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "franka-stak"}, "unknown demo 'franka-stak'"),
        ({"name": "franka-stack", "policy": "x"}, "unknown policy 'x'"),
        ({"name": "franka-stack", "script": '{"at_s": 1}'}, "script"),
        ({"name": "mine", "data": "/nowhere"}, "unknown demo 'mine'"),
    ],
)
def test_that_does_not_exist_is_refused(arguments: dict[str, Any], message: str):
    with pytest.raises(ValueError, match=message):
        robocell.Cell(**arguments)


@pytest.mark.sample
def test_takes_commands_from_outside_only_without_a_policy():
    cell = robocell.Cell("franka-stack", policy="fsm")
    with pytest.raises(RuntimeError, match="only while decide"):
        cell.arm.send((0.4, 0.0, 0.3))
    own = robocell.Cell("franka-stack")
    with pytest.raises(ValueError, match="without a policy"):
        own.run()
    with pytest.raises(ValueError, match="7 finite joint positions"):
        own.arm.send_joints([0.0])


def test_gets_disturbances_from_a_script():
    line = {"at_s": 4.0, "do": "drag", "object": "blue_cube", "to": [0.4, -0.3, 0.025]}
    calm = robocell.Cell("franka-stack", 3, policy="fsm")
    disturbed = robocell.Cell("franka-stack", 3, policy="fsm", script=json.dumps(line))
    assert calm.run()["state_hash"] != disturbed.run()["state_hash"]
    assert disturbed.summary()["outcome"] == "done"


@pytest.mark.sample
def test_draws_the_cubes_where_they_are(tmp_path: Path):
    cell = robocell.Cell("franka-stack", 1)
    for name, channel in (("red_cube", 0), ("blue_cube", 2)):
        at = cell.objects[name].position
        picture = cell.render(64, 48, eye=at + np.array((0.0, -0.3, 0.3)), target=at)
        assert picture.shape == (48, 64, 3)
        pixel = picture[24, 32].astype(int)
        others = np.delete(pixel, channel)
        assert pixel[channel] > 2 * others.max(), (name, pixel)
    assert (cell.render() == cell.render()).all()
    with pytest.raises(ValueError, match="0 x 48 pixels"):
        cell.render(0, 48)
    with pytest.raises(ValueError, match="no direction of view"):
        cell.render(64, 48, eye=(0, 0, 0), target=(0, 0, 0))


@pytest.mark.sample
def test_cameras_see_colour_depth_and_mask():
    cell = robocell.Cell("franka-stack", 1)
    assert cell.cameras == ["front", "wrist"]
    seen = cell.observe(["front", "wrist"])
    image = seen["front"]
    assert (image.rgb.shape, image.depth.shape, image.mask.shape) == (
        (224, 224, 3),
        (224, 224),
        (224, 224),
    )
    red = image.mask == 1 + cell.instances.index("red_cube")
    assert red.sum() > 10
    assert (image.rgb[red][:, 0] > 2 * image.rgb[red][:, 2]).all()
    eye = np.array((1.5, 0.5, 1.2))
    away = np.linalg.norm(cell.objects["red_cube"].position - eye)
    assert abs(np.median(image.depth[red]) - away) < 0.1
    assert (image.depth[image.mask == 0] == 0).all()
    # What a camera at the tool sees moves with the arm.
    cell.arm.send((0.4, 0.2, 0.3))
    cell.step(1500)
    later = cell.observe(["wrist"])["wrist"]
    assert (later.depth != seen["wrist"].depth).mean() > 0.5
    with pytest.raises(ValueError, match=r"camera 'wrst' is not known.*wrist"):
        cell.observe(["wrst"])


@pytest.mark.sample
def test_several_advance_together_as_each_alone():
    def make(seed: int) -> robocell.Cell:
        cell = robocell.Cell("franka-stack", seed)
        cell.arm.send((0.4, 0.1, 0.2))
        return cell

    cells = [make(seed) for seed in range(4)]
    assert robocell.step_all(cells, 500) == [500] * 4
    for seed, cell in enumerate(cells):
        alone = make(seed)
        alone.step(500)
        assert alone.state_hash == cell.state_hash
