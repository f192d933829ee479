"""Answers: plain JSON, SI units, and the lines that all texts share."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone import ConeModel, Outcome, Regime, dataset, words
from gelcone.analyses import answer
from gelcone.analyses.answer import ending_lines, in_si, outcome_lines, parameters_json, plain, variable_json
from gelcone.analyses.request import Subject
from gelcone.codes import FilmPullIn
from gelcone.devices.si import shown_values
from gelcone.plots import style
from gelcone.register.analyses import ANALYSES
from tests.analyses.said import INF, MODEL, NAN
from tests.edited import edited, made


def test_plain_values_are_json():
    content = {"a": np.array([1.0, np.nan, np.inf]), 3: (np.float32(2.0), np.int8(1)), "x": xr.DataArray([True])}
    assert json.loads(json.dumps(plain(content), allow_nan=False)) == {
        "a": [1.0, None, None],
        "3": [2.0, 1],
        "x": [True],
    }
    assert parameters_json(ConeModel(stretch_limit=[2.0, np.inf]))["stretch_limit"] == [2.0, "inf"]


def test_outcomes_are_counted_with_their_remedy():
    codes = np.array([Outcome.OK, Outcome.OUTSIDE, Outcome.OUTSIDE], dtype=np.int8)
    result = xr.Dataset({"outcome": ("member", codes)})
    assert outcome_lines(result) == [f"2 of 3 runs failed: {Outcome.OUTSIDE.meaning}"]
    assert ending_lines(result) == ["  1 of 3: ok", f"  2 of 3: {Outcome.OUTSIDE.meaning}"]
    assert ending_lines(result.isel(member=0)) == []


def test_cells_that_pulled_in_are_counted_apart_from_those_that_left_otherwise():
    left = [Regime.LEFT_THE_DOMAIN] * 3
    result = made({"regime": ("cell", [Regime.REST, *left]), "outcome": ("cell", [0, 6, 6, 1])})
    assert answer.counts_text(result) == f"rest 1, {Regime.LEFT_THE_DOMAIN.label} 1, {Outcome.PULLED_IN.words} 2"
    assert answer.counts_text(result.isel(cell=slice(3))) == f"rest 1, {Outcome.PULLED_IN.words} 2"


def test_a_run_that_failed_is_not_doubtful():
    """What it says of the motion is that there is none."""
    result = made({"doubtful": ("member", [0, 1, 1, -1]), "outcome": ("member", [0, 0, 6, 1])})
    assert [line.partition(":")[0] for line in answer.doubt_lines(result)] == ["1 of 4 doubtful"]
    assert answer.doubt_lines(result.isel(member=[0, 2, 3])) == []


def test_codes_and_periods_are_known_by_what_they_are_not_by_a_name_that_ends_alike():
    """A user may name a parameter as a variable of ours."""
    period = xr.DataArray([0, 2, np.nan], name="fate_period", attrs={"quantity": "count"})
    assert variable_json(period) == ["none", 2, "unknown"]
    for name in ("duty_cycle", "own_period", "own_regime", "sign", "own_outcome", "unstable"):
        own = xr.DataArray([0.3, 1.0], name=name, attrs={"quantity": "parameter", "units": "1"})
        assert variable_json(own) is own
    at = dataset.columns("limit", {
        "window_regime": ([3.0, np.nan], "kind of motion there", Regime),
        "run_outcome": (np.array([6, 0]), "how the run ended", Outcome),
        "kind": (np.array([1, 2]), "how it pulls in", FilmPullIn),
        "sign": (np.array([-1, 1], dtype=np.int8), "sign of the exponent", "code"),
        "resting": (np.array([0, 1], dtype=np.int8), "1 if at rest", "code"),
        "number": (np.array([0, 1], dtype=np.int8), "of the attractor", "code"),
    })  # fmt: skip
    found = {name: variable_json(variable) for name, variable in xr.Dataset(at).items()}
    assert found["window_regime"] == ["chaotic", "unknown"]
    assert found["run_outcome"] == [Outcome(6).label, "ok"]
    assert found["kind"] == ["minimum", "localisation"]
    assert found["sign"] == ["negative", "positive"]
    assert found["resting"] == [False, True]
    assert found["number"].values.tolist() == [0, 1]


def test_a_device_has_its_states_and_axes_in_si_units():
    device = gelcone.find_device("soft-film")
    model = device.to_model().replace(voltage=[0.1, 0.2])
    result = gelcone.regime(model, transient=60.0, budget=100.0)
    shown = in_si(result, Subject(model, device))
    assert shown["section"].attrs["units"] == "mm, m/s"
    scale = [1e3 * device.scales.length, device.scales.velocity]
    np.testing.assert_allclose(shown["section"], result["section"] * scale)
    np.testing.assert_allclose(shown["voltage"], np.array([0.1, 0.2]) * device.scales.voltage)
    assert shown["voltage"].attrs["units"] == "V"
    assert "amplitude of the drive" in shown["voltage"].attrs["long_name"]
    np.testing.assert_allclose(gelcone.model_of(shown).voltage, [0.1, 0.2], rtol=1e-14)
    assert in_si(result, Subject(model)) is result


@pytest.mark.parametrize("said", [True, False])
def test_further_states_have_their_own_units_and_names(said):
    """Files of 0.2 do not say what further states are: these keep their numbers."""
    device = gelcone.find_device("soft-film").replace(series_resistance="20 Mohm")
    model = device.to_model()
    of = dataset.of_states(model.system) if said else "state"
    variables = {"section": (("point", "state"), np.ones((4, 3)), "states", of)}
    result = dataset.label(model, variables, options={}, title="regime of motion")
    assert result["state"].values.tolist() == ["displacement", "velocity", "film_voltage"]
    shown = in_si(result, Subject(model, device))["section"]
    assert shown.attrs["units"] == ("mm, m/s, V" if said else "mm, m/s, 1")
    last = device.scales.voltage if said else 1.0
    np.testing.assert_allclose(shown[0], [1e3 * device.scales.length, device.scales.velocity, last], rtol=1e-14)
    values, attrs = shown_values(np.ones((1, 4, 3)), result["section"].attrs, device.scales)
    np.testing.assert_array_equal(values[0], shown)
    assert attrs["units"] == shown.attrs["units"]


SHOWN = {"time": 1e3, "voltage": 1.0, "frequency": 1.0, "length": 1e3}
"""Units in which results are read, in an SI unit."""


@pytest.fixture(scope="module")
def pump():
    device = gelcone.find_device("biased-pump").replace(film="taut")
    return Subject(device.to_model(), device, (0.25, 0.5))


@pytest.mark.parametrize("name", [name for name in ANALYSES if name not in ("show", "sweep")])
def test_the_options_of_an_answer_are_in_the_units_of_the_device(name, pump):
    model, device = pump.model, pump.device
    per = {"time": device.scales.time, "voltage": device.voltage_amplitude / model.voltage,
           "frequency": device.frequency / model.drive_frequency, "length": device.scales.length}  # fmt: skip
    measured = {o.name: o.quantity for o in ANALYSES[name].options.values() if o.quantity}
    shown = made({}, options=json.dumps(dict.fromkeys(measured, 0.5) | {"tolerance": 0.25, "unset": None}))
    found = answer.options_json(ANALYSES[name].command, shown, device)
    for option, quantity in measured.items():
        assert found[option] == pytest.approx(0.5 * per[quantity] * SHOWN[quantity], rel=1e-9), option
    assert found["tolerance"] == 0.25
    assert found["unset"] is None
    plain = answer.options_json(ANALYSES[name].command, shown, None)
    assert all(plain[option] == 0.5 for option in measured)


def test_the_answer_says_what_it_is_about(pump):
    shown = made(
        {"outcome": ("member", [0, 6]), "highest": ("member", [1.0, NAN], "mm"), "validity_near_limit": ("member",
        [0.5, NAN]),
         "film_state_taut": ("member", [1.0, 0.5])},
        options='{"budget": null}',
    )  # fmt: skip
    ensemble = Subject(MODEL.replace(voltage=[0.5, 0.75, 1.0]), None, (0.25, 0.5))
    found = answer.plain(answer.answer_json("regime", {"kind": "made"}, shown, ensemble))
    errors = dict.fromkeys(("film_error", "gain_error", "capacitance_error"))
    about = {"device": None, "fields": None, "film": "taut", "members": 3, "initial": [0.25, 0.5]}
    assert found["subject"] == about | errors
    assert found["parameters"]["voltage"] == [0.5, 0.75, 1.0]
    assert (found["command"], found["result"], found["units"]) == ("regime", {"kind": "made"}, None)
    assert found["outcome"] == ["ok", "pulled_in"]
    assert found["validity"] == {"near_limit": [0.5, "unknown"]}
    assert found["film_state"] == {"taut": [1.0, 0.5]}
    assert found["dims"] == {str(name): ["member"] for name in shown}
    own = answer.plain(answer.answer_json("regime", {}, shown, pump))
    assert own["subject"]["device"] == "biased pumping cone"
    assert own["subject"]["film"] == "taut"
    assert own["subject"]["fields"]["spring_rate"] == pump.device.parameters()["spring_rate"]
    scales = pump.device.scales
    assert own["subject"]["initial"] == pytest.approx([250.0 * scales.length, 0.5 * scales.velocity])
    assert (own["parameters"], own["units"]) == (None, {"highest": "mm"})
    nothing = answer.answer_json("limits", {}, made({}, options="{}"), Subject(MODEL, None, None))
    assert [nothing[name] for name in ("outcome", "validity", "film_state")] == [None, None, None]
    assert nothing["subject"]["initial"] is None


@pytest.mark.parametrize(
    ("name", "of", "values", "found"),
    [
        ("regime", Regime, [0, 3, -1], ["rest", "chaotic", "unknown"]),
        ("fate_regime", Regime, [1, -1], ["periodic", "none"]),
        ("threshold_from", Regime, [2], ["quasi-periodic"]),
        ("threshold_to", Regime, [6], ["transient chaos"]),
        ("motion_outcome", Outcome, [0, 6], ["ok", "pulled_in"]),
        ("sign", "code", [-1, 0, 1], ["negative", "uncertain", "positive"]),
        ("symmetric", "code", [0, 1, -1], [False, True, "unknown"]),
        ("coexisting", "code", [0, 1], [False, True]),
        ("cascade", "code", [1, 0], [True, False]),
        ("period", "count", [2.0, 0.0, NAN], [2, "none", "unknown"]),
        ("cycle", "count", [1.0, 0.0], [1, "none"]),
        ("height", "length", [0.5, 1.0], [0.5, 1.0]),
    ],
)
def test_codes_are_words_in_json(name, of, values, found):
    own = xr.DataArray(np.array(values), dims="k", name=name, attrs=dataset.attributes("", of))
    assert answer.plain(answer.variable_json(own)) == found


@pytest.mark.parametrize(
    ("values", "attrs", "found"),
    [
        ([1.0, NAN, INF], {}, [1.0, "unknown", "infinite"]),
        ([NAN, INF], {"nan_means": "not applicable", "infinite_means": "never"}, ["not applicable", "never"]),
    ],
)
def test_what_is_not_finite_is_a_word_in_json_and_text(values, attrs, found):
    variable = xr.DataArray(values, dims="k", attrs=attrs)
    assert answer.plain(variable) == found
    assert [words.measured(one) for one in variable] == [v if isinstance(v, str) else "1" for v in found]


def test_the_heading_of_a_text():
    lines = answer.heading(Subject(MODEL.replace(voltage=0.75, damping_ratio=0.25)), ["voltage"])
    text = " ".join(line.strip() for line in lines)
    assert lines[0] == "cone model, dimensionless"
    assert "damping_ratio 0.25" in text
    assert "voltage 0.75" not in text
    assert "voltage 0.75" in " ".join(answer.heading(Subject(MODEL.replace(voltage=0.75))))
    assert max(map(len, lines)) <= answer.WIDTH
    default = "bears compression, the default without a device; --film membrane wrinkles, as the film of devices does"
    assert default in text
    wrinkles = " ".join(answer.heading(Subject(MODEL.replace(film="wrinkling"))))
    assert "default without a device" not in wrinkles
    device = gelcone.find_device("biased-pump").replace(film="taut")
    own = " ".join(answer.heading(Subject(device.to_model(), device), ["spring_rate"]))
    assert own.startswith("biased pumping cone")
    assert "default without a device" not in own
    assert "spring rate" not in own.replace("_", " ")
    grid = made({}, {"voltage": ("voltage", [800.0, 850.0, 900.0], "V"), "material": ("material", ["a", "b"])})
    assert answer.grid_text(grid, ["voltage", "material"]) == "voltage 800 to 900 V, 3 values; material a, b, 2 values"


def test_the_heading_names_components_other_than_the_usual_ones():
    own = MODEL.replace(waveform="triangle", bias="spring+tests.toys:CubicBias", circuit="charge")
    lines = " ".join(line.strip() for line in answer.heading(Subject(own)))
    for said in ("bias spring + cubic", "waveform triangle", "circuit charge"):
        assert said in lines
        assert said not in " ".join(answer.heading(Subject(MODEL)))


def test_the_heading_states_the_error_of_a_film_that_stays_the_same():
    """Whatever else is swept; of films that differ the error of the first would be that of none."""
    device = gelcone.find_device("biased-pump")
    subject, plain = Subject(device.to_model(), device), Subject(device.to_model())
    own = subject.model.own_numbers
    stated = f"its force is known to {own['film_error']:.1%}, what a voltage takes from it to {own['gain_error']:.1%}, "
    stated += f"its capacitance to {own['capacitance_error']:.1%}"
    for kept in ((), ("frequency",), ("spring_rate", "payload")):
        assert stated in " ".join(line.strip() for line in answer.heading(subject, kept))
    for varied in ("hoop_prestretch", "prestretch", "film_radius", "disc_radius", "material.stretch_limit", "material"):
        assert "is known to" not in " ".join(line.strip() for line in answer.heading(subject, ["frequency", varied]))
    assert stated in " ".join(line.strip() for line in answer.heading(plain, ["voltage"]))
    for varied in ("hoop_prestretch", "radius_ratio", "stretch_limit"):
        assert "is known to" not in " ".join(line.strip() for line in answer.heading(plain, [varied]))


def test_how_members_of_a_text_end():
    two = made({"outcome": ("member", [0, 6, 6])})
    assert answer.ending_lines(two) == ["  1 of 3: ok", f"  2 of 3: {Outcome.PULLED_IN.meaning}"]
    assert answer.ending_lines(made({"outcome": 0})) == []


def test_the_heading_of_an_ensemble_has_the_range_of_what_differs():
    device = gelcone.find_device("biased-pump").replace(film="taut", frequency=[5.0, 10.0, 5.0])
    own = " ".join(" ".join(answer.heading(Subject(device.to_model(), device))).split())
    assert "frequency 5 to 10 Hz (2 values)" in own
    assert "frequency" not in " ".join(answer.heading(Subject(device.to_model(), device), ["frequency"]))
    plain = " ".join(answer.heading(Subject(MODEL.replace(voltage=[0.25, 0.75]))))
    assert "voltage 0.25 to 0.75 (2 values)" in plain


@pytest.mark.parametrize(
    ("swept", "stated"),
    [([], True), (["frequency", "film_thickness"], True), (["hoop_prestretch"], False), (["disc_radius"], False),
     (["material.stretch_limit"], False), (["material"], False)],
)  # fmt: skip
def test_the_error_of_the_film_is_stated_unless_what_is_swept_changes_the_film(swept, stated):
    device = gelcone.find_device("biased-pump")
    text = " ".join(answer.heading(Subject(device.to_model(), device), swept))
    assert ("its force is known" in text) == stated


def test_of_films_of_an_ensemble_the_largest_error_is_stated(monkeypatch):
    model = gelcone.ConeModel(film="membrane", radius_ratio=[0.25, 0.25])
    monkeypatch.setitem(vars(model), "own_numbers", model.own_numbers | {"film_error": np.array([0.005, 0.02])})
    text = " ".join(line.strip() for line in answer.heading(Subject(model)))
    assert "its force is known to 2.0%" in text


@pytest.mark.parametrize(("swept", "stated"), [("drive_frequency", True), ("radius_ratio", False)])
def test_the_error_of_a_model_s_film(swept, stated):
    text = " ".join(answer.heading(Subject(gelcone.ConeModel(film="membrane", radius_ratio=0.25)), [swept]))
    assert ("its force is known" in text) == stated


@pytest.mark.parametrize("out", ["map.zarr", "map.zarr/a", "map.zarr/a/b/c", "maps/a", "map"])
def test_files_are_not_written_into_a_store_however_deep(out, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "map.zarr").mkdir()
    (tmp_path / "map.zarr" / "zarr.json").write_text("{}")
    if out.startswith("map.zarr"):
        with pytest.raises(gelcone.InputError) as error:
            answer.check_folder(Path(out), "limits", True)
        store = tmp_path / "map.zarr"
        assert str(error.value) == f"{out}: lies inside the store {store}; choose a folder outside"
    else:
        answer.check_folder(Path(out), "limits", False)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["map.zarr", "zarr.json"]


def test_a_result_and_its_figure_are_replaced_only_where_that_was_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(style, "draw_file", lambda figure, path: path.write_text(figure))
    result, out = made({"height": (None, 12.5, "mm")}), tmp_path / "there"
    places = answer.write_results(out, "limits", result, "first", False)
    assert places == (out / "limits.nc", out / "limits.png")
    ways = (answer.check_folder, lambda *to: answer.write_results(*to[:2], edited(result, height=13.5), "then", to[2]))
    for ask in ways:
        for name in ("limits.nc", "limits.png"):  # either of them
            (out / name).rename(out / "other")
            with pytest.raises(gelcone.InputError, match=rf"limits\.{'png' if name.endswith('nc') else 'nc'}: exists"):
                ask(out, "limits", False)
            (out / "other").rename(out / name)
        assert (float(gelcone.load(places[0])["height"]), places[1].read_text()) == (12.5, "first")
        ask(out, "limits", True)
    assert (float(gelcone.load(places[0])["height"]), places[1].read_text()) == (13.5, "then")
    answer.check_folder(out, "settled", False)
    answer.check_folder(None, "limits", False)


@pytest.mark.parametrize("thickness", ["0.2 mm", "0.21 mm", "0.23 mm"])
def test_what_was_typed_comes_back_as_it_was_typed(thickness):
    """Axes, single numbers and options of a device, which are scaled to it and back."""
    device = gelcone.find_device("biased-pump").replace(film="taut", film_thickness=thickness)
    volts = [100.0 * k for k in range(1, 12)]
    found = gelcone.static(device, volts)
    assert found["constant_voltage"].values.tolist() == volts
    assert answer.options_json("static", found, device)["voltages"] == volts
    for bias in volts[:3]:
        about = gelcone.transfer(device, [5.0], bias=bias, amplitudes=[10.0], threads=1)
        assert (float(about["bias_voltage"]), answer.options_json("transfer", about, device)["bias"]) == (bias, bias)
