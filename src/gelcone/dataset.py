"""Labelled results: every analysis returns an `xarray.Dataset` that states its contents and how to run it again.

Each variable carries ``long_name``, ``units`` (``1``: dimensionless) and ``quantity``, the scale of a device that
converts it to millimetres, volts or newtons (see `gelcone.devices.si.to_si`). The attributes hold the model's scalar
parameters, the options and gelcone's version; parameters that are arrays are coordinates of the results.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from enum import IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from gelcone._version import __version__
from gelcone.codes import Outcome
from gelcone.earlier import with_names_of_today
from gelcone.errors import InputError, described
from gelcone.files import write_whole, writer_of
from gelcone.netcdf import read_netcdf, write_netcdf
from gelcone.physics.members import Ensemble
from gelcone.physics.model import ConeModel
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

Of = str | type[IntEnum] | Mapping[str, Any]
"""Content of a variable: its quantity, its codes, or a parameter with these attributes."""
Table = Mapping[str, tuple[Any, str, Of]]
"""Variable -> values, long name, content."""
Variable = tuple[tuple[str, ...], Any, str, Of]
"""Dims after the member dims, values, long name, content."""


UNITS = {"angle": "degree"}
"""Units of quantities that have one without a device."""


class Findings(NamedTuple):
    """Results of an analysis for some members: its variables by name, and the outcome of each run (members,)."""

    variables: dict[str, Variable]
    outcome: npt.NDArray[np.int8]


FILM_ERRORS = ("film_error", "gain_error", "capacitance_error")
"""Attributes of results on films that are fitted to states: the stated relative errors of the force, of what a voltage
takes from it, and of the capacitance in runs."""


def film_errors(*models: Ensemble) -> dict[str, float]:
    """The `FILM_ERRORS` of models, each the largest of their films and members; none for films in closed form."""
    fitted = [
        (film.prefix, model.members().own_numbers)
        for model in models
        for film in model.system.films
        if film.prefix + FILM_ERRORS[0] in model.system.numbers
    ]
    with np.errstate(invalid="ignore"):
        return {
            n: max(float(np.fmax.reduce(numbers[p + n], axis=None)) for p, numbers in fitted)
            for n in FILM_ERRORS
            if fitted
        }


def film_errors_of(result: xr.Dataset) -> dict[str, float]:
    """The `FILM_ERRORS` that a result states."""
    return {name: result.attrs[name] for name in FILM_ERRORS if name in result.attrs}


def single_values(model: Ensemble) -> dict[str, Any]:
    """The components of a model and its parameters with one value, as plain data."""
    one = {name: v for name, v in model.parameters().items() if name not in model.values or np.ndim(v) == 0}
    return {name: "inf" if value == np.inf else value for name, value in one.items()}


def member_dims(model: Ensemble) -> tuple[str, ...]:
    """Names of the ensemble's dims: none, ``member``, or ``member_0``, ``member_1``, ..."""
    rank = len(model.shape)
    return ("member",)[:rank] if rank < 2 else tuple(f"member_{i}" for i in range(rank))


