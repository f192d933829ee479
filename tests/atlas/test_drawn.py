"""An analysis of every draw is that of each device alone; membranes between others are interpolated to what is said."""

import json
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import gelcone
from gelcone.atlas import drawn
from gelcone.atlas.plan import Plan
from gelcone.devices.analysis import plain
from gelcone.devices.scales import MEASURES
from gelcone.membrane.gel import Array
from gelcone.physics.film import interpolated_pull_in, pull_in
from gelcone.statistics import spread
from tests.recorded import numbers, record

PUMP = gelcone.find_device("biased-pump").replace(film="taut")
DRAWS = {"moving_mass": np.array([4.8e-3, 5.3e-3]), "film_thickness": np.array([2.1e-4, 1.9e-4])}


def alone(k, device=PUMP):
    return device.replace({name: values[k] for name, values in DRAWS.items()})


def test_an_envelope_of_draws_is_that_of_each():
    axes = {"frequencies": ["8 Hz", "11 Hz"], "peaks": ["0.8 kV", "1.6 kV", "2.4 kV", "3.2 kV"]}
    found = gelcone.over_draws(PUMP, DRAWS, "envelope", margin=0.3, **axes)
    assert found.recommended_peak.units == "V"
    assert json.loads(found.options)["highest_peak"] == pytest.approx(3200.0)  # V
    for k in range(2):
        own = gelcone.envelope(alone(k), margin=0.3, **axes)
        for name in ("recommended_peak", "limit_low", "limit_high", "static_limit_voltage", "recommended_constant"):
            np.testing.assert_allclose(found[name][k], own[name], rtol=1e-12)
        np.testing.assert_array_equal(found["first_limit"][k], own["first_limit"])
        np.testing.assert_allclose(found["operating_peak_voltage"][k], own["operating_peak_voltage"], rtol=1e-12)
        np.testing.assert_allclose(found["operating_frequency"][k], own["operating_frequency"], rtol=1e-12)
    assert np.ptp(found["recommended_peak"].values[:, 0]) > 10.0


def test_an_envelope_of_draws_of_films_in_opposite_phase_has_the_second_voltage_of_each():
    """At the recommended peak, which is a margin below the highest one that was examined."""
    films = {"second_film": "taut", "second_drive": "opposite", "second_flat_height": 1.2, "rest_height": 0.6}
    model = gelcone.ConeModel(**films, voltage=0.1, voltage_bias=0.3, damping_ratio=0.5)
    axes, draws = {"frequencies": [0.6, 0.8], "peaks": [0.1, 0.2]}, {"spring_stiffness": np.array([0.9, 1.1])}
    found = gelcone.over_draws(model, draws, "envelope", margin=0.3, **axes)
    np.testing.assert_allclose(found["recommended_constant"], 0.7 * 0.2)
    np.testing.assert_allclose(found["recommended_second_voltage"], 0.7 * 0.2 * abs(2.0 * 0.3 / 0.4 - 1.0))


def test_a_frequency_response_of_draws_is_that_of_each():
    """Of a damped pump, whose motion settles soon."""
    hertz, pump = [9.0, 11.0, 12.0], PUMP.replace(damping_coefficient=0.03)
    found = gelcone.over_draws(pump, DRAWS, "frequency", frequencies=hertz)
    assert found["stroke"].dims == ("draw", "branch", "drive_frequency")
    np.testing.assert_allclose(found["drive_frequency"], hertz)
    for k in range(2):
        own = gelcone.frequency(alone(k, pump), hertz)
        for name in ("stroke", "peak_frequency", "harmonic_phase", "linear_stroke"):
            np.testing.assert_allclose(found[name][k], own[name], rtol=1e-6, atol=1e-9)
    assert np.ptp(found["peak_frequency"].values) > 0.1


def test_an_analysis_that_is_swept_is_the_sweep_of_the_draws():
    found = gelcone.over_draws(PUMP, DRAWS, "limits")
    plan = gelcone.Plan(PUMP, {}, draws=DRAWS)
    for name, values in gelcone.sweep(plan, "limits").data_vars.items():
        np.testing.assert_array_equal(found[name], values)


