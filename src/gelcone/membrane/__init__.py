"""The relaxed axisymmetric membrane under voltage: states by finite elements, limits, and the table of a film."""
