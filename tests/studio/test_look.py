"""The numbers of the live panels are those of the analyses."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import InputError
from gelcone.analyses.answer import in_si
from gelcone.devices.checks import doubts
from gelcone.motion.start import start_states
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.register.analyses import ANALYSES
from gelcone.studio import look
from gelcone.studio.orbit import PER_OSCILLATION, PER_PERIOD
from gelcone.studio.setting import Setting, Shelf
from gelcone.words import evidence_in_words
from tests.recorded import record


@pytest.fixture(scope="module")
def shelf():
    shelf = Shelf()
    return shelf


def test_the_run_is_that_of_simulate(shelf):
    subject = shelf.subject(Setting(device="biased-pump"))
    shown = in_si(gelcone.simulate(subject.model, subject.initial, periods=5), subject)
    found = look.response(subject, 5)
    for name, variable in (("t", "time"), ("x", "displacement"), ("u", "velocity"), ("v", "drive_voltage")):
        np.testing.assert_allclose(found.arrays[name], shown[variable].values, rtol=1e-11, atol=1e-12)
    assert found.words["shares"] == [{"code": look.TAUT, "share": 1.0}]
    assert found.words["period"] == pytest.approx(1e3 / subject.device.frequency)  # ms


def test_shares_of_the_film_are_those_of_simulate(shelf):
    subject = shelf.subject(Setting(preset="base", values={"voltage": "1.04"}))
    result = gelcone.simulate(subject.model, subject.initial, periods=3)
    found = look.response(subject, 3)
    shares = {entry["code"]: entry["share"] for entry in found.words["shares"]}
    slack = sum(shares.get(code, 0.0) for code in (look.HOOP_SLACK, look.CRUMPLED))
    assert slack == pytest.approx(float(result.validity_hoop_slack), abs=2e-3)
    assert 0.5 < slack < 1.0


def test_a_voltage_above_the_pull_in_of_the_membrane_counts_as_in_simulate(shelf):
    subject = shelf.subject(Setting(device="biased-pump", values={"film": "wrinkling", "voltage_offset": "1.7 kV"}))
    result = gelcone.simulate(subject.model, subject.initial, periods=3)
    beyond = float(result["validity_beyond_membrane"])
    assert 0.05 < beyond < 0.95
    shares = {entry["code"]: entry["share"] for entry in look.response(subject, 3).words["shares"]}
    assert shares[look.BEYOND_MEMBRANE] == pytest.approx(beyond, abs=5e-3)


def test_breakdown_is_told(shelf):
    subject = shelf.subject(Setting(device="biased-pump", values={"dielectric_strength": "8 kV/mm"}))
    shares = {entry["code"]: entry["share"] for entry in look.response(subject, 3).words["shares"]}
    assert 0.0 < shares[look.BREAKDOWN] < 1.0


def test_the_kind_is_that_of_regime(shelf):
    subject = shelf.subject(Setting(device="biased-pump"))
    found, result = look.kind(subject), gelcone.regime(subject.model, subject.initial)
    assert found.words["regime"] == int(result.regime) == gelcone.Regime.PERIODIC
    assert found.words["lines"][0] == "periodic, period 1"
    assert "per second" in found.words["lines"][1]
    section = in_si(result, subject)["section"].values
    np.testing.assert_allclose(found.arrays["px"], section[:, 0], rtol=1e-12)


def test_every_number_of_a_kind_has_the_unit_of_the_result(shelf):
    """Also those with words for what is missing, such as the lifetime of chaos."""
    subject = shelf.subject(Setting(device="biased-pump", values={"film": "taut"}))
    found = ANALYSES["regime"].compute(subject.model.members(), start_states(subject.model.members(), subject.initial))
    shown, member = in_si(gelcone.regime(subject.model, subject.initial), subject), look.single(found, subject)
    assert shown["lifetime"].attrs["units"] == "ms"
    for name, value in member.items():
        if name in shown and "units" in shown[name].attrs and shown[name].attrs.get("quantity") != "state":
            assert getattr(value, "attrs", {"units": "1"})["units"] == shown[name].attrs["units"], name


def test_a_first_impression_is_no_verdict(shelf):
    regular = shelf.subject(Setting(device="biased-pump", values={"damping_coefficient": "0.2 N s/m"}))
    assert look.response(regular, 20).words["seems"] == "seems to repeat"
    wild = shelf.subject(Setting(preset="base", values={"voltage": "1.7"}))
    assert look.response(wild, 20).words["seems"] == "does not repeat yet"


def test_statics_are_those_of_static(shelf):
    subject = shelf.subject(Setting(preset="base"))
    found = look.statics(subject)
    assert found.words["marks"]["pitchfork"] == pytest.approx(np.sqrt(0.9))
    assert set(found.arrays["stable"].tolist()) == {0, 1}


def test_statics_lead_to_pull_in_and_are_found_once_for_all_drives(shelf):
    body = {"film": "wrinkling", "rest_height": "1"}
    one, other, stiffer = (
        look.statics(shelf.subject(Setting(preset="base", values=body | own)))
        for own in ({"voltage": "0.3", "drive_frequency": "0.5"}, {"voltage": "0.4"}, {"spring_stiffness": "1"})
    )
    reached, pull_in = np.nanmax(one.arrays["voltage"]), one.words["marks"]["pull_in"]
    assert 0.99 * pull_in < reached <= pull_in
    np.testing.assert_array_equal(one.arrays["voltage"], other.arrays["voltage"])
    assert one.words["swing"] == [-0.3, 0.3]
    assert stiffer.words["marks"]["pull_in"] != pull_in


def test_a_run_that_ends_is_shown_up_to_its_end(shelf):
    subject = shelf.subject(Setting(preset="base", values={"film": "wrinkling", "voltage": "1.2"}))
    found = look.response(subject, 20)
    run = gelcone.integrate(subject.model, subject.initial, 20.0 * float(subject.model.drive_period))
    assert found.words["ended"]
    assert found.arrays["t"][-1] == pytest.approx(float(run.end_times[0]), rel=1e-6)
    assert np.isfinite(found.arrays["x"]).all()


def test_each_film_of_two_has_its_own_state(shelf):
    found = look.response(shelf.subject(Setting(device="double-cone")), 2)
    assert found.arrays["film1"].shape == found.arrays["film2"].shape == found.arrays["film"].shape
    assert "film1" not in look.response(shelf.subject(Setting(device="biased-pump")), 2).arrays


def test_a_run_that_pulls_in_says_when_and_where(shelf):
    subject = shelf.subject(Setting(device="biased-pump", values={"voltage_offset": "1700 V"}))
    found = look.response(subject, 3)
    assert found.words["ended"] == "pulled in"
    assert found.words["seems"].startswith("the film pulls in after ")
    assert f"at the height {found.arrays['x'][-1]:.4g} mm" in found.words["seems"]


# --- every panel against the Dataset of its analysis -----------------------------------------------------------------

SUBJECTS = {
    "device": Setting(device="biased-pump"),
    "preset": Setting(preset="base", values={"voltage": "0.8"}),
    "offset": Setting(preset="base", values={"voltage": "0.3", "voltage_bias": "0.5", "drive_frequency": "1.3"}),
}


@pytest.fixture(params=SUBJECTS)
def subject(request, shelf):
    return shelf.subject(SUBJECTS[request.param])


def test_the_spectrum_is_that_of_spectrum(subject):
    found = look.spectrum(subject)
    shown = in_si(gelcone.spectrum(subject.model, subject.initial, periods=look.SPECTRUM_PERIODS), subject)
    drive = 10.0 if subject.device is not None else float(subject.model.drive_frequency)
    assert found.words["top"] == pytest.approx(8.0 * drive, rel=1e-12)
    np.testing.assert_allclose(found.arrays["frequency"], shown["frequency"].values, rtol=1e-12)
    np.testing.assert_allclose(found.arrays["amplitude"], shown["amplitude"].values, rtol=1e-12)
    lines = np.isfinite(shown["line_ratio"].values)
    assert lines.any() == (found.arrays["amplitude"].max() > 1e-9)  # none of an actuator at rest
    np.testing.assert_allclose(found.arrays["line"], shown["line_frequency"].values[lines], rtol=1e-12)
    np.testing.assert_allclose(found.arrays["height"], shown["line_amplitude"].values[lines], rtol=1e-12)


def test_the_spectrum_of_a_drive_that_does_not_repeat_is_that_of_its_run(shelf):
    values = {"waveform": "chirp", "frequency": "1 Hz", "waveform.start_frequency": "5 Hz"}
    subject = shelf.subject(Setting(device="soft-film", values={"film": "taut"} | values))
    found = look.spectrum(subject)
    shown = in_si(gelcone.spectrum(subject.model, subject.initial), subject)
    np.testing.assert_allclose(found.arrays["frequency"], shown["frequency"].values, rtol=1e-12)
    np.testing.assert_allclose(found.arrays["amplitude"], shown["amplitude"].values, rtol=1e-12)
    seen = shown["frequency"].values[shown["amplitude"].values >= 1e-6 * shown["amplitude"].values[1:].max()]
    assert found.words["top"] == pytest.approx(max(seen.max(), 8.0), rel=1e-12)
    assert found.arrays["line"].size == 0


def test_the_mean_of_a_run_hides_none_of_its_frequencies(shelf, monkeypatch):
    subject = shelf.subject(Setting(device="soft-film", values={"film": "taut", "waveform": "chirp"}))
    amplitude = np.zeros((1, 41))
    amplitude[0, [0, 10, 30]] = 1.0, 1e-3, 1e-8
    made = {"amplitude": ("", amplitude), "line_ratio": ("", np.full((1, 1), np.nan))}
    made |= {"line_amplitude": made["line_ratio"]}
    monkeypatch.setattr(look, "spectrum_cells", lambda *given, **options: SimpleNamespace(variables=made))
    assert look.spectrum(subject).words["top"] == pytest.approx(30.0 * subject.device.frequency)
    amplitude[0, 4:] = 0.0
    amplitude[0, 3] = 1e-3
    assert look.spectrum(subject).words["top"] == pytest.approx(8.0 * subject.device.frequency)  # the least shown


def test_the_section_is_that_of_section(shelf):
    subject = shelf.subject(Setting(device="biased-pump", values={"voltage_amplitude": "850 V"}))
    found = look.section(subject)
    shown = in_si(gelcone.section(subject.model, subject.initial, repeats=look.SECTION_POINTS), subject)
    for name, variable in (("px", "displacement"), ("pu", "velocity")):
        assert found.arrays[name].shape == (look.SECTION_POINTS,)
        np.testing.assert_allclose(found.arrays[name], shown[variable].values, rtol=1e-12)


def test_the_kind_has_the_section_and_the_extent_of_regime(subject):
    found, shown = look.kind(subject), in_si(gelcone.regime(subject.model, subject.initial), subject)
    section = shown["section"].values
    np.testing.assert_allclose(found.arrays["px"], section[:, 0], rtol=1e-12)
    np.testing.assert_allclose(found.arrays["pu"], section[:, 1], rtol=1e-12)
    assert found.words["extent"] == pytest.approx([float(shown["lowest"]), float(shown["highest"])], rel=1e-12)
    assert found.words["lines"] == evidence_in_words(shown)


def test_a_motion_that_leaves_the_domain_is_said_to(shelf):
    gone = shelf.subject(Setting(preset="base", values={"film": "wrinkling", "voltage": "1.2"}))
    assert look.kind(gone).words["regime"] == gelcone.Regime.LEFT_THE_DOMAIN


def test_a_run_that_stopped_has_the_kind_of_regime_and_says_why_it_stopped(shelf, monkeypatch):
    """What ran out of digits next to its stretch limit has not settled, and has not left the domain."""
    analysis = look.ANALYSES["regime"]

    def compute(members, states, **options):
        found = analysis.compute(members, states, **options)
        found.outcome[:] = gelcone.Outcome.STRETCH_LIMIT
        found.variables["regime"][1][:] = gelcone.Regime.TRANSIENT
        return found

    monkeypatch.setattr(look, "ANALYSES", {"regime": SimpleNamespace(compute=compute)})
    found = look.kind(shelf.subject(Setting(device="biased-pump")))
    assert found.words["regime"] == gelcone.Regime.TRANSIENT
    assert found.words["lines"][-1] == gelcone.Outcome.STRETCH_LIMIT.meaning
    assert found.run is None
    assert "ox" not in found.arrays


def test_numbers_of_the_source_and_of_pull_in_are_in_words(shelf, monkeypatch):
    """Pull-in is that of the subject's own film."""
    asked = record(
        monkeypatch, look.performance, of_source={"current": 1.5}, in_words=lambda numbers, subject: [numbers],
    )  # fmt: skip
    monkeypatch.setattr(look.PULL_INS, "of", lambda model: 2.5)
    subject = shelf.subject(Setting(device="biased-pump", values={"film": "taut"}))
    assert look.electrical(subject, "run").words == {"numbers": [{"current": 1.5}]}
    assert asked["of_source"][0]["run"] == "run"
    for film in ("cone", "membrane"):
        monkeypatch.setattr(look, "pull_in_film", lambda model, film=film: film)
        assert look.margins(subject).words == {"numbers": [{f"static pull-in of the {film}": 2.5}]}
    assert all(call["subject"] is subject for call in asked["in_words"])


