"""Is the cone model right? The same film as a continuum, solved by finite elements, and both side by side."""
