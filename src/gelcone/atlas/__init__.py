"""Parameter space: bifurcation diagrams, two-parameter maps and basins, all made of independent cells."""
