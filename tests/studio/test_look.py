"""The numbers of the live panels are those of the analyses."""

import numpy as np
import pytest

import gelcone
from gelcone import InputError
from gelcone.analyses.answer import in_si
from gelcone.devices.checks import doubts
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.studio import look
from gelcone.studio.orbit import PER_OSCILLATION, PER_PERIOD
from gelcone.studio.setting import Setting, Shelf
from tests.studio.conftest import SUBJECTS


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


def test_a_first_impression_is_no_verdict(shelf):
    regular = shelf.subject(Setting(device="biased-pump", values={"damping_coefficient": "0.2 N s/m"}))
    assert look.response(regular, 20).words["seems"] == "seems to repeat"
    wild = shelf.subject(Setting(preset="base", values={"voltage": "1.7"}))
    assert look.response(wild, 20).words["seems"] == "does not repeat yet"


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
