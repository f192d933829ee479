"""An envelope as the page is sent it: growing, and in the end that of the analysis."""

import asyncio
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.devices.files import shipped_devices
from gelcone.motion.plane import DRIVEN_LIMITS, DriveShape
from gelcone.motion.static_limits import STATIC_LIMITS
from gelcone.studio import envelope
from gelcone.studio.grids import Source
from gelcone.studio.long_work import Work
from tests.recorded import record

PUMP = Source(shipped_devices()["biased-pump"], None, {})


class Here:
    """A pool that does its tasks here and now."""

    size = 2

    async def do(self, lane, run, function, *arguments):
        await asyncio.sleep(0)
        return function(*arguments)


def sent(source):
    found = []

    async def send(head, arrays=None):
        found.append((head, {name: np.array(values) for name, values in (arrays or {}).items()}))

    asyncio.run(envelope.draw_envelope(Work(Here(), 1, 1, 7, send), source))
    return found


def compared(messages, result):
    """Whether the last picture is a result of the analysis."""
    (head, arrays), (done, _) = messages[-2:]
    assert (head["kind"], done["kind"], done["grid"]) == ("envelope", "done", "envelope")
    result = gelcone.to_si(result, gelcone.find_device("biased-pump"))
    np.testing.assert_allclose(arrays["frequency"], result["drive_frequency"], rtol=1e-12)
    np.testing.assert_allclose(arrays["window"], result["recommended_peak"], rtol=1e-12)
    for name in DRIVEN_LIMITS:
        expected = result["limit_low"].sel(driven_limit=name).values
        np.testing.assert_allclose(arrays[f"limit {name}"], expected, rtol=1e-12, err_msg=name)
    static = [head["static"][str(name)] for name in result["static_limit"].values]
    np.testing.assert_allclose(static, result["static_limit_voltage"], rtol=1e-12)
    assert head["highest"] == pytest.approx(float(result["peak_voltage"][-1]))
    assert head["most"] == pytest.approx(float(result["drive_frequency"][-1]))
    assert head["least"] == pytest.approx(float(result["drive_frequency"][0]))
    assert head["pull_in_of"] == result.attrs["pull_in_of"] == "membrane"


def test_an_envelope_grows_to_that_of_the_analysis_at_its_frequencies(monkeypatch):
    model = gelcone.find_device("biased-pump").to_model()
    omegas = float(model.drive_frequency) * np.array([0.5, 1.0])
    axes = envelope.find_axes(PUMP)
    monkeypatch.setattr(envelope, "find_axes", lambda source: axes._replace(omegas=omegas))
    monkeypatch.setattr(envelope, "REFINEMENTS", 0)
    monkeypatch.setattr(envelope, "FIRST_TASK", 1)
    monkeypatch.setattr(envelope, "EXPECTED", 1.0)
    found, find_rows = [], envelope.find_rows
    monkeypatch.setattr(envelope, "find_rows", lambda *given: found.append(find_rows(*given)) or found[-1])
    messages = sent(PUMP)
    known = [len(arrays["frequency"]) for head, arrays in messages[:-1]]
    assert known == sorted(known)
    assert known[0] < known[-1] == 2
    shares = [head["share"] for head, _ in messages[:-1]]
    assert shares == sorted(shares)
    assert shares[-1] < 1.0
    compared(messages, gelcone.envelope(model, frequencies=omegas))
    rows = {name: np.concatenate([one[name] for one in found]) for name in found[0]}
    between, around, confirmed = envelope.find_between(PUMP, rows, float(np.nanmin(rows["low"])), set())
    assert between.size == around.size == 1 - len(confirmed)


@pytest.mark.slow
def test_a_whole_envelope_is_that_of_the_analysis():
    device = gelcone.find_device("biased-pump")
    compared(sent(PUMP), gelcone.envelope(device.to_model()))


