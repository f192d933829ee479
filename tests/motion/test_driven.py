"""The search for driven limits, in made-up planes whose limits are known functions of the frequency."""

from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.motion import driven as module
from gelcone.motion.driven import DRIVEN_LIMITS, NARROWEST, PARTS, WITHIN, YIELDS, driven, rows_of
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

    def examine(self, omegas, peaks, lower=None, *, yields=True):
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
    plane = module.Plane(model, module.DriveShape(0.5, 0.5), 0.3, None)
    natural, loaded = plane.natural_frequency(), plane.natural_frequency(1.2)
    assert loaded < 0.95 * natural
    found = plane.default_frequencies(1.2)
    for wanted in (0.77, *np.outer((0.5, 1.0, 2.0), (natural, loaded)).ravel()):
        assert np.abs(found / wanted - 1.0).min() <= module.TOO_CLOSE
    at = [k for k in range(found.size) if np.isclose(found[k], [0.77, natural, loaded]).any()]
    assert len(at) == 3  # these three to the last digit
    assert (found[1:] / found[:-1]).min() > 1.0 + 0.9 * module.TOO_CLOSE


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
    monkeypatch.setattr(module, "are_slow", lambda members: members.time_constant > 1e3)
    found = module.Plane._transient(members, module._Drifts(np.array(known), []))
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
    plane = module.Plane(flat, module.DriveShape(0.8, 0.0), 0.0, None)
    low, high = module._onset(plane, np.array([0.5, 0.9]), 2.5)
    np.testing.assert_allclose(low, [0.75, np.inf])
    np.testing.assert_allclose(high, [0.7875, np.inf])
    np.testing.assert_array_equal(asked["omegas"], [0.5, 0.9])
    assert asked["highest"] == pytest.approx(2.0)
    for other in (module.DriveShape(0.8, 0.2), None):
        model = flat if other else flat.replace(rest_height=0.5)
        plane = module.Plane(model, other or module.DriveShape(1.0, 0.0), 0.0, None)
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
    np.testing.assert_allclose(module._highest(x), [top, 1.0, 0.2], atol=1e-12)


# --- what is handed on ------------------------------------------------------------------------------------------------

FLAT = ConeModel(damping_ratio=0.1, voltage=1.2, spring_stiffness=0.5)


def plane_of(model=FLAT, limits_from="rest", threads=5, membrane=None, bias=0.25):
    return module.Plane(model, module.DriveShape(0.75, bias), 0.5, threads, membrane, limits_from)


def test_a_plane_scales_amplitude_and_bias_with_the_peak(monkeypatch):
    model = plane_of().at(np.array([0.5, 0.9]), np.array([0.4, 0.8]))
    assert model.drive_frequency.tolist() == [0.5, 0.9]
    np.testing.assert_allclose(model.voltage, [0.3, 0.6])
    np.testing.assert_allclose(model.voltage_bias, [0.1, 0.2])
    asked = record(monkeypatch, module, stiffness_under=4.0, drive_ramp="ramp")
    assert plane_of().natural_frequency(0.8) == 2.0
    drive = asked["stiffness_under"][0]["model"]
    assert (drive.voltage, drive.voltage_bias) == pytest.approx((0.6, 0.2))
    assert plane_of().ramp("levels") == "ramp"
    assert asked["drive_ramp"] == [{"model": FLAT, "levels": "levels", "bias_share": 0.25}]


