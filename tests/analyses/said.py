"""What the tests of texts share: a subject, and the lines behind the heading."""

import numpy as np

import gelcone
from gelcone.analyses import answer
from gelcone.analyses.request import Subject

NAN, INF = np.nan, np.inf
MODEL = gelcone.ConeModel()
SUBJECT = Subject(MODEL)
HEAD = len(answer.heading(SUBJECT))
EVENTS = ("fold", "period_doubling", "symmetry_breaking")


def said(function, shown, subject=SUBJECT):
    return function(shown, subject).splitlines()[HEAD:]
