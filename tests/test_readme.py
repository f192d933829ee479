"""The numbers of the README are those that its commands print."""

import re
from pathlib import Path

import pytest

TEXT = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_window_is_what_its_command_prints(command_line):
    """Line by line, as the command that stands before it prints it; lines may be left out."""
    before, block = re.search(r"(.*?)```text\n(recommended drive.*?)```", TEXT, flags=re.DOTALL).groups()
    command = re.findall(r"`gelcone (envelope [^`]*)`", before)[-1]
    code, out, _ = command_line(*command.split())
    assert code == 0
    printed = iter(out.splitlines())
    for line in block.splitlines():
        assert line in printed, f"{line!r} is not printed, or in another order; the command prints:\n{out}"
