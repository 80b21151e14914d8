"""The command ``robocell``: the program of this package, with this Python for tasks."""

from __future__ import annotations

import os
import sys

_PROGRAMS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin")


def main() -> int:
    """Becomes the program ``robocell``; returns only when there is none."""
    program = os.path.join(_PROGRAMS, "robocell")
    if not os.path.isfile(program):
        print(
            f"robocell: {program} is missing: this package was built without the programs; "
            "`python/build-wheel DIR` builds a wheel with them",
            file=sys.stderr,
        )
        return 3
    os.environ.setdefault("ROBOCELL_PYTHON", sys.executable)
    os.execv(program, ["robocell", *sys.argv[1:]])
