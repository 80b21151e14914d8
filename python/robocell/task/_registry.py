"""The policies that a file declares."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, overload

Declared = TypeVar("Declared", bound=Callable[..., Any])

#: Size of the name of a policy in a decision, in bytes.
_NAME_BYTES = 16

declared: list[tuple[str | None, Callable[..., Any]]] = []


@overload
def policy(target: Declared) -> Declared: ...


@overload
def policy(target: str) -> Callable[[Declared], Declared]: ...


def policy(target: Any) -> Any:
    """Declares a class or a function as a policy of this file.

    Without a name the policy is called like the file. With one, ``@policy("name")``,
    ``--policy name`` chooses it; a file may declare several. A name has at most 16
    bytes.

    A class is made with ``TaskCell``, or without an argument, and has
    ``decide(self, cell)``. It may have ``reconcile(self, cell)``, called after
    decisions were missed, ``save(self)`` and ``restore(self, state)`` for its
    memory, ``phases`` (names, drawn on the page) and ``phase`` (the current one).
    Without ``save`` its attributes are its memory, if they can be pickled.

    A function is called as ``f(cell)`` or ``f(cell, memory)``; ``memory`` is a
    namespace that is kept from one decision to the next, and over a restart.
    """
    if isinstance(target, str):
        return _named(target)
    if not callable(target):
        raise ValueError(f"a policy is a class or a function, not {target!r}")
    declared.append((None, target))
    return target


def _named(name: str) -> Callable[[Declared], Declared]:
    if not name or len(name.encode()) > _NAME_BYTES:
        raise ValueError(f"the name of a policy has 1 to {_NAME_BYTES} bytes, '{name}' has not")

    def declare(target: Declared) -> Declared:
        declared.append((name, target))
        return target

    return declare
