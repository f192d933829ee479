"""Materials: the library's figures and sources, and the record's checks."""

import math

import numpy as np
import pytest

import gelcone
from gelcone.devices.device import find_device
from gelcone.devices.materials import Material, find_material, load_materials, side_by_side
from gelcone.errors import InputError
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel
from gelcone.words import members_of
from tests.devices.own import PowerFilm
from tests.toys import Quadratic

RUBBER = {"name": "rubber", "shear_modulus": "20 kPa", "relative_permittivity": 5}


@pytest.mark.parametrize(("ratio", "kilopascal"), [("2:1", 288.8), ("4:1", 56.1), ("6:1", 24.7), ("8:1", 11.0)])
def test_library_figures(ratio, kilopascal):
    gel = load_materials()[f"PVC-DBA {ratio}"]
    assert gel.name == f"PVC-DBA {ratio}"
    assert gel.shear_modulus == pytest.approx(1e3 * kilopascal / 3, rel=1e-15)
    assert (gel.relative_permittivity, gel.relative_permittivity_range) == (4.77, None)
    assert (gel.law, gel.stretch_limit, gel.dielectric_strength) == ("gent", 50.0, None)


def test_every_number_of_the_library_has_its_source():
    gels = {name: gel for name, gel in load_materials().items() if name.startswith("PVC-DBA")}
    assert len(gels) == 4
    for gel in gels.values():
        assert set(gel.sources) == {"shear_modulus", "shear_modulus_range", "relative_permittivity", "stretch_limit"}
        assert "Polymers 2025, 17(19), 2641" in gel.sources["shear_modulus"]
        assert "with P(VC-VA) added it is 7.3" in gel.sources["relative_permittivity"]
        assert "not measured on this gel" in gel.sources["stretch_limit"]
    for name in ("VHB 4905", "VHB 4910"):
        gel = find_material(name)
        numbers = {field for field, value in gel if isinstance(value, float)}
        assert numbers <= set(gel.sources)


@pytest.mark.parametrize(
    ("ratio", "modulus", "poisson"), [("2:1", 288.8, 0.42), ("6:1", 24.7, 0.39), ("8:1", 11.0, 0.35)]
)
def test_the_range_of_the_modulus_is_that_of_its_reasons(ratio, modulus, poisson):
    """Equi-biaxial stiffness of a compressible gel, and a secant of the nominal stress to 25 % strain."""
    low, high = find_material(f"PVC-DBA {ratio}").shear_modulus_range
    assert low == pytest.approx(1e3 * modulus / (6.0 * (1.0 - poisson)), rel=3e-4)
    secant = (1.25 - 1.25**-2.0) / 0.25  # nominal stress over mu and strain
    assert high == pytest.approx(1e3 * modulus / secant, rel=2e-3)


def test_a_range_lies_around_its_number_and_goes_with_it():
    gel = find_material("PVC-DBA 6:1")
    assert gel.replace(shear_modulus="9 kPa").shear_modulus_range is None
    assert gel.replace(young_modulus="30 kPa").shear_modulus_range is None
    assert gel.replace(relative_permittivity=7.3).shear_modulus_range is not None
    with pytest.raises(
        InputError, match=r"shear_modulus_range = \[1000.0, 2000.0\]: must be \[lowest, highest\] around"
    ):
        gel.replace(shear_modulus_range=["1 kPa", "2 kPa"])
    assert (
        find_device("biased-pump").replace(material=["PVC-DBA 6:1", "PVC-DBA 8:1"]).material.shear_modulus_range is None
    )


def test_unknown_name_suggests_the_near_one():
    with pytest.raises(InputError, match="'PVC-DBA 4:2' is not a material; did you mean 'PVC-DBA 4:1'"):
        find_material("PVC-DBA 4:2")
    with pytest.raises(InputError, match="'rubber' is not a material; known: PVC-DBA 2:1, PVC-DBA 4:1"):
        find_material("rubber")


def test_modulus_and_permittivity():
    material = Material(young_modulus="60 kPa", relative_permittivity=5)
    assert material.shear_modulus == pytest.approx(2e4)
    assert material.stretch_limit == LAWS["gent"].parameters["stretch_limit"].default


