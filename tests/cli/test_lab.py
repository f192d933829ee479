"""Fits and data sheets: what is read as a material or a device, what is refused, and which files there are."""

from pathlib import Path

import pytest

import gelcone
from gelcone.cli import command, lab
from gelcone.lab import device, device_tests
from gelcone.plots import style

DEVICE = "disc_radius = '8 mm'\n"


@pytest.mark.parametrize(
    ("subject", "text", "kind"),
    [
        (None, None, ("material", None, {})),
        ("gel.toml", "[material]\nname = 'gel'\n", ("material", "gel.toml", {"material": {"name": "gel"}})),
        ("own.toml", DEVICE, ("device", "own.toml")),
        ("own.toml", "film_radius = '30 mm'\n[material]\n", ("device", "own.toml")),
        ("biased-pump", None, ("device", "biased-pump")),
        ("biased-pump", "[material]\n", ("material", "biased-pump", {"material": {}})),  # a file goes first
    ],
)
def test_a_file_with_a_radius_is_a_device_and_another_a_material(
    subject, text, kind, monkeypatch, command_line, tmp_path
):
    asked = []
    monkeypatch.setattr(
        lab, "_fit_device", lambda subject, data, output, own: asked.append(("device", subject, data, own))
    )
    monkeypatch.setattr(
        lab,
        "_fit_material",
        lambda subject, content, data, output, own: asked.append(("material", subject, content, own)),
    )
    if text is not None:
        (tmp_path / subject).write_text(text, encoding="utf-8")
    assert command_line("fit", *([subject] if subject else []), "--data", "a.csv")[0] == 0
    ((*found, own),) = asked
    wanted = kind if kind[0] == "material" else (*kind, (Path("a.csv"),))
    assert tuple(found) == wanted
    assert own == (lab.OF_MATERIALS if kind[0] == "material" else lab.OF_DEVICES)


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        ([], "--data is missing; give tests.toml or a measured CSV file"),
        (["none.toml", "--data", "a"], "none.toml: there is no such file; give a TOML file with a table [material]"),
        (["bad.toml", "--data", "a"], "bad.toml: broken TOML: "),
        (["--data", "a", "--free", "b"], "--free: is an option of the fit of a device; leave it out"),
        (["biased-pump", "--data", "a", "--laws", "gent"],
         "--laws: is an option of the fit of a material; leave it out"),
        (["biased-pump", "--data", "a", "--data", "b"],
         "--data: of a device is one list of tests; put all into one tests.toml"),
    ],
)  # fmt: skip
def test_what_cannot_be_fitted_is_refused_in_full_words(typed, message, command_line, tmp_path):
    (tmp_path / "bad.toml").write_text("a = = 1\n", encoding="utf-8")
    code, out, err = command_line("fit", *typed)
    assert (code, out) == (2, "")
    if message.endswith(": "):
        assert err.startswith(f"Error: {message}")
        assert err.endswith("; correct it there\n")
    else:
        assert err == f"Error: {message}\n"


@pytest.mark.parametrize("option", ["films", "loss"])
@pytest.mark.parametrize("given", [None, "a", "a,b", "a, b, c"])
@pytest.mark.parametrize("plan", [False, True])
def test_a_plan_is_that_of_one_structure_and_a_fit_compares_several(option, given, plan, monkeypatch, command_line):
    """A fit or a plan is asked for with the words of the option, and what is not given is left to it."""
    asked = []

    def stop(kind):
        def ask(device, tests, free, **how):
            asked.append((kind, how))
            raise gelcone.InputError("asked")

        return ask

    monkeypatch.setattr(device_tests, "read_device_tests", str)
    monkeypatch.setattr(device, "fit_device", stop("fit"))
    monkeypatch.setattr(device, "plan_device", stop("plan"))
    typed = ("--predict", "pull-in", *(("--plan",) if plan else ("--profile", "mass")))
    typed += () if given is None else (f"--{option}", given)
    code, _, err = command_line("fit", "biased-pump", "--data", "a.toml", "--free", "moving_mass~3%", *typed)
    words = None if given is None else given.replace(" ", "").split(",")
    assert code == 2
    if plan and words and len(words) > 1:
        assert (err, asked) == (f"Error: --{option}: a plan is that of one structure; give one\n", [])
    elif plan:
        one = {"films": "film", "loss": "loss"}
        own = {name: words[0] if words and key == option else None for key, name in one.items()}
        assert asked == [("plan", own | {"predict": ("pull-in",)})]
    else:
        several = {"films": "films", "loss": "losses"}
        own = {name: words if key == option else None for key, name in several.items()}
        assert asked == [("fit", own | {"predict": ("pull-in",), "profile": ("mass",)})]


@pytest.mark.parametrize("text", ["1,x", "1.5", "", "one"])
def test_numbers_of_branches_are_whole(text):
    with pytest.raises(gelcone.InputError) as error:
        lab._counts(text)
    assert str(error.value) == f"--branches = {text!r}: must be whole numbers, such as 1,2,3"
    assert (lab._counts(None), lab._words(None)) == (None, None)
    assert (lab._counts("0, 3"), lab._words(" a ,b")) == ([0, 3], ["a", "b"])


