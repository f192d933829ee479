"""Curves of bifurcations in two parameters, and their points of codimension two, against certified ones."""

import json
from dataclasses import replace
from inspect import unwrap
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import InputError
from gelcone.atlas.branches import curve, locus
from gelcone.atlas.branches.branch import Ending, Event, EventKind
from gelcone.atlas.branches.event import DOUBLE, FOLD, Singular
from gelcone.atlas.branches.varied import vary
from gelcone.motion.orbit import Kind
from gelcone.presets import find_preset
from tests.atlas.branches import maps
from tests.toys import STATED

REFERENCES = {
    r["key"]: r
    for r in json.loads((Path(__file__).parents[2] / "reference" / "continuation.json").read_text())["references"]
}
BASE = find_preset("base").model
OPTIONS = {"switch": 0, "checks": 2, "start": "rest"}


@pytest.fixture(scope="module")
def folds():
    return gelcone.locus(BASE, "fold", {"voltage": (0.93, 1.5), "drive_frequency": (0.095, 0.125)}, **OPTIONS)


@pytest.fixture(scope="module")
def breakings():
    """On one curve of symmetry breakings the branches that are born turn subcritical between two frequencies."""
    model = BASE.replace(drive_frequency=0.11)
    return gelcone.locus(model, "breaking", {"voltage": (1.01, 1.04), "drive_frequency": (0.107, 0.112)}, **OPTIONS)


@pytest.fixture(scope="module")
def doublings():
    return gelcone.locus(BASE, "doubling", {"voltage": (0.93, 1.2), "drive_frequency": (0.079, 0.121)}, **OPTIONS)


def special(result, kind):
    at = np.flatnonzero(result["event_kind"].values == kind)
    return [result.isel(event=k) for k in at]


def nearest(found, values):
    return min(
        found, key=lambda e: abs(float(e["event_first"]) - values[0]) + abs(float(e["event_second"]) - values[1])
    )


def check_values(event, reference, largest_error):
    for place, value in zip(("first", "second"), reference["values"], strict=True):
        error = float(event[f"event_{place}_error"])
        # the reference itself has so many digits
        assert abs(float(event[f"event_{place}"]) - value) <= 3.0 * error + 10.0 ** -reference["digits_trusted"]
        assert 0.0 < error < largest_error


@pytest.mark.slow
def test_certified_cusp(folds):
    reference = REFERENCES["codim2/base_v_omega/cusp_1"]
    event = nearest(special(folds, EventKind.CUSP), reference["values"])
    check_values(event, reference, 1e-11)
    side = np.sign(float(event["event_orbit"][0]))
    # the values of a cusp do not tell its states: they move with the square of what these are off
    np.testing.assert_allclose(side * event["event_orbit"], reference["orbit_state_at_phase_0"], rtol=0.0, atol=5e-9)
    assert float(event["event_multiplier_real"][0]) == pytest.approx(1.0, abs=1e-9)


@pytest.fixture(scope="module")
def generalised():
    """A locus of doublings with a generalised one, and its curves."""
    model, curves, follow_curve = BASE.replace(hoop_prestretch=1.03, meridional_prestretch=1.0), [], curve.follow_curve
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(locus, "follow_curve", lambda *given: curves.append(follow_curve(*given)) or curves[-1])
        over = {"voltage": (1.0, 1.1), "hoop_prestretch": (1.02, 1.04)}
        return gelcone.locus(model, "period doubling", over, **OPTIONS), curves


def test_certified_generalised_doubling(generalised):
    reference = REFERENCES["codim2/base_v_lp/generalized_period_doubling_1"]
    event = nearest(special(generalised[0], EventKind.GENERALISED_DOUBLING), reference["values"])
    check_values(event, reference, 1e-10)
    side = np.sign(float(event["event_orbit"][0]))
    np.testing.assert_allclose(side * event["event_orbit"], reference["orbit_state_at_phase_0"], rtol=0.0, atol=1e-9)


def test_the_criticality_changes_at_a_degenerate_symmetry_breaking(breakings):
    """Beside it, the branch that is born lies above the value of its event on one side and below on the other."""
    (event,) = special(breakings, EventKind.DEGENERATE_SYMMETRY_BREAKING)
    for place in ("first", "second"):
        assert 0.0 < float(event[f"event_{place}_error"]) < 1e-10
    assert float(event["event_multiplier_real"][0]) == pytest.approx(1.0, abs=1e-9)
    voltage, frequency = float(event["event_first"]), float(event["event_second"])
    sides = []
    for beside in (-1e-4, 1e-4):
        model = BASE.replace(drive_frequency=frequency + beside)
        line = gelcone.continue_branch(model, "voltage", 0.95, voltage + 0.005, switch=1, checks=2)
        at = np.flatnonzero(line["event_kind"].values == EventKind.SYMMETRY_BREAKING)
        at = at[np.abs(line["event_value"].values[at] - voltage).argmin()]
        assert abs(float(line["event_value"][at]) - voltage) < 2e-3
        # not by the coefficient, but where the orbits lie that are followed from there
        born = line.isel(branch=int(line["event_born_branch"][at]))
        ends = born["value"].values[np.isfinite(born["value"].values)]
        near = (
            ends[:3] if abs(ends[0] - line["event_value"][at]) < abs(ends[-1] - line["event_value"][at]) else ends[-3:]
        )
        sides.append(np.sign(np.mean(near - float(line["event_value"][at]))))
    assert sorted(sides) == [-1.0, 1.0]


