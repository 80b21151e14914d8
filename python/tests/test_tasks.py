"""Tasks in Python as tasks of a cell."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import EXAMPLES

from robocell import read, wire

LOCKSTEP = ("--speed", "max")
KILLS = [{"at_s": at, "do": "kill", "process": "task"} for at in (3.0, 6.5, 9.0, 15.5)]

NEEDS = {"stack_tree": "py_trees", "stack_fsm": "transitions", "palletize": "transitions"}


def example(name: str) -> Path:
    package = NEEDS.get(name)
    if package is not None and importlib.util.find_spec(package) is None:
        pytest.skip(f"the package {package} is not installed")
    return EXAMPLES / f"{name}.py"


@pytest.mark.parametrize("name", ["stack_skills", "stack_ifelse", "stack_tree", "stack_fsm"])
def test_is_the_same_in_one_process_in_four_and_killed(run, name):
    file = example(name)
    one = run("franka-stack", file, "--one-process").summary
    assert one["outcome"] == "done"
    assert len(one["placed"]) == 4
    assert one["policy"] == name
    four = run("franka-stack", file, *LOCKSTEP).summary
    killed = run("franka-stack", file, *LOCKSTEP, script=KILLS).summary
    assert killed["task_restarts"] == len(KILLS)
    assert one["state_hash"] == four["state_hash"] == killed["state_hash"]


@pytest.mark.parametrize("way", ["ifelse", "script", "fsm", "tree", "table", "matrix"])
def test_a_way_puts_the_cube_on_its_mark_and_is_the_same_when_killed(run, way):
    for package in ("py_trees", "transitions"):
        pytest.importorskip(package)
    file = EXAMPLES / "cube_six_ways.py"
    alone = run("cube", file, "--policy", way, "--one-process").summary
    assert (alone["outcome"], alone["drops"]) == ("done", 0)
    script = [{"at_s": at, "do": "kill", "process": "task"} for at in (0.7, 2.3, 4.1, 6.2)]
    killed = run("cube", file, "--policy", way, *LOCKSTEP, script=script).summary
    assert (killed["outcome"], killed["task_restarts"]) == ("done", 4)
    # A generator has no checkpoint: the script starts from its first step.
    if way != "script":
        assert killed["state_hash"] == alone["state_hash"]


def test_a_pallet_is_the_same_in_one_process_and_in_four_with_a_killed_task(run):
    file = example("palletize")
    alone = run("ur10-palletize", file, "--one-process").summary
    assert (alone["outcome"], len(alone["placed"]), alone["drops"]) == ("done", 9, 0)
    killed = run("ur10-palletize", file, *LOCKSTEP, script=KILLS).summary
    assert killed["task_restarts"] == len(KILLS)
    for key in ("outcome", "ticks", "placed", "state_hash"):
        assert killed[key] == alone[key], key


def test_a_bin_that_leans_on_the_stop_is_lifted_without_losing_it(run):
    done = run("ur10-palletize", example("palletize"), "--one-process", "--seed", "11").summary
    assert (done["outcome"], len(done["placed"]), done["drops"]) == ("done", 9, 0)


def test_is_evaluated_over_seeds(robocell):
    task = ("--task", str(example("stack_skills")))
    done = robocell("eval", "franka-stack", *task, "--seeds", "1..2", "--json")
    assert done.code == 0, done.text
    assert (done.summary["runs"], done.summary["done"]) == (2, 2)


@pytest.mark.parametrize("name", ["stack_skills", "stack_ifelse", "stack_fsm", "stack_tree"])
def test_goes_home_stays_done_and_works_again_when_disturbed(robocell, tmp_path, name):
    words = ["run", "franka-stack", "--task", str(example(name)), "--one-process", "--json"]
    # Undisturbed, each of them is done before 37 s.
    assert robocell(*words, "--timeout", "45").summary["outcome"] == "done"
    # Off the top, at its height: the others stay in place.
    drag = {"at_s": 40.0, "do": "drag", "object": "yellow_cube", "to": [0.55, 0.35, 0.18]}
    script = tmp_path / "drag.jsonl"
    script.write_text(json.dumps(drag))
    later = ["--script", str(script), "--timeout"]
    assert robocell(*words, *later, "43").summary["outcome"] == "timeout"
    done = robocell(*words, *later, "65").summary
    assert (done["outcome"], len(done["placed"])) == ("done", 4)


def test_recovers_from_a_cube_that_is_taken_off_the_stack(run):
    drag = {"at_s": 14.0, "do": "drag", "object": "red_cube", "to": [0.45, -0.1, 0.025]}
    done = run("franka-stack", example("stack_skills"), *LOCKSTEP, script=[drag]).summary
    assert done["outcome"] == "done"
    assert len(done["placed"]) == 4


def test_stops_in_real_time_with_a_killed_task_and_finishes(run):
    kill = [{"at_phase": "PLACE", "do": "kill", "process": "task"}]
    done = run("franka-stack", example("stack_skills"), script=kill).summary
    assert (done["outcome"], done["task_restarts"], done["limit_violations"]) == ("done", 1, 0)


def test_a_task_that_is_stopped_for_10_s_is_replaced_and_the_job_finishes(run):
    stop = [{"at_s": 6.0, "do": "stop", "process": "task", "for_s": 10.0}]
    done = run("franka-stack", example("stack_skills"), script=stop).summary
    assert (done["outcome"], done["drops"], done["limit_violations"]) == ("done", 0, 0)
    assert done["task_restarts"] == 1


FAULTY = """
from robocell.task import policy, skills

