"""The studio: a page in the browser whose controls answer at once.

The server is thin: it reads what the page asks for through the checks of the command line, calls the analyses of the
register and what they are made of, and sends numbers. The page, in ``static``, draws them.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any


class _Callable(ModuleType):
    """``gelcone.studio(device)`` works also once a module of this folder was imported: Python then puts the folder
    itself in the place of the public function of the same name."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        from gelcone.studio.notebook import studio

        return studio(*arguments, **options)


sys.modules[__name__].__class__ = _Callable
