"""Branches of periodic orbits: followed in a parameter, with their bifurcations, and checked against brute force."""
