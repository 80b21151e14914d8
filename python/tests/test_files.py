"""Trees of BehaviorTree.CPP, imported, with leaves in Python."""

from __future__ import annotations

import subprocess
from typing import Any

import numpy as np
import pytest
from conftest import program

from robocell._core import FileTree, Status

LOCKSTEP = ("--speed", "max")

#: What its tutorial teaches: ports, a subtree with remapping, reactive nodes, scripts.
FETCH = """
<root BTCPP_format="4" main_tree_to_execute="Fetch">
  <BehaviorTree ID="Fetch">
    <Sequence>
      <Script code="tries := 0"/>
      <RetryUntilSuccessful num_attempts="3">
        <SubTree ID="Carry" object="cube" place="{goal}" said="{word}" _autoremap="false"/>
      </RetryUntilSuccessful>
      <Say text="{word}"/>
      <Timeout msec="20000"><Home/></Timeout>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Carry">
    <ReactiveSequence>
      <Condition ID="OnTable" object="{object}"/>
      <Sequence>
        <ChooseGoal goal="{place}"/>
        <Grasp object="{object}" _onSuccess="said := 'held'"/>
        <PutDown object="{object}" place="{place}"/>
      </Sequence>
    </ReactiveSequence>
  </BehaviorTree>
</root>
"""

TASK = """
from robocell.task import policy, skills
from robocell.task.files import Leaf, TreeFile

class Work(Leaf):
    def __init__(self):
        self.skill = None

    def start(self, cell, ports):
        self.skill = None

    def tick(self, cell, ports):
        if self.skill is None:
            self.skill = self.make(ports)
        return cell.arm.do(self.skill)

class Grasp(Work):
    def make(self, ports):
        return skills.pick(ports["object"])

class PutDown(Work):
    def make(self, ports):
        return skills.place(ports["object"], ports["place"])

class Home(Work):
    def make(self, ports):
        return skills.home()

class Say(Leaf):
    def tick(self, cell, ports):
        cell.log("said " + ports["text"])
        return True

def choose_goal(cell, ports):
    ports["goal"] = "mark"
    return True

@policy
class Fetch(TreeFile):
    file = "fetch.tree.json"
    leaves = {
        "Grasp": Grasp, "PutDown": PutDown, "Home": Home, "Say": Say, "ChooseGoal": choose_goal,
        "OnTable": lambda cell, ports: cell.objects[ports["object"]].position[2] > 0,
    }
"""


@pytest.fixture
def fetch(task, tmp_path):
    """The task, beside the tree that was imported."""
    xml = tmp_path / "fetch.xml"
    xml.write_text(FETCH)
    words = [str(program()), "bt", "import", str(xml)]
    imported = subprocess.run(words, capture_output=True, text=True, check=True)
    file = task(TASK)
    (file.parent / "fetch.tree.json").write_text(imported.stdout)
    return file


@pytest.mark.sample
def test_an_imported_tree_runs_and_resumes_when_it_is_killed(run, robocell, fetch):
    checked = robocell("bt", "check", str(fetch.parent / "fetch.tree.json"))
    assert checked.code == 0, checked.text
    alone = run("cube", fetch, *LOCKSTEP)
    assert alone.summary["outcome"] == "done", alone.text
    times = (0.02, 0.5, 1.5, 2.5, 3.5, 4.5, 5.5)
    script = [{"at_s": at, "do": "kill", "process": "task"} for at in times]
    killed = run("cube", fetch, *LOCKSTEP, script=script)
    assert killed.summary["outcome"] == "done", killed.text
    assert killed.summary["state_hash"] == alone.summary["state_hash"]
    assert killed.summary["task_restarts"] == len(times)


@pytest.mark.sample
def test_a_leaf_that_is_missing_or_wrong_is_named(run, fetch):
    text = fetch.read_text()
    fetch.write_text(text.replace('"Home": Home, ', ""))
    refused = run("cube", fetch)
    assert refused.code == 3, refused.text
    assert "fetch.tree.json:" in refused.text
    assert "the policy's 'leaves' have no 'Home'" in refused.text
    fetch.write_text(text.replace('"goal"] = "mark"\n    return True', '"gaol"] = "mark"'))
    wrong = run("cube", fetch, "--one-process")
    assert "leaf 'Carry/ChooseGoal' answered None" in wrong.text, wrong.text
    fetch.write_text(text.replace('"goal"] = "mark"', '"gaol"] = "mark"'))
    wrong = run("cube", fetch, "--one-process")
    assert "has no bound port 'gaol'; did you mean 'goal'?" in wrong.text, wrong.text


@pytest.mark.sample
def test_a_leaf_is_replaced(run, fetch):
    plain = run("cube", fetch, *LOCKSTEP).summary
    later = run("cube", fetch, *LOCKSTEP, "--replace", "Home=failure:0").summary
    assert later["state_hash"] == plain["state_hash"]
    # The arm does not go home.
    without = run("cube", fetch, *LOCKSTEP, "--replace", "Home=success").summary
    assert without["outcome"] == "done"
    assert without["sim_time_s"] < plain["sim_time_s"]
    wrong = run("cube", fetch, *LOCKSTEP, "--replace", "Hom=success")
    assert wrong.code == 3
    assert "unknown leaf 'Hom'; did you mean 'Home'?" in wrong.text


#: A leaf with a port of each type that Python writes, and one for any type.
WRITES = """
{"format": "behavior-tree/1", "name": "t",
 "blackboard": {"local": {
   "flag": {"type": "bool"}, "count": {"type": "integer"}, "size": {"type": "number"},
   "word": {"type": "text"}, "point": {"type": "numbers"}, "other": {"type": "integer"}}},
 "leaves": {"Write": {"ports": {
   "flag": {"type": "bool", "access": "write"}, "count": {"type": "integer", "access": "write"},
   "size": {"type": "number", "access": "write"}, "word": {"type": "text", "access": "write"},
   "point": {"type": "numbers", "access": "write"}, "any": {"type": "any", "access": "write"}}}},
 "root": {"id": "w", "type": "Write", "ports": {
   "flag": {"bb": "local.flag"}, "count": {"bb": "local.count"}, "size": {"bb": "local.size"},
   "word": {"bb": "local.word"}, "point": {"bb": "local.point"}, "any": {"bb": "local.other"}}}}
"""


def written(**values: Any) -> dict[str, str]:
    """The blackboard after a leaf wrote the values."""

    def include(name: str) -> str:
        raise FileNotFoundError(name)

    tree = FileTree("t.json", WRITES, ["Write"], include)
    tree.tick(0, lambda _node, _what, _ports: (Status.SUCCESS, values))
    return dict(tree.values())


@pytest.mark.sample
def test_a_leaf_writes_a_port_of_each_type():
    values = written(flag=True, count=3, size=3, word="three", point=[1, 2.5], any=4)
    assert values == {
        "flag": "true",
        "count": "3",
        "size": "3",
        "word": "'three'",
        "point": values["point"],
        "other": "4",
    }
    assert written(count=np.int32(-7))["count"] == "-7"
    assert written(count=2**60 + 1)["count"] == str(2**60 + 1)
    for wrong in ({"count": 2.5}, {"count": True}, {"flag": 1}, {"size": "3"}):
        with pytest.raises(TypeError, match="its key is of another type"):
            written(**wrong)
