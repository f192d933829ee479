"""The settled motion of the live panels is that of the analyses."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.analyses.answer import in_si
from gelcone.motion.start import start_states
from gelcone.register.analyses import ANALYSES
from gelcone.studio import equilibria, settled
from gelcone.studio.setting import Setting, Shelf
from gelcone.words import evidence_in_words
from tests.recorded import record


@pytest.fixture(scope="module")
def shelf():
    shelf = Shelf()
    return shelf


def test_the_kind_is_that_of_regime(shelf):
    subject = shelf.subject(Setting(device="biased-pump"))
    found, result = settled.kind(subject), gelcone.regime(subject.model, subject.initial)
    assert found.words["regime"] == int(result.regime) == gelcone.Regime.PERIODIC
    assert found.words["lines"][0] == "periodic, period 1"
    assert "per second" in found.words["lines"][1]
    section = in_si(result, subject)["section"].values
    np.testing.assert_allclose(found.arrays["px"], section[:, 0], rtol=1e-12)


def test_every_number_of_a_kind_has_the_unit_of_the_result(shelf):
    """Also those with words for what is missing, such as the lifetime of chaos."""
    subject = shelf.subject(Setting(device="biased-pump", values={"film": "taut"}))
    found = ANALYSES["regime"].compute(subject.model.members(), start_states(subject.model.members(), subject.initial))
    shown, member = in_si(gelcone.regime(subject.model, subject.initial), subject), settled.single(found, subject)
    assert shown["lifetime"].attrs["units"] == "ms"
    for name, value in member.items():
        if name in shown and "units" in shown[name].attrs and shown[name].attrs.get("quantity") != "state":
            assert getattr(value, "attrs", {"units": "1"})["units"] == shown[name].attrs["units"], name


def test_the_spectrum_is_that_of_spectrum(subject):
    found = settled.spectrum(subject)
    shown = in_si(gelcone.spectrum(subject.model, subject.initial, periods=settled.SPECTRUM_PERIODS), subject)
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
    found = settled.spectrum(subject)
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
    monkeypatch.setattr(settled, "spectrum_cells", lambda *given, **options: SimpleNamespace(variables=made))
    assert settled.spectrum(subject).words["top"] == pytest.approx(30.0 * subject.device.frequency)
    amplitude[0, 4:] = 0.0
    amplitude[0, 3] = 1e-3
    assert settled.spectrum(subject).words["top"] == pytest.approx(8.0 * subject.device.frequency)  # the least shown


def test_the_section_is_that_of_section(shelf):
    subject = shelf.subject(Setting(device="biased-pump", values={"voltage_amplitude": "850 V"}))
    found = settled.section(subject)
    shown = in_si(gelcone.section(subject.model, subject.initial, repeats=settled.SECTION_POINTS), subject)
    for name, variable in (("px", "displacement"), ("pu", "velocity")):
        assert found.arrays[name].shape == (settled.SECTION_POINTS,)
        np.testing.assert_allclose(found.arrays[name], shown[variable].values, rtol=1e-12)


def test_the_kind_has_the_section_and_the_extent_of_regime(subject):
    found, shown = settled.kind(subject), in_si(gelcone.regime(subject.model, subject.initial), subject)
    section = shown["section"].values
    np.testing.assert_allclose(found.arrays["px"], section[:, 0], rtol=1e-12)
    np.testing.assert_allclose(found.arrays["pu"], section[:, 1], rtol=1e-12)
    assert found.words["extent"] == pytest.approx([float(shown["lowest"]), float(shown["highest"])], rel=1e-12)
    assert found.words["lines"] == evidence_in_words(shown)


def test_a_motion_that_leaves_the_domain_is_said_to(shelf):
    gone = shelf.subject(Setting(preset="base", values={"film": "wrinkling", "voltage": "1.2"}))
    assert settled.kind(gone).words["regime"] == gelcone.Regime.LEFT_THE_DOMAIN


def test_a_run_that_stopped_has_the_kind_of_regime_and_says_why_it_stopped(shelf, monkeypatch):
    """What ran out of digits next to its stretch limit has not settled, and has not left the domain."""
    analysis = settled.ANALYSES["regime"]

    def compute(members, states, **options):
        found = analysis.compute(members, states, **options)
        found.outcome[:] = gelcone.Outcome.STRETCH_LIMIT
        found.variables["regime"][1][:] = gelcone.Regime.TRANSIENT
        return found

    monkeypatch.setattr(settled, "ANALYSES", {"regime": SimpleNamespace(compute=compute)})
    found = settled.kind(shelf.subject(Setting(device="biased-pump")))
    assert found.words["regime"] == gelcone.Regime.TRANSIENT
    assert found.words["lines"][-1] == gelcone.Outcome.STRETCH_LIMIT.meaning
    assert found.run is None
    assert "ox" not in found.arrays


def test_numbers_of_the_source_and_of_pull_in_are_in_words(shelf, monkeypatch):
    """Pull-in is that of the subject's own film."""
    asked = record(
        monkeypatch, settled.performance, of_source={"current": 1.5}, in_words=lambda numbers, subject: [numbers],
    )  # fmt: skip
    monkeypatch.setattr(equilibria.PULL_INS, "of", lambda model: 2.5)
    subject = shelf.subject(Setting(device="biased-pump", values={"film": "taut"}))
    assert settled.electrical(subject, "run").words == {"numbers": [{"current": 1.5}]}
    assert asked["of_source"][0]["run"] == "run"
    for film in ("cone", "membrane"):
        monkeypatch.setattr(equilibria, "pull_in_film", lambda model, film=film: film)
        assert equilibria.margins(subject).words == {"numbers": [{f"static pull-in of the {film}": 2.5}]}
    assert all(call["subject"] is subject for call in asked["in_words"])


