"""The best drive is safe, and no other drive in its window yields more; its sensitivities are those of the motion."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError
from gelcone.motion import best_drive
from gelcone.motion.best_drive import drive
from gelcone.motion.envelope import plane_of
from gelcone.motion.plane import NUDGE, Plane
from tests.recorded import numbers, record
from tests.toys import ThreeHarmonics

CONE = gelcone.ConeModel(damping_ratio=0.1, rest_height=0.4, stretch_limit=8.0, voltage=0.4, voltage_bias=0.2)
RANGE = {"lowest_frequency": 0.4, "highest_frequency": 1.6}
WORTH = {"stroke": "window_stroke", "power": "window_damper_power"}


@pytest.fixture(scope="module", autouse=True)
def few():
    """Few frequencies, for every one takes a while."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(best_drive, "COARSE", 4)
        patch.setattr(best_drive, "FINE", 3)
        patch.setattr(best_drive, "PEAKS", (0.5, 1.2, 3))
        yield


@pytest.fixture(scope="module")
def found():
    return drive(CONE, **RANGE, threads=1)


def at(found, **changes):
    numbers = {name: float(found[name]) for name in ("voltage", "voltage_bias", "drive_frequency")}
    model = CONE.replace(**numbers).replace(**changes)
    rest = float(gelcone.pull_in_voltage(model)["rest_displacement"])
    return gelcone.settled(model, (rest + NUDGE, 0.0))


def test_the_motion_is_that_of_the_drive(found):
    own = at(found)
    assert float(found["stroke"]) == pytest.approx(float(own["stroke"]), rel=1e-3)  # the window samples 12 periods
    assert float(np.ptp(found["displacement"].values)) == pytest.approx(float(own["stroke"]), rel=1e-3)
    period = 2.0 * np.pi / float(found["drive_frequency"])
    assert float(found["time"][-1]) == pytest.approx(2.0 * period)
    assert float(found["work"]) == pytest.approx(float(found["power"]) * period)
    assert float(found["power"]) == pytest.approx(2.0 * 0.1 * float(found["speed"]) ** 2)
    speed = np.gradient(found["displacement"].values, found["time"].values)
    assert float(found["speed"]) == pytest.approx(np.sqrt(np.mean(speed**2)), rel=2e-2)


def test_the_drive_is_below_every_limit_of_the_envelope_by_the_margin(found):
    there = gelcone.envelope(CONE, frequencies=[0.9 * float(found["drive_frequency"]), float(found["drive_frequency"])])
    low = np.nanmin([*there["limit_low"].values[:, 1], *there["static_limit_voltage"].values])
    assert float(found["peak_voltage"]) <= 0.8 * low * (1.0 + 1e-2)
    assert float(found["frequency_low"]) <= float(found["drive_frequency"]) <= float(found["frequency_high"])


@pytest.mark.parametrize("largest", WORTH)
def test_no_edge_of_the_window_yields_more(largest, found):
    best = found if largest == "stroke" else drive(CONE, largest=largest, **RANGE, threads=1)
    there = gelcone.envelope(CONE, frequencies=np.geomspace(*RANGE.values(), 4))
    safe = there["recommended_peak"] <= 0.9 * best_drive._detuned(there["drive_frequency"].values, there)
    assert safe.any()
    assert float(best[largest]) >= float(there[WORTH[largest]][safe.values].max()) * (1.0 - 1e-9)
    assert float(best["window_value"].max()) >= float(best[largest])


FREQUENCY = np.array([0.5, 0.995, 1.0, 1.5])


