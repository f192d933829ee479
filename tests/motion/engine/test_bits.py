"""A member's numbers have the same bits whatever surrounds it: order, company, threads, chunks, width, processor."""

import numpy as np
import pytest
from engine_systems import Cone, assembly, cone_numbers

from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine import program as programs
from gelcone.motion.engine import run as runs
from gelcone.motion.engine.loop import module_text
from gelcone.motion.engine.program import Program

MEMBERS = 45
KINDS = [("states", 1e-6), ("tangents", 1e-10), ("work", 1e-10), ("states", 1e-15)]


def ensemble():
    rng = np.random.default_rng(11)
    voltage = rng.uniform(0.2, 2.0, MEMBERS)
    voltage[[4, 30]] = 6.0  # these leave the film's range, and fail
    return {
        "numbers": cone_numbers(voltage=voltage, frequency=rng.uniform(0.1, 1.0, MEMBERS), stretch_limit=20.0),
        "states0": rng.uniform(-1.0, 1.0, (MEMBERS, 2)),
        "start": rng.uniform(0.0, 10.0, MEMBERS),
        "times": 10.0 + np.cumsum(rng.uniform(0.1, 3.0, (MEMBERS, 8)), axis=1),
    }


def run(program, index=slice(None), **options):
    given = ensemble()
    numbers = {k: np.broadcast_to(v, MEMBERS)[index] for k, v in given["numbers"].items()}
    return program.run(
        numbers, given["states0"][index], given["start"][index], given["times"][index], smallest_step=2e-8, **options
    )


def assert_same_bits(a, b):
    for name in ("states", "tangents", "work", "status", "steps", "smallest_step", "end_time", "end_state"):
        first, second = getattr(a, name), getattr(b, name)
        assert (first is None) == (second is None)
        if first is not None:
            first, second = np.ascontiguousarray(first), np.ascontiguousarray(second)
            np.testing.assert_array_equal(first.view(np.int64), second.view(np.int64), err_msg=name)


def take(raw, index):
    parts = {name: value if value is None else value[index] for name, value in vars(raw).items() if name != "switches"}
    return programs.Raw(**parts, switches={})


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: f"{kind[0]}-{kind[1]:g}")
def kind(request):
    program = Program(Cone(), *request.param)
    return request.param, program, run(program)


def test_some_members_fail_and_one_bit_is_seen(kind):
    _, program, raw = kind
    assert 0 < (raw.status > 0).sum() < MEMBERS // 2
    other = run(program)
    other.end_state[0, 0] = np.nextafter(other.end_state[0, 0], 2.0)
    with pytest.raises(AssertionError, match="end_state"):
        assert_same_bits(raw, other)


def test_order_and_company(kind):
    _, program, raw = kind
    shuffled = np.random.default_rng(5).permutation(MEMBERS)
    assert_same_bits(take(raw, shuffled), run(program, shuffled))
    for i in (0, 4, 17, 30, 44):
        assert_same_bits(take(raw, [i]), run(program, [i]))


def test_threads(kind):
    _, program, raw = kind
    for threads in (2, 5):
        assert_same_bits(raw, run(program, threads=threads))


def test_chunks_and_resumption(kind, monkeypatch):
    _, program, raw = kind
    for steps, seconds in ((1, 0.0), (7, 1e-5), (100, 1.0)):
        monkeypatch.setattr(runs, "FIRST_STEPS", steps)
        monkeypatch.setattr(runs, "CALL_SECONDS", seconds)
        assert_same_bits(raw, run(program))


@pytest.mark.parametrize("width", [2, 4, 8, 16])
def test_lane_width(kind, width):
    (keep, tolerance), _, raw = kind
    assert_same_bits(raw, run(Program(Cone(), keep, tolerance, width=width)))


def test_a_processor_without_wide_vectors(kind):
    (keep, tolerance), _, raw = kind
    host = compiler.host()
    if not host.triple.startswith("x86_64"):
        pytest.skip("the processors named here are of another kind")
    haswell = compiler.Machine(host.triple, "haswell", "")
    program = Program(Cone(), keep, tolerance, machine=haswell)
    text = assembly(module_text(program._plan(8)), haswell)
    assert "zmm" not in text
    assert "vfmadd" in text
    assert_same_bits(raw, run(program))


def test_a_processor_without_fused_arithmetic():
    """It calls the C library's fma, which is slow, and the same."""
    host = compiler.host()
    if not host.triple.startswith("x86_64"):
        pytest.skip("the processors named here are of another kind")
    plain = compiler.Machine(host.triple, "x86-64", "")
    some = slice(0, 6)
    program = Program(Cone(), "tangents", 1e-6)
    assert_same_bits(run(program, some), run(Program(Cone(), "tangents", 1e-6, machine=plain), some))