def test_statics_have_the_branches_marks_and_swing_of_static(subject):
    found = look.statics(subject)
    highest = 2.0 ** np.ceil(np.log2(float(subject.model.peak_voltage)))
    shown = in_si(gelcone.static(subject.model, np.linspace(0.0, highest, 2)), subject)
    np.testing.assert_allclose(found.arrays["voltage"], shown["branch_voltage"].values, rtol=1e-12)
    np.testing.assert_allclose(found.arrays["x"], shown["branch_displacement"].values, rtol=1e-12)
    slope = gelcone.static(subject.model, np.linspace(0.0, highest, 2))["branch_slope"].values
    np.testing.assert_array_equal(found.arrays["stable"], slope > 0.0)
    marks = {name: float(shown[f"{name}_voltage"]) for name in ("pitchfork", "pull_in")}
    assert found.words["marks"] == pytest.approx({n: v for n, v in marks.items() if np.isfinite(v)}, rel=1e-12)
    run = in_si(gelcone.simulate(subject.model, subject.initial, periods=3), subject)["drive_voltage"].values
    assert found.words["swing"] == pytest.approx([run.min(), run.max()], rel=2e-3)


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_equilibria_are_found_again_for_every_parameter_that_they_depend_on(shelf, monkeypatch, film):
    values = {"film": film, "bias": "spring+beam+weight+force"}
    model = shelf.subject(Setting(preset="base", values=values | {"voltage": "0.4"})).model
    counted = []
    monkeypatch.setattr(look, "static", lambda model, voltages: counted.append((model.parameters(), voltages[-1])))
    monkeypatch.setattr(look.STATICS, "stored", {})
    look.STATICS.of(model)
    numbers = [name for name, value in model.values.items() if np.ndim(value) == 0 and np.isfinite(value)]
    assert len(numbers) > 10
    for name in numbers:
        before = len(counted)
        look.STATICS.of(model.replace(**{name: 1.01 * float(model.values[name]) + 1e-3}))
        assert len(counted) == before + (name not in look.DRIVEN), name
    for changed in ({"law": "neo-hookean"}, {"film": "wrinkling" if film == "taut" else "taut"}, {"bias": "spring"}):
        before = len(counted)
        look.STATICS.of(model.replace(**changed) if "bias" not in changed else gelcone.ConeModel(film=film))
        assert len(counted) == before + 1
    before = len(counted)
    look.STATICS.of(model.replace(voltage=3.0))  # beyond what was looked at
    assert counted[before:]
    assert counted[-1][1] >= 3.0
    look.STATICS.of(model.replace(voltage_bias=4.0))  # the peak is that of amplitude and offset
    assert counted[-1][1] >= 4.4


