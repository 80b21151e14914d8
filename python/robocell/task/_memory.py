"""The memory of a policy, kept with every decision.

An attribute that cannot be pickled must not cost the rest of the memory, end the process
again and again, or be lost in silence: it is left out, asked again in every decision, and
named with file and line in the first decision where that is so.

The digests of the values that the constructor set are kept, too. After an edit of the file
an attribute with another digest has the new value, not that of the checkpoint.
"""

from __future__ import annotations

import io
import json
import pickle
import zlib
from collections.abc import Iterator, Mapping, MutableMapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeAlias

from robocell.task._cell import TaskCell
from robocell.task._graph import CODE, Handle, Handles, Pickler, digest, load
from robocell.task._source import place

#: Path of a part, name of an attribute.
Key: TypeAlias = tuple[str, str]
#: By path and attribute the digest of the value that the constructor set.
Made: TypeAlias = dict[str, dict[str, str]]

#: The attribute of what a method ``save`` of the user returned.
SAVED = "save()"


@dataclass
class Part:
    """Attributes of one object: the policy, or a node."""

    #: The same after an edit of the file; "" for the policy.
    path: str
    #: In front of an attribute in the log: ``self.``.
    called: str
    #: The attributes themselves, not a copy.
    values: MutableMapping[str, Any]
    #: Whose class, or which function, sets them.
    owner: Any
    #: Attributes that are not memory.
    skip: frozenset[str] = frozenset()
    #: Of a node: the policy, whose file has the name of the node.
    policy: Any = None
    word: str = ""

    def place(self, name: str) -> str:
        """``FILE:LINE`` where an attribute is set."""
        return place(self.owner, name, self.policy, self.word)

    def items(self) -> list[tuple[str, Any]]:
        """Those that are memory."""
        return [(name, value) for name, value in self.values.items() if name not in self.skip]


class Remembers:
    """The memory of a policy with an engine; see :class:`Memory`."""

    #: Methods of a subclass that are called, besides those of every policy.
    _memory_hooks: ClassVar[frozenset[str]] = frozenset()

    def _memory_missing(self) -> str:
        """Methods that a subclass lacks or did not call; "" for a complete policy."""
        return ""

    def _memory_skip(self) -> frozenset[str]:
        """Attributes of the policy that are not memory."""
        return frozenset()

    def _memory_parts(self) -> list[Part]:
        """The attributes of other objects than the policy."""
        return []

    def _memory_handles(self) -> dict[Handle, Any]:
        """Objects that the constructor makes and that values may name."""
        return {}

    def _memory_engine(self) -> Any:
        """The state of the engine; ``None`` without one."""
        return None

    def _memory_restore(self, engine: Any, paths: list[str]) -> None:
        """Takes it back; ``paths`` are those of the parts then."""


@dataclass
class Saved:
    """The content of a checkpoint."""

    made: Made
    #: State of the tree or machine.
    engine: Any
    #: Attributes that could not be kept.
    lost: list[Key]
    #: Whether the policy has saved itself, or tried to: its attributes are not here.
    has_own: bool
    values: dict[Key, Any] = field(default_factory=dict)
    #: Those that were kept and cannot be read.
    unread: dict[Key, Exception] = field(default_factory=dict)


