"""All computations behind the paper's figures and claims, by name."""

from gelcone.paper.studies import (
    continuum,
    diagrams,
    ends,
    limits,
    maps,
    practical,
    resonance,
    samples,
    spectra,
    statics,
    triples,
)
from gelcone.paper.studies.study import Study

STUDIES: dict[str, Study] = {
    study.name: study
    for module in (statics, continuum, triples, spectra, practical, resonance, diagrams, maps, limits, samples, ends)
    for study in module.STUDIES
}