def test_equilibria_do_not_depend_on_what_is_left_out_of_their_key(shelf):
    model = shelf.subject(Setting(preset="base")).model
    levels = np.linspace(0.0, 0.5, 3)
    expected = gelcone.static(model, levels)
    for name in look.DRIVEN:
        changed = {"waveform": "triangle", "circuit": "ideal"}.get(name)
        other = model.replace(**{name: 1.1 * float(model.values[name]) + 0.1 if changed is None else changed})
        assert gelcone.static(other, levels).branch_displacement.equals(expected.branch_displacement), name


# --- what the numbers mean -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("hoop", [False, True])
@pytest.mark.parametrize("meridional", [False, True])
@pytest.mark.parametrize("limit", [False, True])
@pytest.mark.parametrize("beyond", [False, True])
@pytest.mark.parametrize("breakdown", [False, True])
def test_of_several_things_that_happen_to_a_film_the_gravest_is_shown(hoop, meridional, limit, beyond, breakdown):
    fails = {"hoop_slack": hoop, "meridional_slack": meridional, "near_limit": limit, "breakdown": breakdown}
    fails |= {"beyond_membrane": beyond}
    slack = [look.TAUT, look.HOOP_SLACK, look.MERIDIONAL_SLACK, look.CRUMPLED][hoop + 2 * meridional]
    expected = look.BREAKDOWN if breakdown else look.BEYOND_MEMBRANE if beyond else look.NEAR_LIMIT if limit else slack
    marks = {name: np.array([[False, flag]]) for name, flag in fails.items()}
    assert look._coded(marks, 2).tolist() == [look.TAUT, expected]
    assert look._coded({}, 2).tolist() == [look.TAUT, look.TAUT]


