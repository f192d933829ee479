"""Fitted films from JSON text and files."""

from __future__ import annotations

import json
import math
from pathlib import Path

from gelcone.errors import InputError
from gelcone.files import read_text
from gelcone.physics.component import from_record
from gelcone.physics.film.continuum import ContinuumFilm
from gelcone.physics.film.unwrinkled import UnwrinkledFilm
from gelcone.physics.laws import LAWS, StrainEnergyLaw

FORMS: dict[int, type[ContinuumFilm | UnwrinkledFilm]] = {kind.form: kind for kind in (UnwrinkledFilm, ContinuumFilm)}
"""Number of a file's format -> the film in it; gelcone 0.1 wrote the first."""


def film_from_json(text: str, origin: str = "film") -> ContinuumFilm | UnwrinkledFilm:
    """The film that a fitted film's `to_json` wrote; `InputError` naming ``origin`` for text that is not one."""
    remedy = "write a new one with gelcone validate --fit"
    try:
        values = json.loads(text)
        number = values.pop("gelcone_film")
        if number not in FORMS:
            known = " and ".join(map(str, FORMS))
            raise InputError(f"{origin}: is a film of format {number}, this gelcone reads {known}; {remedy}")
        for name in ("law_parameters", "errors"):
            values[name] = tuple((str(key), float(value)) for key, value in values[name].items())
        for name, value in values.items():
            if isinstance(value, list):
                values[name] = tuple(tuple(map(float, v)) if isinstance(v, list) else float(v) for v in value)
        law = from_record("strain-energy law", values.pop("law"), LAWS, StrainEnergyLaw)  # type: ignore[type-abstract]
        film = FORMS[number](law=law, largest=values.pop("reach"), **values)
        if not (film.largest > 0.0 and film.reach_squared < film.wall < math.inf and film.sound()):
            raise ValueError("a number is out of bounds")
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise InputError(
            f"{origin}: is no film that gelcone wrote ({type(error).__name__}: {error}); {remedy}"
        ) from None
    return film


def read_film(path: str | Path) -> ContinuumFilm | UnwrinkledFilm:
    """The film in a JSON file; `InputError` for one that cannot be read or used."""
    remedy = "give a film that gelcone validate --fit wrote, taut, wrinkling or continuum"
    return film_from_json(read_text(Path(path), remedy), str(path))
