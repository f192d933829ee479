"""Waveforms of pieces: certified motions; peaks and rates; corners; jumps; refusals."""

import numpy as np
import pytest

import gelcone
from gelcone.devices.device import Device, find_device
from gelcone.errors import InputError
from gelcone.motion.engine.backend import EngineBackend
from gelcone.motion.flow import integrate
from gelcone.motion.orbit import Kind, Shooting
from gelcone.motion.response import simulate
from gelcone.motion.settled import settled
from gelcone.physics.drive import Pieced, Pieces
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import (
    WAVEFORMS,
    Burst,
    Chirp,
    HalfWave,
    Harmonics,
    Samples,
    Staircase,
    Trapezoid,
    multisine,
    random_levels,
)
from tests.physics.film.test_branches import CERTIFIED, model_of

CASES = [case for case in CERTIFIED["cases"] if case["kind"] == "wave"]


def of_case(case):
    """The model of a certified case; the drive frequency is that of the repeat."""
    wave, more, omega = case["wave"], {}, case["wave"].get("omega")
    match wave["kind"]:
        case "trapezoid":
            drive, more = Trapezoid(), {name: wave[name] for name in ("rise", "high", "fall")}
        case "half wave":
            drive = HalfWave()
        case "chirp":
            drive, omega = Chirp(wave["sweep"]), 2.0 * np.pi / wave["duration"]
            more = {"start_frequency": wave["omega0"], "end_frequency": wave["omega1"]}
        case "burst":
            drive, omega = Burst(wave["cycles"], wave["period"]), omega / wave["period"]
        case "harmonics":
            drive = Harmonics(tuple(map(tuple, wave["terms"])))
        case "staircase":
            drive = Staircase(tuple(wave["levels"]), wave["rise"] / wave["hold"], repeat=False)
            omega = 2.0 * np.pi / (wave["hold"] * len(wave["levels"]))
        case "samples":
            last = wave["times"][-1]
            shares = tuple(time / last for time in wave["times"])
            drive = Samples(shares, tuple(wave["values"]), wave["interpolation"], wave["repeat"])
            omega = 2.0 * np.pi / last
    sine = {"kind": "sine", "v": wave.get("v", 1.0), "v0": wave.get("v0", 0.0), "omega": omega}
    return model_of(case | {"wave": sine}).replace(waveform=drive, **more)


@pytest.mark.parametrize("case", CASES, ids=[case["name"] for case in CASES])
def test_motions_and_works_are_the_certified_ones(case):
    rows = case["rows"]
    run = simulate(of_case(case), case["start"], times=[row["tau"] for row in rows])
    for name, of in {"displacement": "x", "velocity": "u", "drive_voltage": "film_voltage"}.items():
        np.testing.assert_allclose(run[name], [row[of] for row in rows], atol=1e-12)
    works = {"supplied_energy": "source"} | {name: name for name in rows[0] if name.endswith("_dissipation")}
    for name, of in works.items():
        found = run.get(name, 0.0)
        np.testing.assert_allclose(found, [row[of] for row in rows], atol=2e-12)
    assert float(abs(run["energy_residual"]).max()) < 1e-13


EVERY = [
    *(WAVEFORMS[name] for name in WAVEFORMS),
    Chirp("logarithmic", True),
    Samples(interpolation="pchip", repeat=True),
    multisine(2, 9, 5),
    random_levels(7, 3),
    Harmonics(((1, 1.0, 0.0), (1, 0.5, 2.0), (3, 0.2, 0.0))),
]


def numbers(waveform, bias=0.3):
    given = {"voltage": 1.3, "voltage_bias": bias, "drive_frequency": 0.6}
    return waveform.numbers(
        waveform.complete({name: given.get(name) or q.default for name, q in waveform.parameters.items()})
    )


@pytest.mark.parametrize("waveform", EVERY, ids=lambda one: f"{one.name}")
def test_peak_and_rate_are_those_of_the_voltage(waveform):
    n = numbers(waveform)
    period = float(waveform.period(n))
    tau = np.linspace(0.0, period, 200_001)
    voltage = waveform.voltage(tau, n)
    assert waveform.peak(n) == pytest.approx(np.abs(voltage).max(), rel=2e-4)
    smooth = np.abs(np.diff(voltage, 2)) < 1e-6
    middle = 0.5 * (tau[1:] + tau[:-1])[:-1][smooth]
    step = tau[1] - tau[0]
    rate = waveform.voltage_rate(middle, n)
    np.testing.assert_allclose(rate, (np.diff(voltage) / step)[:-1][smooth], atol=2e-3)


