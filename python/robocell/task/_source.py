"""Where in a file an attribute is set."""

from __future__ import annotations

import ast
import inspect
import textwrap
from typing import Any

#: Of the base class of all, which has no file.
_WITHOUT_SOURCE = (OSError, TypeError, SyntaxError)


def place(owner: Any, name: str, policy: Any = None, word: str = "") -> str:
    """``FILE:LINE`` of the first line that sets an attribute of ``owner``. Where only this
    package does, of the first ``word``, the name of a node, in the file of the policy; else of
    the class or function."""
    target = owner if inspect.isfunction(owner) else type(owner)
    classes = target.__mro__ if inspect.isclass(target) else (target,)
    for one in classes:
        found = None if _is_own(one) else _line_in(one, name)
        if found:
            return found
    if policy is not None:
        target = type(policy)
    found = _line_in_file(target, word) if word else None
    return found or _line_in_file(target, name) or _line_of(target)


def _is_own(target: Any) -> bool:
    return str(getattr(target, "__module__", "")).split(".")[0] == "robocell"


def _line_in(target: Any, name: str) -> str | None:
    """Within a class or function."""
    try:
        file, (lines, first) = inspect.getsourcefile(target), inspect.getsourcelines(target)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except _WITHOUT_SOURCE:
        return None
    line = _first(tree, name, with_words=False)
    return None if line is None else f"{file}:{max(first, 1) + line - 1}"


def _line_in_file(target: Any, name: str) -> str | None:
    """Anywhere in its file: a leaf may get an attribute from the policy, and a key of the
    blackboard is a string."""
    try:
        file = inspect.getsourcefile(target)
        with open(file or "", encoding="utf-8") as text:
            line = _first(ast.parse(text.read()), name, with_words=True)
    except (*_WITHOUT_SOURCE, ValueError):
        return None
    return None if line is None else f"{file}:{line}"


def _first(tree: ast.AST, name: str, *, with_words: bool) -> int | None:
    plain = name.lstrip("/")
    lines = [
        node.lineno
        for node in ast.walk(tree)
        if (isinstance(node, ast.Attribute) and node.attr == plain and _is_set(node))
        or (isinstance(node, ast.FunctionDef) and f"{node.name}()" == plain)
        or (with_words and isinstance(node, ast.Constant) and node.value == plain)
    ]
    return min(lines, default=None)


def _is_set(node: ast.Attribute) -> bool:
    return isinstance(node.ctx, ast.Store)


def _line_of(target: Any) -> str:
    try:
        return f"{inspect.getsourcefile(target)}:{inspect.getsourcelines(target)[1]}"
    except _WITHOUT_SOURCE:
        return str(getattr(target, "__module__", "?"))
