"""What films have in common whose force was fitted to the continuum: for which film it was, and how far it reaches."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.physics.component import Numbers, to_record
from gelcone.physics.film.taut import PRESTRETCHES, GelFilm, check_prestretch_mode
from gelcone.physics.laws import LAWS, StrainEnergyLaw

Polynomial = tuple[float, ...]
"""Coefficients, that of the constant first."""


@dataclass(frozen=True, kw_only=True)
class FittedFilm(GelFilm):
    """A film whose force was fitted for one geometry, law and pre-stretch.

    Parameters
    ----------
    radius_ratio : a/b that it was fitted for.
    law, law_parameters : the strain-energy law and the values of its parameters, by name.
    prestretches : meridional and hoop pre-stretch.
    largest : largest |x| that the fit covers; ``reach`` in files.
    errors : what -> largest error of the fit there.
    """

    radius_ratio: float
    law: StrainEnergyLaw
    law_parameters: tuple[tuple[str, float], ...]
    prestretches: tuple[float, float]
    largest: float
    errors: tuple[tuple[str, float], ...] = ()
    prestretch_mode: str = dataclasses.field(default="radial", compare=False)

    form: ClassVar[int]
    """Number of the format of its files; raised when an older one can no longer be read."""
    ending = Outcome.PULLED_IN

    def __post_init__(self) -> None:
        check_prestretch_mode(self.prestretch_mode)

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """What is left out is that of the fit; `InputError` for what differs from it."""
        own = {name: value for name, value in given.items() if value is not None}
        if not own.keys() & PRESTRETCHES.keys():
            own |= dict(zip(("meridional_prestretch", "hoop_prestretch"), self.prestretches, strict=True))
        values = super().complete(dict(self.law_parameters) | own)
        differences = self.differences(values)
        if differences:
            raise InputError(
                f"the continuum film does not fit the model: {'; '.join(differences)}; fit another film for each law "
                "and pre-stretch (gelcone validate --fit, or gelcone.fit_film), or leave it out for the cone"
            )
        return values

    def differences(self, values: Numbers) -> list[str]:
        """In words, which values differ from those that the film was fitted for."""
        pairs = [(name, values[name], own) for name, own in self.law_parameters]
        pairs += list(
            zip(("meridional pre-stretch", "hoop pre-stretch"), self.stretches(values), self.prestretches, strict=True)
        )
        found = []
        for name, given, own in pairs:
            if not np.all(np.asarray(given, dtype=float) == own):
                shown = f"{float(given):g}" if np.ndim(given) == 0 else f"{np.size(given)} values"
                found.append(f"{name} = {shown}, fitted for {own:g}")
        return found

    def strain_limit(self, n: Numbers) -> Any:
        """The largest x^2 that the film was fitted for."""
        return np.asarray(self.reach_squared)

    @property
    def reach_squared(self) -> float:
        return self.largest * self.largest

    def reach(self, n: Numbers) -> tuple[float, float]:
        return 0.0, self.largest

    def limit_share(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> Any:
        """Also that of the strain beside the disc."""
        return np.fmax(super().limit_share(x, voltage, y, n), self.state(x, voltage, y, n).limit_share)

    def outside(self, x: float, n: Numbers) -> str:
        return (
            f"initial displacement {x:g}: must be less than {self.largest:g} either way, which the continuum film was "
            "fitted for; start lower"
        )

    def to_json(self) -> str:
        """The film as JSON text, which `gelcone.physics.film.stored.film_from_json` reads back exactly."""
        own = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        for name in ("prestretch_mode", "largest"):
            del own[name]
        named = {
            "law": to_record(self.law, LAWS),
            "law_parameters": {name: _finite(value) for name, value in self.law_parameters},
            "errors": dict(self.errors),
        }
        return json.dumps({"gelcone_film": self.form} | own | {"reach": self.largest} | named)


def _finite(value: float) -> float | str:
    return value if math.isfinite(value) else "inf"
