"""Refusals of mistakes, each with the line of the user's file."""

from __future__ import annotations

import ast
import difflib
import inspect
import textwrap
from collections.abc import Callable, Iterable, Iterator
from typing import Any

_WITHOUT_SOURCE = (OSError, TypeError, SyntaxError)

_KINDS = (
    (inspect.isasyncgenfunction, "an async generator"),
    (inspect.iscoroutinefunction, "an async function"),
    (inspect.isgeneratorfunction, "a generator function"),
)


class Refused(ValueError):
    """Something that a user wrote and that cannot work. The message has ``FILE:LINE``."""

    def __init__(self, where: str, problem: str) -> None:
        super().__init__(f"{where}: {problem}" if where else problem)
        self.where = where


def line_of(target: Any) -> str:
    """``FILE:LINE`` of the definition of a class or function, after its decorators; "" for
    what has no file."""
    target = inspect.unwrap(target)
    target = getattr(target, "func", target)
    if not (inspect.isroutine(target) or inspect.isclass(target)):
        target = type(target)
    try:
        file, (lines, first) = inspect.getsourcefile(target), inspect.getsourcelines(target)
    except _WITHOUT_SOURCE:
        code = getattr(target, "__code__", None)
        return f"{code.co_filename}:{code.co_firstlineno}" if code else ""
    defined = ("def ", "async def ", "class ")
    after = (n for n, line in enumerate(lines) if line.lstrip().startswith(defined))
    return f"{file}:{max(first, 1) + next(after, 0)}"


def constant_line(cls: type, name: str, index: int | None = None) -> str:
    """``FILE:LINE`` where the body of a class, or of one of its bases, sets ``name``; with an
    index of that element of it. Else of the class."""
    for one in cls.__mro__:
        if name not in vars(one):
            continue
        try:
            file, (lines, first) = inspect.getsourcefile(one), inspect.getsourcelines(one)
            body = ast.parse(textwrap.dedent("".join(lines))).body[0]
        except _WITHOUT_SOURCE:
            break
        value = _assigned(body, name)
        if value is None:
            break
        elements = getattr(value, "elts", ())
        if index is not None and index < len(elements):
            value = elements[index]
        return f"{file}:{max(first, 1) + value.lineno - 1}"
    return line_of(cls)


def _assigned(body: ast.AST, name: str) -> ast.expr | None:
    """The value of the last assignment to a name in the body of a class."""
    found = None
    for node in getattr(body, "body", ()):
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        if any(isinstance(target, ast.Name) and target.id == name for target in targets):
            found = getattr(node, "value", None)
    return found


def takes(target: Callable[..., Any], count: int) -> bool:
    """Whether a callable takes ``count`` arguments by position."""
    try:
        inspect.signature(target).bind(*([None] * count))
    except TypeError:
        return False
    except ValueError:
        return True
    return True


def check_kind(function: Any, called: str) -> None:
    """Refuses a function that does not run when it is called."""
    # Of an object that can be called, its method.
    for one in (function, vars(type(function)).get("__call__")):
        for is_kind, kind in _KINDS:
            if is_kind(one):
                keep = (
                    "; keep a generator in an attribute and call next() of it in decide"
                    if kind == "a generator function"
                    else ""
                )
                raise Refused(
                    line_of(one), f"{called} is {kind}: a call of it does not run it{keep}"
                )


def check_call(function: Any, count: int, called: str, usage: str) -> None:
    """Refuses all but a function of ``count`` arguments that runs when it is called."""
    if not callable(function):
        raise Refused("", f"{called} is {function!r}; a function is needed: {usage}")
    check_kind(function, called)
    if not takes(function, count):
        raise Refused(
            line_of(function),
            f"{called}{inspect.signature(function)} has other arguments than {usage}",
        )


def check_result(result: Any, function: Any, called: str) -> None:
    """Refuses a result that has to be run first, as of a function that hides its kind."""
    if not (
        inspect.isawaitable(result) or inspect.isgenerator(result) or inspect.isasyncgen(result)
    ):
        return
    if inspect.iscoroutine(result):
        result.close()
    kind = type(result).__name__
    raise Refused(line_of(function), f"{called} returned a {kind}, of which nothing was run")


def returns_nothing(function: Any) -> bool:
    """Whether a function has a body that never returns a value. False where that is not
    known."""
    if hasattr(function, "__wrapped__") or not inspect.isroutine(function):
        return False
    try:
        body = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (*_WITHOUT_SOURCE, IndexError):
        return False
    if not isinstance(body, ast.FunctionDef):
        return False
    return not any(isinstance(node, ast.Raise) or _has_value(node) for node in _own_nodes(body))


def _has_value(node: ast.AST) -> bool:
    if not isinstance(node, ast.Return) or node.value is None:
        return False
    return not (isinstance(node.value, ast.Constant) and node.value.value is None)


def _own_nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Those of a function, without functions and classes in it."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)):
            continue
        yield child
        yield from _own_nodes(child)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """``; did you mean 'b'?`` with the nearest of the known words, or nothing."""
    near = difflib.get_close_matches(word, list(known), 1)
    return f"; did you mean '{near[0]}'?" if near else ""
