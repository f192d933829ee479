"""Messages to the page: a JSON head and arrays, in one binary frame.

A frame is the length of the head (unsigned 32-bit, little-endian), the head as UTF-8 padded with spaces so that what
follows begins at a multiple of 8 bytes, and the arrays, each padded to a multiple of 8. The head's ``arrays`` lists
name, type (``f4`` or ``u1``), offset and number of values of each.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from gelcone.analyses.answer import plain

TYPES = {"u": "u1", "i": "f4", "f": "f4", "b": "u1"}
"""Kind of a NumPy array -> type in the frame. Numbers travel in single precision, which is enough for a picture."""


def pack(head: Mapping[str, Any], arrays: Mapping[str, Any] | None = None) -> bytes:
    """One frame; numbers in the head that are not finite become null."""
    index, parts, at = [], [], 0
    for name, values in (arrays or {}).items():
        array = np.asarray(values)
        kind = TYPES[array.dtype.kind]
        with np.errstate(over="ignore"):  # too large for single precision: infinite, and not drawn
            data = np.ascontiguousarray(array, dtype=f"<{kind}").tobytes()
        index.append([name, kind, at, array.size])
        parts.append(data + b"\0" * (-len(data) % 8))
        at += len(parts[-1])
    text = json.dumps(plain({**head, "arrays": index}), allow_nan=False).encode()
    text += b" " * (-(4 + len(text)) % 8)
    return b"".join([struct.pack("<I", len(text)), text, *parts])
