"""An envelope as the page is sent it: growing, and in the end that of the analysis."""

import asyncio

import numpy as np
import pytest

import gelcone
from gelcone.devices.files import shipped_devices
from gelcone.motion.driven import DRIVEN_LIMITS
from gelcone.studio import envelope
from gelcone.studio.grids import Source
from gelcone.studio.long_work import Work

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
        expected = result["limit_high"].sel(driven_limit=name).values
        np.testing.assert_allclose(arrays[f"limit {name}"], expected, rtol=1e-12, err_msg=name)
    static = [head["static"][str(name)] for name in result["static_limit"].values]
    np.testing.assert_allclose(static, result["static_limit_voltage"], rtol=1e-12)
    assert head["highest"] == pytest.approx(float(result["driven_peak"][-1]))
    assert head["most"] == pytest.approx(float(result["drive_frequency"][-1]))
    assert head["pull_in_of"] == result.attrs["pull_in_of"] == "membrane"


def test_an_envelope_grows_to_that_of_the_analysis_at_its_frequencies(monkeypatch):
    model = gelcone.find_device("biased-pump").to_model()
    omegas = float(model.drive_frequency) * np.array([0.5, 1.0, 1.7])
    axes = envelope.find_axes(PUMP)
    monkeypatch.setattr(envelope, "find_axes", lambda source: axes._replace(omegas=omegas))
    monkeypatch.setattr(envelope, "REFINEMENTS", 0)
    monkeypatch.setattr(envelope, "FIRST_TASK", 1)
    messages = sent(PUMP)
    known = [len(arrays["frequency"]) for head, arrays in messages[:-1]]
    assert known == sorted(known)
    assert known[0] < known[-1] == 3
    shares = [head["share"] for head, _ in messages[:-1]]
    assert shares == sorted(shares)
    assert shares[-1] < 1.0
    compared(messages, gelcone.envelope(model, frequencies=omegas))


@pytest.mark.slow
def test_a_whole_envelope_is_that_of_the_analysis():
    device = gelcone.find_device("biased-pump")
    compared(sent(PUMP), gelcone.envelope(device.to_model()))
