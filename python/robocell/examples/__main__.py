"""Lists the example tasks, or prints the path of one::

robocell run franka-stack --task "$(python -m robocell.examples stack_skills)"
"""

from __future__ import annotations

import sys
from pathlib import Path

_HERE = Path(__file__).parent
#: In a wheel the examples are beside this file, in a checkout beside the package.
_PLACES = (_HERE, _HERE.parents[1] / "examples")


def examples() -> dict[str, Path]:
    """The files by their names without ``.py``."""
    files = [file for place in _PLACES for file in sorted(place.glob("[!_]*.py"))]
    return {file.stem: file for file in files}


def main() -> int:
    """The exit code."""
    known = examples()
    if len(sys.argv) < 2:
        for name, file in known.items():
            first = file.read_text().split('"""')[1].strip().split("\n\n")[0]
            print(f"{name:16} {' '.join(first.split())}")
        return 0
    name = sys.argv[1].removesuffix(".py")
    if len(sys.argv) > 2 or name not in known:
        print(f"unknown example '{name}'; known are: {', '.join(known)}", file=sys.stderr)
        return 2
    print(known[name])
    return 0


if __name__ == "__main__":
    sys.exit(main())
