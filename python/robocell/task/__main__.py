"""Runs the task of a file: ``python -m robocell.task FILE ARGUMENTS``. ``robocell``
starts it as the task process of a cell, and for ``eval``, ``verify`` and ``show``."""

from __future__ import annotations

import gc
import importlib.util
import os
import sys
import threading
import warnings
from types import ModuleType
from typing import NoReturn

from robocell import _core
from robocell.task import _registry
from robocell.task._explain import explain
from robocell.task._refuse import Refused, line_of
from robocell.task._runner import Maker, maker
from robocell.task.skills import FORMER_NAME

_CONFIGURATION = 3
_NAME_BYTES = 16


def load(path: str) -> ModuleType:
    """Imports a file under its own name, so that its classes can be pickled."""
    name = os.path.splitext(os.path.basename(path))[0]
    if name in sys.modules or name in sys.stdlib_module_names:
        name = f"task_{name}"
    sys.path.insert(0, os.path.dirname(os.path.abspath(path)))
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def policies(path: str) -> list[tuple[str, Maker]]:
    """The policies of a file, by name; the first is its default."""
    _registry.declared.clear()
    module = load(path)
    # Those of a file that it imports are not its own.
    declared = [one for one in _registry.declared if one[1].__module__ == module.__name__]
    stem = os.path.splitext(os.path.basename(path))[0]
    default = stem.encode()[:_NAME_BYTES].decode(errors="ignore")
    if not declared:
        raise ImportError(
            f"{path}: no policy found; mark a class or a function with @robocell.task.policy"
        )
    found: dict[str, Maker] = {}
    first: dict[str, str] = {}
    for name, target in declared:
        name = default if name is None else name
        if name in found:
            raise Refused(
                line_of(target),
                f"this is a second policy '{name}'; the first is in {first[name]}: "
                '@policy("other_name") names one, and --policy chooses it',
            )
        found[name] = maker(target)
        first[name] = line_of(target)
    # Without a policy of the file's name the first one has that name, too.
    if default not in found:
        found[default] = next(iter(found.values()))
    names = sorted(found, key=lambda name: name != default)
    return [(name, found[name]) for name in names]


def _refuse_exit() -> None:
    """Makes ``os._exit`` raise: it ends all of the cell in one process, and leaves nothing to
    report. Forked processes keep it."""
    leave, own = os._exit, os.getpid()

    def exit_or_raise(status: int) -> NoReturn:
        if os.getpid() != own:
            leave(status)
        raise RuntimeError(
            f"os._exit({status}) would end the process of the task; raise an exception, or "
            "call cell.fail(reason, why)"
        )

    vars(os)["_exit"] = exit_or_raise
    vars(os)["_leave"] = leave


def _leave_threads(code: int) -> None:
    """Ends this process although a thread of the task does not: the program that asked this
    program waits for its end."""
    alive = [one for one in threading.enumerate() if not one.daemon]
    names = [one.name for one in alive if one is not threading.main_thread()]
    if names:
        print(
            f"warning: {sys.argv[1]}: the process ends although these threads of the task have "
            f"not: {', '.join(names)}; daemon=True allows it without this warning",
            file=sys.stderr,
        )
        sys.stdout.flush()
        sys.stderr.flush()
        vars(os)["_leave"](code)


def main() -> int:
    """The task program of ``sys.argv[1]``; its exit code."""
    if len(sys.argv) < 2:
        print("usage: python -m robocell.task FILE [ARGUMENTS]", file=sys.stderr)
        return 2
    path = sys.argv[1]
    _refuse_exit()
    # Python shows those of the main program only.
    warnings.filterwarnings("default", FORMER_NAME, DeprecationWarning)
    try:
        found = policies(path)
    except Exception as error:
        print(explain(error), file=sys.stderr)
        return _CONFIGURATION
    # What the imports made stays: the collections of a running task need not look at it.
    gc.collect()
    gc.freeze()
    return _core.task_main(found, sys.argv[2:])


if __name__ == "__main__":
    code = main()
    _leave_threads(code)
    sys.exit(code)
