"""The components of a system as plain data, for files and results."""

from __future__ import annotations

from typing import Any

from gelcone.errors import InputError
from gelcone.physics.bias import BIASES, Bias, Together
from gelcone.physics.circuit import CIRCUITS
from gelcone.physics.component import find_component, to_record
from gelcone.physics.film.film import Film
from gelcone.physics.film.gel import GelFilm
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS
from gelcone.physics.system import ConeSystem
from gelcone.physics.waveforms import WAVEFORMS

FILMS: dict[str, Film] = {film.name: film for film in (TautCone(), WrinklingCone(), MembraneFilm())}
_SHIPPED = {name: to_record(film, FILMS) for name, film in FILMS.items()}


def system_record(system: ConeSystem) -> dict[str, Any]:
    """Each component by its kind; ``law`` and ``prestretch_mode`` accompany a film that has them."""
    film = system.film
    own = (
        {"prestretch_mode": film.prestretch_mode, "law": to_record(film.law, LAWS)} if isinstance(film, GelFilm) else {}
    )
    return (
        own
        | {
            "film": film_record(film),
            "bias": bias_record(system.bias),
            "waveform": to_record(system.waveform, WAVEFORMS),
            "circuit": to_record(system.circuit, CIRCUITS),
        }
        | {
            name: value
            for second in system.films[1:]
            for name, value in (("second_film", film_record(second.film)), ("second_drive", second.drive))
        }
    )


def film_record(film: Film) -> Any:
    """A film; one that ships by its name and what else it was given."""
    record = to_record(film, FILMS)
    if type(FILMS.get(film.name)) is not type(film):
        return record
    own = {name: value for name, value in record.items() if value != _SHIPPED[film.name][name]}
    own = {name: value for name, value in own.items() if name not in ("law", "prestretch_mode")}
    return {"component": film.name} | own if own else film.name


def find_film(given: Any) -> Film:
    """The film that a record describes.

    Raises `InputError` for an unknown name, and for the fitted films of gelcone 0.1 and 0.2 and their files.
    """
    if isinstance(given, str) and (given == "continuum" or given.lstrip().startswith("{") or given.endswith(".json")):
        raise InputError(
            f"{given[:60]!r} is a fitted film of gelcone 0.1 or 0.2, which is not read any more; take film = membrane "
            "(--film membrane), the same membrane without a fit"
        )
    return find_component("film", given, FILMS, Film)  # type: ignore[type-abstract]


def bias_record(bias: Bias) -> Any:
    """A bias; several together as their names with a plus, or as a list where one needs more than its name."""
    if not isinstance(bias, Together):
        return to_record(bias, BIASES)
    parts = [to_record(part, BIASES) for part in bias.parts]
    return "+".join(parts) if all(isinstance(part, str) for part in parts) else parts


def find_bias(given: Any) -> Bias:
    """The bias that a record, or several joined by a plus or in a list, describe.

    Raises `InputError` for an unknown name.
    """
    names = given.split("+") if isinstance(given, str) and "+" in given else given
    if isinstance(names, list | tuple):
        return Together(tuple(find_bias(name.strip() if isinstance(name, str) else name) for name in names))
    return find_component("bias", given, BIASES, Bias)  # type: ignore[type-abstract]
