"""The figure of results that have none of their own."""

from itertools import pairwise

import numpy as np
import xarray as xr

import gelcone
from gelcone.plots.values import values_figure


def test_whole_numbers_have_whole_ticks_and_labels_fit_their_panel():
    harmonics = xr.DataArray([0.3, 0.1, 0.0, 0.0], dims="harmonic", attrs={"units": "mm"})
    result = xr.Dataset({"harmonic_amplitude": harmonics}, coords={"harmonic": [1, 2, 3, 4]})
    (axes,) = values_figure(result).axes
    ticks = axes.get_xticks()
    np.testing.assert_array_equal(ticks, np.round(ticks))
    assert axes.get_ylabel() == "harmonic amplitude\n(mm)"
    assert axes.lines[0].get_linestyle() == "None"  # there is nothing between two harmonics
    (stems,) = axes.collections
    assert [stem[:, 1].tolist() for stem in stems.get_segments()] == [[0.0, 0.3], [0.0, 0.1], [0.0, 0.0], [0.0, 0.0]]


def varied(**axes):
    """Two numbers of an ensemble of three members, whose parameters are along one dim."""
    coords = {
        name: ("member", values, {"quantity": "parameter", "units": unit}) for name, (values, unit) in axes.items()
    }
    return xr.Dataset(
        {
            "stroke": ("member", [1.0, 2.0, 4.0], {"units": "mm"}),
            "code": ("member", [0, 1, 2], {"flag_values": [0, 1, 2]}),
        },
        coords=coords,
    )


def test_members_are_drawn_over_the_parameter_that_varies():
    """Not over one that all of them share; and over none where none varies."""
    result = varied(voltage=([300.0] * 3, "V"), frequency=([5.0, 6.0, 8.0], "Hz"))
    (axes,) = values_figure(result).axes
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_xydata(), [[5.0, 1.0], [6.0, 2.0], [8.0, 4.0]])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("frequency (Hz)", "stroke (mm)")
    alone = values_figure(varied(voltage=([300.0] * 3, "V")))
    assert [text.get_text() for text in alone.axes[0].texts] == ["stroke: 1, 2, 4 mm"]


def test_members_of_a_device_are_drawn_over_the_field_that_varies():
    """Also where the gel varies, which is a name, and not over the harmonics."""
    device = gelcone.find_device("biased-pump").replace(film="taut", film_thickness=[1.8e-4, 2e-4, 2.2e-4])
    panels = values_figure(gelcone.settled(device)).axes
    assert panels[0].get_ylabel() == "stroke (mm)"
    assert panels[-1].get_xlabel() == "film thickness (mm)"
    np.testing.assert_allclose(panels[0].lines[0].get_xdata(), [0.18, 0.2, 0.22])
    result = varied(frequency=([5.0, 6.0, 8.0], "Hz"))
    result = result.assign_coords(material=("member", ["a", "b", "c"], {"quantity": "device field"}))
    assert values_figure(result[["stroke", "code"]]).axes[0].get_xlabel() == "frequency (Hz)"
    only_gels = result.drop_vars("frequency")
    assert [text.get_text() for text in values_figure(only_gels).axes[0].texts] == ["stroke: 1, 2, 4 mm"]


def test_a_number_that_is_missing_has_no_unit():
    attrs = {"units": "V", "long_name": "pull-in", "nan_means": "not searched", "infinite_means": "not reached"}
    numbers = {"one": np.nan, "two": np.inf, "three": [np.inf, 2.5], "four": 1234.5678}
    result = xr.Dataset(
        {name: (("k",) * np.ndim(value), value, attrs) for name, value in numbers.items() if name != "three"}
    )
    result["three"] = ("k", numbers["three"], attrs)
    texts = [text.get_text() for text in values_figure(result).axes[0].texts]
    assert texts == [
        "pull-in: 1234.6 V",
        "pull-in: not reached, 2.5 V",
    ]
    alone = values_figure(result[["one", "two"]])
    assert [text.get_text() for text in alone.axes[0].texts] == ["pull-in: not searched", "pull-in: not reached"]


def test_single_numbers_of_one_unit_are_bars_and_what_has_no_value_is_left_out():
    meanings = {"first": 1200.0, "second": 3400.0, "third": np.inf}
    result = xr.Dataset({name: ((), v, {"units": "V", "long_name": f"the {name}"}) for name, v in meanings.items()})
    (axes,) = values_figure(result).axes
    assert [bar.get_width() for bar in axes.patches] == [1200.0, 3400.0]
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["the first", "the second"]
    assert axes.get_ylim()[0] > axes.get_ylim()[1]  # the first on top
    assert axes.get_xlabel() == "value (V)"
    other = result.assign(force=((), 2.0, {"units": "N", "long_name": "a force"}))
    assert [text.get_text() for text in values_figure(other).axes[0].texts] == [
        "the first: 1200 V", "the second: 3400 V", "a force: 2 N",
    ]  # fmt: skip