def made_up(*limits):
    """A window below these limits at `FREQUENCY`; its edge yields 1, 2, 9 and 3."""
    limits = np.array(limits)
    return xr.Dataset(
        {
            "static_limit_voltage": ("limit", [np.nan]),
            "static_limit": ("limit", ["breakdown"]),
            "first_limit": ("f", [0, 0, 0, 0]),
            "limit_low": (("driven", "f"), limits[None, :]),
            "driven_limit": ("driven", ["pull-in"]),
            "peak_voltage": ("peak", [0.1]),
            "recommended_peak": ("f", 0.8 * limits),
            "drive_frequency": ("f", FREQUENCY),
            "regime": (("f", "peak"), np.full((4, 1), Regime.PERIODIC)),
            "outcome": (("f", "peak"), np.zeros((4, 1))),
            **{
                f"driven_{name}": (("f", "peak"), np.full((4, 1), 0.1))
                for name in ("stroke", "damper_power", "power", "apparent_power")
            },
            **{
                f"window_{name}": ("f", [1.0, 2.0, 9.0, 3.0])
                for name in ("stroke", "damper_power", "power", "apparent_power")
            },
            "window_regime": ("f", np.full(4, Regime.PERIODIC)),
        }
    )


def test_a_drive_keeps_half_of_its_margin_where_its_frequency_is_a_little_off():
    """Next to a limit that falls steeply with frequency, the edge of the window is not chosen though it yields most."""
    window = made_up(2.0, 1.4, 2.0, 1.9)
    np.testing.assert_allclose(
        best_drive._detuned(FREQUENCY, window)[[0, 2]], [1.0 / (0.5 + (1.0 / 1.4 - 0.5) * 0.005 / 0.495), 1.4]
    )
    best = best_drive._best("stroke", 0.1, 0.2, window)
    assert (float(best.frequency), float(best.peak)) == (1.5, pytest.approx(0.8 * 1.9))
    flat = window.assign(limit_low=window["limit_low"] * 0.0 + 2.0)
    assert float(best_drive._best("stroke", 0.1, 0.2, flat).frequency) == 1.0
    # the edge there is 0.8 x 2; half of the margin is kept below limits from 1.6/0.9 on
    for limit, chosen in ((1.77, 1.5), (1.79, 1.0)):
        assert float(best_drive._best("stroke", 0.1, 0.2, made_up(2.0, limit, 2.0, 1.9)).frequency) == chosen


def test_a_voltage_is_held_between_the_next_frequencies_with_a_lower_limit():
    window = made_up(2.0, 1.4, 2.0, 1.9)
    assert best_drive._safe_band(1.0, 1.5, window, window) == (1.0, 1.5)
    assert best_drive._safe_band(1.0, 1.95, window, window) == (1.0, 1.0)
    assert best_drive._safe_band(0.5, 1.5, window, window) == (0.5, 0.5)
    assert best_drive._safe_band(1.5, 1.3, window, window) == (0.5, 1.5)


@pytest.mark.parametrize("name", ["rest_height", "drive_frequency", "damping_ratio"])
def test_sensitivities_are_those_of_the_settled_motion(name, found):
    value = {"drive_frequency": float(found["drive_frequency"])}.get(name, getattr(CONE, name))
    more, less = (float(at(found, **{name: value * (1.0 + h)})["stroke"]) for h in (2e-3, -2e-3))
    own = float(found["sensitivity"][found["field"].values.tolist().index(name)])
    assert own == pytest.approx(np.log(more / less) / 4e-3, rel=2e-2, abs=2e-2)


def test_what_is_largest_is_in_the_units_of_the_number_of_that_name(found):
    assert {name: found[name].attrs["quantity"] for name in best_drive._QUANTITY} == best_drive._QUANTITY
    assert found["window_value"].attrs["quantity"] == found["stroke"].attrs["quantity"]