def test_a_draw_without_a_state_is_said_and_the_others_have_theirs():
    heights = {"hoop_prestretch": np.array([1.4, 30.0])}
    found = gelcone.over_draws(PUMP, heights, "envelope", frequencies=[8.0, 9.0], peaks=[500.0, 900.0])
    assert found.outcome.values.tolist() == [gelcone.Outcome.OK, gelcone.Outcome.ERROR]
    assert np.isfinite(found.recommended_peak[0]).all()
    assert np.isnan(found.recommended_peak[1]).all()
    words = gelcone.in_words(found)
    assert "1 of 2 runs failed" in words
    rows = words.partition("in how many draws\n")[2].splitlines()[:2]
    assert all(row.endswith(" 1, failed 1") and "none" not in row for row in rows)


def test_a_draw_that_is_refused_leaves_the_others_their_frequency_response(monkeypatch):
    monkeypatch.setattr(drawn, "AT_ONCE", 2)
    model, shares = gelcone.ConeModel(voltage=0.1, voltage_bias=0.4), []

    def of(*damping, **options):
        draws = {"damping_ratio": np.array(damping)}
        return gelcone.over_draws(model, draws, "frequency", frequencies=[0.8, 0.9], **options)

    found = of(0.1, 0.0, 0.12, progress=shares.append)
    assert found.outcome.values.tolist() == [gelcone.Outcome.OK, gelcone.Outcome.ERROR, gelcone.Outcome.OK]
    assert np.isnan(found.stroke[1]).all()
    np.testing.assert_array_equal(found.stroke[[0, 2]], of(0.1, 0.12).stroke)
    assert sum(shares) == pytest.approx(1.0, abs=1e-9)
    with pytest.raises(gelcone.InputError, match="without damping no motion settles"):
        of(0.0, 0.0)


def test_a_draw_that_fails_at_one_frequency_has_failed(monkeypatch):
    def failing(run):
        own = plain(run)

        def call(*arguments, **options):
            found = own(*arguments, **options)
            found["outcome"][1, ..., -1] = gelcone.Outcome.PULLED_IN
            return found

        return call

    monkeypatch.setattr(drawn, "plain", failing)
    model, draws = gelcone.ConeModel(voltage=0.1, voltage_bias=0.4), {"damping_ratio": np.array([0.1, 0.12])}
    found = gelcone.over_draws(model, draws, "frequency", frequencies=[0.8, 0.9])
    assert found.outcome.values.tolist() == [gelcone.Outcome.OK, gelcone.Outcome.PULLED_IN]


def test_an_envelope_of_which_all_draws_are_refused_says_why():
    still, axes = gelcone.ConeModel(voltage=0.0), {"frequencies": [0.8, 0.9], "peaks": [0.5, 1.0]}
    with pytest.raises(gelcone.InputError, match="here the device's drive is scaled; give it an amplitude"):
        gelcone.over_draws(still, {"damping_ratio": np.array([0.1, 0.2])}, "envelope", **axes)


def test_a_path_is_no_draws_and_a_frame_is():
    """Of pandas; how to read a file is said."""
    with pytest.raises(gelcone.InputError, match=r"draws = 'd.csv': must be name -> values or a Dataset; read a file"):
        gelcone.over_draws(PUMP, "d.csv")
    frame = pd.DataFrame(DRAWS)
    one, other = (gelcone.over_draws(PUMP, draws, threads=1) for draws in (frame, dict(frame)))
    xr.testing.assert_equal(one, other)


@pytest.mark.parametrize(
    ("analysis", "options", "message"),
    [
        ("tongues", {}, "analysis of draws"),
        ("envelope", {"initial": (0.1, 0.0)}, "initial: envelope has a start of its own; leave it out"),
        ("datasheet", {"initial": (0.1, 0.0)}, "initial: datasheet has a start of its own; leave it out"),
        ("envelope", {"margin": 1.0}, "margin = 1: must be at least 0 and below 1"),
        ("envelope", {"patience": 1.0}, "patience"),
        ("frequency", {"branches": True}, "branches: is not computed for draws; leave it out, or run frequency of one"),
        ("frequency", {"frequencies": ["9 Hz", "8 Hz"]}, "frequencies: must be at least 2 positive numbers that"),
        ("envelope", {"peaks": ["1 kV"]}, "peaks: must be at least 2 positive numbers that increase"),
    ],
)
def test_what_draws_do_not_take_is_refused(analysis, options, message):
    with pytest.raises(gelcone.InputError, match=message):
        gelcone.over_draws(PUMP, DRAWS, analysis, **options)


