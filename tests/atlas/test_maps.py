"""Cells, maps, bifurcation diagrams and basins."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import dataset
from gelcone.atlas import maps as module
from gelcone.atlas.bifurcation import bifurcation, thresholds_of
from gelcone.atlas.maps import ALSO, attractors, basin, map
from gelcone.atlas.plan import Plan
from gelcone.atlas.sweep import compute, sweep
from gelcone.codes import Regime
from gelcone.devices.si import device_attributes
from gelcone.errors import InputError
from gelcone.motion.floquet import onset_voltage, tongues
from gelcone.motion.regime import regime
from gelcone.physics.model import ConeModel
from gelcone.register.analyses import find_analysis
from tests.recorded import numbers, record

FAST = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3)
QUICK = {"transient": 300.0, "budget": 1500.0, "patience": 600.0}


def test_cells_do_not_depend_on_order_or_grouping():
    over = {"voltage": np.linspace(0.3, 1.7, 5), "stretch_limit": np.array([0.3, 1.2, 50.0])}
    plan, analysis = Plan(FAST, over, options={"tolerance": 1e-15, **QUICK}), find_analysis("regime")
    whole = sweep(plan, keep=["section"], threads=2).stack(member=plan.dims)
    order = np.random.default_rng(1).permutation(plan.size)
    for part in (order[:4], order[4:]):
        cells = compute(plan, analysis, part, ["section"])
        for name in cells:
            alone = whole[name].transpose("member", ...).values[part]
            np.testing.assert_array_equal(cells[name].values, alone, str(name))


def test_branches_do_not_depend_on_how_many_members_are_computed_together(monkeypatch):
    whole = bifurcation(FAST, "voltage", np.linspace(0.2, 1.4, 7), bisections=0, **QUICK)
    monkeypatch.setattr("gelcone.atlas.bifurcation.CHUNK", 3)
    xr.testing.assert_identical(bifurcation(FAST, "voltage", np.linspace(0.2, 1.4, 7), bisections=0, **QUICK), whole)


def test_a_map_is_its_cells_one_by_one():
    """The regime of a cell is that of the model with its values, and the first name varies slowest."""
    plane = map(FAST, {"voltage": [0.4, 1.0, 1.6], "damping_ratio": [0.05, 0.2]}, budget=1500.0)
    for voltage, damping in [(0.4, 0.2), (1.6, 0.05), (1.0, 0.2)]:
        alone = regime(FAST.replace(voltage=voltage, damping_ratio=damping), budget=1500.0)
        cell = plane.sel(voltage=voltage, damping_ratio=damping)
        for name in ("regime", "period", "lyapunov", "standard_error", "highest", "doubtful"):
            np.testing.assert_array_equal(cell[name].values, alone[name].values, name)


def test_a_map_may_hold_the_power_and_the_margin_of_each_cell():
    """Those of the settled motion and of the limits of the cell's own device, also where it cannot start."""
    device = gelcone.find_device("biased-pump").replace(film="wrinkling")
    over = {"voltage_amplitude": [200.0, 400.0], "material.stretch_limit": [0.01, 50.0]}
    power, margin = (map(device, over, also=also)[also] for also in ALSO)
    assert (power.attrs["units"], margin.attrs["units"]) == ("mW", "1")
    assert np.isnan(power.sel({"material.stretch_limit": 0.01})).all()
    assert np.isnan(margin.sel({"material.stretch_limit": 0.01})).all()
    for amplitude in (200.0, 400.0):
        own = device.replace(voltage_amplitude=amplitude)
        at = {"voltage_amplitude": amplitude, "material.stretch_limit": 50.0}
        assert float(power.sel(at)) == pytest.approx(float(gelcone.settled(own)["power"]), rel=1e-9)
        limit = float(gelcone.limits(own)["pull_in_voltage"])
        assert float(margin.sel(at)) == pytest.approx(1.0 - (790.0 + amplitude) / limit, rel=1e-9)
    with pytest.raises(InputError, match="'size' is not a quantity of a map"):
        map(device, over, also="size")