def test_the_states_of_a_film_have_the_names_that_stand_at_their_place():
    assert [look.FILM_STATES[k] for k in (look.TAUT, look.HOOP_SLACK, look.MERIDIONAL_SLACK, look.CRUMPLED)] == [
        "taut", "hoop slack", "meridian slack", "slack in both directions"
    ]  # fmt: skip
    assert (look.FILM_STATES[look.BREAKDOWN], look.FILM_STATES[look.NEAR_LIMIT]) == (
        "above breakdown",
        "near its stretch limit",
    )
    assert look.FILM_STATES[look.BEYOND_MEMBRANE] == "above membrane pull-in"
    assert look.WRINKLED[: look.CRUMPLED] == look.FILM_STATES[: look.CRUMPLED]
    assert look.WRINKLED[look.CRUMPLED] == "crumpled"
    assert look.WRINKLED[look.BREAKDOWN :] == look.FILM_STATES[look.BREAKDOWN :]


def test_of_two_films_the_state_of_both_is_what_happens_in_either(shelf):
    arrays = look.response(shelf.subject(Setting(device="double-cone", values={"voltage_amplitude": "3 kV"})), 3).arrays
    one, other, both = arrays["film1"], arrays["film2"], arrays["film"]
    assert ((both != look.TAUT) == ((one != look.TAUT) | (other != look.TAUT))).all()
    assert (both[one == other] == one[one == other]).all()


