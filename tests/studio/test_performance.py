"""The numbers of the first line are those of the analyses."""

from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.analyses.answer import in_si
from gelcone.codes import Regime
from gelcone.studio import equilibria, performance, settled
from gelcone.studio.performance import QUANTITIES
from gelcone.studio.setting import Setting, Shelf

WRINKLING = {"film": "wrinkling", "second_film": "wrinkling"}
SETTINGS = {
    "pump": Setting(device="biased-pump"),
    "weight": Setting(device="weight-cone", values={"film": "wrinkling"}),
    "soft": Setting(device="soft-film"),
    "double": Setting(file=gelcone.find_device("double-cone").replace(**WRINKLING).to_toml()),
    "preset": Setting(preset="base", values={"voltage": "1.2"}),
    "offset": Setting(preset="base", values={"voltage": "0.3", "voltage_bias": "0.5", "drive_frequency": "1.3"}),
    "two": Setting(preset="base", values={"voltage": "0.9", "rest_height": "1", "damping_ratio": "0.05"}),
}


@pytest.fixture(scope="module")
def shelf():
    return Shelf()


@pytest.fixture(params=SETTINGS, scope="module")
def case(request, shelf):
    subject = shelf.subject(SETTINGS[request.param])
    return subject, settled.kind(subject)


def numbers(parts):
    return {own["name"]: own for own in parts.words["numbers"]}


def test_stroke_and_lag_are_those_of_settled(case):
    subject, found = case
    settled, own = in_si(gelcone.settled(subject.model, subject.initial), subject), numbers(found)
    assert own["stroke"]["value"] == pytest.approx(float(settled.stroke), rel=2e-4, abs=1e-9)
    if "lag" not in own:
        assert found.words["regime"] == gelcone.Regime.REST
        return
    largest = int(np.argmax(settled.harmonic_amplitude.values))
    assert ("twice" in own["lag"]["text"]) == (largest == 1)
    phase = float(settled.harmonic_phase[largest])
    assert (own["lag"]["value"] + phase + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.02)


def test_mean_height_current_and_power_are_those_of_simulate_along_the_settled_motion(case):
    subject, found = case
    times = np.linspace(0.0, float(found.run.times[0, -1]), 4001)
    run = in_si(gelcone.simulate(subject.model, found.run.states[0, 0], times=times), subject)
    electrical = settled.electrical(subject, found.run)
    own = numbers(found) | numbers(electrical)

    def mean(name):
        return float(np.trapezoid(run[name].values, times) / times[-1])

    size = float(np.ptp(run["displacement"].values))
    assert own["mean height"]["value"] == pytest.approx(mean("displacement"), rel=1e-3, abs=1e-4 * size + 1e-12)
    currents = [run[name].values for name in ("current", "second_current") if name in run]
    assert own["current"]["value"] == pytest.approx(max(np.abs(i).max() for i in currents), rel=5e-3)
    assert own["power"]["value"] == pytest.approx(mean("dissipated_power"), rel=1e-3, abs=1e-9)


def test_the_field_is_the_share_of_the_dielectric_strength(shelf):
    subject = shelf.subject(SETTINGS["pump"])
    found = settled.kind(subject)
    times = np.linspace(0.0, float(found.run.times[0, -1]), 2001)
    run = in_si(gelcone.simulate(subject.model, found.run.states[0, 0], times=times), subject)
    share = float(run["true_field"].max()) / (1e-6 * subject.device.dielectric_strength)
    own = numbers(found)["field"]
    assert own["value"] == pytest.approx(share, rel=1e-3)
    assert own["text"] == f"{100 * share:.2g} % of breakdown"
    unknown = settled.kind(shelf.subject(SETTINGS["preset"]))
    assert "field" not in numbers(unknown)


def test_the_pull_in_is_that_of_the_static_analysis_and_is_kept_for_other_drives(shelf, monkeypatch):
    monkeypatch.setattr(equilibria.PULL_INS, "stored", {})
    cone = {"film": "wrinkling"}
    subject = shelf.subject(Setting(device="biased-pump", values=cone))
    peak = subject.device.voltage_amplitude + subject.device.voltage_offset
    expected = in_si(gelcone.limits(subject.model), subject)
    own = numbers(equilibria.margins(subject))["static pull-in of the cone"]
    assert own["value"] == pytest.approx(float(expected.pull_in_voltage), rel=1e-12)
    assert own["text"] == f"2.81 kV (peak at {100 * peak / own['value']:.2g} %)"
    other = shelf.subject(
        Setting(device="biased-pump", values=cone | {"voltage_amplitude": "400 V", "frequency": "7 Hz"})
    )
    assert equilibria.PULL_INS.has(other.model)
    stiffer = shelf.subject(Setting(device="biased-pump", values=cone | {"spring_rate": "16 N/m"}))
    assert not equilibria.PULL_INS.has(stiffer.model)
    never = shelf.subject(Setting(preset="base"))
    assert numbers(equilibria.margins(never)) == {}


def test_the_pull_in_of_films_in_opposite_phase_is_said_to_be_at_their_bias(shelf):
    films = {"film": "taut", "second_film": "taut", "spring_rate": "1 N/m"}
    subject = shelf.subject(Setting(device="double-cone", values=films))
    (own,) = performance.in_words({"static pull-in of the cone": 1.0}, subject)
    assert " kV at this bias (peak at " in own["text"]
    same = shelf.subject(Setting(device="double-cone", values=films | {"second_drive": "same"}))
    assert "bias" not in performance.in_words({"static pull-in of the cone": 1.0}, same)[0]["text"]