def test_an_envelope_is_made_from_coarse_to_fine_and_between_its_rows_until_all_is_known(monkeypatch):
    """With limits that are made up: every frequency once, in tasks of a few, and the picture in hertz and volts."""
    omegas, count = np.arange(1.0, 34.0), len(DRIVEN_LIMITS)
    asked, between = [], []
    static = np.array([np.inf, 1.25, np.nan, np.inf, np.nan, 1.5])

    def find_rows(source, own, static, around=None):
        assert (source, static[-1]) == (PUMP, 1.5)
        asked.append((own.tolist(), None if around is None else around.tolist()))
        low = np.tile(own[:, None] / 100.0, (1, count))
        return {"frequency": own, "low": low, "final_below": own}

    def find_between(source, rows, ceiling, confirmed):
        own = rows["frequency"]
        assert (np.diff(own) > 0.0).all()
        between.append((own[[0, -1]].tolist(), ceiling, set(confirmed)))
        new = own[:-1][np.diff(own) > 0.9][:3] + 0.5 if len(between) <= 2 else np.empty(0)
        return new, 10.0 + new, confirmed | {(float(own[0]), float(own[-1]))}

    monkeypatch.setattr(envelope, "find_axes", lambda source: envelope.Axes(omegas, 2.0, 100.0))
    monkeypatch.setattr(
        envelope,
        "find_limits",
        lambda source: envelope.Limits(static, 1.515 * np.arange(1, 21) / 20.0, "membrane", DriveShape(1.25, -0.25)),
    )
    monkeypatch.setattr(envelope, "find_rows", find_rows)
    monkeypatch.setattr(envelope, "find_between", find_between)
    messages = sent(PUMP)
    begun = [own for own, around in asked if around is None]
    assert begun[:2] == [[1.0, 17.0], [9.0, 33.0]]  # the coarsest first, two for each worker
    assert max(map(len, begun)) <= 4
    assert sorted(own for part in begun for own in part) == omegas.tolist()
    later = [(own, around) for own, around in asked if around is not None]
    new = [1.5, 2.5, 3.5, 17.5, 18.5, 19.5]
    assert [len(own) for own, _ in later] == [3, 3]  # at most four a task
    assert [one for own, _ in later for one in own] == new
    assert all(around == [10.0 + one for one in own] for own, around in later)
    assert [pair for pair, *_ in between[:2]] == [[1.0, 17.0], [17.0, 33.0]]
    assert {ceiling for _, ceiling, _ in between} == {1.25}
    assert len(between) == 4  # both workers, twice: the second time they find nothing more
    assert all(known == {(1.0, 17.0), (17.0, 33.0)} for *_, known in between[2:])
    (head, arrays), (done, _) = messages[-2:]
    assert (done["kind"], done["grid"], head["id"]) == ("done", "envelope", 7)
    every = np.sort([*omegas, *new])
    np.testing.assert_allclose(arrays["frequency"], 2.0 * every)
    for name in DRIVEN_LIMITS:
        np.testing.assert_allclose(arrays[f"limit {name}"], 100.0 * every / 100.0)
    assert head["static"]["pull-in"] == 150.0
    assert (head["highest"], head["least"], head["most"]) == (pytest.approx(151.5), 2.0, 66.0)
    assert (head["pull_in_of"], head["shape"]) == ("membrane", {"voltage_amplitude": 1.25, "voltage_offset": -0.25})
    assert head["share"] == pytest.approx(len(every) / (1.8 * 33))
    first = messages[0][0]
    assert (list(first["static"]), first["pull_in_of"]) == (list(STATIC_LIMITS), "membrane")
    assert first["share"] == 0.0


def test_rows_are_those_of_the_motion_at_their_frequencies_up_to_pull_in_and_around_what_is_known(monkeypatch):
    """A worker is asked for the numbers of the picture alone."""
    made = dict.fromkeys(("frequency", "low", "high", "final_below", "more"), 1.0)
    asked = record(monkeypatch, envelope, _plane="plane", peaks_of="peaks", rows_of=made)
    assert envelope.find_rows(PUMP, "omegas", [1.25, 1.5], "around") == {n: v for n, v in made.items() if n != "more"}
    assert asked["peaks_of"] == [{"plane": "plane", "static": [1.25, 1.5]}]
    (rows,) = asked["rows_of"]
    given = {"omegas": "omegas", "volts": "peaks", "pull_in": 1.5, "around": "around", "yields": False}
    assert {name: rows[name] for name in given} == given


STAIRS = {"component": "staircase", "levels": [-0.5, 0.2], "rise": 0.1}
SAMPLED = {"component": "samples", "shares": [0.0, 0.5, 1.0], "values": [0.0, 0.5, 0.0], "repeat": True}


@pytest.mark.parametrize(
    ("waveform", "amplitude", "offset", "peak"),
    [
        ("half_wave", "1500 V", "-300 V", 1200.0),
        ("half_wave", "1500 V", "300 V", 1800.0),
        (STAIRS, "1 kV", "300 V", 500.0),
        (SAMPLED, "1 kV", "-400 V", 400.0),
        ("burst", "1 kV", "-400 V", 1400.0),
        ("sine", "1 kV", "-400 V", 1400.0),
    ],
)
def test_the_page_is_sent_the_shape_whose_peak_is_that_of_the_analysis(waveform, amplitude, offset, peak, monkeypatch):
    device = gelcone.find_device("biased-pump").replace(
        {"waveform": waveform, "voltage_amplitude": amplitude, "voltage_offset": offset}
    )
    plane = SimpleNamespace(model=device.to_model(), shape=DriveShape.of(device.to_model()))
    record(monkeypatch, envelope, _plane=plane, static_limits_of="static", peaks_of="peaks", pull_in_of="membrane")
    shape = envelope.find_limits(PUMP).shape
    own = device.voltage_amplitude / shape.amplitude, device.voltage_offset / shape.bias
    assert own == pytest.approx((peak, peak), rel=1e-9)


def test_an_envelope_begins_with_the_default_frequencies_and_goes_between_rows_up_to_the_lowest_limit(
    monkeypatch,
):
    plane = SimpleNamespace(model="model", default_frequencies=lambda: np.array([0.75, 1.5]))
    asked = record(
        monkeypatch, envelope, _plane=plane,
        scales={"frequency": 3.0, "voltage": 40.0}, unknown_between=("between", "around"),
    )  # fmt: skip
    axes = envelope.find_axes(PUMP)
    assert (axes.omegas.tolist(), axes.hertz, axes.volts) == ([0.75, 1.5], 3.0, 40.0)
    assert envelope.find_between(PUMP, "rows", 1.25, "confirmed") == ("between", "around", "confirmed")
    assert [list(call.values()) for call in asked["unknown_between"]] == [[plane, "rows", 1.25, "confirmed"]]
