"""Made-up studies for the tests of claims; names that studies share are written here once."""

import numpy as np
import xarray as xr

from gelcone.codes import Regime
from gelcone.paper.claims import CLAIMS
from gelcone.paper.verdicts import judge

REST, PERIODIC, CHAOTIC = Regime.REST, Regime.PERIODIC, Regime.CHAOTIC


def both_exponents(largest):
    """Largest exponents with a second one below."""
    largest = np.asarray(largest, dtype=float)
    return np.stack([largest, largest - 1.0], axis=-1)


def cells(over, chaos, *, exponent=None, error=0.01, finite=None, kinds=None, **more):
    """A map or a branch over parameters: chaotic where ``chaos``, with exponents of +-0.1 unless given."""
    chaos = np.asarray(chaos, dtype=bool)
    dims = tuple(over)
    exponent = np.where(chaos, 0.1, -0.1) if exponent is None else exponent
    finite = exponent if finite is None else finite
    kinds = np.where(chaos, int(CHAOTIC), int(PERIODIC)) if kinds is None else kinds
    variables = {
        "regime": (dims, np.asarray(kinds, dtype=int)),
        "lyapunov": ((*dims, "exponent"), both_exponents(exponent)),
        "standard_error": ((*dims, "exponent"), np.full((*chaos.shape, 2), error)),
        "finite": ((*dims, "exponent"), both_exponents(finite)),
    }
    return xr.Dataset(variables | {n: (dims, np.asarray(v)) for n, v in more.items()}, coords=over)


def diagram(parameter, values, chaos, *, thresholds=(), **more):
    """A bifurcation diagram whose branch from the fixed state is `cells`; the sweep up shows the opposite."""
    own = cells({parameter: np.asarray(values, dtype=float)}, chaos, **more)
    fixed = {name: variable.expand_dims(branch=["from 1,0"]) for name, variable in own.items() if name != "finite"}
    other = cells(
        {parameter: own[parameter].values},
        ~np.asarray(chaos, dtype=bool),
        **{n: v for n, v in more.items() if n not in ("exponent", "kinds", "finite")},
    )
    swept = {name: variable.expand_dims(branch=["up"]) for name, variable in other.items() if name != "finite"}
    found = xr.concat([xr.Dataset(swept), xr.Dataset(fixed)], "branch").assign(finite=own["finite"])
    columns = [list(column) for column in zip(*thresholds, strict=True)] or [[], [], []]
    for name, column in zip(("branch", "low", "high"), columns, strict=True):
        found[f"threshold_{name}"] = ("threshold", np.array(column))
    return found


def triple(parameter, values=(1.0, 2.0, 3.0), slack=(0.9, 0.8, 0.7), kinds=(0, 3, 3)):
    """Motions at three values of a parameter of which the last two are chaotic."""
    return xr.Dataset(
        {"regime": (parameter, list(kinds)), "late_validity_slack": (parameter, list(slack))},
        coords={parameter: list(values)},
    )


def found(name, **studies):
    """What the check of a claim finds on studies, their names with underscores for dashes."""
    named = {study.replace("_", "-"): data for study, data in studies.items()}
    return checked(name, {study: named[study] for study in CLAIMS[name].studies})


def checked(name, studies):
    """What the check of a claim finds, with all that the report says of every claim."""
    finding = CLAIMS[name].check(studies)
    meanings = [one.meaning for one in (*finding.numbers, *finding.slack)]
    assert len(set(meanings)) == len(meanings)
    for text in (*meanings, finding.neighbourhood, *finding.details, *finding.details.values(), *finding.parts):
        assert text == " ".join(text.split())
        assert not text.endswith((".", ","))
    for text in (CLAIMS[name].statement, finding.why, *([finding.unseen] if finding.decidable else [])):
        assert text == " ".join(text.split())
        assert text[:1].isupper()
        assert text.endswith(".")
    for one in finding.numbers:
        assert one.low is None or one.high is None or np.isnan(one.value) or one.low <= one.value <= one.high
    assert all(part.why for part in finding.parts.values())
    assert isinstance(finding.numbers, tuple)
    assert bool(finding.neighbourhood) == (finding.share is not None)  # a share says of which parameters it is
    return finding


def verdict(name, **studies):
    return judge(found(name, **studies))


def number(finding, part):
    """The one number of a finding whose meaning holds some words."""
    (one,) = (number for number in finding.numbers if part in number.meaning)
    return one