def test_a_device_is_answered_in_its_units(command_line, undrawn):
    typed = (
        "drive",
        "soft-film",
        "--film",
        "taut",
        "--set",
        "initial_height=3 mm",
        "--lowest-frequency",
        "8 Hz",
        "--highest-frequency",
        "14 Hz",
    )
    code, out, err = command_line(*typed, "--out", "there")
    assert code == 0, err
    (line,) = [line for line in out.splitlines() if line.startswith("largest stroke: ")]
    result = gelcone.load("there/drive.nc")
    assert f"{1e3 * float(result['stroke']):.4g} um at {float(result['drive_frequency']):.4g} Hz" in line
    assert 8.0 <= float(result["drive_frequency"]) <= 14.0
    assert {"film_thickness", "material.shear_modulus", "frequency"} <= set(result["field"].values.tolist())
    device = gelcone.find_device("soft-film").replace(
        initial_height="3 mm",
        voltage_amplitude=float(result["voltage"]),
        frequency=float(result["drive_frequency"]),
        film="taut",
        release_height=None,
    )
    assert float(gelcone.settled(device)["stroke"]) == pytest.approx(float(result["stroke"]), rel=1e-3)
    assert command_line("show", "there/drive.nc")[1] == out.split("wrote ")[0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"largest": "strok"}, "did you mean 'stroke'"),
        ({"lowest_frequency": 1.0}, "lowest_frequency: is given alone; give both ends of the frequencies, or neither"),
        (
            {"highest_frequency": 1.0},
            "highest_frequency: is given alone; give both ends of the frequencies, or neither",
        ),
        (
            {"lowest_frequency": 2.0, "highest_frequency": 1.0},
            "lowest_frequency = 2.0: must be greater than 0 and below the highest frequency, 1.0",
        ),
        (
            {"lowest_frequency": 0.0, "highest_frequency": 1.0},
            "lowest_frequency = 0.0: must be greater than 0 and below the highest frequency, 1.0",
        ),
    ],
)
def test_bad_input_is_refused(options, message):
    with pytest.raises(gelcone.InputError, match=message):
        drive(CONE, **options)


def test_a_drive_that_moves_nothing_is_said():
    flat = gelcone.ConeModel(damping_ratio=0.5, voltage=0.05, drive_frequency=3.0)
    with pytest.raises(gelcone.InputError, match="no drive within the window moves the disc"):
        drive(flat, lowest_frequency=2.5, highest_frequency=3.5, threads=1)
    with pytest.raises(gelcone.InputError, match="takes one actuator"):
        drive(CONE.replace(voltage=[0.1, 0.2]))


def test_a_waveform_of_ones_own_is_scaled_to_its_peak():
    own = CONE.replace(waveform=ThreeHarmonics())
    found = drive(own, **RANGE, threads=1)
    numbers = {name: float(found[name]) for name in ("voltage", "voltage_bias", "drive_frequency")}
    assert float(own.replace(**numbers).peak_voltage) == pytest.approx(float(found["peak_voltage"]))


def test_a_limit_at_a_constant_voltage_counts_where_it_is_the_lower_one():
    """At each frequency that either envelope examined; where both did, the later one."""
    wide = made_up(2.0, 1.4, 2.0, 1.9).assign(static_limit_voltage=("limit", [1.7]))
    near = made_up(1.1, 1.2, 1.3, 1.8).assign(drive_frequency=("f", [1.0, 1.1, 1.2, 1.5]))
    known, limits, names = best_drive._rows(wide, near)
    np.testing.assert_array_equal(known, [0.5, 0.995, 1.0, 1.1, 1.2, 1.5])
    np.testing.assert_allclose(limits, [1.7, 1.4, 1.1, 1.2, 1.3, 1.8])
    held = "breakdown at a constant voltage"
    assert names == [held, "pull-in", "pull-in", "pull-in", "pull-in", "pull-in"]
    assert best_drive._limit(0.6, wide, near) == (held, 1.7)
    assert best_drive._limit(1.08, wide, near) == ("pull-in", 1.2)
    free = wide.assign(first_limit=("f", [-1, 0, -1, 0]), static_limit_voltage=("limit", [np.nan]))
    assert best_drive._limit(0.5, free, free) == ("none", np.inf)


def test_the_limit_of_films_in_opposite_phase_is_of_the_drive_held_at_its_peak():
    held = made_up(2.0, 1.4, 2.0, 1.9).assign(static_limit_voltage=("limit", [1.7]), recommended_second_voltage=1.0)
    assert best_drive._limit(0.5, held, held) == ("breakdown of the drive held at its peak", 1.7)


