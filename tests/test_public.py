"""Every public name is explained: its parameters, what it returns and raises, and an example that runs."""

import doctest
import inspect
import re
import subprocess
import sys
import tempfile
import zipfile
from importlib import import_module
from pathlib import Path

import pytest

import gelcone
import gelcone.devices.units

NAMES = [name for name in dir(gelcone) if not name.startswith("__") and callable(getattr(gelcone, name))]
SECTION = re.compile(r"^(\w+)\n-{3,}\n(.*?)(?=^\w+\n-{3,}\n|\Z)", flags=re.MULTILINE | re.DOTALL)
ENTRY = re.compile(r"^(\*{0,2}\w+(?:, \*{0,2}\w+)*) : ", flags=re.MULTILINE)


def public(name):
    """A public object; a folder that can be called, as the studio, stands for the function of its name."""
    thing = getattr(gelcone, name)
    return getattr(import_module(gelcone._listing()[name][0]), name) if inspect.ismodule(thing) else thing


def examples(text):
    return doctest.DocTestParser().get_examples(text)


def missing(thing):
    """The parts that a docstring lacks, each as a few words."""
    text = inspect.getdoc(thing) or ""
    sections = dict(SECTION.findall(text))
    entries = sections.get("Parameters", "") + sections.get("Attributes", "")
    named = {name.strip("* ") for names in ENTRY.findall(entries) for name in names.split(",")}
    named |= set(re.findall(r"``(\w+)``", entries))  # a parameter may stand in the entry of another
    # the values of an enumeration and the text of an error are not parameters; `parameters` are a model's numbers
    plain = inspect.isclass(thing) and issubclass(thing, int | Exception)
    parameters = {} if plain else inspect.signature(thing).parameters
    found = [f"the parameter {name}" for name in parameters if name not in named | {"parameters"}]
    if not inspect.isclass(thing):
        found += ["Returns"] * ("Returns" not in sections and inspect.signature(thing).return_annotation != "None")
        found += ["Raises"] * ("Raises" not in sections)
    if not any(re.search(r"\d", example.want) for example in examples(sections.get("Examples", ""))):
        found.append("an example with a number")
    return found


def test_public_names_are_found_in_a_zip_file(tmp_path):
    """By a process that has no other gelcone."""
    packed, source = tmp_path / "packed.zip", Path(gelcone.__file__).parents[1]
    with zipfile.ZipFile(packed, "w") as archive:
        for path in sorted(source.glob("gelcone/**/*.py")):
            archive.write(path, path.relative_to(source))
    code = f"import sys; sys.path.insert(0, {str(packed)!r}); import gelcone; print(gelcone.__file__, *dir(gelcone))"
    code += "; gelcone.simulate"
    place, *names = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.split()
    assert Path(place).is_relative_to(packed)
    assert names == dir(gelcone)


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_is_explained(name):
    assert missing(public(name)) == []


@pytest.mark.parametrize("name", NAMES)
def test_an_example_runs_as_it_stands(name, monkeypatch, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    check(doctest.DocTestParser().get_doctest(inspect.getdoc(public(name)), {}, name, None, 0))


@pytest.mark.parametrize("module", [gelcone, gelcone.devices.units], ids=lambda module: module.__name__)
def test_the_examples_of_a_module_run(module):
    for test in doctest.DocTestFinder(exclude_empty=True).find(module):
        if test.examples and test.name.startswith(module.__name__):
            check(test)


def check(test):
    printed = []
    assert test.examples
    doctest.DocTestRunner(verbose=False).run(test, out=printed.append)
    assert "".join(printed) == ""


def explained(model, first, second=1.0, *, third=2.0):
    """Compute.

    Parameters
    ----------
    model : one actuator.
    first : to be left out here.

    Returns
    -------
    A number.
    """


@pytest.mark.parametrize("name", NAMES)
def test_the_first_line_of_a_docstring_names_the_thing_or_says_what_it_does(name):
    """Neither a question nor a subclause; a function in the imperative."""
    first = (inspect.getdoc(public(name)) or "").partition("\n")[0]
    assert not re.match(r"(What|Which|Where|How|Are|Is|That|Its|Names|Draws)\b", first), first
    assert "?" not in first


def test_what_is_missing_is_seen():
    assert missing(explained) == ["the parameter second", "the parameter third", "Raises", "an example with a number"]


def test_help_speaks_of_devices():
    text = inspect.getdoc(gelcone.simulate)
    assert "A `Device` in its place takes SI numbers, or texts with units" in text
    assert "With a device in s, or texts with units." in text
    assert "default its own rest or release" in text
    assert "With a device in V, or texts with units." in inspect.getdoc(gelcone.static)
    assert "With a device in s," in inspect.getdoc(gelcone.map)


REQUIRED = {
    name: [
        own
        for own in inspect.signature(public(name)).parameters.values()
        if own.default is own.empty and own.kind in (own.POSITIONAL_ONLY, own.POSITIONAL_OR_KEYWORD)
    ]
    for name in NAMES
    if inspect.isfunction(public(name))
}
"""Of each public function the parameters that it cannot do without."""


@pytest.mark.parametrize("name", [name for name, required in REQUIRED.items() if required])
def test_a_number_in_place_of_what_a_function_takes_is_refused_in_a_line(name):
    with pytest.raises(gelcone.InputError) as refused:
        public(name)(*[3] * len(REQUIRED[name]))
    assert "\n" not in str(refused.value)
