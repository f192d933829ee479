"""Plans: cells of a grid, their models and starts, and what their coordinates are."""

import numpy as np
import pytest

import gelcone
from gelcone.atlas.plan import Plan, about
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from tests.recorded import numbers
from tests.toys import FilteredVoltage

PUMP = gelcone.find_device("biased-pump").replace(film="taut")
FILTERED = ConeModel(circuit=FilteredVoltage(), voltage=0.3, rest_height=0.2)


def test_the_first_name_varies_slowest_and_draws_fastest():
    plan = Plan(
        ConeModel(), {"voltage": [0.1, 0.2], "displacement": [0.3, 0.4, 0.5]}, draws={"damping_ratio": [0.05, 0.01],
        "rest_height": [0.3, 0.6]},
    )  # fmt: skip
    assert (plan.dims, plan.shape, plan.size) == (("voltage", "displacement", "draw"), (2, 3, 2), 12)
    grid = plan.grid
    assert grid["voltage"].tolist() == [0.1] * 6 + [0.2] * 6
    assert grid["displacement"].tolist() == [0.3, 0.3, 0.4, 0.4, 0.5, 0.5] * 2
    assert grid["damping_ratio"].tolist() == [0.05, 0.01] * 6
    assert grid["rest_height"].tolist() == [0.3, 0.6] * 6
    some = plan.values(np.array([7, 2]))
    assert [some[name].tolist() for name in grid] == [[0.2, 0.1], [0.3, 0.4], [0.01, 0.05], [0.6, 0.3]]


def test_cells_have_their_own_start_or_that_of_the_plan():
    model, states = Plan(ConeModel(), {"velocity": [0.1, 0.2]}, (0.7, 0.5)).at({"velocity": np.array([0.1, 0.2])})
    assert states.tolist() == [[0.7, 0.1], [0.7, 0.2]]
    assert np.shape(model.damping_ratio) == (2,)
    assert Plan(ConeModel(), {"voltage": [0.1, 0.2]}).initial == (1.0, 0.0)
    assert str(Plan(ConeModel(), {"voltage": [0.1, 0.2]}, np.array([0.5, 0.25])).initial) == "(0.5, 0.25)"
    assert Plan(PUMP, {"frequency": [8.0, 9.0]}).initial is None
    pump = Plan(PUMP, {"frequency": [8.0, 9.0]}, ("2 mm", 0.1))
    assert pump.initial == (2e-3, 0.1)
    start = [2e-3 / PUMP.scales.length, 0.1 * PUMP.scales.time / PUMP.scales.length]
    np.testing.assert_allclose(pump.at(pump.grid)[1], [start] * 2)


def test_draws_of_a_start_are_the_start():
    plan = Plan(
        FILTERED, {"voltage": [0.1, 0.2]}, (0.7, 0.5),
        draws={"velocity": [0.3, -0.4], "film_voltage": [0.01, 0.02]},
    )  # fmt: skip
    _, states = plan.at(plan.grid)
    np.testing.assert_array_equal(states, [[0.7, 0.3, 0.01], [0.7, -0.4, 0.02]] * 2)
    _, states = Plan(ConeModel(), {}, (0.7, 0.5), draws={"displacement": [0.1, 0.2]}).at(
        {"displacement": np.array([0.2])}
    )
    np.testing.assert_array_equal(states, [[0.2, 0.5]])
    pump = Plan(PUMP, {}, draws={"displacement": ["3 mm", "4 mm"], "frequency": [8.0, 9.0]})
    _, states = pump.at(pump.grid)
    np.testing.assert_allclose(states, [[3e-3 / PUMP.scales.length, 0.0], [4e-3 / PUMP.scales.length, 0.0]])


