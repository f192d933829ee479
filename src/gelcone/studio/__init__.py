"""The studio: a page in the browser whose controls answer at once.

The server reads requests with the checks of the command line, calls the analyses of the register or their parts, and
sends numbers. The page, in ``static``, draws them.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _Callable(ModuleType):
    """The module's type, which makes ``gelcone.studio(device)`` work after an import of a submodule: Python then binds
    ``gelcone.studio`` to this package in place of the public function."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        from gelcone.studio.notebook import studio

        return studio(*arguments, **options)


sys.modules[__name__].__class__ = _Callable
