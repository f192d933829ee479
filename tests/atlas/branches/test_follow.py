"""One branch: the same whatever its steps, its events between its points, its exponents those of its multipliers."""

import numpy as np
import pytest

import gelcone
from gelcone.atlas.branches import follow
from gelcone.atlas.branches.branch import EventKind
from gelcone.motion.flow import integrate
from gelcone.presets import find_preset
from tests.atlas.branches.events import events_of

BASE = find_preset("base").model
SPRING = find_preset("spring").model.replace(damping_ratio=0.01)


def branches(**changes):
    """Rest of the base set and the orbits born where it loses stability; a resonance of the spring set with two folds.
    ``changes`` are those of the constants of the module."""
    with pytest.MonkeyPatch.context() as patched:
        for name, value in changes.items():
            patched.setattr(follow, name, value)
        return [
            gelcone.continue_branch(BASE, "voltage", 0.95, 1.03, switch=1, checks=2),
            gelcone.continue_branch(SPRING, "drive_frequency", 0.45, 0.8, start="settled", switch=0, checks=2),
        ]


@pytest.fixture(scope="module")
def usual():
    return branches()


@pytest.fixture(scope="module")
def voltages():
    """Branches of the base set, some of which begin within their interval."""
    diagram = gelcone.bifurcation(BASE, "voltage", [1.005, 1.015], sweeps=(), bisections=0)
    return gelcone.continue_branch(BASE, "voltage", 0.98, 1.03, start=diagram, switch=0, checks=2)


@pytest.fixture(scope="module")
def frequencies():
    """A branch that begins within its interval, with two events on the way forward and two on the way back."""
    diagram = gelcone.bifurcation(SPRING, "drive_frequency", [0.7, 0.75], sweeps=(), bisections=0)
    return gelcone.continue_branch(SPRING, "drive_frequency", 0.45, 1.2, start=diagram, switch=0, checks=2)


def facts(result):
    """What a branch is, without its points: events with their errors, and ends."""
    events = sorted((e["kind"], e["period"], e["value"], e["value_error"]) for e in events_of(result))
    return events, sorted(map(tuple, np.sort(result["ended"].values).tolist()))


@pytest.mark.parametrize(
    "steps",
    [{"LONGEST_STEP": 0.01}, {"FIRST_STEP": 0.05}, {"FIRST_STEP": 3.0, "LONGEST_STEP": 3.0, "AIM": 10.0}],
    ids=["a quarter of the longest", "ten times the first", "so long that they must be refused"],
)
def test_a_branch_does_not_depend_on_its_steps(usual, steps):
    for one, other in zip(usual, branches(**steps), strict=True):
        (events, ends), (others, their_ends) = facts(one), facts(other)
        assert len(events) >= 2
        assert [event[:2] for event in others] == [event[:2] for event in events]
        for (*_, value, error), (*_, found, its_error) in zip(events, others, strict=True):
            assert abs(value - found) <= 3.0 * (error + its_error)
        assert their_ends == ends


def test_the_curvature_of_an_event_is_that_of_the_branch_that_leaves_it(usual):
    """The value changes by the curvature times the squared amplitude: of the branch itself at a fold, else of the one
    that is born. Nearby, the next power of the amplitude is a few per cent of that."""
    kinds = set()
    for result in usual:
        for k, event in enumerate(events_of(result)):
            leaving = event["branch"] if event["kind"] == "fold" else event["born_branch"]
            if leaving is None:
                continue
            orbit = result["event_orbit"].values[k]
            count = int(np.isfinite(orbit[:, 0]).sum())
            apart = np.abs(result["orbit"].values[leaving, :, :count] - orbit[:count]).max(axis=(1, 2))
            near = np.nanargmin(np.where(apart > 1e-3, apart, np.nan))
            change = float(result["value"][leaving, near]) - event["value"]
            assert change / apart[near] ** 2 == pytest.approx(float(result["event_curvature"][k]), rel=0.05)
            kinds.add(event["kind"])
    assert kinds == {"fold", "loss of rest", "symmetry breaking", "period doubling"}


def outside(result, branch, point):
    multipliers = result["multiplier_real"].values[branch, point] + 1j * result["multiplier_imag"].values[branch, point]
    return int((np.abs(multipliers) > 1.0).sum())


