"""Conical PVC-gel actuators: from energy to motion."""
