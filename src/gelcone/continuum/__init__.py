"""The film as a continuum, by finite elements, and the fit of its force."""
