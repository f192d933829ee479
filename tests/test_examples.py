"""The examples run as they are, in an empty folder; each asserts a number of its own."""

import runpy
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_its_number_holds(example, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(example), run_name="__main__")
    assert capsys.readouterr().out.strip()


def test_there_are_examples_and_each_is_short_and_asserts():
    assert len(EXAMPLES) >= 5
    for example in EXAMPLES:
        source = example.read_text(encoding="utf-8")
        assert len(source.splitlines()) <= 40, example.name
        assert "\nassert " in source, example.name