@pytest.mark.parametrize("limits_from", ["rest", "settled", "both"])
@pytest.mark.parametrize("with_lower", [False, True])
def test_from_rest_and_from_lower_peaks_are_examined_as_the_limits_ask(monkeypatch, limits_from, with_lower):
    """Of both the larger of each limit counts, the next peak starts from the motion that rose slowly, and the rest is
    that of the motion from rest."""
    calls, lower = [], numbers(3, 2, at=3.0) if with_lower else None
    met = {"rest": [1.0, 0.0, 0.0], "slow": [0.0, 1.0, 0.0]}

    def examine(plane, model, start, yields, transient=False):
        rows = np.isin([0.5, 0.6, 0.7], np.ravel(model.drive_frequency))
        from_rest = start[0, 0] == 0.5 + module.NUDGE
        calls.append(("rest" if from_rest else "slow", start.tolist(), yields, transient))
        own = np.array(met["rest" if from_rest else "slow"])[rows]
        found = dict.fromkeys(DRIVEN_LIMITS[:-1], own)
        return found | {"final": start + 10.0 * from_rest, "stroke": own + 5.0 + from_rest}

    monkeypatch.setattr(module.Plane, "_examine", examine)
    monkeypatch.setattr(module, "CHUNK", 2)
    found = plane_of(limits_from=limits_from).examine(
        np.array([0.5, 0.6, 0.7]), np.array([0.1, 0.2, 0.3]), lower, yields=False
    )
    slow, rest = limits_from != "rest" and with_lower, limits_from == "both" or limits_from == "rest" or not with_lower
    starts = [[[0.5 + module.NUDGE, 0.0]] * 2, [[0.5 + module.NUDGE, 0.0]]]
    expected = []
    for part, rows in enumerate((slice(0, 2), slice(2, 3))):
        expected += [("slow", lower[rows].tolist(), False, False)] if slow else []
        expected += [("rest", starts[part], False, limits_from != "settled")] * rest
    assert calls == expected
    both = np.maximum(met["slow"], met["rest"])
    for name in DRIVEN_LIMITS[:-1]:
        np.testing.assert_array_equal(found[name], both if slow and rest else met["slow" if slow else "rest"], name)
    at_rest = np.array([[10.5 + module.NUDGE, 10.0]] * 3)
    np.testing.assert_array_equal(found["final"], lower if slow else at_rest)
    np.testing.assert_array_equal(found["stroke"], np.array(met["rest"]) + 6.0 if rest else np.array(met["slow"]) + 5.0)


class Found:
    """A search whose motions are given."""

    def __init__(self, **given):
        self.given = given
        self.cycles = SimpleNamespace(attracting=np.array(given["attracting"]), resting=np.array(given["resting"]))
        self.starts = SimpleNamespace(
            state=np.stack([given["state"], given["state"] + 50.0], axis=1), outcome=np.array([given["outcome"],
            [9] * 5]).T,
            period=np.array([given["period"], [0] * 5]).T, apart=np.array(given["apart"]),
        )  # fmt: skip
        self.courses, self.begun = ["course"], []

    def begin(self, rows, durations, patience):
        self.begun.append((rows.tolist(), durations.tolist(), patience))


@pytest.mark.parametrize("classified", [False, True])
def test_where_motions_settle_is_by_their_cycles_else_by_their_kind(monkeypatch, classified):
    """A cycle, rest, a failure, a motion without a period, and one that returns but is slow: only what is unclear is
    classified, the slow one from where it has come to, with no more patience than the disc needs."""
    search = Found(
        attracting=[True, True, False, False, False], resting=[False, True, False, False, False], state=numbers(5, 2,
        at=4.0),
        outcome=[0, 0, 3, 0, 0], period=[1, 1, 0, 0, 2], apart=[np.nan] * 5,
    )  # fmt: skip
    made = []

    def classify(members, states, **options):
        count = members.size
        made.append((members.number("voltage").tolist(), states.tolist(), options))
        return SimpleNamespace(
            final=states + 100.0, regime=np.full(count, Regime.CHAOTIC), outcome=np.full(count, len(made))
        )

    slow = np.array([False, False, False, False, True])
    asked = record(
        monkeypatch, module, Search=lambda *given, **options: search, classify=classify, are_slow=slow,
        transient_of_the_disc=np.array([10.0, 20.0, 30.0, 40.0, 50.0]), transient_of=numbers(5, at=1e4),
    )  # fmt: skip
    members = FLAT.replace(voltage=[0.1, 0.2, 0.3, 0.4, 0.5]).members()
    start = numbers(5, 2)
    final, regime, outcome, drifts = plane_of()._settle(members, start, classified)
    flow = {"tolerance": module.TOLERANCE, "threads": 5}
    (searched,) = asked["Search"]
    assert {name: searched[name] for name in flow} == flow
    ((rows, durations, patience),) = search.begun
    assert rows == ([4] if classified else [0, 1, 2, 3, 4])
    np.testing.assert_allclose(durations, [*numbers(5, at=1e4)[:4], module.LONGEST_WAIT * 50.0])
    assert patience == 1.0
    unsure = [0.4, 0.5] if classified else [0.4]
    assert [voltage for call in made for voltage in call[0]] == unsure
    assert made[0][1] == [start[3].tolist()]
    assert made[0][2] == flow
    if classified:
        assert made[1][1] == [search.given["state"][4].tolist()]
        assert made[1][2] == flow | {"transient": 50.0, "patience": module.PATIENCE}
    ends = numbers(5, 2, at=4.0)
    ends[3] = start[3] + 100.0
    ends[4] += 100.0 * classified
    np.testing.assert_allclose(final, ends)
    kinds = [Regime.PERIODIC, Regime.REST, Regime.LEFT_THE_DOMAIN, Regime.CHAOTIC]
    assert regime.tolist() == [*kinds, Regime.CHAOTIC if classified else Regime.PERIODIC]
    assert outcome.tolist() == [0, 0, 3, 1, 2 * classified]
    assert drifts.known.tolist() == [True, True, False, False, False]
    assert drifts.courses == ["course"]