class Known(pull_in.PullInCurve):
    """A made-up curve, which depends on the film as it likes."""

    def voltage(self, x) -> Array:
        A, B = self.numbers["A"], self.numbers["B"]
        found = (1.0 + A + 2.0 * B + self.numbers["bend"] * (A - 1.44) ** 2) * (1.0 + np.abs(x))
        return np.where(np.abs(x) < self.numbers["ends"] * B, found, np.inf)


@pytest.fixture
def made(monkeypatch):
    """Membranes in place of those that take seconds: how many were made, and how far from linear they are."""
    films, others = [], {"bend": 0.0, "ends": 1e9, "reach_squared": 9.0}

    def make(law, numbers, A, B, ratio):
        films.append((A, B))
        return Known({"A": A, "B": B, "film_error": 0.01, **{k: v(A) if callable(v) else v for k, v in others.items()}})

    monkeypatch.setattr(pull_in, "_made", make)
    monkeypatch.setattr(pull_in, "_curves", {})
    return films, others


def wrinkling(count):
    rng = np.random.default_rng(4)
    stretches = {name: rng.normal(1.2, 0.02, count) for name in ("meridional_prestretch", "hoop_prestretch")}
    return gelcone.ConeModel(film="wrinkling", voltage=0.3, **stretches).members()


def off(members, x):
    """How far the curves of films that are in memory are from their own."""
    rows = []
    for key in interpolated_pull_in._keys_of(members):
        _, law, A, B, ratio = key
        own = pull_in._made(key[0], law, A, B, ratio)
        rows.append(pull_in.curve_of(*key).voltage(x) / own.voltage(x) - 1.0)
    return np.array(rows)


def test_few_membranes_stand_for_the_films_of_many_draws(made):
    films, _ = made
    members, x = wrinkling(40), np.linspace(-2.9, 2.9, 77)
    with interpolated_pull_in.interpolated_curves(members) as between:
        assert len(films) == between.made == 8
        assert between.films == 40
        assert between.error < 1e-12
        assert np.abs(off(members, x)).max() < 1e-6
        read = list(pull_in.curves_between.values())
        assert len(read) == 32
        assert all(curve.voltage(3.5) == curve.voltage(3.0) and curve.error == 0.01 for curve in read)
    assert len(pull_in._curves) == 8
    assert not pull_in.curves_between


def test_more_films_than_are_held_are_interpolated_all(made, monkeypatch):
    films, _ = made
    monkeypatch.setattr(pull_in, "MOST", 16)
    members = wrinkling(40)
    with interpolated_pull_in.interpolated_curves(members):
        for _ in range(2):
            for key in interpolated_pull_in._keys_of(members):
                pull_in.curve_of(*key)
    assert len(films) == 8


@pytest.mark.parametrize(
    "other", [{"bend": 2000.0}, {"ends": 2.0}, {"reach_squared": lambda A: 9.0 if A < 1.44 else 8.0}]
)
def test_films_that_are_not_alike_have_a_membrane_each(made, other):
    _, others = made
    others.update(other)
    with interpolated_pull_in.interpolated_curves(wrinkling(40)) as between:
        assert between is None
        assert not pull_in.curves_between


def test_taut_cones_whose_membranes_are_asked_for_share_them_too(made):
    stretches = np.random.default_rng(3).normal(1.3, 0.02, 20)
    members = gelcone.find_device("biased-pump").replace(film="taut", hoop_prestretch=stretches).to_model().members()
    with interpolated_pull_in.interpolated_curves(members) as between:
        assert (between.films, between.made) == (20, 6)


def test_the_error_of_films_between_others_is_said(made):
    _, others = made
    others["bend"] = 10.0
    members = wrinkling(60)
    with interpolated_pull_in.interpolated_curves(members) as between:
        own = float(np.sqrt(np.mean(off(members, np.linspace(0.0, 2.0, 9)) ** 2)))
    assert 1e-3 < own < between.error < 8.0 * own


def test_few_films_are_made_each(made):
    films, _ = made
    with interpolated_pull_in.interpolated_curves(wrinkling(8)) as between:
        assert between is None
    assert films == []
    with interpolated_pull_in.interpolated_curves(
        gelcone.ConeModel(hoop_prestretch=np.linspace(1, 1.2, 40)).members()
    ) as between:
        assert between is None


