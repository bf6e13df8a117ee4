"""Equations of poses that meet few others, against the dense system."""

import numpy as np
import pytest

from motorcade.tracking.optimise import PairIndex, PassingEquations

STAYING, FRAMES, WIDTH = 4, 6, 6


def equations(rng: np.random.Generator, joined: bool, many: int = 1) -> PassingEquations:
    """Poses that each meet three of four that stay, so many a frame; if joined, they also meet."""
    passing = np.arange(STAYING + FRAMES) >= STAYING
    pairs = [(frame, (frame + k) % STAYING) for frame in np.flatnonzero(passing) for k in range(3)]
    if joined:
        pairs += [(frame, frame + 1) for frame in np.flatnonzero(passing)[:-1]]
    pairs += [(one, one) for one in range(STAYING)]
    rows, columns, blocks = [], [], []
    gradient = np.zeros((len(passing), WIDTH))
    for one in pairs:
        jacobian = rng.normal(size=(2, 8, WIDTH)) * (1.0 if one[0] != one[1] else 0.5)
        residual = rng.normal(size=8)
        for a in range(2):
            gradient[one[a]] += jacobian[a].T @ residual
            for b in range(2):
                rows.append(one[a])
                columns.append(one[b])
                blocks.append(jacobian[a].T @ jacobian[b])
    index = PairIndex(np.array(rows), np.array(columns))
    sums = index.sums(np.array(blocks))
    frame = np.where(passing, np.arange(len(passing)) - STAYING, -1) // many
    return PassingEquations(index.rows, index.columns, sums, gradient, frame)


def test_a_covariance_is_that_of_a_frame_alone(rng: np.random.Generator) -> None:
    some = equations(rng, joined=True, many=FRAMES)
    doubt = np.full(WIDTH, 10.0)
    passing = np.flatnonzero(some.frame >= 0)
    dense = np.zeros((len(some.frame), WIDTH, len(some.frame), WIDTH))
    dense[some.rows, :, some.columns] = some.blocks
    own = dense[np.ix_(passing, range(WIDTH), passing, range(WIDTH))]
    own = own.reshape(FRAMES * WIDTH, -1) + 0.01 * np.eye(FRAMES * WIDTH)
    expected = np.linalg.inv(own).reshape(FRAMES, WIDTH, FRAMES, WIDTH)
    found = some.covariance(doubt)
    for k, row in enumerate(passing):
        np.testing.assert_allclose(found[row], expected[k, :, k], rtol=1e-6, atol=1e-9)
    stays = np.linalg.inv(dense[0, :, 0] + 0.01 * np.eye(WIDTH))
    np.testing.assert_allclose(found[0], stays, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize(("joined", "many"), [(False, 1), (True, 1), (False, 3), (True, FRAMES)])
@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_a_step_is_that_of_the_dense_system(
    rng: np.random.Generator, joined: bool, many: int, damping: float
) -> None:
    some = equations(rng, joined, many)
    count = len(some.gradient)
    dense = np.zeros((count, WIDTH, count, WIDTH))
    dense[some.rows, :, some.columns] = some.blocks
    dense = dense.reshape(count * WIDTH, -1)
    dense += damping * np.diag(np.diag(dense))
    expected = np.linalg.solve(dense, -some.gradient.ravel()).reshape(-1, WIDTH)
    np.testing.assert_allclose(some.step(damping), expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("joined", [False, True])
def test_what_has_no_solution_is_singular(rng: np.random.Generator, joined: bool) -> None:
    some = equations(rng, joined)
    some.gradient[0] = np.nan
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        some.step(0.0)


def test_sums_are_those_of_a_loop(rng: np.random.Generator) -> None:
    rows, columns = rng.integers(0, 5, (2, 100))
    values = rng.normal(size=(100, 2))
    index = PairIndex(rows, columns)
    assert len({*zip(index.rows.tolist(), index.columns.tolist(), strict=True)}) == len(index.rows)
    for row, column, found in zip(index.rows, index.columns, index.sums(values), strict=True):
        mine = (rows == row) & (columns == column)
        np.testing.assert_allclose(found, values[mine].sum(axis=0))
    assert index.sums(values).sum() == pytest.approx(values.sum())
    nothing = np.zeros(0, np.int64)
    assert PairIndex(nothing, nothing).sums(np.zeros((0, 3))).shape == (0, 3)
