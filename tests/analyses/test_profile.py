"""What `gelcone film` prints: one state in full, several a line each, and why one cannot be held."""

import numpy as np
import pytest

from gelcone import words
from gelcone.analyses import (
    answer,
    profile,
)  # fmt: skip
from gelcone.motion.profile import Held
from tests.analyses.said import NAN, SUBJECT
from tests.edited import coded, edited, made

BASE = ("film", "--film", "membrane", "--set", "stretch_limit=50")


@pytest.fixture
def printed(command_line):
    def run(*arguments):
        code, out, err = command_line(*BASE, *arguments)
        assert (code, err) == (0, "")
        return out

    return run


def test_one_state_is_told_in_full(printed):
    out = printed("--over", "displacement=0.75", "--over", "constant_voltage=0.5", "--set", "dielectric_strength=0.7")
    assert "0.75 at 0.5: partly wrinkled, 52% of its area" in out
    assert "force 0.2132, charge 0.7872, capacitance 1.574 (exact; other commands use fits: force within" in out
    assert "largest field 0.8149 at the mounted radius 0.25, 116% of the dielectric strength: breaks down" in out
    assert (
        "least tangent stiffness 1.225 at the mounted radius 0.25 (0: localisation); pulls in at this height at 0.54"
        in out
    )


def test_states_have_a_line_each_and_capacitances_a_table(printed):
    out = printed("--over", "displacement=0.2,0.5,0.75", "--over", "constant_voltage=0.3,0.6")
    assert "  0.2 at 0.6: slack: without tension, of no definite shape; raise the disc or lower the voltage" in out
    assert "  0.5 at 0.6: wrinkled; force 0.0149, capacitance 1.5, field" in out
    assert "  0.75 at 0.6: pulled in: one ring has localised; lower the voltage or the disc" in out
    assert "breakdown unknown: the dielectric strength is not given" in out
    rows = out.partition("capacitance over height and voltage:\n")[2].splitlines()
    assert [row.split() for row in rows[:2]] == [["0.3", "0.6"], ["0.2", "1.07", "1.462"]]
    assert rows[3].split() == ["0.75", "1.497", "-"]


@pytest.mark.parametrize("strength", [[], ["--set", "dielectric_strength=0.7"]])
def test_where_no_film_is_held_nothing_is_said_of_its_breakdown(printed, strength):
    out = printed("--over", "displacement=0.75", "--over", "constant_voltage=0.6", *strength)
    assert "pulled in" in out
    assert "breakdown" not in out


def test_without_a_rest_there_is_a_remedy(printed):
    out = printed("--over", "constant_voltage=2", "--set", "rest_height=0.8")
    assert "no rest at 2: the disc does not rest at this voltage on a slow ramp; give a height or a lower" in out


def test_both_films_of_a_double_cone_are_printed(printed):
    second = ("--set", "second_film=membrane", "--set", "second_flat_height=1")
    out = printed("--over", "displacement=0.4", "--over", "constant_voltage=0.3", *second)
    first, _, second = out.partition("second film:\n")
    assert "0.4 at 0.3: " in first
    assert "0.4 at 0.3: " in second


def film_of(heights=(14.0,), voltages=(800.0,), **changes):
    over = ("height", "constant_voltage")
    numbers = {
        "force": (0.25, "N"), "charge": (1.5, "uC"), "capacitance": (2.5, "nF"), "pull_in_film_voltage": (1700.0, "V"),
        "largest_field": (12.0, "V/um"), "largest_field_radius": (8.5, "mm"), "breakdown_share": (0.625, "1"),
        "largest_limit_share": (0.125, "1"), "least_tangent_stiffness": (1.75, "1"),
        "least_tangent_stiffness_radius": (9.5, "mm"),
        "wrinkled_share": (0.375, "1"), "film_error": (0.0125, "1"),
    }  # fmt: skip
    shape = (len(heights), len(voltages))
    own = {n: (over, np.full(shape, v), unit) for n, (v, unit) in numbers.items()}
    own |= {"held": (over, np.zeros(shape, dtype=int)), "film_state": coded(over, np.ones(shape, dtype=int), ("taut",
            "partly_wrinkled")), "displacement": (over, np.broadcast_to(np.array(heights)[:, None], shape),
            "mm")}  # fmt: skip
    rings = ("ring", *over)
    own |= {"meridional_stretch": (rings, np.stack([np.full(shape, v) for v in (1.25, 1.5)])),
            "thickness": (rings, np.stack([np.full(shape, v) for v in (0.1, 0.2)]), "mm")}  # fmt: skip
    own["outcome"] = 0
    coords = {"height": ("height", list(heights), "mm"), "constant_voltage": ("constant_voltage", list(voltages), "V")}
    return edited(made(own, coords), **changes)


