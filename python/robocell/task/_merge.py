"""A checkpoint meets a policy that was just constructed, perhaps of an edited file.

Where the constructors of both set the same value, the checkpoint wins; where they differ,
the file does.
"""

from __future__ import annotations

import reprlib
from typing import Any

from robocell.task._graph import CODE_DIGEST, UNKNOWN_DIGEST, digest
from robocell.task._memory import Key, Memory, Part, Saved, reason

#: Values that are equal everywhere: whether two leaves share one does not matter.
_ATOMS = (bool, int, float, complex, str, bytes, type(None))
#: Lines about one restart.
_MOST_LINES = 8
#: A line has 160 bytes.
_SHORT = reprlib.Repr()
_SHORT.maxother = _SHORT.maxstring = 60


class Merge:
    """Restores the attributes of a policy from a checkpoint."""

    def __init__(self, memory: Memory, saved: Saved) -> None:
        self._memory = memory
        self._saved = saved
        #: Attributes from the checkpoint.
        self.kept: list[str] = []
        self._edited: list[str] = []
        #: By its number, a value of the constructor and the one in its place.
        self._replaced: dict[int, tuple[Any, Any]] = {}
        self._new: list[tuple[Part, str]] = []

    def run(self) -> None:
        """Sets the attributes, and returns the new ones."""
        for part in self._memory.parts:
            if not (self._saved.has_own and part.path == ""):
                self._part(part)
        self._share()
        paths = [part.path for part in self._memory.parts]
        gone = sorted(set(self._saved.made) - set(paths))
        self._edited += [f"{path} is not in the edited file" for path in gone]
        self._say()

    def _part(self, part: Part) -> None:
        old = self._saved.made.get(part.path)
        new = self._memory.made[part.path]
        if old is None:
            self._edited.append(f"{part.path} is new in the edited file")
            self._new += [(part, name) for name in new]
            return
        keys = [*self._saved.values, *self._saved.unread]
        names = {name for path, name in keys if path == part.path}
        for name in sorted(names | set(old) | set(new)):
            key = (part.path, name)
            if self._is_edited(part, name, old.get(name), new.get(name)):
                self._edited.append(self._edit(part, name))
                self._new += [(part, name)] if name not in old else []
            elif key in self._saved.values:
                self._set(part, name, self._saved.values[key])
            elif key in self._saved.unread:
                self._warn(part, name, self._saved.unread[key])
            elif self._was_deleted(key, old):
                part.values.pop(name, None)

    def _is_edited(self, part: Part, name: str, old: str | None, new: str | None) -> bool:
        if old == new:
            return False
        if old is None or new is None or name not in part.values:
            return True
        # A constructor that reads a clock, or random numbers, never sets the same value.
        if digest(part.values[name], self._memory.handles) == new:
            return True
        self._memory.keep_made(part.path, name, old)
        return False

    def _was_deleted(self, key: Key, old: dict[str, str]) -> bool:
        is_memory = old.get(key[1]) not in (None, CODE_DIGEST, UNKNOWN_DIGEST)
        return is_memory and key not in self._saved.lost

    def _set(self, part: Part, name: str, value: Any) -> None:
        before = part.values.get(name)
        if not isinstance(before, _ATOMS):
            self._replaced[id(before)] = (before, value)
        part.values[name] = value
        self.kept.append(f"{part.called}{name}")

    def _share(self) -> None:
        """A new leaf has the object that the others and the policy have."""
        for part, name in self._new:
            pair = self._replaced.get(id(part.values.get(name)))
            if pair is not None:
                part.values[name] = pair[1]

    def _warn(self, part: Part, name: str, error: Exception) -> None:
        where = part.place(name)
        called = f"{part.called}{name}"
        self._memory.say("warning", f"{where}: {called} is not restored: {reason(error)}")

    def _edit(self, part: Part, name: str) -> str:
        called = f"{part.called}{name}"
        if name not in part.values:
            return f"{called} is not set by the edited file"
        try:
            shown = _SHORT.repr(part.values[name])
        except Exception:  # A class of the user.
            shown = type(part.values[name]).__name__
        return f"{called} is that of the edited file: {shown} ({part.place(name)})"

    def _say(self) -> None:
        lines = self._edited
        if not lines:
            return
        if len(lines) > _MOST_LINES:
            lines = [*lines[: _MOST_LINES - 1], f"and {len(lines) - _MOST_LINES + 1} more"]
        kept = ", ".join(self.kept) or "nothing"
        for line in [*lines, f"from the checkpoint: {kept}"]:
            self._memory.say("task", line)