@pytest.mark.parametrize(
    ("law", "given"),
    [
        ("gent", {"stretch_limit": 12.0}),
        ("gent", {"stretch_limit": math.inf}),
        ("neo-hookean", {}),
        ("yeoh", {"yeoh_c2": -0.01, "yeoh_c3": 0.002}),
    ],
)
def test_every_law_reaches_the_model(law, given):
    material = Material(**RUBBER, law=law, **given)
    assert material.law_parameters == given
    model = ConeModel.from_parameters({"law": material.law, **material.law_parameters})
    assert {k: v for k, v in model.parameters().items() if k in given} == given


@pytest.mark.parametrize("material", [Material(**RUBBER), find_material("PVC-DBA 6:1")])
def test_parameters_give_the_material_back(material):
    assert Material(**material.parameters()) == material
    assert material.replace() == material


def test_replace_drops_what_no_longer_holds():
    gel = find_material("PVC-DBA 4:1")
    changed = gel.replace(relative_permittivity=5.5, young_modulus="30 kPa")
    assert changed.shear_modulus == pytest.approx(1e4)
    assert changed.relative_permittivity_range is None
    assert set(changed.sources) == {"stretch_limit"}
    assert changed.name == "PVC-DBA 4:1, changed"
    assert changed.replace(stretch_limit=20).name == "PVC-DBA 4:1, changed"
    other_law = gel.replace(law="yeoh", yeoh_c2=0.1)
    assert other_law.law_parameters == {"yeoh_c2": 0.1, "yeoh_c3": 0.0}
    own_law = gel.replace(law=Quadratic(), law_growth=0.2)
    assert own_law.law_parameters == {"law_growth": 0.2}
    assert own_law.replace(law="neo-hookean").law_parameters == {}
    assert gel.relative_permittivity == pytest.approx(4.77), "the library's own is untouched"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"shear_modulus": "20 kV"}, "shear_modulus = '20 kV': kV is a unit of voltage, not of pressure; give a num"),
        ({"shear_modulus": 0}, "shear_modulus = 0: must be greater than 0 Pa; give a larger one"),
        ({"shear_modulus": None}, "shear_modulus: is missing; give the shear modulus in Pa"),
        ({"young_modulus": 3e4}, "young_modulus and shear_modulus are both given; give one"),
        ({"relative_permittivity": 0.5}, "relative_permittivity = 0.5: must be at least 1"),
        (
            {"relative_permittivity_range": [6, 7]},
            "relative_permittivity_range = [6.0, 7.0]: must be [lowest, highest]",
        ),
        ({"relative_permittivity_range": 5}, "relative_permittivity_range = 5.0: must be [lowest, highest]"),
        ({"law": "gnet"}, "law: 'gnet' is not a strain-energy law; did you mean 'gent'?"),
        ({"law": 3}, "law: strain-energy law = 3: must be a strain-energy law or the name of one: gent"),
        (
            {"law": "yeoh", "stretch_limit": 3},
            "stretch_limit: the yeoh law does not take it; it takes yeoh_c2, yeoh_c3",
        ),
        ({"yeoh_c2": 1}, "yeoh_c2: the gent law does not take it; it takes stretch_limit"),
        ({"stretch_limit": -1}, "stretch_limit = -1: must be greater than 0"),
        ({"stretch_limit": math.nan}, "stretch_limit = nan: must be finite"),
        ({"dielectric_strength": "20 kV"}, "dielectric_strength = '20 kV': kV is a unit of voltage, not of electric"),
        ({"shear_moduls": 3}, "'shear_moduls' is not a material field; did you mean 'shear_modulus'?"),
        ({"name": 3}, "name = 3: must be a non-empty text in quotes"),
        ({"sources": 3}, "sources = 3: must map field names to texts"),
    ],
)
def test_bad_input_is_one_line(changes, message):
    with pytest.raises(InputError) as caught:
        Material(**RUBBER | changes)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_gels_side_by_side_are_those_of_each(command_line):
    names = ["PVC-DBA 4:1", "PVC-DBA 8:1"]
    pump = gelcone.find_device("biased-pump").replace(film="wrinkling")
    both = gelcone.static(pump.replace(material=names), voltages=None)
    for k, name in enumerate(names):
        one = gelcone.static(pump.replace(material=name))
        assert float(both["pull_in_voltage"][k]) == pytest.approx(float(one["pull_in_voltage"]), rel=1e-9)
    code, out, err = command_line(
        "static", "biased-pump", "--film", "wrinkling", "--set", f"material={', '.join(names)}"
    )
    assert code == 0, err
    assert [line for line in out.splitlines() if line.startswith("material ")] == [
        f"material {name}:" for name in names
    ]
    assert gelcone.Device(**pump.replace(material=names).parameters()) == pump.replace(material=names)


