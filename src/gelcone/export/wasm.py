"""A device as WebAssembly, with a small JavaScript interface and a page that runs it."""

from __future__ import annotations

import html
import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

from gelcone._version import __version__
from gelcone.errors import MissingDependency
from gelcone.export.compiler import compiled
from gelcone.export.sources import Exported, filled, in_comment, sources
from gelcone.files import check_writable, write_together, writer_of

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-s")
_SYSTEM = Path("/usr/include/wasm32-wasi")


def write_wasm(exported: Exported, path: Path, force: bool) -> list[Path]:
    """Write the module, its JavaScript and a page next to it, all named after the module.

    Raises `MissingDependency` without a compiler for WebAssembly.
    """
    name = exported.name
    paths = [path.with_name(f"{name}.{ending}") for ending in ("wasm", "js", "html")]
    check_writable(paths, force=force)
    module = _compiled(exported)
    title = "".join(c for c in exported.device.name if c.isprintable())
    variables = {variable.name: k for k, variable in enumerate(exported.variables)}
    device = exported.device
    peak = float(exported.model.peak_voltage) * exported.scale_values["voltage"]
    script = {
        "VARIABLES_TABLE": json.dumps(variables, indent=2),
        "DEVICE_TITLE": in_comment(title),
        "GELCONE_VERSION": __version__,
    }
    field = 'own.get("true_field") / (strength || Infinity)' if "true_field" in exported.outputs else "0"
    page = {
        "DEVICE_TITLE": html.escape(title),
        "DEVICE_MOST": f"{1.5 * peak:.0f}",
        "DEVICE_BEGIN": f"{0.0 if exported.inside else abs(float(device.voltage_offset)):.0f}",
        "RADII": json.dumps([float(device.disc_radius), float(device.film_radius)]),
        "FIELD_READ": field,
    }
    texts = [filled("device.js", name, script), filled("device.html", name, page)]
    contents = [module, *(text.encode() for text in texts)]
    write_together({place: writer_of(data) for place, data in zip(paths, contents, strict=True)}, force=force)
    return paths


def find_compiler() -> list[str]:
    """Find the command of a compiler for WebAssembly; `MissingDependency` without one."""
    if importlib.util.find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-wasi", "-mexec-model=reactor"]
    target = ("clang", "--target=wasm32-wasi")
    if shutil.which("clang") and shutil.which("wasm-ld") and _SYSTEM.is_dir() and _has_builtins(target):
        linked = ("-nostartfiles", "-Wl,--no-entry", "-Wl,-z,stack-size=1048576")
        return [*target, "-isystem", str(_SYSTEM), *linked]
    raise MissingDependency(
        "WebAssembly needs a compiler: pip install 'gelcone[platforms]', or on Debian apt install clang lld wasi-libc "
        "libclang-rt-dev-wasm32"
    )


def _has_builtins(target: tuple[str, ...]) -> bool:
    """Whether clang has its runtime functions for WebAssembly, which Debian packages separately."""
    command = [*target, "-rtlib=compiler-rt", "-print-libgcc-file-name"]
    named = subprocess.run(command, capture_output=True, text=True, check=False)
    return named.returncode == 0 and Path(named.stdout.strip()).is_file()


def _compiled(exported: Exported) -> bytes:
    """Compile the module."""
    command = [*find_compiler(), *FLAGS, "-o", "module.wasm", "wasm.c", "-lm"]
    texts = sources(exported) | {"wasm.c": filled("wasm.c", exported.name, {})}
    return compiled(command, texts, "module.wasm", "does not make WebAssembly of the source ({}); install ziglang")
