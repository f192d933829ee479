"""The job scripts of the guide: their commands are taken, and with Slurm's own replaced they run, end and resume."""

from __future__ import annotations

import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.atlas.store import Status

GUIDE = Path(__file__).parents[2] / "docs" / "slurm.md"
SCRIPTS = re.findall(r"```bash\n(.*?)```", GUIDE.read_text(encoding="utf-8"), flags=re.DOTALL)
SMALL = {
    "biased-pump --over": "biased-pump --film taut --over",
    "5 Hz:20 Hz:512": "5 Hz:20 Hz:56",
    "0.1 kV:1 kV:512": "0.1 kV:1 kV:56",
}
COMMANDS = {
    "gelcone": '#!/bin/bash\nexec "{python}" -m gelcone "$@"\n',
    "dask": '#!/bin/bash\nexec "{python}" -m dask "$@"\n',
    "srun": '#!/bin/bash\nexec "$@"\n',
    "scontrol": '#!/bin/bash\necho "$@" >> requeued\n',
}


def test_there_are_two_scripts_for_the_shell_and_one_for_python():
    assert len(SCRIPTS) == 2
    (text,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), flags=re.DOTALL)
    compile(text, "slurm.md", "exec")


needs_bash = pytest.mark.skipif(sys.platform == "win32" or not shutil.which("bash"), reason="there is no bash here")


@needs_bash
@pytest.mark.parametrize("script", SCRIPTS, ids=["node", "nodes"])
def test_a_script_is_one_for_the_shell_and_its_commands_are_taken(script):
    done = subprocess.run(["bash", "-n"], input=script, text=True, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    for line in re.findall(r"gelcone (map .*?) &$", script.replace("\\\n", " "), flags=re.MULTILINE):
        words = {re.sub(r"=.*", "", word) for word in line.split() if word.startswith("--")}
        assert words <= {"--resume", "--over", "--workers", "--scheduler", "--store", "--out", "--force"}


@needs_bash
@pytest.mark.parametrize("script", SCRIPTS, ids=["node", "nodes"])
@pytest.mark.parametrize(("left", "taken"), [(None, "--store"), ("gelcone.lock", "--store"), ("zarr.json", "--resume")])
def test_a_script_begins_a_store_in_which_no_run_has_written(script, left, taken, tmp_path):
    if left:
        (tmp_path / "map.zarr").mkdir()
        (tmp_path / "map.zarr" / left).write_text("")
    (tmp_path / "bin").mkdir()
    for name in COMMANDS:
        (tmp_path / "bin" / name).write_text(f'#!/bin/bash\n[ {name} != gelcone ] || echo "$@" > typed\n')
        (tmp_path / "bin" / name).chmod(0o755)
    path = f"{tmp_path / 'bin'}:{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "SLURM_CPUS_PER_TASK": "2", "SLURM_JOB_ID": "7"}
    subprocess.run(["bash", "-c", script], cwd=tmp_path, env=environment, check=False, timeout=60)
    typed = (tmp_path / "typed").read_text().split()
    assert {"--store", "--resume"} & {*typed} == {taken}


@needs_bash
@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=["node", "nodes"])
def test_a_job_that_meets_its_limit_is_queued_again_and_resumes(script, tmp_path):
    """With Slurm's signal as soon as there are cells; the next job finishes the map."""
    for long, short in SMALL.items():
        script = script.replace(long, short)
    (tmp_path / "bin").mkdir()
    for name, text in COMMANDS.items():
        path = tmp_path / "bin" / name
        path.write_text(text.format(python=sys.executable))
        path.chmod(path.stat().st_mode | stat.S_IEXEC)
    environment = os.environ | {
        "PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}",
        "PYTHONPATH": str(Path(gelcone.__file__).parents[1]),
        "SLURM_CPUS_PER_TASK": "2",
        "SLURM_JOB_ID": "7",
    }

    def job():
        return subprocess.Popen(["bash", "-c", script], cwd=tmp_path, env=environment, start_new_session=True)

    first = job()
    while first.poll() is None and not (tmp_path / "map.zarr" / "status" / "c").exists():
        time.sleep(0.05)
    first.send_signal(signal.SIGUSR1)
    first.wait(timeout=60)
    assert (tmp_path / "requeued").read_text() == "requeue 7\n"
    before = gelcone.show(tmp_path / "map.zarr")["status"]
    assert (before == Status.COMPUTED).any()
    assert (before == 0).any()
    assert job().wait(timeout=120) == 0
    found = gelcone.show(tmp_path / "map.zarr")
    assert (found["status"] != 0).all()
    device = gelcone.find_device("biased-pump").replace(film="taut")
    over = {"frequency": np.linspace(5.0, 20.0, 56), "voltage_amplitude": np.linspace(100.0, 1000.0, 56)}
    alone = gelcone.sweep(gelcone.Plan(device, over), "regime")
    computed = found["status"].values == Status.COMPUTED
    np.testing.assert_array_equal(found["regime"].values[computed], alone["regime"].values[computed])
