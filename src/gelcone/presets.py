"""The paper's parameter sets, read from ``presets.toml``."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib.resources import files

from gelcone.errors import unknown_name
from gelcone.physics.model import ConeModel


@dataclass(frozen=True)
class Preset:
    """One parameter set: dimensionless numbers from the paper's text, and those that were reconstructed.

    The paper's film is the taut one; another ``film`` is for asking what becomes of a claim.
    """

    name: str
    purpose: str
    initial: tuple[float, float]
    text: dict[str, float]
    reconstructed: dict[str, float]
    film: str = "taut"

    @property
    def model(self) -> ConeModel:
        paper = ConeModel.from_parameters(self.text | self.reconstructed)
        return paper if self.film == paper.film.name else paper.replace(film=self.film)


def load_presets() -> dict[str, Preset]:
    """All parameter sets by name."""
    tables = tomllib.loads(files("gelcone").joinpath("presets.toml").read_text(encoding="utf-8"))
    return {
        name: Preset(name, table["purpose"], tuple(table["initial"]), table["text"], table["reconstructed"])
        for name, table in tables.items()
    }


def find_preset(name: str) -> Preset:
    """The parameter set of that name; `InputError` with the nearest name when there is none."""
    presets = load_presets()
    if name not in presets:
        raise unknown_name("preset of the paper", name, presets)
    return presets[name]
