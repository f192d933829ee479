"""The command `gelcone` before its arguments are read: threads of BLAS, and an interrupt."""

import os
import sys

import pytest

from gelcone.__main__ import main


def test_the_command_has_one_thread_of_blas_unless_others_are_asked_for(monkeypatch):
    monkeypatch.setattr("gelcone.cli.main", lambda: None)
    for given, expected in (("", "1"), ("3", "3")):
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", given)
        if not given:
            monkeypatch.delenv("OPENBLAS_NUM_THREADS")
        main()
        assert os.environ["OPENBLAS_NUM_THREADS"] == expected


@pytest.mark.parametrize("imported", [True, False])
def test_an_interrupt_prints_one_line_and_exits_as_shells_expect(imported, monkeypatch, capsys):
    """128 and the number of the signal; also while the command line is being imported."""

    class Importing:
        def __getattr__(self, name):
            raise KeyboardInterrupt

    def interrupted():
        raise KeyboardInterrupt

    if imported:
        monkeypatch.setattr("gelcone.cli.main", interrupted)
    else:
        monkeypatch.setitem(sys.modules, "gelcone.cli", Importing())
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 130
    assert capsys.readouterr() == ("", "interrupted\n")
