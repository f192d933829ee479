"""The paper's claims, in our words, and their checks."""

from gelcone.paper.claims import damping, limit, maps, spring, statics, voltage
from gelcone.paper.claims.claim import Claim

__all__ = ["CLAIMS", "Claim"]

CLAIMS: dict[str, Claim] = {
    found.name: found
    for module in (statics, damping, limit, voltage, spring, maps)
    for found in vars(module).values()
    if isinstance(found, Claim)
}
"""Claims by name, in the order of the report."""