@pytest.mark.parametrize("bias", [-0.4, -2.0])
@pytest.mark.parametrize("waveform", EVERY, ids=lambda one: f"{one.name}")
def test_the_peak_counts_an_offset_of_either_sign(waveform, bias):
    n = numbers(waveform, bias)
    voltage = waveform.voltage(np.linspace(0.0, float(waveform.period(n)), 20_001), n)
    assert waveform.peak(n) == pytest.approx(np.abs(voltage).max(), rel=2e-3, abs=1e-12)


@pytest.mark.parametrize("waveform", EVERY, ids=lambda one: f"{one.name}")
def test_the_detail_counts_the_swings_of_a_repeat(waveform):
    """As many as it has maxima, or more, but not many times as many."""
    n = numbers(waveform)
    voltage = waveform.voltage(np.linspace(0.0, float(waveform.period(n)), 4001)[:-1], n)
    slopes = np.sign(np.diff(voltage, append=voltage[0]))
    slopes = slopes[slopes != 0.0]
    maxima = int(((slopes > 0.0) & (np.roll(slopes, -1) < 0.0)).sum())
    assert maxima <= waveform.detail(n) + 1e-9
    assert waveform.detail(n) <= 3.0 * maxima


def test_the_peak_of_a_cubic_may_lie_within_a_piece():
    class Hump(Pieced):
        """s - s^2/10 - s^3/200, which turns within its one piece."""

        name = "hump"

        def table(self, n):
            return Pieces(np.zeros(1), np.array([[0.0, 1.0, -0.1, -0.005, 0.0]]))

    hump = Hump()
    n = numbers(hump, 0.1)
    voltage = hump.voltage(np.linspace(0.0, float(hump.period(n)), 200_001)[:-1], n)
    assert hump.peak(n) == pytest.approx(np.abs(voltage).max(), rel=1e-4)
    inside, h = np.linspace(0.1, 6.2, 40) / n["drive_frequency"], 1e-6
    slope = (hump.voltage(inside + h, n) - hump.voltage(inside - h, n)) / (2.0 * h)
    np.testing.assert_allclose(hump.voltage_rate(inside, n), slope, atol=1e-8)


def test_a_multisine_has_the_peak_of_its_amplitude():
    assert multisine(2, 9, 5).peak(numbers(multisine(2, 9, 5), 0.0) | {"voltage_bias": 0.0}) == pytest.approx(
        1.3, rel=2e-3
    )


def test_a_run_shows_every_level_of_a_staircase():
    levels = tuple(np.random.default_rng(0).permutation(40) / 40.0)
    model = ConeModel(waveform=Staircase(levels, 0.1), voltage=0.5, damping_ratio=0.2)
    shown = simulate(model, periods=1)["drive_voltage"].values
    for level in levels:
        assert (np.abs(shown - 0.5 * level) < 1e-9).sum() >= 10


