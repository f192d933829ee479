"""`python -m gelcone` and the command `gelcone`: an interrupt is one line from the first import on."""

import sys


def main() -> None:
    """Runs the command line."""
    try:
        from gelcone.cli import main as run

        run()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(130)


if __name__ == "__main__":
    main()