def test_cells_that_make_no_actuator_leave_the_others_their_margin(monkeypatch):
    """A permittivity of which all follows late is none."""
    record(monkeypatch, module, jump_voltages=lambda part: (np.full(part.size, 0.8), None))
    model = FAST.replace(dielectric_share=0.3, dielectric_time=2.0)
    plan = Plan(model, {"voltage": [0.1, 0.2], "dielectric_share": [0.3, 1.0]})
    margin = module.with_quantity(xr.Dataset(), plan, "margin")["margin"]
    np.testing.assert_allclose(margin, [[0.875, np.nan], [0.75, np.nan]])


@pytest.mark.parametrize("of_device", [False, True])
def test_the_power_is_that_of_the_motions_of_the_map(monkeypatch, of_device):
    """With the options of the map that the settled motion takes, in the model's units both times."""
    device, asked = gelcone.find_device("biased-pump").replace(film="taut"), []
    model, over = (device, {"frequency": [5.0, 6.0]}) if of_device else (FAST, {"voltage": [0.4, 0.5]})

    def counted(plan, analysis="regime", **how):
        asked.append((analysis, dict(plan.options)))
        found = xr.Dataset({"power" if analysis == "settled" else "regime": (plan.dims, np.zeros(2))})
        return found if plan.device is None else found.assign_attrs(device_attributes(plan.device))

    monkeypatch.setattr(module, "plain", lambda function: counted)
    given = {"transient": 3.0, "patience": 7.0, "budget": 40.0, "tolerance": 1e-9}
    map(model, over, initial=(0.2, 0.1), also="power", **given)
    unit = float(device.scales.size("time")) if of_device else 1.0
    named = {name: value if name == "tolerance" else value / unit for name, value in given.items()}
    assert asked[0] == ("regime", pytest.approx(named, rel=1e-12))
    del named["budget"]
    assert asked[1] == ("settled", pytest.approx(named, rel=1e-12))


def test_cells_outside_the_stretch_limit_do_not_stop_the_map():
    plane = map(FAST, {"stretch_limit": [0.3, 5.0, 50.0], "voltage": [0.3, 1.2]}, **QUICK)
    assert (plane["regime"].sel(stretch_limit=0.3) == Regime.LEFT_THE_DOMAIN).all()
    assert (plane["outcome"].sel(stretch_limit=[5.0, 50.0]) == 0).all()
    assert plane["regime"].dims == ("stretch_limit", "voltage")
    model = dataset.model_of(plane)
    np.testing.assert_array_equal(model.voltage, [[0.3, 1.2]] * 3)


def test_the_first_threshold_is_the_onset_of_rest():
    onset = float(onset_voltage(FAST)["onset_voltage"])
    values = onset * np.array([0.8, 0.9, 1.1, 1.2])
    diagram = bifurcation(FAST, "voltage", values, initial=((0.01, 0.0),), sweeps=(), bisections=5, **QUICK)
    first = thresholds_of(diagram)[0]
    assert first["from"] == "rest"
    assert first["low"] - 0.01 * onset < onset < first["high"] + 0.01 * onset
    assert 0.0 < first["high"] - first["low"] <= 0.2 * onset / 2**5 * 1.001


def test_sweeps_up_and_down_show_hysteresis():
    """Between its folds a lifted film of small stiffness keeps the side it comes from."""
    model = ConeModel(
        damping_ratio=0.1,
        spring_stiffness=0.3,
        hoop_prestretch=1.0,
        voltage=0.05,
        voltage_bias=1.2,
        drive_frequency=0.5,
    )
    heights = np.linspace(-0.6, 0.6, 9)
    diagram = bifurcation(
        model, "rest_height", heights, initial=((-0.8, 0.0),), sweeps=("up", "down"), bisections=0, **QUICK
    )
    middle = 0.5 * (diagram["lowest"] + diagram["highest"])
    gap = (middle.sel(branch="up") - middle.sel(branch="down")).values
    assert np.abs(gap[4]) > 0.3
    assert np.abs(gap[[0, -1]]).max() < 1e-3