@pytest.mark.parametrize("name", ["square", "ramp", "half_wave", "burst", "staircase"])
def test_a_run_cut_anywhere_is_the_same_run(name):
    """The piece of a member is found anew at each start, also on a corner; and each member has its own."""
    model = ConeModel(waveform=name, voltage=[0.5, 0.4], voltage_bias=0.2, drive_frequency=[0.6, 0.7], rest_height=0.4)
    times = np.linspace(0.0, 30.0, 16)[1:]
    whole = integrate(model, (0.6, 0.0), times)
    corners = model.system.waveform.corners_between(np.zeros(2), np.full(2, 30.0), model.members().own_numbers).later
    for cut in (7.3, float(corners[0, 3])):
        first = integrate(model, (0.6, 0.0), [cut]).states[:, -1]
        rest = integrate(model, first, times[times > cut], start=cut)
        np.testing.assert_allclose(rest.states, whole.states[:, times > cut], atol=1e-12)
    alone = integrate(model.take([1]), (0.6, 0.0), times)
    assert (alone.states[0] == whole.states[1]).all()


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_what_a_source_loses_when_it_jumps_is_half_the_capacitance_times_the_squared_jump(film):
    """The balance closes; with a small resistance in between the same is lost there."""
    given = {"waveform": "square", "duty": 0.4, "rise": 0.0, "voltage": 0.3, "voltage_bias": 0.3, "film": film}
    model = ConeModel(**given, drive_frequency=0.4, rest_height=0.3, prestretch=1.2, damping_ratio=0.1)
    ideal = simulate(model, (0.4, 0.0), times=np.linspace(0.0, 40.0, 81))
    assert float(abs(ideal["energy_residual"]).max()) < 1e-12
    behind = simulate(model.replace(series_resistance=2e-3), (0.4, 0.0), times=np.linspace(0.0, 40.0, 81))
    assert float(ideal["resistor_dissipation"][-1]) > 0.5
    charging = 0.5 * 1.16 * 0.36  # behind the resistance the film starts without charge
    lost = float(behind["resistor_dissipation"][-1]) - charging
    assert lost == pytest.approx(float(ideal["resistor_dissipation"][-1]), rel=0.02)
    assert np.isinf(ideal["peak_slew_rate"])
    for name in ("peak_current", "rms_current", "apparent_power"):
        assert np.isinf(ideal[name])
        assert np.isfinite(behind[name])
    assert "peak and rms current of the ideal source are infinite" in ideal.gelcone.words()
    assert "infinite" not in behind.gelcone.words()
    assert np.isinf(gelcone.settled(model)["apparent_power"])
    if film == "taut":  # v C with C = 1 + x^2
        charges = abs(ideal["drive_voltage"] * (1.0 + ideal["displacement"] ** 2))
        assert float(ideal["peak_charge"]) == pytest.approx(float(charges.max()), rel=1e-12)


def test_shooting_over_pieces_has_the_derivatives_of_differences():
    model = ConeModel(waveform="half_wave", voltage=0.6, voltage_bias=0.2, drive_frequency=0.5, rest_height=0.4)
    shooting = Shooting(model.members(), ("voltage", "voltage_bias"), Kind(1), 4, 2.0 * np.pi)
    nodes, values, step = np.tile([0.6, 0.0], (4, 1)), np.array([0.6, 0.2]), 1e-6
    found = shooting.run(nodes, values)
    slopes, tangents = found.slopes.copy(), found.tangents.copy()
    for k, row in enumerate(step * np.eye(2)):
        ahead, behind = (shooting.run(nodes, values + sign * row).ends.copy() for sign in (1.0, -1.0))
        np.testing.assert_allclose(slopes[..., k], (ahead - behind) / (2.0 * step), atol=1e-8)
        ahead, behind = (shooting.run(nodes + sign * row, values).ends.copy() for sign in (1.0, -1.0))
        np.testing.assert_allclose(tangents[..., k], (ahead - behind) / (2.0 * step), atol=1e-8)
    with pytest.raises(InputError, match="duty: shapes the drive's pieces; a branch cannot follow it"):
        Shooting(ConeModel(waveform="square").members(), ("duty",), Kind(1), 4, 2.0 * np.pi)


@pytest.mark.parametrize(
    ("analysis", "given"),
    [
        *(
            (name, ())
            for name in ("section", "extrema", "lyapunov", "regime", "settled", "envelope", "operating_limits")
        ),
        ("bifurcation", ("voltage", [0.1, 0.3])),
        ("frequency", ([0.5, 0.6],)),
        ("basin", ({"displacement": [0.0, 1.0], "velocity": [0.0, 1.0]},)),
        ("map", ({"voltage": [0.1, 0.2], "damping_ratio": [0.1, 0.2]},)),
        ("continue_branch", ("voltage", 0.1, 0.3)),
        ("locus", ("fold", {"drive_frequency": (0.8, 1.2), "voltage": (0.2, 0.6)})),
    ],
)
def test_every_analysis_of_periodic_drives_refuses_one_that_does_not_repeat(monkeypatch, analysis, given):
    def run(*_, **__):
        raise AssertionError("it runs")

    monkeypatch.setattr(EngineBackend, "run", run)
    model = ConeModel(waveform="chirp", rest_height=0.4, damping_ratio=0.1, voltage_bias=0.2)
    with pytest.raises(InputError, match=r"waveform = chirp: does not repeat.*or simulate it"):
        getattr(gelcone, analysis)(model, *given)


