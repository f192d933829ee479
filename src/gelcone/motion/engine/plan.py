"""The plan of a program, on which its code depends, and the layout of its numbers."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from gelcone.motion.engine.equations import Equation
from gelcone.motion.engine.recurrences import held_values
from gelcone.physics.trace import Node

CROWD = 4
"""Members of a thread for each lane of each law: with 1 the lanes of some law are always full, with more also close to
the end of a run."""
ARRIVED, NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, TERMINAL_EVENT = range(5)
"""Statuses of ended members; TERMINAL_EVENT + k for the event k, which is terminal or switches without end."""
MOST_IN_PLACE = 100
"""Most switches at one time; after more no law is taken to hold, as each of a few borders has only two sides."""
THREAD = ["ptr noalias %lanes", "ptr noalias %scratch", "ptr %job", "ptr %words", "ptr noalias %store"]
"""Arguments: a thread's lanes (laws, rows, width), scratch room for the last step, job, words, slots (slots, rows)."""
SAME_THREAD = "ptr %lanes, ptr %scratch, ptr %job, ptr %words, ptr %store"


class Job(IntEnum):
    """Fields of the job that the loop reads, 8 bytes each: addresses of arrays, then integers."""

    TABLE = 0  # (held values, padded members)
    STATES = 1  # (members, states)
    SWITCHES = 2  # (members, switches), at the start, then at the end
    START = 3  # (members,)
    TIMES = 4  # (members, samples)
    CORNERS = 5  # (members, corners + 1), the last infinite
    SMALLEST = 6  # (members,)
    MOST_STEPS = 7  # (members,)
    RESULT = 8  # (members, samples, states)
    STATUS = 9  # (members,) int64
    STEPS = 10  # (members,)
    LEAST = 11  # (members,)
    END_TIME = 12  # (members,)
    END_STATE = 13  # (members, states)
    DWELL = 14  # (members, 2^switches)
    MEMBERS = 15
    SAMPLES = 16
    CORNER_COUNT = 17
    PADDED = 18
    SLOTS = 19  # members that a thread works on at a time
    NEXT = 20  # the member that the next free slot takes
    PIECES = 21  # an address: (members, pieces, terms of a piece)
    FIRST_PIECE = 22  # an address: (members,) int64, the piece that begins at the first corner
    PIECE_COUNT = 23


@dataclass(frozen=True)
class Border:
    """A traced event.

    ``direction``, ``smooth``, ``seldom`` and ``gentle`` as in `Event`; ``switch``, the place of its switch (None:
    terminal); ``sided``, true if the side of a member is known: the function is positive there (direction -1) or
    negative.
    """

    direction: int
    switch: int | None
    sided: bool
    smooth: bool
    seldom: bool
    gentle: bool


@dataclass(frozen=True)
class Law:
    """The law of a member while the switches that distinguish laws keep their signs: rates of change of the states,
    border functions, and the equations of all roots in these."""

    rates: tuple[Node, ...]
    borders: tuple[Node, ...]
    equations: tuple[Equation, ...]

    @property
    def wanted(self) -> list[Node]:
        """The rates and the border functions."""
        return [*self.rates, *self.borders]

    @property
    def held(self) -> list[Node]:
        """Nodes of the formulas that do not change during the run of a member."""
        parts = [node for equation in self.equations for node in (*equation.slopes, equation.first)]
        return held_values([*self.wanted, *parts])


@dataclass(frozen=True)
class Plan:
    """The plan of a program, on which its code depends.

    ``laws``: one for each combination of signs of the switches at the places ``telling``; bit k of its index is set if
    the k-th of these is negative. ``restarts``: values to which the states are reset after each sample (None: not
    reset); with any, steps end at the samples, else samples are read from the Taylor polynomial. ``passengers``: number
    of integrals, the last states, that do not bound the steps. ``pieces``: number of switches, the last ones, that
    describe the piece of the drive between two corners: its beginning, then its terms; they are loaded at each corner.
    """

    laws: tuple[Law, ...]
    telling: tuple[int, ...]
    borders: tuple[Border, ...]
    switches: tuple[Node, ...]
    numbers: tuple[str, ...]
    order: int
    tolerance: float
    restarts: tuple[float | None, ...]
    passengers: int
    pieces: int
    width: int

    @property
    def signs(self) -> int:
        """Number of switches whose sign counts."""
        return len(self.switches) - self.pieces

    @property
    def wanted(self) -> list[Node]:
        """The rates and border functions of all laws."""
        return [node for law in self.laws for node in law.wanted]

    @property
    def slots(self) -> int:
        """Members that a thread works on, a power of 2; for a single law one for each lane."""
        return self.width if len(self.laws) == 1 else CROWD * len(self.laws) * self.width

    @property
    def ends_at_samples(self) -> bool:
        """True if steps end at the samples, where states are reset to `restarts`."""
        return any(value is not None for value in self.restarts)


class Layout:
    """Places of the rows of a lane, of the scratch room that keeps the last step, and of the words of a thread.

    A row has ``width`` numbers, one for each lane. The rows declared first follow the states of a lane, in their order.
    """

    time: int
    time_low: int
    target: int
    stop: int
    corner: int
    smallest: int
    most_steps: int
    least: int
    steps: int
    member: int
    slot: int
    sample: int
    corner_number: int
    table: int

    def __init__(self, plan: Plan) -> None:
        self.states: int = len(plan.laws[0].rates)
        self.held: list[Node] = list({node.index: node for law in plan.laws for node in law.held}.values())
        roots = (equation.root.index for law in plan.laws for equation in law.equations)
        self.equations: list[int] = list(dict.fromkeys(roots))
        for row, name in enumerate(Layout.__annotations__, self.states):
            setattr(self, name, row)
        self.switches: int = self.table + len(self.held)
        self.sides: int = self.switches + len(plan.switches)
        self.roots: int = self.sides + len(plan.borders)
        self.dwell: int = self.roots + len(self.equations)
        self.combinations: int = 2**plan.signs if plan.signs else 0
        self.since: int = self.dwell + self.combinations
        self.in_place: int = self.since + 1
        self.rows: int = self.since + 2
        self.terms: int = plan.order + 1
        self.borders: int = self.states * self.terms
        self.root_terms: int = self.borders + len(plan.borders) * self.terms
        self.step_time: int = self.root_terms + len(self.equations) * self.terms
        self.step_low: int = self.step_time + 1
        self.step: int = self.step_time + 2
        self.scratch_rows: int = self.step_time + 3
        # words of a thread: for each law the bits of lanes with a member, the number of waiting members, and the place
        # of the first of these in the law's ring; then the rings, the addresses of each law's ``step`` (0 until it is
        # compiled) and of ``serve``, and the law, counted from 1, whose ``step`` is missing
        self.waiting: int = len(plan.laws)
        self.heads: int = 2 * len(plan.laws)
        self.rings: int = 3 * len(plan.laws)
        self.code: int = self.rings + len(plan.laws) * plan.slots
        self.serve: int = self.code + len(plan.laws)
        self.missing: int = self.serve + 1
        self.words: int = self.missing + 1

    def root(self, equation: Equation) -> int:
        """Index of the equation's root among those of all laws."""
        return self.equations.index(equation.root.index)
