"""Quaternions."""

from __future__ import annotations

import numpy as np
import pytest

from robocell import rotation

pytestmark = pytest.mark.sample


def some(seed: int) -> np.ndarray:
    q = np.random.default_rng(seed).normal(size=4)
    return q / np.linalg.norm(q)


@pytest.mark.parametrize("seed", range(20))
def test_products_and_inverses_are_those_of_matrices(seed: int):
    a, b = some(seed), some(seed + 100)
    both = rotation.matrix(a) @ rotation.matrix(b)
    np.testing.assert_allclose(rotation.matrix(rotation.product(a, b)), both, atol=1e-12)
    np.testing.assert_allclose(rotation.matrix(rotation.inverse(a)), rotation.matrix(a).T)
    assert rotation.angle_between(rotation.of_matrix(rotation.matrix(a)), a) < 1e-6


def test_a_quarter_turn_about_z_takes_x_to_y():
    turn = rotation.about((0, 0, 2), np.pi / 2)
    np.testing.assert_allclose(rotation.rotate(turn, (1, 0, 0)), (0, 1, 0), atol=1e-12)
    np.testing.assert_allclose(rotation.by_vector((0, 0, np.pi / 2)), turn)
    assert rotation.by_vector((0, 0, 0)).tolist() == [1, 0, 0, 0]
    assert rotation.angle_between(turn, (1, 0, 0, 0)) == pytest.approx(np.pi / 2)
