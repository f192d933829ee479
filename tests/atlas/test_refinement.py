import itertools

import numpy as np
import pytest
from scipy.stats import linregress

from gelcone.atlas.refinement import (
    CHECKED_SHARE,
    MOST_CHECKED,
    _drawn,
    _nearest,
    _points_of,
    border_dimension,
    refine,
)
from gelcone.errors import InputError


def follow(kinds, coarsest):
    """What `refine` asks for of a grid of known kinds: how often each cell, and what it comes to."""
    wanted, asked = refine(kinds.shape, coarsest), np.zeros(kinds.size, dtype=int)
    cells = next(wanted)
    while True:
        assert (np.diff(cells) > 0).all()
        asked[cells] += 1
        try:
            cells = wanted.send(kinds.flat[cells])
        except StopIteration as ended:
            return asked, ended.value


def disc(n):
    y, x = np.mgrid[0 : 1 : n * 1j, 0 : 1 : n * 1j]
    return (np.hypot(x - 0.5, y - 0.4) < 0.3).astype(int) + 2 * (y > 0.8 + 0.05 * np.sin(9 * x))


GRIDS = {
    "disc and wave": disc(100),
    "line": (np.linspace(0, 1, 1001) > 0.3123).astype(int),
    "solid": (np.add.outer(np.linspace(0, 1, 33), np.multiply.outer(np.linspace(0, 1, 20), [0.1, 0.6, 1])) > 0.9) * 1,
    "all of a kind": np.zeros((65, 30), dtype=int),
    "noise": np.random.default_rng(1).integers(0, 2, (40, 50)),
    "as coarse as can be": np.array([[0, 1], [1, 1]]),
}


@pytest.mark.parametrize("name", GRIDS)
@pytest.mark.parametrize("coarsest", [2, 9, 16])
def test_each_cell_is_asked_for_once_or_has_a_computed_source(name, coarsest):
    kinds = GRIDS[name]
    asked, refined = follow(kinds, coarsest)
    sources = refined.sources
    assert set(np.unique(asked)) <= {0, 1}
    np.testing.assert_array_equal(sources == np.arange(kinds.size), asked == 1)
    assert (asked[sources] == 1).all()


@pytest.mark.parametrize("name", ["disc and wave", "line", "solid"])
def test_kinds_are_those_of_the_whole_grid(name):
    kinds = GRIDS[name]
    sources = follow(kinds, 16)[1].sources
    np.testing.assert_array_equal(kinds.flat[sources], kinds.ravel())


def test_work_grows_like_the_length_of_smooth_borders():
    """Four times the cells, twice the border."""
    work = [follow(disc(n), 16)[0].sum() for n in (128, 256, 512)]
    for less, more in itertools.pairwise(work):
        assert 1.7 < more / less < 2.3
    assert work[-1] < 0.05 * 512**2


def test_uncomputed_cells_have_no_neighbour_of_another_kind():
    kinds = GRIDS["noise"].repeat(6, axis=0).repeat(6, axis=1)
    asked, refined = follow(kinds, 16)
    found = kinds.flat[refined.sources].reshape(kinds.shape)
    for axis in (0, 1):
        change = np.flatnonzero(np.diff(found, axis=axis))
        for side in (np.take(asked.reshape(kinds.shape), range(k, k + found.shape[axis] - 1), axis) for k in (0, 1)):
            assert (side.flat[change] == 1).all()


@pytest.mark.parametrize("last", [16, 17, 19, 22, 23])
def test_an_inferred_cell_takes_the_nearest_of_the_lattice(last):
    """Of two as near the lower one; the last block may be shorter than the others."""
    coarse, fine = np.array([0, 8, last]), np.arange(0, last + 1)
    expected = coarse[np.abs(fine[:, None] - coarse).argmin(axis=1)]
    np.testing.assert_array_equal(_nearest(coarse, fine), expected)


def test_the_check_finds_out_how_much_is_missed():
    """Dust that the lattices do not see: what is missed among the cells drawn is what is missed among all inferred."""
    kinds = (np.random.default_rng(4).random((401, 401)) < 0.02).astype(int)
    kinds[::8, ::8] = 0
    _, refined = follow(kinds, 32)
    inferred = refined.sources != np.arange(kinds.size)
    wrong = (kinds.flat[refined.sources] != kinds.ravel())[inferred].mean()
    assert refined.checked == MOST_CHECKED
    assert wrong > 0.01
    assert refined.missed / refined.checked == pytest.approx(wrong, abs=3 * np.sqrt(wrong / refined.checked))