def test_sweeps_of_a_driven_film_show_where_rest_and_swing_coexist():
    """Upwards the parametric swing holds on beyond the voltages at which, downwards, rest has become stable again."""
    model = ConeModel(damping_ratio=0.05, spring_stiffness=1.5, drive_frequency=1.1)
    diagram = bifurcation(model, "voltage", np.linspace(0.8, 1.2, 9), initial=((0.1, 0.0),), bisections=4, **QUICK)
    up, down = (diagram["regime"].sel(branch=branch).values for branch in ("up", "down"))
    assert (up == Regime.PERIODIC).all()
    assert down[-1] == Regime.REST
    assert down[0] == Regime.PERIODIC
    assert [str(name) for name in diagram["branch"].values] == ["up", "down", "from 0.1,0"]
    assert diagram["branch"].attrs["long_name"] == "direction of the sweep, or the state that every point starts from"
    (change,) = (row for row in thresholds_of(diagram) if row["branch"] == "down")
    assert (change["from"], change["to"]) == ("periodic", "rest")
    # A start near rest answers the same on both sides of the interval.
    margin = 0.02
    beside = regime(model.replace(voltage=[change["low"] - margin, change["high"] + margin]), (0.01, 0.0))
    assert beside["regime"].values.tolist() == [Regime.PERIODIC, Regime.REST]


def test_a_sweep_that_comes_from_rest_finds_where_rest_is_lost():
    """Rest and swing coexist between 1 and 1.1; met from above, the change is where rest loses its stability."""
    model = ConeModel(damping_ratio=0.05, spring_stiffness=1.5, drive_frequency=1.1)
    tongue = tongues(model, [1.1, 1.2], np.linspace(0.8, 1.2, 41))
    lost = float(tongue["boundary_voltage"][0, -1])
    diagram = bifurcation(model, "voltage", [1.0, 1.1, 1.2], ((0.1, 0.0),), sweeps=("down",), bisections=4, **QUICK)
    (change,) = (row for row in thresholds_of(diagram) if row["branch"] == "down")
    assert (change["from"], change["to"]) == ("periodic", "rest")
    assert change["low"] - 0.01 < lost < change["high"] + 0.01


def test_thresholds_bracket_a_real_change():
    diagram = bifurcation(FAST, "voltage", [0.6, 0.7, 0.8], initial=((0.5, 0.0),), sweeps=(), bisections=6)
    (change,) = thresholds_of(diagram)
    assert 0.0 < change["high"] - change["low"] <= 0.1 / 2**6 * 1.001
    sides = regime(FAST.replace(voltage=[change["low"], change["high"]]), (0.5, 0.0))
    names = [Regime(int(code)).label for code in sides["regime"].values]
    assert names[0] == change["from"] == "rest"
    assert names[1] != "rest"


def test_a_sweep_goes_on_behind_values_that_cannot_start():
    """The stretch limit is swept through values at which the film is torn: each later point starts afresh."""
    diagram = bifurcation(FAST.replace(voltage=0.3), "stretch_limit", [0.2, 0.3, 1.0, 5.0], bisections=0, **QUICK)
    for branch in ("up", "from 1,0"):
        codes = diagram["regime"].sel(branch=branch).values
        assert codes[0] == Regime.LEFT_THE_DOMAIN
        assert codes[-1] == Regime.REST
    # Downwards the disc is at rest already, which any limit allows.
    assert (diagram["regime"].sel(branch="down") == Regime.REST).all()


def test_progress_of_a_diagram_adds_up_to_one():
    shares = []
    bifurcation(FAST, "voltage", [0.2, 0.3, 0.4], bisections=1, progress=shares.append, **QUICK)
    assert min(shares) > 0.0
    assert sum(shares) == pytest.approx(1.0)


def test_a_double_well_has_two_mirror_attractors_with_equal_shares():
    model = ConeModel(damping_ratio=0.2, spring_stiffness=1.5, voltage=0.0, voltage_bias=1.5)
    axis = np.linspace(-1.5, 1.5, 8)
    found = basin(model, {"displacement": axis, "velocity": axis}, **QUICK)
    assert found["attractor_share"].values.tolist() == [0.5, 0.5]
    numbers = found["attractor"].values
    assert (numbers != numbers[::-1, ::-1]).all()
    np.testing.assert_allclose(np.sort(found["attractor_highest"]), [-0.98583, 0.98583], atol=1e-4)


def test_the_attractors_of_a_device_are_in_its_units():
    """Once, as the cells that end on them, and as the motion itself."""
    device = gelcone.find_device("biased-pump").replace(film="taut")
    found = basin(device, {"displacement": ["12 mm", "14 mm"], "velocity": [0.0, 0.1]})
    alone = gelcone.regime(device)
    assert found.sizes["attractor_number"] == 1
    for name in ("lowest", "highest"):
        assert found[f"attractor_{name}"].attrs["units"] == alone[name].attrs["units"] == "mm"
        assert float(found[f"attractor_{name}"][0]) == pytest.approx(float(alone[name]), rel=1e-4)
        assert float(found[f"attractor_{name}"][0]) == float(found[name][0, 0])
    assert float(found["attractor_lyapunov"][0]) == pytest.approx(float(alone["lyapunov"][0]), rel=1e-4)
    assert found["attractor_lyapunov"].attrs["long_name"] == "largest Lyapunov exponent"


