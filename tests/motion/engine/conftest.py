"""The tests of the engine keep their object code in a folder of their own; all others in the usual one, as users do."""

import pytest


@pytest.fixture(scope="session")
def _code(tmp_path_factory):
    return tmp_path_factory.mktemp("code")


@pytest.fixture(scope="package", autouse=True)
def _own_cache(_code):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GELCONE_CACHE", str(_code))
        yield
