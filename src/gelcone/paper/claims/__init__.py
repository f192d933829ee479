"""The paper's claims: what it says, in our words, and how each is read off the studies."""

from gelcone.paper.claims import damping, limit, maps, spring, statics, voltage
from gelcone.paper.claims.claim import Claim

__all__ = ["CLAIMS", "Claim"]

CLAIMS: dict[str, Claim] = {
    found.name: found
    for module in (statics, damping, limit, voltage, spring, maps)
    for found in vars(module).values()
    if isinstance(found, Claim)
}
"""In the order of the report."""