def test_the_result_says_how_its_membranes_were_made(made, monkeypatch):
    """Each draw is examined with its own curve, made or between others."""

    def window(plane, omegas, peaks, progress):
        none = np.full((2, 7), np.inf)
        return {"low": none, "high": none}, np.array([*[np.inf] * 5, plane.membrane.voltage(0.5)]), peaks

    monkeypatch.setattr(drawn, "_window", window)
    draws = {name: np.random.default_rng(2).normal(1.3, 0.01, 12) for name in ("hoop_prestretch",)}
    pump = PUMP.replace(film="wrinkling")
    found = gelcone.over_draws(pump, draws, "envelope", frequencies=[8.0, 9.0], peaks=[400.0, 800.0])
    own = (1.0 + pump.meridional_prestretch**2 + 2.0 * draws["hoop_prestretch"] ** 2) * 1.5 * pump.scales.voltage
    np.testing.assert_allclose(found["static_limit_voltage"][:, -1], own, rtol=1e-6)
    assert json.loads(found.attrs["membranes"])["films"] == 12
    line = gelcone.in_words(found).splitlines()[-1]
    assert line.startswith("pull-in of the membrane: 6 membranes made for 12 films, the voltages of the others ")


def test_a_data_sheet_has_the_interval_of_every_figure():
    """The draw in the middle is the pump; a field about zero is said by mean and deviation."""
    thickness, offsets = np.array([1.8e-4, 2.0e-4, 2.2e-4]), np.array([-30.0, 0.0, 30.0])
    draws = {"film_thickness": thickness, "voltage_offset": offsets}
    pump = PUMP.replace(voltage_offset=0.0)
    found = gelcone.over_draws(pump, draws, "datasheet", voltages=["1 kV"])
    np.testing.assert_array_equal(
        [gelcone.stroke_and_blocked_force(pump, ["1 kV"])["blocked_force"][0]], found["blocked_force"][1:]
    )
    each = [pump.replace(film_thickness=h, voltage_offset=v) for h, v in zip(thickness, offsets, strict=True)]
    forces = [float(gelcone.stroke_and_blocked_force(own, ["1 kV"])["blocked_force"][0]) for own in each]
    low, high = np.quantile(forces, [0.025, 0.975])
    assert float(found["blocked_force_low"][1]) == pytest.approx(low, rel=1e-12)
    assert float(found["blocked_force_high"][1]) == pytest.approx(high, rel=1e-12)
    words = gelcone.in_words(found)
    assert "95 % at 1 kV" in words
    assert f"{1e3 * low:.3g} to {1e3 * high:.3g} mN" in words
    spread = float(np.std(thickness) / 2e-4)
    assert f"tolerances: within these intervals lie 95 % of 3 draws, of film_thickness {100 * spread:.2g} %" in words
    assert f"voltage_offset 0 ± {np.std(offsets):.2g}" in words


# --- what is handed on ------------------------------------------------------------------------------------------------

CONE = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)


def drawn_of(model, count=3):
    """A plan of draws of the damping alone, or of a mass."""
    draws = (
        {"damping_ratio": numbers(count, at=0.0)}
        if isinstance(model, gelcone.ConeModel)
        else {"moving_mass": DRAWS["moving_mass"]}
    )
    return Plan(model, {}, None, draws)


def test_the_spread_of_draws_below_zero_is_a_positive_share():
    assert drawn._spread(np.array([-2.0, -4.0])) == drawn._spread(np.array([2.0, 4.0])) == pytest.approx(1.0 / 3.0)
    assert drawn._spread(np.array([-1.0, 2.0])) == [0.5, 1.5]


