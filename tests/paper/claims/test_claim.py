"""A claim is what its check, statement and studies make of it."""

from gelcone.paper.claims.claim import Claim, claim


def test_a_claim_holds_all_that_it_is_declared_with():
    def check(studies):
        return studies

    found = claim("slack", "the film is slack", 7, "static", "energy", without=("wrinkling",))(check)
    assert found == Claim("slack", "the film is slack", 7, ("static", "energy"), check, ("wrinkling",))
    assert claim("slack", "the film is slack", 7, "static")(check).without == ()
    assert found.check({"static": 1}) == {"static": 1}
