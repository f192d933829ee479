"""The paper's figures by number: each draws the Datasets of its studies."""

from gelcone.paper.figures import parameters, practical, resonance, spectra, statics, triptych
from gelcone.paper.figures.figure import PaperFigure

FIGURES: dict[int, PaperFigure] = {
    figure.number: figure
    for figure in sorted(
        (
            *statics.FIGURES,
            *triptych.FIGURES,
            *spectra.FIGURES,
            *practical.FIGURES,
            *resonance.FIGURES,
            *parameters.FIGURES,
        ),
        key=lambda figure: figure.number,
    )
}
