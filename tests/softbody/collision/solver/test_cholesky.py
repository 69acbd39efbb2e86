"""Do the factors solve the equations?"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from softbody.collision.solver.cholesky import factor, solve_lower, solve_upper


@given(st.integers(0, 10**6))
def test_the_factors_solve_symmetric_equations(seed):
    random = np.random.default_rng(seed)
    root = random.normal(size=(6, 6))
    matrix, right = root @ root.T + np.eye(6), random.normal(size=6)
    block, x = np.tril(matrix), right.copy()
    factor(block)
    solve_lower(block, x)
    solve_upper(block, x)
    assert matrix @ x == pytest.approx(right, abs=1e-10)


def test_each_half_is_solved_by_itself():
    block = np.diag(np.arange(1.0, 7.0) ** 2)
    block[1, 0] = 3.0
    block[1, 1] += 9.0  # L = diag(1 … 6), and 3 below the first
    factor(block)
    x = np.array([1.0, 5.0, 3.0, 4.0, 5.0, 6.0])
    solve_lower(block, x)
    assert x == pytest.approx([1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    solve_upper(block, x)
    assert x == pytest.approx([-0.5, 0.5, 1 / 3, 1 / 4, 1 / 5, 1 / 6])
