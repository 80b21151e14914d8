"""Arguments of skills are called as the ports of the same skills in files."""

from __future__ import annotations

import inspect
import json
import pickle
import subprocess

import pytest
from conftest import program

import robocell
from robocell.task import skills

pytestmark = pytest.mark.sample

#: The functions whose skill has another name in files.
OF_FILES = {
    "move_to": "MoveTo",
    "move_to_object": "MoveTo",
    "move_to_place": "MoveTo",
    "move_up": "Up",
    "wait": "Stay",
    "pick": "Pick",
    "place": "Place",
    "close": "Close",
    "conveyor": "Conveyor",
}
#: What only Python has, or has for more skills than files.
ONLY_PYTHON = {"orientation", "yaw", "precise", "gripper", "holding", "timeout_s"}


def ports() -> dict[str, set[str]]:
    """Names of the ports of each type of node."""
    done = subprocess.run(
        [str(program()), "schema", "tree"], capture_output=True, text=True, check=True
    )
    found = {}
    for rule in json.loads(done.stdout)["$defs"]["node"]["allOf"]:
        name = rule.get("if", {}).get("properties", {}).get("type", {}).get("const")
        told = rule.get("then", {}).get("properties", {}).get("ports", {})
        found[name] = set(told.get("properties", {}))
    return found


def test_arguments_are_called_as_the_ports_of_files():
    known = ports()
    for function, node in OF_FILES.items():
        arguments = set(inspect.signature(getattr(skills, function)).parameters)
        assert arguments - ONLY_PYTHON <= known[node], function
        assert arguments & known[node], function


@pytest.mark.parametrize(
    ("function", "old", "new"),
    [
        ("move_to", {"position": (0.4, 0.1, 0.3)}, {"pose": (0.4, 0.1, 0.3)}),
        ("move_to_object", {"name": "a", "above": 0.1}, {"object": "a", "above_m": 0.1}),
        (
            "move_to_place",
            {"name": "a", "place": "b", "above": 0.1},
            {"object": "a", "place": "b", "above_m": 0.1},
        ),
        ("move_up", {"by": 0.2}, {"by_m": 0.2}),
        ("pick", {"name": "a", "clearance": 0.2}, {"object": "a", "clearance_m": 0.2}),
        (
            "place",
            {"name": "a", "place": "b", "clearance": 0.2, "tolerance": 0.01},
            {"object": "a", "place": "b", "clearance_m": 0.2, "tolerance_m": 0.01},
        ),
        ("close", {"name": "a"}, {"object": "a"}),
        ("wait", {"seconds": 2.0}, {"for_s": 2.0}),
    ],
)
def test_former_names_are_taken_with_a_warning(function, old, new):
    make = getattr(skills, function)
    with pytest.warns(DeprecationWarning) as warned:
        made = make(**old)
    changed = [name for name in old if name not in new]
    assert len(warned) == len(changed)
    for name in changed:
        assert any(f"{function}({name}=) is now {function}(" in str(one.message) for one in warned)
    assert all(one.filename == __file__ for one in warned)
    assert pickle.dumps(made) == pickle.dumps(make(**new))


def test_both_names_of_an_argument_are_refused():
    with pytest.raises(TypeError, match="move_to\\(\\) got pose= and position=, its former name"):
        skills.move_to(pose=(0.4, 0.1, 0.3), position=(0.4, 0.1, 0.3))


def test_a_pose_has_three_numbers_or_seven_as_in_files():
    turn = (0.0, 0.0, 1.0, 0.0)
    seven = skills.move_to(pose=(0.4, 0.1, 0.3, *turn), above_m=0.1)
    two = skills.move_to((0.4, 0.1, 0.3 + 0.1), turn)
    assert pickle.dumps(seven) == pickle.dumps(two)
    for pose in [(0.4, 0.1), "red_cube", 0.4, (0.4, 0.1, float("nan"))]:
        with pytest.raises(ValueError, match=r"pose is .*; 3 finite numbers \(x y z, m\) or 7"):
            skills.move_to(pose=pose)
    with pytest.raises(ValueError, match="orientation= is one too many"):
        skills.move_to((0.4, 0.1, 0.3, *turn), turn)


def test_a_former_name_in_a_task_is_reported_with_its_line(run, task):
    text = """
from robocell.task import policy, skills

@policy
def decide(cell):
    cell.arm.do(skills.move_to(position=(0.4, 0.1, 0.3)))
    cell.report(True)
"""
    ended = run("franka-stack", task(text), "--one-process", "--speed", "max")
    assert ended.code == 0, ended.text
    assert "mine.py:6: DeprecationWarning: move_to(position=) is now move_to(pose=)" in ended.text


@pytest.mark.parametrize(
    "skill",
    [
        skills.pick("red_cub"),
        skills.place("red_cub", "spot"),
        skills.move_to_object("red_cub"),
        skills.move_up(holding="red_cub"),
        skills.close("red_cub"),
    ],
)
def test_a_cell_without_a_policy_refuses_a_skill_with_an_unknown_name(skill):
    cell = robocell.Cell("franka-stack")
    with pytest.raises(ValueError, match=r"three numbers \(x y z\) are needed, not \(0.5, -0.1\)"):
        cell.add_place("spot", (0.5, -0.1))
    cell.add_place("spot", (0.5, -0.1, 0.0))
    with pytest.raises(ValueError, match=r"did you mean 'red_cube'\?"):
        cell.do(skill, timeout_s=0.02)
    with pytest.raises(ValueError, match=r"unknown place 'spt'; did you mean 'spot'\?"):
        cell.do(skills.place("red_cube", "spt"), timeout_s=0.02)
    with pytest.raises(TypeError, match=r"needs a skill, as skills.home\(\), not <function pick"):
        cell.do(skills.pick)
