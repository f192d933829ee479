"""The share of the symbols whose types pyright knows, of gelcone as it is installed; ends with 1 below 97 %.

python tools/types_seen.py       (takes pyright, and gelcone installed in this environment, not in editable mode)
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

LEAST = 97.0


def main() -> int:
    """Run pyright, which finds the package by the first Python on the path."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    command = [sys.executable, "-m", "pyright", "--verifytypes", "gelcone", "--ignoreexternal"]
    said = subprocess.run(command, env=os.environ | {"PATH": path}, capture_output=True, text=True, check=False).stdout
    found = re.search(r"Type completeness score: ([\d.]+)%", said)
    if found is None:
        print(said)
        return 1
    print(f"{found[1]} % of the symbols have a known type, at least {LEAST:g} % are wanted")
    return int(float(found[1]) < LEAST)


if __name__ == "__main__":
    sys.exit(main())
