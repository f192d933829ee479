"""Devices in SI units, measured materials, strict units, and results back in SI."""