def test_basins_are_cut_by_any_state():
    """A raised disc falls into either of two mirror wells; a filter that still holds a voltage shifts the border."""
    model = ConeModel(
        damping_ratio=0.2, spring_stiffness=1.5, voltage=0.0, voltage_bias=1.5, circuit="amplifier", filter_time=2.0
    )
    state = model.system.states[2].name
    found = basin(model, {"displacement": [-0.4, 0.4], state: [0.0, 1.5]}, **QUICK)
    assert found["attractor"].dims == ("displacement", state)
    assert found["attractor_share"].values.tolist() == [0.5, 0.5]
    for k, x in enumerate((-0.4, 0.4)):
        for j, v in enumerate((0.0, 1.5)):
            alone = regime(model, (x, 0.0, v), **QUICK)
            end = found["attractor_highest"].values[int(found["attractor"].values[k, j])]
            assert float(alone["highest"]) == pytest.approx(end, abs=1e-6)
    assert (found["attractor"].values[0] != found["attractor"].values[1]).all()


def test_attractors_are_numbered_by_how_often_they_are_reached_and_what_has_not_settled_is_none():
    """Five cells on a cycle of period 2, three at rest on one side, two on the other, and three on no attractor."""
    kinds = [Regime.REST, Regime.TRANSIENT, Regime.REST, Regime.REST, Regime.LEFT_THE_DOMAIN, *[Regime.PERIODIC] * 5]
    kinds += [Regime.REST, Regime.REST, Regime.TRANSIENT]
    highest = np.array([1.0, 5.0, -1.0, 1.0, 7.0, *[2.0] * 5, 1.0, -1.0, 5.0])
    regimes, cycle = np.array([int(kind) for kind in kinds]), np.array([2 * (k == Regime.PERIODIC) for k in kinds])
    own = {"regime": regimes, "period": cycle, "highest": highest, "lowest": highest - cycle}
    numbers, cells = attractors(own)
    assert numbers.tolist() == [1, -1, 2, 1, -1, *[0] * 5, 1, 2, -1]
    assert cells.tolist() == [5, 0, 2]


def test_a_basin_over_a_state_of_a_component_starts_there():
    """Two wells: a film that has crept far decides in which the disc ends."""
    model = ConeModel(damping_ratio=0.2, voltage=0.0, voltage_bias=1.5, viscous_modulus_1=1.5, relaxation_time_1=30.0)
    over = {"displacement": [-0.9, 0.3], "viscous_meridional_1": [0.2, 1.0]}
    found = basin(model, over, **QUICK)
    for i, x in enumerate(over["displacement"]):
        for k, p in enumerate(over["viscous_meridional_1"]):
            alone = regime(model, (x, 0.0, p, 1.0), **QUICK)
            assert found["highest"].values[i, k] == alone["highest"].item()
            assert found["lyapunov"].values[i, k, 0] == alone["lyapunov"].values[0]
    assert found["viscous_meridional_1"].attrs["long_name"].startswith("initial Maxwell branch 1")


def test_results_read_back_as_they_were(tmp_path):
    diagram = bifurcation(FAST, "voltage", [0.2, 0.3], sweeps=(), **QUICK)
    dataset.save(diagram, tmp_path / "diagram.nc")
    assert dataset.load(tmp_path / "diagram.nc").identical(diagram)


