"""Branches against certified bifurcations, and what the result says of them."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import gelcone
from gelcone import InputError
from gelcone.atlas.branches import check, continuation, follow
from gelcone.atlas.branches.branch import Branch, Ending, Event, EventKind, Walk
from gelcone.atlas.branches.event import Born, Singular
from gelcone.atlas.branches.point import Corrected, Point
from gelcone.atlas.branches.varied import vary
from gelcone.codes import Regime
from gelcone.motion.flow import integrate
from gelcone.motion.orbit import Kind
from gelcone.motion.validity import unknown
from gelcone.presets import find_preset
from tests.atlas.branches.events import events_of
from tests.recorded import record

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
    monkeypatch.setattr(check, "at_value", lambda *_: Corrected(point, True, share * check.FARTHEST_CYCLE))
    shooting = vary(BASE, {"voltage": (0.95, 1.0)}, (1.0, 0.0)).shooting(1e-9)
    run = check.Runs(np.array([0.97]), np.array([[[0.3, 0.0]]]), np.array([1]), np.array([False]), np.array([True]))
    assert (check.polished(shooting, run, 0, 1.0)[1] is point) == found


def test_the_orbit_of_a_motion_is_searched_from_its_last_state_with_its_period_and_symmetry(monkeypatch):
    asked = []

    def moved(members, state, times, **flow):
        asked.append((members.number("voltage")[0], state.tolist(), times.size, flow))
        return SimpleNamespace(states=np.zeros((1, times.size, 2)))

    monkeypatch.setattr(check, "integrate", moved)
    monkeypatch.setattr(check, "at_value", lambda own, nodes, value, metric: Corrected((own.kind, value), True, 0.0))
    shooting = vary(BASE, {"voltage": (0.95, 1.0)}, (1.0, 0.0)).shooting(1e-9)
    section = np.arange(12.0).reshape(3, 2, 2)
    symmetric = np.array([False, True, False])
    runs = check.Runs(np.array([0.96, 0.97, 0.98]), section, np.array([1, 2, 2]), symmetric, symmetric)
    flow = {"tolerance": 2e-9, "threads": 5}
    for k, kind in enumerate((Kind(1), Kind(1, True), Kind(2))):
        own, point = check.polished(shooting, runs, k, 1.0, **flow)
        assert (own.kind, point) == (kind, (kind, runs.values[k]))
        assert asked.pop() == (runs.values[k], section[k, 1].tolist(), own.count, flow)


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


def test_branches_start_from_a_result_in_which_the_disc_only_rests():
    model = gelcone.ConeModel(damping_ratio=0.1, spring_stiffness=0.5, drive_frequency=0.5)
    rest = gelcone.continue_branch(model, "voltage", 0.1, 0.2, checks=2)
    assert rest.resting.values.tolist() == [1]
    again = gelcone.continue_branch(model, "voltage", 0.1, 0.2, checks=2, start=rest)
    assert again.resting.values.tolist() == [1]
    assert not again.flag_kind.size


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
    with pytest.raises(InputError, match=r"tolerance = 0.0: must be a number above 0 and below 1"):
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


def test_settled_motions_of_a_device_are_runs_at_the_values_that_are_followed():
    """Over the scale of its field, whatever unit the diagram has."""
    at, ones = ("branch", "frequency"), [[1, 1]]
    diagram = xr.Dataset(
        {
            "regime": (at, [[Regime.PERIODIC] * 2]), "period": (at, ones), "symmetric": (at, ones),
            "section": ((*at, "repeat", "state"), np.ones((1, 2, 1, 2)), {"units": "1"}),
        },
        coords={"frequency": ("frequency", [9.0, 10.0], {"units": "Hz"})},
        attrs={"parameter": "frequency", "title": "bifurcation diagram"},
    )  # fmt: skip
    varied = vary(PUMP, {"frequency": (9.0, 11.0)})
    models = [PUMP.replace(frequency=hertz).to_model() for hertz in (9.0, 10.0)]
    expected = [float(model.drive_frequency) for model in models]
    np.testing.assert_allclose(continuation._runs(diagram, varied).values, expected)


# --- made-up branches: each number says where it belongs --------------------------------------------------------------

PUMP = gelcone.find_device("biased-pump").replace(film="taut")


class World:
    """In place of shooting: maps of a repeat in a time of 3 over the value, cut into segments."""

    system = gelcone.ConeModel().members().system
    size, symmetric, phase = 2, False, np.pi

    def __init__(self, kind, segments):
        self.kind, self.segments, self.count = kind, segments, segments * kind.repeats
        self.signs = -np.ones(2) if kind.reflected else np.ones(2)

    def repeat_time(self, values):
        return 3.0 / values[0]


def nodes_of(world, value):
    return value + 0.01 * np.arange(2 * world.count, dtype=float).reshape(world.count, 2)


def a_branch(world, values, multipliers, **own):
    points = [
        Point(nodes_of(world, value), value, np.array(two, dtype=complex), None)
        for value, two in zip(values, multipliers, strict=True)
    ]
    return Branch(world, points, **own)


def an_event(world, kind, value, after, curvature=None, unstable=1.0, **own):
    none = np.zeros((world.count, 2))
    orbit = Singular(nodes_of(world, value), np.array([value]), np.array([0.1 * value]), none, none,
                     np.array([-0.5 + 0.25j, 0.1]), -1.0)  # fmt: skip
    born = None if curvature is None else Born(curvature, none)
    return Event(kind, orbit, born, unstable, after, world.kind, **own)


def some_branches():
    """One of period 1 with two events; one of mirrored orbits, born at the second; one of period 3 with 48 nodes."""
    once, mirrored, thrice = World(Kind(1), 4), World(Kind(1, True), 4), World(Kind(3), 16)
    events = [
        an_event(once, EventKind.FOLD, 0.7, 0, 0.4, 0.0),
        an_event(once, EventKind.LOSS_OF_REST, 0.8, 1, -2.0, -1.0, born_branch=1),
    ]
    last = an_event(mirrored, EventKind.TORUS, 0.9, 0, resolved=False)
    first = a_branch(once, [0.6, 0.8, 1.0], [[0.5j, -0.5j], [-1.5, 0.2], [0.9, 0.0]], events=events, resting=True)
    second = a_branch(mirrored, [0.7, 0.9], [[-0.5, 0.2], [2.0, 0.1]], events=[last], parent=events[1], level=2)
    second.ended = (Ending.REST, Ending.WALL)
    third = a_branch(thrice, [0.95], [[0.25, 0.1]], level=1)
    for number, branch in enumerate((first, second, third)):
        for event in branch.events:
            event.branch = number
    return [first, second, third]


@pytest.fixture(scope="module")
def labelled():
    """The branches as a result over the frequency of a device, and one unit of it in SI."""
    varied, branches = vary(PUMP, {"frequency": (9.0, 11.0)}), some_branches()
    section = np.arange(2 * 70 * 2, dtype=float).reshape(2, 70, 2)
    runs = check.Runs(np.array([0.6, 0.9]), section, np.array([1, 0]), np.zeros(2, bool), np.ones(2, bool))
    checked = check.Checked(7, 1, 9, [check.Flag(check.OTHER_PERIOD, 2, 0.95, "why")])
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(
            continuation, "_extent", lambda own: (own.values - 1.0, own.values + 2.0, unknown(len(own.points)))
        )
        result = continuation._label(varied, SimpleNamespace(branches=branches), runs, checked, {})
    scale = float(varied.scales[0])
    assert not 0.9 < scale < 1.1
    return result, branches, scale


def test_points_have_their_values_orbits_and_multipliers_over_the_whole_period(labelled):
    """Of mirrored orbits the second half too, and the squares; of long ones every fourth node."""
    result, branches, scale = labelled
    for k, (branch, stride) in enumerate(zip(branches, (1, 1, 4), strict=True)):
        own, count = result.isel(branch=k), len(branch.points)
        np.testing.assert_allclose(own["value"][:count], scale * branch.values)
        np.testing.assert_array_equal(own["lowest"][:count], branch.values - 1.0)
        np.testing.assert_array_equal(own["highest"][:count], branch.values + 2.0)
        assert np.isnan(own["value"][count:]).all()
        for point, there in enumerate(branch.points):
            nodes, multipliers = there.nodes, there.multipliers
            if branch.map.reflected:
                nodes, multipliers = np.concatenate([nodes, -nodes]), multipliers**2
            nodes = nodes[::stride]
            np.testing.assert_array_equal(own["orbit"][point, : len(nodes)], nodes)
            assert np.isnan(own["orbit"][point, len(nodes) :]).all()
            np.testing.assert_allclose(own["multiplier_real"][point], multipliers.real)
            np.testing.assert_allclose(own["multiplier_imag"][point], multipliers.imag)
            period = branch.map.period * 3.0 / there.value
            assert float(own["lyapunov"][point]) == pytest.approx(np.log(abs(multipliers[0])) / period)
            assert int(own["stable"][point]) == (abs(multipliers[0]) < 1.0)
        assert (own["stable"][count:] == -1).all()
    assert result["nodes_per_repeat"].values.tolist() == [4, 4, 4]
    assert result["orbit"].sizes["node"] == 12


def test_branches_say_what_they_are_and_where_they_come_from(labelled):
    result, _, _ = labelled
    assert result["period"].values.tolist() == [1, 2, 3]
    assert result["symmetric"].values.tolist() == [0, 1, 0]
    assert result["resting"].values.tolist() == [1, 0, 0]
    assert result["level"].values.tolist() == [0, 2, 1]
    assert result["born"].values.tolist() == [-1, 1, -1]
    assert result["ended"].values.tolist() == [[0, 0], [Ending.REST, Ending.WALL], [0, 0]]


def test_events_have_the_values_of_their_orbits(labelled):
    result, branches, scale = labelled
    values = np.array([0.7, 0.8, 0.9])
    np.testing.assert_allclose(result["event_value"], scale * values)
    np.testing.assert_allclose(result["event_error"], 0.1 * scale * values)
    np.testing.assert_allclose(result["event_curvature"], scale * np.array([0.4, -2.0, np.nan]))
    assert result["event_kind"].values.tolist() == [EventKind.FOLD, EventKind.LOSS_OF_REST, EventKind.TORUS]
    assert result["event_branch"].values.tolist() == [0, 0, 1]
    assert result["event_born_branch"].values.tolist() == [-1, 1, -1]
    assert result["event_point"].values.tolist() == [0, 1, 0]
    assert result["event_supercritical"].values.tolist() == [-1, 1, -1]
    assert result["event_resolved"].values.tolist() == [1, 1, 0]
    orbits = [nodes_of(branches[0].shooting, value) for value in values]
    orbits[2] = np.concatenate([orbits[2], -orbits[2]])
    for k, orbit in enumerate(orbits):
        np.testing.assert_allclose(result["event_orbit"][k, : len(orbit)], orbit)
        assert np.isnan(result["event_orbit"][k, len(orbit) :]).all()
    multipliers = np.array([-0.5 + 0.25j, 0.1])
    expected = np.array([multipliers, multipliers, multipliers**2])
    np.testing.assert_allclose(result["event_multiplier_real"], expected.real)
    np.testing.assert_allclose(result["event_multiplier_imag"], expected.imag)


def test_runs_and_flags_have_the_unit_of_the_field_and_the_last_sections(labelled):
    result, _, scale = labelled
    np.testing.assert_allclose(result["run_value"], scale * np.array([0.6, 0.9]))
    np.testing.assert_array_equal(result["run_section"], np.arange(280.0).reshape(2, 70, 2)[:, -64:])
    assert result["run_period"].values.tolist() == [1, 0]
    np.testing.assert_allclose(result["flag_value"], scale * 0.95)
    assert result["flag_kind"].values.tolist() == [check.FLAGS.index(check.OTHER_PERIOD)]
    assert (result["flag_branch"].values.tolist(), result["flag_explanation"].values.tolist()) == ([2], ["why"])
    assert [int(result[name]) for name in ("checked_cycles", "checked_orbits", "seeded")] == [7, 9, 1]
    assert result["event_value"].attrs["units"] == result["value"].attrs["units"] == "Hz"
    assert result.attrs["parameter"] == "frequency"


@pytest.mark.parametrize(
    ("segments", "kind", "kept"),
    [
        (4, Kind(1), (1, 4)), (16, Kind(1), (1, 16)), (32, Kind(1), (2, 16)), (16, Kind(1, True), (2, 16)),
        (4, Kind(8), (2, 16)), (4, Kind(32), (4, 32)), (8, Kind(3), (2, 12)),
    ],
)  # fmt: skip
def test_at_most_16_nodes_of_an_orbit_are_stored_but_one_in_each_repeat(segments, kind, kept):
    assert continuation._kept(World(kind, segments)) == kept


def test_branches_of_a_result_begin_with_its_middle_orbits(labelled):
    """A branch that rests is none of them, nor one without points."""
    result, branches, scale = labelled
    varied = vary(PUMP, {"frequency": (9.0, 11.0)})
    rest = result.isel(branch=[0]).assign(orbit=0.0 * result["orbit"].isel(branch=[0]))
    none = result.isel(branch=[0]).assign(value=np.nan * result["value"].isel(branch=[0]))
    parts = [name for name in result.variables if "branch" in result[name].dims]
    runs = continuation._runs(
        xr.concat([rest[parts], result[parts], none[parts]], "branch").assign_attrs(result.attrs), varied
    )
    np.testing.assert_allclose(runs.values, [0.8, 0.9, 0.95])
    assert runs.period.tolist() == [1, 2, 3]
    assert runs.symmetric.tolist() == [False, True, False]
    assert (runs.arrived.tolist(), runs.attracting) == ([True] * 3, False)
    first = [branches[k].points[point].nodes[0] for k, point in ((0, 1), (1, 1), (2, 0))]
    expected = varied.without_units(np.array(first)[:, None], result["orbit"].attrs, scale * runs.values)
    np.testing.assert_allclose(runs.section, expected)


def test_a_start_that_is_a_result_stands_by_all_its_numbers():
    """In the plan of a store: another number, name or text anywhere is another start."""
    start = xr.Dataset({"a": ("x", [1.0, 2.0]), "b": ("x", ["p", "q"])}, coords={"x": [3, 4]})
    others = [
        start.assign(a=("x", [1.0, 2.5])), start.assign(b=("x", ["p", "r"])), start.assign_coords(x=[3, 5]),
        start.rename(a="aa"), start[["a"]],
    ]  # fmt: skip
    digests = [continuation._digest(one) for one in (start, *others)]
    assert len(set(digests)) == 6
    assert continuation._digest(start.copy(deep=True)) == digests[0]
    varied = vary(BASE, {"voltage": (0.9, 1.1)}, (1.0, 0.0))
    plans = [continuation._plan(varied, {"start": "result", "switch": 1}, one) for one in (start, others[0], "rest")]
    assert [plan["options"]["start"] for plan in plans] == [f"result {digests[0]}", f"result {digests[1]}", "result"]
    assert plans[0]["options"]["switch"] == 1
    of_device = continuation._plan(vary(PUMP, {"frequency": (9.0, 11.0)}), {}, "rest")
    assert (plans[0]["device"], of_device["device"]) == (None, PUMP.parameters())


def test_each_point_takes_a_five_hundredth_of_what_is_left_of_its_share():
    told = []
    tick = continuation.point_by_point(told.append, 0.4)
    for _ in range(100):
        tick(None)
    np.testing.assert_allclose(told, 0.4 * 0.002 * 0.998 ** np.arange(100))


def test_a_response_near_equilibrium_begins_where_the_bias_lets_go(monkeypatch):
    """At both ends of the interval, from standing there."""
    model = gelcone.ConeModel(rest_height=0.8, damping_ratio=0.1)
    varied, asked = vary(model, {"voltage": (0.2, 0.5)}, (1.0, 0.3)), []
    world = World(Kind(1), 4)
    world.numbers_at = lambda values: model.own_numbers

    def nothing(walk, shooting, values, starts, **flow):
        asked.append((values.tolist(), starts.tolist()))
        return check.Runs(values, np.zeros((2, 1, 2)), np.zeros(2, int), np.zeros(2, bool), np.zeros(2, bool))

    monkeypatch.setattr(continuation, "brute_force", nothing)
    walk = Walk(0.2, 0.5)
    assert continuation._roots(world, varied, walk, "rest", np.array([[1.0, 0.3]]), {}) == []
    assert asked == [([0.2, 0.5], [[pytest.approx(0.8), 0.0]])]
    with pytest.raises(InputError, match=r"periodic neither at voltage = 0\.2 nor at 0\.5"):
        continuation._roots(world, varied, walk, "settled", np.array([[1.0, 0.3]]), {})
    assert asked[1] == ([0.2, 0.5], [[1.0, 0.3]])


def test_branches_are_checked_at_even_values_from_two_starts(monkeypatch):
    """The initial state and a twentieth of it; what is found is labelled with all options."""
    asked, tree = {}, SimpleNamespace(branches=["one"])
    monkeypatch.setattr(
        type(vary(BASE, {"voltage": (0.9, 1.1)})), "shooting", lambda self, tolerance: ("plane", tolerance)
    )
    monkeypatch.setattr(continuation, "grown", lambda *arguments: asked.update(grown=arguments) or tree)
    monkeypatch.setattr(
        continuation,
        "brute_force",
        lambda walk, line, values, starts, **flow: asked.update(checked=(values, starts, flow)),
    )
    monkeypatch.setattr(continuation, "cover", lambda tree, line, runs, **flow: check.Checked(3, 1, 0, ["first"]))
    monkeypatch.setattr(continuation, "run_perturbed", lambda tree, **flow: check.Checked(0, 0, 5, ["second"]))
    monkeypatch.setattr(continuation, "_label", lambda *arguments: arguments)
    options = {"switch": 3, "checks": 5, "points": 77, "tolerance": 1e-12, "start": "settled"}
    found = gelcone.continue_branch(BASE, "voltage", 0.9, 1.1, (0.6, 0.2), **options)
    _, own, _, checked, said = found
    assert own is tree
    assert checked == check.Checked(3, 1, 5, ["first", "second"])
    assert {name: said[name] for name in options} == options
    assert (said["parameter"], said["low"], said["high"], list(said["initial"])) == ("voltage", 0.9, 1.1, [0.6, 0.2])
    values, starts, flow = asked["checked"]
    np.testing.assert_allclose(values, [0.9, 0.95, 1.0, 1.05, 1.1])
    np.testing.assert_allclose(starts, [[0.6, 0.2], [0.03, 0.01]])
    assert flow == {"tolerance": 1e-12, "threads": None}
    shooting, _, walk, start, states, switch, _ = asked["grown"]
    assert (shooting, start, switch) == (("plane", 1e-12), "settled", 3)
    assert (walk.low, walk.high, walk.most) == (0.9, 1.1, 77)
    np.testing.assert_array_equal(states, [[0.6, 0.2]])


def test_brute_force_begins_as_in_the_middle_of_the_interval_with_the_threads_of_the_call(monkeypatch):
    """Also the runs near orbits, and those of cycles that start branches."""
    own, asked = vary(BASE, {"voltage": (0.9, 1.1)}), []
    tree = SimpleNamespace(branches=["one"])
    monkeypatch.setattr(type(own), "shooting", lambda self, tolerance: "plane")
    monkeypatch.setattr(type(own), "starts", lambda self, values: asked.append(values) or np.array([[0.5, 0.25]]))
    parts = {"grown": tree, "brute_force": "runs", "_label": "labelled"}
    parts |= {"cover": check.Checked(3, 1, 0, []), "run_perturbed": check.Checked(0, 0, 5, [])}
    calls = record(monkeypatch, continuation, **parts)
    assert gelcone.continue_branch(BASE, "voltage", 0.9, 1.1, tolerance=1e-12, threads=5) == "labelled"
    assert asked == [[pytest.approx(1.0)]]
    flow = {"tolerance": 1e-12, "threads": 5}
    for name in ("brute_force", "cover", "run_perturbed"):
        assert {option: calls[name][0][option] for option in flow} == flow, name
    assert calls["grown"][0]["flow"] == flow
    assert calls["cover"][0]["runs"] == calls["_label"][0]["runs"] == "runs"
    assert calls["cover"][0]["tree"] is calls["run_perturbed"][0]["tree"] is tree
    np.testing.assert_allclose(calls["brute_force"][0]["starts"], [[0.5, 0.25], [0.025, 0.0125]])


def test_a_response_begins_on_each_settled_orbit_that_is_stable_once(monkeypatch):
    """Of five runs one has no cycle, one no orbit nearby, one an unstable orbit, and one an orbit that is known."""
    varied = vary(gelcone.ConeModel(rest_height=0.8, damping_ratio=0.1), {"voltage": (0.2, 0.5)}, (1.0, 0.3))
    world = World(Kind(1), 4)
    section = np.arange(12.0).reshape(6, 1, 2)
    periods, symmetric = np.array([0, 1, 2, 2, 1, 4]), np.array([False, False, False, True, False, False])
    runs = check.Runs(np.arange(6.0), section, periods, symmetric, periods > 0)
    points = {1: None, 2: SimpleNamespace(stable=False), **{k: SimpleNamespace(stable=True, name=k) for k in (3, 4, 5)}}
    polished = []

    def near(shooting, of, k, scale, **flow):
        assert (shooting, of) == (world, runs)
        polished.append((k, scale, flow))
        return SimpleNamespace(kind=check.kind_of(periods[k], symmetric[k])), points[k]

    asked = record(
        monkeypatch, continuation, brute_force=runs, polished=near,
        shortest=lambda own, point, scale: (own, point), follow=lambda own, point, walk: (own.kind, point.name),
    )  # fmt: skip
    monkeypatch.setattr(continuation.Tree, "holds", lambda tree, own, point: point.name == 4)
    walk, flow = Walk(0.2, 0.5), {"tolerance": 2e-9, "threads": 5}
    found = continuation._roots(world, varied, walk, "settled", np.array([[1.0, 0.3]]), flow)
    assert found == [(Kind(1, True), 3), (Kind(4), 5)]
    assert polished == [(k, walk.scale, flow) for k in range(1, 6)]
    assert [call["walk"] is walk for call in asked["follow"]] == [True, True]