def test_what_a_motion_fails_in_and_yields_is_sampled_over_enough_drive_periods(monkeypatch):
    """16 samples of a period at least, 12 periods, and as many times 12 as last long enough; each group of equal
    sampling is run by itself, in blocks."""
    runs = []

    def fails(plane, members, run):
        return {"hoop_slack": members.number("voltage") + 1.0}

    def yields_of(members, run, samples, **flow):
        runs[-1]["yields"] = samples, flow
        return {"stroke": members.number("voltage") + 2.0}

    def ran(members, states, times, **options):
        runs.append(options | {"states": states.tolist(), "times": times})
        return "run"

    record(monkeypatch, module, integrate=ran, _yields=yields_of)
    monkeypatch.setattr(module.Plane, "_fails", fails)
    monkeypatch.setattr(module, "BLOCK_SAMPLES", 16 * 12 * 2)
    voltage, states = np.array([0.1, 0.2, 0.3, 0.4]), numbers(4, 2)
    members = FLAT.replace(voltage=voltage, drive_frequency=2.0 * np.pi / np.array([1.0, 1.0, 2.0, 1.0])).members()
    members.rate = np.array([1.0, 1.0, 1.0, 30.0])
    period = np.ravel(members.drive_period)
    found = plane_of()._look(members, states, np.array([0.0, 0.0, 60.0, 0.0]), yields=True)
    np.testing.assert_allclose(found["hoop_slack"], voltage + 1.0)
    np.testing.assert_allclose(found["stroke"], voltage + 2.0)
    by_start = {row[0]: run for run in runs for row in run["states"]}
    for k, (samples, turns) in enumerate(((16, 12), (16, 12), (16, 48), (64, 12))):
        run = by_start[states[k, 0]]
        row = [state[0] for state in run["states"]].index(states[k, 0])
        np.testing.assert_allclose(run["times"][row], period[k] * np.arange(samples * turns + 1) / samples)
        assert (run["keep"], run["tolerance"], run["threads"]) == ("work", module.TOLERANCE, 5)
        assert run["yields"] == (samples, {"tolerance": module.TOLERANCE, "threads": 5})
    runs.clear()
    plane_of()._look(members, states, 0.0, yields=False)
    assert {run["keep"] for run in runs} == {"states"}


def test_a_run_fails_where_either_film_does_and_pulls_in_by_the_curve_of_the_plane(monkeypatch):
    """The membrane is the first film's."""
    first = {"hoop_slack": [[-1.0, 2.0, -1.0], [-1.0, -1.0, -1.0]], "beyond_membrane": [[9.0] * 3] * 2}
    second = {"hoop_slack": [[-1.0, -1.0, -1.0], [-1.0, -1.0, 0.5]], "near_limit": [[-1.0] * 3, [-1.0, 1.0, -1.0]]}
    films = [{name: np.array(values) for name, values in film.items()} for film in (first, second)]
    record(monkeypatch, module, excesses=lambda members, states, voltages: [dict(film) for film in films])
    members = SimpleNamespace(
        size=2, system=SimpleNamespace(film=SimpleNamespace(kinds=())),
        voltages=lambda times, states: [np.array([[1.0, 2.0, 1.0], [1.0, 1.0, 1.0]]), np.full((2, 3), 9.0)],
    )  # fmt: skip
    run = SimpleNamespace(times=None, states=np.zeros((2, 3, 2)) + 0.5)
    membrane = SimpleNamespace(voltage=lambda x: 1.0 + x)
    found = plane_of(membrane=membrane)._fails(members, run)
    assert found["hoop_slack"].tolist() == [1.0, 1.0]
    assert found["near_limit"].tolist() == [0.0, 1.0]
    assert found["beyond_membrane"].tolist() == [1.0, 0.0]
    assert np.isnan(found["breakdown"]).all()
    assert np.isnan(plane_of()._fails(members, run)["beyond_membrane"]).all()


