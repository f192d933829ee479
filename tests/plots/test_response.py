"""Figures of the time response: drawn without a warning (pytest makes them errors), with the right lines and units."""

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg

import gelcone
from gelcone import ConeModel, Outcome, find_device, simulate
from gelcone.motion.validity import SLACK_IN
from gelcone.plots.response import MOST_LINES, SLACK, failings, mark_end, members, response_figure, up_to_end
from gelcone.plots.style import BLUE, CYCLE, GREY, STYLE, VERMILION, save_figure
from tests.plots.made_up import blank, corners, data_of, result

RESPONSES = {
    "single": lambda: simulate(ConeModel(), periods=3),
    "never slack": lambda: simulate(ConeModel(voltage=0.0), periods=3),
    "near the limit": lambda: simulate(ConeModel(stretch_limit=0.4), (0.927, 0.0), periods=2),
    "unbounded": lambda: simulate(ConeModel(law="neo-hookean", voltage_bias=3.0), periods=100),
    "two samples": lambda: simulate(ConeModel(), times=[1.0, 2.0]),
    "one sample": lambda: simulate(ConeModel(), times=[1.0]),
    "ensemble": lambda: simulate(ConeModel(voltage=[0.5, 1.0, 1.3]), periods=3),
    "large ensemble": lambda: simulate(ConeModel(voltage=np.linspace(0.1, 1.3, 40)), periods=3),
    "some outside": lambda: simulate(ConeModel(stretch_limit=[0.4, 50.0]), periods=3),
    "frequencies": lambda: simulate(ConeModel(drive_frequency=[0.5, 1.0]), periods=3),
    "grid": lambda: simulate(ConeModel(drive_frequency=[[0.5], [1.0]], voltage=[0.1, 0.2]), periods=3),
    "device": lambda: of_device(find_device("paper-table1")),
    "device ensemble": lambda: of_device(find_device("soft-film").replace(frequency=[8.0, 10.0])),
}


def of_device(device):
    response = simulate(device.to_model(), device.initial_state(), periods=3)
    return gelcone.to_si(response, device)


@pytest.mark.parametrize("name", RESPONSES)
def test_every_response_is_drawn_without_a_warning(name):
    response = RESPONSES[name]()
    figure = response_figure(response)
    with mpl.rc_context(STYLE):
        FigureCanvasAgg(figure).draw()
    lines = min(response.outcome.size, MOST_LINES)
    if lines > 1:
        assert [len(axes.lines) for axes in figure.axes] == [1, 2] * lines
        return
    top, bottom, *others = figure.axes
    assert len(top.lines) == 1 + (int(response.outcome) != 0)
    assert len(bottom.lines) == 1
    assert len(others[-1].lines) == 2
    assert len(others) == (2 if failings(response) else 1)


def test_axes_carry_the_units_of_the_device():
    figure = response_figure(RESPONSES["device"]())
    top, bottom, _, side = figure.axes
    assert top.get_ylabel() == "displacement (mm)"
    assert (bottom.get_xlabel(), bottom.get_ylabel()) == ("time (ms)", "voltage (V)")
    assert (side.get_xlabel(), side.get_ylabel()) == ("displacement (mm)", "velocity (m/s)")
    assert figure.get_suptitle() == "paper's Table 1, PVC-DBA 4:1"


def test_lines_are_the_motion():
    response = RESPONSES["single"]()
    top = response_figure(response).axes[0]
    np.testing.assert_array_equal(top.lines[0].get_xdata(), response.time)
    np.testing.assert_array_equal(top.lines[0].get_ydata(), response.displacement)
    assert top.get_xlim() == (response.time[0], response.time[-1])


def test_a_run_that_ended_early_fills_its_figure():
    model = gelcone.ConeModel(film="wrinkling", voltage=0.9, drive_frequency=0.5)
    response = gelcone.simulate(model, (0.6, 0.0), periods=20)
    ran = np.isfinite(response["displacement"].values)
    assert ran.mean() < 0.05
    assert (response["film_state"].values[~ran] == -1).all()
    assert not response["hoop_slack"].values[~ran].any()
    figure = response_figure(response)
    end = float(response["time"][ran][-1])
    assert end < figure.axes[0].get_xlim()[1] < 1.2 * end
    shares = [text.get_text() for text in figure.axes[2].texts][1::2]
    assert shares[0] == f"{(response['hoop_slack'] | response['meridional_slack']).values[ran].mean():.0%}"


