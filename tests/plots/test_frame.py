"""What every figure has: axes in the units of the device, and the parameters that it shares."""

import json

import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import gelcone
from gelcone import ConeModel
from gelcone.plots.frame import LINE, TERMS, add_footnote, fixed_parameters
from tests.plots.made_up import texts

MODEL = ConeModel(damping_ratio=0.3, voltage=[0.2, 0.4], dielectric_strength=1.5)


def test_a_figure_says_which_parameters_all_of_it_shares():
    response = gelcone.simulate(MODEL, periods=2)
    footnote = fixed_parameters(response)
    assert "damping ratio 0.3" in footnote
    assert "dielectric strength 1.5" in footnote
    assert "voltage 0" not in footnote.replace("voltage bias 0", "")
    figure = gelcone.plot(response)
    assert footnote.split(",")[0] in texts(figure)
    assert gelcone.plot(response).get_size_inches()[1] > gelcone.plots.response_figure(response).get_size_inches()[1]


def note(coords=(), **attrs):
    """The note of a result without numbers."""
    return fixed_parameters(xr.Dataset({}, {name: ("k", [0.0, 1.0]) for name in coords}, attrs))


def test_what_is_swept_or_drawn_is_not_fixed_nor_is_the_usual_mentioned():
    own = {
        "voltage": 0.3,
        "damping_ratio": 0.123456,
        "rest_height": 0.5,
        "law": "gent",
        "film": "wrinkling",
        "count": 3,
    }
    own |= {"prestretch_mode": "radial", "bias": "beam", "circuit": "ideal", "waveform": "a description of a waveform"}
    own |= {"prestretch": [1.0, 1.2]}
    model = json.dumps(own)
    whole = ["voltage 0.3", "damping ratio 0.1235", "rest height 0.5", "film wrinkling", "count 3", "bias beam"]
    for given, gone in (
        ({}, ()), ({"coords": ["voltage"]}, (0,)), ({"coords": ["drawn_damping_ratio"]}, (1,)),
        ({"parameter": "rest_height"}, (2,)), ({"parameters": "voltage,rest_height"}, (0, 2)),
        ({"coords": ["film"]}, (3,)),
    ):  # fmt: skip
        left = [words for k, words in enumerate(whole) if k not in gone]
        assert note(model=model, **given) == "fixed (dimensionless): " + ", ".join(left), given
    assert note(model=json.dumps({"law": "gent"})) == ""
    assert note() == ""


@pytest.mark.parametrize("name", ["film_thickness", "drawn_film_thickness"])
def test_what_is_swept_or_drawn_of_a_device_is_not_fixed(name):
    device = gelcone.find_device("biased-pump")
    response = gelcone.simulate(device.replace(film="taut"), periods=1)
    assert "film_thickness 200 um" in fixed_parameters(response)
    assert fixed_parameters(response).endswith("film taut")
    footnote = fixed_parameters(response.assign_coords({name: ("k", [1.0, 2.0])}))
    assert "film_thickness" not in footnote
    assert "disc_radius" in footnote


def test_a_field_of_a_device_is_not_fixed_over_the_parameter_that_follows_from_it():
    response = gelcone.simulate(gelcone.find_device("biased-pump").replace(film="taut"), periods=1)
    assert ", frequency 10 Hz" in fixed_parameters(response)
    assert ", frequency" not in fixed_parameters(response.assign_coords(drive_frequency=("k", [1.0, 2.0])))


@pytest.mark.parametrize("kind", ["frequency", "static"])
def test_the_note_lies_below_everything_else(kind):
    single = ConeModel(damping_ratio=0.3, voltage=0.3, rest_height=0.5)
    result = gelcone.frequency(single, [0.9, 1.0, 1.2]) if kind == "frequency" else gelcone.static(single)
    figure = gelcone.plot(result)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    (note,) = (text for text in figure.texts if text.get_text().startswith("fixed"))
    top = note.get_window_extent(renderer).y1
    for above in (*figure.axes, *figure.legends):
        assert above.get_tightbbox(renderer).y0 >= top - 1.0


def test_the_axes_and_the_note_of_a_device_are_in_its_units():
    device = gelcone.find_device("soft-film")
    over = {"voltage_amplitude": [100.0, 200.0], "voltage_offset": [50.0, 100.0]}
    swept = gelcone.map(device, over, budget=100.0, transient=60.0)
    figure = gelcone.plot(swept)
    assert figure.axes[0].get_xlabel().endswith("(V)")
    assert figure.axes[0].get_ylabel().endswith("(V)")
    footnote = fixed_parameters(swept)
    assert "film_radius" in footnote
    assert "voltage_amplitude" not in footnote


def test_a_sweep_of_three_parameters_is_a_row_of_maps():
    plan = gelcone.Plan(
        ConeModel(damping_ratio=0.3),
        {"voltage": [0.2, 0.4], "prestretch": [1.0, 1.2], "drive_frequency": [0.8, 0.9, 1.0]},
        options={"budget": 100.0, "transient": 60.0},
    )
    figure = gelcone.plot(gelcone.sweep(plan))
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["drive frequency 0.8", "drive frequency 0.9", "drive frequency 1"]
    assert all(axes.collections for axes in figure.axes)


@pytest.mark.parametrize(("text", "said"), [("", TERMS), ("fixed: voltage 0.3", f"fixed: voltage 0.3. {TERMS}")])
def test_the_note_ends_with_where_terms_are_explained(text, said):
    figure = Figure(figsize=(6.0, 3.0), layout="constrained")
    add_footnote(figure, text)
    assert [one.get_text() for one in figure.texts] == [said]
    assert figure.get_size_inches() == pytest.approx((6.0, 3.0 + LINE + 0.06))


def test_no_line_of_the_note_parts_a_name_from_its_value():
    pairs = [f"parameter {k} is" for k in range(30)]
    figure = Figure(figsize=(3.0, 3.0), layout="constrained")
    add_footnote(figure, ", ".join(pairs))
    lines = figure.texts[0].get_text().split("\n")
    assert len(lines) > 5
    assert all(line.startswith(("parameter", "terms", "help", "glossary", "gelcone")) for line in lines)
    assert figure.get_size_inches()[1] == pytest.approx(3.0 + LINE * len(lines) + 0.06)


def test_a_caption_names_the_components_and_numbers_of_one_s_own():
    samples = {"component": "samples", "shares": [0, 0.5, 1], "values": [0, 1, -1], "repeat": True, "jump": True}
    own = gelcone.find_device("biased-pump").replace(
        {"material.shear_modulus": "9 kPa"}, waveform=samples, bias="tests.toys:CubicBias", film="taut"
    )
    words = fixed_parameters(gelcone.simulate(own, periods=1)).split(", ")
    assert {"waveform samples (3 values", "bias cubic", "shear_modulus 9 kPa", "film taut"} <= set(words)
    plain = gelcone.simulate(ConeModel(waveform=samples), periods=1)
    assert "waveform samples" in fixed_parameters(plain).split(", ")
