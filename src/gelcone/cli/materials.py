"""`gelcone materials`."""

from __future__ import annotations

import click

from gelcone.cli.output import print_json


@click.command("materials")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of text.")
def command(as_json: bool) -> None:
    """List the measured gels that ship, with their sources."""
    from gelcone.devices.materials import load_materials

    materials = load_materials()
    if as_json:
        print_json({name: material.parameters() for name, material in materials.items()})
        return
    for name, material in materials.items():
        click.echo(
            f"{name}: shear modulus {material.shear_modulus / 1e3:.4g} kPa, "
            f"relative permittivity {material.relative_permittivity:.3g}"
        )
    sources = sorted({source for material in materials.values() for source in material.sources.values()})
    click.echo("\n".join(["sources:", *(f"  {source}" for source in sources)]))
