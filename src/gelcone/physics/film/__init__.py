"""Films: what resists and drives the disc."""
