"""`gelcone.plot` draws every kind of result: each registered figure on a small real one, with its numbers in it."""

import pprint
import tempfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh

import gelcone
from gelcone import ConeModel, InputError
from gelcone.plots import FIGURES, figure_of
from gelcone.presets import find_preset
from tests.plots.described import described, tagged
from tests.plots.figures_table import TABLE

QUICK = {"transient": 30.0, "budget": 60.0}
MODEL = ConeModel(damping_ratio=0.3, stretch_limit=5.0)
MOVING = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3, voltage=0.9)
RAISED = MODEL.replace(rest_height=0.3)
MEMBRANE = ConeModel(film="membrane", stretch_limit=50.0)
DRAWS = {"prestretch": gelcone.Uniform(0.9, 1.1)}


def sweep(analysis, **draws):
    plan = gelcone.Plan(MODEL, {"voltage": [0.5, 1.0]}, draws=gelcone.draw(draws, 4) if draws else {}, options=QUICK)
    return gelcone.sweep(plan, analysis)


def compared():
    pytest.importorskip("skfem")
    from gelcone.continuum.compare import compare

    return compare(RAISED, displacements=[0.1, 0.3], voltages=[0.0, 0.2], elements=20)


def fitted():
    folder = Path(__file__).parents[2] / "docs" / "measured" / "vhb"
    tests = gelcone.read_tests(*(folder / f"vhb-{name}.csv" for name in ("quasi-static", "relaxation", "dielectric")))
    return gelcone.fit_material(tests, laws=["gent"], branches=[0, 1], draws=0)


def designed():
    from tests.lab.quick_design import quick_design

    with tempfile.TemporaryDirectory() as folder:
        return quick_design(Path(folder))[1]


def of_pump(made):
    folder = Path(__file__).parents[2] / "docs" / "measured" / "pump"
    tests = gelcone.read_device_tests(folder / "pump-tests.toml")
    return made(gelcone.find_device(folder / "pump.toml"), tests, {"spring_rate": 0.1, "damping_coefficient": 1.0})


RESULTS = {
    "step": lambda: gelcone.step(RAISED, [0.3, 0.6]),
    "creep": lambda: gelcone.creep(ConeModel(rest_height=0.4, prestretch=1.3, viscous_modulus_1=0.5), [0.3, 0.6]),
    "transfer functions": lambda: gelcone.transfer(RAISED.replace(damping_ratio=0.1), [0.5, 1.0], bias=0.4),
    "triptych": lambda: gelcone.triptych(MOVING.replace(voltage=[0.2, 0.9]), periods=3, late_periods=2, **QUICK),
    "bifurcation diagram": lambda: gelcone.bifurcation(MOVING, "voltage", [0.3, 0.9], bisections=0, **QUICK),
    "draws": lambda: gelcone.over_draws(
        RAISED, {"rest_height": [0.3, 0.31]}, "envelope", frequencies=[0.3, 0.5], peaks=[0.3, 0.6]
    ),
    "extrema": lambda: gelcone.extrema(MOVING, repeats=5, discard=20),
    "best drive": lambda: gelcone.drive(RAISED, lowest_frequency=0.3, highest_frequency=0.5),
    "branches": lambda: gelcone.continue_branch(
        RAISED.replace(damping_ratio=0.1), "drive_frequency", 0.5, 0.9, start="settled", checks=2
    ),
    "locus": lambda: gelcone.locus(
        find_preset("base").model, "doubling", {"voltage": (0.93, 1.02), "drive_frequency": (0.098, 0.102)}, checks=2
    ),
    "basins of attraction": lambda: gelcone.basin(MODEL, {"displacement": [0.0, 1.0], "velocity": [0.0, 1.0]}, **QUICK),
    "data sheet": lambda: gelcone.datasheet(RAISED.replace(voltage=0.2), [0.3]),
    "designs": designed,
    "device fit": lambda: of_pump(gelcone.fit_device),
    "device plan": lambda: of_pump(gelcone.plan_device),
    "film": lambda: gelcone.film(MEMBRANE, [0.3, 0.5], [0.2, 0.5]),
    "frequency response": lambda: gelcone.frequency(RAISED, [0.2, 0.3]),
    "cone and continuum": compared,
    "operating envelope": lambda: gelcone.envelope(RAISED, peaks=[0.3, 0.6], frequencies=[0.3, 0.5]),
    "instability tongues of rest": lambda: gelcone.tongues(MODEL, [0.3, 0.4, 0.5], [0.0, 1.0, 2.0]),
    "Lyapunov exponents": lambda: gelcone.lyapunov(MODEL, **QUICK),
    "material fit": fitted,
    "parameter map": lambda: gelcone.map(MOVING, {"voltage": [0.3, 0.9], "prestretch": [0.9, 1.0]}, **QUICK),
    "Poincare section": lambda: gelcone.section(MOVING, repeats=5, discard=5),
    "regime of motion": lambda: gelcone.regime(MOVING, **QUICK),
    "spectrum": lambda: gelcone.spectrum(MOVING),
    "statics": lambda: gelcone.static(RAISED, [0.0, 0.5]),
    "sweep": lambda: sweep("lyapunov"),
    "probability": lambda: gelcone.probability(sweep("regime", **DRAWS)),
    "time response": lambda: gelcone.simulate(MODEL, periods=2),
}
"""Title of a figure in the register -> a small result of that kind."""


