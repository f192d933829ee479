"""What the tests of films share."""

import pytest

from gelcone.motion import response


@pytest.fixture
def undelivered(monkeypatch):
    """Runs have no root mean squares and peaks of what a source delivers, which take longer than the motion where the
    film is a membrane; runs of `test_membrane_charge` have them."""
    monkeypatch.setattr(response, "delivered", lambda *given: {})
