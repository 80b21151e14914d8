"""Exceptions of a user's file in one line, with the place where they were raised."""

from __future__ import annotations

import importlib.util
import os
import site
import sysconfig
import traceback

from robocell.task._refuse import Refused

_OWN = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
#: Its files are tasks.
_EXAMPLES = os.path.join(_OWN, "examples")


def _engines() -> tuple[str, ...]:
    """Folders of the packages that call functions of a user."""
    specs = [importlib.util.find_spec(name) for name in ("transitions", "py_trees")]
    return tuple(os.path.dirname(one.origin) for one in specs if one and one.origin)


def _libraries() -> tuple[str, ...]:
    """Folders of installed packages."""
    paths = sysconfig.get_paths()
    own = [paths[key] for key in ("stdlib", "platstdlib", "purelib", "platlib")]
    # Distributions have folders of their own.
    return (*own, *site.getsitepackages(), site.getusersitepackages())


def explain(error: BaseException) -> str:
    """``FILE:LINE: in FUNCTION: TYPE: MESSAGE``, or ``FILE:LINE: MESSAGE`` of a refusal."""
    message = " ".join(str(error).split())
    if isinstance(error, Refused) and error.where:
        return message
    what = f"{type(error).__name__}: {message}" if message else type(error).__name__
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}:{error.lineno}: {type(error).__name__}: {error.msg}"
    frame = _frame(error)
    if frame is None:
        return what
    return f"{os.path.abspath(frame.filename)}:{frame.lineno}: in {frame.name}: {what}"


def _frame(error: BaseException) -> traceback.FrameSummary | None:
    """The innermost frame of a file of the user. Where there is none, as of a task in an
    installed package, the innermost one outside of this package and of those that call a
    user's functions."""
    engines, libraries = _engines(), _libraries()
    last = None
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        path = os.path.abspath(frame.filename)
        is_own = _is_in(path, (_OWN,)) and not _is_in(path, (_EXAMPLES,))
        if frame.filename.startswith("<") or is_own or _is_in(path, engines):
            continue
        if _is_in(path, (_EXAMPLES,)) or not _is_in(path, libraries):
            return frame
        last = last or frame
    return last


def _is_in(path: str, folders: tuple[str, ...]) -> bool:
    return path.startswith(tuple(folder + os.sep for folder in folders))