def test_the_envelope_of_each_draw_is_that_of_its_own_plane(monkeypatch):
    """The second of three draws is refused; limits count with the margin, up to the highest peak of each draw."""
    of, counted = drawn_of(CONE), []
    nominal = SimpleNamespace(default_frequencies=lambda: np.array([0.5, 0.75]))
    omegas, static = [0.5, 0.75], np.array([np.nan, 2.0, 0.5, np.inf, np.nan, 1.25])

    def planes(model, threads, limits_from):
        if model == CONE:
            return nominal
        if model.damping_ratio == numbers(3)[1]:
            raise gelcone.InputError("this one is refused")
        return model

    def window(plane, omegas, peaks, progress):
        progress(1.0)
        at = float(plane.damping_ratio)
        low = np.full((2, 7), np.inf)
        low[0, [1, 2]], low[1, 0] = (0.75 + at, 0.875), np.nan
        return {"low": low, "high": low + 0.25}, static + at, np.array([0.1, 0.9 - at]) if peaks is None else peaks

    asked = record(monkeypatch, drawn, plane_of=planes, _window=window)
    variables, outcome, options = drawn._windows(of, {"margin": 0.25, "limits_from": "both"}, 5, counted.append)
    assert {(call["threads"], call["limits_from"]) for call in asked["plane_of"]} == {(5, "both")}
    assert [call["plane"].damping_ratio for call in asked["_window"]] == numbers(3)[[0, 2]].tolist()
    for call in asked["_window"]:
        assert (call["omegas"].tolist(), call["peaks"]) == (omegas, None)
    assert outcome.tolist() == [0, gelcone.Outcome.ERROR, 0]
    at = np.array([numbers(3)[0], np.nan, numbers(3)[2]])
    value = {name: variable[1] for name, variable in variables.items()}
    np.testing.assert_allclose(value["recommended_peak"], 0.75 * (0.5 + at)[:, None] + [[0.0, 0.0]])
    np.testing.assert_allclose(value["recommended_constant"], 0.75 * (0.5 + at))
    np.testing.assert_allclose(value["static_limit_voltage"], static + at[:, None])
    np.testing.assert_allclose(value["limit_low"][:, 1, 0], 0.75 + at)
    np.testing.assert_allclose(value["limit_high"][:, 2, 0], 1.125 + 0.0 * at)
    assert value["first_limit"].tolist() == [[1, -1], [-1, -1], [1, -1]]
    np.testing.assert_allclose(value["operating_peak_voltage"], [0.9] * 3)
    np.testing.assert_allclose(value["operating_frequency"], [CONE.drive_frequency] * 3)
    assert value["drive_frequency"].tolist() == omegas
    assert options == {"margin": 0.25, "limits_from": "both", "highest_peak": 0.9 - numbers(3)[0]}
    assert sum(counted) == pytest.approx(1.0)
    own = {"frequencies": np.array([[0.5, 0.75]] * 3), "peaks": np.array([[0.1, 0.9], [0.1, 0.8], [0.1, 0.25]])}
    monkeypatch.setattr(drawn, "_axis", lambda of, name, *given: (own[name][0], own[name]))
    value = drawn._windows(of, {"peaks": "given"}, 5, None)[0]
    np.testing.assert_allclose(value["recommended_peak"][1][2], [0.8 * 0.25] * 2)
    assert value["recommended_constant"][1][2] == pytest.approx(0.8 * 0.25)


def test_a_draw_is_examined_up_to_its_own_pull_in(monkeypatch):
    static = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    asked = record(monkeypatch, drawn, static_limits_of=static, driven="found", peaks_of="its own")
    assert drawn._window("plane", "omegas", "given", "progress") == ("found", static, "given")
    assert drawn._window("plane", "omegas", None, "progress") == ("found", static, "its own")
    wanted = {"plane": "plane", "omegas": "omegas", "refine": False, "progress": "progress", "pull_in": 0.6}
    for call, volts in zip(asked["driven"], ("given", "its own"), strict=True):
        assert {name: call[name] for name in wanted} == wanted
        assert (call["volts"], call["ceiling"]) == (volts, np.inf)


def test_an_axis_is_shared_in_si_and_each_draws_own_without_units():
    of = drawn_of(PUMP)
    shared, each = drawn._axis(of, "frequencies", "frequency", ["8 Hz", "10 Hz"], None)
    scales = [PUMP.replace(moving_mass=float(mass)).scales.frequency for mass in DRAWS["moving_mass"]]
    np.testing.assert_allclose(each, shared / np.array(scales)[:, None])
    assert np.ptp(scales) > 0.0
    given, own = drawn._axis(of, "frequencies", "frequency", None, lambda: [0.5, 0.75])
    np.testing.assert_allclose(given, np.array([0.5, 0.75]) * PUMP.scales.frequency)
    np.testing.assert_allclose(own, given / np.array(scales)[:, None])
    with pytest.raises(gelcone.InputError, match="frequencies: must be at least 2 positive numbers that increase"):
        drawn._axis(of, "frequencies", "frequency", ["10 Hz", "8 Hz"], None)


def response_of(count, at=0.0):
    """Made-up responses of some members at two frequencies; the members' second sweep ended in the second one."""
    dims = ("member", "branch", "step")
    outcome = np.zeros((count, 2, 2), dtype=np.int8)
    outcome[:, 1, 1] = 3
    return xr.Dataset(
        {"stroke": (dims, numbers(count, 2, 2, at=at), {"units": "1"}), "outcome": (dims, outcome),
         "jump_member": ("jump", [count - 1, count - 1])},
        {"harmonic": ("harmonic", [1, 2])},
    )  # fmt: skip


