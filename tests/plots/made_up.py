"""Made-up results for the tests of figures, and what stands on a drawn figure as numbers.

Names of variables that results share are written here once.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.text import Text

OUTCOME, REGIME, DOUBTFUL = "outcome", "regime", "doubtful"
EXPONENT = "lyapunov"
LASTING_EXPONENT = "lyapunov"


def result(variables, coords=None, units=None, attrs=None):
    """A Dataset from name -> (dims, values); dimensionless, or with the unit in ``units`` by name."""
    units = units or {}
    described = {}
    for name, (dims, values) in {**variables, **(coords or {})}.items():
        described[name] = (dims, np.array(values), {"units": units.get(name, "1"), "long_name": name})
    data = xr.Dataset({name: described[name] for name in variables}, attrs=attrs or {})
    return data.assign_coords({name: described[name] for name in coords or {}})


def parameter(data, *names):
    """Marks coordinates as parameters that name the members of an ensemble."""
    for name in names:
        data[name].attrs["quantity"] = "parameter"
    return data


def blank():
    """Axes to draw on."""
    return Figure().add_subplot()


def line(axes, label):
    """The one line with a label."""
    (found,) = (one for one in axes.lines if one.get_label() == label)
    return found


def data_of(drawn):
    """x and y of a line without gaps, or the points of a scatter."""
    if hasattr(drawn, "get_offsets"):
        return np.asarray(drawn.get_offsets()).T
    x, y = (np.asarray(values, dtype=float) for values in drawn.get_data())
    seen = np.isfinite(x) & np.isfinite(y)
    return np.array([x[seen], y[seen]])


def corners(collection):
    """Lowest and highest x and y of every path of a collection: (x0, x1, y0, y1) a path."""
    found = []
    for path in collection.get_paths():
        x, y = path.vertices.T
        found.append((x.min(), x.max(), y.min(), y.max()))
    return np.array(found)


def colour(drawn):
    """Colour of a line, or face of a collection, as RGB."""
    from matplotlib.colors import to_rgb

    value = drawn.get_facecolor()[0] if hasattr(drawn, "get_offsets") else drawn.get_color()
    return to_rgb(value)


def cells_of(mesh):
    """Borders in x and y of a mesh and its values, NaN where masked."""
    corner = np.asarray(mesh.get_coordinates())
    values = np.ma.filled(np.ma.asarray(mesh.get_array()).astype(float), np.nan)
    return corner[0, :, 0], corner[:, 0, 1], values


def texts(figure):
    """Everything that is written in a figure."""
    return " | ".join(t.get_text() for t in figure.findobj(lambda a: isinstance(a, Text)) if t.get_text())
