"""How the actuator moves: the compiled flow and the analyses built on it, one a file."""