def test_the_states_of_components_can_be_swept_and_follow_from_the_start_where_they_are_not():
    plan = Plan(FILTERED, {"film_voltage": [0.1, 0.2], "displacement": [0.5, 0.6]})
    _, states = plan.at(plan.grid)
    np.testing.assert_array_equal(states, [[0.5, 0.0, 0.1], [0.6, 0.0, 0.1], [0.5, 0.0, 0.2], [0.6, 0.0, 0.2]])
    whole = Plan(FILTERED, {"voltage": [0.1, 0.2]}, (0.5, 0.1, 0.25))
    assert whole.at(whole.grid)[1].tolist() == [[0.5, 0.1, 0.25]] * 2
    with pytest.raises(InputError, match="initial"):
        Plan(FILTERED, {"voltage": [0.1, 0.2]}, (0.5, 0.1, 0.25, 0.3))


def test_options_of_a_device_are_scaled_to_its_model():
    plan = Plan(PUMP, {"frequency": [8.0, 9.0]}, options={"patience": "30 s", "tolerance": 1e-9})
    assert float(np.ravel(plan.options["patience"])[0]) == pytest.approx(30.0 / PUMP.scales.time)
    assert plan.options["tolerance"] == 1e-9
    assert Plan(ConeModel(), {"voltage": [0.1, 0.2]}, options={"patience": 30.0}).options == {"patience": 30.0}


@pytest.mark.parametrize(
    ("model", "name", "quantity", "units"),
    [
        (ConeModel(), "voltage", "parameter", "1"), (ConeModel(), "displacement", "length", "1"),
        (ConeModel(), "velocity", "velocity", "1"), (FILTERED, "film_voltage", "parameter", "1"),
        (PUMP, "film_thickness", "device field", "m"), (PUMP, "velocity", "device field", "m/s"),
    ],
)  # fmt: skip
def test_a_coordinate_says_what_it_is(model, name, quantity, units):
    found = about(Plan(model, {name: [1e-4, 2e-4]}), name)
    assert (found["quantity"], found["units"]) == (quantity, units)
    assert found["long_name"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((ConeModel(), {}), "over: is empty"),
        ((ConeModel(), {"voltage": [0.1, 0.2]}, (1.0, 0.0), 3), "draws = 3: must be names and their values"),
        ((ConeModel(voltage=[0.1, 0.2]), {"damping_ratio": [0.1, 0.2]}), "ensemble"),
        ((ConeModel(), {"voltage": [0.1]}), "at least 2 values"),
        (
            (ConeModel(), {"voltage": [0.1, 0.3, 0.2]}),
            r"voltage: 0\.2 comes after 0\.3; the values of a sweep must increase",
        ),
        ((gelcone.find_device("biased-pump"), {"frequency": [10.0, 5.0]}), "frequency: 5 Hz comes after 10 Hz; the"),
        ((ConeModel(), {"voltage": [0.1, 0.1]}), "must increase"),
        ((ConeModel(), {"voltag": [0.1, 0.2]}), "did you mean 'voltage'"),
        ((ConeModel(), {"voltage": [-0.1, 0.2]}), "voltage"),
        ((ConeModel(), {"velocity": [0.1, np.inf]}), "velocity = inf: must be finite"),
        ((ConeModel(), {"voltage": [[0.1, 0.2], [0.3, 0.4]]}), r"in one dimension, not shape \(2, 2\)"),
        ((ConeModel(), {}, None, {"voltag": [0.1, 0.2]}), "'voltag' is not a parameter that can be drawn; did you"),
        ((ConeModel(), {"voltage": [0.1, 0.2]}, (1.0,)), "must be a displacement and a velocity"),
        ((ConeModel(), {"voltage": [0.1, 0.2]}, None, {"voltage": [0.1, 0.2]}), "both swept and drawn"),
        ((ConeModel(), {}, None, {"voltage": [0.1, 0.2], "damping_ratio": [0.1]}), "same number of values"),
        ((PUMP, {"material": ["PVC-DBA 4:1", "PVC-DBA 4:1"]}), "at least 2 gels, each once"),
    ],
)
def test_plans_that_cannot_be_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        Plan(*arguments)


def test_gels_have_no_order():
    plan = Plan(PUMP, {"material": ["PVC-DBA 4:1", "PVC-DBA 6:1"]})
    with pytest.raises(InputError, match="gels have no order; map takes numbers"):
        plan.check_order("map")
    assert Plan(PUMP, {"frequency": [8.0, 9.0]}).check_order("map") is None