@pytest.mark.parametrize(
    ("over", "options", "message"),
    [
        ({"voltge": [0.0, 1.0]}, {}, "did you mean 'voltage'"),
        ({"voltage": [1.0]}, {}, "at least 2"),
        ({"voltage": [1.0, 0.5]}, {}, "must increase"),
        ({"voltage": [-1.0, 0.5]}, {}, "at least 0"),
        ({"voltage": [0.0, 1.0]}, {"budget": 0.0}, "budget"),
        ({"voltage": [0.0, np.nan]}, {}, "must be"),
        ({"voltage": [[0.0, 1.0]]}, {}, "in one dimension"),
        ({"voltage": [0.0, 1.0]}, {"budget": 0.0}, "budget = 0: must be positive"),
        ({"voltage": [0.0, 1.0]}, {"transient": -1.0}, "transient = -1: must be positive"),
        ({"voltage": [0.0, 1.0]}, {"patience": 0.0}, "patience = 0: must be positive"),
        ({"voltage": [0.0, 1.0]}, {"initial": (1.0,)}, "must be a displacement and a velocity"),
        ({}, {}, "over: is empty"),
        ({"stretch_limit": [0.1, 0.2]}, {}, "must exceed"),
    ],
)
def test_bad_plans_are_refused(over, options, message):
    with pytest.raises(InputError, match=message):
        map(FAST, over, **options)


def test_sweeps_and_states_are_checked():
    with pytest.raises(InputError, match="'sideways'"):
        bifurcation(FAST, "voltage", [0.1, 0.2], sweeps=("sideways",))
    with pytest.raises(InputError, match="initial: is empty"):
        bifurcation(FAST, "voltage", [0.1, 0.2], initial=())
    with pytest.raises(InputError, match="holds a state twice"):
        bifurcation(FAST, "voltage", [0.1, 0.2], initial=((1.0, 0.0), (1, 0)))
    with pytest.raises(InputError, match="bisections = -1: must be at least 0"):
        bifurcation(FAST, "voltage", [0.1, 0.2], bisections=-1)
    with pytest.raises(InputError, match="belongs to the initial state"):
        bifurcation(FAST, "displacement", [0.1, 0.2])
    with pytest.raises(InputError, match="bifurcation: takes one actuator, not an ensemble of 2"):
        bifurcation(FAST.replace(voltage=[0.1, 0.2]), "damping_ratio", [0.1, 0.2])


# --- what is handed on ------------------------------------------------------------------------------------------------

BUDGETS = {"transient": 11.0, "patience": 12.0, "budget": 13.0, "tolerance": 2e-9}
OVER = {"voltage": [0.1, 0.2], "damping_ratio": [0.1, 0.2, 0.3]}


def test_a_map_is_the_sweep_of_its_plan_and_what_is_asked_for_also_takes_half_of_the_work(monkeypatch):
    asked, shares = {}, []

    def sweeps(plan, analysis="regime", **options):
        options["progress"](1.0)
        asked[analysis] = plan, options
        return xr.Dataset({"power": (tuple(plan.over), numbers(2, 3))} if analysis == "settled" else {"regime": 1})

    monkeypatch.setattr(module, "plain", {module.sweep: sweeps}.__getitem__)
    rest = {"coarsest": 2, "store": "folder", "threads": 5}
    found = map(FAST, OVER, (0.25, 0.5), also="power", progress=shares.append, **rest, **BUDGETS)
    np.testing.assert_array_equal(found["power"], numbers(2, 3))
    assert found.attrs["title"] == "parameter map"
    (plan, options), (power, more) = asked["regime"], asked["settled"]
    assert {name: options[name] for name in rest} == rest
    assert (dict(plan.options), plan.initial, plan.model) == (BUDGETS, (0.25, 0.5), FAST)
    assert more["threads"] == 5
    own = {name: value for name, value in BUDGETS.items() if name != "budget"}
    assert (power.initial, power.model, dict(power.options)) == ((0.25, 0.5), FAST, own)
    for name, values in OVER.items():
        assert power.over[name].tolist() == values
    assert shares == [0.5, 0.5]
    shares.clear()
    map(FAST, OVER, also="margin", progress=shares.append)
    assert shares == [1.0]


def test_the_margin_is_what_the_peak_is_below_the_voltage_of_the_jump_where_the_film_can_rest(monkeypatch):
    """Of 0.1 and 0.2 over 0.8 in all cells but those beyond their stretch limit."""
    plan = Plan(FAST, {"voltage": [0.1, 0.2], "stretch_limit": [1e-3, 50.0]})
    stretched = Plan(FAST.replace(prestretch=1.2), plan.over)
    asked = record(monkeypatch, module, jump_voltages=lambda part: (np.full(part.size, 0.8), None))
    found = module.with_quantity(xr.Dataset(), stretched, "margin")
    np.testing.assert_allclose(found["margin"], [[np.nan, 0.875], [np.nan, 0.75]])
    assert asked["jump_voltages"][0]["model"].values["stretch_limit"].tolist() == [50.0, 50.0]
    known = xr.Dataset({"power": 1.0})
    assert module.with_quantity(known, plan, "power") is known
    assert module.with_quantity(known, plan, None) is known


