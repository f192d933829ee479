"""Cells of maps and strips are those of the command line, whoever computes them."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import InputError, Outcome
from gelcone.analyses.request import read_subject
from gelcone.devices.files import shipped_devices
from gelcone.studio import grids
from gelcone.studio.controls import controls_of
from gelcone.studio.grids import IMPOSSIBLE, PULLED_IN, Source, axis, even_tasks, kinds, thresholds

PUMP = Source(shipped_devices()["biased-pump"], None, {"settings": []})


def test_cells_of_a_device_are_those_of_regime():
    found = kinds(PUMP, {"voltage_amplitude": ["300 V", "500 V"], "frequency": ["9 Hz", "11 Hz"]})
    for k, (volts, hertz) in enumerate([("300 V", "9 Hz"), ("500 V", "11 Hz")]):
        device = gelcone.find_device("biased-pump").replace(voltage_amplitude=volts, frequency=hertz)
        one = gelcone.to_si(gelcone.regime(device.to_model(), device.initial_state()), device)
        assert found["regime"][k] == int(one.regime)
        assert found["high"][k] == float(one.highest)
        assert found["exponent"][k] == float(one.lyapunov[0])
        np.testing.assert_array_equal(found["section"][k], one.section[:, 0])


def test_only_a_film_that_pulls_in_has_that_kind(monkeypatch):
    """The others have the one that the analysis gives: what ran out of steps or digits has not left the domain."""
    outcome = np.array([Outcome.OK, Outcome.PULLED_IN, Outcome.STRETCH_LIMIT, Outcome.STEP_LIMIT])
    periodic, left, open_ = (int(gelcone.Regime[name]) for name in ("PERIODIC", "LEFT_THE_DOMAIN", "TRANSIENT"))
    blank = np.zeros(4)
    made = {"regime": ("", np.array([periodic, left, open_, open_])), "lowest": ("", blank), "highest": ("", blank)}
    made |= {"section": ("", np.zeros((4, 2, 2))), "lyapunov": ("", np.zeros((4, 2)))}
    regime = SimpleNamespace(compute=lambda *given, **options: SimpleNamespace(outcome=outcome, variables=made))
    monkeypatch.setattr(grids, "ANALYSES", {"regime": regime})
    found = kinds(PUMP, {"frequency": ["9 Hz", "10 Hz", "11 Hz", "12 Hz"]})
    assert found["regime"].tolist() == [periodic, PULLED_IN, open_, open_]


def test_any_field_of_a_device_is_an_axis_and_what_cannot_be_built_says_so():
    found = kinds(PUMP, {"disc_radius": ["6 mm", "40 mm"]})
    assert found["regime"].tolist() == [gelcone.Regime.PERIODIC, IMPOSSIBLE]
    device = gelcone.find_device("biased-pump").replace(disc_radius="6 mm")
    one = gelcone.to_si(gelcone.regime(device.to_model(), device.initial_state()), device)
    assert found["high"][0] == pytest.approx(float(one.highest), rel=1e-12)


def test_cells_of_a_preset_take_starts_too():
    found = kinds(Source(None, None, {"preset": "base", "settings": []}), {"displacement": ["0.5", "1"]})
    assert found["regime"].tolist() == [gelcone.Regime.REST] * 2


def test_cells_of_a_preset_begin_where_their_axes_say_and_else_where_the_preset_does():
    subject = read_subject(None, preset="base", settings=[])
    axes = {"velocity": ["0.5", "-0.25"], "voltage": ["0.3", "0.4"]}
    found = grids.cells_of(subject, axes)
    np.testing.assert_array_equal(found.states[:, 1], [0.5, -0.25])
    np.testing.assert_array_equal(found.states[:, 0], [subject.initial[0]] * 2)
    assert found.members.number("voltage").tolist() == [0.3, 0.4]
    both = grids.cells_of(subject, {"displacement": ["0.5", "0.6"], "velocity": ["0.1", "0.2"]})
    np.testing.assert_array_equal(both.states, [[0.5, 0.1], [0.6, 0.2]])
    for scale in (found.length, found.rate, found.voltage):
        np.testing.assert_array_equal(scale, [1.0, 1.0])


def test_an_axis_holds_numbers_of_a_control():
    controls = controls_of(read_subject("biased-pump"))
    found = axis(controls, ["frequency", 5, 15], 11)
    assert found.texts([0, 10]) == ["5 Hz", "15 Hz"]
    for bad in (
        ["nothing", 0, 1],
        ["material", 0, 1],
        ["frequency", 2, 1],
        ["frequency", 0, "x"],
        "frequency",
        [[], 0, 1],
    ):
        with pytest.raises(InputError):
            axis(controls, bad, 11)


def test_thresholds_are_those_of_limits():
    preset = Source(None, None, {"preset": "base", "settings": []})
    lines = thresholds(preset, {"spring_stiffness": ["0.5", "0.9"]})
    model = gelcone.ConeModel.from_parameters(preset.subject().model.parameters()).replace(spring_stiffness=[0.5, 0.9])
    limits = gelcone.limits(model)
    np.testing.assert_array_equal(lines["pull-in of the cone at the peak"], limits.pull_in_voltage)
    np.testing.assert_array_equal(lines["rest becomes unstable"], limits.onset_voltage)


@pytest.mark.parametrize(("count", "sizes"), [(0, []), (20, [20]), (130, [33, 33, 32, 32]), (600, [120] * 5)])
def test_the_tasks_of_a_level_are_even(count, sizes):
    parts = even_tasks(np.arange(count), workers=2, most=128)
    assert [part.size for part in parts] == sizes
    assert np.concatenate([np.zeros(0), *parts]).tolist() == list(range(count))


def test_cells_that_pull_in_are_a_kind_of_their_own():
    source = Source(None, None, {"preset": "base", "settings": ["film=wrinkling", "rest_height=1"]})
    found = kinds(source, {"voltage": ["0.1", "3"]})
    assert found["regime"].tolist()[1] == PULLED_IN != found["regime"].tolist()[0]
    outcome = gelcone.regime(source.subject().model.replace(voltage=3.0), source.subject().initial).outcome
    assert int(outcome) == gelcone.Outcome.PULLED_IN


# --- in full words, and both sides of bounds --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["nothing", 0, 1], "'nothing': is not a parameter that can be swept here; choose one of the list"),
        (["material", 0, 1], "'material': is not a parameter that can be swept here; choose one of the list"),
        ("frequency", "Frequency: give numbers for both ends"),
        (["frequency", 1], "['frequency', 1]: is not a parameter that can be swept here; choose one of the list"),
        ([], "[]: is not a parameter that can be swept here; choose one of the list"),
        (["frequency", 0, "x"], "Frequency: give numbers for both ends"),
        (["frequency", 0, float("inf")], "Frequency: give numbers for both ends"),
        (["frequency", 2, 1.5], "Frequency: from 2 to 1.5 is empty; the first end must be below the second"),
        (["frequency", 2, 2], "Frequency: from 2 to 2 is empty; the first end must be below the second"),
    ],
)
def test_an_axis_that_cannot_be_is_refused_in_full_words(given, message):
    with pytest.raises(InputError) as error:
        axis(controls_of(read_subject("biased-pump", settings=["film=taut"])), given, 11)
    assert str(error.value) == message


def test_the_values_of_an_axis_are_typed_with_ten_digits():
    own = grids.Axis("a", "mm", np.array([0.1 + 0.2, 1.0 / 3.0, 2.0]))
    assert own.texts([2, 0, 1]) == ["2 mm", "0.3 mm", "0.3333333333 mm"]
    assert grids.Axis("a", "", np.array([1.5])).texts([0]) == ["1.5"]


def test_a_source_is_another_one_where_its_file_text_or_options_are(tmp_path):
    import os

    path = tmp_path / "own.toml"
    path.write_text(shipped_devices()["soft-film"].read_text(encoding="utf-8"), encoding="utf-8")
    sources = [Source(path, None, {"settings": []}), Source(path, None, {"settings": ["frequency=9 Hz"]}),
               Source(None, path.read_text(), {"settings": []}), Source(None, "other", {"settings": []})]  # fmt: skip
    assert len({source.key for source in sources}) == 4
    before = sources[0].key
    os.utime(path, ns=(5, 7))
    assert (sources[0].key != before, grids.modified(path)) == (True, 7)
    assert (grids.modified(None), grids.modified(tmp_path / "gone")) == (0, 0)
    assert grids.device_in(None, None) is None
    assert grids.device_in(None, path.read_text()) == grids.device_in(path, None) == gelcone.find_device("soft-film")


@pytest.mark.parametrize(
    ("count", "workers", "most", "sizes"),
    [
        (31, 1, 48, [31]), (33, 1, 48, [17, 16]), (96, 1, 48, [48, 48]), (97, 1, 48, [33, 32, 32]),
        (256, 4, 128, [32] * 8), (512, 4, 128, [64] * 8), (10_000, 1, 128, [127] * 46 + [126] * 33),
    ],
)  # fmt: skip
def test_tasks_are_no_smaller_than_lanes_and_no_larger_than_a_picture_waits_for(count, workers, most, sizes):
    assert [part.size for part in even_tasks(np.arange(count), workers, most)] == sizes


def test_one_unit_of_a_cell_is_that_of_its_own_device():
    found = grids.cells_of(
        read_subject("biased-pump", settings=["film=taut"]), {"film_thickness": ["0.2 mm", "0.25 mm"]}
    )
    for k, thickness in enumerate((2e-4, 2.5e-4)):
        scales = gelcone.find_device("biased-pump").replace(film="taut", film_thickness=thickness).scales
        assert [found.length[k], found.rate[k], found.voltage[k]] == pytest.approx(
            [1e3 * scales.length, 1.0 / scales.time, scales.voltage], rel=1e-12
        )


def test_a_cell_begins_where_its_own_device_rests():
    heights = ["18 mm", "22 mm"]
    found = grids.cells_of(read_subject("biased-pump", settings=["film=taut"]), {"initial_height": heights})
    for k, height in enumerate(heights):
        own = gelcone.find_device("biased-pump").replace(film="taut", initial_height=height)
        np.testing.assert_allclose(found.states[k], own.initial_state(), rtol=1e-12, atol=1e-15)


def test_a_threshold_that_is_met_somewhere_is_drawn_there(monkeypatch):
    """At the amplitude that is left of it beyond the offset; one that is nowhere left is not drawn."""
    made = {"onset_voltage": [2.0, 3.0], "pitchfork_voltage": [0.4, 0.6], "pull_in_voltage": [0.1, 0.5]}
    found = SimpleNamespace(variables={name: ("", np.array(values)) for name, values in made.items()})
    monkeypatch.setattr(grids, "limits_cells", lambda members, states, threads: found)
    source = Source(None, None, {"preset": "base", "settings": ["voltage_bias=-0.5"]})
    lines = thresholds(source, {"spring_stiffness": ["0.5", "0.9"]})
    assert list(lines) == ["rest becomes unstable", "flat film loses its stability at the peak"]
    np.testing.assert_allclose(lines["rest becomes unstable"], [2.0, 3.0])
    np.testing.assert_allclose(lines["flat film loses its stability at the peak"], [np.nan, 0.1])
    half = Source(None, None, {"preset": "base", "settings": ["voltage_bias=-0.5", "waveform=half_wave"]})
    lines = thresholds(half, {"spring_stiffness": ["0.5", "0.9"]})
    np.testing.assert_allclose(lines["flat film loses its stability at the peak"], [0.9, 1.1])


def test_nothing_bounds_the_use_of_what_cannot_be_built():
    assert thresholds(PUMP, {"disc_radius": ["6 mm", "40 mm"]}) == {}


def test_a_membrane_is_made_also_where_a_motion_has_no_kind():
    """And the page takes the picture that was made; for the kind of the motion it asks by itself."""
    source = Source(shipped_devices()["soft-film"], None, {"settings": ["film=taut", "waveform=chirp"]})
    with pytest.raises(InputError, match="does not repeat"):
        grids.settled.kind(source.subject())
    assert grids.make_membrane(source, 3)


def test_a_worker_reads_its_subject_before_it_looks_what_is_there(monkeypatch):
    """Rests are searched for while it is read; of a membrane picture and kind are made; profiles are of their film."""
    done = []
    subject = SimpleNamespace(model="model")
    source = SimpleNamespace(subject=lambda: done.append("read") or subject)
    for place, name in ((grids, "stored_rests"), (grids.look, "response"), (grids.settled, "kind")):
        monkeypatch.setattr(place, name, lambda *given, name=name: done.append((name, *given)) or "found")
    monkeypatch.setattr(grids.profiles, "table", lambda *given: given)
    assert grids.find_rests(source, ["keys"]) == "found"
    assert done == ["read", ("stored_rests", ["keys"])]
    done.clear()
    assert grids.make_membrane(source, 3.0)
    assert done == ["read", ("response", subject, 3.0), ("kind", subject)]
    assert grids.find_profiles(source, 1) == (subject, 1)
    for name, answers in (("find_pull_in", grids.equilibria.PULL_INS), ("find_static", grids.equilibria.STATICS)):
        monkeypatch.setattr(answers, "of", lambda model, name=name: (name, model))
        assert getattr(grids, name)(source) == (name, "model")
    monkeypatch.setattr(grids, "curve_of", lambda *key: key)
    assert grids.find_curves(source, [("a", 1), ("b", 2)]) == [("a", 1), ("b", 2)]