@pytest.mark.slow
@pytest.mark.parametrize("frequency", ["0.08", "0.09", "0.11", "0.12"])
def test_certified_points_lie_on_the_curve(doublings, frequency):
    reference, omega = REFERENCES[f"curve/base_v_omega/pd1/at_{frequency}"], float(frequency)
    line = gelcone.continue_branch(
        BASE.replace(drive_frequency=omega),
        "voltage",
        0.8,
        reference["value"] + 0.01,
        switch=0,
        checks=2,
    )
    values = line["event_value"].values[line["event_kind"].values == EventKind.PERIOD_DOUBLING]
    assert np.abs(values - reference["value"]).min() < 1e-9
    voltage, height = (doublings[name].values for name in ("voltage", "drive_frequency"))
    between = [
        np.interp(omega, *(a[k : k + 2][np.argsort(h[k : k + 2])] for a in (h, v)))
        for v, h in zip(voltage, height, strict=True)
        for k in range(len(v) - 1)
        if (h[k] - omega) * (h[k + 1] - omega) <= 0.0
    ]
    assert np.abs(np.array(between) - reference["value"]).min() < 1e-3


def test_the_coefficient_along_a_curve_has_one_orientation(generalised):
    """Null vectors and weights may come with either sign at each point: no zero appears or is lost by that."""
    curves = [one for one in generalised[1] if one is not None]
    assert curves
    for one in curves:
        signs = np.random.default_rng(1).choice([-1.0, 1.0], (len(one.points), 2))
        signs[0] = 1.0
        turned = [replace(p, null=a * p.null, left=b * p.left) for p, (a, b) in zip(one.points, signs, strict=True)]
        np.testing.assert_allclose(curve._tests(one.shooting, turned), one.tests, rtol=1e-3, atol=1e-9)


def test_what_cannot_be_followed_is_refused():
    over = {"voltage": (0.95, 1.0), "drive_frequency": (0.09, 0.11)}
    with pytest.raises(InputError, match="did you mean 'fold'"):
        gelcone.locus(BASE, "folds", over)
    with pytest.raises(InputError, match="use tongues"):
        gelcone.locus(BASE, "loss of rest", over)
    with pytest.raises(InputError, match="takes two parameters, not 1"):
        gelcone.locus(BASE, "fold", {"voltage": (0.9, 1.0)})
    with pytest.raises(InputError, match="must hold the model's own value"):
        gelcone.locus(BASE, "fold", over | {"drive_frequency": (0.2, 0.3)})
    with pytest.raises(InputError, match="none lies on voltage"):
        gelcone.locus(BASE, "fold", {"voltage": (0.5, 0.6), "drive_frequency": (0.09, 0.11)}, checks=2)


@pytest.mark.parametrize(
    ("null", "left", "fold", "other"), [(1, 1, 1, 1), (-1, 1, 1, -1), (1, -1, -1, -1), (-1, -1, -1, 1)]
)
def test_a_vector_that_turns_round_changes_the_sign_of_what_is_odd_in_it(null, left, fold, other):
    """A fold's coefficient is left . second(null, null), the others' left . third(null, null, null)."""
    vector, nothing = np.array([[1.0, -2.0]]), np.zeros(2)
    for at, turned in ((FOLD, fold), (DOUBLE, other)):
        one, two = (
            Singular(vector, nothing, nothing, a * vector, b * vector, np.ones(2, complex), at)
            for a, b in ((1.0, 1.0), (null, left))
        )
        assert curve._turned(one, two) == turned


@pytest.mark.parametrize(("path", "reverses"), [("forth", False), ("cusp", True)])
def test_a_curve_turns_back_at_a_cusp(path, reverses):
    """Values (t^2, t^3) about t = 0, scaled alike; a bend is none."""
    t = np.array([-0.2, -0.1, 0.1, 0.2])
    values = np.stack([t**2, t**3], axis=1) if path == "cusp" else np.stack([t, t**2], axis=1)
    points = [SimpleNamespace(values=value) for value in values]
    window = SimpleNamespace(scale=np.array([1.0, 0.5]))
    assert curve._reverses(SimpleNamespace(points=points), 1, window) is reverses


