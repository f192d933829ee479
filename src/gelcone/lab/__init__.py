"""From measured data to materials and devices: files as laboratories export them, fits, and sheets of numbers."""
