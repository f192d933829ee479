"""The relaxed axisymmetric membrane under voltage: states by shooting, borders, and the table that a film runs on."""
