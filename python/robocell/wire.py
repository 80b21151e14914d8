"""Messages between the processes of a cell, as numpy types.

All layouts are generated from Rust.
"""

from __future__ import annotations

import functools
import json
from typing import Any

import numpy as np

from robocell import _core

_NUMBERS = {"u8": "<u1", "u32": "<u4", "u64": "<u8", "i64": "<i8", "f64": "<f8"}


@functools.cache
def schema() -> dict[str, Any]:
    """The output of ``robocell schema wire``: structs, codes, constants and topics."""
    loaded: dict[str, Any] = json.loads(_core.wire_schema())
    return loaded


@functools.cache
def dtype(name: str) -> np.dtype[Any]:
    """The numpy type of a struct, such as ``"WorldState"``.

    Raises:
        KeyError: for a struct that the contract does not have.
    """
    structs = schema()["structs"]
    if name not in structs:
        known = ", ".join(structs)
        raise KeyError(f"unknown struct '{name}'; known are: {known}")
    layout = structs[name]
    names, formats, offsets = [], [], []
    for field in layout["fields"]:
        element = _element(field["type"])
        count = field["count"]
        names.append(field["name"])
        formats.append(element if count == 1 else (element, (count,)))
        offsets.append(field["offset"])
    return np.dtype(
        {"names": names, "formats": formats, "offsets": offsets, "itemsize": layout["size"]}
    )


def _element(name: str) -> Any:
    if name in _NUMBERS:
        return np.dtype(_NUMBERS[name])
    if name.startswith("Text"):
        return np.dtype(f"S{name[4:]}")
    return dtype(name)


def code(kind: str, name: str) -> int:
    """The number of a named code: ``code("GoalKind", "Pose")``."""
    return int(schema()["codes"][kind][name])


def type_name(message: str) -> str:
    """The name under which iceoryx2 knows a message; another contract has another."""
    return f"{message}#{schema()['structs'][message]['schema']}"