def test_yields_are_means_over_the_run_and_the_largest_of_either_film(monkeypatch):
    """The second motion's voltage jumps."""
    times = np.tile(np.arange(0.0, 121.0), (2, 1)) * [[0.5], [0.25]]
    states, work = numbers(2, 121, 2, at=3.0), numbers(2, 121, 3, at=4.0)
    members = ConeModel(damping_ratio=0.1, voltage=[0.1, 0.2], second_film="taut", second_drive="opposite").members()
    causes = list(members.system.causes)
    work = numbers(2, 121, len(causes), at=4.0)
    fields = [numbers(2, 121, at=6.0), numbers(2, 121, at=5.0)]
    fields[1][1, 7] = 9.0
    jumps, asked_fields = np.array([0.0, 0.5]), [SimpleNamespace(true_field=field) for field in fields]
    monkeypatch.setattr(type(members), "film_states", lambda own, states, voltages: asked_fields)
    asked = record(
        monkeypatch, module, dissipated_energy=numbers(2, 121, at=7.0), heat_of=numbers(2, 121, at=8.0),
        lost_in_jumps=jumps,
        apparent_power=np.array([11.0, 12.0]), extent=(np.array([0.25, 0.5]), np.array([1.0, 1.75])),
    )  # fmt: skip
    charges = [numbers(2, 20), -numbers(2, 20, at=2.0)]
    monkeypatch.setattr(type(members.system), "source_charges", lambda own, times, z, n: charges)
    run = SimpleNamespace(times=times, states=states, work=work)
    found = module._yields(members, run, 10, tolerance=2e-9, threads=5)
    lasts = np.array([60.0, 30.0])
    np.testing.assert_allclose(found["stroke"], [0.75, 1.25])
    np.testing.assert_allclose(found["power"], (numbers(2, 121, at=7.0)[:, -1] + jumps) / lasts)
    np.testing.assert_allclose(found["damper_power"], work[:, -1, causes.index("damper")] / lasts)
    np.testing.assert_allclose(found["heating"], numbers(2, 121, at=8.0)[:, -1] / lasts)
    np.testing.assert_array_equal(found["apparent_power"], [11.0, np.inf])
    np.testing.assert_array_equal(found["field"], [fields[0][0].max(), 9.0])
    np.testing.assert_array_equal(found["peak_charge"], numbers(2, 20, at=2.0).max(axis=1))
    (jumped,) = asked["lost_in_jumps"]
    np.testing.assert_array_equal(jumped["begin"], states[:, 0])
    np.testing.assert_array_equal(jumped["spans"], lasts)
    assert (jumped["tolerance"], jumped["threads"]) == (2e-9, 5)
    assert asked["apparent_power"][0]["times"].shape == (2, 20)


def test_frequencies_between_are_looked_for_below_the_ceiling_alone_and_around_the_lower_limit(monkeypatch):
    asked = record(monkeypatch, module, unknown_between=(np.empty(0), np.empty(0)), rows_of={"frequency": OMEGAS})
    for ceiling, highest in ((0.75, 0.75), (9.0, 2.0)):
        driven(World(), OMEGAS, VOLTS, refine=True, progress=None, ceiling=ceiling)
        assert asked["unknown_between"][-1]["ceiling"] == highest
    monkeypatch.undo()
    monkeypatch.setattr(module, "_onset", lambda plane, omegas, highest: (np.nan, np.nan))
    low = np.full((2, len(DRIVEN_LIMITS)), np.inf)
    low[:, 0] = 0.5, 1.5
    found = {"frequency": np.array([0.8, 1.25]), "low": low, "final_below": numbers(2, 2)}
    between, around = module.unknown_between(World(pull_in=lambda omega: 0.3 + 0.0 * omega), found, 2.0, set())
    assert (between.tolist(), around.tolist()) == ([pytest.approx(1.0)], [0.5])
