"""Which attributes of an object can be kept in a checkpoint."""

from __future__ import annotations

import io
import pickle
from collections.abc import Mapping, Set
from typing import Any

from robocell.task._cell import Arm, Object, TaskCell

#: Kept without a trial.
_PLAIN = (bool, int, float, str, bytes, type(None))


class Pickler(pickle.Pickler):
    """Leaves the parts of the cell out: the next process has its own."""

    def __init__(self, file: io.BytesIO, cell: TaskCell) -> None:
        super().__init__(file, protocol=5)
        self._cell = cell

    def persistent_id(self, value: Any) -> tuple[str, str | int] | None:
        if isinstance(value, TaskCell):
            return ("cell", "")
        if isinstance(value, Arm):
            return ("arm", self._cell.arms.index(value))
        if isinstance(value, Object):
            return ("object", value.name)
        if value is self._cell.objects:
            return ("objects", "")
        return None


class Unpickler(pickle.Unpickler):
    """The reverse of :class:`Pickler`."""

    def __init__(self, file: io.BytesIO, cell: TaskCell) -> None:
        super().__init__(file)
        self._cell = cell

    def persistent_load(self, pid: Any) -> Any:
        kind, which = pid
        match kind:
            case "cell":
                return self._cell
            case "arm":
                return self._cell.arms[which]
            case "object":
                return self._cell.objects[which]
            case "objects":
                return self._cell.objects
        raise pickle.UnpicklingError(f"'{kind}' is unknown")


def dump(value: Any, cell: TaskCell) -> bytes:
    """A value as bytes.

    Raises:
        pickle.PicklingError, TypeError or AttributeError: for what cannot be pickled.
    """
    file = io.BytesIO()
    Pickler(file, cell).dump(value)
    return file.getvalue()


def load(state: bytes, cell: TaskCell) -> Any:
    """The value of :func:`dump`."""
    return Unpickler(io.BytesIO(state), cell).load()


class Keepable:
    """Finds out once for each attribute whether it can be pickled."""

    def __init__(self, cell: TaskCell) -> None:
        self._cell = cell
        self._known: dict[tuple[Any, str, type], bool] = {}

    def of(self, owner: Any, value: Any, without: Set[str]) -> dict[str, Any]:
        """The attributes of ``value``, known as ``owner``, that can be kept."""
        return self.values(owner, {k: v for k, v in vars(value).items() if k not in without})

    def values(self, owner: Any, values: Mapping[str, Any]) -> dict[str, Any]:
        """Those of ``values`` that can be kept."""
        return {key: value for key, value in values.items() if self._is(owner, key, value)}

    def _is(self, owner: Any, key: str, value: Any) -> bool:
        if isinstance(value, _PLAIN):
            return True
        at = (owner, key, type(value))
        known = self._known.get(at)
        if known is None:
            try:
                dump(value, self._cell)
                known = True
            except (pickle.PicklingError, TypeError, AttributeError):
                known = False
            self._known[at] = known
        return known