def test_what_is_given_of_a_start_stays_and_the_rest_follows_from_it():
    """Of a component with two states of which one is swept: a given start of the other is kept, and each swept state is
    its own, in whatever order the names come."""
    model = FILTERED.replace(viscous_modulus_1=0.5, relaxation_time_1=10.0)
    names = [state.name for state in model.system.states]
    plan = Plan(model, {names[-1]: [0.3, 0.4], "velocity": [0.1, 0.2], "displacement": [0.5, 0.6]})
    at = {names[-1]: np.array([0.4]), "velocity": np.array([0.2]), "displacement": np.array([0.5])}
    _, (states,) = plan.at(at)
    follows = model.members().start_states((0.5, 0.2))[0]
    np.testing.assert_allclose(states, [*follows[:-1], 0.4])
    whole = numbers(len(names), at=0.0)
    plan = Plan(model, {names[2]: [0.3, 0.4]}, tuple(whole))
    _, (states,) = plan.at({names[2]: np.array([0.3])})
    np.testing.assert_allclose(states, [*whole[:2], 0.3, *whole[3:]])


def test_budgets_of_a_device_are_at_least_as_long_in_every_cell():
    """The unit of time is that of each cell's own mass."""
    masses = [0.004, 0.009]
    plan = Plan(PUMP, {"moving_mass": masses}, options={"patience": "30 s"})
    scales = [PUMP.replace(moving_mass=mass).scales.time for mass in masses]
    assert float(plan.options["patience"]) == pytest.approx(30.0 / min(scales))


def test_cells_that_differ_in_their_start_alone_are_as_many_of_the_own_model():
    plan = Plan(ConeModel(damping_ratio=0.37), {"displacement": [0.1, 0.2, 0.3]}, (0.5, 0.25))
    model, states = plan.at(plan.grid)
    assert model.damping_ratio.tolist() == [0.37] * 3
    assert states.tolist() == [[0.1, 0.25], [0.2, 0.25], [0.3, 0.25]]


def test_values_that_the_model_refuses_together_leave_the_other_cells():
    """A bound that belongs to no single parameter: of a permittivity only a part follows late."""
    model = ConeModel(dielectric_share=0.3, dielectric_time=2.0)
    for given in ({"over": {"dielectric_share": [0.5, 1.0]}}, {"over": {}, "draws": {"dielectric_share": [0.5, 1.0]}}):
        plan = Plan(model, **given)
        cells, made, states = plan.possible()
        assert (cells.tolist(), made.dielectric_share.tolist(), states.shape) == ([0], [0.5], (1, 2))
        assert plan.refusal(1).startswith("dielectric_share = 1: must be below 1")
        assert plan.refusal(0) == ""
    with pytest.raises(InputError, match="dielectric_share = 1: must be below 1"):
        Plan(model, {"dielectric_share": [1.0, 1.2]}).possible()


def test_fields_of_a_device_that_exclude_one_another_leave_the_other_cells():
    """The disc is as large as its film, larger, or - in other cells - smaller; options are in the units of those."""
    over = {"disc_radius": [0.01, 0.025, 0.03], "film_radius": np.linspace(0.02, 0.03, 3)}
    plan = Plan(PUMP, over, options={"patience": "30 s"})
    cells, made, _ = plan.possible()
    assert cells.tolist() == [0, 1, 2, 5]
    at = {name: values[cells] for name, values in plan.grid.items()}
    np.testing.assert_array_equal(made.radius_ratio, at["disc_radius"] / at["film_radius"])
    scales = PUMP.replace_quietly(at).scales.time
    assert float(plan.options["patience"]) == pytest.approx(30.0 / scales.min())


def test_coordinates_say_what_begins_there():
    plan = Plan(FILTERED, {"film_voltage": [0.1, 0.2], "displacement": [0.5, 0.6], "velocity": [0.0, 0.1]})
    (state,) = FILTERED.system.states[2:]
    assert about(plan, "film_voltage")["long_name"] == f"initial {state.meaning}"
    assert about(plan, "displacement")["long_name"] == "initial displacement"
    assert about(plan, "velocity")["long_name"] == "initial velocity"