def test_no_more_is_claimed_of_a_drive_than_was_examined():
    """Where no limit is met up to the highest peak examined, 1.6, a voltage above it counts as one that meets one."""
    window = made_up(2.0, 1.4, 2.0, 1.9).assign(first_limit=("f", [-1, 0, 0, -1]), peak_voltage=("peak", [1.6]))
    above = window.assign(static_limit_voltage=("limit", [3.1]))
    _, limits, names = best_drive._rows(above)
    np.testing.assert_allclose(limits, [1.6, 1.4, 2.0, 1.6])
    assert names == ["none", "pull-in", "pull-in", "none"]
    np.testing.assert_allclose(best_drive._detuned(FREQUENCY, above)[[0, 3]], [1.6, 1.6], rtol=0.01)
    assert best_drive._safe_band(1.0, 1.7, above, above) == (1.0, 1.0)
    assert best_drive._safe_band(1.0, 1.5, above, above) == (1.0, 1.5)
    below = window.assign(static_limit_voltage=("limit", [1.5]))
    assert best_drive._rows(below)[2][0] == "breakdown at a constant voltage"


def test_the_second_search_lies_between_the_neighbours_and_around_the_limit_there():
    window = made_up(2.0, 1.4, 2.0, 1.9)
    for omega, ends, bound in ((0.5, (0.5, 0.995), 2.0), (1.0, (0.995, 1.5), 2.0), (1.4, (1.0, 1.5), 1.9)):
        found = best_drive._around(window, omega)
        assert (found["frequencies"][0], found["frequencies"][-1]) == pytest.approx(ends)
        np.testing.assert_allclose(found["peaks"], bound * np.linspace(*best_drive.PEAKS))
    free = window.assign(first_limit=("f", [-1] * 4))
    np.testing.assert_allclose(best_drive._around(free, 1.0)["peaks"], 0.1 * np.linspace(*best_drive.PEAKS))


def test_drives_inside_the_window_are_its_edge_and_the_peaks_up_to_it():
    window = made_up(2.0, 1.4, 2.0, 1.9)
    window = window.drop_dims("peak").assign(
        peak_voltage=("peak", [1.1, 1.52, 1.7]),
        regime=(("f", "peak"), np.array([[Regime.PERIODIC, Regime.PERIODIC, Regime.CHAOTIC]] * 4)),
        outcome=(("f", "peak"), np.array([[0, 3, 0]] * 4)),
        **{f"driven_{name}": (("f", "peak"), np.arange(12.0).reshape(4, 3) + 10.0 * k)
           for k, name in enumerate(("stroke", "damper_power", "power", "apparent_power"))},
    )  # fmt: skip
    found = best_drive.candidates(window)
    np.testing.assert_allclose(found.frequency, [*FREQUENCY, 0.5, 0.5, 0.995, 1.0, 1.0, 1.5, 1.5])
    np.testing.assert_allclose(found.peak, [1.6, 1.12, 1.6, 1.52, 1.1, 1.52, 1.1, 1.1, 1.52, 1.1, 1.52])
    np.testing.assert_allclose(found.stroke, [1, 2, 9, 3, 0, 1, 3, 6, 7, 9, 10])
    np.testing.assert_allclose(found.power[4:], found.stroke[4:] + 10.0)
    np.testing.assert_allclose(found.supplied[4:], found.stroke[4:] + 20.0)
    np.testing.assert_allclose(found.apparent[4:], found.stroke[4:] + 30.0)
    assert found.periodic.tolist() == [1, 1, 1, 1, 1, 0, 1, 1, 0, 1, 0]
    assert found.edge.tolist() == [1] * 4 + [0] * 7


@pytest.mark.parametrize(
    ("largest", "value"), [("stroke", 0.3), ("power", 0.4), ("work", 0.8 * np.pi / 0.5), ("speed", np.sqrt(0.4 / 0.2))]
)
def test_what_may_be_largest(largest, value):
    yields = (np.array([v, v]) for v in (0.3, 0.4, 0.7, 9.0))
    one = best_drive.Candidates(np.full(2, 0.5), np.ones(2), np.array([1.0, 0.0]), np.ones(2), *yields)
    np.testing.assert_allclose(one.value(largest, 0.1), [value, np.nan])


