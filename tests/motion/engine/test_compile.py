"""Object code: the cache, two processes at once, other systems, and what importing the package loads."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from engine_systems import Cone, assembly, cone_numbers

from gelcone import disk_cache
from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.loop import module_text
from gelcone.motion.engine.program import Program
from gelcone.motion.flow import integrate
from gelcone.presets import find_preset

HERE = Path(__file__).parent
SOURCES = HERE.parents[2] / "src"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path / "code"))
    return disk_cache.folder(compiler.CODE)


@pytest.fixture
def compilations(monkeypatch):
    """Counts what is compiled."""
    made = []
    real = compiler.object_code

    def count(text, *how):
        made.append(text)
        return real(text, *how)

    monkeypatch.setattr(compiler, "object_code", count)
    return made


def end(tolerance=1e-6):
    program = Program(Cone(), "states", tolerance)
    return program.run(cone_numbers(), [[1.0, 0.0]], 0.0, [[7.0]]).end_state


def test_a_second_program_comes_from_the_cache(folder, compilations):
    first = end()
    assert len(compilations) == 1
    assert len(list(folder.iterdir())) == 1
    np.testing.assert_array_equal(end(), first)
    assert len(compilations) == 1
    end(1e-10)
    assert len(compilations) == 2


def test_one_may_ask_whether_a_program_is_in_the_cache(folder, compilations):
    content, other = "a program", compiler.Machine("x86_64-unknown-linux-gnu", "x86-64", "")
    assert not compiler.is_stored(content)
    text = "define double @one() {\n  ret double 1.0\n}\n"
    made = compiler.library(content, lambda: text)
    assert made.size > 100
    assert compiler.is_stored(content)
    assert compiler.is_stored(content, compiler.host())
    assert not compiler.is_stored(content, other)
    assert not compiler.is_stored("another")
    assert len(compilations) == 1


def test_programs_that_differ_have_entries_of_their_own(folder, monkeypatch):
    end()
    (entry,) = folder.iterdir()
    monkeypatch.setattr(compiler, "__version__", "another")
    end()
    assert len(list(folder.iterdir())) == 2
    monkeypatch.setattr(disk_cache, "digest_of", lambda sources: "edited")
    end()
    assert len(list(folder.iterdir())) == 3
    Program(Cone(), "states", 1e-6, machine=compiler.Machine(compiler.host().triple, "", ""))._compile(8)
    assert len(list(folder.iterdir())) == 4
    assert entry.exists()


def test_it_works_without_a_folder(folder, compilations, monkeypatch):
    first = end()
    monkeypatch.setenv("GELCONE_CACHE", "")
    np.testing.assert_array_equal(end(), first)
    assert len(compilations) == 2


def run_python(code, **environment):
    return subprocess.Popen(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(SOURCES), str(HERE)])} | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_processes_at_once_share_the_cache_and_have_the_bits_of_this_one(tmp_path):
    """Whose code was compiled in another way."""
    code = (
        "from engine_systems import Cone, cone_numbers\n"
        "from gelcone.motion.engine.program import Program\n"
        "for keep in ('states', 'work', 'tangents'):\n"
        "    raw = Program(Cone(), keep, 1e-6).run(cone_numbers(), [[1.0, 0.0]], 0.0, [[7.0]])\n"
        "    print(raw.end_state.tobytes().hex())\n"
    )
    running = [run_python(code, GELCONE_CACHE=str(tmp_path)) for _ in range(3)]
    told = [process.communicate(timeout=120) for process in running]
    assert [errors for _, errors in told] == [""] * 3
    here = [
        Program(Cone(), keep, 1e-6).run(cone_numbers(), [[1.0, 0.0]], 0.0, [[7.0]]).end_state.tobytes().hex()
        for keep in ("states", "work", "tangents")
    ]
    assert [output.split() for output, _ in told] == [here] * 3
    (kind,) = tmp_path.iterdir()
    assert len(list(kind.iterdir())) == 3
    assert f"{kind.name}-tests" == compiler.CODE


def test_a_film_with_several_laws_has_the_bits_of_a_process_with_the_defaults(tmp_path):
    code = (
        "import numpy as np\n"
        "from gelcone.motion.flow import integrate\n"
        "from gelcone.physics.model import ConeModel\n"
        "model = ConeModel(film='wrinkling', voltage=0.5, rest_height=0.3)\n"
        "run = integrate(model, (0.4, 0.1), np.linspace(1.0, 40.0, 9), keep='tangents')\n"
        "end = run.states.tobytes() + run.tangents.tobytes()\n"
    )
    names: dict[str, bytes] = {}
    exec(code, names)
    output, errors = run_python(code + "print(end.hex())\n", GELCONE_CACHE=str(tmp_path)).communicate(timeout=120)
    assert (output.strip(), errors) == (names["end"].hex(), "")


def test_importing_the_package_loads_none_of_it():
    code = (
        "import sys, gelcone, gelcone.motion.engine\n"
        "print([name for name in sys.modules if 'llvmlite' in name or 'engine.' in name])"
    )
    output, errors = run_python(code).communicate(timeout=60)
    assert (output.strip(), errors) == ("[]", "")


def test_cold_and_cached_start_are_quick(tmp_path):
    code = (
        "import time\n"
        "from engine_systems import Cone, cone_numbers\n"
        "from gelcone.motion.engine.program import Program\n"
        "numbers = cone_numbers()\n"
        "for _ in range(2):\n"
        "    before = time.process_time()\n"
        "    Program(Cone(), 'tangents', 1e-15).run(numbers, [[1.0, 0.0]], 0.0, [[1.0]])\n"
        "    print(time.process_time() - before)\n"
    )
    output, errors = run_python(code, GELCONE_CACHE=str(tmp_path)).communicate(timeout=60)
    cold, cached = map(float, output.split())
    assert errors == ""
    assert cold < 1.0  # twice what it may take on an idle core
    assert cached < 0.1


OTHERS = [
    ("x86_64-pc-windows-msvc", "haswell", rb"\x64\x86", {"__chkstk"}),
    ("aarch64-pc-windows-msvc", "generic", rb"\x64\xaa", {"__chkstk"}),
    ("arm64-apple-macosx11.0.0", "apple-m1", rb"\xcf\xfa\xed\xfe", set()),
    ("x86_64-apple-macosx11.0.0", "haswell", rb"\xcf\xfa\xed\xfe", set()),
    ("aarch64-unknown-linux-gnu", "generic", rb"\x7fELF", set()),
]


@pytest.mark.parametrize(("triple", "processor", "magic", "allowed"), OTHERS, ids=[other[0] for other in OTHERS])
def test_code_for_other_systems_calls_nothing_from_outside(triple, processor, magic, allowed):
    machine = compiler.Machine(triple, processor, "")
    for keep in ("states", "tangents"):
        text = module_text(Program(Cone(), keep, 1e-6)._plan(machine.vector))
        assert re.match(magic, compiler.object_code(text, machine), re.DOTALL)
        words = assembly(text, machine)
        defined = set(re.findall(r"^([\w.$]+):", words, re.MULTILINE))
        called = set(re.findall(r"^\s+(?:callq?|bl|b|jmpq?)\s+([A-Za-z_]\w*)\s*(?:[#;/].*)?$", words, re.MULTILINE))
        assert "refill" in {name.lstrip("_") for name in called}
        assert called - defined <= allowed


def test_a_law_is_compiled_when_a_member_first_comes_to_it(folder, compilations):
    """A wrinkling film in tension needs the code of the taut film alone; compressed near the plane it falls slack."""
    model = find_preset("base").model.replace(film="wrinkling", prestretch=0.8)
    tolerance = 2.3e-7  # of no other test, so that nothing is compiled yet
    integrate(model, (1.0, 0.0), [0.01], tolerance=tolerance, threads=1)
    assert len(compilations) == 2
    integrate(model, (1.0, 0.0), [0.02], tolerance=tolerance, threads=1)
    assert len(compilations) == 2
    run = integrate(model, (1.0, 0.0), [6.0], tolerance=tolerance, threads=1)
    assert run.film_times[0, 0, 2:].sum() > 0.0
    assert len(compilations) > 2


def test_a_register_holds_eight_numbers_where_the_processor_says_that_it_has_avx_512():
    for triple, features, count in (
        ("x86_64-unknown-linux-gnu", "+avx2,+avx512f,-avx512bw", 8),
        ("x86_64-unknown-linux-gnu", "+avx2,-avx512f", 4),
        ("x86_64-pc-windows-msvc", "", 4),
        ("i686-unknown-linux-gnu", "+avx512f", 8),
        ("arm64-apple-macosx11.0.0", "+avx512f", 2),
    ):
        assert compiler.Machine(triple, "generic", features).vector == count
