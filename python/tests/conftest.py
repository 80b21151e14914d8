"""Where the programs are, and how a cell is run."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import robocell as package

EXAMPLES = Path(__file__).parent.parent / "examples"


def program() -> Path:
    """The program ``robocell``: ``$ROBOCELL``, that of the package, or of the checkout."""
    named = os.environ.get("ROBOCELL")
    places = [
        Path(named) if named else None,
        Path(package.__file__).parent / "bin" / "robocell",
        Path(__file__).parents[2] / "target" / "release" / "robocell",
        Path(__file__).parents[2] / "target" / "debug" / "robocell",
    ]
    for place in places:
        if place is not None and place.is_file():
            return place
    pytest.skip("program robocell is missing: set ROBOCELL, or build the wheel")


class Run:
    """What a run of a cell printed."""

    def __init__(self, done: subprocess.CompletedProcess[str]) -> None:
        self.code = done.returncode
        self.text = done.stdout + done.stderr
        lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
        self.summary: dict[str, Any] = json.loads(lines[-1]) if lines else {}


@pytest.fixture
def robocell() -> Iterator[Callable[..., Run]]:
    """Calls the program: ``robocell("status", cwd=DIR)``."""
    # Paths of sockets are short.
    home = Path(tempfile.mkdtemp(prefix="rt", dir="/dev/shm"))
    env = dict(os.environ, ROBOCELL_RUN_DIR=str(home), ROBOCELL_PYTHON=sys.executable)
    env["PYTHONPATH"] = os.pathsep.join(path for path in sys.path if path)

    def call(*words: str, cwd: Path | None = None) -> Run:
        done = subprocess.run(
            [str(program()), *words], capture_output=True, text=True, env=env, cwd=cwd, check=False
        )
        return Run(done)

    yield call
    shutil.rmtree(home, ignore_errors=True)


@pytest.fixture
def run(robocell: Callable[..., Run], tmp_path: Path) -> Callable[..., Run]:
    """Runs a cell with a task to its end: ``run("franka-stack", FILE, *options)``."""

    def start(
        demo: str, task: Path | None, *options: str, script: list[dict[str, Any]] | None = None
    ) -> Run:
        words = ["run", demo, "--json", "--headless"]
        words += [] if "--until-done" in options else ["--until-done"]
        words += [] if task is None else ["--task", str(task)]
        if script is not None:
            lines = tmp_path / "script.jsonl"
            lines.write_text("".join(json.dumps(line) + "\n" for line in script))
            words += ["--script", str(lines)]
        return robocell(*words, *options)

    return start


@pytest.fixture
def task(tmp_path: Path) -> Callable[[str], Path]:
    """A task file with that text."""

    def write(text: str, name: str = "mine.py") -> Path:
        file = tmp_path / name
        file.write_text(text)
        return file

    return write
