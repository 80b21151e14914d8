"""Objects as bytes, and back: the content of the checkpoint of a policy.

Values go through one pickler, one after the other, so that an object they share is still one
object. The bytes of equal memories have to be equal: ``replay --verify`` compares them.
"""

from __future__ import annotations

import functools
import hashlib
import io
import pickle
import pickletools
import types
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from robocell.task._cell import Arm, Object, TaskCell

#: Names an object that is not written: its kind, then its own name.
Handle: TypeAlias = tuple[Any, ...]

#: Functions and the like: only an edit of the file changes them.
CODE = (
    types.FunctionType,
    types.MethodType,
    types.BuiltinFunctionType,
    types.ModuleType,
    functools.partial,
    type,
)
#: The digest of such a value, and of one that cannot be pickled.
CODE_DIGEST, UNKNOWN_DIGEST = "code", "?"
#: An edit is overlooked once in 2^64.
_DIGEST_BYTES = 8


_OF_CELL = frozenset({Arm, Object, TaskCell})


class Handles:
    """Objects that every process has of its own: parts of the cell, the policy, nodes. The
    bytes have their names only."""

    def __init__(self, cell: TaskCell, more: Mapping[Handle, Any]) -> None:
        self._cell = cell
        self._by_name: dict[Handle, Any] = {("cell",): cell, ("objects",): cell.objects}
        self._by_name.update({("arm", index): arm for index, arm in enumerate(cell.arms)})
        self._by_name.update({("object", name): one for name, one in cell.objects.items()})
        self._by_name.update(more)
        #: The memory that the arrays of the cell show.
        self._state = cell._core.state
        # The objects are held above, so that no other gets one of these numbers.
        self._by_id = {id(value): name for name, value in self._by_name.items()}

    def name(self, value: Any) -> Handle | None:
        """The name of a handle; none for any other object."""
        name = self._by_id.get(id(value))
        if type(value) is np.ndarray:
            return self._view(value)
        if name is not None or type(value) not in _OF_CELL:
            return name
        # A copy.
        if isinstance(value, Arm):
            return ("arm", [arm.name for arm in self._cell.arms].index(value.name))
        return ("object", value.name) if isinstance(value, Object) else ("cell",)

    def _view(self, array: npt.NDArray[Any]) -> Handle | None:
        """An array that shows the newest decision, which a copy would not."""
        base: Any = array
        while isinstance(base, (np.ndarray, np.void)) and base.base is not None:
            base = base.base
        if base is not self._state:
            return None
        begin = array.ctypes.data - self._state.ctypes.data
        return ("view", begin, array.dtype, array.shape, array.strides)

    def find(self, name: Handle) -> Any:
        """The handle of that name."""
        if name[0] == "view":
            _, begin, dtype, shape, strides = name
            return np.ndarray(shape, dtype, self._state, begin, strides)
        try:
            return self._by_name[name]
        except KeyError:
            missing = " ".join(str(word) for word in name)
            raise pickle.UnpicklingError(f"{missing} does not exist any more") from None


class Pickler(pickle.Pickler):
    """Writes values, and handles by name."""

    def __init__(self, file: io.BytesIO, handles: Handles) -> None:
        super().__init__(file, protocol=5)
        self._handles = handles

    def persistent_id(self, value: Any) -> Any:
        return self._handles.name(value)


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, handles: Handles) -> None:
        super().__init__(file)
        self._handles = handles

    def persistent_load(self, pid: Any) -> Any:
        return self._handles.find(pid)


class _Digester(Pickler):
    """Sets have another order in each process."""

    def persistent_id(self, value: Any) -> Any:
        if type(value) in (set, frozenset):
            return ("set", sorted(_digested(one, self._handles) for one in value))
        return super().persistent_id(value)


def _digested(value: Any, handles: Handles) -> bytes:
    file = io.BytesIO()
    _Digester(file, handles).dump(value)
    return file.getvalue()


def digest(value: Any, handles: Handles) -> str:
    """Equal for equal values, in every process."""
    if isinstance(value, CODE):
        return CODE_DIGEST
    try:
        written = _digested(value, handles)
    except Exception:  # Any exception of a class of the user when it is pickled.
        return UNKNOWN_DIGEST
    return hashlib.blake2b(written, digest_size=_DIGEST_BYTES).hexdigest()


def load(body: bytes, ends: Sequence[int], handles: Handles) -> list[Any]:
    """The values of one :class:`Pickler`, of which each has an end in ``body``; in place of
    one that cannot be read the exception."""
    unpickler = _Unpickler(io.BytesIO(body), handles)
    try:
        return [unpickler.load() for _ in ends]
    except Exception:  # Told by the slow way, which continues.
        return _load_what_can(body, ends, handles)


class _Missing:
    """An object of a value that could not be read."""


class _Memo(dict[int, Any]):
    """Objects by their number; those of such a value are refused to the others."""

    def __getitem__(self, number: int) -> Any:
        value = super().__getitem__(number)
        if isinstance(value, _Missing):
            raise KeyError(number)
        return value


def _load_what_can(body: bytes, ends: Sequence[int], handles: Handles) -> list[Any]:
    file = io.BytesIO(body)
    # Only the one in Python shows its memo.
    unpickler: Any = vars(pickle)["_Unpickler"](file)
    unpickler.persistent_load = handles.find
    unpickler.memo = memo = _Memo()
    values: list[Any] = []
    begin, count = 0, 0
    for end in ends:
        file.seek(begin)
        opcodes = pickletools.genops(body[begin:end])
        count += sum(opcode.name == "MEMOIZE" for opcode, _, _ in opcodes)
        try:
            values.append(unpickler.load())
        except Exception as error:  # Any exception of a class of the user.
            values.append(error)
        # The pickler has counted the objects that are missing.
        while len(memo) < count:
            memo[len(memo)] = _Missing()
        begin = end
    return values
