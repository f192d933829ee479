"""What an analysis finds does not depend on the instruction set: the same bits with AVX-512 as on a Haswell without."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gelcone.motion.engine import compile as compiler

SOURCE = Path(__file__).parents[3] / "src"
FINDS = """
import sys
import gelcone
from gelcone.motion.engine import compile as compiler

if sys.argv[1] != "host":
    machine = compiler.Machine(compiler.host().triple, sys.argv[1], "")
    compiler.host = lambda: machine
model = gelcone.ConeModel(
    voltage=[0.5, 1.2, 1.7], damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3, voltage_bias=0.1
)
found = gelcone.regime(model, budget=2000.0)
run = gelcone.simulate(model, periods=200)
for result in (found, run):
    for name, variable in sorted(result.variables.items()):
        print(name, variable.values.tobytes().hex())
"""


def finds(processor, tmp_path, **environment):
    """What a fresh process with code for this processor prints."""
    own = {"PYTHONPATH": str(SOURCE), "GELCONE_CACHE": str(tmp_path / processor)}
    command = [sys.executable, "-c", FINDS, processor]
    return subprocess.run(
        command, env=os.environ | own | environment, capture_output=True, text=True, check=True
    ).stdout


@pytest.mark.skipif(compiler.host().vector != 8, reason="this machine has one vector width only")
def test_an_analysis_gives_the_same_bits_with_and_without_avx_512(tmp_path):
    """NumPy is kept from AVX-512, too: its own functions must not make a difference either."""
    wide = finds("host", tmp_path)
    narrow = finds("haswell", tmp_path, NPY_DISABLE_CPU_FEATURES="AVX512F AVX512CD AVX512_SKX AVX512_CLX")
    assert len(wide) > 100_000
    different = [a.split(" ")[0] for a, b in zip(wide.splitlines(), narrow.splitlines(), strict=True) if a != b]
    assert different == []