@policy
class Faulty:
    def decide(self, cell):
        {line}
"""


@pytest.mark.sample
@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("cell.objects['red'].position", 'mine.py:7: in decide: KeyError: "unknown object'),
        ("skills.pick('red_cub').step(cell.arm)", "did you mean 'red_cube'?"),
        ("cell.arm.send('here')", "mine.py:7: in decide: ValueError"),
        ("cell.arm.grip('shut')", "'open', 'close' and 'keep' are allowed"),
        ("1 / 0", "mine.py:7: in decide: ZeroDivisionError"),
    ],
)
def test_that_raises_is_given_up_with_file_and_line(run, task, line, message):
    ended = run("franka-stack", task(FAULTY.format(line=line)))
    assert ended.code == 6, ended.text
    assert message in ended.text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import nothing_like_this", "mine.py:1: in <module>: ModuleNotFoundError"),
        ("def f(:", "mine.py:1: SyntaxError"),
        ("x = 1", "no policy found; mark a class or a function"),
        (
            "from robocell.task import policy\n@policy\nclass A:\n"
            "    def __init__(self, cell):\n        cell.task['no_such_key']\n",
            "mine.py:5: in __init__: KeyError",
        ),
    ],
)
def test_that_cannot_be_made_is_refused_before_anything_starts(run, task, text, message):
    ended = run("franka-stack", task(text))
    assert ended.code == 3, ended.text
    assert message in ended.text


SHARED = """
import py_trees
from robocell.task import policy, skills
from robocell.task.trees import SkillLeaf, TreePolicy

class Note(py_trees.behaviour.Behaviour):
    def __init__(self, name, done):
        super().__init__(name)
        self.done = done

    def update(self):
        self.done.append(self.name)
        return py_trees.common.Status.SUCCESS

@policy
class Tree(TreePolicy):
    def build(self, cell):
        self.done = []
        pick = SkillLeaf("pick", cell.arm, skills.pick("red_cube"))
        home = SkillLeaf("home", cell.arm, skills.home())
        notes = [Note(name, self.done) for name in "ab"]
        return py_trees.composites.Sequence("all", True, [pick, notes[0], home, notes[1]])

    def after(self, cell, status):
        cell.report(self.done == ["a", "b"])
