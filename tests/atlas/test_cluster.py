"""Addresses of schedulers, and what is said of workers that are lost; `test_sweep.py` has the sweeps."""

import json
import warnings
from collections.abc import Callable
from contextlib import nullcontext
from types import SimpleNamespace
from typing import NamedTuple

import pytest

from gelcone.atlas import cluster as module
from gelcone.atlas.cluster import cluster
from gelcone.errors import InputError, LostWorker


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


class Future(NamedTuple):
    """A task that is done when it is asked for."""

    function: Callable
    arguments: tuple

    def result(self):
        return self.function(*self.arguments)


class Client:
    """A scheduler's client with two workers of two and three threads, whose tasks are done at once."""

    def __init__(self):
        self.given, self.cancelled = [], None

    def nthreads(self):
        return {"one": 2, "other": 3}

    def subscribe_topic(self, topic, handler):
        self.handler = handler

    def submit(self, function, *arguments, pure):
        self.given.append(arguments)
        return Future(function, arguments)

    def cancel(self, futures):
        self.cancelled = futures


class Completed(list):
    """Futures in the order in which they are given."""

    def __iter__(self):
        while self:
            yield self.pop(0)

    add = list.append


@pytest.mark.parametrize(("fewest", "ahead"), [(7, 20), (33, 33)])
def test_a_cluster_has_the_threads_of_all_its_workers_and_tasks_ahead(monkeypatch, fewest, ahead):
    """Four for each thread, and as many as workers that come later need."""
    client = Client()
    distributed = SimpleNamespace(as_completed=lambda futures: Completed(futures), KilledWorker=MemoryError)
    monkeypatch.setattr(module, "_import_distributed", lambda: distributed)
    monkeypatch.setattr(module, "_client", lambda distributed, address: nullcontext(client))
    monkeypatch.setattr(module, "FEWEST_AHEAD", fewest)
    with cluster(scheduler="tcp://10.0.0.1:8786")() as team:
        assert team.size == 5
        answers = team.run(lambda task: task * task, range(100))
        first = next(answers)
        assert len(client.given) == ahead
        rest = list(answers)
    assert sorted([first, *rest]) == [(k * k, 0) for k in range(100)]
    assert client.cancelled == []
    with pytest.warns(LostWorker, match="worker one is lost; 1 left take over"):
        client.handler((0.0, {"worker": "one", "action": "remove-worker"}))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        client.handler((0.0, {"worker": "other", "action": "remove-worker", "expected": True}))
        client.handler((0.0, {"worker": "unknown", "action": "remove-worker"}))
        client.handler((0.0, {"worker": "third", "action": "add-worker"}))
    with pytest.warns(LostWorker, match="worker third is lost; none is left"):
        client.handler((0.0, {"worker": "third", "action": "remove-worker"}))


def test_a_scheduler_without_workers_is_said_and_how_to_start_one(monkeypatch):
    client = Client()
    client.nthreads = dict
    monkeypatch.setattr(module, "_import_distributed", SimpleNamespace)
    monkeypatch.setattr(module, "_client", lambda distributed, address: nullcontext(client))
    words = "scheduler tcp://one:1: has no workers; the run waits for one: start it with `dask worker tcp://one:1`"
    with pytest.warns(LostWorker, match=words), cluster(scheduler="tcp://one:1")() as team:
        assert team.size == 1
    client.handler((0.0, {"worker": "late", "action": "add-worker"}))
    with pytest.warns(LostWorker, match="worker late is lost; none is left; the run waits for one: start it with"):
        client.handler((0.0, {"worker": "late", "action": "remove-worker"}))


@pytest.mark.parametrize("versions", [["0.1.0"], [None, "0.1.0"], [None, "no gelcone"], []])
def test_workers_of_a_scheduler_have_the_same_version_all_of_them(versions):
    """None here stands for this one; a scheduler without workers yet may get the right ones."""
    own = [module.__version__ if version is None else version for version in versions]

    def run(function):
        assert function() == module.__version__
        if "no gelcone" in own:
            raise ModuleNotFoundError
        return dict(enumerate(own))

    client = SimpleNamespace(run=run)
    if not versions:
        module._check_versions(client, "tcp://one:1")
        return
    shown = "no gelcone" if "no gelcone" in own else ", ".join(sorted(own))
    with pytest.raises(InputError, match=f"scheduler tcp://one:1: its workers have {shown}, here is "):
        module._check_versions(client, "tcp://one:1")
