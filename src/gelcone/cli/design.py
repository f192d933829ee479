"""`gelcone design`: a wish in, devices out."""

from __future__ import annotations

from pathlib import Path

import click

from gelcone.cli.options import PLACE, output_parameters
from gelcone.cli.output import Output, progress_bar, result_files
from gelcone.files import writer_of

FILES = ("design.nc", "design.png")


def design_command() -> click.Command:
    """`gelcone design`."""
    text = """Find devices that meet the requirements of a wish in spite of the tolerances of their fields.

    A wish is a TOML file: what the device must do, which fields are free within which bounds, and the tolerance of
    each; `gelcone init --wish wish.toml` writes one to fill in. Designs are searched along the first two objectives,
    checked by their settled motion and their operating envelope, and printed with the share of devices within the
    tolerances that meet all, of 4,096 new draws. The search runs on a homogeneous cone; the check and all that is
    printed are of the film of the wish, by default "membrane", and the probability is of draws of the cone, its numbers
    times those of the film over its own at nominal values. A search takes some two minutes of a processor. --out writes
    a device file of each, with a table and a figure.

    \b
    gelcone init --wish wish.toml
    gelcone design wish.toml --out designs
    gelcone envelope designs/design-1.toml
    """
    params: list[click.Parameter] = [
        click.Argument(["wish"], type=PLACE, metavar="WISH"),
        click.Option(
            ["--samples"], type=PLACE, metavar="FILE",
            help="Fields that are uncertain together, as a fit writes them (draws.nc; or .csv), with correlations, in "
            "place of their [tolerances]. What is fixed is at their median, what is free spreads as they do.",
        ),
        click.Option(["--nominal"], is_flag=True, help="As if nothing were uncertain; prints no probability."),
        click.Option(["--seed"], type=click.IntRange(0, 2**31), default=0, show_default=True, help="Of the search."),
        *output_parameters(),
    ]  # fmt: skip
    return click.Command("design", params=params, callback=run_design, help=text)


def run_design(
    *, wish: Path, samples: Path | None, nominal: bool, seed: int, out: Path | None, force: bool, as_json: bool
) -> int:
    """Reads the wish, searches, and prints and writes the designs."""
    from gelcone.analyses.design import design_json, design_words, device_text
    from gelcone.analyses.draws import read_samples
    from gelcone.analyses.request import Subject
    from gelcone.lab.design import design
    from gelcone.lab.wish import read_wish

    output = Output("design", out, force, as_json)
    output.check(FILES)
    asked = read_wish(wish)
    subject = Subject(asked.device.to_model(), asked.device)
    draws = None if samples is None else read_samples(samples, (), subject)
    with progress_bar("design") as progress:
        result = design(asked, samples=draws, nominal=nominal, seed=seed, progress=progress)
    devices = {f"design-{k + 1}.toml": writer_of(device_text(result, k)) for k in range(result.sizes["design"])}
    output.deliver(design_words(result), design_json(result), result_files("design", result) | devices)
    return 0
