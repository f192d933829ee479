"""`python -m gelcone` and the command `gelcone`; an interrupt prints one line, even during imports."""

import os
import sys


def main() -> None:
    """Runs the command line."""
    # must be set before NumPy is imported: for small matrices on busy cores its threads take a hundred times as long
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        from gelcone.cli import main as run

        run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