@pytest.mark.parametrize("setting", [Setting(device="biased-pump"), Setting(device="soft-film")])
def test_the_settled_orbit_closes_and_goes_through_its_section_points(shelf, setting):
    found = settled.kind(shelf.subject(setting)).arrays
    x, u = found["ox"], found["ou"]
    size = np.array([np.ptp(x), np.ptp(u)])
    assert np.hypot((x[-1] - x[0]) / size[0], (u[-1] - u[0]) / size[1]) < 1e-6
    for px, pu in zip(found["px"][:4], found["pu"][:4], strict=True):
        assert np.hypot((x - px) / size[0], (u - pu) / size[1]).min() < 1e-6


def test_the_settled_orbit_begins_where_the_drive_is_at_its_phase_0(shelf, monkeypatch):
    """At the second point of the section: of a pure sine, whose force repeats twice as often, the first is half way."""
    subject, analysis = shelf.subject(Setting(device="biased-pump")), settled.ANALYSES["regime"]

    def compute(members, states, **options):
        found = analysis.compute(members, states, **options)
        found.variables["section"][1][0, 0] += 0.1  # as if the motion had another period
        return found

    monkeypatch.setattr(settled, "ANALYSES", {"regime": SimpleNamespace(compute=compute)})
    found = settled.kind(subject).arrays
    assert (found["ox"][0], found["ou"][0]) == (found["px"][1], found["pu"][1])
    assert found["ox"][0] != found["px"][0]


def test_the_settled_orbit_is_what_a_long_run_settles_to(shelf):
    subject = shelf.subject(Setting(device="soft-film"))
    late = gelcone.section(subject.model, subject.initial, discard=3000, repeats=2)
    found = settled.kind(subject).arrays
    here = np.stack([found["ox"], found["ou"]], axis=1)
    for k in range(2):
        there = [float(in_si(late, subject)[name].values[k]) for name in ("displacement", "velocity")]
        assert np.abs((here - there) / np.ptp(here, axis=0)).max(axis=1).min() < 1e-5


def test_section_points_of_chaos_lie_on_the_curve_that_is_shown_with_them(shelf):
    found = settled.kind(shelf.subject(Setting(preset="base", values={"voltage": "1.7"}))).arrays
    assert found["px"].size > 2
    assert set(found["px"].tolist()) <= set(found["ox"].tolist())
    turns = np.flatnonzero(np.diff(np.sign(found["ou"])) > 0)
    assert np.diff(turns).min() >= 40


def test_the_settled_voltage_is_the_drive_s_own_and_not_its_size(shelf):
    subject = shelf.subject(Setting(preset="base"))
    assert subject.model.members().forcing_period[0] < subject.model.members().drive_period[0]
    arrays = settled.kind(subject).arrays
    assert arrays["ov"].min() == pytest.approx(-0.5, rel=1e-3)
    turns = float(arrays["ot"][-1] / subject.model.members().drive_period[0])
    assert turns == pytest.approx(round(turns), abs=1e-6)


def test_a_motion_that_ends_has_no_settled_orbit(shelf):
    gone = shelf.subject(Setting(preset="base", values={"film": "wrinkling", "voltage": "1.2"}))
    assert "ox" not in settled.kind(gone).arrays
