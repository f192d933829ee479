"""The search for driven limits, in made-up planes whose limits are known functions of the frequency."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.motion import driven as module
from gelcone.motion import plane as planes
from gelcone.motion.driven import NARROWEST, PARTS, WITHIN, driven, rows_of
from gelcone.motion.plane import DRIVEN_LIMITS, YIELDS
from gelcone.physics.model import ConeModel
from tests.recorded import numbers, record

NEVER = lambda omega: np.full(np.shape(omega), np.inf)  # noqa: E731
UNKNOWN = lambda omega: np.full(np.shape(omega), np.nan)  # noqa: E731
PULL_IN = lambda omega: 1.3 + 0.1 * omega  # noqa: E731
HOOP = lambda omega: 0.62 + 0.3 * (omega - 1.0) ** 2  # noqa: E731
STEP = lambda omega: np.where(omega < 1.017, 0.4, 1.1)  # noqa: E731


class World:
    """A plane whose motions meet each limit above a voltage that the frequency gives; ``asked`` are its pairs."""

    def __init__(self, limits_from="rest", onset=np.nan, **limits):
        self.limits_from, self.onset = limits_from, onset
        self.limits = {name: limits.get(name.replace(" ", "_").replace("-", "_"), NEVER) for name in DRIVEN_LIMITS[:-1]}
        self.asked = []

    def examine(self, omegas, peaks, lower=None, *, yields=True, shift=0.0):
        below = [None] * len(peaks) if lower is None else lower.tolist()
        self.asked += zip(omegas.tolist(), peaks.tolist(), below, strict=True)
        met = {name: np.where(np.isnan(limit(omegas)), np.nan, 1.0 * (peaks >= limit(omegas)))
               for name, limit in self.limits.items()}  # fmt: skip
        own = {name: 10.0 * k + omegas + 0.1 * peaks for k, name in enumerate(YIELDS)} if yields else {}
        codes = {"regime": 2.0 + 0.0 * peaks, "outcome": 0.0 * peaks}
        return met | own | codes | {"final": np.stack([omegas, peaks], axis=1)}


@pytest.fixture(autouse=True)
def onsets(monkeypatch):
    """The onset of rest is that of the world, known to a thousandth of a volt."""
    monkeypatch.setattr(module, "_onset", lambda plane, omegas, highest: (plane.onset, plane.onset + 1e-3))


OMEGAS, VOLTS = np.array([0.7, 1.0, 1.6]), np.linspace(0.2, 2.0, 10)


@pytest.mark.parametrize("limits_from", ["rest", "settled", "both"])
def test_each_limit_lies_in_an_interval_of_a_64th_of_the_peaks_apart(limits_from):
    """Also below the lowest peak; what is not met is infinite, and what is not known NaN."""
    world = World(limits_from, 0.9, pull_in=PULL_IN, hoop_slack=HOOP, chaos=lambda omega: 0.05 + 0.0 * omega,
                  dielectric_breakdown=UNKNOWN)  # fmt: skip
    found = driven(world, OMEGAS, VOLTS, refine=False, progress=None)
    for name, limit in (("pull-in", PULL_IN), ("hoop slack", HOOP), ("chaos", world.limits["chaos"])):
        k = DRIVEN_LIMITS.index(name)
        low, high = found["low"][:, k], found["high"][:, k]
        assert (low <= limit(OMEGAS)).all(), name
        assert (limit(OMEGAS) <= high).all(), name
        np.testing.assert_allclose(high - low, 0.2 / PARTS**3, rtol=1e-9)
    for name in ("meridional slack", "stretch limit"):
        k = DRIVEN_LIMITS.index(name)
        assert np.isinf(found["low"][:, k]).all()
        assert np.isinf(found["high"][:, k]).all()
    k = DRIVEN_LIMITS.index("dielectric breakdown")
    assert np.isnan(found["low"][:, k]).all()
    assert np.isnan(found["high"][:, k]).all()
    np.testing.assert_array_equal(found["low"][:, -1], 0.9)
    np.testing.assert_allclose(found["high"][:, -1], 0.901)


@pytest.mark.parametrize(("limits_from", "step"), [("rest", 4), ("settled", 1)])
def test_peaks_are_examined_up_to_the_first_few_with_pull_in(limits_from, step):
    """From rest four at a time; what is not examined is NaN, and all that was is where it belongs."""
    world = World(limits_from, pull_in=PULL_IN)
    found = driven(world, OMEGAS, VOLTS, refine=False, progress=None)
    for i, omega in enumerate(OMEGAS):
        first = int(np.argmax(PULL_IN(omega) <= VOLTS))
        last = min((first // step + 1) * step, len(VOLTS))
        for k, name in enumerate(YIELDS):
            np.testing.assert_allclose(found[name][i, :last], 10.0 * k + omega + 0.1 * VOLTS[:last])
            assert np.isnan(found[name][i, last:]).all()
        np.testing.assert_array_equal(np.isfinite(found["regime"][i]), np.arange(len(VOLTS)) < last)


@pytest.mark.parametrize("limits_from", ["rest", "settled"])
def test_up_to_the_first_limit_the_lowest_one_is_the_same_from_fewer_peaks(limits_from):
    """And motions below it; what lies above is chaotic in many devices, and takes longest."""
    limits = {"pull_in": PULL_IN, "hoop_slack": HOOP, "chaos": lambda omega: 0.9 + 0.0 * omega}
    worlds = World(limits_from, **limits), World(limits_from, **limits)
    whole, first = (
        driven(world, OMEGAS, VOLTS, refine=True, progress=None, to_first=to_first)
        for world, to_first in zip(worlds, (False, True), strict=True)
    )
    np.testing.assert_array_equal(first["frequency"], whole["frequency"])
    for end in ("low", "high"):
        np.testing.assert_array_equal(np.fmin.reduce(first[end], axis=1), np.fmin.reduce(whole[end], axis=1))
    below = VOLTS[None] <= np.fmin.reduce(whole["low"], axis=1)[:, None]
    np.testing.assert_array_equal(first["stroke"][below], whole["stroke"][below])
    asked, every = ({(omega, peak) for omega, peak, _ in world.asked} for world in reversed(worlds))
    assert asked < every
    assert len({pair for pair in asked if pair[1] > 1.0}) < 0.5 * len({pair for pair in every if pair[1] > 1.0})


def test_no_peak_far_above_the_constant_pull_in_is_examined():
    """To the first one above it by a hundredth; all else has its shape all the same."""
    world = World(hoop_slack=HOOP)
    found = driven(world, OMEGAS, VOLTS, refine=False, progress=None, pull_in=0.995)
    assert max(peak for _, peak, _ in world.asked) == pytest.approx(1.2)
    assert found["stroke"].shape == (3, 10)
    assert np.isfinite(found["stroke"]).sum(axis=1).tolist() == [6, 6, 6]


def test_a_voltage_rises_from_the_state_settled_at_the_peak_below():
    """Level by level, and within an interval from the level at its lower end."""
    world = World("settled", hoop_slack=HOOP)
    driven(world, OMEGAS, VOLTS, refine=False, progress=None)
    assert len(world.asked) > 50
    for omega, peak, lower in world.asked:
        if lower is None:
            assert peak == VOLTS[0]
            continue
        below = VOLTS[peak - 1e-9 > VOLTS]
        assert lower == [omega, pytest.approx(below[-1] if below.size else VOLTS[0])]


@pytest.mark.parametrize("limit", [HOOP, STEP])
def test_frequencies_are_added_until_the_lowest_limit_is_known_between_any_two(limit):
    """To a hundredth by the straight line, or to a jump between two that are 0.2 % apart."""
    world = World(hoop_slack=limit)
    shares = []
    found = driven(world, OMEGAS, VOLTS, refine=True, progress=shares.append)
    assert sum(shares) == pytest.approx(1.0)
    known, low = found["frequency"], np.fmin.reduce(found["low"], axis=1)
    assert (np.diff(known) > 0.0).all()
    assert known.size > OMEGAS.size
    shown = np.linspace(0.7, 1.6, 2001)
    off = np.abs(np.interp(np.log(shown), np.log(known), low) / limit(shown) - 1.0)
    beside = np.searchsorted(known, shown[off > WITHIN + 0.02])
    assert (known[beside] / known[beside - 1] < NARROWEST**2).all()
    assert (limit is STEP) == (beside.size > 0)
    yields = np.isfinite(found["stroke"]).any(axis=1)
    np.testing.assert_array_equal(yields, np.isin(known, OMEGAS))


def test_no_frequency_is_added_where_all_limits_lie_above_the_ceiling():
    found = driven(World(hoop_slack=HOOP), OMEGAS, VOLTS, refine=True, progress=None, ceiling=0.6)
    np.testing.assert_array_equal(found["frequency"], OMEGAS)


@pytest.mark.parametrize("around", [0.3, 0.6, 1.1, 1.9])
def test_around_expected_limits_fewer_peaks_give_the_same_intervals(around):
    world, all_ = World(hoop_slack=HOOP, pull_in=PULL_IN), World(hoop_slack=HOOP, pull_in=PULL_IN)
    found = rows_of(world, OMEGAS, VOLTS, None, around=np.full(3, around))
    whole = rows_of(all_, OMEGAS, VOLTS, None, yields=False)
    k = DRIVEN_LIMITS.index("hoop slack")
    for end in ("low", "high"):
        np.testing.assert_array_equal(found[end][:, k], whole[end][:, k])
    at_levels = [peak for _, peak, _ in world.asked if np.isin(peak, VOLTS)]
    assert min(at_levels) <= HOOP(OMEGAS).min()
    if around > 0.6:
        assert min(at_levels) > VOLTS[0]


def test_a_motion_below_all_limits_is_where_the_next_frequency_begins():
    low = np.array([[0.55, np.nan, 1.5], [np.inf, np.inf, np.inf], [0.1, 0.3, np.nan], [VOLTS[2], np.inf, np.inf]])
    final = np.arange(4 * 10 * 2, dtype=float).reshape(4, 10, 2)
    found = module._below_all(final, low, VOLTS)
    np.testing.assert_array_equal(found, final[np.arange(4), [1, 9, 0, 2]])


def test_default_frequencies_hold_the_resonances_at_rest_and_under_the_own_drive():
    """As far as these lie within the span of the first, each to three per cent; none is closer to another."""
    model = ConeModel(
        damping_ratio=0.1, voltage=0.6, voltage_bias=0.6, rest_height=0.6, hoop_prestretch=1.4, drive_frequency=0.77
    )
    plane = planes.Plane(model, planes.DriveShape(0.5, 0.5), 0.3, None)
    natural, loaded = plane.natural_frequency(), plane.natural_frequency(1.2)
    assert loaded < 0.95 * natural
    found = plane.default_frequencies()
    for wanted in (0.77, *np.outer((0.5, 1.0, 2.0), (natural, loaded)).ravel()):
        assert np.abs(found / wanted - 1.0).min() <= planes.TOO_CLOSE
    at = [k for k in range(found.size) if np.isclose(found[k], [0.77, natural, loaded]).any()]
    assert len(at) == 3  # these three to the last digit
    assert (found[1:] / found[:-1]).min() > 1.0 + 0.9 * planes.TOO_CLOSE


@pytest.mark.parametrize(
    ("zeta", "times", "known", "lasts"),
    [
        (0.05, (3.0, 1.0), (False, True), (80.0, 80.0)),
        (0.5, (30.0, 1.0), (False, False), (120.0, 8.0)),
        (0.5, (30.0, 30.0), (False, True), (120.0, 8.0)),
        (1e-4, (30.0, 1e5), (True, False), (1000.0, 1000.0)),
        (0.5, (1e5, 1e5), (False, True), (1000.0, 8.0)),
    ],
)
def test_a_transient_lasts_as_the_slower_of_disc_and_film_unless_the_course_of_the_film_is_known(
    monkeypatch, zeta, times, known, lasts
):
    """Four decay times of each: of the disc at most 1000, of states far slower at most that."""
    members = SimpleNamespace(damping_ratio=np.full(2, zeta), time_constant=np.array(times))
    monkeypatch.setattr(planes, "are_slow", lambda members: members.time_constant > 1e3)
    found = planes.Plane._transient(members, np.array(known))
    np.testing.assert_allclose(found, lasts)


def test_the_onset_of_rest_is_a_peak_voltage_of_a_drive_without_a_bias(monkeypatch):
    """Its amplitude over the share of it in the peak, up to the highest one; infinite where rest stays stable."""
    asked = {}

    def onsets(model, highest):
        asked.update(omegas=model.drive_frequency, highest=highest)
        return {name: SimpleNamespace(values=np.array(v)) for name, v in
                (("onset_voltage", [0.6, np.nan]), ("onset_error", [0.03, np.nan]))}  # fmt: skip

    monkeypatch.undo()
    monkeypatch.setattr(module, "onset_voltage", onsets)
    flat = ConeModel(damping_ratio=0.1, voltage=1.2, spring_stiffness=0.5)
    plane = planes.Plane(flat, planes.DriveShape(0.8, 0.0), 0.0, None)
    low, high = module._onset(plane, np.array([0.5, 0.9]), 2.5)
    np.testing.assert_allclose(low, [0.75, np.inf])
    np.testing.assert_allclose(high, [0.7875, np.inf])
    np.testing.assert_array_equal(asked["omegas"], [0.5, 0.9])
    assert asked["highest"] == pytest.approx(2.0)
    for other in (planes.DriveShape(0.8, 0.2), None):
        model = flat if other else flat.replace(rest_height=0.5)
        plane = planes.Plane(model, other or planes.DriveShape(1.0, 0.0), 0.0, None)
        assert np.isnan(module._onset(plane, np.array([0.5]), 2.5)).all()


def test_onsets_are_sought_up_to_the_highest_peak(monkeypatch):
    asked = []
    monkeypatch.setattr(module, "_onset", lambda plane, omegas, highest: asked.append(highest) or (np.nan, np.nan))
    rows_of(World(hoop_slack=HOOP), OMEGAS, VOLTS, None)
    assert asked == [VOLTS[-1]]


def test_the_largest_value_between_samples_is_that_of_their_parabola():
    x = np.array([[0.0, 0.9, 1.0, 0.5], [1.0, 0.5, 0.2, 0.1], [0.2, 0.2, 0.2, 0.2]])
    parabola = np.polyfit([0.0, 1.0, 2.0], x[0, 1:], 2)
    top = np.polyval(parabola, -0.5 * parabola[1] / parabola[0])
    np.testing.assert_allclose(planes._highest(x), [top, 1.0, 0.2], atol=1e-12)


def test_frequencies_between_are_looked_for_below_the_ceiling_alone_and_around_the_lower_limit(monkeypatch):
    asked = record(monkeypatch, module, unknown_between=(np.empty(0), np.empty(0)), rows_of={"frequency": OMEGAS})
    for ceiling, highest in ((0.75, 0.75), (9.0, 2.0)):
        driven(World(), OMEGAS, VOLTS, refine=True, progress=None, ceiling=ceiling)
        assert asked["unknown_between"][-1]["ceiling"] == highest
    monkeypatch.undo()
    monkeypatch.setattr(module, "_onset", lambda plane, omegas, highest: (np.nan, np.nan))
    low = np.full((2, len(DRIVEN_LIMITS)), np.inf)
    low[:, 0] = 0.5, 1.5
    found = {"frequency": np.array([0.8, 1.25]), "low": low, "high": low, "final_below": numbers(2, 2)}
    between, around = module.unknown_between(World(pull_in=lambda omega: 0.3 + 0.0 * omega), found, 2.0, set())
    assert (between.tolist(), around.tolist()) == ([pytest.approx(1.0)], [0.5])


def test_no_frequency_is_added_where_the_limit_lies_within_the_interval_to_which_it_is_known(monkeypatch):
    """Peaks far apart leave wide intervals: the straight line between these is not off by their width."""
    monkeypatch.setattr(module, "_onset", lambda plane, omegas, highest: (np.nan, np.nan))
    low, high = np.full((2, 2, len(DRIVEN_LIMITS)), np.inf)
    low[:, 0], high[:, 0] = 0.5, 0.6
    found = {"frequency": np.array([0.8, 1.25]), "low": low, "high": high, "final_below": numbers(2, 2)}
    for limit, off in ((0.49, True), (0.51, False), (0.59, False), (0.61, True)):
        world = World(pull_in=lambda omega, limit=limit: limit + 0.0 * omega)
        between, _ = module.unknown_between(world, found, 2.0, set())
        assert bool(between.size) == off, limit


class Fractal(World):
    """A plane with a fractal border of chaos: from 1 to 1.08 a motion is chaotic or not by the last digits of its
    start, which the ``run`` differs in."""

    def __init__(self, run):
        super().__init__(chaos=lambda omega: np.ones(np.shape(omega)))
        self.run = run

    def examine(self, omegas, peaks, lower=None, *, yields=True, shift=0.0):
        found = super().examine(omegas, peaks, lower, yields=yields, shift=shift)
        last_digits = np.modf(np.abs(np.sin(1e7 * peaks + 1e11 * shift + 3e3 * self.run)) * 1e6)[0]
        return found | {"chaos": 1.0 * (peaks >= 1.0 + 0.08 * last_digits)}


def test_limits_at_a_fractal_border_are_as_wide_as_runs_from_starts_next_to_each_other_differ():
    k, ends = DRIVEN_LIMITS.index("chaos"), []
    for run in range(40):
        found = driven(Fractal(run), OMEGAS[:1], VOLTS, refine=False, progress=None)
        ends.append((found["low"][0, k], found["high"][0, k]))
    low, high = np.array(ends).T
    overlap = (low[:, None] <= high) & (low <= high[:, None])
    assert overlap.mean() > 0.95
    assert (high - low > 4.0 * 0.2 / PARTS**3).mean() > 0.5


def test_the_progress_counts_each_start_at_a_fractal_border():
    """Chaotic motions take nearly all of the time."""
    shares = []
    driven(Fractal(0), OMEGAS[:1], VOLTS, refine=False, progress=shares.append)
    assert sum(shares) == pytest.approx(1.0)
    narrowing = 0.4 * 0.9 / module.NARROWINGS
    assert np.isclose(shares, narrowing / (1 + len(module.SHIFTS))).sum() >= 1 + len(module.SHIFTS)
