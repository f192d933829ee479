"""`python -m gelcone` is the command `gelcone`."""

from gelcone.cli import main

main()
