"""The check of the prose: the sources break no rule, and each rule is broken by a text made for it."""

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = runpy.run_path(str(ROOT / "tools" / "plain_english.py"))


def found(tmp_path, source):
    path = tmp_path / "module.py"
    path.write_text(source, encoding="utf-8")
    return list(SCRIPT["findings"](path))


@pytest.mark.slow
def test_the_sources_break_no_rule(capsys):
    """What the check of a change runs for itself."""
    status = SCRIPT["main"]()
    printed = capsys.readouterr().out
    assert status == 0, printed
    assert int(printed.split()[0]) == len([*(ROOT / "src").rglob("*.py")])


@pytest.mark.parametrize(
    "word", ["is told", "tells", "Beside it", "it goes on", "so many threads", "is kept", "looks at", "is no number"]
)
@pytest.mark.parametrize("place", ["# {}", 'TEXT = "{}"', 'TEXT = f"{{1}} {}"', '"""Module.\n\n{}\n"""'])
def test_each_word_is_found_wherever_it_stands(tmp_path, word, place):
    header = "" if place.startswith('"""') else '"""Module."""\n\n'
    ((line, reason),) = found(tmp_path, header + place.format(word) + "\n")
    assert line == 3
    assert "write" in reason


@pytest.mark.parametrize("name", ["told", "_told", "told_fields"])
def test_the_word_is_found_in_names(tmp_path, name):
    ((line, reason),) = found(tmp_path, f'"""Module."""\n{name} = 1\n')
    assert line == 2
    assert repr(name) in reason


@pytest.mark.parametrize("fine", ["told_by = 1", "there is no fold", "it is no longer stable", "retold", "look_up = 2"])
def test_other_words_are_not(tmp_path, fine):
    assert found(tmp_path, f'"""Module."""\n# {fine}\n') == []


@pytest.mark.parametrize("name", ["run", "_run"])
@pytest.mark.parametrize(
    "beginning",
    ["What it is.", "The same of two.", "Its length.", "How it runs.", "Of a film.", "Whether it runs.", "In volts."],
)
def test_a_docstring_stands_alone_a_private_one_too(tmp_path, beginning, name):
    ((line, reason),) = found(tmp_path, f'"""Module."""\n\n\ndef {name}():\n    """{beginning}"""\n')
    assert (line, "stand alone" in reason) == (4, True)
    for fine in ("Run it.", "Toggle it.", "Ordered values.", "Whether a film runs."):
        assert found(tmp_path, f'"""Module."""\n\n\ndef {name}():\n    """{fine}"""\n') == []


def test_public_names_have_docstrings_and_private_ones_need_none(tmp_path):
    source = "class Thing:\n    def run(self): ...\n    def _own(self): ...\n\n\ndef _help(): ...\n"
    reasons = [reason for _, reason in found(tmp_path, source)]
    assert reasons == ["the module has no docstring", "Thing has no docstring", "run has no docstring"]


def test_a_method_inherits_the_docstring_of_its_base(tmp_path):
    law = (
        '"""Module."""\n\n\nclass Own(Gent):\n    """A law."""\n\n    def energy(self): ...\n    def other(self): ...\n'
    )
    assert [reason for _, reason in found(tmp_path, law)] == ["other has no docstring"]


def test_a_base_is_found_among_classes_of_one_name(tmp_path):
    """The continuum has a class `Film`, too."""
    assert len(SCRIPT["_classes"]()["Film"]) > 1
    taut = '"""Module."""\n\n\nclass Own(Film):\n    """A film."""\n\n    def drag(self, x, n): ...\n'
    assert found(tmp_path, taut) == []
