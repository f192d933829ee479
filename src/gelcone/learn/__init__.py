"""Devices as environments in which a controller learns (extra learn)."""
