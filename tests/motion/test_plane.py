"""The plane of drive frequency and peak voltage: what it asks of its parts, and what it hands on."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.codes import Regime
from gelcone.errors import InputError
from gelcone.motion import envelope
from gelcone.motion import plane as module
from gelcone.motion.attractor.search import patience_of, transient_of
from gelcone.motion.electrical import charge_of, field_of
from gelcone.motion.plane import DRIVEN_LIMITS, DriveShape
from gelcone.physics.model import ConeModel
from tests.recorded import numbers, record

FLAT = ConeModel(damping_ratio=0.1, voltage=1.2, spring_stiffness=0.5)


def plane_of(model=FLAT, limits_from="rest", threads=5, membrane=None, bias=0.25):
    return module.Plane(model, module.DriveShape(0.75, bias), 0.5, threads, membrane, limits_from)


@pytest.mark.parametrize(
    ("drive", "message"),
    [
        ({"voltage": 0.0}, "voltage = 0: here the device's drive is scaled; give it an amplitude"),
        ({"waveform": "half_wave", "voltage": 0.5, "voltage_bias": -0.6}, "voltage_bias = -0.6: the drive stays"),
    ],
)
def test_a_drive_that_stays_at_0_cannot_be_scaled(drive, message):
    with pytest.raises(InputError, match=message):
        DriveShape.of(ConeModel(**drive))


def test_a_plane_scales_amplitude_and_bias_with_the_peak(monkeypatch):
    model = plane_of().at(np.array([0.5, 0.9]), np.array([0.4, 0.8]))
    assert model.drive_frequency.tolist() == [0.5, 0.9]
    np.testing.assert_allclose(model.voltage, [0.3, 0.6])
    np.testing.assert_allclose(model.voltage_bias, [0.1, 0.2])
    asked = record(monkeypatch, module, driven_frequency=2.0, drive_ramp="ramp", every_balance=["balance"])
    assert plane_of().natural_frequency(0.8) == 2.0
    drive = asked["driven_frequency"][0]["model"]
    assert (drive.voltage, drive.voltage_bias) == pytest.approx((0.6, 0.2))
    plane = plane_of()
    assert [plane.ramp("levels"), plane.ramp("more")] == ["ramp", "ramp"]
    assert asked["every_balance"] == [{"model": FLAT, "bias_share": 0.25}]
    assert asked["drive_ramp"] == [{"balance": "balance", "levels": levels} for levels in ("levels", "more")]


@pytest.mark.parametrize("bias", [0.1, -0.1, -0.4])
def test_on_the_ramp_of_the_peak_films_have_the_voltages_that_the_drive_has_at_its_peak(bias):
    """A staircase from 0 to 0.5 about a bias of either sign peaks with that sign or with the other."""
    pair = {"second_film": "taut", "second_drive": "opposite", "second_flat_height": 1.4}
    model = ConeModel(**pair, waveform="staircase", voltage=0.5, voltage_bias=bias)
    first, second = model.members().voltages(
        np.linspace(0.0, model.members().drive_period[()], 400)[None], np.zeros((1, 400, 2))
    )
    at = np.argmax(np.abs(first))
    ramp = module.Plane.of(model, None).ramp(np.array([np.abs(first).max()]))
    np.testing.assert_allclose(ramp.voltages, np.abs([first.flat[[at]], second.flat[[at]]]), rtol=1e-12)


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


def test_motions_are_followed_for_the_patience_given_or_briefly():
    """For 32 transients, or the default of `regime` where that is less."""
    members = FLAT.replace(drive_frequency=[1.0, 1e-3]).members()
    plane, transient = plane_of(), transient_of(members, None)
    assert plane._budget(members) == {}
    assert replace(plane, patience=70.0, brief=True)._budget(members) == {"patience": 70.0}
    longest = np.minimum(32.0 * transient, patience_of(members, None))
    np.testing.assert_array_equal(replace(plane, brief=True)._budget(members)["patience"], longest)
    assert longest[0] == 32.0 * transient[0] < 1e5


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
    final, regime, outcome, found = plane_of()._settle(members, start, classified)
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
    assert found.cycles.attracting.tolist() == [True, True, False, False, False]
    assert found.courses == ["course"]


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
    found = plane_of()._observe(members, states, np.array([0.0, 0.0, 60.0, 0.0]), yields=True)
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
    plane_of()._observe(members, states, 0.0, yields=False)
    assert {run["keep"] for run in runs} == {"states"}


def test_a_run_fails_where_either_film_does_and_pulls_in_by_the_curve_of_the_plane(monkeypatch):
    """The membrane is the first film's, where the model has none."""
    first = {"hoop_slack": [[-1.0, 2.0, -1.0], [-1.0, -1.0, -1.0]]}
    second = {"hoop_slack": [[-1.0, -1.0, -1.0], [-1.0, -1.0, 0.5]], "near_limit": [[-1.0] * 3, [-1.0, 1.0, -1.0]]}
    films = [{name: np.array(values) for name, values in film.items()} for film in (first, second)]
    record(monkeypatch, module, violations=lambda members, states, voltages: [dict(film) for film in films])
    members = SimpleNamespace(
        size=2, system=SimpleNamespace(films=[SimpleNamespace(kinds=())] * 2),
        voltages=lambda times, states: [np.array([[1.0, 2.0, 1.0], [1.0, 1.0, 1.0]]), np.full((2, 3), 9.0)],
    )  # fmt: skip
    run = SimpleNamespace(times=None, states=np.zeros((2, 3, 2)) + 0.5, film_times=np.zeros((2, 2, 1)))
    membrane = SimpleNamespace(voltage=lambda x: 1.0 + x)
    found = plane_of(membrane=membrane)._fails(members, run)
    assert found["hoop_slack"].tolist() == [1.0, 1.0]
    assert found["near_limit"].tolist() == [0.0, 1.0]
    assert found["beyond_membrane"].tolist() == [1.0, 0.0]
    assert np.isnan(found["breakdown"]).all()
    assert np.isnan(plane_of()._fails(members, run)["beyond_membrane"]).all()
    films[1]["beyond_membrane"] = np.array([[-1.0] * 3, [-1.0, 0.1, -1.0]])
    assert plane_of()._fails(members, run)["beyond_membrane"].tolist() == [0.0, 1.0]
    films[0]["beyond_membrane"] = np.array([[-0.5] * 3] * 2)
    assert plane_of(membrane=membrane)._fails(members, run)["beyond_membrane"].tolist() == [0.0, 1.0]