def test_the_responses_of_draws_are_those_of_their_members_at_their_own_frequencies_and_starts(monkeypatch):
    monkeypatch.setattr(drawn, "AT_ONCE", 2)
    asked, shares = [], []

    def responses(model, omegas=None, initial=None, **options):
        asked.append((model, omegas, initial, options))
        if omegas is None:
            return xr.Dataset(coords={"drive_frequency": [0.5, 0.75]})
        if options["progress"] is not None:
            options["progress"](1.0)
        return response_of(model.size, at=10.0 * len(asked))

    monkeypatch.setattr(drawn, "plain", {drawn.frequency: responses}.__getitem__)
    draws = {"damping_ratio": numbers(3), "voltage": numbers(3, at=0.25), "velocity": numbers(3, at=0.5)}
    of = Plan(CONE, {}, (0.25, 0.5), draws)
    given = {"tolerance": 2e-9, "patience": 12.0}
    variables, outcome, _ = drawn._responses(of, given, 5, shares.append)
    (nominal, *parts) = asked
    assert (nominal[0], nominal[1], tuple(nominal[2]), nominal[3]) == (CONE, None, (0.25, 0.5), {"threads": 5})
    for (model, omegas, initial, options), rows in zip(parts, ([0, 1], [2]), strict=True):
        assert model.damping_ratio.tolist() == numbers(3)[rows].tolist()
        assert model.voltage.tolist() == numbers(3, at=0.25)[rows].tolist()
        np.testing.assert_allclose(omegas, [[0.5, 0.75]] * len(rows))
        np.testing.assert_array_equal(initial, [[0.25, velocity] for velocity in numbers(3, at=0.5)[rows]])
        assert {name: options[name] for name in given} == given
        assert options["threads"] == 5
    assert variables["jumps"][1].tolist() == [0, 2, 2]
    whole = np.concatenate([numbers(2, 2, 2, at=20.0), numbers(1, 2, 2, at=30.0)])
    assert variables["stroke"][0] == ("branch", "drive_frequency")
    np.testing.assert_array_equal(variables["stroke"][1], whole)
    assert outcome.tolist() == [3, 3, 3]
    assert variables["drive_frequency"][1].tolist() == [0.5, 0.75]
    assert sum(shares) == pytest.approx(1.0)


def test_a_sheet_has_the_ends_of_its_figures_over_all_draws_at_the_voltages_above_0(monkeypatch):
    """One of four draws is refused; voltages are given on in the units in which they are read."""
    volts = {"units": "V"}
    made = []

    def sheet(model, voltages=None, *, threads):
        made.append((model, voltages, threads))
        k = float(len(made))
        if k == 4.0:
            raise gelcone.InputError("refused")
        along = ("constant_voltage", [0.0, k, 2.0 * k])
        return xr.Dataset(
            {"free_stroke": along, "mass": 10.0 * k},
            {"constant_voltage": ("constant_voltage", [0.0, 500.0, 900.0], volts)},
        )

    monkeypatch.setattr(drawn, "find_analysis", lambda name: SimpleNamespace(call=sheet))
    plan = Plan(PUMP, {}, None, {"moving_mass": np.array([4e-3, 5e-3, 6e-3, 9e-3])})
    shares = []
    found = drawn._sheet(plan, {"voltages": "given"}, 5, shares.append)
    assert made[0] == (PUMP, "given", 5)
    for (device, voltages, threads), mass in zip(made[1:], plan.draws["moving_mass"], strict=True):
        assert (float(device.moving_mass), threads) == (mass, 5)
        np.testing.assert_allclose(voltages, np.array([500.0, 900.0]) / MEASURES["voltage"].per_unit)
    low, _, high = spread(np.array([20.0, 30.0, np.nan, 50.0]))
    assert (float(found["mass"]), float(found["mass_low"]), float(found["mass_high"])) == (10.0, low, high)
    ends = spread(np.array([[0.0, k, 2.0 * k] for k in (2.0, 3.0, np.nan, 5.0)]))
    np.testing.assert_allclose(found["free_stroke_low"], ends[0])
    np.testing.assert_allclose(found["free_stroke_high"], ends[2])
    assert (found.attrs["draws"], found.attrs["failed"]) == (4, 1)
    mass = plan.draws["moving_mass"]
    assert json.loads(found.attrs["drawn"])["moving_mass"] == pytest.approx(mass.std() / mass.mean())
    assert shares == [0.25] * 4