def test_gels_of_several_laws_and_none_are_refused():
    pump = gelcone.find_device("biased-pump")
    yeoh = gelcone.Material(name="own", shear_modulus="8 kPa", relative_permittivity=6.0, law="yeoh")
    with pytest.raises(gelcone.InputError, match="the laws gent and yeoh differ"):
        pump.replace(material=["PVC-DBA 4:1", yeoh])
    with pytest.raises(gelcone.InputError, match="is empty; give at least one gel"):
        pump.replace(material=[])
    with pytest.raises(gelcone.InputError, match="PVC-DBA 4:2"):
        pump.replace(material=["PVC-DBA 4:1", "PVC-DBA 4:2"])


def test_members_of_an_ensemble_bear_the_names_of_their_gels(tmp_path):
    """Not those of the numbers that differ, unless one of them was changed."""
    gels = ["PVC-DBA 4:1", "PVC-DBA 8:1"]
    device = gelcone.find_device("soft-film").replace(material=gels, film="taut")
    found = gelcone.settled(device)
    assert found["material"].values.tolist() == gels
    assert [name for name, _ in members_of(found)] == [f"material {gel}" for gel in gels]
    gelcone.save(found, tmp_path / "settled.nc")
    assert gelcone.load(tmp_path / "settled.nc")["material"].values.tolist() == gels
    changed = gelcone.settled(device.replace({"material.shear_modulus": ["10 kPa", "20 kPa"]}))
    assert [name for name, _ in members_of(changed)][1].startswith("material.shear_modulus 20 kPa")


# --- gels that creep --------------------------------------------------------------------------------------------------

VHB = {
    "shear_modulus": "15.36 kPa",
    "relative_permittivity": 4.8,
    "stretch_limit": 110.0,
    "flow": "linear",
    "viscous_modulus_1": "26.06 kPa",
    "relaxation_time_1": "0.6074 s",
    "viscous_modulus_2": "26.53 kPa",
    "relaxation_time_2": "6.56 s",
    "viscous_modulus_3": "10.83 kPa",
    "relaxation_time_3": "61.25 s",
}
"""VHB 4910 of Wang et al. (2016) in Stewart and Anand's code."""


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_a_material_carries_its_branches_in_si(film):
    device = find_device("biased-pump").replace(material=Material(**VHB), film=film)
    model = device.to_model()
    assert (model.film.branches, model.film.flow, model.film.rested) == (3, "linear", "raised")
    moduli = [model.viscous_modulus_1, model.viscous_modulus_2, model.viscous_modulus_3]
    np.testing.assert_allclose(moduli, [1.697, 1.727, 0.705], atol=5e-4)
    assert model.relaxation_time_2 == pytest.approx(6.56 / device.scales.time, rel=1e-12)
    swept = device.replace({"material.relaxation_time_1": [0.1, 1.0]}).to_model()
    np.testing.assert_allclose(swept.relaxation_time_1, np.array([0.1, 1.0]) / device.scales.time)
    again = type(device).from_text(device.to_toml())
    assert again.to_model().system == model.system
    assert again.to_model().values == model.values


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"viscous_modulus_1": "9 kPa"}, "relaxation_time_1: is missing; viscous_modulus_1 is given"),
        ({"viscous_modulus_2": "9 kPa", "relaxation_time_2": "1 s"}, "viscous_modulus_2: there is no branch 1"),
        (
            {
                "viscous_modulus_1": "9 kPa",
                "relaxation_time_1": "1 s",
                "viscous_modulus_3": 1e3,
                "relaxation_time_3": 1,
            },
            "viscous_modulus_3: there is no branch 2; number them from 1",
        ),
        ({"relaxation_time_1": "1 s"}, "viscous_modulus_1: is missing; relaxation_time_1 is given"),
        ({"viscous_stretch_limit_2": 50.0}, "viscous_modulus_2: is missing; viscous_stretch_limit_2 is given"),
        ({"flow": "exp"}, "flow = 'exp': must be one of log, linear"),
        (VHB | {"viscous_stretch_limit_1": 50.0}, "the linear flow has none"),
        (VHB | {"viscous_stretch_limit_2": 50.0}, "viscous_stretch_limit_2: the linear flow has none"),
        ({"relaxation_time_1": "1 kPa", "viscous_modulus_1": "9 kPa"}, "relaxation_time_1"),
    ],
)
def test_branches_of_a_material_that_cannot_be_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        Material(**{"shear_modulus": "15 kPa", "relative_permittivity": 4.8, **given})