@pytest.mark.parametrize("waveform", ["sine", "triangle"])
def test_yields_are_means_over_the_run_and_the_largest_of_either_film(monkeypatch, waveform):
    """The second motion's voltage jumps."""
    times = np.tile(np.arange(0.0, 121.0), (2, 1)) * [[0.5], [0.25]]
    states, work = numbers(2, 121, 2, at=3.0), numbers(2, 121, 3, at=4.0)
    model = ConeModel(damping_ratio=0.1, voltage=[0.1, 0.2], second_film="taut", second_drive="opposite")
    members = model.replace(waveform=waveform).members()
    causes = list(members.system.causes)
    work = numbers(2, 121, len(causes), at=4.0)
    fields = [numbers(2, 121, at=6.0), numbers(2, 121, at=5.0)]
    fields[1][1, 7] = 9.0
    jumps, asked_fields = np.array([0.0, 0.5]), [SimpleNamespace(true_field=field) for field in fields]
    monkeypatch.setattr(type(members), "film_states", lambda own, states, voltages: asked_fields)
    asked = record(
        monkeypatch, module, dissipated_energy=numbers(2, 121, at=7.0), heat_of=numbers(2, 121, at=8.0),
        lost_in_jumps=jumps,
        apparent_power=np.array([11.0, 12.0]), between_corners="path", largest=np.array([0.0, 29.0]),
        extent=(np.array([0.25, 0.5]), np.array([1.0, 1.75])),
    )  # fmt: skip
    charges = [numbers(2, 121), -numbers(2, 121, at=2.0)]
    monkeypatch.setattr(type(members.system), "source_charges", lambda own, times, z, n: charges)
    run = SimpleNamespace(times=times, states=states, work=work)
    found = module._yields(members, run, 10, tolerance=2e-9, threads=5)
    lasts = np.array([60.0, 30.0])
    np.testing.assert_allclose(found["stroke"], [0.75, 1.25])
    np.testing.assert_allclose(found["power"], (numbers(2, 121, at=7.0)[:, -1] + jumps) / lasts)
    np.testing.assert_allclose(found["damper_power"], work[:, -1, causes.index("damper")] / lasts)
    np.testing.assert_allclose(found["heating"], numbers(2, 121, at=8.0)[:, -1] / lasts)
    np.testing.assert_array_equal(found["apparent_power"], [11.0, np.inf])
    np.testing.assert_array_equal(found["field"], [fields[0][0].max(), 29.0])
    np.testing.assert_array_equal(found["peak_charge"], [numbers(2, 121, at=2.0)[0].max(), 29.0])
    for call in asked["largest"]:
        if waveform == "sine":  # over four periods, with 64 samples in each
            np.testing.assert_allclose(call["path"].times, times[:, 40:41] * np.arange(1, 257) / 256)
            np.testing.assert_array_equal(call["path"].begin, states[:, 0])
            np.testing.assert_array_equal(call["path"].end, times[:, 40])
        else:
            assert call["path"] == "path"
            np.testing.assert_array_equal(asked["between_corners"][0]["spans"], times[:, 40])
    assert [call["value"] for call in asked["largest"]] == [charge_of, field_of]
    (jumped,) = asked["lost_in_jumps"]
    np.testing.assert_array_equal(jumped["begin"], states[:, 0])
    np.testing.assert_array_equal(jumped["spans"], lasts)
    assert (jumped["tolerance"], jumped["threads"]) == (2e-9, 5)


def test_a_film_that_falls_slack_bounds_a_double_cone_in_either_place():
    """A double cone and its mirror image, whose second film wrinkles: its slack meridians count as those of the
    first."""
    height, wrinkling = 0.0828, {"hoop_prestretch": 1.525, "meridional_prestretch": 1.0027}
    taut = {"hoop_prestretch": 1.369, "meridional_prestretch": 1.103}
    rest = {True: -0.3142, False: height + 0.3142}
    flags = []
    for taut_first in (True, False):
        first, second = (taut, wrinkling) if taut_first else (wrinkling, taut)
        films = ("taut", "wrinkling") if taut_first else ("wrinkling", "taut")
        model = ConeModel(
            film=films[0], second_film=films[1], second_drive="same", second_flat_height=height, drive_frequency=2.136,
            damping_ratio=0.495, spring_stiffness=1.311, rest_height=rest[taut_first], voltage=0.276,
            voltage_bias=-0.17, **first, **{f"second_{name}": value for name, value in second.items()},
        )  # fmt: skip
        plane = envelope.plane_of(model, 1)
        found = plane.examine(np.full(3, 2.136), np.array([0.75, 0.83, 0.95]))
        flags.append(found["meridional slack"].tolist())
    assert flags == [[0.0, 1.0, 1.0]] * 2
