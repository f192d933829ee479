"""Devices and results for other programs: C, FMUs, tables and MATLAB files.

A device leaves gelcone as the integrator's compiled loop, translated line by line into C99: the same steps, events
and ends with the same bits.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _Callable(ModuleType):
    """Makes the package callable: once a module of it is imported, Python replaces the public function
    ``gelcone.export`` by the package of that name."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        from gelcone.export.public import export

        return export(*arguments, **options)


sys.modules[__name__].__class__ = _Callable