def test_a_film_that_does_not_creep_is_refused_with_a_remedy():
    with pytest.raises(InputError, match="'power film' does not creep; set film = membrane, wrinkling or taut"):
        find_device("biased-pump").replace(material=Material(**VHB), film=PowerFilm()).to_model()


def test_a_range_stays_where_another_number_is_changed_and_holds_its_own_ends():
    """Each number takes its own range and its own source with it."""
    given = {"shear_modulus": 9e3, "shear_modulus_range": [9e3, 1.2e4], "relative_permittivity": 5.0}
    given |= {
        "relative_permittivity_range": [4.0, 5.0],
        "sources": {"shear_modulus": "a", "relative_permittivity": "b"},
    }
    gel = Material(**given)
    stiffer, other = gel.replace(shear_modulus="10 kPa"), gel.replace(relative_permittivity=1.0)
    assert (stiffer.shear_modulus_range, other.relative_permittivity_range) == (None, None)
    assert list(stiffer.relative_permittivity_range) == [4.0, 5.0]
    assert list(other.shear_modulus_range) == [9e3, 1.2e4]
    assert (stiffer.sources, other.sources) == ({"relative_permittivity": "b"}, {"shear_modulus": "a"})
    assert gel.replace(sources={}).name == gel.name
    assert gel.replace(stretch_limit=30.0).sources == gel.sources


def test_numbers_of_gels_side_by_side_are_one_where_they_agree_and_left_out_where_one_is_unknown():
    one = Material(name="a", shear_modulus=1e4, relative_permittivity=5.0, dielectric_strength=1e7, resistivity=1e9)
    two = Material(name="b", shear_modulus=2e4, relative_permittivity=5.0, resistivity=2e9)
    both = side_by_side([one, two, one])
    np.testing.assert_array_equal(both.shear_modulus, [1e4, 2e4, 1e4])
    np.testing.assert_array_equal(both.resistivity, [1e9, 2e9, 1e9])
    assert both.relative_permittivity == 5.0
    assert both.dielectric_strength is None
    assert both.name == "a / b / a"
    creeping = [gel.replace(viscous_modulus_1=5e3, relaxation_time_1=0.1, flow="linear") for gel in (one, two)]
    assert side_by_side(creeping).flow == "linear"
    with pytest.raises(InputError, match="the flow rules of the gels differ; run the gels one by one"):
        side_by_side([creeping[0], creeping[1].replace(flow=None)])
    assert both.flow is None


def test_the_library_is_as_it_was_whatever_is_done_with_what_was_loaded():
    gels = load_materials()
    assert gels["VHB 4910"] is find_material("VHB 4910")
    gels.clear()
    gels["VHB 4910"] = None
    assert find_material("VHB 4910").viscous_modulus_1 == 82313.0
    assert len(load_materials()) > 3