"""


def test_leaves_and_the_policy_of_a_tree_share_an_object_after_a_kill(run, task):
    pytest.importorskip("py_trees")
    file = task(SHARED)
    alone = run("franka-stack", file, "--one-process").summary
    kill = [{"at_s": 5.0, "do": "kill", "process": "task"}]
    killed = run("franka-stack", file, *LOCKSTEP, script=kill).summary
    assert (killed["outcome"], killed["task_restarts"]) == ("done", 1)
    assert killed["state_hash"] == alone["state_hash"]


LOCKED = """
import threading
from robocell.task import SUCCESS, policy, skills

@policy
class Locked:
    def __init__(self, cell):
        self.skills = [skills.pick("red_cube"), skills.home()]
        self.lock = threading.Lock()

    def decide(self, cell):
        if self.skills and cell.arm.do(self.skills[0]) == SUCCESS:
            del self.skills[0]
        cell.report(not self.skills)
"""


@pytest.mark.sample
def test_an_attribute_that_cannot_be_kept_is_named_in_every_mode_and_the_rest_resumes(
    run, robocell, task
):
    file = task(LOCKED)
    message = f"{file}:9: self.lock is not kept over a restart: TypeError: cannot pickle"
    alone = run("franka-stack", file, "--one-process")
    assert message in alone.text
    kill = [{"at_s": 3.0, "do": "kill", "process": "task"}]
    killed = run("franka-stack", file, *LOCKSTEP, script=kill)
    assert killed.summary["outcome"] == "done", killed.text
    assert killed.summary["state_hash"] == alone.summary["state_hash"]
    assert message in robocell("logs", "task").text
    seeds = robocell("eval", "franka-stack", "--task", str(file), "--seeds", "1..3")
    assert seeds.text.count(message) == 1, seeds.text


SCRIPT = """
from robocell.task import RUNNING, policy, skills

@policy
class Script:
    def __init__(self, cell):
        self.steps = self.script(cell)

    def script(self, cell):
        home = skills.home()
        while cell.arm.do(home) == RUNNING or cell.time_s < 2.0:
            yield

    def decide(self, cell):
        cell.report(next(self.steps, "end") == "end")
"""


@pytest.mark.sample
def test_the_log_says_resumed_only_if_something_was(run, robocell, task, tmp_path):
    def said(text: str) -> list[str]:
        file = tmp_path / f"{len(text)}.mcap"
        kill = {"at_s": 1.0, "do": "kill", "process": "task"}
        words = (*LOCKSTEP, "--record", str(file))
        done = run("franka-stack", task(text), *words, "--timeout", "9", script=[kill])
        assert done.summary["task_restarts"] == 1, done.text
        lines = [event.text for event in read(file).events]
        return [line for line in lines if line.startswith("[task] ")]

    assert said(LOCKED) == ["[task] resumed from its checkpoint"]
    again = "[task] the policy starts again: nothing of its memory was kept; the job continues"
    assert said(SCRIPT) == [again]
    words = ("run", "franka-stack", "--task", str(task(SCRIPT)), "--one-process", "--until-done")
    one = robocell(*words, "--headless", "--script", str(tmp_path / "script.jsonl"))
    assert again in one.text
    assert "resumed from its checkpoint" not in one.text


@pytest.mark.sample
def test_that_calls_exit_is_reported_with_file_and_line(run, robocell, task):
    file = task("import os\n" + FAULTY.format(line="os._exit(0)"))
    message = "mine.py:8: in decide: RuntimeError: os._exit(0) would end the process"
    one = run("franka-stack", file, "--one-process")
    assert (one.code, one.summary["outcome"], one.summary["reason"]) == (
        5,
        "failed",
        "policy_raised",
    )
    four = run("franka-stack", file)
    assert four.code == 6
    assert message in four.text


@pytest.mark.sample
def test_whose_process_ends_in_the_middle_of_a_run_is_not_done(run, task):
    # As a library in C may do it.
    exits = "__import__('ctypes').CDLL(None)._exit(0)"
    ended = run("franka-stack", task(FAULTY.format(line=exits)), "--one-process")
    assert ended.code == 6
    assert "mine.py ended with exit status: 0 before the end of the run" in ended.text


@pytest.mark.sample
def test_whose_thread_does_not_end_runs_and_the_thread_is_named(run, task):
    text = """
