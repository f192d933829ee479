"""The actuator's motion: the compiled flow, and the analyses built on it, one in each file."""
