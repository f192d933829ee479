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
from gelcone.physics.drive import PHASE_SPEED, Pieced, Pieces
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
from gelcone.quantity import LARGEST
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


@pytest.mark.parametrize("bias", [0.0, 0.3, -0.4])
@pytest.mark.parametrize("waveform", EVERY, ids=lambda one: f"{one.name}")
def test_an_amplitude_reaches_the_peak_that_it_is_asked_for(waveform, bias):
    n = numbers(waveform, bias)
    found = waveform.amplitude_at(n, 1.7)
    assert waveform.peak({**n, "voltage": found}) == pytest.approx(1.7, rel=2e-3 if bias else 1e-9)
    assert np.isnan(waveform.amplitude_at(n, np.nan))
    assert waveform.amplitude_at(n, np.inf) == np.inf


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
        (
            {"waveform": {"component": "samples", "shares": [0.0, 0.8], "values": [0.0, 1.0]}},
            "samples: shares end at 0.8 of the repeat, and must end at 1; add 1.0 with its value",
        ),
        (
            {"waveform": {"component": "samples", "shares": [0.2, 1.0], "values": [0.0, 1.0]}},
            "samples: shares begin at 0.2 of the repeat, and must begin at 0; add 0.0 with its value",
        ),
        (
            {"waveform": {"component": "samples", "shares": [0.0, 50.0], "values": [0.0, 1.0]}},
            "samples: shares end at 50 of the repeat, and must end at 1; scale them from 0 to 1",
        ),
        ({"waveform": {"component": "samples", "shares": [0.0, 1.0], "values": [0.0]}}, "as many as shares"),
        (
            {"waveform": {"component": "samples", "shares": [0.0, 0.7, 0.5, 1.0], "values": [0, 1, 2, 0]}},
            "samples: shares 0.7, 0.5: must increase, by 1e-12 at least; sort them",
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
    for rise in (0.26, [0.1, 0.26], [0.26, 0.1]):
        with pytest.raises(InputError, match=r"rise \+ high \+ fall = 1.01"):
            own.complete({"rise": rise, "high": 0.5, "fall": 0.25})


def table_of(name, **given):
    own = WAVEFORMS[name] if isinstance(name, str) else name
    values = {"voltage": 1.0, "voltage_bias": 0.0, "drive_frequency": 0.6} | given
    n = own.numbers(own.complete({n: values.get(n, q.default) for n, q in own.parameters.items()}))
    return own, n


def voltages(name, phases, **given):
    own, n = table_of(name, **given)
    return own.voltage(np.array(phases) / 0.6, n)


def test_a_square_is_high_for_its_duty_counted_between_the_middles_of_its_edges():
    """By phases as shares of the repeat; the middle of the rise is at 0."""
    for duty, rise in ((0.3, 0.1), (0.7, 0.02)):
        own, n = table_of("square", duty=duty, rise=rise)
        at = (
            2.0
            * np.pi
            * np.array([1e-9, 0.4 * rise, 0.6 * rise, duty - 0.6 * rise, duty - 1e-9, duty + 0.6 * rise, 0.9])
        )
        np.testing.assert_allclose(own.voltage(at / 0.6, n), [0.0, 0.8, 1.0, 1.0, 0.0, -1.0, -1.0], atol=1e-6)
        tau = np.linspace(0.0, 2.0 * np.pi / 0.6, 100_001)
        assert np.mean(own.voltage(tau, n)) == pytest.approx(2.0 * duty - 1.0, abs=1e-4)
    for duty in (0.02, 0.98):
        assert WAVEFORMS["square"].complete({"duty": duty, "rise": 0.02})["duty"] == duty
    with pytest.raises(InputError, match=r"duty = 0\.981: must be from rise = 0\.02 to 1 - rise"):
        WAVEFORMS["square"].complete({"duty": [0.5, 0.981], "rise": 0.02})
    assert WAVEFORMS["ramp"].complete({"fall": 1.0})["fall"] == 1.0


def test_a_diode_passes_what_is_positive_also_of_a_constant_voltage():
    for amplitude, bias, peak in (
        (1.3, 0.3, 1.6),
        (1.3, -0.3, 1.0),
        (1.3, -2.0, 0.0),
        (0.0, 0.4, 0.4),
        (0.0, -0.4, 0.0),
    ):
        own, n = table_of("half_wave", voltage=amplitude, voltage_bias=bias)
        phase = np.linspace(0.001, 6.28, 400)
        expected = np.maximum(bias + amplitude * np.sin(phase), 0.0)
        np.testing.assert_allclose(own.voltage(phase / 0.6, n), expected, atol=1e-12)
        assert float(own.peak(n)) == pytest.approx(peak)
        grid = 2.0 * np.pi * np.arange(own.samples(n).size) / own.samples(n).size
        np.testing.assert_allclose(own.samples(n), np.maximum(bias + amplitude * np.sin(grid), 0.0), atol=1e-12)


@pytest.mark.parametrize("repeat", [True, False])
def test_a_staircase_comes_to_its_first_level_from_its_last_or_begins_there(repeat):
    """Four levels of a quarter of the repeat each, of which a tenth is the rise."""
    stairs = Staircase((0.2, 0.5, 1.0, 0.7), 0.1, repeat)
    at = 2.0 * np.pi * np.array([1e-9, 0.0125, 0.026, 0.249, 0.2625, 0.276, 0.51, 0.53, 0.99])
    first = [0.7, 0.45, 0.2] if repeat else [0.2, 0.2, 0.2]
    expected = [*first, 0.2, 0.35, 0.5, 0.7, 1.0, 0.7]
    np.testing.assert_allclose(voltages(stairs, at), expected, atol=1e-6)


def test_numbers_of_harmonics_are_bounded_and_the_highest_counts_wherever_it_stands():
    own = Harmonics(((5, 0.2, 0.1), (1, 1.0, 0.0), (3, 0.5, 2.0)))
    assert (own.detail({}), own.antiperiodic) == (5, True)
    phase = np.array([0.3, 2.0])
    expected = 0.2 * np.sin(5 * phase + 0.1) + np.sin(phase) + 0.5 * np.sin(3 * phase + 2.0)
    np.testing.assert_allclose(own.shape(phase, {}), expected)
    assert len(multisine(3, 258).terms) == 256
    with pytest.raises(InputError, match="multisine from 3 to 259: must be 1 to 256 harmonics"):
        multisine(3, 259)
    with pytest.raises(InputError, match="multisine from 0 to 5"):
        multisine(0, 5)
    assert [k for k, _, _ in multisine(2, 4).terms] == [2, 3, 4]
    assert multisine(2, 4, 1).terms == multisine(2, 4, 1).terms != multisine(2, 4, 2).terms
    assert Burst(999, 1000).peak({"voltage": 1.0, "voltage_bias": -0.5}) == 1.5
    for cycles, period in ((1000, 1001), (0, 5), (5, 5)):
        with pytest.raises(InputError, match=f"burst of {cycles} cycles in {period}"):
            Burst(cycles, period)


def test_a_ramp_rises_for_all_but_the_share_in_which_it_falls():
    """From the middle of the rise, at phase 0, to the top after 0.4 of the repeat, and down in a fifth."""
    at = 2.0 * np.pi * np.array([1e-9, 0.2, 0.4, 0.5, 0.6, 0.8])
    np.testing.assert_allclose(voltages("ramp", at, fall=0.2), [0.0, 0.5, 1.0, 0.0, -1.0, -0.5], atol=1e-6)
    at = 2.0 * np.pi * np.array([1e-9, 0.049, 0.051, 0.4, 0.55, 0.7, 0.949])
    expected = [0.0, 0.98, 1.0, 1.0, 0.0, -1.0, -1.0]  # from 0.45 on it falls for a fifth of the repeat
    found = voltages("trapezoid", at, rise=0.1, high=0.4, fall=0.2)
    np.testing.assert_allclose(found, expected, atol=1e-6)


@pytest.mark.parametrize("values", [(0.0, 1.0, 0.5), (0.5, 1.0, 0.0)])
def test_samples_that_would_jump_where_they_repeat_are_refused_whichever_end_is_higher(values):
    with pytest.raises(InputError, match="repeated they would jump; add a last sample, or jump = true"):
        Samples(values=values, repeat=True)
    assert Samples(values=values, repeat=True, jump=True).values == Samples(values=values).values == values


@pytest.mark.parametrize(("first", "last"), [(0.5, 6.0), (6.0, 0.5)])
def test_the_detail_of_a_chirp_is_that_of_its_fastest_swing_of_each_member(first, last):
    n = {"start_frequency": np.array([first, 0.5]), "end_frequency": np.array([last, 0.5]), "drive_frequency": 0.5}
    assert Chirp().detail(n) == pytest.approx([12.0, 1.0], rel=1e-15)


@pytest.mark.parametrize("rise", [-0.1, 1.1])
def test_a_staircase_rises_in_a_share_of_a_levels_time(rise):
    with pytest.raises(InputError, match="a rise from 0 to 1, a share of a level's time"):
        Staircase(rise=rise)
    assert Staircase(rise=1.0).rise == 1.0


@pytest.mark.parametrize("seed", range(4))
def test_a_multisine_reaches_1_and_no_more_between_all_samples(seed):
    wave = multisine(3, 9, seed)
    top = np.abs(wave.shape(np.linspace(0.0, 2.0 * np.pi, 20_001), {})).max()
    assert 1.0 - 1e-12 < top < 1.004


@pytest.mark.parametrize("sweep", ["linear", "logarithmic"])
@pytest.mark.parametrize("repeat", [True, False])
def test_a_chirp_is_the_same_over_its_phase_as_over_the_time(sweep, repeat):
    waveform, times = Chirp(sweep, repeat), np.array([0.3, 2.6, 6.1])
    own = {"voltage": 0.7, "voltage_bias": 0.2, "drive_frequency": 0.8, "start_frequency": 0.9, "end_frequency": 2.5}
    n = waveform.numbers(waveform.complete(own))
    by_phase = {**n, "drive_frequency": 1.0, PHASE_SPEED: 0.8}
    for name in ("voltage", "voltage_rate"):
        found = getattr(waveform, name)(0.8 * times, by_phase)
        np.testing.assert_allclose(found, getattr(waveform, name)(times, n), rtol=1e-12)


def test_a_sum_of_harmonics_is_antiperiodic_where_all_of_them_are_odd():
    for numbers, odd in (((1, 3, 7), True), ((1, 2), False), ((2, 4), False), ((3,), True), ((4, 1, 3), False)):
        waveform = Harmonics(tuple((k, 1.0, 0.3 * k) for k in numbers))
        assert waveform.antiperiodic == odd
        phase = np.linspace(0.0, 3.0, 7)
        assert np.allclose(waveform.shape(phase + np.pi, {}), -waveform.shape(phase, {})) == odd


def test_a_chirp_behind_a_filter_takes_a_resistance_without_a_state_where_it_does_not_jump_back():
    """It begins at 0 and holds its last voltage; a repeated one ends within a swing, unless its swings are whole."""
    reduced = {"film": "taut", "filter_time": 0.3, "series_resistance": 0.005, "reduced": "series_resistance"}
    assert ConeModel(**reduced, waveform="chirp").system.circuit.reduced
    whole = {"start_frequency": 1.0, "end_frequency": 3.0}  # their mean makes two swings in a repeat
    assert ConeModel(**reduced, waveform=Chirp(repeat=True), **whole).system.circuit.reduced
    with pytest.raises(InputError, match="the voltage of the waveform 'chirp' jumps"):
        ConeModel(**reduced, waveform=Chirp(repeat=True), start_frequency=1.0, end_frequency=3.5)


def test_no_number_of_a_list_may_be_too_large_to_compute_with():
    Samples((0.0, 0.5, 1.0), (0.0, LARGEST, 0.0))
    for values in ((0.0, 10.0 * LARGEST, 0.0), (0.0, -np.inf, 0.0), (0.0, np.nan, 0.0)):
        with pytest.raises(InputError, match=r"^samples: values = .*: must be a list of numbers of at most"):
            Samples((0.0, 0.5, 1.0), values)


def test_a_triangle_passes_its_corners_where_a_generator_does():
    waveform = WAVEFORMS["triangle"]
    n = waveform.numbers(waveform.complete({"voltage": 1.0}))
    phases = np.pi * np.array([-0.25, 0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0])
    np.testing.assert_allclose(waveform.voltage(phases, n), [-0.5, 0.0, 0.5, 1.0, 0.5, 0.0, -1.0, 0.0], atol=1e-14)