def test_numbers_stand_in_their_order_with_three_digits_and_their_units(shelf):
    subject = shelf.subject(SETTINGS["pump"])
    found = settled.kind(subject)
    entries = found.words["numbers"] + settled.electrical(subject, found.run).words["numbers"]
    assert all(list(QUANTITIES)[own["place"]] == own["name"] for own in entries)
    texts = {own["name"]: own["text"] for own in entries}
    assert texts["stroke"].endswith(" mm")
    assert texts["current"].endswith(" uA")
    assert texts["lag"].endswith("°")
    assert texts["power"].endswith((" mW", " uW"))
    flat = numbers(settled.kind(shelf.subject(SETTINGS["soft"])))["mean height"]
    assert (flat["text"], flat["value"]) == ("0 mm", 0.0)  # and not the 1e-17 of rounding
    low = shelf.subject(Setting(device="soft-film", values={"voltage_amplitude": "50 V"}))
    rest = settled.kind(low)
    at_rest = numbers(rest) | numbers(settled.electrical(low, rest.run))
    for name, text in (("stroke", "0 mm"), ("mean height", "0 mm"), ("power", "0 mW")):
        assert (at_rest[name]["text"], at_rest[name]["value"]) == (text, 0.0)
    assert "lag" not in at_rest


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (0.1234, "12 %"),
        (0.994, "99 %"),
        (0.9951, "99.5 %"),
        (1.234, "123 %"),
        (0.00123, "0.12 %"),
        (12.34, "1.23e+03 %"),
    ],
)
def test_a_share_has_two_digits_below_all_of_it(share, text):
    assert performance._percent(share) == text


def test_numbers_that_are_known_are_said_in_order_with_their_units(shelf):
    """Of a device in SI, of a preset without units; the lag of a multiple of the frequency says so."""
    device, preset = shelf.subject(SETTINGS["weight"]), shelf.subject(SETTINGS["preset"])
    s, peak = device.device.scales, float(device.model.peak_voltage)
    given = {"stroke": 0.25, "lag": 123.456, "harmonic": 2, "field": 0.5, "current": np.nan, "power": 0.0,
             "static pull-in of the cone": 2.0 * peak}  # fmt: skip
    found = {own["name"]: own for own in performance.in_words(given, device)}
    assert list(found) == ["stroke", "lag", "power", "field", "static pull-in of the cone"]
    assert [own["place"] for own in found.values()] == [0, 2, 4, 5, 6]
    assert found["stroke"]["value"] == pytest.approx(250.0 * s.length)
    assert found["stroke"]["text"] == f"{250.0 * s.length:.3g} mm"
    assert found["lag"] == {"name": "lag", "place": 2, "text": "123° at twice the drive's frequency", "value": 123.456}
    assert (found["power"]["text"], found["power"]["value"]) == ("0 mW", 0.0)
    assert (found["field"]["text"], found["field"]["value"]) == ("50 % of breakdown", 0.5)
    slow = found["static pull-in of the cone"]
    assert slow["value"] == pytest.approx(2.0 * peak * s.voltage)
    assert slow["text"].endswith(" (peak at 50 %)")
    assert slow["peak"] == 0.5
    plain = {own["name"]: own for own in performance.in_words(given | {"harmonic": 1}, preset)}
    assert (plain["stroke"]["text"], plain["stroke"]["value"], plain["lag"]["text"]) == ("0.25", 0.25, "123°")
    assert len(performance.MULTIPLES) >= max(performance.HARMONICS)


def test_a_motion_that_ends_has_no_numbers(shelf):
    gone = shelf.subject(Setting(preset="base", values={"film": "wrinkling", "voltage": "1.2"}))
    found = settled.kind(gone)
    assert found.words["numbers"] == []
    assert found.run is None


@pytest.mark.parametrize(
    ("half", "turns", "k"), [(True, 1, 2), (True, 2, 1), (True, 2, 2), (True, 3, 2), (False, 1, 1), (False, 2, 2)]
)
def test_the_lag_is_that_of_the_largest_harmonic_whatever_the_mean_height(half, turns, k, monkeypatch):
    """Of x = 5 + sin(k omega t - 0.4) sampled over forcing periods, which without an offset are half of the drive's;
    there a motion of the drive's own frequency takes two."""
    omega, samples = 0.7, 64
    period = (np.pi if half else 2.0 * np.pi) / omega
    times = period * np.arange(turns * samples + 1) / samples
    x = 5.0 + np.sin(k * omega * times - 0.4)
    members = SimpleNamespace(
        drive_frequency=np.array([omega]), forcing_period=np.array([period]), shape=(1,), values={}
    )
    run = SimpleNamespace(times=times[None], states=np.stack([x, 0.0 * x], axis=-1)[None])
    monkeypatch.setattr(performance, "extent", lambda members, times, states: (np.array([4.0]), np.array([6.0])))
    found = performance.motion(members, run, Regime.PERIODIC, turns)
    assert (found["stroke"], found["harmonic"]) == (2.0, k)
    assert found["mean height"] == pytest.approx(5.0)
    assert found["lag"] == pytest.approx(np.degrees(0.4), abs=1e-9)
    assert "lag" not in performance.motion(members, run, Regime.CHAOTIC, turns)