def label(
    model: Ensemble,
    variables: Mapping[str, Variable],
    *,
    coords: Mapping[str, Variable] | None = None,
    outcome: Any = None,
    options: Mapping[str, Any],
    title: str,
    errors: Mapping[str, float] | None = None,
) -> xr.Dataset:
    """Labels results of ``model`` as a Dataset.

    A variable whose values have the dims (members, ...) is reshaped to the ensemble; one given with exactly its own
    dims (shared by all members) stays as it is. ``errors`` are the `FILM_ERRORS` of the films that ran, by default
    those of the model.
    """
    import xarray as xr

    import gelcone.accessor  # noqa: F401  (gives Datasets their methods)

    members = member_dims(model)

    def array(spec: Variable) -> xr.DataArray:
        dims, values, long_name, of = spec
        values = np.asarray(values)
        if values.ndim == len(dims) + 1:
            values = values.reshape(model.shape + values.shape[1:])
            dims = members + dims
        return xr.DataArray(values, dims=dims, attrs=attributes(long_name, of))

    parameter_coords = {}
    for name, value in model.values.items():
        if np.ndim(value):
            spread = np.broadcast_to(value, model.shape)
            attrs = attributes(model.system.parameters[name].meaning, "parameter")
            parameter_coords[name] = xr.DataArray(spread.copy(), dims=members, attrs=attrs)
    data = {name: array(spec) for name, spec in variables.items()}
    if outcome is not None:
        data["outcome"] = outcome_array(np.asarray(outcome).reshape(model.shape), members)
    result = xr.Dataset(
        data,
        coords=parameter_coords | {name: array(spec) for name, spec in (coords or {}).items()},
        attrs={
            "title": title,
            "model": json.dumps(single_values(model)),
            "options": json.dumps(dict(options)),
            "gelcone_version": __version__,
            **(film_errors(model) if errors is None else errors),
        },
    )
    return name_dims(result, model.system)


def attributes(long_name: str, of: Of) -> dict[str, Any]:
    """The attributes of a variable; a parameter keeps its meaning unless one is given."""
    if isinstance(of, str):
        return {"long_name": long_name, "units": UNITS.get(of, "1"), "quantity": of}
    if isinstance(of, Mapping):
        return {**of, **({"long_name": long_name} if long_name else {})}
    return attributes(long_name, "flag") | flags(of)


NAN, INFINITE = "nan_means", "infinite_means"
"""Attributes that explain a variable's values that are not finite."""


def absent(quantity: str, nan: str = "not applicable", infinite: str = "not reached") -> dict[str, str]:
    """The attributes of a variable with missing values: the words for NaN and infinity."""
    return {"units": "1", "quantity": quantity, NAN: nan, INFINITE: infinite}


STATES = "state_quantities"
"""Attribute of a variable over states: the quantity of each state."""


def of_states(system: ConeSystem) -> dict[str, str]:
    """The attributes of a variable with last dim ``state``, each state in its own quantity."""
    return {"units": "1", "quantity": "state", STATES: ", ".join(state.quantity for state in system.states)}


NUMBERED = {
    "harmonic": "multiple of the drive frequency",
    "fate": "rank of the end of nearby starts, 1 for the most frequent",
}
"""Dims whose entries are numbered from 1, and the meaning of the number."""


def name_dims(result: xr.Dataset, system: ConeSystem) -> xr.Dataset:
    """Adds the coordinates of dims with the same entries in every result: states by name, numbered ones, bounds."""
    known: dict[str, tuple[Sequence[Any], str, str]] = {
        "state": ([state.name for state in system.states], "state", "code"),
        "bound": (("lowest", "highest"), "end of the range that was searched", "code"),
    }
    known |= {n: (range(1, result.sizes.get(n, 0) + 1), meaning, "count") for n, meaning in NUMBERED.items()}
    coords = {
        dim: (dim, np.array(values), attributes(meaning, quantity))
        for dim, (values, meaning, quantity) in known.items()
        if dim in result.sizes
    }
    return result.assign_coords(coords)


def columns(dims: str | tuple[str, ...], table: Table) -> dict[str, Any]:
    """Variables with the same dims, as `Dataset.assign` takes them, from a table of values, long names and contents."""
    return {name: (dims, np.asarray(values), attributes(meaning, of)) for name, (values, meaning, of) in table.items()}


def flags(codes: type[IntEnum]) -> dict[str, Any]:
    """The CF attributes of a variable that holds these codes."""
    return {
        "flag_values": np.array([code.value for code in codes], dtype=np.int8),
        "flag_meanings": " ".join(code.name.lower() for code in codes),
    }


def flags_of(names: Sequence[str]) -> dict[str, Any]:
    """The CF attributes of a variable that holds indices into ``names``."""
    return {"flag_values": np.arange(len(names), dtype=np.int8), "flag_meanings": " ".join(names)}


