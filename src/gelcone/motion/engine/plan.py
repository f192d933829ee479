"""The parts that the code of a program depends on, and where its numbers are."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from gelcone.motion.engine.equations import Equation
from gelcone.motion.engine.recurrences import held_values
from gelcone.physics.trace import Node

CROWD = 4
"""Members that a thread works on, for each lane of each law: with 1 there is always a law whose lanes are full, with
more this lasts longer at the end."""
ARRIVED, NOT_FINITE, STEP_TOO_SMALL, TOO_MANY_STEPS, TERMINAL_EVENT = range(5)
"""Ways in which a member ends; TERMINAL_EVENT + k stands for the event k, which is terminal or switches on and on."""
MOST_IN_PLACE = 100
"""Switches at once after which no law is taken to hold: each of a few borders has only two sides."""
THREAD = ["ptr noalias %lanes", "ptr noalias %scratch", "ptr %job", "ptr %words", "ptr noalias %store"]
"""A thread's lanes (laws, rows, width), room for the last step, job, words, and slots (slots, rows)."""
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
    """A traced event: its direction, the place of its switch (None: terminal), and whether it is ``sided``: whether the
    function is known to be positive (direction -1) where a member is; ``smooth`` and ``seldom`` are those of the
    event."""

    direction: int
    switch: int | None
    sided: bool
    smooth: bool
    seldom: bool


@dataclass(frozen=True)
class Law:
    """The law of a member as long as the switches that distinguish laws keep their signs: the rates of change of the
    states, the border functions and the equations of all roots among both."""

    rates: tuple[Node, ...]
    borders: tuple[Node, ...]
    equations: tuple[Equation, ...]

    @property
    def wanted(self) -> list[Node]:
        """All nodes that are wanted."""
        return [*self.rates, *self.borders]

    @property
    def held(self) -> list[Node]:
        """Nodes of its formulas that do not change while a member is integrated."""
        parts = [node for equation in self.equations for node in (*equation.slopes, equation.first)]
        return held_values([*self.wanted, *parts])


@dataclass(frozen=True)
class Plan:
    """All that the code of a program depends on.

    ``laws``: one for each combination of signs of the switches at the places ``telling``; bit k of its place is set
    where the k-th of them is negative.
    ``restarts``: what the states are set to after each sample (None leaves them); steps then end at the samples, else
    samples are read from the Taylor polynomial. ``passengers``: how many of the last states are integrals that nothing
    depends on, which do not shorten the steps. ``pieces``: how many of the last switches describe the piece of the
    drive between two corners: its beginning, then its terms, which are loaded at each corner.
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
        """The number of switches whose sign counts."""
        return len(self.switches) - self.pieces

    @property
    def wanted(self) -> list[Node]:
        """All nodes that are wanted, law by law."""
        return [node for law in self.laws for node in law.wanted]

    @property
    def slots(self) -> int:
        """Members that a thread can work on; with a single law more than lanes serve nothing. A power of 2."""
        return self.width if len(self.laws) == 1 else CROWD * len(self.laws) * self.width

    @property
    def ends_at_samples(self) -> bool:
        """Whether each step ends at the next sample at the latest, for the states to be set to `restarts` there."""
        return any(value is not None for value in self.restarts)


class Layout:
    """Rows of a lane, ``width`` numbers each, and of the scratch room that keeps the last step."""

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
        first = self.states
        (
            self.time,
            self.time_low,
            self.target,
            self.stop,
            self.corner,
            self.smallest,
            self.most_steps,
            self.least,
            self.steps,
            self.member,
            self.slot,
            self.sample,
            self.corner_number,
            self.table,
        ) = range(first, first + 14)
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
        # words of a thread: for each law a bit for each lane that has a member, how many wait, and where in the law's
        # ring the first of them is; then the rings, the addresses of each law's ``step`` (0 until it is compiled) and
        # of ``serve``, and the law, counted from 1, of which ``step`` is missing
        self.waiting: int = len(plan.laws)
        self.heads: int = 2 * len(plan.laws)
        self.rings: int = 3 * len(plan.laws)
        self.code: int = self.rings + len(plan.laws) * plan.slots
        self.serve: int = self.code + len(plan.laws)
        self.missing: int = self.serve + 1
        self.words: int = self.missing + 1

    def root(self, equation: Equation) -> int:
        """Place of the equation's root among all."""
        return self.equations.index(equation.root.index)
