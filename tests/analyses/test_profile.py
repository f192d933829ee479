"""What `gelcone film` prints: one state in full, several a line each, and why one cannot be held."""

import pytest

BASE = ("film", "--film", "membrane", "--set", "stretch_limit=50")


@pytest.fixture
def printed(command_line):
    def run(*arguments):
        code, out, err = command_line(*BASE, *arguments)
        assert (code, err) == (0, "")
        return out

    return run


def test_one_state_is_told_in_full(printed):
    out = printed("--height", "0.75", "--voltage", "0.5", "--set", "dielectric_strength=0.7")
    assert "0.75 at 0.5: partly wrinkled, 52% of its area" in out
    assert "force 0.2132 (in runs within" in out
    assert "charge 0.7872, capacitance 1.574" in out
    assert "largest field 0.8149 at the mounted radius 0.25, 116% of the dielectric strength: breaks down" in out
    assert "least firmness 1.225 at the mounted radius 0.25 (0: localisation); pulls in at this height at 0.54" in out


def test_states_have_a_line_each_and_capacitances_a_table(printed):
    out = printed("--height", "0.2,0.5,0.75", "--voltage", "0.3,0.6")
    assert "  0.2 at 0.6: slack: without tension, of no definite shape; raise the disc or lower the voltage" in out
    assert "  0.5 at 0.6: wrinkled; force 0.0149, capacitance 1.5, field" in out
    assert "  0.75 at 0.6: pulled in: one ring has localised; lower the voltage or the disc" in out
    assert "breakdown unknown: the dielectric strength is not given" in out
    rows = out.partition("capacitance over height and voltage:\n")[2].splitlines()
    assert [row.split() for row in rows[:2]] == [["0.3", "0.6"], ["0.2", "1.07", "1.462"]]
    assert rows[3].split() == ["0.75", "1.497", "-"]


def test_without_a_rest_there_is_a_remedy(printed):
    out = printed("--voltage", "2", "--set", "rest_height=0.8")
    assert "no rest at 2: the disc does not rest at this voltage on a slow ramp; give a height or a lower" in out


def test_both_films_of_a_double_cone_are_printed(printed):
    out = printed(
        "--height", "0.4", "--voltage", "0.3", "--set", "second_film=membrane", "--set", "second_flat_height=1"
    )
    first, _, second = out.partition("second film:\n")
    assert "0.4 at 0.3: " in first
    assert "0.4 at 0.3: " in second
