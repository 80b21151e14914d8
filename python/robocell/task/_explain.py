"""Exceptions of a user's file in one line, with the place where they were raised."""

from __future__ import annotations

import os
import traceback

_OWN = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def explain(error: BaseException) -> str:
    """``FILE:LINE: in FUNCTION: TYPE: MESSAGE``; the innermost line outside of this
    package."""
    message = " ".join(str(error).split())
    what = f"{type(error).__name__}: {message}" if message else type(error).__name__
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}:{error.lineno}: {type(error).__name__}: {error.msg}"
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        path = os.path.abspath(frame.filename)
        if not frame.filename.startswith("<") and not path.startswith(_OWN + os.sep):
            return f"{path}:{frame.lineno}: in {frame.name}: {what}"
    return what
