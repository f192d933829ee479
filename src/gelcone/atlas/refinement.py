"""Refinement of a grid from a coarse lattice: cells near a change of kind are computed, the others inferred.

A lattice holds every s-th value of each axis, and the last; s halves from level to level down to 1. The points of a
lattice are the corners of blocks. A block whose corners are of different kinds is computed, on its own lattice and on
the next; elsewhere the kind of the corners is taken over. Each level is repeated until no inferred point of such a
block is left, so that a border is followed to its end. At the end every cell next to one of another kind is computed.
The cells that are computed depend on the kinds alone, not on the order of the work.

An island between the points of the coarsest lattice is missed: that lattice determines the smallest feature that is
found. A check estimates how much is missed: some of the inferred cells, drawn at random, are computed, too, and borders
that they reveal are followed.

The number of cells at the borders grows as a power of the grid's fineness. The power is the dimension of the borders
(`border_dimension`), 1 for smooth ones in the plane. It is near 2 where chaos and periodic windows are interleaved, so
that few cells can be inferred at any fineness.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gelcone.errors import InputError

Cells = npt.NDArray[np.intp]
Kinds = npt.NDArray[np.int64]
UNKNOWN = -(2**31)
"""Marks a cell whose kind is unknown."""
MOST_CHECKED, CHECKED_SHARE = 512, 0.05
"""Largest number and largest share of the inferred cells that are computed as a check."""
FEWEST_BOXES = 8
"""Boxes along the shorter axis, of the largest that are counted for the dimension of borders."""


@dataclass(frozen=True)
class Refined:
    """The result of a refinement: ``sources``, the index of the cell whose values each cell takes, its own where it was
    computed; and the number of inferred cells whose kind was ``checked``, and of those among them with another kind,
    ``missed``."""

    sources: Cells
    checked: int = 0
    missed: int = 0


def refine(shape: tuple[int, ...], coarsest: int) -> Generator[Cells, Kinds, Refined]:
    """Requests cells level by level, and returns the cell from which each cell takes its values.

    Yields flattened indices of cells to compute, increasing, none twice; is sent their kinds, any integers.

    Parameters
    ----------
    shape : of the grid, at least 2 along each axis.
    coarsest : least number of points along an axis of the coarsest lattice (where the grid has as many).

    Raises
    ------
    InputError : for fewer than 2 points.
    """
    if coarsest < 2:
        raise InputError(f"coarsest = {coarsest}: must be at least 2 points along each axis")
    strides = [2 ** math.floor(math.log2((n - 1) / (min(coarsest, n) - 1))) for n in shape]
    kinds = np.full(shape, UNKNOWN, dtype=np.int64)
    sources = np.full(shape, -1, dtype=np.intp)
    axes = _lattice(shape, strides)
    yield from _compute(axes, np.ones([len(axis) for axis in axes], dtype=bool), kinds, sources)
    while max(strides) > 1:
        while (points := _points_of(_mixed_blocks(kinds[np.ix_(*axes)]), axes, axes))[_inferred(axes, sources)].any():
            yield from _compute(axes, points, kinds, sources)
        mixed = _mixed_blocks(kinds[np.ix_(*axes)])
        strides = [max(1, stride // 2) for stride in strides]
        coarse, axes = axes, _lattice(shape, strides)
        _infer(coarse, axes, kinds, sources)
        yield from _compute(axes, _points_of(mixed, coarse, axes), kinds, sources)
    yield from _follow_borders(axes, kinds, sources)
    drawn = _drawn(_inferred(axes, sources))
    inferred = kinds[drawn]
    yield from _compute(axes, drawn, kinds, sources)
    missed = int((kinds[drawn] != inferred).sum())
    yield from _follow_borders(axes, kinds, sources)
    return Refined(sources.ravel(), int(drawn.sum()), missed)


def border_dimension(kinds: Kinds) -> tuple[float, float] | None:
    """Box-counting dimension of the borders between kinds, and the standard error of its fit.

    The number of boxes that hold cells of several kinds grows with this power as the boxes are halved, from about
    `FEWEST_BOXES` along the shorter axis down to two cells a side (Falconer, Fractal Geometry (2014), chapter 2). None
    where there are fewer than three sizes of boxes, or no borders in one of them.
    """
    low, high = _blocks(kinds, kinds)
    counts: list[float] = []
    smallest = np.prod(low.shape)
    while min(low.shape) >= FEWEST_BOXES:
        # The share of mixed boxes times the number of boxes that fit, fractions included.
        counts.append((low != high).mean() * smallest / 2.0 ** (len(counts) * kinds.ndim))
        low, high = _blocks(low, high, apart=2)
    if len(counts) < 3 or min(counts) == 0:
        return None
    halvings = -np.arange(len(counts), dtype=float)
    logarithms = np.log2(counts)
    slope, offset = np.polyfit(halvings, logarithms, 1)
    left = logarithms - offset - slope * halvings
    error = np.sqrt((left**2).sum() / (len(counts) - 2) / ((halvings - halvings.mean()) ** 2).sum())
    return float(slope), float(error)


def _blocks(low: Kinds, high: Kinds, apart: int = 1) -> tuple[Kinds, Kinds]:
    """Lowest and highest kind of each block of two neighbours a side, from those of the neighbours.

    Blocks begin ``apart`` cells from one another; at 2 they do not overlap.
    """
    for axis in range(low.ndim):
        first = np.arange(0, low.shape[axis] - 1, apart)
        low = np.minimum(low.take(first, axis), low.take(first + 1, axis))
        high = np.maximum(high.take(first, axis), high.take(first + 1, axis))
    return low, high


def _lattice(shape: tuple[int, ...], strides: list[int]) -> list[Cells]:
    """Every stride-th index of each axis, and the last."""
    return [np.unique(np.append(np.arange(0, n, s), n - 1)) for n, s in zip(shape, strides, strict=True)]


def _inferred(axes: list[Cells], sources: Cells) -> npt.NDArray[np.bool_]:
    """Mask of the lattice points that are not computed."""
    cell_numbers = np.arange(sources.size).reshape(sources.shape)
    inferred: npt.NDArray[np.bool_] = sources[np.ix_(*axes)] != cell_numbers[np.ix_(*axes)]
    return inferred


def _compute(
    axes: list[Cells], wanted: npt.NDArray[np.bool_], kinds: Kinds, sources: Cells
) -> Generator[Cells, Kinds, None]:
    """Requests the wanted lattice points that are not computed yet."""
    cell_numbers = np.arange(kinds.size).reshape(kinds.shape)
    cells = cell_numbers[np.ix_(*axes)][wanted & _inferred(axes, sources)]
    if cells.size:
        kinds.flat[cells] = yield cells
        sources.flat[cells] = cells


def _follow_borders(axes: list[Cells], kinds: Kinds, sources: Cells) -> Generator[Cells, Kinds, None]:
    """Requests cells next to others of another kind, until all of them are computed."""
    while (border := _at_borders(kinds))[_inferred(axes, sources)].any():
        yield from _compute(axes, border, kinds, sources)


def _drawn(inferred: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Mask of some of the inferred cells, the same in every run and with every NumPy, whose `RandomState` is frozen."""
    cells, drawn = np.flatnonzero(inferred), np.zeros(inferred.shape, dtype=bool)
    count = min(MOST_CHECKED, int(CHECKED_SHARE * cells.size))
    drawn.flat[np.random.RandomState(0).permutation(cells)[:count]] = True
    return drawn


