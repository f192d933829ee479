"""Arrays of many motions: rows are taken as copies and put back."""

from dataclasses import dataclass

import numpy as np

from gelcone.motion.columns import Columns


@dataclass(frozen=True)
class Pair(Columns):
    one: np.ndarray
    two: np.ndarray


def test_rows_are_taken_as_copies_and_put_back():
    whole = Pair(np.arange(4.0), np.arange(8).reshape(4, 2))
    for rows in (slice(1, 3), [1, 2], np.array([False, True, True, False])):
        part = whole.take(rows)
        assert part.one.tolist() == [1.0, 2.0]
        assert part.two.tolist() == [[2, 3], [4, 5]]
        part.one[:] = 9.0
        assert whole.one.tolist() == [0.0, 1.0, 2.0, 3.0]
    whole.put([0, 3], Pair(np.array([7.0, 8.0]), np.zeros((2, 2), dtype=int)))
    assert whole.one.tolist() == [7.0, 1.0, 2.0, 8.0]
    assert whole.two.tolist() == [[0, 0], [2, 3], [4, 5], [0, 0]]
