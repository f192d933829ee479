"""What an analysis finds does not depend on the instruction set: the same bits with AVX-512 as on a Haswell without."""

import os
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from gelcone.motion.engine import compile as compiler

SOURCE = Path(__file__).parents[3] / "src"
HASWELL = """
from gelcone.motion.engine import compile as compiler

machine = compiler.Machine(compiler.host().triple, "haswell", "")
compiler.host = lambda: machine
"""
FINDS = """
import gelcone

model = gelcone.ConeModel(
    voltage=[0.5, 1.2, 1.7], damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3, voltage_bias=0.1
)
found = gelcone.regime(model, budget=2000.0)
run = gelcone.simulate(model, periods=200)
for result in (found, run):
    for name, variable in sorted(result.variables.items()):
        print(name, variable.values.tobytes().hex())
"""


@pytest.mark.skipif(compiler.host().vector != 8, reason="this machine has one vector width only")
def test_an_analysis_gives_the_same_bits_with_and_without_avx_512(tmp_path):
    """NumPy is kept from AVX-512, too: its own functions must not make a difference either."""
    with redirect_stdout(StringIO()) as wide:
        exec(FINDS, {})
    own = {"PYTHONPATH": str(SOURCE), "GELCONE_CACHE": str(tmp_path)}
    own |= {"NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX AVX512_CLX"}
    narrow = subprocess.run(
        [sys.executable, "-c", HASWELL + FINDS], env=os.environ | own, capture_output=True, text=True, check=True
    ).stdout
    assert len(wide.getvalue()) > 100_000
    pairs = zip(wide.getvalue().splitlines(), narrow.splitlines(), strict=True)
    assert [one.split(" ")[0] for one, other in pairs if one != other] == []
