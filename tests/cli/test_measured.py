"""`gelcone measured`: one comparison outside of its interval ends with 1, whatever the others say."""

import json

import pytest

from gelcone.lab import page
from gelcone.lab.page import Comparison, Page


def made(*verdicts):
    compared = tuple(Comparison("stroke@1 kV", 1e-3, 0.9e-3, 1.1e-3, 1.05e-3, "m", verdict) for verdict in verdicts)
    return Page("A cone", "made up", ("breakdown",), compared)


@pytest.mark.parametrize(
    ("pages", "code"),
    [
        ([made("inside")], 0),
        ([made("inside", "outside")], 1),
        ([made("not compared: it rests on assumed numbers (moving_mass 80%)")], 0),
        ([made("outside (40% of 10 samples)"), made("inside")], 1),
        ([made()], 0),
    ],
)
def test_one_that_is_outside_ends_with_1(pages, code, command_line, monkeypatch):
    left = list(pages)
    monkeypatch.setattr(page, "compare_measured", lambda path, **options: left.pop(0))
    found, out, _ = command_line("measured", *(f"page{k}.toml" for k in range(len(pages))))
    assert found == code
    assert out.count("A cone (made up)") == len(pages)
    left[:] = pages
    found, out, _ = command_line("measured", "--json", *(f"page{k}.toml" for k in range(len(pages))))
    assert found == code
    listed = json.loads(out)["result"]["pages"]
    assert [[one["verdict"] for one in own["compared"]] for own in listed] == [
        [one.verdict for one in own.compared] for own in pages
    ]