def test_a_kick_is_tried_at_the_best_drive_alone_if_it_lies_at_the_edge(monkeypatch):
    plane = plane_of(CONE, 5)
    asked = record(monkeypatch, best_drive, coexisting={"kick_high": np.array([0.5])})
    kicks = [best_drive._kick(plane, best_drive.Candidates(0.7, 0.4, 1.0, edge, *[1.0] * 4)) for edge in (0.0, 1.0)]
    np.testing.assert_array_equal(kicks, [np.nan, 0.5])
    (one,) = asked["coexisting"]
    members, disc = one["members"], one["states"][:, :2].tolist()
    assert (members.size, float(members.drive_frequency[0]), disc) == (1, 0.7, [[plane.rest + NUDGE, 0.0]])
    assert (float(members.peak_voltage[0]), one["threads"]) == (pytest.approx(0.4), 5)


def test_the_last_search_is_around_the_largest_value_along_the_edge(monkeypatch):
    """Stroke 1/(1 + (20 log(w/1.37))^2) times the voltage: its vertex is found between the frequencies examined."""
    known, edge = np.array([1.2, 1.3, 1.4, 1.5]), np.array([1.0, 1.1, 1.2, 1.3])
    examined = {}

    def examine(omegas, peaks):
        examined.update(omegas=omegas, peaks=peaks)
        stroke = 1.0 / (1.0 + (20.0 * np.log(omegas / 1.37)) ** 2)
        regime = np.where(omegas < 1.31, int(Regime.CHAOTIC), int(Regime.PERIODIC))
        return {"stroke": stroke, "damper_power": stroke, "power": stroke, "apparent_power": stroke, "regime": regime}

    monkeypatch.setattr(best_drive, "_edge", lambda *given: (known, edge, known))
    found = best_drive._closest(SimpleNamespace(examine=examine), "stroke", 0.1, 1.4, "wide", "near")
    np.testing.assert_allclose(found, 1.37 * np.array([0.99, 1.0, 1.01]), rtol=1e-5)
    np.testing.assert_allclose(examined["omegas"][[0, -1]], [1.3, 1.5])
    np.testing.assert_allclose(1.0 / examined["peaks"], np.interp(examined["omegas"], known, 1.0 / edge))
    monkeypatch.setattr(best_drive, "_edge", lambda *given: (known[:2], edge[:2], known[:2]))
    at_end = best_drive._closest(SimpleNamespace(examine=lambda w, v: examine(w, v) | {"stroke": w, "regime": 0 * w +
        int(Regime.PERIODIC)}), "stroke", 0.1, 1.3)  # fmt: skip
    np.testing.assert_allclose(at_end, [0.99 * 1.3, 1.3])
    nothing = lambda w, v: examine(w, v) | {"stroke": np.full(w.size, np.nan)}  # noqa: E731
    assert best_drive._closest(SimpleNamespace(examine=nothing), "stroke", 0.1, 1.3).tolist() == [0.99 * 1.3, 1.3]


def test_strokes_at_other_frequencies_are_those_of_settled_motions(found):
    for share, stroke in zip(found["detuning"].values, found["detuned_stroke"].values, strict=True):
        own = at(found, drive_frequency=float(found["drive_frequency"]) * (1.0 + share))
        assert stroke == pytest.approx(float(own["stroke"]), rel=1e-3)


def test_the_last_search_finds_more(found, monkeypatch):
    monkeypatch.setattr(best_drive, "_closest", lambda plane, largest, zeta, omega, *_: np.array([0.99, 1.0]) * omega)
    less = drive(CONE, **RANGE, threads=1)
    assert float(found["stroke"]) > 1.01 * float(less["stroke"])


