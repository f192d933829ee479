"""`python -m gelcone` and the command `gelcone`: an interrupt is one line from the first import on."""

import os
import sys


def main() -> None:
    """Runs the command line."""
    # read where NumPy is first imported: on busy cores its threads take a hundred times as long as one does for small
    # matrices
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        from gelcone.cli import main as run

        run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
