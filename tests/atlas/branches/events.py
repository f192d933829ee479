"""The events of branches as a list of dicts, for tests to read."""

import numpy as np

from gelcone.words import event_label


def events_of(result):
    """The events in the order of their branches."""
    return [event_of(result, result.isel(event=k)) for k in range(result.sizes["event"])]


def event_of(result, own):
    branch, born, kind = int(own["event_branch"]), int(own["event_born_branch"]), int(own["event_supercritical"])
    return {
        "kind": event_label(own["event_kind"]),
        "value": float(own["event_value"]),
        "value_error": float(own["event_error"]),
        "period": int(result["period"][branch]),
        "symmetric": bool(result["symmetric"][branch]),
        "supercritical": None if kind < 0 else bool(kind),
        "multipliers": np.stack([own["event_multiplier_real"], own["event_multiplier_imag"]], axis=1).tolist(),
        "branch": branch,
        "born_branch": None if born < 0 else born,
    }