class Memory:
    """The memory of one policy that was just constructed. ``made`` are the digests of the
    first construction in this process."""

    def __init__(
        self, cell: TaskCell, parts: list[Part], more: Mapping[Handle, Any], made: Made | None
    ) -> None:
        self.handles = Handles(cell, more)
        self.parts = parts
        self._code = {
            (part.path, name): value
            for part in parts
            for name, value in part.items()
            if isinstance(value, CODE)
        }
        self.made = self._digests() if made is None else made
        self._refused: set[Key] = set()
        self._said: set[str] = set()
        self._lines: list[tuple[str, str]] = []
        self._header: tuple[list[Key], bytes] = ([], b"")

    def _digests(self) -> Made:
        return {
            part.path: {name: digest(value, self.handles) for name, value in part.items()}
            for part in self.parts
        }

    def keep_made(self, path: str, name: str, value: str) -> None:
        """Takes a digest from a checkpoint: the constructor sets another value each time,
        which is not an edit."""
        self.made = {**self.made, path: {**self.made[path], name: value}}
        self._header = ([], b"")

    def take_lines(self) -> list[tuple[str, str]]:
        """Lines for the log since the last call, with their kinds."""
        lines, self._lines = self._lines, []
        return lines

    def say(self, kind: str, text: str) -> None:
        """Adds a line to the log, unless it was said before."""
        if text not in self._said:
            self._said.add(text)
            self._lines.append((kind, text))

    def save(self, engine: Any, saved: Part | None = None) -> bytes:
        """All of it as bytes, with the state of the tree or machine. ``saved`` is the value
        that the user's own method gave in place of the attributes of the policy."""
        parts = self.parts if saved is None else [saved, *self.parts[1:]]
        self._ask_again(parts)
        while (written := self._write(parts)) is None:
            pass
        keys, ends, body = written
        if keys != self._header[0] or not self._header[1]:
            has_own = saved is not None
            text = json.dumps({"made": self.made, "keys": keys, "has_own": has_own})
            self._header = (keys, zlib.compress(text.encode()))
        return pickle.dumps((self._header[1], engine, sorted(self._refused), ends, body), 5)

    def _ask_again(self, parts: list[Part]) -> None:
        """An attribute that was refused may have another value by now."""
        for key in list(self._refused):
            values = next((part.values for part in parts if part.path == key[0]), {})
            try:
                Pickler(io.BytesIO(), self.handles).dump(values.get(key[1]))
            except Exception:  # As in _write.
                continue
            self._refused.discard(key)

    def _write(self, parts: list[Part]) -> tuple[list[Key], list[int], bytes] | None:
        """The attributes that can be kept. ``None`` when one more was refused: the pickler
        takes a part of it for written, and cannot continue."""
        file = io.BytesIO()
        pickler = Pickler(file, self.handles)
        keys, ends = [], []
        for part in parts:
            for name, value in part.items():
                key = (part.path, name)
                if key in self._refused or self._is_code(key, value):
                    continue
                try:
                    pickler.dump(value)
                except Exception as error:  # Any exception of a class of the user.
                    self._refused.add(key)
                    where = part.place(name)
                    called = f"{part.called}{name}"
                    why = reason(error)
                    self.say("warning", f"{where}: {called} is not kept over a restart: {why}")
                    return None
                keys.append(key)
                ends.append(file.tell())
        return keys, ends, file.getvalue()

    def _is_code(self, key: Key, value: Any) -> bool:
        """Whether the next constructor sets it again: then there is nothing to keep."""
        return isinstance(value, CODE) and self._code.get(key) is value

    def read(self, state: bytes) -> Saved:
        """The value that :meth:`save` has written."""
        header, engine, lost, ends, body = pickle.loads(state)
        head = json.loads(zlib.decompress(header))
        saved = Saved(head["made"], engine, [(path, name) for path, name in lost], head["has_own"])
        values = load(body, ends, self.handles)
        for (path, name), value in zip(head["keys"], values, strict=True):
            if isinstance(value, Exception):
                saved.unread[path, name] = value
            else:
                saved.values[path, name] = value
        return saved


def reason(error: Exception) -> str:
    """An exception in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def attributes(value: Any) -> MutableMapping[str, Any]:
    """The attributes of an object, to be read and set."""
    if any(one.__dict__.get("__slots__") for one in type(value).__mro__):
        return _Slots(value)
    found: dict[str, Any] = vars(value)
    return found


class _Slots(MutableMapping[str, Any]):
    """Attributes of an object of a class with slots."""

    def __init__(self, owner: Any) -> None:
        self._owner = owner
        names = [one.__dict__.get("__slots__", ()) for one in type(owner).__mro__]
        slots = [name for own in names for name in ([own] if isinstance(own, str) else own)]
        self._slots = [name for name in slots if not name.startswith("__")]

    def __getitem__(self, name: str) -> Any:
        return getattr(self._owner, name)

    def __setitem__(self, name: str, value: Any) -> None:
        object.__setattr__(self._owner, name, value)

    def __delitem__(self, name: str) -> None:
        object.__delattr__(self._owner, name)

    def __iter__(self) -> Iterator[str]:
        names = [*getattr(self._owner, "__dict__", ()), *self._slots]
        return iter([name for name in names if hasattr(self._owner, name)])

    def __len__(self) -> int:
        return len(list(iter(self)))