def test_the_edge_is_that_of_both_searches_and_of_the_closer_one_where_they_meet():
    wide = made_up(2.0, 1.4, 2.0, 1.9)
    near = made_up(1.1, 1.2, 1.3, 1.8).assign(drive_frequency=("f", [1.0, 1.1, 1.2, 1.5]))
    frequency, peak, value = best_drive._edge("stroke", 0.1, wide, near)
    np.testing.assert_array_equal(frequency, [0.5, 0.995, 1.0, 1.1, 1.2, 1.5])
    np.testing.assert_allclose(peak, 0.8 * np.array([2.0, 1.4, 1.1, 1.2, 1.3, 1.8]))
    np.testing.assert_allclose(value, [1.0, 2.0, 1.0, 2.0, 9.0, 3.0])


def searched(monkeypatch, **parts):
    """All searches made up, the later ones with other limits, and what was asked for."""
    wide = made_up(2.0, 1.4, 2.0, 1.9).assign(
        window_damper_power=("f", [0.5, 0.25, 0.75, 4.0]), window_apparent_power=("f", [5.0, 6.0, 7.0, 8.0])
    )
    near = made_up(1.8, 1.9, 1.95, 2.0).assign(drive_frequency=("f", [1.2, 1.4, 1.6, 1.9]))
    near = near.assign(window_damper_power=("f", [0.1, 0.2, 0.6, 0.3]), window_apparent_power=("f", [15.0, 16, 17, 18]))
    near = near.assign(window_power=("f", [1.5, 1.6, 1.7, 1.8]))
    last = near.isel(f=slice(0, 3)).assign(drive_frequency=("f", [1.58, 1.61, 1.64]))
    last, asked, made_windows = last.assign(window_stroke=("f", [1.0, 2.0, 3.0])), {}, iter(range(3))

    def windows(plane, static_limits, *, peaks=None, **options):
        number = next(made_windows)
        asked[("first", "second", "third")[number]] = options | {
            "cone": plane.model,
            "plane": plane,
            "threads": plane.threads,
            "peaks": peaks,
            "static": static_limits,
        }
        if options["progress"] is not None:
            options["progress"](1.0)
        return (wide, near, last)[number]

    motion = {name: ("time", numbers(3, at=k)) for k, name in enumerate(("displacement", "drive_voltage", "time"))}
    made = {"settled_periods": xr.Dataset(motion), "_sensitivities": (["a", "b"], np.array([0.25, -0.5]))}
    made |= {"_closest": np.array([1.58, 1.61, 1.64])}
    beside = {"stroke": np.array([4.0, 5.0]), "outcome": np.array([0.0, float(Outcome.PULLED_IN)])}
    monkeypatch.setattr(Plane, "examine", lambda plane, omegas, peaks: asked.update(beside=(omegas, peaks)) or beside)
    made |= {"static_limits_of": np.array([1.5, np.nan]), "coexisting": {"kick_high": np.array([7.0])}}
    asked |= record(monkeypatch, best_drive, **(made | parts))
    monkeypatch.setattr(best_drive, "window_of", windows)
    return asked


