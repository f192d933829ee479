"""The register of analyses: names alone, loaded when they are used, so that every folder may read it."""
