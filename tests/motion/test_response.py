"""The time response: power balance, stresses and fields by hand, validity, and what the Dataset says about itself."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import gelcone
from gelcone import ConeModel, InputError, Outcome, dataset, simulate
from gelcone.motion import response
from gelcone.motion.flow import integrate
from gelcone.motion.job import to_the_end
from gelcone.motion.validity import SHARES, validity_of_run, validity_variables
from tests.recorded import numbers, record
from tests.toys import PowerFilm

KNOWN = tuple(name for name in SHARES if name != "beyond_membrane")
"""Those of a model without a radius ratio."""
BALANCE = ("supplied_energy", "dissipated_energy", "kinetic_energy", "film_energy", "spring_energy", "field_energy")
FULL = {
    "damping_ratio": 0.04,
    "spring_stiffness": 1.3,
    "voltage": 0.7,
    "voltage_bias": 0.3,
    "drive_frequency": 0.9,
    "stretch_limit": 12.0,
    "meridional_prestretch": 1.1,
    "hoop_prestretch": 1.3,
    "rest_height": 0.25,
}
LAWS = {
    "gent": {"law": "gent", "stretch_limit": 12.0},
    "neo-hookean": {"law": "neo-hookean", "stretch_limit": None},
    "yeoh": {"law": "yeoh", "stretch_limit": None, "yeoh_c2": 0.05, "yeoh_c3": 0.002},
}
every_law = pytest.mark.parametrize("law", LAWS)


def members():
    """Hypothesis: a model over the ranges of use, and a start inside its stretch limit."""

    @st.composite
    def draw(pick):
        def number(low, high):
            return pick(st.floats(low, high))

        stretches = {"meridional_prestretch": number(0.8, 1.4), "hoop_prestretch": number(0.8, 1.4)}
        displacement = number(-1.5, 1.5)
        reached = float(ConeModel(law="neo-hookean", **stretches).strain(np.array([0.0, displacement])).max())
        model = ConeModel(
            damping_ratio=number(0.0, 0.5),
            spring_stiffness=number(0.0, 5.0),
            voltage=number(0.0, 1.5),
            voltage_bias=number(-0.5, 0.5),
            drive_frequency=number(0.1, 4.0),
            stretch_limit=pick(st.one_of(st.just(np.inf), st.floats(1.1, 20.0).map(lambda f: f * reached + 0.1))),
            rest_height=number(-0.5, 0.5),
            **stretches,
        )
        return model, (displacement, number(-1.0, 1.0))

    return draw()


# --- energies ---------------------------------------------------------------------------------------------------------


@every_law
def test_the_power_balance_closes_under_drive_and_damping(law):
    model = ConeModel(**FULL | LAWS[law])
    result = simulate(model, (0.6, 0.2), periods=300)
    scale = float(result.supplied_energy.max() - result.supplied_energy.min())
    assert scale > 1.0
    assert float(abs(result.energy_residual).max()) < 1e-11 * scale
    supplied, dissipated, *stored = (result[name] for name in BALANCE)
    change = sum(stored) - sum(stored)[0]
    np.testing.assert_allclose(supplied, dissipated + change, atol=1e-10 * scale)


def test_the_balance_holds_in_chaos_too():
    model = ConeModel(damping_ratio=0.01, spring_stiffness=0.9, voltage=1.7, drive_frequency=0.1)
    result = simulate(model, periods=100)
    assert int(result.outcome) == Outcome.OK
    assert float(abs(result.energy_residual).max()) < 1e-9


@every_law
def test_the_powers_are_the_rates_of_the_energies(law):
    result = simulate(ConeModel(**FULL | LAWS[law]), (0.6, 0.2), times=np.linspace(0.0, 5.0, 2001))
    for energy, power in (("supplied_energy", "input_power"), ("dissipated_energy", "dissipated_power")):
        rate = np.gradient(result[energy].values, result.time.values, edge_order=2)
        np.testing.assert_allclose(result[power].values, rate, atol=1e-5)
    assert (result.dissipated_power >= 0.0).all()


def test_the_current_is_the_rate_of_the_charge():
    result = simulate(ConeModel(**FULL), (0.6, 0.2), times=np.linspace(0.0, 5.0, 2001))
    charge = result.drive_voltage * (1.0 + result.displacement**2)
    np.testing.assert_allclose(result.current, np.gradient(charge, result.time, edge_order=2), atol=1e-5)


def test_energies_are_counted_from_time_zero_also_when_it_is_not_sampled():
    model = ConeModel(**FULL)
    late = simulate(model, (0.6, 0.2), times=[2.0, 3.0])
    whole = simulate(model, (0.6, 0.2), times=[0.0, 2.0, 3.0])
    for name in BALANCE:
        np.testing.assert_array_equal(late[name], whole[name][1:])
    assert float(abs(late.energy_residual).max()) < 1e-13


# --- by hand ----------------------------------------------------------------------------------------------------------


def response_by_hand(law, strain):
    """2 dW/dI1 per mu."""
    if law == "gent":
        return 1.0 / (1.0 - strain / 12.0)
    return 1.0 if law == "neo-hookean" else 1.0 + 2.0 * 0.05 * strain + 3.0 * 0.002 * strain**2


@pytest.mark.parametrize("second", [{}, {"second_film": "taut", "second_drive": "opposite"}])
def test_the_drive_is_what_is_commanded_and_the_film_has_what_the_circuit_leaves(second):
    """A slow drive behind a resistance with a leak: the film has the share of both in series."""
    drive = {"voltage": 0.1, "voltage_bias": 0.4, "drive_frequency": 1e-3}
    model = ConeModel(**drive, **second, series_resistance=1.0, leakage_time=4.0, damping_ratio=0.2, rest_height=0.1)
    times = np.linspace(6000.0, 6020.0, 5)
    found, ideal = simulate(model, times=times), simulate(ConeModel(**drive, **second, rest_height=0.1), times=times)
    shift = 0.1 * np.sin(1e-3 * times)
    for film, command in {"": 0.4 + shift, **({"second_": 0.4 - shift} if second else {})}.items():
        np.testing.assert_allclose(found[f"{film}drive_voltage"], command, atol=1e-12)
        np.testing.assert_allclose(ideal[f"{film}drive_voltage"], command, atol=1e-12)
        x = found["displacement"].values - (model.values["second_flat_height"] if film else 0.0)
        np.testing.assert_allclose(found[f"{film}film_voltage"], command / (1.0 + (1.0 + x * x) / 4.0), rtol=2e-3)
    assert not [name for name in ideal if str(name).endswith("film_voltage")]


@every_law
def test_stretches_stresses_and_field_at_a_point(law):
    result = simulate(ConeModel(**FULL | LAWS[law]), (0.6, 0.2), times=[1.7])
    x = float(result.displacement[0])
    q = 1.0 + x * x
    v = 0.3 + 0.7 * np.sin(0.9 * 1.7)
    l1, l2 = 1.1 * np.sqrt(q), 1.3
    l3 = 1.0 / (l1 * l2)
    strain = l1**2 + l2**2 + l3**2 - 3.0
    secant = response_by_hand(law, strain)
    expected = {
        "drive_voltage": v,
        "meridional_stretch": l1,
        "hoop_stretch": l2,
        "thickness_stretch": l3,
        "meridional_stress": (l1**2 - l3**2) * secant - v * v * q,
        "hoop_stress": (l2**2 - l3**2) * secant - v * v * q,
        "true_field": abs(v) * np.sqrt(q),
        "kinetic_energy": 0.5 * float(result.velocity[0]) ** 2,
        "spring_energy": 0.65 * (x - 0.25) ** 2,
        "field_energy": 0.5 * v * v * q,
    }
    for name, value in expected.items():
        assert float(result[name][0]) == pytest.approx(value, rel=1e-13), name
    if law == "gent":
        assert float(result.film_energy[0]) == pytest.approx(-6.0 * np.log(1.0 - strain / 12.0), rel=1e-13)


@pytest.mark.parametrize(("mode", "stretches"), [("radial", (1.0, 1.3)), ("equibiaxial", (1.3, 1.3))])
def test_the_prestretch_mode_decides_the_meridional_stretch(mode, stretches):
    result = simulate(ConeModel(prestretch=1.3, prestretch_mode=mode), (0.0, 0.0), times=[1.0])
    assert (float(result.meridional_stretch[0]), float(result.hoop_stretch[0])) == stretches


def test_displacement_and_velocity_are_those_of_the_flow():
    model = ConeModel(voltage=[0.3, 0.9], damping_ratio=0.1)
    times = np.linspace(0.0, 20.0, 50)
    result = simulate(model, (0.5, 0.1), times=times)
    states = integrate(model, (0.5, 0.1), times).states
    np.testing.assert_allclose(result.displacement, states[..., 0], rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(result.velocity, states[..., 1], rtol=1e-11, atol=1e-12)


# --- validity ---------------------------------------------------------------------------------------------------------


def still(**parameters):
    """A disc that stays at 0 under a drive of period 2 pi, whose shares are known."""
    result = simulate(ConeModel(damping_ratio=0.1, drive_frequency=1.0, **parameters), (0.0, 0.0), periods=10)
    np.testing.assert_array_equal(result.displacement, 0.0)
    return result


def test_a_film_is_slack_while_the_voltage_is_above_its_tension():
    """l1^2 - l3^2 = v^2 sin^2 at x = 0: with lm = lh = lp the share is 1 - (2/pi) arcsin(sqrt(tension)/v)."""
    stretch, v = 1.2, 1.5
    tension = stretch**2 - stretch**-4
    result = still(prestretch=stretch, prestretch_mode="equibiaxial", voltage=v, stretch_limit=np.inf)
    expected = 1.0 - 2.0 / np.pi * np.arcsin(np.sqrt(tension) / v)
    assert float(result.validity_hoop_slack) == pytest.approx(expected, abs=0.01)
    assert float(result.validity_meridional_slack) == pytest.approx(expected, abs=0.01)


def test_a_flat_film_without_prestretch_is_slack_at_any_voltage_and_never_without():
    # the voltage itself is 0 at three of the 101 samples of each period or so
    assert float(still(voltage=0.5).validity_hoop_slack) > 0.97
    assert float(still(voltage=0.0).validity_hoop_slack) == 0.0


def test_the_field_exceeds_the_dielectric_strength_for_the_share_that_arcsine_says():
    model = ConeModel(voltage=1.0, drive_frequency=1.0)
    result = simulate(model.replace(dielectric_strength=0.5), (0.0, 0.0), periods=10)
    assert float(result.validity_breakdown) == pytest.approx(2.0 / 3.0, abs=0.01)
    assert float(simulate(model.replace(dielectric_strength=1.001), (0.0, 0.0)).validity_breakdown) == 0.0


def test_without_a_dielectric_strength_the_breakdown_is_unknown():
    assert np.isnan(float(simulate(ConeModel(), periods=1).validity_breakdown))


def test_a_film_held_within_one_percent_of_its_limit_is_near_it():
    stretch = 1.5
    flat = 2.0 * stretch**2 + stretch**-4 - 3.0
    for share, near in ((0.995, 1.0), (0.985, 0.0)):
        result = still(prestretch=stretch, prestretch_mode="equibiaxial", voltage=0.0, stretch_limit=flat / share)
        assert float(result.validity_near_limit) == near


def test_flags_say_when_the_model_fails_and_shares_how_often():
    model = ConeModel(**FULL | {"voltage": [0.7, 1.2], "stretch_limit": 2.6})
    result = simulate(model.replace(dielectric_strength=0.8), (0.6, 0.2))
    np.testing.assert_array_equal(result.hoop_slack, result.hoop_stress < 0.0)
    np.testing.assert_array_equal(result.meridional_slack, result.meridional_stress < 0.0)
    np.testing.assert_array_equal(result.breakdown, result.true_field > 0.8)
    np.testing.assert_array_equal(result.near_limit, model.strain(result.displacement) >= 0.99 * 2.6)
    for name in KNOWN:
        np.testing.assert_allclose(result[f"validity_{name}"], result[name].mean("time"), atol=0.01)
    assert "breakdown" not in simulate(model, (0.6, 0.2), periods=1)


def test_shares_do_not_depend_on_which_times_are_kept():
    model = ConeModel(**FULL)
    few = simulate(model.replace(dielectric_strength=0.8), (0.6, 0.2), times=[40.0])
    uneven = simulate(
        model.replace(dielectric_strength=0.8), (0.6, 0.2), times=np.concatenate([np.linspace(0.0, 0.1, 999), [40.0]])
    )
    for name in KNOWN:
        assert float(few[f"validity_{name}"]) == float(uneven[f"validity_{name}"])
    assert 0.0 < float(few.validity_breakdown) < 1.0


def test_a_member_that_never_runs_has_no_shares_and_the_others_have_theirs():
    model = ConeModel(stretch_limit=[0.4, 50.0])
    result = simulate(model.replace(dielectric_strength=1.0), periods=2)
    assert result.outcome.values.tolist() == [Outcome.OUTSIDE, Outcome.OK]
    alone = simulate(model.take([1]).replace(dielectric_strength=1.0), periods=2)
    for name, variable in result.data_vars.items():
        if "member" in variable.dims and variable.dtype == float and name != "initial":
            # the drive goes on whether the film does or not
            assert np.isnan(variable[0]).all() or name == "drive_voltage", name
            np.testing.assert_array_equal(variable[1], alone[name][0])


# --- the Dataset ------------------------------------------------------------------------------------------------------


def test_every_variable_says_what_it_is():
    result = simulate(ConeModel(voltage=[0.1, 0.2]), periods=1)
    for name, variable in result.variables.items():
        assert {"long_name", "units"} <= variable.attrs.keys(), name
    assert json.loads(result.attrs["options"]) == {"periods": 1, "tolerance": 1e-15}
    assert result.attrs["gelcone_version"] == gelcone.__version__
    flags = dict(
        zip(result.outcome.attrs["flag_meanings"].split(), result.outcome.attrs["flag_values"].tolist(), strict=True)
    )
    assert flags == {outcome.name.lower(): outcome.value for outcome in Outcome}


@pytest.mark.parametrize(
    ("parameters", "dims"),
    [
        ({}, ("time",)),
        ({"voltage": [0.1, 0.2, 0.3]}, ("member", "time")),
        ({"voltage": [[0.1], [0.2]], "rest_height": [0.0, 0.1, 0.2]}, ("member_0", "member_1", "time")),
        ({"drive_frequency": [0.5, 1.0]}, ("member", "sample")),
        ({"drive_frequency": [1.0, 1.0]}, ("member", "time")),
        ({"drive_frequency": [[0.5], [1.0]], "voltage": [0.1, 0.2]}, ("member_0", "member_1", "sample")),
    ],
)
def test_dims_of_ensembles(parameters, dims):
    model = ConeModel(**parameters)
    result = simulate(model, periods=2)
    assert result.displacement.dims == dims
    assert result.outcome.dims == dims[:-1]
    assert result.outcome.shape == model.shape
    assert result.time.dims == (dims if dims[-1] == "sample" else ("time",))
    ends = np.broadcast_to(2.0 * model.drive_period, model.shape)
    np.testing.assert_allclose(result.time[..., -1], ends if dims[-1] == "sample" else ends.flat[0], rtol=1e-15)
    for name, value in parameters.items():
        np.testing.assert_array_equal(result[name], np.broadcast_to(value, model.shape))
        assert result[name].dims == dims[:-1]


def test_members_of_a_grid_are_where_their_parameters_say():
    model = ConeModel(voltage=[[0.1], [0.9]], rest_height=[0.0, 0.1, 0.2])
    result = simulate(model, times=[3.0])
    for i in range(2):
        for j in range(3):
            cell = result.isel(member_0=i, member_1=j)
            alone = simulate(ConeModel(voltage=float(cell.voltage), rest_height=float(cell.rest_height)), times=[3.0])
            np.testing.assert_array_equal(cell.displacement, alone.displacement)


def test_times_and_a_number_of_periods_exclude_each_other():
    with pytest.raises(InputError, match="periods and times are both given; give one of them"):
        simulate(ConeModel(), periods=2.0, times=[1.0])


def test_initial_states_may_differ_between_members():
    model = ConeModel(voltage=[[0.1], [0.9]], rest_height=[0.0, 0.1, 0.2])
    initial = np.random.default_rng(1).uniform(-0.5, 0.5, (2, 3, 2))
    result = simulate(model, initial, times=[0.0, 3.0])
    np.testing.assert_array_equal(result.displacement[..., 0], initial[..., 0])
    np.testing.assert_array_equal(result.velocity[..., 0], initial[..., 1])
    np.testing.assert_array_equal(result.initial, initial)


def test_an_oscillation_much_faster_than_the_drive_is_resolved():
    result = simulate(ConeModel(drive_frequency=0.01, spring_stiffness=4.0), periods=1)
    steps = np.diff(result.time)
    assert steps.max() <= 2.0 * np.pi / np.sqrt(4.0) / response.SAMPLES_PER_OSCILLATION
    assert result.sizes["time"] <= response.MOST_SAMPLES + 1
    long = simulate(ConeModel(), periods=1000)
    assert long.sizes["time"] == response.MOST_SAMPLES + 1


MODELS = {
    "single": ConeModel(**FULL),
    "no limit": ConeModel(stretch_limit=np.inf),
    "some without limit": ConeModel(stretch_limit=[5.0, np.inf]),
    "mode": ConeModel(prestretch=[1.0, 1.2], prestretch_mode="equibiaxial"),
    "yeoh": ConeModel(law="yeoh", yeoh_c2=[0.1, 0.2], yeoh_c3=1 / 3),
    "neo-hookean": ConeModel(law="neo-hookean", voltage=1 / 3),
    "grid": ConeModel(voltage=[[0.1], [1 / 3]], drive_frequency=[0.5, 0.7, 1.0]),
    "one failed": ConeModel(stretch_limit=[0.4, 50.0]),
}


@pytest.mark.parametrize("name", MODELS)
def test_the_model_comes_back_from_its_result_and_from_the_file(name, tmp_path):
    model = MODELS[name]
    result = simulate(model.replace(dielectric_strength=0.9), periods=1)
    path = tmp_path / "response.nc"
    gelcone.save(result, path)
    read = gelcone.load(path)
    xr.testing.assert_identical(read, result)
    for variable in result.variables:
        assert read[variable].dtype == result[variable].dtype
    for source in (result, read):
        again = dataset.model_of(source)
        assert again.shape == model.shape
        assert again.law == model.law
        assert again.prestretch_mode == model.prestretch_mode
        for parameter, value in model.parameters().items():
            if not isinstance(value, str):
                back = np.broadcast_to(again.parameters()[parameter], model.shape)
                np.testing.assert_array_equal(back, np.broadcast_to(value, model.shape))
    xr.testing.assert_identical(simulate(dataset.model_of(read), periods=1), result)


# --- over the parameter ranges ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("start", [0.0, 1e-30])
def test_the_balance_closes_at_rest(start):
    """Flat and undriven the disc bounds no step, while the source charges the film and takes the charge back."""
    result = simulate(ConeModel(spring_stiffness=0.0, damping_ratio=0.0, voltage=1.0), (start, 0.0), periods=3)
    assert float(abs(result.energy_residual).max()) < 1e-12
    stored = 0.5 * result.drive_voltage.values**2  # that of a capacitor, over its capacitance when flat
    np.testing.assert_allclose(result.supplied_energy, stored, atol=1e-9)


@settings(deadline=None, max_examples=40)
@given(members())
def test_everywhere_the_balance_closes_and_no_member_ends_beyond_its_limit(member):
    model, initial = member
    result = simulate(model, initial, periods=3)
    if int(result.outcome) != Outcome.OK:
        assert np.isnan(float(result.displacement[-1]))
        return
    x = result.displacement.values
    assert (model.strain(x) < model.strain_limit()).all()
    energies = np.array([np.abs(result[name]).max() for name in BALANCE])
    assert float(abs(result.energy_residual).max()) <= 1e-9 * (1.0 + energies.max())
    for name in SHARES:
        assert np.isnan(float(result[f"validity_{name}"])) == (name in ("breakdown", "beyond_membrane"))


@settings(deadline=None, max_examples=30)
@given(members())
def test_everywhere_tangent_maps_shrink_areas_by_the_damping(member):
    """The sum rule of the Lyapunov exponents, for every stretch of the motion."""
    model, initial = member
    times = np.linspace(0.0, 6.0, 61)
    run = integrate(model, initial, times, keep="tangents")
    if run.outcome[0] == Outcome.OK:
        expected = np.exp(-2.0 * model.damping_ratio * 0.1)
        scale = np.abs(run.tangents[0, 1:]).max(axis=(1, 2)) ** 2
        assert (np.abs(np.linalg.det(run.tangents[0, 1:]) - expected) <= 1e-10 * np.maximum(scale, 1.0)).all()


@settings(deadline=None, max_examples=30)
@given(members())
def test_everywhere_a_mirrored_cone_mirrors_its_motion(member):
    model, (x, u) = member
    mirror = model.replace(rest_height=-model.rest_height)
    one = integrate(model, (x, u), [1.0, 5.0]).states
    np.testing.assert_array_equal(one, -integrate(mirror, (-x, -u), [1.0, 5.0]).states)


# --- the contract -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"periods": 0}, "periods = 0: must be a positive number of drive periods"),
        ({"periods": -1.5}, "periods = -1.5: must be a positive number of drive periods"),
        ({"periods": np.nan}, "periods = nan: must be a positive number of drive periods"),
        ({"periods": np.inf}, "periods = inf: must be a positive number of drive periods"),
        ({"periods": "3"}, "periods = '3': must be a number, without a unit"),
        ({"times": []}, "times: must be a list of at least one number, not of shape (0,)"),
        ({"times": [[1.0, 2.0]]}, "times: must be a list of at least one number, not of shape (1, 2)"),
        ({"times": [1.0, np.nan]}, "times: nan is among them; they must be finite and not before 0"),
        ({"times": [1.0, np.inf, np.inf]}, "times: inf is among them; they must be finite and not before 0"),
        ({"times": [-1.0, 1.0]}, "times: -1 is among them; they must be finite and not before 0"),
        ({"times": [1.0, 3.0, 2.0]}, "times: 2 comes after 3; they must increase, sort them"),
        ({"times": [1.0, 1.0]}, "times: 1 comes after 1; they must increase, sort them"),
        ({"times": [0.0]}, "times = 0: the run has no length; give at least one later time"),
        ({"times": "soon"}, "times = 'soon': must be numbers"),
        ({"tolerance": 0.0}, "tolerance = 0.0: must be a number above 0 and below 1"),
        ({"initial": (1.0,)}, "initial = (1.0,): must be a displacement and a velocity, shape (2,) or shape (2, 2)"),
        ({"initial": "up"}, "initial = 'up': must be a displacement and a velocity, shape (2,) or shape (2, 2)"),
        ({"initial": (np.nan, 0.0)}, "initial = [nan, 0.0]: must be finite"),
        ({"initial": (1.0, np.inf)}, "initial = [1.0, inf]: must be finite"),
        (
            {"initial": (8.0, 0.0)},
            "stretch_limit = 50: must exceed I1 - 3 = 63.02 at the initial displacement 8; start lower or raise it",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(options, message):
    with pytest.raises(InputError) as error:
        simulate(ConeModel(voltage=[0.5, 1.0]), **options)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_start_beyond_all_numbers_is_refused():
    with pytest.raises(InputError, match="its strain is beyond what doubles hold"):
        simulate(ConeModel(stretch_limit=np.inf), (1e200, 0.0))


def test_an_ensemble_beyond_the_memory_is_refused_before_it_is_begun(monkeypatch):
    monkeypatch.setattr(response.os, "sysconf", lambda name: 20_000)
    with pytest.raises(InputError) as error:
        simulate(ConeModel(voltage=np.linspace(0.0, 1.0, 800)))
    assert str(error.value) == (
        "800 members of 2000 samples need about 0.486 GB of memory, this machine has 0.4; take fewer members or samples"
    )


def test_progress_adds_up_to_one():
    shares = []
    simulate(ConeModel(voltage=np.linspace(0.1, 1.0, 20)), periods=3, progress=shares.append)
    assert sum(shares) == pytest.approx(1.0)


def test_shares_are_counted_to_where_a_run_ends():
    model = ConeModel(
        film="wrinkling", spring_stiffness=0.9, damping_ratio=0.01, drive_frequency=0.1, voltage=[0.5, 1.04]
    )
    times = np.broadcast_to(np.linspace(0.1, 20.0, 200), (2, 200))
    run = integrate(model, (1.0, 0.0), times)
    assert run.outcome.tolist() == [Outcome.OK, Outcome.PULLED_IN]
    kept, states = to_the_end(run, np.arange(0, 200, 2))
    last = int(np.isfinite(states[1, :, 0]).sum()) - 1
    assert kept[1, last] == run.end_times[1] > kept[1, last - 1]
    np.testing.assert_array_equal(states[1, last], run.end_states[1])
    np.testing.assert_array_equal(states[0], run.states[0, ::2])


class Unaccounted(PowerFilm):
    """A film whose energy nobody knows."""

    name = "unaccounted"

    def work(self, x, squared, y, n):
        return np.nan * x


@pytest.mark.parametrize(("film", "known"), [(PowerFilm(), True), (Unaccounted(), False)])
def test_the_balance_of_a_film_whose_energy_is_unknown_is_unknown(film, known):
    run = simulate(ConeModel(film=film, voltage=0.2, rest_height=0.1), (0.3, 0.0), periods=2)
    assert np.isfinite(run["displacement"].values).all()
    assert np.isfinite(run["energy_residual"].values).all() == known
    assert np.isnan(run["energy_residual"].values[1:]).all() != known


# --- what is handed on ------------------------------------------------------------------------------------------------


def ran(members, samples, films=1, **changes):
    """A made-up run whose numbers are all different."""
    size, states = members.size, len(members.system.states)
    made = {
        "times": np.tile(np.arange(float(samples)), (size, 1)), "states": numbers(size, samples, states, at=1.0),
        "work": numbers(size, samples, len(members.system.causes), at=2.0), "outcome": np.zeros(size, dtype=np.int8),
        "end_times": numbers(size, at=3.0), "end_states": numbers(size, states, at=4.0),
        "pull_in": np.zeros((size, films), dtype=np.int8), "film_times": numbers(size, films, 4, at=5.0),
    }  # fmt: skip
    return SimpleNamespace(**(made | changes))


@pytest.mark.parametrize("wanted", [None, [0.5, 1.0, 3.0]])
def test_a_time_response_hands_each_part_what_it_was_asked_for(monkeypatch, wanted):
    """Shares are those of even times up to the end, whichever times are shown; what is delivered, of all samples."""
    model, shares = ConeModel(damping_ratio=0.1, voltage=[0.2, 0.3], drive_frequency=2.0 * np.pi), []
    jumps = numbers(2, 1, at=8.0), numbers(2, 1, at=9.0)
    heat = {"heat": ((), numbers(2, at=31.0), "heat", "power density")}
    power = {"apparent_power": ((), numbers(2, at=32.0), "power", "apparent power")}

    def integrated(members, states, times, **options):
        return ran(model.members(), times.shape[1], times=times)

    def variables(members, run, jumped, lost):
        return {"displacement": run.states[..., 0]}, [SimpleNamespace(kind=None)]

    asked = record(
        monkeypatch, response, integrate=integrated, switched=jumps, _variables=variables, _heat=heat,
        validity_of_run=numbers(2, 3, at=20.0),
        delivered=power, broken=lambda members, motion, voltages, states: {"breakdown": motion[..., 0] > 1.0},
        even_times=lambda model, spans: np.linspace(0.0, 1.0, 6)[None] * np.reshape(np.max(spans), (-1, 1)),
        validity_variables=lambda found, outcome, system, **more: {"found": (("all",), found, "", "share")},
    )  # fmt: skip
    options = {"tolerance": 2e-9, "threads": 5}
    length = {"periods": 3.0} if wanted is None else {"times": wanted}
    found = simulate(model, numbers(2, 2), **length, progress=shares.append, **options)
    even = np.linspace(0.0, 3.0, 6)
    every = np.union1d(even, wanted or [])
    (run,), (of_jumps,), (of_time,), (of_power,) = (
        asked[n] for n in ("integrate", "switched", "validity_of_run", "delivered")
    )
    np.testing.assert_allclose(run["times"], [every] * 2)
    np.testing.assert_array_equal(run["initial"], numbers(2, 2))
    assert run["keep"] == "work"
    shown = sum(shares)
    run["progress"](1.0)
    assert (shown, sum(shares)) == pytest.approx((0.6, 1.0))
    for call in (run, of_jumps):
        assert {name: call[name] for name in options} == options
    np.testing.assert_array_equal(of_jumps["states"], numbers(2, 2))
    np.testing.assert_allclose(of_jumps["times"], [every] * 2)
    assert asked["_variables"][0]["jumped"] is jumps[0]
    assert asked["_variables"][0]["lost"] is of_power["lost"] is jumps[1]
    np.testing.assert_allclose(run["times"][0, of_time["samples"]], even)
    np.testing.assert_allclose(of_power["times"], [every] * 2)
    np.testing.assert_array_equal(found["found"], numbers(2, 3, at=20.0))
    shown = every if wanted is None else np.array(wanted)
    np.testing.assert_allclose(found["time"], shown)
    at = np.searchsorted(every, shown)
    np.testing.assert_array_equal(found["displacement"], numbers(2, every.size, 2, at=1.0)[:, at, 0])
    np.testing.assert_array_equal(found["heat"], numbers(2, at=31.0))
    np.testing.assert_array_equal(found["apparent_power"], numbers(2, at=32.0))
    assert json.loads(found.attrs["options"]) == {"periods": 3.0 if wanted is None else None, "tolerance": 2e-9}


def test_heat_is_the_mean_of_the_second_half_of_a_run_over_both_films():
    members = ConeModel(damping_ratio=0.1, second_film="taut", second_drive="same", leakage_time=7.0).members()
    run = ran(members, 9, times=np.arange(9.0)[None] ** 2)
    found = response._heat(members, run)
    lost = run.work[0, :, members.system.causes.index("leak")] / 2.0
    for name in ("heat", "heating"):
        np.testing.assert_allclose(found[name][1], [(lost[8] - lost[6]) / (64.0 - 36.0)])
    assert response._heat(ConeModel().members(), run) == {}


def test_means_of_the_second_half_do_not_hang_on_the_samples_that_are_asked_for():
    """Many samples of the first half do not move the second."""
    model = ConeModel(rest_height=0.5, voltage=0.3, voltage_bias=0.2, series_resistance=0.3, leakage_time=9.0)
    end = 20.0
    found = [
        response.simulate(model, times=times)
        for times in (np.linspace(0.0, end, 401), np.append(np.linspace(0.0, 0.3 * end, 4000), end))
    ]
    for name in ("rms_voltage", "rms_current", "apparent_power", "heat"):
        assert float(found[0][name]) == pytest.approx(float(found[1][name]), rel=3e-3), name


def test_states_of_a_film_and_its_pull_in_are_those_at_the_end_of_each_run():
    """Of two runs the second pulled in."""
    members = ConeModel(film="wrinkling", damping_ratio=0.1, voltage=0.0, voltage_bias=[0.3, 0.4]).members()
    kinds = members.system.film.kinds
    spent = numbers(2, 1, len(kinds), at=1.0)
    run = ran(members, 3, film_times=spent, pull_in=np.array([[0], [2]], dtype=np.int8))
    found = response.ends_of_films(members, run)
    shares = validity_variables(validity_of_run(members, run), run.outcome, members.system)
    for k, kind in enumerate(kinds):
        np.testing.assert_allclose(shares[f"film_state_{kind}"][1], spent[:, 0, k] / spent[:, 0].sum(axis=1))
    np.testing.assert_array_equal(found["pull_in_time"][1], [np.nan, run.end_times[1]])
    np.testing.assert_array_equal(found["pull_in_displacement"][1], [np.nan, run.end_states[1, 0]])
    np.testing.assert_array_equal(found["pull_in_film_voltage"][1], [np.nan, 0.4])
    assert found["pull_in_kind"][1].tolist() == [0, 2]