def test_a_basin_has_one_line_for_each_attractor_and_chaos_that_ends_is_what_it_ends_in(monkeypatch):
    """Rest from three of six states, a cycle from two, one of each after chaos; none of one."""
    over, asked = {"displacement": [0.1, 0.2], "velocity": [0.0, 0.5, 1.0]}, {}
    ends = Regime.TRANSIENT_CHAOS
    kinds = [[Regime.REST, ends, Regime.REST], [Regime.PERIODIC, ends, Regime.TRANSIENT]]
    period = [[0, 0, 0], [1, 1, 0]]
    lowest, highest = ([[low, low, low], [high, high, 9.0]] for low, high in ((0.25, 0.5), (0.25, 0.75)))
    growth = np.stack([numbers(2, 3, at=-1.0), numbers(2, 3, at=-2.0)], axis=-1)

    def sweeps(plan, **options):
        asked.update(options, plan=plan)
        dims = tuple(plan.over)
        own = {
            "regime": kinds,
            "period": period,
            "lowest": lowest,
            "highest": highest,
            "status": period,
            "source": period,
        }
        return xr.Dataset(
            {n: (dims, np.array(v)) for n, v in own.items()} | {"lyapunov": ((*dims, "exponent"), growth)}
        )

    monkeypatch.setattr(module, "plain", {module.sweep: sweeps}.__getitem__)
    found = basin(FAST, over, threads=5, progress="progress", **BUDGETS)
    assert (asked["threads"], asked["progress"]) == (5, "progress")
    assert (dict(asked["plan"].options), asked["plan"].initial) == (BUDGETS, (0.0, 0.0))
    assert found["attractor"].values.tolist() == [[0, 0, 0], [1, 1, -1]]
    np.testing.assert_allclose(found["attractor_share"], [0.5, 1.0 / 3.0])
    assert found["attractor_regime"].values.tolist() == [Regime.REST, Regime.PERIODIC]
    assert found["attractor_period"].values.tolist() == [0, 1]
    assert found["attractor_lowest"].values.tolist() == [0.25, 0.5]
    assert found["attractor_highest"].values.tolist() == [0.25, 0.75]
    np.testing.assert_array_equal(found["attractor_lyapunov"], growth[[0, 1], 0, 0])
    assert not {"status", "source"} & set(found)


def test_cells_are_on_one_attractor_where_kind_period_and_both_ends_are_the_same():
    """Chaos is one whatever its ends."""
    kinds = [Regime.PERIODIC] * 5 + [Regime.CHAOTIC] * 2
    cells = {
        "regime": np.array(kinds), "period": np.array([1, 1, 2, 1, 1, 0, 0]),
        "lowest": np.array([0.5, 0.5001, 0.5, 0.25, 0.5, 0.1, 0.2]),
        "highest": np.array([1.5, 1.5, 1.5, 1.5, 1.25, 1.1, 1.2]),
    }  # fmt: skip
    assert [module._same(cells, 0, k) for k in range(6)] == [True, True, False, False, False, False]
    assert module._same(cells, 5, 6)


def test_rests_of_a_device_that_differ_by_next_to_nothing_are_one_attractor(monkeypatch):
    """What is next to nothing is measured by the device's own width, in whatever unit its cells are."""
    pump = gelcone.find_device("biased-pump").replace(film="taut")
    ends = pump.scales.shown("length") * np.array([[2e-6, -2e-6], [0.1, 0.1]])
    own = {"regime": np.full((2, 2), Regime.REST), "period": np.zeros((2, 2)), "lowest": ends, "highest": ends}
    own |= {"status": ends, "source": ends, "lyapunov": -ends}
    cells = xr.Dataset({name: (("displacement", "velocity"), values) for name, values in own.items()})
    cells = cells.assign_attrs(device_attributes(pump))
    monkeypatch.setattr(module, "plain", {module.sweep: lambda plan, **options: cells}.__getitem__)
    found = basin(pump, {"displacement": [1e-3, 2e-3], "velocity": [0.0, 0.1]})
    assert found["attractor"].values.tolist() == [[0, 0], [1, 1]]
