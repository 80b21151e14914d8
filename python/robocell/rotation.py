"""Rotations as unit quaternions ``w x y z``, the form of all poses of a cell."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Vector = npt.NDArray[np.float64]
Numbers = Any


def about(axis: Numbers, angle: float) -> Vector:
    """The rotation by ``angle`` (rad) about an axis of any length but zero."""
    unit = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    return np.concatenate([[np.cos(0.5 * angle)], np.sin(0.5 * angle) * unit])


def by_vector(vector: Numbers) -> Vector:
    """The rotation about a vector, by its length (rad)."""
    angle = float(np.linalg.norm(vector))
    return about(vector, angle) if angle > 1e-12 else np.array([1.0, 0.0, 0.0, 0.0])


def product(first: Numbers, second: Numbers) -> Vector:
    """The rotation that does ``second``, then ``first``."""
    a, b, c, d = first
    w, x, y, z = second
    result = np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )
    return np.asarray(result / np.linalg.norm(result))


def inverse(rotation: Numbers) -> Vector:
    """The rotation back."""
    return np.asarray(rotation, dtype=np.float64) * (1.0, -1.0, -1.0, -1.0)


def matrix(rotation: Numbers) -> Vector:
    """The matrix whose columns are the turned axes."""
    w, x, y, z = rotation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotate(rotation: Numbers, vector: Numbers) -> Vector:
    """A vector, turned."""
    return np.asarray(matrix(rotation) @ np.asarray(vector, dtype=np.float64))


def angle_between(first: Numbers, second: Numbers) -> float:
    """The angle from one orientation to another (rad)."""
    w = abs(float(np.dot(first, second)))
    return 2.0 * float(np.arccos(min(1.0, w)))


def of_matrix(turned: Numbers) -> Vector:
    """The rotation whose matrix this is."""
    m = np.asarray(turned, dtype=np.float64)
    # The largest component of the quaternion gives the others.
    squares = 1.0 + np.array(
        [
            m[0, 0] + m[1, 1] + m[2, 2],
            m[0, 0] - m[1, 1] - m[2, 2],
            m[1, 1] - m[0, 0] - m[2, 2],
            m[2, 2] - m[0, 0] - m[1, 1],
        ]
    )
    a, b, c = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    d, e, f = m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
    rows = np.array(
        [
            [squares[0], a, b, c],
            [a, squares[1], d, e],
            [b, d, squares[2], f],
            [c, e, f, squares[3]],
        ]
    )
    row = rows[int(np.argmax(squares))]
    return np.asarray(row / np.linalg.norm(row))
