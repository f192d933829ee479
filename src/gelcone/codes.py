"""Outcomes of runs and kinds of motion: the numbers in results, and what they mean in words."""

from __future__ import annotations

import inspect
import textwrap
from enum import IntEnum
from typing import Any, Self

import numpy as np

STEPS_PER_CALL = 800_000
CALL_SPAN = 2000.0
"""Longest stretch of motion handed to the integrator at once, in units of the fastest linear time scale: between such
calls an interrupt is noticed and a failing member is separated from its neighbours."""

WIDTH = 116
"""Most letters of a line of a docstring."""


class Code(IntEnum):
    """Numbers in results, each given with what it means; the docstring of a class of them lists its members."""

    meaning: str
    """One or two sentences."""

    def __init_subclass__(cls, **given: Any) -> None:
        super().__init_subclass__(**given)
        listed = "\n".join(
            textwrap.fill(f"* ``{one.name}``: {one.meaning}", WIDTH, subsequent_indent="  ", break_on_hyphens=False)
            for one in cls
            if one.meaning
        )
        before, *after = inspect.cleandoc(cls.__doc__ or "").split("\n\n", 1)
        cls.__doc__ = "\n\n".join(filter(None, (before, listed, *after)))

    def __new__(cls, value: int, meaning: str = "") -> Self:
        code = int.__new__(cls, value)
        code._value_, code.meaning = value, meaning
        return code

    @property
    def label(self) -> str:
        """The name as in JSON, with underscores."""
        return self.name.lower()

    @property
    def words(self) -> str:
        """The name as in texts and figures, with blanks."""
        return self.label.replace("_", " ")


def meanings(variable: Any) -> dict[int, str]:
    """Code -> its word, of a variable of a result that holds codes."""
    words = str(variable.attrs["flag_meanings"]).split()
    return dict(zip(np.ravel(variable.attrs["flag_values"]).tolist(), words, strict=True))


class Outcome(Code):
    """The ending of the run of one member; everything but ``OK`` leaves NaN from where it happened.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=[0.5, 3.0], film="wrinkling", law="neo-hookean", hoop_prestretch=1.4)
    >>> response = gelcone.simulate(model, (0.5, 0.0), periods=8)
    >>> [f"{code}: {gelcone.Outcome(code).label}" for code in response.outcome.values]
    ['0: ok', '6: pulled_in']
    """

    OK = 0, "ok"
    OUTSIDE = (
        1,
        "starts beyond the stretch limit, or its membrane cannot be computed; start lower, raise "
        "stretch_limit, or take film = wrinkling",
    )
    STRETCH_LIMIT = (
        2,
        "came closer to the stretch limit than double precision resolves; raise stretch_limit, "
        "lower the voltage or start with less energy",
    )
    STEP_LIMIT = (
        3,
        f"needed more than {STEPS_PER_CALL} steps for a short stretch of the run; the model is too stiff, or its drive "
        "has corners too often",
    )
    NOT_FINITE = (
        4,
        "became infinite, because the energy has no bound there (a film without stretch limit, or "
        "deviations sampled too rarely), or did not start from finite numbers",
    )
    ERROR = 5, "the analysis raised an error there; run this point alone to see it"
    PULLED_IN = (
        6,
        "pulled in: the film lost its equilibrium under the voltage; lower the voltage or start with less energy",
    )
    IMPOSSIBLE = 7, "no actuator has these values together; narrow the range of one of them"


class FilmPullIn(Code):
    """The way in which a film without compression pulls in."""

    NONE = 0
    MINIMUM = 1
    LOCALISATION = 2


class Regime(Code):
    """Kinds of motion.

    Examples
    --------
    >>> import gelcone
    >>> [f"{kind.value}: {kind.label}" for kind in gelcone.Regime][:4]
    ['0: rest', '1: periodic', '2: quasi-periodic', '3: chaotic']
    """

    REST = 0, "The disc does not move."
    PERIODIC = 1, "A motion that repeats after a whole number of forcing periods, which is its period."
    QUASI_PERIODIC = 2, "A motion of two frequencies that have no common period."
    CHAOTIC = (
        3,
        "Bounded, never repeating, with a positive Lyapunov exponent: neighbouring motions part exponentially.",
    )
    TRANSIENT = (
        4,
        "Not settled when the patience ended, or stopped by the integrator before: where it leads is unknown.",
    )
    LEFT_THE_DOMAIN = (
        5,
        "The run ended where the model does: the film pulled in, or there is no state; the outcome says why.",
    )
    TRANSIENT_CHAOS = 6, "Chaos that ends by itself, after its lifetime in the mean."

    @property
    def label(self) -> str:
        """The name in words, as printed and in JSON."""
        return "quasi-periodic" if self is Regime.QUASI_PERIODIC else self.name.lower().replace("_", " ")