# --- made-up curves: each number says where it belongs ----------------------------------------------------------------

PUMP = gelcone.find_device("biased-pump").replace(film="taut")
PAIR = {"frequency": (9.0, 11.0), "film_thickness": (1.5e-4, 2.5e-4)}


def singular(first, second, at=FOLD, errors=(0.01, 0.02)):
    nodes = np.full((2, 2), first) + np.arange(4.0).reshape(2, 2)
    return Singular(nodes, np.array([first, second]), np.array(errors), nodes, nodes, np.array([-0.5j, 0.1]), at)


def test_curves_have_their_values_in_the_units_of_both_fields(monkeypatch):
    """Orbits at phase 0, multipliers over the whole period; no curvature of folds, and none of what is not there."""
    monkeypatch.setattr(locus, "born", lambda shooting, point: SimpleNamespace(curvature=10.0 * point.values[0]))
    mirrored = maps.Maps(maps.pitchfork, Kind(1, True), symmetric=True)
    points = [[singular(0.1 * k + 0.5, 0.2 * k + 0.3) for k in range(count)] for count in (3, 2)]
    special = [(singular(0.55, 0.35), 0)]
    folds = curve.Curve(maps.Maps(maps.s_curve, Kind(2)), EventKind.FOLD, points[0], [1.0, 2.0, 3.0], [])
    folds.ended = (Ending.LIMIT, Ending.REST)
    breaks = curve.Curve(mirrored, EventKind.SYMMETRY_BREAKING, points[1], [4.0, 5.0], special)
    varied = vary(PUMP, PAIR)
    scales = varied.scales
    assert scales[0] > 1e4 * scales[1]
    result = locus._label(varied, [folds, breaks], {})
    values = np.full((2, 2, 3), np.nan)
    for k, own in enumerate(points):
        values[:, k, : len(own)] = np.transpose([point.values for point in own])
    np.testing.assert_allclose(result["frequency"], scales[0] * values[0])
    np.testing.assert_allclose(result["film_thickness"], scales[1] * values[1])
    np.testing.assert_array_equal(result["coefficient"], [[1.0, 2.0, 3.0], [4.0, 5.0, np.nan]])
    np.testing.assert_allclose(result["curvature"], [[np.nan] * 3, [5.0, 6.0, np.nan]])
    np.testing.assert_allclose(result["orbit"][0, 1], points[0][1].nodes[0])
    assert result["period"].values.tolist() == [2, 2]
    assert result["symmetric"].values.tolist() == [0, 1]
    assert result["ended"].values.tolist() == [[Ending.LIMIT, Ending.REST], [Ending.LIMIT] * 2]
    assert result["event_kind"].values.tolist() == [EventKind.DEGENERATE_SYMMETRY_BREAKING]
    assert (result["event_curve"].values.tolist(), result["event_point"].values.tolist()) == ([1], [0])
    assert result["orbit"].attrs["along"] == "frequency=frequency,film_thickness=film_thickness"
    assert result["event_orbit"].attrs["along"] == "frequency=event_first,film_thickness=event_second"
    for place, scale, value, error in (("first", scales[0], 0.55, 0.01), ("second", scales[1], 0.35, 0.02)):
        np.testing.assert_allclose(result[f"event_{place}"], [scale * value])
        np.testing.assert_allclose(result[f"event_{place}_error"], [scale * error])
    np.testing.assert_allclose(result["event_multiplier_real"], [[-0.25, 0.01]])
    np.testing.assert_allclose(result["event_multiplier_imag"], 0.0, atol=1e-15)
    np.testing.assert_allclose(result["event_orbit"], [special[0][0].nodes[0]])
    assert (result.attrs["parameters"], result.attrs["event"]) == ("frequency,film_thickness", "fold")
    stated = locus._label(vary(PUMP.replace(film="tests.toys:StatedCone"), PAIR), [folds, breaks], {})
    assert STATED.items() <= stated.attrs.items()


def across_from(begin):
    """The start of brute force along the first field, in the middle of its interval."""
    own = PUMP.replace(frequency="10 Hz")
    return vary(own, {"frequency": PAIR["frequency"]}, begin).starts(
        [10.0 / vary(own, {"frequency": PAIR["frequency"]}).scales[0]]
    )


