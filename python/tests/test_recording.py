"""Recordings as arrays and tables."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import EXAMPLES

import robocell

SCRIPT = [{"at_s": 4.0, "do": "drag", "object": "blue_cube", "to": [0.4, -0.3, 0.025]}]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("recording") / "run.mcap"


@pytest.fixture
def recorded(run: Callable[..., Any], file: Path) -> Path:
    if not file.exists():
        ended = run("franka-stack", None, "--speed", "max", "--record", str(file), "--seed", "3")
        assert ended.code == 0, ended.text
    return file


def test_is_what_a_cell_in_this_process_computes(recorded: Path):
    recording = robocell.read(recorded)
    assert (recording.demo, recording.seed) == ("franka-stack", 3)
    assert (recording.cut, recording.problems) == (None, [])
    cell = robocell.Cell("franka-stack", 3, policy=recording.policy)
    row = 0
    while cell.step(10):
        row += 1
        assert recording.time_s[row] == cell.time_s
        if row % 100:
            continue
        arm = recording.arms["panda"]
        assert (arm.joint_positions[row] == cell.arm.joint_positions).all()
        assert (arm.tcp_position[row] == cell.arm.tcp_position).all()
        for name, one in cell.objects.items():
            assert (recording.objects[name].position[row] == one.position).all()
    assert row == len(recording.time_s) - 1
    assert recording.events[-1].kind == "done"
    assert [event.text for event in recording.events] == [line for _, line in cell.log()]


def test_tells_how_long_each_decision_took(recorded: Path):
    recording = robocell.read(recorded)
    sent = recording.published_ns
    assert len(sent) == len(recording.time_s)
    assert (np.diff(sent.astype(np.int64)) > 0).all()
    decisions = recording.decisions["header"]
    at = np.searchsorted(recording.time_s, decisions["tick"] / 1000.0)
    took_s = (decisions["publish_ns"] - sent[at]) * 1e-9
    # Lockstep: a decision comes after its state, and before the next state that needs it.
    assert (took_s > 0).all()
    assert (decisions["publish_ns"][:-1] < sent[at[:-1] + 1]).all()


def test_has_tables(recorded: Path):
    pytest.importorskip("pandas")
    recording = robocell.read(recorded, every=100)
    joints, objects = recording.joints_table(), recording.objects_table()
    assert next(iter(joints.columns)) == "panda/panda_joint1"
    assert len(joints) == len(objects) == len(recording.time_s)
    np.testing.assert_allclose(objects["red_cube/x"].iloc[-1], 0.55, atol=0.01)
    decisions = recording.decisions_table()
    assert decisions["outcome"].iloc[-1] == "Done"
    assert decisions["phase"].iloc[-1] == "DONE"
    assert "all stacked" in recording.events_table()["text"].iloc[-1]


def test_is_plotted_by_the_notebook(recorded: Path, monkeypatch: pytest.MonkeyPatch):
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib").use("Agg")
    notebook = json.loads((EXAMPLES / "recording.ipynb").read_text())
    code = ["".join(one["source"]) for one in notebook["cells"] if one["cell_type"] == "code"]
    monkeypatch.chdir(recorded.parent)
    names: dict[str, Any] = {}
    for source in code:
        exec(source, names)
    assert eval(code[-1].splitlines()[-1], names) == 0.0


def test_that_was_cut_says_where(recorded: Path, tmp_path: Path):
    half = tmp_path / "half.mcap"
    bytes_ = recorded.read_bytes()
    half.write_bytes(bytes_[: len(bytes_) // 2])
    recording = robocell.read(half)
    assert recording.cut
    assert 0 < recording.time_s[-1] < robocell.read(recorded).time_s[-1]


@pytest.mark.sample
def test_that_is_none_is_refused(tmp_path: Path):
    text = tmp_path / "text.mcap"
    text.write_text("no recording")
    for path in (text, tmp_path / "missing.mcap"):
        with pytest.raises(ValueError, match=str(path)):
            robocell.read(path)
    with pytest.raises(ValueError, match="every is 0"):
        robocell.read(text, every=0)


def test_has_all_objects_from_the_first_row(run: Callable[..., Any], tmp_path: Path):
    # More objects than one message of a recording has.
    file = tmp_path / "many.mcap"
    run("ur10-fill-bin", None, "--speed", "max", "--record", str(file), "--timeout", "0.5")
    recording = robocell.read(file)
    assert len(recording.objects) > 8
    for name, one in recording.objects.items():
        assert np.linalg.norm(one.orientation[0]) == pytest.approx(1.0), name
        assert np.linalg.norm(one.position[1] - one.position[0]) < 0.1, name