def test_the_best_drive_says_of_each_number_what_was_found(monkeypatch):
    """The stroke is largest at 1.6 in the second search, at 0.8 x 1.95; 1.5 and 1.9 next to it have other limits."""
    asked, shares = searched(monkeypatch), []
    found = drive(CONE, lowest_frequency=0.7, highest_frequency=1.7, margin=0.2, threads=5, progress=shares.append)
    np.testing.assert_allclose(asked["first"]["frequencies"], np.geomspace(0.7, 1.7, best_drive.COARSE))
    np.testing.assert_allclose(asked["second"]["frequencies"], np.geomspace(1.0, 1.5, best_drive.FINE))
    np.testing.assert_allclose(asked["second"]["peaks"], 1.9 * np.linspace(*best_drive.PEAKS))
    (closest,) = asked["_closest"]
    assert (closest["largest"], closest["damping_ratio"], closest["omega"]) == ("stroke", 0.1, 1.6)
    np.testing.assert_array_equal(asked["third"]["frequencies"], [1.58, 1.61, 1.64])
    np.testing.assert_array_equal(asked["third"]["peaks"], asked["second"]["peaks"])
    for part in ("first", "second", "third"):
        assert (asked[part]["margin"], asked[part]["threads"], asked[part]["cone"]) == (0.2, 5, CONE), part
        assert asked[part]["to_first"], part
    assert asked["first"]["static"] is asked["second"]["static"] is asked["third"]["static"]
    assert len(asked["static_limits_of"]) == len(asked["coexisting"]) == 1
    assert sum(shares) == pytest.approx(1.0)
    peak = 0.8 * 1.95
    np.testing.assert_allclose(asked["beside"], [[0.99 * 1.6, 1.01 * 1.6], [peak, peak]])
    np.testing.assert_array_equal(found["detuned_stroke"], [4.0, np.nan])
    np.testing.assert_allclose(found["detuning"], [-0.01, 0.01])
    expected = {
        "drive_frequency": 1.6, "peak_voltage": peak, "voltage": peak * 2.0 / 3.0, "voltage_bias": peak / 3.0,
        "stroke": 9.0, "work": 0.6 * 2.0 * np.pi / 1.6, "speed": np.sqrt(0.6 / 0.2), "power": 0.6,
        "supplied_power": 1.7,
        "apparent_power": 17.0, "limit_voltage": 1.95, "frequency_low": 1.0, "frequency_high": 1.9, "kick": 7.0,
        "undecided_motions": 0,
    }  # fmt: skip
    for name, value in expected.items():
        assert float(found[name]) == pytest.approx(value), name
    np.testing.assert_array_equal(found["frequency"], [0.5, 0.995, 1.0, 1.2, 1.4, 1.5, 1.58, 1.6, 1.61, 1.64, 1.9])
    peaks = [2.0, 1.4, 2.0, 1.8, 1.9, 1.9, 1.8, 1.95, 1.9, 1.95, 2.0]
    np.testing.assert_allclose(found["window_peak"], 0.8 * np.array(peaks))
    np.testing.assert_array_equal(found["window_value"], [1.0, 2.0, 9.0, 1.0, 2.0, 3.0, 1.0, 9.0, 2.0, 3.0, 3.0])
    for k, name in enumerate(("displacement", "drive_voltage", "time")):
        np.testing.assert_array_equal(found[name], numbers(3, at=k), name)
    assert (found["field"].values.tolist(), found["sensitivity"].values.tolist()) == (["a", "b"], [0.25, -0.5])
    chosen, (one,) = asked["settled_periods"][0]["chosen"], asked["_sensitivities"]
    assert (one["chosen"], one["device"], one["threads"]) == (chosen, None, 5)
    assert asked["settled_periods"][0]["threads"] == 5
    assert (chosen.voltage, chosen.voltage_bias, chosen.drive_frequency) == pytest.approx((peak * 2 / 3, peak / 3, 1.6))
    assert (found.attrs["limit"], found.attrs["largest"]) == ("pull-in", "stroke")
    assert json.loads(found.attrs["options"]) == {
        **{"largest": "stroke", "margin": 0.2},
        **{"lowest_frequency": 0.7, "highest_frequency": 1.7, "patience": None},
    }


def test_motions_that_are_undecided_within_the_patience_are_counted_and_said(monkeypatch):
    asked = searched(monkeypatch)
    undecided = np.array([[Regime.TRANSIENT], [Regime.PERIODIC], [Regime.CHAOTIC], [Regime.TRANSIENT]])
    monkeypatch.setattr(best_drive, "_searches", with_regime(best_drive._searches, undecided))
    found = drive(CONE, lowest_frequency=0.7, highest_frequency=1.7, patience=50.0)
    assert int(found["undecided_motions"]) == 2
    assert "2 examined motions neither settled nor showed chaos, and are not taken: --patience" in gelcone.in_words(
        found
    )
    assert (asked["first"]["plane"].patience, asked["first"]["plane"].brief) == (50.0, True)
    with pytest.raises(InputError, match="patience = 0: must be positive"):
        drive(CONE, lowest_frequency=0.7, highest_frequency=1.7, patience=0.0)


def with_regime(searches, regime):
    """The searches, the motions of the first of which have other regimes."""

    def made(*given, **options):
        wide, *others = searches(*given, **options)
        return wide.assign(regime=(("f", "peak"), regime)), *others

    return made


