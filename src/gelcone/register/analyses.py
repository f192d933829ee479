"""The register: the analyses of gelcone by name, each loaded when it is first asked for.

The listing is that of the public names in ``gelcone/__init__.py``: a name with a line about it is an analysis.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import gelcone
from gelcone.errors import check_name
from gelcone.register.analysis import Analysis, command_name


class Register(Mapping[str, Analysis]):
    """Name -> analysis, in the order of the listing."""

    def __getitem__(self, name: str) -> Analysis:
        if name not in self.summaries:
            raise KeyError(name)
        return getattr(gelcone, name).analysis

    def __iter__(self) -> Iterator[str]:
        return iter(self.summaries)

    def __len__(self) -> int:
        return len(self.summaries)

    @property
    def summaries(self) -> Mapping[str, str]:
        """Name -> a line about it; loads nothing."""
        return {name: about for name, (_, about) in gelcone._listing().items() if about}


ANALYSES = Register()
COMMANDS: Mapping[str, str] = {command_name(name): name for name in ANALYSES}
"""Command -> name of its analysis."""


def sweepable() -> dict[str, Analysis]:
    """The analyses that can be asked of every cell of a sweep."""
    return {name: analysis for name, analysis in ANALYSES.items() if analysis.swept}


def find_analysis(name: str) -> Analysis:
    """The analysis of that name; `InputError` with the nearest name when there is none."""
    check_name("analysis", name, ANALYSES)
    return ANALYSES[name]
