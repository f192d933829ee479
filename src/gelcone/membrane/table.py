"""The table of a film: all numbers of its force, fitted to its states; the formulas stand in `force.py`."""

from __future__ import annotations

from functools import cache

import numpy as np

from gelcone.membrane import force
from gelcone.membrane.columns import LIMIT_SHARE, columns, localised, lowest_localisation
from gelcone.membrane.elements import Elements
from gelcone.membrane.force import FLAT, NEVER
from gelcone.membrane.gel import Gel
from gelcone.membrane.mean_length import NAMES as MEAN_LENGTH
from gelcone.membrane.mean_length import fitted as fitted_mean_length
from gelcone.membrane.piece import BEFORE, FittedFilm, fit_piece, no_piece
from gelcone.membrane.refusals import not_made, too_few
from gelcone.membrane.slack import slack_height, slack_limit

HIGHEST = 3.0
"""Largest height, in b - a, up to which states are computed."""
TRIALS = np.geomspace(0.05, 2.0 * HIGHEST, 48)
TRIALS = TRIALS[: np.searchsorted(TRIALS, HIGHEST) + 1]
"""Heights at which it is tried whether a film reaches them: up to the first above the highest."""
BRACKETS, ROUNDS, CUT_FINEST = 8, 3, 2e-3
"""Search for the heights at which films localise before they fall slack: heights per round, rounds, and the share of
the voltage to which the end of a column is computed."""
LEAST_NEAR = 2e-3
"""Least range of s of the near piece: a film that falls slack in a smaller range is taken to localise there, too."""
COARSE, FINE = 100, 160
"""Numbers of elements; the finer one of films whose hoop is stretched more than their meridian."""
MARGIN, GAIN_MARGIN, ELEMENT_ERROR = 3.5, 2.0, 2e-4
"""Ratios of the stated errors of the force and of its reduction by a voltage to the largest at the computed heights
(errors in between may be larger); and the error of the elements."""
LARGEST_ERROR = 1.5
"""Largest stated error of the force of a film that is not refused."""


def table(gel: Gel, ratio: float) -> dict[str, float]:
    """The numbers of the film of a gel; ``ratio`` is a/b.

    ``film_error`` is the largest error of the force, over the force and a tenth of that without voltage there or at the
    height 0.1, whichever is greater. ``gain_error`` is the largest relative error of the reduction of the force by a
    voltage, at heights from 0.1.

    Raises `InputError` for a film with too few states found, or with a force that is fitted too badly.
    """
    strong = gel.has_rims
    film = FittedFilm(Elements(gel, ratio, FINE if strong else COARSE), {})
    hump = gel.hump()
    limit = min(slack_limit(gel), NEVER)
    free = float(gel.crumpling(gel.B)) / gel.G
    flat = (free if hump > gel.B else limit) if strong else float(film.slack_at(np.zeros(1))[0])
    film.numbers["slack_limit"] = limit
    reach, begin = _reach(film.elements), slack_height(gel, ratio, 0.0) ** 2
    if begin >= reach:
        raise not_made(gel, "without voltage this film is slack at every height", "wrinkling, or larger pre-stretches")
    lowest = lowest_localisation(gel, max(limit if limit < NEVER else 0.0, flat, 1.0))
    film.numbers["lowest_pull_in"] = min(lowest, NEVER)
    slackest = slack_height(gel, ratio, limit) ** 2 if limit < NEVER else np.inf
    if np.isfinite(lowest):
        cut = -1.0 if hump <= gel.A else _cut(film, begin, slackest, reach)
    elif slackest > begin + LEAST_NEAR:
        cut = min(slackest, reach)
    else:
        raise too_few(gel)
    falls_slack = cut > begin + LEAST_NEAR
    cut = cut if falls_slack else -1.0
    film.numbers |= {"cut_squared": cut, "begin_squared": begin, "reach_squared": reach, "flat_voltage": flat}
    ends = {"near": (begin, cut), "far": (max(cut, 0.0), reach)}
    for piece, (low, high) in ends.items():
        if low < high:
            fit_piece(film, piece, low, high)
        else:
            no_piece(film, piece)
    error = ELEMENT_ERROR + MARGIN * max(film.errors)
    if not error <= LARGEST_ERROR:
        why = f"the force of this film (a/b = {ratio:g}) cannot be fitted to its states"
        raise not_made(gel, why, "wrinkling, or other pre-stretches")
    stated = {"film_error": error, "gain_error": ELEMENT_ERROR + GAIN_MARGIN * max(film.gain_errors)}
    return film.numbers | fitted_mean_length(film.elements, begin, reach) | stated


@cache
def names() -> tuple[str, ...]:
    """Names of all numbers of a table, sorted."""
    all_names = ["cut_squared", "begin_squared", "reach_squared", "slack_limit", "flat_voltage"]
    all_names += ["lowest_pull_in", "star_place", "end_begin", "end_scale", "end_offset", "film_error", "gain_error"]
    all_names += [*force.END_NAMES, *MEAN_LENGTH] + [f"flat_area_{i}" for i in range(FLAT + 1)]
    for piece in force.PIECES:
        for what in force.shapes(piece):
            all_names += list(force.names(piece, what).ravel())
    return tuple(sorted(all_names))


def _reach(film: Elements) -> float:
    """The largest s at which the film without voltage stays within its stretch limit next to the disc."""
    states = film.unloaded(TRIALS, until_lost=True)
    gel, measured = film.gel, film.measures(states)
    with np.errstate(all="ignore"):
        inside = states.found & (gel.strain(measured.disc, np.ones(TRIALS.size)) < LIMIT_SHARE * gel.strain_limit)
    count = int(np.argmin(inside)) if not inside.all() else TRIALS.size
    if count < 2:
        raise too_few(gel)
    return float(min(TRIALS[count - 1], HIGHEST)) ** 2


def _cut(film: FittedFilm, begin: float, slackest: float, reach: float) -> float:
    """The s above which the film, raised in voltage, localises before it falls slack."""
    low, high = begin, min(slackest, reach)
    for _ in range(ROUNDS):
        s = np.linspace(low, high, BRACKETS + 2)[1:-1]
        x = film.height(s)
        top = film.slack_at(x)
        cut_columns = columns(film.elements, x, top, top * (1.0 - BEFORE), finest=CUT_FINEST)
        falls = cut_columns.end >= top * (1.0 - 0.03)
        if film.gel.has_rims:
            falls |= ~localised(film.gel, cut_columns)
        first = int(np.argmin(falls)) if not falls.all() else s.size
        low, high = (s[first - 1] if first else low), (s[first] if first < s.size else high)
    return float(low)