def test_a_curve_shows_the_state_of_both_films_and_of_each(shelf, monkeypatch):
    subject = shelf.subject(Setting(device="double-cone", values={"film": "taut", "second_film": "taut"}))
    members = subject.model.members()
    run = look.integrate(members, look.start_states(members, subject.initial), np.linspace(0.0, 1.0, 4))
    codes = [np.array(own) for own in ([1, 0, 0, 0], [0, 0, 2, 2], [1, 0, 2, 2])]
    monkeypatch.setattr(look, "film_states", lambda *given: codes)
    arrays, shares = look.curve(members, run, subject, "o")
    for name, own in zip(("ofilm1", "ofilm2", "ofilm"), codes, strict=True):
        assert arrays[name].tolist() == own.tolist()
    assert shares == [{"code": 0, "share": 0.25}, {"code": 1, "share": 0.25}, {"code": 2, "share": 0.5}]


def test_a_state_of_one_film_alone_is_one_of_both(monkeypatch):
    one = {"hoop_slack": np.array([[True, True, False, False]])}
    other = {"hoop_slack": np.array([[True, False, True, False]]), "breakdown": np.array([[False, False, True, False]])}
    monkeypatch.setattr(look, "broken_by_film", lambda *given: (one, other))
    found = [codes.tolist() for codes in look.film_states(None, np.zeros((1, 4, 2)), [])]
    slack, broken = look.HOOP_SLACK, look.BREAKDOWN
    assert found == [[slack, slack, 0, 0], [slack, 0, broken, 0], [slack, slack, broken, 0]]


def test_the_place_of_a_kind_of_motion_in_the_legend_is_its_number():
    legend = look.legend()["regimes"]
    for regime in gelcone.Regime:
        assert legend[regime] == {"name": regime.label, "colour": REGIME_COLOURS[regime]}
    assert len(legend) == len(gelcone.Regime)
    assert look.legend()["pulled_in"] == {"name": "pulled in", "colour": look.PULLED_IN_COLOUR}


def test_axes_are_in_the_units_of_the_numbers(shelf):
    device = look.axes(shelf.subject(SUBJECTS["device"]))
    assert device == {
        "time": "time (ms)",
        "displacement": "height (mm)",
        "velocity": "velocity (mm/s)",
        "voltage": "voltage (V)",
        "constant": "constant voltage (V)",
        "frequency": "frequency (Hz)",
        "amplitude": "amplitude (mm)",
    } | {"velocity": f"velocity ({look.units(shelf.subject(SUBJECTS['device']))['velocity']})"}
    preset = look.axes(shelf.subject(SUBJECTS["preset"]))
    assert preset["displacement"] == "displacement"
    assert not any("(" in name for name in preset.values())


