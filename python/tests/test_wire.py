"""Layouts of messages."""

from __future__ import annotations

import json
import subprocess

import numpy as np
import pytest
from conftest import program

from robocell import wire


@pytest.mark.sample
def test_is_the_contract_of_the_programs():
    printed = subprocess.check_output([str(program()), "schema", "wire"], text=True)
    assert json.loads(printed) == wire.schema()


@pytest.mark.sample
@pytest.mark.parametrize("name", ["WorldState", "Decision", "ArmStatus", "TraceLine", "Health"])
def test_every_message_is_a_numpy_type_of_its_size(name):
    dtype = wire.dtype(name)
    assert dtype.itemsize == wire.schema()["structs"][name]["size"]
    message = np.zeros(1, dtype)[0]
    assert message["header"]["tick"] == 0
    assert wire.type_name(name).startswith(f"{name}#")


@pytest.mark.sample
def test_an_unknown_struct_is_refused():
    with pytest.raises(KeyError, match=r"known are: .*WorldState"):
        wire.dtype("WorldStat")


@pytest.mark.sample
def test_codes_have_names():
    assert wire.code("GoalKind", "Hold") == 0
    assert wire.code("GripperGoal", "Close") != wire.code("GripperGoal", "Open")