def outcome_array(values: Any, dims: tuple[str, ...]) -> xr.DataArray:
    """Outcome codes as a CF flag variable."""
    import xarray as xr

    return xr.DataArray(np.asarray(values, dtype=np.int8), dims=dims, attrs=OUTCOME_ATTRIBUTES)


OUTCOME_ATTRIBUTES = attributes("how the run of the member ended", Outcome)


def model_of(dataset: xr.Dataset) -> ConeModel:
    """The model that a Dataset was computed from; `InputError` if the Dataset does not state it."""
    if "model" not in dataset.attrs:
        raise InputError("the Dataset does not say which model it was computed from; give a result of gelcone")
    parameters = {k: np.inf if v == "inf" else v for k, v in json.loads(dataset.attrs["model"]).items()}
    swept = [coord for coord in dataset.coords.values() if coord.attrs.get("quantity") == "parameter"]
    if swept:
        import xarray as xr

        for coord, spread in zip(swept, xr.broadcast(*swept), strict=True):
            parameters[str(coord.name)] = spread.values
    return ConeModel.from_parameters(parameters)


def save(dataset: xr.Dataset | Savable, path: str | Path, *, force: bool = False) -> None:
    """Write a Dataset as netCDF-4, or a device as a device file (TOML). The file appears whole or not at all.

    Parameters
    ----------
    dataset : a result, or a `Device`.
    path : name of the file; folders above it are made.
    force : whether a file that exists is overwritten. Default no.

    Raises
    ------
    InputError : for a file that exists, and a folder that cannot be written.

    Examples
    --------
    >>> import gelcone, tempfile
    >>> path = tempfile.mkdtemp() + "/mine.toml"
    >>> gelcone.save(gelcone.find_device("biased-pump").replace(spring_rate="16 N/m"), path)
    >>> gelcone.find_device(path).spring_rate
    16.0
    """
    if isinstance(dataset, Savable):
        write_whole(Path(path), writer_of(dataset.to_toml()), force=force)
    elif hasattr(dataset, "data_vars"):
        write_whole(Path(path), lambda to: write_netcdf(dataset, to), force=force)
    else:
        raise InputError(f"save: was given {described(dataset)}; give a result of an analysis, or a device")


@runtime_checkable
class Savable(Protocol):
    """An object that writes itself as a device file: a device."""

    def to_toml(self) -> str:
        """The text of a device file."""


def load(path: str | Path) -> xr.Dataset:
    """Read a Dataset that `save` wrote, equal to the original; variables of earlier versions get the names of today.

    Parameters
    ----------
    path : the netCDF file.

    Returns
    -------
    The Dataset with its units, model and options.

    Raises
    ------
    InputError : for a file that is missing, or that gelcone did not write.

    Examples
    --------
    >>> import gelcone, tempfile
    >>> path = tempfile.mkdtemp() + "/run.nc"
    >>> response = gelcone.simulate(gelcone.ConeModel(), periods=1)
    >>> gelcone.save(response, path)
    >>> gelcone.load(path).identical(response), response.sizes["time"]
    (True, 101)
    """
    import gelcone.accessor  # noqa: F401  (gives Datasets their methods)

    try:
        return with_names_of_today(read_netcdf(Path(path)))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except InputError as error:
        raise InputError(f"{path}: {error}; run it again, or open it with xarray.open_dataset") from None
    except (KeyboardInterrupt, MemoryError):
        raise
    except Exception as error:  # damaged files raise many kinds of errors
        reason = " ".join(str(error).split())
        raise InputError(f"{path}: is not a readable netCDF-4 file ({reason}); give one that gelcone wrote") from None


def with_initial(result: xr.Dataset, model: Ensemble, states0: Array) -> xr.Dataset:
    """Adds the initial states (members, N) to ``result``."""
    result["initial"] = (
        (*member_dims(model), "state"),
        states0.reshape((*model.shape, states0.shape[-1])),
        {"long_name": "initial states"} | of_states(model.system),
    )
    return name_dims(result, model.system)
