"""No viscous device is silently wrong: a few blocks of ``benchmarks/creeping.py``, and that it sees what is wrong."""

import json

import creeping
import pytest

from gelcone.motion import response

TAUT = 1
"""Three branches and a triangle behind an ideal source."""
SLOW = pytest.mark.slow


@pytest.mark.parametrize(
    ("block", "count"),
    [(0, 10), (TAUT, 10), pytest.param(5, 20, marks=SLOW), pytest.param(7, 40, marks=SLOW)],
    ids=["slew rate", "three branches", "linear flow and Debye share", "wrinkling behind a resistance"],
)
def test_random_devices_are_right_or_say_why_not(block, count):
    record = creeping.check(block, count)
    assert record["wrong"] == []
    assert record["counts"].get("right", 0) >= 0.7 * count


def test_a_fault_is_seen(monkeypatch):
    """A modulus that is off by a millionth."""
    of_numbers = creeping.model_of
    monkeypatch.setattr(
        creeping,
        "model_of",
        lambda structure, n: of_numbers(structure, {**n, "viscous_modulus_1": (1.0 + 1e-6) * n["viscous_modulus_1"]}),
    )
    assert creeping.check(TAUT, 2)["counts"] == {"wrong": 2}


@pytest.fixture(scope="module")
def residuals():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(response, "delivered", lambda *given: {})  # which takes longer than the motions
        return creeping.balance(4)


@pytest.mark.parametrize(
    ("kinds", "times", "code"),
    [({"right": 9, "without a reference": 1}, 1.0, 0), ({"wrong, pull-in": 1}, 1.0, 1), ({"right": 9}, 1e9, 1)],
)
def test_the_exit_code_knows_every_kind_of_wrong(tmp_path, kinds, times, code, residuals, monkeypatch):
    monkeypatch.setattr(creeping, "balance", lambda: {kind: times * worst for kind, worst in residuals.items()})
    record = {"block": 0, "components": "", "counts": kinds, "worst": 0.1, "wrong": [], "seconds": [1.0, 1.0]}
    (tmp_path / "done.jsonl").write_text(json.dumps(record) + "\n")
    assert creeping.main(creeping.BLOCK, tmp_path / "done.jsonl") == code