DRAWN = {
    (): {"samples": None, "uncertain": ()},
    ("--uncertain", "film_thickness=0.2 mm~0.01 mm", "--count", "8", "--seed", "5"): {
        "samples": None, "uncertain": ("film_thickness=0.2 mm~0.01 mm",), "count": 8, "method": "sobol", "seed": 5,
    },
    ("--samples", "draws.nc"): {
        "samples": Path("draws.nc"), "uncertain": (), "count": 64, "method": "sobol", "seed": 0,
    },
    ("--samples", "draws.nc", "--uncertain", "a=1:2", "--method", "latin-hypercube"): {
        "samples": Path("draws.nc"), "uncertain": ("a=1:2",), "count": 64, "method": "latin-hypercube", "seed": 0,
    },
}  # fmt: skip
"""What is typed of draws, and what reaches the run."""


@pytest.mark.parametrize("drawn", DRAWN)
@pytest.mark.parametrize("more", [(), ("--out", "there"), ("--out", "there", "--force"), ("--out", "there", "--json")])
def test_a_data_sheet_is_also_a_page_where_files_are_written(drawn, more, monkeypatch, command_line, tmp_path):
    """The figure of the sheet, as PDF next to it; one that exists is kept before any work is done."""
    pages, ran = [], []
    monkeypatch.setattr("gelcone.plots.plot", lambda result: f"page of {result}")
    monkeypatch.setattr(style, "save_figure", lambda figure, path, force: pages.append((figure, path, force)))

    def run(analysis, *, out, force, as_json, draw, **typed):
        ran.append((analysis.name, out, force, as_json))
        assert {name: typed[name] for name in DRAWN[drawn]} == DRAWN[drawn]
        if out is not None:
            assert draw("the sheet") == "page of the sheet"
        return 1

    monkeypatch.setattr(lab, "run", run)
    code, out, _ = command_line("datasheet", "biased-pump", *drawn, *more)
    place = Path("there") if more else None
    assert (code, ran) == (1, [("datasheet", place, "--force" in more, "--json" in more)])
    assert pages == ([("page of the sheet", Path("there/datasheet.pdf"), "--force" in more)] if more else [])
    assert out == ("wrote there/datasheet.pdf\n" if more and "--json" not in more else "")
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "datasheet.pdf").write_text("mine")
    ran.clear()
    code, _, err = command_line("datasheet", "biased-pump", *drawn, *more)
    kept = bool(more) and "--force" not in more
    assert (code, len(ran)) == ((2, 0) if kept else (1, 1))
    assert ("there/datasheet.pdf" in err) == kept


RING_DOWN = """[[test]]
kind = "ring-down"
frequency = "9 Hz"
decay = "1 1/s"
noise = {frequency = "0.02 Hz", decay = "0.05 1/s"}
"""


@pytest.mark.parametrize(("mass", "code"), [("moving_mass~50%", 0), ("moving_mass~0.1%", 1)])
def test_each_file_of_a_fit_holds_what_its_name_says_and_a_refused_structure_ends_with_1(
    mass, code, command_line, tmp_path, undrawn
):
    (tmp_path / "a.toml").write_text(RING_DOWN, encoding="utf-8")
    (tmp_path / "own.toml").write_text(gelcone.find_device("biased-pump").replace(film="taut").to_toml())
    free = ("--free", mass, "--free", "damping_coefficient~100%")
    assert command_line("fit", "own.toml", "--data", "a.toml", *free, "--out", "there")[0] == code
    there = tmp_path / "there"
    assert sorted(path.name for path in there.iterdir()) == sorted(lab.DEVICE_FILES)
    fit = gelcone.load(there / "fit.nc")
    assert fit.attrs["refused"] == code
    assert gelcone.Device.from_toml(there / "device.toml") == gelcone.fitted_device(fit)
    assert gelcone.load(there / "draws.nc").sizes == {"draw": 64}
    assert (there / "band.csv").read_text().startswith("voltage (V),height (mm),")


@pytest.mark.parametrize(
    ("name", "command_of_answers"),
    [("limits", "sweep"), ("settled", "sweep"), ("envelope", "envelope"), ("regime", "sweep")],
)
def test_draws_are_delivered_in_the_words_that_their_result_has(
    name, command_of_answers, monkeypatch, command_line, tmp_path
):
    """Those of a sweep for an analysis of cells; from its start, which a device leaves to each draw."""
    from gelcone.atlas import drawn

    asked, delivered, checked = [], [], []
    (tmp_path / "draws.csv").write_text("film_thickness [mm]\n0.2\n0.21\n0.22\n", encoding="utf-8")
    monkeypatch.setattr(drawn, "over_draws", lambda *given, **how: asked.append((given, how)) or "result")
    monkeypatch.setattr(command, "check_folder", lambda *given: checked.append(given))
    monkeypatch.setattr(
        command,
        "deliver",
        lambda answers, result, subject, out, **how: delivered.append((answers, result, out, how)) or 0,
    )
    assert (
        command_line(name, "biased-pump", "--film", "taut", "--samples", "draws.csv", "--out", "there", "--force")[0]
        == 0
    )
    (((device, draws, analysis), how),) = asked
    assert (device.name, draws["film_thickness"].tolist(), analysis) == (
        "biased pumping cone", pytest.approx([2e-4, 2.1e-4, 2.2e-4]), name,
    )  # fmt: skip
    assert how["initial"] is None
    answers, result, out, rest = delivered.pop()
    assert (answers.command, result, out) == (command_of_answers, "result", Path("there"))
    assert (rest["force"], rest["as_json"]) == (True, False)
    assert checked == [(Path("there"), command_of_answers, True)]
    assert set(how) == {"initial", "progress"}