import threading, time
from robocell.task import policy

@policy
class Threaded:
    def __init__(self, cell):
        threading.Thread(target=time.sleep, args=(1000,), name="reader").start()

    def decide(self, cell):
        cell.report(True)
"""
    ended = run("franka-stack", task(text), "--one-process")
    assert ended.code == 0, ended.text
    assert "mine.py: the process ends although these threads of the task have not: reader" in (
        ended.text
    )


@pytest.mark.sample
def test_that_a_signal_ends_in_its_constructor_is_reported_with_the_signal(run, task):
    text = """
import os
from robocell.task import policy

@policy
class Aborts:
    def __init__(self, cell):
        os.abort()

    def decide(self, cell):
        pass
"""
    ended = run("franka-stack", task(text))
    assert ended.code == 3
    assert "mine.py was asked for policy 'mine' of demo 'franka-stack'" in ended.text
    assert "SIGABRT" in ended.text


def test_that_hangs_is_replaced(run, task):
    text = """
from robocell.task import policy

@policy
class Hangs:
    def decide(self, cell):
        while cell.time_s > 0.5:
            pass
"""
    ended = run("franka-stack", task(text), "--timeout", "30")
    assert ended.code != 0
    assert "task" in ended.text


def test_chooses_a_policy_by_its_name(run, task):
    text = """
from robocell.task import policy

@policy("one")
def one(cell):
    cell.report(True)

@policy("two")
def two(cell, memory):
    memory.count = getattr(memory, "count", 0) + 1
    cell.report(memory.count > 20)
"""
    file = task(text)
    assert run("franka-stack", file, *LOCKSTEP).summary["policy"] == "mine"
    two = run("franka-stack", file, *LOCKSTEP, "--policy", "two").summary
    assert (two["policy"], two["ticks"]) == ("two", 200)
    wrong = run("franka-stack", file, *LOCKSTEP, "--policy", "tow")
    assert wrong.code == 3
    assert "did you mean 'two'?" in wrong.text


def test_in_a_project_of_its_own_is_found_beside_its_cell(robocell, tmp_path):
    assert robocell("new", "mine", "--as", "python", cwd=tmp_path).code == 0
    project = tmp_path / "mine"
    words = ("run", "mine", "--data", ".", "--until-done", "--headless", "--speed", "max")
    done = robocell(*words, "--json", "--record", "run.mcap", cwd=project)
    assert (done.summary["outcome"], done.summary["placed"]) == ("done", ["cube"]), done.text
    verified = robocell("replay", "run.mcap", "--verify", "--json", cwd=project)
    assert verified.summary["verdict"] == "same", verified.text
    seeds = robocell("eval", "mine", "--data", ".", "--seeds", "0..4", cwd=project)
    assert "5 of 5 done" in seeds.text


@pytest.mark.sample
def test_of_another_contract_is_refused_with_both_versions(task, tmp_path):
    """The task process of a cell that a launcher of another version started."""
    run_file = tmp_path / "run.json"
    run_file.write_text(json.dumps({"contract": "9.9.9 (messages 00000000)"}))
    file = task("from robocell.task import policy\n\n\n@policy\ndef decide(cell): ...\n")
    words = [str(file), "--spec", str(run_file), "--generation", "1"]
    program = [sys.executable, "-m", "robocell.task", *words]
    ended = subprocess.run(program, capture_output=True, text=True, check=False)
    assert ended.returncode == 3, ended.stderr
    ours = wire.schema()["contract"]
    message = f"this program is of robocell {ours}, the cell of 9.9.9 (messages 00000000)"
    assert message in ended.stderr
