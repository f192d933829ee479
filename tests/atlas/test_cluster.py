"""Addresses of schedulers, and what is said of workers that are lost; `test_sweep.py` has the sweeps."""

import json
import warnings

import pytest

from gelcone.atlas import cluster as module
from gelcone.atlas.cluster import cluster
from gelcone.errors import InputError


@pytest.mark.parametrize("given", ["tcp://10.0.0.1:8786", "tls://host.json:1", "host:8786"])
def test_an_address_is_taken_as_it_is(given):
    assert module._address(given) == given


@pytest.mark.parametrize("name", ["scheduler.json", "scheduler"])
def test_a_scheduler_file_holds_the_address(tmp_path, name):
    path = tmp_path / name
    path.write_text(json.dumps({"address": "tcp://10.0.0.1:8786", "id": "Scheduler"}))
    assert module._address(str(path)) == "tcp://10.0.0.1:8786"


@pytest.mark.parametrize("content", ["{}", "[]", '{"address": 8786}', '{"address": null}', "{", '{"address": {}}'])
def test_a_file_without_an_address_is_refused(tmp_path, content):
    path = tmp_path / "scheduler.json"
    path.write_text(content)
    with pytest.raises(InputError, match="is not a scheduler file of dask; start one with `dask scheduler"):
        module._address(str(path))


def test_a_file_that_does_not_come_is_waited_for_only_so_long(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "CONNECT_SECONDS", 0.2)
    with pytest.raises(InputError, match="--scheduler-file"):
        module._address(str(tmp_path / "late.json"))


def test_processes_or_a_scheduler_are_given_and_not_both():
    for given in ({}, {"workers": 2, "scheduler": "tcp://10.0.0.1:8786"}):
        with pytest.raises(InputError, match="give one of them"):
            cluster(**given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert callable(cluster(scheduler="tcp://10.0.0.1:8786"))
        assert callable(cluster(2))
