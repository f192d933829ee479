"""The paper's parameter sets, read from ``presets.toml``."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from typing import Any

from gelcone.errors import check_name
from gelcone.physics.model import ConeModel


@dataclass(frozen=True)
class Preset:
    """A parameter set: dimensionless numbers from the paper's text, and reconstructed ones.

    ``changes`` replace parameters, to judge a claim with another film than the paper's taut one.
    """

    name: str
    purpose: str
    initial: tuple[float, float]
    text: dict[str, float]
    reconstructed: dict[str, float]
    changes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def model(self) -> ConeModel:
        """The model with these parameters."""
        paper = ConeModel.from_parameters(self.text | self.reconstructed)
        return paper.replace(**self.changes) if self.changes else paper


def load_presets() -> dict[str, Preset]:
    """All parameter sets by name."""
    tables = tomllib.loads(files("gelcone").joinpath("presets.toml").read_text(encoding="utf-8"))
    return {
        name: Preset(name, table["purpose"], tuple(table["initial"]), table["text"], table["reconstructed"])
        for name, table in tables.items()
    }


def find_preset(name: str) -> Preset:
    """The parameter set of that name; `InputError` with the nearest name if there is none."""
    presets = load_presets()
    check_name("preset of the paper", name, presets)
    return presets[name]
