"""A device that left gelcone as C, compiled by this machine's compiler and called from Python."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import gelcone
from gelcone.export.compiler import find_compiler
from gelcone.export.sources import Exported, sources

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
RAW = """
#include "{name}.c"
int raw(const double *numbers, double length, double *z, double *switches) {{
  static instance m;
  double reached;
  int k, status;
  begin(&m);
  for (k = 0; k < N_NUMBERS; ++k) m.numbers[k].d = numbers[k];
  for (k = 0; k < N_STATES; ++k) m.s.z[k].d = z[k];
  for (k = 0; k < N_SWITCHES; ++k) m.s.switches[k].d = switches[k];
  status = (int)run(&m, length, &reached);
  for (k = 0; k < N_STATES; ++k) z[k] = m.s.z[k].d;
  for (k = 0; k < N_SWITCHES; ++k) switches[k] = m.s.switches[k].d;
  return status;
}}
{name} *make(void) {{ static {name} all[64]; static int count; return &all[count++ % 64]; }}
int size(void) {{ return (int)sizeof({name}); }}
double closed(int k) {{ static instance m; begin(&m); return m.numbers[k].d; }}
"""
"""Access to what the public functions hide: a run of given numbers, and the numbers of the formulas."""


def compiled(exported: Exported, folder: Path, *flags: str) -> ctypes.CDLL:
    """The library of an exported device, compiled without a warning."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in sources(exported).items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "raw.c").write_text(RAW.format(name=exported.name), encoding="utf-8")
    command = [*find_compiler(), *STRICT, *(flags or ("-O1",)), "-fPIC", "-shared", "-o", "raw.so", "raw.c", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:2000]
    return ctypes.CDLL(str(folder / "raw.so"))


class Instance:
    """An instance with the five functions, by names of variables."""

    def __init__(self, exported: Exported, library: ctypes.CDLL) -> None:
        self.names = [variable.name for variable in exported.variables]
        pointer, self._size = ctypes.c_void_p, library.size()
        own = {name: getattr(library, f"{exported.name}_{name}") for name in ("init", "set", "get", "step", "words")}
        own["init"].argtypes, own["init"].restype = [pointer], None
        own["set"].argtypes = [pointer, ctypes.c_int, ctypes.c_double]
        own["get"].argtypes, own["get"].restype = [pointer, ctypes.c_int], ctypes.c_double
        own["step"].argtypes = [pointer, ctypes.c_double]
        own["words"].restype = ctypes.c_char_p
        library.make.restype = pointer
        self._own, self._at = own, library.make()
        own["init"](self._at)

    def set(self, name: str, value: float) -> int:
        return self._own["set"](self._at, self.names.index(name), value)

    def __getitem__(self, name: str) -> float:
        return self._own["get"](self._at, self.names.index(name))

    def step(self, seconds: float) -> int:
        return self._own["step"](self._at, seconds)

    def words(self, outcome: int) -> str:
        return self._own["words"](outcome).decode()

    def stored(self) -> bytes:
        return ctypes.string_at(self._at, self._size)

    def restore(self, data: bytes) -> None:
        ctypes.memmove(self._at, data, self._size)


def device(name: str = "biased-pump", **changes: object) -> gelcone.Device:
    return gelcone.find_device(name).replace(**changes)
