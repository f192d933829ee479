"""`gelcone locus` as JSON; `gelcone continue` is among the contracts of all analyses."""

import pytest

from tests.answers import result


@pytest.mark.slow
def test_a_locus_is_an_answer(command_line):
    axes = ["--over", "voltage=1.15:1.3", "--over", "damping_ratio=0.009:0.011"]
    code, out, err = command_line("locus", "doubling", "--preset", "base", *axes, "--json")
    assert code == 0, err
    content = result(out)
    assert content["command"] == "locus"
    assert content["parameters"]["drive_frequency"] > 0.0
    assert content["result"]
