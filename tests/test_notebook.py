"""What a notebook shows, in a fresh kernel: the blocks of the guide as cells, and the studio."""

from __future__ import annotations

import re
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient

import gelcone
from gelcone import markup
from gelcone.progress import bar
from gelcone.studio.notebook import elsewhere

pytestmark = pytest.mark.filterwarnings("ignore:Proactor event loop")  # of Windows, which kernels work around
GUIDE = Path(__file__).parents[1] / "docs" / "notebooks.md"
MORE = ("device.to_model()", "table.head(2)", "frame = gelcone.studio(device)\nframe", "frame.close()")


@pytest.fixture(scope="module")
def shown():
    """Cell -> what it shows, by kind."""
    blocks = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), flags=re.DOTALL)
    cells = [nbformat.v4.new_code_cell(text) for text in (*blocks, *MORE)]
    NotebookClient(nbformat.v4.new_notebook(cells=cells), timeout=120).execute()
    found = {}
    for cell in cells:
        of_cell = found[cell.source.splitlines()[-1]] = {}
        for output in cell.outputs:
            of_cell |= output.get("data", {})
            if output.output_type == "stream":
                of_cell[output.name] = of_cell.get(output.name, "") + output.text
    return found


def cell(shown, begin):
    return next(found for source, found in shown.items() if source.startswith(begin))


def test_the_last_line_of_a_cell_is_seen(shown):
    assert cell(shown, "response.gelcone.plot()")["image/png"].startswith("iVBOR")
    device = cell(shown, "device  #")["text/html"]
    assert "<svg" in device
    assert "spring_rate" in device
    assert "15 N/m" in device
    assert "<svg" in cell(shown, "device.to_model()")["text/html"]
    frame = cell(shown, "frame")["text/html"]
    assert "<iframe" in frame or elsewhere() in frame


def test_a_notebook_has_words_a_table_and_progress(shown):
    assert "run of 500 ms" in cell(shown, "table = ")["stdout"]
    assert "displacement (mm)" in cell(shown, "table.head")["text/html"]
    regime = cell(shown, "gelcone.regime")
    assert "regime" in regime["stderr"] or "application/vnd.jupyter.widget-view+json" in regime
    assert "IProgress" not in regime.get("stderr", "")


# --- without a kernel -------------------------------------------------------------------------------------------------


def test_a_table_has_one_row_for_each_entry_and_codes_as_words():
    device = gelcone.find_device("biased-pump").replace(film="taut")
    response = gelcone.simulate(device, times=[0.0, 1e-3, 2e-3])
    frame = gelcone.table(response)
    assert len(frame) == 3
    np.testing.assert_array_equal(frame["displacement (mm)"], response.displacement.values)
    thin = gelcone.simulate(device.replace(film_thickness=[1.8e-4, 2e-4]), times=[0.0, 1e-3])
    assert gelcone.table(thin)["outcome"].tolist() == ["ok", "ok"]
    assert len(thin.gelcone.table(["sample", "member"])) == 4
    with pytest.raises(gelcone.InputError, match="dims"):
        gelcone.table(response, "member")
    with pytest.raises(gelcone.InputError, match="was given a dict"):
        gelcone.table({})


def test_words_are_those_of_the_command_line(command_line):
    own = gelcone.find_device("biased-pump").replace(film="taut")
    found = gelcone.in_words(gelcone.simulate(own, periods=2))
    code, printed, err = command_line("simulate", "biased-pump", "--film", "taut", "--periods", "2")
    assert code == 0, err
    assert printed.strip() == found.strip()


def test_names_stay_text():
    device = gelcone.find_device("biased-pump").replace(name="<script>alert(1)</script>", film="taut")
    assert "<script" not in device._repr_html_()
    assert "&lt;script&gt;" in device._repr_html_()
    assert "<b>" not in markup.shown("", markup.cone(0.2, 0.5, ["<b>", "<b>", "<b>"]), [("<b>", "<b>")])


@pytest.mark.parametrize("name", ["biased-pump", "double-cone", "paper-table1", "beam-cone"])
def test_every_drawing_stays_inside_its_frame(name):
    device = gelcone.find_device(name)
    for html in (device._repr_html_(), gelcone.ConeModel(rest_height=-9.0)._repr_html_()):
        svg = html[html.index("<svg") : html.index("</svg>")]
        heights = [float(y) for y in re.findall(r'[ c]y="([-\d.]+)"', svg)]
        heights += [
            float(y) for points in re.findall(r'points="([^"]+)"', svg) for y in re.findall(r",([-\d.]+)", points)
        ]
        assert heights
        assert min(heights) >= 0.0
        assert max(heights) <= markup.TALL


def test_a_drawing_has_the_heights_of_its_device():
    low, high = (markup.cone(0.25, height, ["", "", ""]) for height in (0.1, 0.4))

    def rise(svg):
        (left, top, *_) = re.findall(r"([\d.]+),([\d.]+)", svg)
        return float(left[1]) - float(top[1])

    assert rise(high) == pytest.approx(4.0 * rise(low), abs=0.5)


def test_a_bar_takes_shares_and_counts_of_cells(capsys):
    class Tally:
        asked, computed = 4, 3

    with bar("map") as report:
        report(Tally())
        report(0.25)
    assert "map" in capsys.readouterr().err
    assert float(gelcone.limits(gelcone.ConeModel(rest_height=0.3), progress=True).outcome) == 0.0
    assert "limits" in capsys.readouterr().err


def test_behind_a_hub_a_line_says_why_there_is_no_frame(monkeypatch):
    monkeypatch.setenv("JUPYTERHUB_SERVICE_PREFIX", "/user/anna/")
    frame = gelcone.studio("biased-pump")
    try:
        html = frame._repr_html_()
    finally:
        frame.close()
    assert "<iframe" not in html
    assert "JupyterHub" in html
    assert "ssh -L" in html
    assert "token" not in html