def over_both(analysis, first, second, **draws):
    plan = gelcone.Plan(
        MOVING, dict([first, second]) if second else dict([first]) if first else {},
        draws=gelcone.draw(draws, 4) if draws else {}, options=QUICK if analysis == "regime" else {},
    )  # fmt: skip
    return gelcone.sweep(plan, analysis)


STIFF, STRETCH = ("spring_stiffness", [0.5, 0.75]), ("prestretch", [0.9, 1.0, 1.1])
TWO = ConeModel(second_film="taut", second_flat_height=1.0, voltage=0.4, damping_ratio=0.1)
VARIANTS = {
    "map of the stroke": (lambda: RESULTS["parameter map"](), {"colour": "stroke"}),
    "diagram of the extent": (lambda: RESULTS["bifurcation diagram"](), {"middle": "extent"}),
    "ensemble of responses": (lambda: gelcone.simulate(MOVING.replace(voltage=[0.3, 0.9]), periods=2), {}),
    "response of two films": (lambda: gelcone.simulate(TWO, periods=2), {}),
    "ensemble of exponents": (lambda: gelcone.lyapunov(MOVING.replace(voltage=[0.3, 0.9]), **QUICK), {}),
    "limits over two": (lambda: over_both("limits", STIFF, STRETCH), {}),
    "limits of draws": (lambda: over_both("limits", None, None, prestretch=gelcone.Uniform(0.9, 1.1)), {}),
    "limits over one and draws": (lambda: over_both("limits", STIFF, None, prestretch=gelcone.Uniform(0.9, 1.1)), {}),
    "tolerances over one": (lambda: over_both("regime", ("voltage", [0.3, 0.9]), None, **DRAWS), {}),
    "tolerances": (lambda: over_both("regime", None, None, **DRAWS), {}),
    "probability over two": (
        lambda: gelcone.probability(
            over_both("regime", ("voltage", [0.3, 0.9]), STRETCH, damping_ratio=gelcone.Uniform(0.05, 0.1))
        ),
        {},
    ),
    "response with branches": (
        lambda: gelcone.frequency(RAISED.replace(damping_ratio=0.1), [0.4, 0.5, 0.6], branches=True), {},
    ),
    "static forces": (lambda: gelcone.stroke_and_blocked_force(RAISED, [0.0, 0.2, 0.5]), {}),
}  # fmt: skip
"""Results of the same kinds that are drawn in another way."""


FILTERED = gelcone.find_device("soft-film").replace({"film": "taut", "filter_frequency": "300 Hz"})
IN_TIME = {"transient": "0.5 s", "budget": "1 s"}


@pytest.mark.parametrize(
    ("draw", "label"),
    [
        (lambda: gelcone.regime(FILTERED, **IN_TIME), "displacement (mm)"),
        (lambda: gelcone.section(FILTERED, repeats=5, discard=5), "displacement (mm)"),
        (
            lambda: gelcone.bifurcation(FILTERED, "frequency", ["8 Hz", "9 Hz"], bisections=0, **IN_TIME),
            "displacement (mm)\nonce per forcing period",
        ),
        (
            lambda: gelcone.basin(
                FILTERED, {"displacement": ["2 mm", "5 mm"], "velocity": ["0 m/s", "0.1 m/s"]}, **IN_TIME
            ),
            "initial displacement (mm)",
        ),
        (lambda: gelcone.triptych(FILTERED, periods=3, late_periods=2, **IN_TIME), "displacement (mm)"),
        (lambda: gelcone.simulate(FILTERED, periods=2), "displacement (mm)"),
    ],
)
def test_a_device_of_more_states_than_two_is_drawn_in_its_units(draw, label):
    figure = gelcone.plot(draw())
    axes = figure.axes
    assert label in {text for one in axes for text in (one.get_xlabel(), one.get_ylabel())}


