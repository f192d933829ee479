"""The tests keep their object code in a folder of their own."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GELCONE_CACHE", str(tmp_path_factory.mktemp("code")))
        yield
