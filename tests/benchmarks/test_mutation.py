"""The program that puts faults in: which faults there are, and that it tells a seen one from one that is not."""

import ast
import importlib.util
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def mutation():
    spec = importlib.util.spec_from_file_location("mutation", ROOT / "benchmarks" / "mutation.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["mutation"] = module  # where its dataclass looks for itself
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def tree(tmp_path):
    """A program of one folder, whose tests see a change of a sum but not of a difference."""
    files = {
        "src/gelcone/__init__.py": "",
        "src/gelcone/shapes/__init__.py": "",
        "src/gelcone/shapes/sides.py": "def total(a, b):\n    return a + b\n\n\ndef rest(a, b):\n    return a - b\n",
        "tests/shapes/test_sides.py": "from gelcone.shapes import sides\n\n\ndef test_total():\n"
        "    assert sides.total(1, 2) == 3\n",
        "pyproject.toml": '[tool.pytest.ini_options]\npythonpath = ["src"]\n',
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_each_fault_is_a_change_that_still_compiles(mutation):
    faults = [fault for name in ("plots", "paper") for fault in mutation.random_faults(ROOT, name, 30, 1)]
    assert len({(fault.file, fault.at) for fault in faults}) == len(faults) == 60
    assert len({fault.kind for fault in faults}) >= 6
    for fault in faults:
        text = (ROOT / fault.file).read_bytes()
        changed = fault.applied(text)
        assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(text))


def test_the_same_seed_gives_the_same_faults(mutation):
    one, same, other = (mutation.random_faults(ROOT, "analyses", 10, seed) for seed in (1, 1, 2))
    assert one == same != other


def test_listed_faults_are_found_in_the_program_as_it_is(mutation):
    faults = mutation.listed_faults(ROOT)
    assert len(faults) >= 20
    for fault in faults:
        changed = fault.applied((ROOT / fault.file).read_bytes())
        if fault.file.suffix == ".py":  # others are of the studio's page
            ast.parse(changed)


def test_looks_words_and_annotations_are_left_out(mutation, tree):
    path = tree / "src/gelcone/shapes/drawn.py"
    path.write_text(
        'MOST_STEPS = 5\nif TYPE_CHECKING:\n    x = 1\n\n\ndef draw(axes, n: "1" = 3):\n    """Words 7."""\n'
        '    axes.plot(n, lw=2.0)\n    raise ValueError(f"{n + 1}")\n'
    )
    faults = mutation.faults_of(tree, path.relative_to(tree))
    assert [(fault.old, fault.new) for fault in faults] == [("3", "(4)")]


@pytest.mark.slow
def test_the_share_that_is_seen_is_printed_by_folder_and_the_tree_is_not_touched(mutation, tree, capsys):
    before = (tree / "src/gelcone/shapes/sides.py").read_text()
    code = mutation.main(["--folder", "shapes", "--count", "9"], tree)
    printed = capsys.readouterr().out
    assert code == 1
    assert "shapes          1 of    2    50%" in printed
    assert "not seen: shapes/sides.py:6" in printed
    assert "- return a - b" in printed
    assert (tree / "src/gelcone/shapes/sides.py").read_text() == before
    assert mutation.main(["--folder", "shapes", "--least", "0.5"], tree) == 0


@pytest.mark.slow
def test_tests_that_fail_without_a_fault_say_nothing_about_faults(mutation, tree):
    (tree / "tests/shapes/test_sides.py").write_text("def test_nothing():\n    assert False\n")
    with pytest.raises(SystemExit, match="fails without any fault"):
        mutation.main(["--folder", "shapes"], tree)


def test_an_unknown_folder_is_refused(mutation, tree, capsys):
    with pytest.raises(SystemExit):
        mutation.main(["--folder", "shape"], tree)
    assert "no folder shape" in capsys.readouterr().err
