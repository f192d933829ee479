"""Names of C for exported devices: whatever the file is called, the sources compile."""

import re
import shutil
import subprocess

import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.export import fmu
from gelcone.export.compiler import find_compiler
from gelcone.export.names import MATHEMATICS, c_name
from gelcone.export.sources import Exported, example, filled, sources
from tests.export.instance import STRICT, device

AMPLIFIED = {"film": "wrinkling", "series_resistance": "1 MOhm", "current_limit": "2 mA", "waveform": "trapezoid"}


@pytest.mark.parametrize(
    ("name", "right"), [("My Pump!", "my_pump"), ("7up", "device_7up"), ("double", "device_double"), ("ä-b", "b")]
)
def test_names_of_c(name, right):
    assert c_name(name) == right


def test_a_name_without_letters_is_refused():
    with pytest.raises(InputError, match="letter"):
        c_name("...")


@pytest.mark.parametrize(
    "name", ["pump", "membrane", "stroke", "force", "device", "step", "film", "mine", "runs", "scales"]
)
def test_other_names_stay_what_they_are(name):
    assert c_name(name) == name


def test_no_name_of_the_sources_is_that_of_a_device():
    """Functions and types at the left edge of all sources of C, FMU and WebAssembly, and their files."""
    own = Exported(device(**AMPLIFIED), "pump", True, 1e-7)
    texts = {**sources(own), "example.c": example(own), "wasm.c": filled("wasm.c", "pump", {})}
    for version in (2, 3):
        texts |= {name: text for name, text in fmu._contents(own, version).items() if name.endswith((".c", ".h"))}
    found = {re.sub(r".*/|\.\w+$", "", name) for name in texts} - {"pump"}
    assert {"example", "fmu", "fmi2", "fmi3"} < found
    for text in texts.values():
        bare = re.sub(r"/\*.*?\*/|\"[^\"\n]*\"", "", text, flags=re.DOTALL)
        found |= set(re.findall(r"^[\w][^\n;{=]*?\b([a-z]\w*)\s*\(", bare, re.MULTILINE))
        found |= set(
            re.findall(r"^(?:static|typedef)\b[^\n({=]*?\b([a-z]\w*)\s*(?:\[\d*\])?\s*[;=]", bare, re.MULTILINE)
        )
        found |= set(re.findall(r"^typedef \w+ \(\*([a-z]\w*)\)", bare, re.MULTILINE))
        found |= set(re.findall(r"^} ([a-z]\w*);", bare, re.MULTILINE))
        found |= set(re.findall(r"#include <(\w+)\.h>", bare))
    assert {"run", "point", "component", "function", "step_function", "one_device", "math", "piece_now"} < found
    found = {name for name in found if not name.startswith(("pump", "__")) and name not in ("device", "export_name")}
    assert {name for name in found if c_name(name) != f"device_{name}"} == set()


@pytest.mark.parametrize(
    "name", ["sin", "sinf", "sinl", "round", "exp", "printf", "memcpy", "export", "linux", "int64_t"]
)
def test_no_name_of_c_or_its_library_is_that_of_a_device(name):
    assert c_name(name) == f"device_{name}"
    assert len(set(MATHEMATICS.split())) == len(MATHEMATICS.split())


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")
@pytest.mark.parametrize("name", ["run", "n", "v", "text", "exp", "example", "test", "export", "device", "math"])
def test_sources_compile_whatever_their_folder_is_called(name, tmp_path):
    """As C, and their header as C++; each file is there, and none took the place of another."""
    folder = tmp_path / name
    paths = gelcone.export(device(film="taut"), folder)
    assert len(set(paths)) == 5
    assert all(path.is_file() for path in paths)
    headers = [path.name for path in paths if path.suffix == ".h"]
    for own in [*(path.name for path in paths if path.suffix == ".c"), *headers]:
        words = [*find_compiler(), *STRICT, "-Wno-pragma-once-outside-header", "-fsyntax-only", own]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:1000]
    if shutil.which("g++"):
        words = ["g++", "-fsyntax-only", "-x", "c++", *headers]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:1000]
