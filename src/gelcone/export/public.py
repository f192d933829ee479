"""The public function `export`, which writes results and devices for other programs."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gelcone import interchange
from gelcone.devices.device import Device
from gelcone.errors import DoubtfulInput, InputError, check_path, unknown_name
from gelcone.export.fmu import HOST, VERSIONS, write_fmu
from gelcone.export.names import c_name
from gelcone.export.reference import test_program
from gelcone.export.sources import Exported, example, sources
from gelcone.export.wasm import write_wasm
from gelcone.files import check_writable, write_together, writer_of
from gelcone.motion.flow import check_flow

if TYPE_CHECKING:
    import xarray as xr

TOLERANCE = 1e-7
"""Relative error of a step; the displacement is then right to about 1e-9 of the stroke."""
FMU, WASM = ".fmu", ".wasm"
DRIVES = ("own", "sine")
OF_DEVICE = "belongs to the export of a device, and this is a result; leave it out"
"""The reason why an option is refused with a result."""


def export(
    what: xr.Dataset | Device,
    path: str | Path,
    *,
    fmi: int | None = None,
    platforms: Sequence[str] | None = None,
    drive: str | None = None,
    tolerance: float | None = None,
    force: bool = False,
) -> list[Path]:
    """Write a result as tables or for MATLAB, or a device as C, FMU or WebAssembly.

    Parameters
    ----------
    what : a Dataset that an analysis returned or `gelcone.load` read, or a `Device` of single numbers.
    path : for a result a name that ends in ``.csv``, ``.mat`` or ``.parquet``: a table holds the variables of the same
        dims, and variables of other dims go to files with these before the suffix, as in ``run.time.csv``. For a device
        a name that ends in ``.fmu`` or ``.wasm``, next to which a JavaScript interface and a page are written, or a
        folder for C: header, source, example, test program and device file. The model has the name of the file or
        folder, with the prefix ``device_`` if C or the sources use that name.
    fmi : version of the FMU's standard, 2 or 3. Default 2. Of FMUs, as ``platforms``; a result has none of the options
        but ``force``.
    platforms : machines for which an FMU holds libraries, besides its sources: ``"host"``, this one (default), and with
        the package ziglang ``"linux"``, ``"linux-arm"``, ``"windows"``, ``"macos"`` and ``"macos-arm"``.
    drive : ``"own"`` includes the drive of the device, to which the input voltage is added; ``"sine"`` does so for a
        sine alone. Default None: the input is the whole voltage.
    tolerance : relative error of one step of the integrator. Default 1e-7.
    force : whether files that exist are overwritten. Default no.

    Returns
    -------
    The files written. In tables columns are ``name (unit)`` and codes are words; a MATLAB file holds the variables as
    arrays, and their units, dims and long names in structs.

    Raises
    ------
    InputError : for other suffixes, options that the form does not have, files that exist, a folder that cannot be
        written, ensembles, and devices whose drive or components cannot be exported.
    MissingDependency : for Parquet without pyarrow, and for WebAssembly and other machines without their compiler.

    Examples
    --------
    >>> import gelcone, tempfile
    >>> response = gelcone.simulate(gelcone.ConeModel(), periods=1)
    >>> files = gelcone.export(response, tempfile.mkdtemp() + "/run.csv")
    >>> [path.name for path in files]
    ['run.time.csv', 'run.csv', 'run.state.csv']
    >>> len(files[0].read_text().splitlines())
    102
    """
    check_path("export", path)
    path = Path(path)
    of_fmu = {"fmi": fmi, "platforms": platforms}
    if not isinstance(what, Device):
        _refuse(of_fmu | {"drive": drive, "tolerance": tolerance}, OF_DEVICE)
        return interchange.export(what, path, force=force)
    if drive is not None and drive not in DRIVES:
        raise unknown_name("drive", drive, DRIVES)
    if drive == "sine" and what.to_model().system.waveform.name != "sine":
        raise InputError("drive = 'sine': the waveform of the device is another; give drive = 'own', or leave it out")
    tolerance = TOLERANCE if tolerance is None else tolerance
    check_flow(tolerance, None)
    if path.suffix not in ("", FMU, WASM):
        raise InputError(f"{path}: a device is written to NAME{FMU}, NAME{WASM} or a folder for C without an ending")
    if path.suffix != FMU:
        _refuse(of_fmu, f"belongs to an FMU, and {path.name} is none; leave it out, or write to NAME{FMU}")
    exported = Exported(what, c_name(path.stem), drive is not None, float(tolerance))
    if path.suffix == FMU:
        version = VERSIONS[0] if fmi is None else fmi
        if version not in VERSIONS:
            raise InputError(f"fmi = {fmi!r}: must be 2 or 3, the version of the standard")
        check_writable([path], force=force)
        if not write_fmu(exported, path, version, (HOST,) if platforms is None else platforms, force):
            warnings.warn(f"{path}: holds sources only, for there is no C compiler here", DoubtfulInput, stacklevel=2)
        return [path]
    if path.suffix == WASM:
        return write_wasm(exported, path, force)
    return _write_c(exported, path, force)


def _refuse(options: Mapping[str, Any], why: str) -> None:
    """Raise `InputError` with the first option that is given."""
    for name, value in options.items():
        if value is not None:
            raise InputError(f"{name} = {value!r}: {why}")


def _write_c(exported: Exported, folder: Path, force: bool) -> list[Path]:
    """Write the sources, an example, a test and the device file in a folder."""
    name = exported.name
    names = (f"{name}.h", f"{name}.c", "example.c", "test.c", "device.toml")
    check_writable([folder / file for file in names], force=force)
    texts = sources(exported) | {
        "example.c": example(exported),
        "test.c": test_program(exported),
        "device.toml": exported.device.to_toml(),
    }
    writers: dict[Path, Callable[[Path], Any]] = {folder / file: writer_of(texts[file]) for file in names}
    write_together(writers, force=force)
    return list(writers)
