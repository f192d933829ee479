"""The paper's figures by number, and one of our own by name; each draws the Datasets of its studies."""

from gelcone.paper.figures import ends, parameters, practical, resonance, spectra, statics, triptych
from gelcone.paper.figures.figure import PaperFigure

FIGURES: dict[int | str, PaperFigure] = {
    figure.number: figure
    for figure in sorted(
        (plot for module in (statics, triptych, spectra, practical, resonance, parameters) for plot in module.FIGURES),
        key=lambda figure: int(figure.number),
    )
} | {figure.number: figure for figure in ends.FIGURES}