def test_what_is_said_of_a_device(shelf):
    subject = shelf.subject(Setting(device="double-cone"))
    shown, device = look.about(subject), subject.device
    assert (shown["disc"], shown["rim"]) == pytest.approx((1e3 * device.disc_radius, 1e3 * device.film_radius))
    assert shown["second"] == pytest.approx(1e3 * device.second_flat_height)
    assert (shown["si"], shown["name"], shown["wrinkles"]) == (
        True,
        device.name,
        device.film in ("wrinkling", "membrane"),
    )
    assert shown["film"] == list(look.WRINKLED if shown["wrinkles"] else look.FILM_STATES)
    assert shown["strength"] == (device.breakdown_field() is not None)
    assert shown["doubts"] == doubts(device) == []
    thick = shelf.subject(Setting(device="soft-film", values={"film_thickness": "90 mm"}))
    assert look.about(thick)["doubts"] == doubts(thick.device)
    assert any("film_thickness = 90 mm" in doubt for doubt in look.about(thick)["doubts"])
    preset = look.about(shelf.subject(Setting(preset="base", values={"bias": "spring+weight"})))
    assert preset["rim"] - preset["disc"] == pytest.approx(1.0)  # lengths are in b - a
    assert (preset["si"], preset["second"], preset["bias"]) == (False, None, "spring+weight")
    assert (preset["film"], preset["strength"]) == (list(look.FILM_STATES), False)


@pytest.mark.parametrize("repeats", [1, 2, 3, 5])
def test_a_motion_that_repeats_every_few_periods_seems_to(shelf, repeats):
    members = shelf.subject(Setting(device="biased-pump")).model.members()
    times = np.linspace(0.0, 40.0 * float(members.forcing_period[0]), 8001)
    phase = 2.0 * np.pi * times / (repeats * float(members.forcing_period[0])) + 0.3
    words = look._seems(members, times, np.stack([np.sin(phase), np.cos(phase)], axis=1))
    assert words == ("seems to repeat" if repeats == 1 else f"seems to repeat every {repeats} periods")


def test_a_motion_seen_at_its_turning_points_is_judged_by_its_heights(shelf):
    """Every second period it turns above, in between below; its velocity is 0 each time."""
    members = shelf.subject(Setting(device="biased-pump")).model.members()
    times = np.linspace(0.0, 40.0 * float(members.forcing_period[0]), 8001)
    phase = np.pi * times / float(members.forcing_period[0])
    states = np.stack([np.cos(phase), -np.sin(phase)], axis=1)
    assert look._seems(members, times, states) == "seems to repeat every 2 periods"


@pytest.mark.parametrize("size", [1e-4, 1.0, 100.0])
def test_whether_a_motion_seems_to_repeat_does_not_depend_on_its_size(shelf, size):
    members = shelf.subject(Setting(device="biased-pump")).model.members()
    times = np.linspace(0.0, 40.0 * float(members.forcing_period[0]), 8001)
    phase = 2.0 * np.pi * times / float(members.forcing_period[0])
    for turns, words in ((1.0003, "seems to repeat"), (2.0**0.5, "does not repeat yet")):
        states = size * np.stack([np.sin(turns * phase), np.cos(turns * phase)], axis=1)
        assert look._seems(members, times, states) == words


def test_a_run_has_the_samples_that_its_oscillations_need(shelf):
    slow = shelf.subject(Setting(device="biased-pump"))
    fast = shelf.subject(Setting(preset="base", values={"drive_frequency": "0.01"}))
    assert look.response(slow, 5).arrays["t"].size == 5 * PER_PERIOD + 1
    run = look.response(fast, 1)
    swings = float(fast.model.members().rate[0]) * run.arrays["t"][-1] / (2.0 * np.pi)
    assert run.arrays["t"].size - 1 >= PER_OSCILLATION * swings > PER_PERIOD
    assert run.arrays["t"][-1] == pytest.approx(run.words["period"], rel=1e-12)
    assert (run.words["shown"], run.words["cut"]) == (1.0, False)


def test_the_time_that_counts_is_that_of_all_periods(shelf, monkeypatch):
    subject = shelf.subject(Setting(preset="base"))
    monkeypatch.setattr(look, "LONGEST_TIME", 2.5 * float(subject.model.drive_period))
    assert look.response(subject, 2).words["shown"] == 2.0
    message = "drive_frequency = 0.1: 3 periods last too long; raise it to "
    with pytest.raises(InputError, match=f"^{message}") as refused:
        look.response(subject, 3)
    lowest = str(refused.value).removeprefix(message).removesuffix(" or more")
    assert float(lowest) == pytest.approx(0.1 * 3.0 / 2.5, rel=0.02)
    raised = shelf.subject(Setting(preset="base", values={"drive_frequency": lowest}))
    assert look.response(raised, 3).words["shown"] == pytest.approx(3.0, rel=1e-12)