@pytest.mark.parametrize("which", ["voltages", "frequencies"])
def test_each_event_lies_between_its_points_and_nothing_changes_elsewhere(which, request):
    """From one point to the next as many multipliers pass the unit circle, modulo 2, as there are events."""
    result = request.getfixturevalue(which)
    value = result["value"].values
    at = list(zip(result["event_branch"].values, result["event_point"].values, strict=True))
    assert len(at) >= 3
    for k, (branch, point) in enumerate(at):
        ends = np.sort(value[branch, point : point + 2])
        if result["event_kind"].values[k] != EventKind.FOLD:
            assert ends[0] <= result["event_value"].values[k] <= ends[1]
        near = result["orbit"].values[branch, [point, point + 1], 0]
        assert np.isfinite(near).all()
    for branch in range(result.sizes["branch"]):
        count = int(np.isfinite(value[branch]).sum())
        changes = [outside(result, branch, k) - outside(result, branch, k + 1) for k in range(count - 1)]
        events = [at.count((branch, k)) for k in range(count - 1)]
        # the ends of a branch lie on the event where it is born or merges
        np.testing.assert_array_equal(np.array(changes)[1:-1] % 2, np.array(events)[1:-1] % 2)


@pytest.mark.parametrize("which", ["voltages", "frequencies"])
def test_the_exponent_is_that_of_the_largest_multiplier_over_the_period(which, request):
    """ln |multiplier| / period at each point; without bias the forcing has half the period of the voltage."""
    result = request.getfixturevalue(which)
    over_frequency = which == "frequencies"
    for branch in range(result.sizes["branch"]):
        own = result.isel(branch=branch)
        drive = own["value"] if over_frequency else BASE.drive_frequency
        largest = np.hypot(own["multiplier_real"], own["multiplier_imag"]).max("multiplier")
        period = int(own["period"]) * np.pi / drive
        np.testing.assert_allclose(own["lyapunov"], np.log(largest) / period, rtol=1e-12)


def test_a_time_average_gives_the_same_exponent(frequencies):
    """Where a stable orbit does not lose half of what damping takes."""
    own = frequencies.isel(branch=0)
    rate = own["lyapunov"].where(own["stable"] == 1).values
    at = int(np.nanargmin(np.abs(rate + 0.004)))
    model = SPRING.replace(drive_frequency=float(own["value"][at]))
    average = gelcone.lyapunov(model, own["orbit"].values[at, 0], transient=50.0)
    assert abs(rate[at] + 0.01) > 0.003
    assert abs(rate[at] - float(average["lyapunov"].max())) < 3.0 * float(average["standard_error"].max()) + 1e-6


def test_multipliers_of_rest_are_those_of_the_linearised_equation(voltages):
    (rest,) = np.flatnonzero(voltages["resting"].values)
    for point in (5, 60, 120):
        own = voltages.isel(branch=int(rest), point=point)
        found = own["multiplier_real"].values + 1j * own["multiplier_imag"].values
        expected = gelcone.floquet_multipliers(BASE.replace(voltage=float(own["value"])))
        expected = expected["multiplier_real"].values + 1j * expected["multiplier_imag"].values
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("highest", [2.4, 2.45])
def test_two_doublings_within_one_step_are_found(highest):
    """A multiplier is beyond -1 over 0.8 % of the drive frequency only, narrower than the usual steps."""
    model = gelcone.ConeModel(
        damping_ratio=0.15045,
        spring_stiffness=0.6356,
        rest_height=0.2152,
        voltage=0.7115,
        voltage_bias=0.4025,
        prestretch=1.5782,
        stretch_limit=20.0,
        drive_frequency=1.7,
    )
    found = gelcone.continue_branch(model, "drive_frequency", 0.9, highest, start="settled", switch=0, checks=2)
    assert [event["kind"] for event in events_of(found)] == ["period doubling"] * 2
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(follow, "LONGEST_STEP", 0.004)
        fine = gelcone.continue_branch(model, "drive_frequency", 1.8, 1.95, start="settled", switch=0, checks=2)
    for one, other in zip(events_of(found), events_of(fine), strict=True):
        assert one["value"] == pytest.approx(other["value"], abs=1e-9)


def test_folds_of_a_film_that_drags_have_the_trace_of_their_orbit():
    """Two states, whose areas shrink by more than the disc's damping: by what is integrated along the orbit."""
    own = {"relaxation_time_1": 0.001, "viscous_modulus_1": 0.5, "reduced": "relaxation_time_1"}
    model = SPRING.replace(**own)
    found = gelcone.continue_branch(model, "drive_frequency", 0.45, 0.8, start="settled", switch=0, checks=2)
    events = events_of(found)
    assert [event["kind"] for event in events] == ["fold", "fold"]
    for k, event in enumerate(events):
        at = model.replace(drive_frequency=event["value"])
        run = integrate(at, found["event_orbit"].values[k, 0], at.members().forcing_period, keep="tangents")
        product = np.prod(np.array(event["multipliers"])[:, 0])
        assert product == pytest.approx(np.exp(run.divergence[0, -1]), rel=1e-8)
