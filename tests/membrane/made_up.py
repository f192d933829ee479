"""Made-up films, whose states at held heights and voltages are formulas: what a table fits to them is known."""

from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.membrane import piece
from gelcone.membrane import table as module
from gelcone.membrane.columns import Columns
from gelcone.membrane.elements import Measures
from gelcone.membrane.gel import Gel
from gelcone.membrane.mean_length import NAMES as MEAN_LENGTH
from gelcone.membrane.piece import FOLDED
from gelcone.membrane.table import COARSE, FINE, table
from gelcone.physics.laws import LAWS

LAW = LAWS["gent"]
GELS = {"even": (1.0, 1.0), "strong meridian": (1.4, 1.1), "strong hoop": (1.0, 1.5)}
ROUNDED = 1e-3
VARIABLES = {False: {"near": (1.0, -1.0), "far": (1.0, -1.0)}, True: {"near": (1e-4, 0.2), "far": (1.0, -1.0)}}
"""c and e of p = -(s + c)^e, by whether the hoop is stretched more and by piece."""


@dataclass
class MadeUp:
    """A film of a gel. Below s = ``cut`` it falls slack at W = 0.1 + 1.2 (p - p(0)), with a strong hoop at 0.1 - 0.6
    (p - p(0)); above it localises where its innermost ring is as long as `length`: at ``lowest`` + ``rise`` d, d =
    p(star) - p. It begins to pull at s = ``begin``. The force over the height has the factor 1 + ``ripple`` sin(30 p),
    which no fit of a low degree follows. The cut is a ``share`` of the way between the heights at which the film falls
    slack, just above a place that the search for it, in steps of a 729th, comes to.
    """

    gel: Gel
    begin: float = 0.04
    share: float = 184 / 729
    lowest: float = 0.2
    rise: float = 0.3
    star: float = -0.25
    longest: float = 1.9
    limit: float = 0.8
    ripple: float = 0.0
    ratio: float = 0.3
    slackest: float = 1.5

    @property
    def strong(self):
        return self.gel.A < self.gel.B

    def of_height(self, x):
        return x * x - (FOLDED if self.strong else 0.0)

    @property
    def cut(self):
        return self.begin + (self.slackest**2 - self.begin) * self.share + 1e-9

    def height(self, s):
        return np.sqrt(s + (FOLDED if self.strong else 0.0))

    def place(self, piece, s):
        c, e = VARIABLES[self.strong][piece]
        return -((s + c) ** e)

    def slack(self, s):
        return 0.1 + (-0.6 if self.strong else 1.2) * (self.place("near", s) - self.place("near", 0.0))

    def away(self, s):
        below = self.star - self.place("far", s)
        return 0.5 * (below + np.hypot(below, ROUNDED))

    def localisation(self, s):
        return self.lowest + self.rise * self.away(s)

    def disc(self, s):
        """The squared length of the innermost ring, whatever the voltage."""
        p = self.place("far", s)
        return np.where(s < self.cut, 0.9 + 0.3 * p, self.longest + 0.8 * (p - self.star)) ** 2

    def length(self, gel, V, grid=0):
        """The length at which a ring localises: that of the innermost one at the height at which the film does."""
        with np.errstate(all="ignore"):
            away = (np.asarray(V) - self.lowest) / self.rise
            return np.where(away > 0.0, self.longest - 0.8 * np.maximum(away - 0.25 * ROUNDED**2 / away, 0.0), np.nan)

    def q(self, s, V):
        return np.where(s < self.cut, V / self.slack(s), V / self.localisation(s))

    def kinks(self, s):
        """The q at which the first and the last hoop fall slack."""
        return 0.45 + 0.05 * self.place("far", s), 0.8 + 0.1 * self.place("far", s)

    def pull(self, s, V):
        """The force over the height."""
        near, q = s < self.cut, self.q(s, V)
        p = np.where(near, self.place("near", s), self.place("far", s))
        rim, whole = (np.maximum(q - at, 0.0) for at in self.kinks(s))
        found = 2.0 + 0.4 * p - 0.3 * q + 0.1 * p * q * q + rim**2 * (0.2 - 0.1 * p) - whole**2 * (0.3 + 0.2 * q)
        return found * np.where(near, self.slack(s) - V, 1.0) * (1.0 + self.ripple * np.sin(30.0 * p))

    def measured(self, x, V):
        s = self.of_height(x)
        near = s < self.cut
        rim, whole = self.kinks(s)
        top, disc = np.where(near, self.slack(s), self.localisation(s)), self.disc(s)
        field_over_v = np.sqrt(1.5 + 0.2 * self.place("far", s) + 0.3 * self.q(s, V))
        area = 1.0 + (0.1 * V - 0.05 * V * V + 0.02 * V**3) * np.ones_like(x)
        force = x * self.pull(s, V)
        return Measures(x, force, area, disc, disc, field_over_v, disc, rim * top - V, whole * top - V)

    # --- what a table asks for ---------------------------------------------------------------------------------------

    def __call__(self, gel, ratio, count):
        assert (gel, ratio) == (self.gel, self.ratio)
        assert count == (FINE if self.strong else COARSE)
        return self

    def unloaded(self, x, until_lost=False):
        return SimpleNamespace(x=x, found=np.ones(x.shape, bool))

    def measures(self, states):
        return self.measured(states.x, np.zeros(states.x.shape))

    def columns(self, film, heights, first, top, steps=14, finest=3e-4):
        s = self.of_height(heights)
        end = np.minimum(np.where(s < self.cut, self.slack(s), self.localisation(s)), top)
        column = np.repeat(np.arange(heights.size), steps)
        share = np.linspace(0.0, 1.0, steps) ** np.linspace(0.9, 1.1, heights.size)[:, None]
        V = (end[:, None] * share).ravel()
        return Columns(column, V, self.measured(heights[column], V), heights, s < self.cut, end, top, None)

    def table(self, monkeypatch):
        """The numbers that are fitted to it."""
        monkeypatch.setattr(module, "Elements", self)
        for one in (module, piece):
            monkeypatch.setattr(one, "columns", self.columns)
        monkeypatch.setattr(piece, "longest", self.length)
        monkeypatch.setattr(module, "lowest_localisation", lambda gel, highest: self.lowest)
        monkeypatch.setattr(module, "slack_limit", lambda gel: self.limit)
        monkeypatch.setattr(piece, "slack_voltages", lambda gel, ratio: lambda x: self.slack(self.of_height(x)))
        monkeypatch.setattr(
            module, "slack_height", lambda gel, ratio, V: self.begin**0.5 if V == 0.0 else self.slackest
        )
        if self.strong:
            monkeypatch.setattr(module, "localised", lambda gel, found: found.heights > self.cut**0.5)
        monkeypatch.setattr(module, "fitted_mean_length", lambda *given: dict.fromkeys(MEAN_LENGTH, 0.0))
        return table(self.gel, self.ratio)


@cache
def made_up(kind, **changes):
    """A made-up film and its table."""
    film = MadeUp(Gel(LAW, LAW.numbers({"stretch_limit": changes.pop("stretch_limit", 50.0)}), *GELS[kind]), **changes)
    with pytest.MonkeyPatch.context() as patch:
        return film, film.table(patch)


def places(film, n, piece):
    """s and V of states of a piece, between the places at which the fit has its own."""
    begin, end = (film.begin, n["cut_squared"]) if piece == "near" else (n["cut_squared"], n["reach_squared"])
    s = begin + (end - begin) * np.linspace(0.01, 0.99, 41)
    return s, np.linspace(0.0, 0.97, 17)[:, None] * (film.slack(s) if piece == "near" else film.localisation(s))