def drawn_numbers(figure):
    """Every number in the lines, points and cells of a figure."""
    found = []
    for axes in figure.axes:
        found += [numbers for line in axes.lines for numbers in line.get_data(orig=False)]
        found += [c.get_offsets().data for c in axes.collections if not isinstance(c, QuadMesh)]
        found += [c.get_array().data for c in axes.collections if c.get_array() is not None]
    return np.concatenate([np.ravel(numbers).astype(float) for numbers in found])


SHOWS = {
    "step": lambda r: r["displacement"],
    "creep": lambda r: r["displacement"][:, 1:],
    "transfer functions": lambda r: r["measured_gain"],
    "triptych": lambda r: r["section_velocity"],
    "best drive": lambda r: r["window_peak"],
    "data sheet": lambda r: r["ramp_stroke"],
    "designs": lambda r: r["apparent_power"],
    "device fit": lambda r: r["predicted"].where(r["reading_test"] < 3, r["measured"] / r["predicted"]),  # a ring-down
    "device plan": lambda r: r["posterior"] / r["prior"],
    "bifurcation diagram": lambda r: r["section"].isel(state=0),
    "draws": lambda r: r["recommended_peak"].median("draw"),
    "extrema": lambda r: r["displacement"],
    "branches": lambda r: r["lyapunov"],
    "locus": lambda r: r["voltage"],
    "material fit": lambda r: r["predicted"],
    "basins of attraction": lambda r: r["attractor"],
    "film": lambda r: xr.concat([r["true_field"], r["hoop_stretch"], r["capacitance"]], "one"),
    "frequency response": lambda r: r["stroke"],
    "cone and continuum": lambda r: r["cone_force"],
    "operating envelope": lambda r: r["blocked_force"],
    "instability tongues of rest": lambda r: r["onset_voltage"],
    "Lyapunov exponents": lambda r: r["running_exponent"],
    "parameter map": lambda r: r["lyapunov"].isel(exponent=0),
    "Poincare section": lambda r: r["velocity"],
    "regime of motion": lambda r: r["section"].isel(state=1),
    "spectrum": lambda r: r["amplitude"].where(r["frequency_ratio"] > 0.0),
    "statics": lambda r: r["equilibrium_displacement"],
    "sweep": lambda r: r["sign"],
    "probability": lambda r: r["probability"],
    "time response": lambda r: r["displacement"],
}
"""Title -> numbers of the result that its figure must show."""


@pytest.mark.parametrize("title", RESULTS)
def test_every_figure_of_the_register_draws_a_real_result(title):
    result = RESULTS[title]()
    assert result.attrs["title"].partition(":")[0] == title
    result = tagged(result)
    figure = gelcone.plot(result)
    assert described(figure, result) == TABLE[title]
    wanted = SHOWS[title](result).values.ravel()
    wanted = wanted[np.isfinite(wanted)]
    numbers = drawn_numbers(figure)
    assert wanted.size
    missing = [value for value in wanted if not np.isclose(numbers, value, rtol=1e-9, atol=1e-12).any()]
    assert not missing


@pytest.mark.parametrize("name", VARIANTS)
def test_other_results_of_a_kind_have_their_own_figures(name):
    made, options = VARIANTS[name]
    result = tagged(made())
    assert described(gelcone.plot(result, **options), result) == TABLE[name]


def test_every_figure_of_the_register_is_tested():
    assert set(RESULTS) == set(SHOWS) == set(FIGURES) == set(TABLE) - set(VARIANTS)


@pytest.mark.parametrize("path", sorted({*FIGURES.values()}))
def test_the_package_lists_and_loads_each_figure(path):
    name = path.split(".")[1]
    assert name in dir(gelcone.plots)
    assert callable(getattr(gelcone.plots, name))


def test_a_name_that_is_no_figure_is_an_attribute_error():
    with pytest.raises(AttributeError, match="has no attribute 'portrait'"):
        _ = gelcone.plots.portrait


# --- results without a figure of their own ----------------------------------------------------------------------------


def test_a_result_over_an_axis_is_drawn_over_it():
    result = gelcone.stroke_and_blocked_force(RAISED, [0.0, 0.2, 0.5])
    axes = {a.get_ylabel(): a for a in gelcone.plot(result).axes}
    line = axes["blocked force"].lines[0]
    assert line.get_xdata().tolist() == [0.0, 0.2, 0.5]
    assert line.get_ydata().tolist() == result["blocked_force"].values.tolist()
    assert list(axes.values())[-1].get_xlabel() == "constant voltage"