@pytest.mark.parametrize("frequency", ["1.09128e-310", "1e-300", "1e-13"])
def test_a_drive_too_slow_for_any_run_is_refused_by_its_name(shelf, frequency):
    subject = shelf.subject(Setting(preset="base", values={"drive_frequency": frequency}))
    with pytest.raises(InputError, match=r"^drive_frequency = .*: 20 periods last too long; raise it to "):
        look.response(subject, 20)
    device = shelf.subject(Setting(device="biased-pump", values={"film": "taut", "frequency": f"{frequency} Hz"}))
    with pytest.raises(InputError, match=r"^frequency = .* Hz: 20 .* raise it to .* Hz or more$") as refused:
        look.response(device, 20)
    assert float(str(refused.value).split()[2]) == pytest.approx(float(frequency), rel=0.01)
    lowest = " ".join(str(refused.value).split()[-4:-2])
    raised = shelf.subject(Setting(device="biased-pump", values={"film": "taut", "frequency": lowest}))
    assert 20.0 * float(raised.model.drive_period) == pytest.approx(look.LONGEST_TIME, rel=0.02)


def test_a_run_that_needs_too_many_samples_is_cut_and_says_where(shelf, monkeypatch):
    monkeypatch.setattr(look, "MOST_SAMPLES", 3000)
    subject = shelf.subject(Setting(preset="base", values={"voltage": "1.7"}))
    run = look.response(subject, 20)
    assert run.arrays["t"].size == 3001
    assert run.words["cut"]
    assert run.arrays["t"][-1] == pytest.approx(run.words["shown"] * run.words["period"], rel=1e-12)
    assert 1.0 < run.words["shown"] < 20.0


def test_every_oscillation_of_two_hundred_periods_of_chaos_has_forty_samples(shelf):
    run = look.response(shelf.subject(Setting(preset="base", values={"voltage": "1.7"})), 200).arrays
    turns = np.flatnonzero(np.diff(np.sign(run["u"])) > 0)
    assert len(turns) > 2000
    assert np.diff(turns).min() >= 40


@pytest.mark.parametrize("setting", [Setting(device="biased-pump"), Setting(device="soft-film")])
def test_the_settled_orbit_closes_and_goes_through_its_section_points(shelf, setting):
    found = look.kind(shelf.subject(setting)).arrays
    x, u = found["ox"], found["ou"]
    size = np.array([np.ptp(x), np.ptp(u)])
    assert np.hypot((x[-1] - x[0]) / size[0], (u[-1] - u[0]) / size[1]) < 1e-6
    for px, pu in zip(found["px"][:4], found["pu"][:4], strict=True):
        assert np.hypot((x - px) / size[0], (u - pu) / size[1]).min() < 1e-6


def test_the_settled_orbit_begins_where_the_drive_is_at_its_phase_0(shelf, monkeypatch):
    """At the second point of the section: of a pure sine, whose force repeats twice as often, the first is half way."""
    subject, analysis = shelf.subject(Setting(device="biased-pump")), look.ANALYSES["regime"]

    def compute(members, states, **options):
        found = analysis.compute(members, states, **options)
        found.variables["section"][1][0, 0] += 0.1  # as if the motion had another period
        return found

    monkeypatch.setattr(look, "ANALYSES", {"regime": SimpleNamespace(compute=compute)})
    found = look.kind(subject).arrays
    assert (found["ox"][0], found["ou"][0]) == (found["px"][1], found["pu"][1])
    assert found["ox"][0] != found["px"][0]


def test_the_settled_orbit_is_what_a_long_run_settles_to(shelf):
    subject = shelf.subject(Setting(device="soft-film"))
    late = gelcone.section(subject.model, subject.initial, discard=3000, repeats=2)
    found = look.kind(subject).arrays
    here = np.stack([found["ox"], found["ou"]], axis=1)
    for k in range(2):
        there = [float(in_si(late, subject)[name].values[k]) for name in ("displacement", "velocity")]
        assert np.abs((here - there) / np.ptp(here, axis=0)).max(axis=1).min() < 1e-5


def test_section_points_of_chaos_lie_on_the_curve_that_is_shown_with_them(shelf):
    found = look.kind(shelf.subject(Setting(preset="base", values={"voltage": "1.7"}))).arrays
    assert found["px"].size > 2
    assert set(found["px"].tolist()) <= set(found["ox"].tolist())
    turns = np.flatnonzero(np.diff(np.sign(found["ou"])) > 0)
    assert np.diff(turns).min() >= 40


def test_the_settled_voltage_is_the_drive_s_own_and_not_its_size(shelf):
    subject = shelf.subject(Setting(preset="base"))
    assert subject.model.members().forcing_period[0] < subject.model.members().drive_period[0]
    arrays = look.kind(subject).arrays
    assert arrays["ov"].min() == pytest.approx(-0.5, rel=1e-3)
    turns = float(arrays["ot"][-1] / subject.model.members().drive_period[0])
    assert turns == pytest.approx(round(turns), abs=1e-6)