def test_what_the_check_finds_is_followed():
    """A bar that lies between the points of the coarsest lattice, and of which a cell is sure to be drawn."""
    kinds = np.zeros((65, 400), dtype=int)
    kinds[2:4, 3:397] = 1
    _, refined = follow(kinds, 9)
    assert refined.missed > 0
    assert refined.checked <= CHECKED_SHARE * kinds.size
    np.testing.assert_array_equal(kinds.flat[refined.sources], kinds.ravel())


def test_a_grid_of_smooth_borders_passes_its_check():
    _, refined = follow(disc(200), 16)
    assert (refined.checked, refined.missed) == (MOST_CHECKED, 0)


def test_a_lattice_of_one_point_is_refused():
    with pytest.raises(InputError, match="coarsest = 1: must be at least 2"):
        next(refine((10, 10), 1))


def carpet(levels):
    """Sierpinski's carpet: the middle of each of three by three squares is another kind."""
    kinds = np.zeros((1, 1), dtype=int)
    for _ in range(levels):
        row = np.concatenate([kinds, kinds, kinds], axis=1)
        kinds = np.concatenate([row, np.concatenate([kinds, np.ones_like(kinds), kinds], axis=1), row])
    return kinds


@pytest.mark.parametrize(
    ("kinds", "expected", "within"),
    [
        (disc(512), 1.0, 0.05),
        (np.random.default_rng(3).integers(0, 50, (256, 300)), 2.0, 0.02),
        (carpet(6), np.log(8) / np.log(3), 0.08),
        (np.random.default_rng(3).integers(0, 50, 4096), 1.0, 0.02),
    ],
    ids=["smooth", "noise", "carpet", "noise on a line"],
)
def test_borders_have_the_dimension_of_their_boxes(kinds, expected, within):
    dimension, error = border_dimension(kinds)
    assert dimension == pytest.approx(expected, abs=within)
    assert error < within


def test_the_dimension_and_its_error_are_those_of_the_line_through_counted_boxes():
    kinds, counts = carpet(5)[:129, :129] + np.eye(129, dtype=int), []
    for side in (1, 2, 4, 8, 16):
        corners = itertools.product(range(0, 128, side), repeat=2)
        counts.append(sum(np.ptp(kinds[i : i + side + 1, j : j + side + 1]) > 0 for i, j in corners))
    line = linregress(-np.arange(5), np.log2(counts))
    assert border_dimension(kinds) == pytest.approx((line.slope, line.stderr), rel=1e-12)
    assert line.stderr > 0.01


def test_borders_without_boxes_of_three_sizes_have_no_dimension():
    assert border_dimension(np.zeros((200, 200), dtype=int)) is None
    assert border_dimension(np.random.default_rng(1).integers(0, 2, (20, 200))) is None


@pytest.mark.parametrize("shape", [(37, 50), (65, 9), (8, 130), (2, 3)])
@pytest.mark.parametrize("coarsest", [2, 9, 16])
def test_the_first_lattice_has_at_least_the_points_that_are_asked_for_along_each_axis(shape, coarsest):
    """Where the grid has as many; of these the coarsest that halves down to the grid."""
    first = np.stack(np.unravel_index(next(refine(shape, coarsest)), shape))
    for own, n in zip(first, shape, strict=True):
        points = np.unique(own)
        least = min(coarsest, n)
        assert (points[0], points[-1]) == (0, n - 1)
        assert least <= points.size
        steps = np.unique(np.diff(points[:-1]))
        assert all(np.log2(step) % 1.0 == 0.0 for step in steps)
        assert (n - 1) / (2 * max(steps, default=n)) < least - 1 or n <= 3


@pytest.mark.parametrize(("inferred", "checked"), [(19, 0), (40, 2), (1000, 50), (20_000, 512)])
def test_a_twentieth_of_the_inferred_cells_is_checked_and_no_more_than_512(inferred, checked):
    cells = np.arange(inferred + 100) >= 100
    drawn = _drawn(cells)
    assert drawn.sum() == checked
    assert not (drawn & ~cells).any()


def test_points_on_a_border_of_a_block_belong_to_it():
    """Of every block between coarse points, all its points are taken, on each of its sides and corners."""
    coarse, fine = [np.array([0, 4, 8, 11]), np.array([0, 4, 6])], [np.array([0, 2, 4, 6, 8, 10, 11]), np.arange(7)]
    for block in np.ndindex(3, 2):
        blocks = np.zeros((3, 2), dtype=bool)
        blocks[block] = True
        within = [(f >= c[k]) & (f <= c[k + 1]) for c, f, k in zip(coarse, fine, block, strict=True)]
        np.testing.assert_array_equal(_points_of(blocks, coarse, fine), np.outer(*within))