def test_curves_begin_at_the_resolved_events_of_their_kind_in_their_own_units(monkeypatch):
    """Branches over one field have another scale than curves over two: values stay where they are in SI."""
    asked, world = {}, maps.Maps(maps.s_curve)
    across = vary(PUMP, {"frequency": PAIR["frequency"]})
    varied = vary(PUMP, PAIR)
    assert across.scales[0] != pytest.approx(varied.scales[0])
    seeds = [
        Event(kind, singular(0.5 + 0.01 * k, np.nan), None, 0.0, k, Kind(1), resolved, branch=0)
        for k, (kind, resolved) in enumerate([(EventKind.FOLD, True), (EventKind.FOLD, False), (EventKind.TORUS, True)])
    ]
    tree = SimpleNamespace(branches=[SimpleNamespace(events=seeds, shooting=world)])
    monkeypatch.setattr(type(varied), "shooting", lambda self, tolerance: world)
    monkeypatch.setattr(locus, "grown", lambda *given: asked.update(grown=given) or tree)
    monkeypatch.setattr(
        locus,
        "brute_force",
        lambda walk, line, values, starts, **flow: asked.update(runs=values, flow=flow, starts=starts),
    )
    monkeypatch.setattr(locus, "cover", lambda *given, **flow: asked.update(cover=flow))
    monkeypatch.setattr(locus, "follow_curve", lambda *given: asked.setdefault("curves", []).append(given))
    monkeypatch.setattr(locus, "_label", lambda varied, curves, options: options)
    begin = ("3 mm", "0.2 m/s")
    options = unwrap(gelcone.locus)(
        PUMP, "fold", PAIR, begin, start="settled", switch=2, checks=3, points=50, tolerance=1e-12, threads=5
    )
    assert asked["flow"] == asked["cover"] == {"tolerance": 1e-12, "threads": 5}
    assert asked["grown"][1].initial == begin  # brute force along the first field begins where it was asked to
    states = asked["grown"][4]
    np.testing.assert_allclose(states, across_from(begin))
    np.testing.assert_allclose(asked["starts"], np.concatenate([states, 0.05 * states]))
    assert (options["tolerance"], options["initial"]) == (1e-12, (3e-3, 0.2))
    ((shooting, kind, nodes, values, at, window),) = asked["curves"]
    assert (shooting, kind, at) == (world, EventKind.FOLD, FOLD)
    np.testing.assert_array_equal(nodes, seeds[0].orbit.nodes)
    own = [0.5 * across.scales[0], PUMP.film_thickness]
    np.testing.assert_allclose(values * varied.scales, own, rtol=1e-12)
    np.testing.assert_allclose(
        [window.low * varied.scales, window.high * varied.scales], np.transpose([*PAIR.values()])
    )
    assert window.most == 50
    np.testing.assert_allclose(asked["runs"] * across.scales[0], [9.0, 10.0, 11.0])
    assert asked["grown"][3] == options["start"] == "settled"
    assert (asked["grown"][5], options["switch"], options["checks"], options["points"]) == (2, 2, 3, 50)
    assert options["over"] == {name: list(ends) for name, ends in PAIR.items()}


def test_the_own_value_of_the_second_parameter_may_be_an_end_of_its_interval():
    model = gelcone.ConeModel(voltage=0.6)
    for low, high in ((0.6, 0.9), (0.2, 0.6), (0.2, 0.9)):
        assert locus._own_value(vary(model, {"damping_ratio": (0.1, 0.2), "voltage": (low, high)}, (1.0, 0.0))) == 0.6
    with pytest.raises(InputError, match=r"voltage from 0\.61 to 0\.9: must hold the model's own value, which is 0\.6"):
        locus._own_value(vary(model, {"damping_ratio": (0.1, 0.2), "voltage": (0.61, 0.9)}, (1.0, 0.0)))


def test_an_event_is_known_where_a_curve_passes_it_with_its_orbit():
    """At the same second value, near the same first one, on the same or the mirrored orbit of the same kind."""
    world = maps.Maps(maps.s_curve)
    one = curve.Curve(world, EventKind.FOLD, [singular(0.5, 0.2), singular(0.7, 0.4)], [1.0, 1.0])
    middle = replace(singular(0.6, 0.3), errors=np.zeros(2))
    assert locus._known([one], world, middle, 0.6, 0.3)
    assert locus._known([one], world, replace(middle, nodes=-middle.nodes), 0.61, 0.3)
    assert not locus._known([one], world, middle, 0.66, 0.3)
    assert not locus._known([one], world, middle, 0.6, 0.45)
    assert not locus._known([one], world, replace(middle, nodes=2.0 * middle.nodes), 0.6, 0.3)
    assert not locus._known([one], world, replace(middle, at=DOUBLE), 0.6, 0.3)
    assert not locus._known([one], world.of_kind(Kind(2)), middle, 0.6, 0.3)
    assert not locus._known([], world, middle, 0.6, 0.3)


def test_fewer_segments_take_every_other_node():
    old, new = SimpleNamespace(segments=8), SimpleNamespace(segments=4)
    nodes = np.arange(32.0).reshape(16, 2)
    np.testing.assert_array_equal(locus._renoded(old, new, nodes, 0.5), nodes[::2])
    assert locus._renoded(old, old, nodes, 0.5) is nodes