def test_a_motion_that_ends_has_no_settled_orbit(shelf):
    gone = shelf.subject(Setting(preset="base", values={"film": "wrinkling", "voltage": "1.2"}))
    assert "ox" not in look.kind(gone).arrays


def test_shares_of_the_film_add_up_and_name_what_occurs():
    film = np.array([look.TAUT] * 6 + [look.BREAKDOWN] * 3 + [look.CRUMPLED], dtype=np.uint8)
    shares = [(look.TAUT, 0.6), (look.CRUMPLED, 0.1), (look.BREAKDOWN, 0.3)]
    assert [(entry["code"], entry["share"]) for entry in look._shares(film)] == shares
    assert look._shares(film[:0]) == []


def test_samples_behind_the_end_of_a_run_count_for_no_state_of_the_film(shelf):
    subject = shelf.subject(Setting(preset="base", values={"voltage": "1.04"}))
    members = subject.model.members()
    run = look.integrate(members, look.start_states(members, subject.initial), np.linspace(0.0, 200.0, 1001))
    part = look.integrate(members, look.start_states(members, subject.initial), run.times[0, :501])
    run.states[0, 501:] = np.nan
    found, expected = (look.curve(members, own, subject)[1] for own in (run, part))
    assert len(expected) > 1
    assert found == expected


def test_what_acts_on_the_disc_is_drawn_only_where_it_does(shelf):
    assert look.about(shelf.subject(Setting(device="snap-cone")))["bias"] == "beam"  # its spring has no stiffness
    stiff = Setting(device="snap-cone", values={"spring_rate": "1 N/m"})
    assert look.about(shelf.subject(stiff))["bias"] == "spring+beam"
    assert look.about(shelf.subject(Setting(preset="base", values={"spring_stiffness": "0"})))["bias"] == "none"


def test_a_run_may_last_from_one_to_five_hundred_periods():
    assert [look.check_periods(own) for own in (1, 2.5, 500)] == [1.0, 2.5, 500.0]
    for wrong in (0.999, 500.001, True, "20", None):
        with pytest.raises(InputError, match="periods: must be a number from 1 to 500"):
            look.check_periods(wrong)


def test_a_small_picture_is_the_end_of_a_run_from_its_own_time_zero(shelf):
    subject = shelf.subject(Setting(preset="base", values={"voltage": "0.8"}))
    whole, found = look.response(subject, look.PERIODS), look.glance(subject)
    t, x = (found.arrays[name] for name in ("t", "x"))
    assert (t[0], t.size) == (0.0, look.GLANCE_SAMPLES + 1)
    assert t[-1] == pytest.approx(look.GLANCE_PERIODS * found.words["period"], rel=1e-3)
    assert x[-1] == whole.arrays["x"][-1]
    begin = whole.arrays["t"][-1] - t[-1]
    np.testing.assert_allclose(x, np.interp(begin + t, whole.arrays["t"], whole.arrays["x"]), atol=1e-12)


@pytest.mark.parametrize("strength", [None, "40 kV/mm"])
def test_the_field_of_each_film_is_over_its_strength_or_over_the_largest(shelf, strength):
    values = {"film": "taut", "second_film": "taut"} | ({} if strength is None else {"dielectric_strength": strength})
    subject = shelf.subject(Setting(device="double-cone", values=values))
    found, device = look.response(subject, 2).arrays, subject.device
    shown = gelcone.simulate(device, times=1e-3 * found["t"])
    known = device.dielectric_strength or device.material.dielectric_strength
    assert (known is None) == ("dielectric_strength" not in subject.model.values)
    for k, prefix in ((1, ""), (2, "second_")):
        field = 1e6 * shown[f"{prefix}true_field"].values
        np.testing.assert_allclose(found[f"field{k}"], field / (known or field.max()), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(found[f"thin{k}"], shown[f"{prefix}thickness_stretch"].values, rtol=1e-9)


def test_answers_are_stored_for_so_many_models_and_no_more():
    found = []
    answers = look.Answers(str, lambda model: found.append(model) or f"of {model}")
    for model in range(look.MOST_STATICS):
        assert answers.of(model) == f"of {model}"
    assert answers.of(0) == "of 0"
    assert len(found) == len(answers.stored) == look.MOST_STATICS
    answers.keep("more", "kept")
    assert (answers.has("more"), answers.has(0), len(answers.stored)) == (True, False, 1)
    assert answers.of("more") == "kept"
