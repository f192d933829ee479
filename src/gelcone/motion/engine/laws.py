"""Tracing of a system into laws, borders and switches: the fields of a `Plan`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from gelcone.motion.engine.equations import equations_of
from gelcone.motion.engine.events import Event
from gelcone.motion.engine.plan import Border, Law
from gelcone.physics.trace import Graph, Node, ordered

DISC_STATES = 2
"""Number of states up to which the trace of the Jacobian depends on the damping alone."""
MOST_TELLING = 4
"""Most switches that distinguish laws: each doubles the code."""


class System(Protocol):
    """Equations of motion of a program. Formulas are traced with a `Graph` as ``xp``."""

    @property
    def states(self) -> tuple[Any, ...]:
        """The state variables."""

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the numbers in the formulas; each member has its values."""

    def rates(self, time: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any) -> Sequence[Any]:
        """Rates of change of the states, (N,)."""

    def flow(
        self, time: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any
    ) -> tuple[Sequence[Any], Sequence[Sequence[Any]]]:
        """Rates (N,) and their derivatives with respect to the states (N, N)."""

    def powers(self, time: Any, state: Sequence[Any], n: Mapping[str, Any], xp: Any) -> tuple[Any, ...]:
        """Powers whose integrals a program with ``keep="work"`` computes."""

    @property
    def bounding_powers(self) -> int:
        """Number of the powers, the first ones, that bound the steps; the others have only the motion's poles."""


def traced_plan(system: System, keep: str, events: Sequence[Event], pieces: tuple[str, ...]) -> dict[str, Any]:
    """The system's formulas as fields of a `Plan`."""
    graph = Graph()
    count = len(system.states)
    state = [graph.state(i) for i in range(count)]
    names = [event.switch for event in events] + list(pieces)
    switched = tuple(dict.fromkeys(name for name in names if name is not None))
    for name in switched:
        if name not in system.numbers:
            raise ValueError(f"switch = {name!r}: is not among the numbers {', '.join(system.numbers)}")
    n = {name: graph.switch(name) if name in switched else graph.number(name) for name in system.numbers}
    telling = list(dict.fromkeys(event.switch for event in events if event.divides and event.switch is not None))
    telling = telling[:MOST_TELLING]

    laws = []
    for signs in range(2 ** len(telling)):
        constants = {name: graph.constant(-1.0 if signs >> k & 1 else 1.0) for k, name in enumerate(telling)}
        laws.append(_law(graph, system, keep, events, state, n | constants))
    return {
        "laws": tuple(laws),
        "telling": tuple(switched.index(name) for name in telling),
        "borders": tuple(_border(k, event, n, laws, telling, switched) for k, event in enumerate(events)),
        "switches": tuple(graph.switch(name) for name in switched),
        "numbers": tuple(system.numbers),
        "restarts": _restarts(keep, count, len(laws[0].rates)),
        "passengers": _passengers(system, keep, len(laws[0].rates)),
        "pieces": len(pieces),
    }


def _border(
    k: int, event: Event, n: Mapping[str, Node], laws: Sequence[Law], telling: Sequence[str], switched: Sequence[str]
) -> Border:
    """The k-th event as a border of the laws; ``switched`` are the names of all switches."""
    switch = None if event.switch is None else n[event.switch]
    own_switch = event.switch in telling or any(switch in ordered([law.borders[k]]) for law in laws)
    if own_switch and not event.direction:
        raise ValueError(f"direction = 0: a border that contains its switch {event.switch!r} takes -1 or 1")
    place = None if event.switch is None else switched.index(event.switch)
    return Border(event.direction, place, own_switch or event.inside, event.smooth, event.seldom, event.gentle)


def _law(
    graph: Graph, system: System, keep: str, events: Sequence[Event], state: Sequence[Any], n: Mapping[str, Any]
) -> Law:
    """The law for the numbers ``n``, with constants in place of the switches that distinguish laws."""
    count = len(state)
    if keep == "tangents":
        flow, slopes = system.flow(graph.time, state, n, graph)
        rates = [graph.node(rate) for rate in flow]
        deviation = [[graph.state(count + count * i + j) for j in range(count)] for i in range(count)]
        for i in range(count):
            for j in range(count):
                terms = [graph.multiply(slopes[i][k], deviation[k][j]) for k in range(count)]
                rates.append(sum(terms, graph.constant(0.0)))
        if count > DISC_STATES or not getattr(system, "planar", True):  # else it is known
            rates.append(graph.node(sum((slopes[i][i] for i in range(count)), graph.constant(0.0))))
    else:
        rates = [graph.node(rate) for rate in system.rates(graph.time, state, n, graph)]
        if keep == "work":
            rates += [graph.node(power) for power in system.powers(graph.time, state, n, graph)]
    values = [graph.node(event.border(graph.time, state, n, graph)) for event in events]
    return Law(tuple(rates), tuple(values), equations_of([*rates, *values]))


def _restarts(keep: str, count: int, rates: int) -> tuple[float | None, ...]:
    """Values to which the states are reset after each sample; None, unchanged, for the ``count`` states of the
    system."""
    if keep != "tangents":
        return (None,) * rates
    unit = [float(i == j) for i in range(count) for j in range(count)]
    return (*[None] * count, *unit, *[0.0] * (rates - count - len(unit)))


def _passengers(system: System, keep: str, rates: int) -> int:
    """Number of integrals, the last states, that do not bound the steps."""
    count = len(system.states)
    bounding = {"states": 0, "tangents": count * count}
    return rates - count - (system.bounding_powers if keep == "work" else bounding[keep])