def test_what_is_largest_may_lie_in_the_first_search(monkeypatch):
    """The power, at 1.5 there, although the second search lies around it."""
    searched(monkeypatch)
    found = drive(CONE, largest="power", lowest_frequency=0.7, highest_frequency=1.7)
    assert (float(found["drive_frequency"]), float(found["power"]), float(found["stroke"])) == (1.5, 4.0, 3.0)
    assert (float(found["apparent_power"]), float(found["limit_voltage"])) == (8.0, 1.9)
    assert found["window_value"].attrs["quantity"] == "power"


def test_two_periods_begin_at_the_last_point_that_is_known_of_the_settled_motion(monkeypatch):
    asked = {}
    points = np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6], [np.nan, np.nan]])

    def kinds(model, start, **options):
        asked["regime"] = model, start, options
        return {"section": xr.DataArray(points)}

    def runs(model, start, **options):
        asked["simulate"] = model, start.tolist(), options
        return "run"

    parts = {best_drive.regime: kinds, best_drive.simulate: runs}
    monkeypatch.setattr(best_drive, "plain", parts.__getitem__)
    monkeypatch.setattr(best_drive, "rest_displacement", lambda model: 0.25)
    assert best_drive.settled_periods(CONE, 5) == "run"
    assert asked["regime"] == (CONE, (0.25 + NUDGE, 0.0), {"threads": 5})
    assert asked["simulate"] == (CONE, [0.5, 0.6], {"periods": 2.0, "threads": 5})


@pytest.mark.parametrize(
    "device", [None, gelcone.find_device("biased-pump").replace(film="taut", voltage_offset="200 V")]
)
def test_sensitivities_are_slopes_of_logarithms_at_the_drive_in_each_number_alone(monkeypatch, device):
    """Of a made-up amplitude exp(v + 2 v0 + 3 omega), which has the slopes v, 2 v0 and 3 omega."""
    asked = {}

    def swings(members, states, *, only_extent, threads):
        asked["options"] = only_extent, threads
        names = zip((1.0, 2.0, 3.0), ("voltage", "voltage_bias", "drive_frequency"), strict=True)
        amplitude = np.exp(sum(by * np.broadcast_to(members.number(name), members.size) for by, name in names))
        return SimpleNamespace(amplitude=amplitude, forcing_periods=np.where(np.arange(members.size) == 1, 0, 1))

    monkeypatch.setattr(best_drive, "settled_swing", swings)
    chosen = (CONE if device is None else device.to_model()).replace(voltage=0.3, voltage_bias=0.2, drive_frequency=0.7)
    names, change = best_drive._sensitivities(chosen, device, 5)
    slopes = dict(zip(names, change.tolist(), strict=True))
    own = ("voltage", "voltage_bias", "drive_frequency")
    own = own if device is None else ("voltage_amplitude", "voltage_offset", "frequency")
    for name, slope in zip(own, (0.3, 0.4, 2.1), strict=True):
        assert slopes.pop(name) == pytest.approx(slope, rel=1e-4), name
    assert np.isnan(slopes.pop(names[0]))  # one of its two motions is not periodic
    if device is None:
        assert set(slopes.values()) == {0.0}
    assert asked["options"] == (True, 5)


@pytest.mark.parametrize(("steep", "known"), [(24.0, True), (26.0, False)])
def test_a_stroke_that_jumps_within_a_per_cent_has_no_sensitivity(monkeypatch, steep, known):
    """Made-up amplitudes v^24 and v^26: e^0.48 and e^0.52 within 2 % of v."""
    swing = lambda members, states, **options: SimpleNamespace(  # noqa: E731
        amplitude=np.broadcast_to(members.number("voltage"), members.size) ** steep,
        forcing_periods=np.ones(members.size),
    )
    monkeypatch.setattr(best_drive, "settled_swing", swing)
    names, change = best_drive._sensitivities(CONE, None, 1)
    own = change[names.index("voltage")]
    assert own == pytest.approx(steep, rel=1e-3) if known else np.isnan(own)