def test_a_member_has_one_colour_in_every_panel():
    """A row for each: none is drawn over another."""
    panels = np.reshape(response_figure(RESPONSES["ensemble"]()).axes, (3, 2))
    colours = [{line.get_color() for line in axes.lines} for axes in panels.ravel()]
    assert all(len(own) == 1 for own in colours)
    assert colours[::2] == colours[1::2]
    assert len(set.union(*colours)) == 3


def test_the_strip_says_where_the_model_fails():
    response = RESPONSES["device"]()
    found = failings(response)
    assert list(found) == ["film slack", "field too high", "beyond membrane"]
    np.testing.assert_array_equal(found["film slack"], response.hoop_slack | response.meridional_slack)
    strip = response_figure(response).axes[2]
    assert [text.get_text() for text in strip.texts][::2] == list(found)
    assert list(failings(RESPONSES["near the limit"]())) == ["film slack", "near limit"]
    assert failings(RESPONSES["never slack"]()) == {}


def test_every_slack_state_of_a_film_that_wrinkles_has_its_words():
    slack = {kind for kinds in SLACK_IN.values() for kind in kinds}
    assert SLACK.keys() == slack & set(ConeModel(film="wrinkling").system.film.kinds)
    kinds = "taut hoop_slack meridional_slack crumpled"
    run = RESPONSES["two samples"]().assign(film_state=("time", [2, 3], {"flag_meanings": kinds}))
    assert [words for words in failings(run) if words in SLACK.values()] == ["meridian slack", "crumpled"]