def film_lines(shown):
    return profile.film_words(shown, SUBJECT).splitlines()[len(answer.heading(SUBJECT, profile.OWN)) :]


def test_one_state_of_a_film():
    lines = [
        "14 mm at 800 V: partly wrinkled, 38% of its area",
        "  force 0.25 N, charge 1.5 uC, capacitance 2.5 nF (exact; other commands use fits: force within 1.2%)",
        "  largest field 12 V/um at the mounted radius 8.5 mm, 62% of the dielectric strength",
        "  meridional stretch 1.25 to 1.5, thickness 0.1 to 0.2 mm; at most 0.12 of the stretch limit",
        "  least tangent stiffness 1.75 at the mounted radius 9.5 mm (0: localisation); pulls in at this height at "
        "1700 V",
    ]
    assert film_lines(film_of()) == lines
    for share in (0.0, 1.0):
        assert film_lines(film_of(wrinkled_share=share))[0] == "14 mm at 800 V: partly wrinkled"
    assert film_lines(film_of(breakdown_share=1.25))[2] == f"{lines[2].replace('62%', '125%')}: breaks down"
    assert film_lines(film_of(breakdown_share=NAN)) == [
        *lines[:2], lines[2].partition(", 62%")[0], *lines[3:], words.UNKNOWN_STRENGTH
    ]  # fmt: skip
    slack = film_of(held=int(Held.SLACK), force=NAN)
    assert film_lines(slack) == [f"14 mm at 800 V: {Held.SLACK.meaning}"]
    assert film_lines(film_of(held=int(Held.NO_REST), force=NAN, displacement=NAN)) == [
        f"no rest at 800 V: {Held.NO_REST.meaning}"
    ]


def test_states_of_a_film_over_heights_and_voltages():
    lines = film_lines(
        film_of((12.0, 14.0), (800.0, 900.0), held=[[0, 0], [0, 1]], capacitance=[[2.0, 3.0], [4.0, NAN]])
    )
    assert lines[0] == (
        "  12 mm at 800 V: partly wrinkled, 38% of its area; force 0.25 N, capacitance 2 nF, field 12 V/um, 62% of the "
        "dielectric strength"
    )
    assert lines[3] == f"  14 mm at 900 V: {Held.SLACK.meaning}"
    assert lines[4] == "capacitance nF over height mm and voltage V:"
    assert [line.split() for line in lines[5:]] == [["800", "900"], ["12", "2", "3"], ["14", "4", "-"]]


def test_what_a_strength_is_for_is_known_where_one_of_the_states_says_it():
    """The others, at which no film is held, have no share of it."""
    shown = film_of((12.0, 14.0), (800.0,), held=[[0], [1]], breakdown_share=[[0.5], [NAN]])
    assert words.UNKNOWN_STRENGTH not in film_lines(shown)


def test_of_many_voltages_a_table_has_some_from_the_first_to_the_last():
    voltages = np.arange(1.0, 31.0)
    rows = film_lines(film_of((12.0, 14.0), voltages, capacitance=np.stack([voltages, 2.0 * voltages])))[-3:]
    chosen, first, second = (np.array(row.split(), dtype=float) for row in rows)
    assert (chosen.size, chosen[0], chosen[-1]) == (profile.MOST_COLUMNS, 1.0, 30.0)
    np.testing.assert_array_equal(first, [12.0, *chosen])
    np.testing.assert_array_equal(second, [14.0, *(2.0 * chosen)])