def test_a_drive_that_does_not_repeat_is_refused_before_anything_runs():
    model = ConeModel(waveform="chirp", rest_height=0.4)
    with pytest.raises(InputError, match="waveform = chirp: does not repeat, and this needs a drive that does"):
        settled(model)
    with pytest.raises(InputError, match="waveform = chirp: does not repeat"):
        settled(model.replace(series_resistance=0.5))  # whose period is that of the voltage itself
    assert int(settled(model.replace(waveform=Chirp(repeat=True)))["outcome"]) == 0
    run = simulate(model)
    assert float(run["time"][-1]) == pytest.approx(2.0 * np.pi)
    after = simulate(model, periods=2)
    last = after["drive_voltage"].sel(time=slice(2.0 * np.pi, None))
    np.testing.assert_allclose(last, float(last[0]), atol=1e-14)


@pytest.mark.parametrize("waveform", WAVEFORMS)
def test_the_samples_of_members_are_those_of_each(waveform):
    members = ConeModel(waveform=waveform, voltage=[0.5, 0.7], voltage_bias=[0.1, 0.2]).members()
    both = members.system.waveform.samples(members.own_numbers)
    for row in range(2):
        one = ConeModel(waveform=waveform, voltage=(0.5, 0.7)[row], voltage_bias=(0.1, 0.2)[row])
        assert both[row].tolist() == one.system.waveform.samples(one.own_numbers).tolist()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"waveform": "trapezoid", "rise": 0.6, "high": 0.5}, r"rise \+ high \+ fall = 1.2: are shares of one repeat"),
        ({"waveform": "square", "duty": 0.01}, "duty = 0.01: must be from rise = 0.02 to 1 - rise"),
        ({"waveform": "ramp", "fall": 1.5}, "fall = 1.5: is a share"),
        ({"waveform": {"component": "burst", "cycles": 5}}, "burst of 5 cycles in 5: must be whole numbers"),
        ({"waveform": {"component": "chirp", "sweep": "quadratic"}}, "'quadratic' is not a sweep of a chirp"),
        ({"waveform": {"component": "harmonics", "terms": [[0, 1.0, 0.0]]}}, "triples"),
        ({"waveform": {"component": "samples", "shares": [0.0, 1.0], "values": [0.0]}}, "as many as shares"),
        (
            {"waveform": {"component": "samples", "shares": [0.0, 0.7, 0.5, 1.0], "values": [0, 1, 2, 0]}},
            "must increase",
        ),
        (
            {"waveform": {"component": "samples", "shares": [0.0, 1.0], "values": [0.0, 0.5], "repeat": True}},
            "0.5 at the end, 0 at the start: repeated they would jump; add a last sample",
        ),
        ({"waveform": "sine", "duty": 0.5}, "duty: is a parameter of the waveform 'square', which this model has not"),
        ({"waveform": {"component": "chirp", "repeat": "no"}}, "chirp: repeat = 'no' must be true or false"),
        ({"waveform": {"component": "staircase", "levels": "abc"}}, "staircase"),
        ({"waveform": {"component": "harmonics", "terms": 5}}, "harmonics"),
    ],
)
def test_what_a_waveform_cannot_be_is_refused(given, message):
    with pytest.raises(InputError, match=message) as raised:
        ConeModel(**given)
    assert len(str(raised.value).splitlines()) == 1


def test_a_device_is_driven_by_waveforms_in_si_units():
    pump = find_device("biased-pump").replace(film="wrinkling")
    square = pump.replace({"waveform": "square", "waveform.duty": 0.3})
    assert square.to_model().duty == 0.3
    assert Device.from_text(square.to_toml()) == square
    chirp = pump.replace({"waveform": "chirp", "waveform.end_frequency": "20 Hz", "frequency": "0.5 Hz"})
    assert chirp.to_model().end_frequency == pytest.approx(20.0 / chirp.scales.frequency)
    assert Device.from_text(chirp.to_toml()) == chirp
    burst = pump.replace(waveform={"component": "burst", "cycles": 2, "period_in_cycles": 4})
    assert Device.from_text(burst.to_toml()) == burst
    run = simulate(burst, periods=2)
    assert float(run["drive_voltage"].max()) == pytest.approx(1470.0, rel=1e-3)


def test_the_shares_of_a_repeat_may_add_up_to_all_of_it():
    own = WAVEFORMS["trapezoid"]
    assert own.complete({"rise": 0.25, "high": 0.5, "fall": 0.25})["fall"] == 0.25
    with pytest.raises(InputError, match=r"rise \+ high \+ fall = 1.01"):
        own.complete({"rise": 0.26, "high": 0.5, "fall": 0.25})
