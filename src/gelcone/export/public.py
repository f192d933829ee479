"""The public function `export`, which writes results and devices for other programs."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
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


def export(
    what: xr.Dataset | Device,
    path: str | Path,
    *,
    fmi: int = 2,
    platforms: Sequence[str] = (HOST,),
    drive: str | None = None,
    tolerance: float = TOLERANCE,
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
    fmi : version of the FMU's standard, 2 or 3. Default 2.
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
    InputError : for other suffixes, files that exist, a folder that cannot be written, ensembles, and devices whose
        drive or components cannot be exported.
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
    if not isinstance(what, Device):
        if drive is not None:
            raise InputError(f"drive = {drive!r}: is an option of devices, and this is a result; leave it out")
        return interchange.export(what, path, force=force)
    if drive is not None and drive not in DRIVES:
        raise unknown_name("drive", drive, DRIVES)
    if drive == "sine" and what.to_model().system.waveform.name != "sine":
        raise InputError("drive = 'sine': the waveform of the device is another; give drive = 'own', or leave it out")
    check_flow(tolerance, None)
    if fmi not in VERSIONS:
        raise InputError(f"fmi = {fmi!r}: must be 2 or 3, the version of the standard")
    if path.suffix not in ("", FMU, WASM):
        raise InputError(f"{path}: a device is written to NAME{FMU}, NAME{WASM} or a folder for C without an ending")
    exported = Exported(what, c_name(path.stem), drive is not None, float(tolerance))
    if path.suffix == FMU:
        check_writable([path], force=force)
        if not write_fmu(exported, path, fmi, platforms, force):
            warnings.warn(f"{path}: holds sources only, for there is no C compiler here", DoubtfulInput, stacklevel=2)
        return [path]
    if path.suffix == WASM:
        return write_wasm(exported, path, force)
    return _write_c(exported, path, force)


def _write_c(exported: Exported, folder: Path, force: bool) -> list[Path]:
    """Write the sources, an example, a test and the device file in a folder."""
    name = exported.name
    names = (f"{name}.h", f"{name}.c", "example.c", "test.c", "device.toml")
    check_writable([folder / own for own in names], force=force)
    texts = sources(exported) | {
        "example.c": example(exported),
        "test.c": test_program(exported),
        "device.toml": exported.device.to_toml(),
    }
    writers: dict[Path, Callable[[Path], Any]] = {folder / own: writer_of(texts[own]) for own in names}
    write_together(writers, force=force)
    return list(writers)
