"""Made-up results with values of one's own, and edits of them."""

import numpy as np
import xarray as xr

from gelcone.codes import Outcome, Regime
from gelcone.dataset import flags

CODES = {"outcome": Outcome, "regime": Regime}


def made(variables, coords=None, **attrs):
    """A Dataset of name -> value, (dims, values) or (dims, values, unit)."""
    own = {
        name: given if isinstance(given, xr.DataArray) else labelled(given)
        for name, given in {**variables, **(coords or {})}.items()
    }
    for name in own.keys() & CODES.keys():
        own[name] = own[name].assign_attrs(flags(CODES[name]))
    return xr.Dataset({n: own[n] for n in variables}, {n: own[n] for n in coords or {}}, attrs)


def labelled(given):
    if not isinstance(given, tuple):
        return xr.DataArray(given, attrs={"units": "1"})
    dims, values, *unit = given
    return xr.DataArray(np.array(values), dims=[dims] if isinstance(dims, str) and dims else dims or (), attrs={
        "units": unit[0] if unit else "1"
    })  # fmt: skip


def coded(dims, values, names):
    own = labelled((dims, values))
    return own.assign_attrs(flag_values=np.arange(len(names)), flag_meanings=" ".join(names))


def edited(shown, **changes):
    """The same with other values of some variables."""
    return shown.assign(
        {n: shown[n].copy(data=np.broadcast_to(np.array(v), shown[n].shape)) for n, v in changes.items()}
    )
