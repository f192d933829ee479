"""Refusals of films whose membrane cannot be made."""

from __future__ import annotations

import numpy as np

from gelcone.errors import InputError
from gelcone.membrane.gel import Gel

TOO_CLOSE = "stretch_limit: is too close to the pre-stretch for the membrane; raise it, or take film = wrinkling"
LOW_LIMIT = 9.0
"""Gels with a lower stretch limit never localise, or only for some pre-stretches, and their membranes are not made."""


def not_made(gel: Gel, why: str, remedy: str) -> InputError:
    """The refusal of a film without a membrane, for a low stretch limit or, where it is high enough, ``why``."""
    if gel.strain_limit < LOW_LIMIT:
        limit = f"stretch_limit = {gel.strain_limit:g}"
        return InputError(f"film = membrane: {limit}: must be at least about {LOW_LIMIT:g}; take film = wrinkling")
    return InputError(f"film = membrane: {why}; take film = {remedy}")


def too_few(gel: Gel) -> InputError:
    """The refusal of a film with too few states found."""
    if np.isfinite(gel.strain_limit):
        return InputError(TOO_CLOSE)
    return not_made(gel, "too few states of this film are found", "wrinkling, or other pre-stretches")