def test_members_are_named_by_what_differs_between_them():
    assert [name for name, _ in members(RESPONSES["ensemble"]())] == ["voltage 0.5", "voltage 1", "voltage 1.3"]
    names = [name for name, _ in members(RESPONSES["grid"]())]
    assert names[1] == "voltage 0.2, drive frequency 0.5"
    assert len(members(RESPONSES["large ensemble"]())) == MOST_LINES
    assert [name for name, _ in members(RESPONSES["single"]())] == [""]


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_the_same_figure_is_the_same_bytes(suffix, tmp_path):
    response = RESPONSES["single"]()
    paths = [tmp_path / f"{name}.{suffix}" for name in "ab"]
    for path in paths:
        save_figure(response_figure(response), path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with pytest.raises(gelcone.InputError, match="exists already"):
        save_figure(response_figure(response), paths[0])


def made_up(outcome=0):
    """A short run: slack in its middle, field too high at its end."""
    time = np.linspace(0.0, 6.0, 7)
    return result(
        {
            "displacement": ("time", time**2),
            "velocity": ("time", 2.0 * time),
            "drive_voltage": ("time", np.sin(time)),
            "hoop_slack": ("time", [0, 0, 1, 0, 0, 0, 0]),
            "meridional_slack": ("time", [0, 0, 0, 1, 0, 0, 0]),
            "breakdown": ("time", [0, 0, 0, 0, 0, 1, 1]),
            "near_limit": ("time", np.zeros(7, dtype=int)),
            "outcome": ((), outcome),
        },
        {"time": ("time", time)},
        {"time": "ms", "displacement": "mm", "velocity": "m/s", "drive_voltage": "V"},
    )


def test_every_curve_stands_where_it_belongs():
    data = made_up()
    top, bottom, strip, side = response_figure(data).axes
    time = data["time"].values
    np.testing.assert_array_equal(data_of(top.lines[0]), [time, time**2])
    np.testing.assert_array_equal(data_of(bottom.lines[0]), [time, np.sin(time)])
    # the first half faint, the second in full, joined in the middle
    early, late = side.lines
    np.testing.assert_array_equal(data_of(early), [time[:4] ** 2, 2.0 * time[:4]])
    np.testing.assert_array_equal(data_of(late), [time[3:] ** 2, 2.0 * time[3:]])
    assert early.get_alpha() < 1.0
    assert (early.get_color(), late.get_color()) == (GREY, BLUE)
    assert bottom.lines[0].get_color() == VERMILION
    assert top.get_position().y0 > strip.get_position().y0 > bottom.get_position().y0
    assert side.get_position().x0 > top.get_position().x0


def test_bars_cover_the_times_at_which_the_model_fails():
    strip = response_figure(made_up()).axes[2]
    slack, field = (corners(collection) for collection in strip.collections)
    np.testing.assert_allclose(slack, [[2.0, 3.0, 0.0, 0.6]])
    np.testing.assert_allclose(field, [[5.0, 6.0, 1.0, 1.6]])
    assert strip.get_ylim() == (2.0, -0.4)
    assert [text.xy[1] for text in strip.texts] == [0.3, 0.3, 1.3, 1.3]
    assert [text.get_text() for text in strip.texts] == ["film slack", "29%", "field too high", "29%"]


def test_a_run_that_ended_early_has_a_cross_at_its_end():
    data = made_up(int(Outcome.PULLED_IN))
    data["displacement"][4:] = np.nan
    top = response_figure(data).axes[0]
    np.testing.assert_array_equal(data_of(top.lines[1]), [[3.0], [9.0]])
    assert [text.get_text() for text in top.texts] == ["pulled in"]
    assert len(response_figure(made_up()).axes[0].lines) == 1


def test_the_cross_is_at_the_last_sample_that_ran_and_the_room_behind_it_is_empty():
    """A long run is drawn a little beyond its end."""
    steps = np.arange(40.0)
    run = xr.Dataset(
        {"displacement": ("time", np.where(steps < 24, steps**2, np.nan)), "outcome": int(Outcome.PULLED_IN)},
        coords={"time": 2.0 * steps},
    )
    shown = up_to_end(run)
    assert shown.sizes["time"] == 27
    mark_end(shown, axes := blank())
    np.testing.assert_array_equal(data_of(axes.lines[0]), [[46.0], [23.0**2]])


def test_an_ensemble_has_a_colour_a_member_and_many_are_picked_evenly():
    figure = response_figure(RESPONSES["large ensemble"]())
    assert [axes.lines[0].get_color() for axes in figure.axes[::2]] == list(CYCLE)
    assert figure.get_suptitle() == "6 of 40 members, evenly picked"
    names = [name for name, _ in members(RESPONSES["large ensemble"]())]
    shown = np.linspace(0.1, 1.3, 40)[[0, 7, 15, 23, 31, 39]]
    assert names == [f"voltage {value:.4g}" for value in shown]


def test_the_voltage_of_a_second_film_and_its_states_are_its_own():
    data = made_up()
    time = data["time"].values
    data["second_drive_voltage"] = data["drive_voltage"] * 0.0 + 2.0
    data["second_film_state"] = "time", np.arange(time.size) % 2, {"flag_meanings": "taut hoop_slack"}
    figure = response_figure(data)
    first, second = figure.axes[1].lines
    np.testing.assert_array_equal(data_of(first), [time, np.sin(time)])
    np.testing.assert_array_equal(data_of(second), [time, np.full(time.size, 2.0)])
    (slack,) = [when for name, when in failings(data).items() if name.startswith("2: ")]
    np.testing.assert_array_equal(slack, np.arange(time.size) % 2 == 1)


def test_behind_a_circuit_the_voltage_on_the_film_is_drawn_over_the_commanded_one():
    data = made_up()
    data["film_voltage"] = 0.5 * data["drive_voltage"]
    commanded, own = response_figure(data).axes[1].lines
    np.testing.assert_array_equal(commanded.get_ydata(), data["drive_voltage"])
    np.testing.assert_array_equal(own.get_ydata(), data["film_voltage"])
    assert (commanded.get_color(), own.get_color()) == (GREY, VERMILION)


def test_an_ensemble_of_one_is_drawn_as_a_single_run():
    one, alone = (response_figure(simulate(ConeModel(voltage=v), periods=2)) for v in ([0.5], 0.5))
    assert len(one.axes) == len(alone.axes)
    for own, other in zip(one.axes, alone.axes, strict=True):
        assert [text.get_text() for text in own.texts] == [text.get_text() for text in other.texts]
        for line, same in zip(own.lines, other.lines, strict=True):
            np.testing.assert_array_equal(data_of(line), data_of(same))


def test_each_member_has_its_time_response_and_its_phase_portrait():
    response = RESPONSES["ensemble"]()
    axes = response_figure(response).axes
    for k in range(3):
        x, u = (response[name].values[k] for name in ("displacement", "velocity"))
        settled = len(x) // 2
        np.testing.assert_array_equal(data_of(axes[2 * k].lines[0]), [response["time"], x])
        early, late = axes[2 * k + 1].lines
        np.testing.assert_array_equal(data_of(early), [x[: settled + 1], u[: settled + 1]])
        np.testing.assert_array_equal(data_of(late), [x[settled:], u[settled:]])