def _mixed_blocks(kinds: Kinds) -> npt.NDArray[np.bool_]:
    """Mask of the blocks between lattice points (one fewer along each axis) whose corners are of different kinds."""
    low, high = _blocks(kinds, kinds)
    return low != high


def _infer(coarse: list[Cells], fine: list[Cells], kinds: Kinds, sources: Cells) -> None:
    """Sets kind and source of the new points of the finer lattice to those of the nearest point of the coarser one."""
    places, nearest = np.ix_(*fine), np.ix_(*(_nearest(c, f) for c, f in zip(coarse, fine, strict=True)))
    unknown = kinds[places] == UNKNOWN
    kinds[places] = np.where(unknown, kinds[nearest], kinds[places])
    sources[places] = np.where(unknown, sources[nearest], sources[places])


def _nearest(coarse: Cells, fine: Cells) -> Cells:
    """The nearest index of the coarser lattice for each index of the finer one; the lower of two that are as near."""
    above = np.searchsorted(coarse, fine)
    below = np.maximum(above - 1, 0)
    return np.where(fine - coarse[below] <= coarse[above] - fine, coarse[below], coarse[above])


def _points_of(blocks: npt.NDArray[np.bool_], coarse: list[Cells], fine: list[Cells]) -> npt.NDArray[np.bool_]:
    """Mask of the points of the lattice ``fine`` in or at the border of marked ``blocks`` of ``coarse``."""
    result = np.zeros([len(axis) for axis in fine], dtype=bool)
    sides = [
        (np.maximum(np.searchsorted(c, f) - 1, 0), np.minimum(np.searchsorted(c, f, side="right") - 1, len(c) - 2))
        for c, f in zip(coarse, fine, strict=True)
    ]
    for corner in np.ndindex(*(2,) * len(fine)):
        result |= blocks[np.ix_(*(side[k] for side, k in zip(sides, corner, strict=True)))]
    return result


def _at_borders(kinds: Kinds) -> npt.NDArray[np.bool_]:
    """Mask of the cells with a neighbour (also across corners) of another kind."""
    from scipy.ndimage import maximum_filter, minimum_filter

    border: npt.NDArray[np.bool_] = maximum_filter(kinds, 3) != minimum_filter(kinds, 3)
    return border