def test_a_swept_parameter_is_an_axis():
    result = gelcone.onset_voltage(MODEL.replace(drive_frequency=[0.5, 0.7, 1.0]))
    line = gelcone.plot(result).axes[0].lines[0]
    assert line.get_xdata().tolist() == [0.5, 0.7, 1.0]
    assert line.get_ydata().tolist() == result["onset_voltage"].values.tolist()


def test_single_numbers_are_written_with_meaning_and_unit():
    device = gelcone.find_device("weight-cone").replace(film="wrinkling")
    result = gelcone.to_si(gelcone.pull_in_voltage(device.to_model()), device)
    (axes,) = gelcone.plot(result).axes
    number = float(result["pull_in_voltage"])
    meaning = result["pull_in_voltage"].attrs["long_name"]
    assert f"{meaning}: {number:.5g} V" in [" ".join(text.get_text().split()) for text in axes.texts]


def test_a_result_in_si_units_is_drawn_in_them():
    device = gelcone.find_device("paper-table1")
    response = gelcone.to_si(gelcone.simulate(device.to_model(), device.initial_state(), periods=2), device)
    assert gelcone.plot(response).axes[0].get_ylabel() == "displacement (mm)"


def test_a_map_of_one_parameter_is_drawn_over_it():
    result = gelcone.map(MODEL, {"voltage": [0.5, 1.0]}, **QUICK)
    (line, *_) = gelcone.plot(result).axes[0].lines
    assert line.get_xdata().tolist() == [0.5, 1.0]


def test_options_reach_the_figure():
    diagram = RESULTS["bifurcation diagram"]()
    assert "exponent" in gelcone.plot(diagram).axes[1].get_ylabel()
    assert "displacement" in gelcone.plot(diagram, middle="extent").axes[1].get_ylabel()


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "given", [xr.Dataset({"displacement": ("time", [1.0])}), np.zeros(3), xr.DataArray([1.0], attrs={"title": "sweep"})]
)
def test_what_is_no_result_is_refused_with_a_remedy(given):
    with pytest.raises(
        InputError, match=f"of type {type(given).__name__} .* is not a result of gelcone; give a Dataset"
    ):
        gelcone.plot(given)


def test_a_panel_that_a_diagram_does_not_have_is_refused_with_those_that_it_has():
    with pytest.raises(InputError, match="'phase' is not a middle; known: exponent, extent"):
        gelcone.plot(RESULTS["bifurcation diagram"](), middle="phase")


@pytest.mark.parametrize(
    ("title", "option", "remedy"),
    [
        ("extrema", "kind", "this figure has none"),
        ("bifurcation diagram", "midle", "did you mean 'middle'"),
        ("parameter map", "color", "did you mean 'colour'"),
    ],
)
def test_an_option_that_the_figure_does_not_have_is_refused_by_name(title, option, remedy):
    with pytest.raises(InputError, match=f"'{option}' is not an option of plot for this result; {remedy}"):
        gelcone.plot(RESULTS[title](), **{option: "phase"})


def test_a_result_without_a_variable_of_its_figure_says_which():
    response = RESULTS["time response"]().drop_vars("velocity")
    with pytest.raises(
        InputError, match=r"'time response' of gelcone .* lacks what its figure draws: .*'velocity'; compute it again"
    ):
        gelcone.plot(response)


def test_the_kind_of_a_result_decides_its_figure():
    assert figure_of(sweep("lyapunov")) is gelcone.plots.any_figure


@pytest.mark.parametrize("title", [*FIGURES, "onset of motion"])
def test_a_title_counts_up_to_a_colon(title):
    """What stands behind it says more, such as the analysis of a sweep."""
    drawn = getattr(gelcone.plots, FIGURES.get(title, "values.values_figure").split(".")[1])
    for whole in (title, f"{title}: limits", f"{title}: of: all"):
        assert figure_of(xr.Dataset(attrs={"title": whole, "gelcone_version": "1"})) is drawn


def write_table():
    """Writes the table of what each figure shows anew, to be read and compared line by line."""
    made = {title: (make, {}) for title, make in RESULTS.items()} | VARIANTS
    shown = {}
    for title, (make, options) in made.items():
        result = tagged(make())
        shown[title] = described(gelcone.plot(result, **options), result)
    place = Path(__file__).with_name("figures_table.py")
    about = place.read_text(encoding="utf-8").partition("TABLE = ")[0]
    text = pprint.pformat(shown, width=115, sort_dicts=False)
    place.write_text(f"{about}TABLE = {text}\n", encoding="utf-8")


if __name__ == "__main__":
    write_table()