def test_widths_have_no_bars_beside_limits_and_one_far_above_the_others_leaves_the_axis():
    volts = {"slack": 900.0, "pull_in": 1400.0, "stretch_limit": 18e3, "driven_error": 3.0, "examined_step": 70.0}
    result = xr.Dataset({f"{name}_voltage": ((), value, {"units": "V"}) for name, value in volts.items()})
    (axes,) = values_figure(result).axes
    assert [bar.get_width() for bar in axes.patches] == [900.0, 1400.0, 1400.0]
    assert [text.get_text() for text in axes.texts] == ["900 V", "1400 V", "1.8e+04 V →"]


def test_long_meanings_take_more_lines_and_none_leaves_the_figure_or_meets_another():
    names = {"one": "short", "two": " ".join(["constant voltage at which a film"] * 6), "three": "short, too"}
    result = xr.Dataset({name: ((), 1.0, {"long_name": meaning}) for name, meaning in names.items()})
    figure = values_figure(result)
    figure.draw_without_rendering()
    assert not figure.axes[0].axison
    texts = figure.axes[0].texts
    assert [" ".join(text.get_text().split()) for text in texts] == [f"{meaning}: 1" for meaning in names.values()]
    boxes = [text.get_window_extent() for text in texts]
    assert all(figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1 for box in boxes)
    assert all(above.y0 > below.y1 for above, below in pairwise(boxes))
    assert boxes[1].height > 2.5 * boxes[0].height


def test_each_other_entry_of_a_number_is_a_curve_over_the_axis():
    """Also where the axis is the last dim; up to six of them."""
    values = np.arange(24.0).reshape(8, 3)
    coords = {"time": ("time", [1.0, 2.0, 4.0], {"units": "s"})}
    for dims, own in ((("state", "time"), values), (("time", "state"), values.T)):
        (axes,) = values_figure(xr.Dataset({"stroke": (dims, own)}, coords)).axes
        found = [line.get_xydata().tolist() for line in axes.lines]
        assert found == [[[x, y] for x, y in zip((1.0, 2.0, 4.0), row, strict=True)] for row in values[:6]]
        assert axes.get_xlabel() == "time (s)"


def names_of(axes):
    legend = axes.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


def test_curves_of_a_panel_are_named_by_what_they_are_for():
    """By the harmonic over a field that varies, by the gel over harmonics; one curve has no name."""
    values = xr.DataArray([[1.0, 2.0], [3.0, 5.0], [4.0, 8.0]], dims=("member", "harmonic"), attrs={"units": "mm"})
    result = varied(frequency=([5.0, 6.0, 8.0], "Hz")).assign(harmonic_amplitude=values, harmonic=[1, 2])
    one, many = values_figure(result).axes
    assert (names_of(one), names_of(many)) == ([], ["harmonic 1", "harmonic 2"])
    assert [line.get_ydata().tolist() for line in many.lines] == [[1.0, 3.0, 4.0], [2.0, 5.0, 8.0]]
    gels = xr.Dataset({"harmonic_amplitude": values}, coords={"harmonic": [1, 2]})
    gels = gels.assign_coords(material=("member", ["a", "b", "c"], {"quantity": "device field"}))
    (axes,) = values_figure(gels).axes
    assert names_of(axes) == ["material a", "material b", "material c"]


def test_stems_of_two_members_stand_side_by_side():
    values = xr.DataArray([[0.3, 0.1], [0.2, 0.4]], dims=("member", "harmonic"), attrs={"units": "mm"})
    (axes,) = values_figure(xr.Dataset({"harmonic_amplitude": values}, coords={"harmonic": [1, 2]})).axes
    found = [line.get_xydata().tolist() for line in axes.lines[:2]]
    for stems, ends in zip(axes.collections, found, strict=True):
        assert [stem[1].tolist() for stem in stems.get_segments()] == ends
    left, right = (np.array(ends) for ends in found)
    assert (right[:, 0] > left[:, 0]).all()
    np.testing.assert_allclose((left + right)[:, 0] / 2.0, [1.0, 2.0])
    np.testing.assert_array_equal([left[:, 1], right[:, 1]], values)


def test_a_number_that_is_the_same_all_along_has_no_panel_beside_one_that_varies():
    result = varied(frequency=([5.0, 6.0, 8.0], "Hz")).assign(period=("member", [1, 1, 1]))
    assert [axes.get_ylabel() for axes in values_figure(result).axes] == ["stroke (mm)"]
    result["stroke"] = result["stroke"].copy(data=[2.0, np.nan, 2.0])
    assert [axes.get_ylabel() for axes in values_figure(result).axes] == ["stroke (mm)", "period"]
