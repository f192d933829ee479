"""Branches against certified bifurcations, and what the result says of them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import gelcone
from gelcone import InputError
from gelcone.atlas.branches import check, continuation, follow
from gelcone.atlas.branches.branch import Ending
from gelcone.atlas.branches.point import Corrected
from gelcone.atlas.branches.varied import vary
from gelcone.codes import Regime
from gelcone.motion.flow import integrate
from gelcone.presets import find_preset
from tests.atlas.branches.events import events_of

REFERENCES = {
    r["key"]: r
    for r in json.loads((Path(__file__).parents[2] / "reference" / "continuation.json").read_text())["references"]
}
BASE = find_preset("base").model
SPRING = find_preset("spring").model.replace(damping_ratio=0.01)


@pytest.fixture(scope="module")
def base():
    return gelcone.continue_branch(BASE, "voltage", 0.935, 1.38, switch=1, checks=4)


@pytest.fixture(scope="module")
def cascade():
    """A narrow interval, on which the born branches are short."""
    return gelcone.continue_branch(BASE, "voltage", 0.9995, 1.029, start="settled", switch=5, checks=2)


def matches(result, key):
    """The event of a result that a reference certifies: same kind, period and value to 1e-9."""
    reference = REFERENCES[key]
    kind = {"pitchfork_of_rest": "loss of rest"}.get(reference["type"], reference["type"].replace("_", " "))
    return [
        event
        for event in events_of(result)
        if event["kind"] == kind
        and event["period"] == reference["period_in_drive_repeats"]
        and abs(event["value"] - reference["value"]) < 1e-9
    ]


BASE_KEYS = [k for k, r in REFERENCES.items() if k.startswith("base/") and r["type"] not in ("orbit", "estimate")]


@pytest.mark.parametrize("key", BASE_KEYS)
def test_certified_bifurcation_of_the_base_set(base, cascade, key):
    result = cascade if "cascade" in key else base
    (event,) = matches(result, key)
    reference = REFERENCES[key]
    assert abs(event["value"] - reference["value"]) <= max(3.0 * event["value_error"], 2e-15)
    expected = np.array(reference["multipliers_of_that_map"])
    np.testing.assert_allclose(event["multipliers"], expected, rtol=1e-7, atol=1e-12)
    k = events_of(result).index(event)
    orbit = result["event_orbit"].values[k]
    state = np.array(reference["orbit_state_at_phase_0"])
    per = int(result["nodes_per_repeat"][event["branch"]])
    starts = orbit[: per * event["period"] : per]
    assert min(np.abs(start - sign * state).max() for start in starts for sign in (1, -1)) < 1e-9


def test_feigenbaum_ratios_of_the_cascade(cascade):
    keys = ["base/period1/pd1"] + [f"base/cascade/pd{k}" for k in range(2, 7)]
    gaps = np.diff([matches(cascade, key)[0]["value"] for key in keys])
    expected = REFERENCES["base/cascade/accumulation"]["feigenbaum_ratios"]
    np.testing.assert_allclose(gaps[:-1] / gaps[1:], expected, rtol=1e-6)


def test_cascade_is_a_chain_of_supercritical_births(cascade):
    (event,) = matches(cascade, "base/period1/pd1")
    for k in range(2, 7):
        assert event["supercritical"]
        born = event["born_branch"]
        (event,) = matches(cascade, f"base/cascade/pd{k}")
        assert event["branch"] == born


def test_curvature_of_born_branches(base):
    events = events_of(base)
    k = events.index(matches(base, "base/period1/pd1")[0])
    expected = REFERENCES["base/period1/pd1"]["branch_curvature"]
    # the largest node may lie elsewhere among twice as many nodes
    assert float(base["event_curvature"][k]) == pytest.approx(expected, rel=0.2)


def test_a_branch_that_merges_is_the_one_of_both_doublings(base):
    right, after = matches(base, "base/period1/pd_right")[0], matches(base, "base/period1/pd_after_fold")[0]
    assert right["born_branch"] == after["born_branch"] is not None
    ended = base["ended"].values[right["born_branch"]]
    assert list(ended) == [Ending.MERGED, Ending.MERGED]


def test_orbits_solve_the_equation_of_motion(base):
    number = matches(base, "base/period1/pd1")[0]["branch"]
    point = int(np.nanargmax(base["value"].values[number]))
    voltage, nodes = float(base["value"][number, point]), base["orbit"].values[number, point]
    stride = np.pi / 0.1 / int(base["nodes_per_repeat"][number])

    def rate(time, state):
        x, u = state
        q = 1.0 + x * x
        film = x * (1.0 - 1.0 / (q * q)) / (1.0 - (q + 1.0 + 1.0 / q - 3.0) / 50.0)
        return [u, -0.02 * u - 0.9 * x - film + (voltage * np.sin(0.1 * time)) ** 2 * x]

    count = int(np.isfinite(nodes[:, 0]).sum())
    for k in range(count):
        run = solve_ivp(rate, (k * stride, (k + 1) * stride), nodes[k], rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(run.y[:, -1], nodes[(k + 1) % count], atol=1e-8)


def test_brute_force_and_branches_agree(base):
    assert int(base["checked_orbits"]) > 50
    unexplained = [k for k in range(base.sizes["flag"]) if not str(base["flag_explanation"][k].values)]
    assert not unexplained


def test_extent_is_that_of_the_motion():
    result = gelcone.continue_branch(SPRING, "drive_frequency", 2.0, 2.5, start="settled", checks=2)
    for point in (0, -1):
        own = result.isel(branch=0, point=point)
        settled = gelcone.settled(SPRING.replace(drive_frequency=float(own["value"])))
        assert float(own["highest"]) == pytest.approx(float(settled["highest"]), abs=1e-6)
        assert float(own["lowest"]) == pytest.approx(float(settled["lowest"]), abs=1e-6)


def test_extents_and_symmetry_are_those_of_the_orbit_integrated_over_its_period(base):
    """One orbit of each branch, in the middle; all of a symmetric branch reach as far to both sides."""
    for number in range(base.sizes["branch"]):
        own = base.isel(branch=number)
        found = np.flatnonzero(np.isfinite(own["lowest"].values))
        point = own.isel(point=found[found.size // 2])
        model = BASE.replace(voltage=float(point["value"]))
        times = np.linspace(0.0, float(own["period"]) * model.forcing_period, 20_001)
        x = integrate(model, point["orbit"].values[0], times).states[0, :, 0]
        assert float(point["lowest"]) == pytest.approx(x.min(), abs=3e-4)
        assert float(point["highest"]) == pytest.approx(x.max(), abs=3e-4)
        mirrored = bool(np.allclose(x + np.roll(x[:-1], 10_000)[np.arange(20_001) % 20_000], 0.0, atol=1e-6))
        assert bool(own["symmetric"]) == (mirrored and np.abs(x).max() > 0.0)
        if own["symmetric"]:
            np.testing.assert_array_equal(own["lowest"].values[found], -own["highest"].values[found])


def test_extents_of_mirrored_orbits_are_mirrored(monkeypatch):
    """Symmetric orbits reach as far to both sides, in whichever half of their period they reach the farthest."""
    branches, extent = [], continuation._extent
    monkeypatch.setattr(continuation, "_extent", lambda branch: branches.append(branch) or extent(branch))
    gelcone.continue_branch(BASE, "voltage", 0.935, 1.0, switch=1, checks=2)
    reflected = [branch.shooting.kind.reflected for branch in branches]
    assert {True, False} <= set(reflected)
    for branch in branches:
        image = replace(branch, points=[replace(point, nodes=-point.nodes) for point in branch.points[1:4]])
        low, high, _ = extent(replace(branch, points=branch.points[1:4]))
        lower, higher, _ = extent(image)
        np.testing.assert_allclose(lower, -high, atol=1e-12)
        np.testing.assert_allclose(higher, -low, atol=1e-12)


def test_flags_of_both_checks_are_in_the_result(monkeypatch):
    one, other = check.Flag(check.NO_ORBIT, -1, 0.5), check.Flag(check.LEAVES, 0, 0.6, "nearby")
    monkeypatch.setattr(continuation, "cover", lambda *_, **__: check.Checked(7, 5, 0, [one]))
    monkeypatch.setattr(continuation, "run_perturbed", lambda *_, **__: check.Checked(0, 0, 9, [other]))
    model = gelcone.ConeModel(damping_ratio=0.1, spring_stiffness=0.5, drive_frequency=0.5)
    result = gelcone.continue_branch(model, "voltage", 0.4, 0.7, checks=2, switch=0)
    assert result["flag_kind"].values.tolist() == [check.FLAGS.index(flag.kind) for flag in (one, other)]
    assert result["flag_branch"].values.tolist() == [-1, 0]
    assert result["flag_value"].values.tolist() == [0.5, 0.6]
    assert result["flag_explanation"].values.tolist() == ["", "nearby"]
    assert [int(result[name]) for name in ("checked_cycles", "seeded", "checked_orbits")] == [7, 5, 9]


@pytest.mark.parametrize(("share", "found"), [(0.5, True), (2.0, False)])
def test_an_orbit_far_from_the_motion_is_not_the_orbit_of_the_motion(monkeypatch, share, found):
    point = object()
    monkeypatch.setattr(check, "at_value", lambda *_: Corrected(point, True, share * check.FARTHEST))
    shooting = vary(BASE, {"voltage": (0.95, 1.0)}, (1.0, 0.0)).shooting(1e-9)
    assert (check.polished(shooting, np.array([[0.3, 0.0]]), 0.97, 1.0) is point) == found


@pytest.mark.parametrize("key", [k for k in REFERENCES if k.startswith("frequency/spring_zeta0.01")])
def test_certified_bifurcation_over_the_frequency(frequencies, key):
    assert matches(frequencies, key)


@pytest.fixture(scope="module")
def frequencies():
    return gelcone.continue_branch(SPRING, "drive_frequency", 0.45, 1.2, start="settled", switch=0, checks=4)


def test_spring_set_has_no_bifurcation_over_the_frequency():
    reference = REFERENCES["frequency/spring_preset"]
    result = gelcone.continue_branch(
        find_preset("spring").model, "drive_frequency", *reference["interval"], start="settled", checks=2
    )
    assert result.sizes["event"] == 0
    assert result.sizes["branch"] == 1
    largest = np.hypot(result["multiplier_real"], result["multiplier_imag"]).max()
    assert float(largest) == pytest.approx(reference["largest_multiplier_modulus"], abs=2e-3)


def test_a_branch_ends_at_the_stretch_limit_or_the_interval():
    stiff = BASE.replace(stretch_limit=0.2, voltage=1.2)
    result = gelcone.continue_branch(stiff, "voltage", 0.93, 1.1, (0.3, 0.0), checks=2, switch=0)
    assert set(result["ended"].values.ravel()) <= {Ending.LIMIT, Ending.REST, Ending.WALL}


def test_a_result_can_be_gone_on_from(frequencies, tmp_path):
    gelcone.save(frequencies, tmp_path / "branches.nc")
    again = gelcone.load(tmp_path / "branches.nc")
    np.testing.assert_array_equal(again["value"], frequencies["value"])
    result = gelcone.continue_branch(SPRING, "drive_frequency", 0.45, 1.2, start=again, switch=0)
    folds = [sorted(e["value"] for e in events_of(r) if e["kind"] == "fold") for r in (result, frequencies)]
    np.testing.assert_allclose(*folds, rtol=1e-12)


def test_a_diagram_seeds_branches_that_rest_does_not_reach():
    fast = find_preset("fast").model
    diagram = gelcone.bifurcation(fast, "voltage", [0.8, 0.85, 0.9], sweeps=(), bisections=0)
    result = gelcone.continue_branch(fast, "voltage", 0.75, 0.95, start=diagram)
    assert int(result["checked_cycles"]) == 3
    assert result.sizes["flag"] == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("voltage", 1.2, 1.0), "swap the ends"),
        (("voltage", 1.0, 1.0), "swap the ends"),
        (("voltag", 1.0, 1.2), "did you mean 'voltage'"),
        (("displacement", 0.0, 1.0), "initial state"),
        (("voltage", -1.0, 1.0), "voltage = -1"),
    ],
)
def test_bad_intervals_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        gelcone.continue_branch(BASE, *arguments)


def test_bad_options_are_refused():
    with pytest.raises(InputError, match="points = 0: must be at least 2"):
        gelcone.continue_branch(BASE, "voltage", 1.0, 1.2, points=0)
    with pytest.raises(InputError, match=r"tolerance = 0.0: must be between 0 and 1"):
        gelcone.continue_branch(BASE, "voltage", 1.0, 1.2, tolerance=0.0)
    with pytest.raises(InputError, match="did you mean 'settled'"):
        gelcone.continue_branch(BASE, "voltage", 1.0, 1.2, start="setled")
    with pytest.raises(InputError, match="is not an orbit"):
        gelcone.continue_branch(BASE, "voltage", 1.3, 1.32, start="settled")
    with pytest.raises(InputError, match="ensemble"):
        gelcone.continue_branch(BASE.replace(voltage=[1.0, 1.1]), "damping_ratio", 0.1, 0.2)


def test_a_device_is_followed_in_its_units_until_it_pulls_in(command_line):
    hard = ["--film", "wrinkling", "--set", "voltage_amplitude=901 V", "--set", "voltage_offset=1.126 kV"]
    code, out, err = command_line(
        "continue", "biased-pump", "frequency", "9 Hz", "11 Hz", "--from", "settled", "--checks", "2", *hard
    )
    assert code == 0, err
    assert "frequency 9 to 10.6649 Hz" in out
    assert "pulls in" in out
    code, _, err = command_line("continue", "biased-pump", "frequency", "11 Hz", "9 Hz")
    assert code == 2
    assert err.count("\n") == 1


def test_a_drive_with_corners_is_followed_and_agrees_with_brute_force():
    model = gelcone.ConeModel(
        damping_ratio=0.05, drive_frequency=0.8, voltage=0.3, rest_height=0.2, waveform="triangle"
    )
    found = gelcone.continue_branch(model, "voltage", 0.3, 0.32, checks=4)
    at = np.abs(found["value"].values[0] - 0.3).argmin()
    motion = gelcone.regime(model, found["orbit"].values[0, at, 0])
    np.testing.assert_allclose(motion["section"].values[-1], found["orbit"].values[0, at, 0], rtol=0.0, atol=1e-10)
    assert motion["period"] == 1
    assert found.sizes["flag"] == 0


def test_progress_goes_on_while_branches_are_followed():
    told = []
    gelcone.continue_branch(BASE, "voltage", 0.935, 1.0, switch=0, checks=2, progress=told.append)
    assert sum(told) == pytest.approx(1.0)
    assert len(told) > 20
    assert max(told) < 0.5


def test_an_interrupt_ends_it_in_one_line(command_line, monkeypatch):
    """Whatever is under way: here the tenth point of a branch."""
    points = []

    def correct(*arguments, **options):
        points.append(arguments)
        if len(points) == 10:
            raise KeyboardInterrupt
        return original(*arguments, **options)

    original = follow.correct
    monkeypatch.setattr(follow, "correct", correct)
    code, out, err = command_line("continue", "voltage", "0.935", "1.0", "--preset", "base")
    assert (code, out) == (130, "")
    assert err.strip().count("\n") == 0
    assert "interrupted" in err.lower()


def test_settled_motions_of_a_diagram_are_runs_of_cycles_and_rests():
    """Of an odd period none is its own mirror image; what is neither rests nor repeats has no period."""
    kinds = [Regime.PERIODIC, Regime.PERIODIC, Regime.REST, Regime.CHAOTIC]
    at = ("branch", "voltage")
    diagram = xr.Dataset(
        {
            "regime": (at, [kinds]), "period": (at, [[2, 3, 0, 0]]), "symmetric": (at, [[1, 1, 0, 1]]),
            "section": ((*at, "repeat", "state"), np.arange(16.0).reshape(1, 4, 2, 2), {"units": "1"}),
        },
        coords={"voltage": ("voltage", [0.9, 0.95, 1.0, 1.05], {"units": "1"})},
        attrs={"parameter": "voltage", "title": "bifurcation diagram"},
    )  # fmt: skip
    runs = continuation._runs(diagram, vary(BASE, {"voltage": (0.9, 1.1)}, (1.0, 0.0)))
    assert runs.period.tolist() == [2, 3, 1, 0]
    assert runs.symmetric.tolist() == [True, False, False, True]
    assert runs.arrived.tolist() == [True, True, True, False]
    assert runs.values.tolist() == [0.9, 0.95, 1.0, 1.05]
    np.testing.assert_array_equal(runs.section, diagram["section"].values[0])
    with pytest.raises(InputError, match="along 'voltage'; give one along 'damping_ratio'"):
        continuation._runs(diagram, vary(BASE, {"damping_ratio": (0.1, 0.2)}, (1.0, 0.0)))
