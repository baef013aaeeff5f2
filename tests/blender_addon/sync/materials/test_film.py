"""Thin films of the Principled, Glass and Metallic BSDF."""

import pytest

from lumenray.engine.scene.film import Film
from lumenray.engine.scene.material import Coated, Dielectric, Glossy

pytestmark = pytest.mark.blender

FILM = {"Thin_Film_Thickness": 420.0, "Thin_Film_IOR": 1.5}


def is_film(film):
    return isinstance(film, Film) and (film.thickness, film.ior) == (420.0, 1.5)


@pytest.mark.parametrize(
    ("values", "kind"),
    [({}, Coated), ({"Metallic": 1.0}, Glossy), ({"Transmission_Weight": 1.0}, Dielectric)],
)
def test_all_parts_of_a_principled_surface_lie_below_the_film(tree, convert, values, kind):
    result, rows = convert(tree.surface(tree.add("BsdfPrincipled", **FILM, **values)))
    assert isinstance(result.surface, kind)
    assert is_film(result.surface.film)
    assert {row["severity"] for row in rows} <= {"info"}
    # What differs from Blender is said: paint below films and films seen from inside glass.
    assert len(rows) == (0 if kind is Glossy else 1)


def test_a_film_lies_over_paint_that_has_no_highlight_of_its_own(tree, convert):
    node = tree.add("BsdfPrincipled", Specular_IOR_Level=0.0, **FILM)
    surface = convert(tree.surface(node))[0].surface
    assert is_film(surface.film)
    assert surface.ior == pytest.approx(1.0)


def test_glass_and_metal_nodes_have_films(tree, convert):
    glass = convert(tree.surface(tree.add("BsdfGlass", **FILM)))[0].surface
    assert isinstance(glass, Dielectric)
    assert is_film(glass.film)
    metal, rows = convert(tree.surface(tree.add("BsdfMetallic", **FILM)))
    assert rows == []
    assert is_film(metal.surface.film)
    assert metal.surface.film.base is None


def test_a_metal_by_its_index_keeps_it_below_the_film(tree, convert):
    node = tree.add("BsdfMetallic", IOR=(0.2, 0.4, 1.3), **FILM)
    node.fresnel_type = "PHYSICAL_CONDUCTOR"
    base = convert(tree.surface(node))[0].surface.film.base
    assert list(base.values) == pytest.approx([1.3, 0.4, 0.2])
    assert list(base.wavelengths) == sorted(base.wavelengths)


@pytest.mark.parametrize("thickness", [0.0, 0.05])
def test_what_blender_takes_for_no_film_is_none(tree, convert, thickness):
    node = tree.add("BsdfPrincipled", Thin_Film_Thickness=thickness)
    result, rows = convert(tree.surface(node))
    assert result.surface.film is None
    assert rows == []


def test_a_thickness_and_a_metal_that_vary_become_their_means(tree, convert):
    picture = tree.add("TexChecker", Vector=tree.add("UVMap").outputs[0], Scale=2.0)
    picture.inputs["Color1"].default_value = (400.0, 400.0, 400.0, 1.0)
    picture.inputs["Color2"].default_value = (200.0, 200.0, 200.0, 1.0)
    shade = tree.add("TexChecker", Vector=tree.add("UVMap").outputs[0], Scale=2.0)
    values = {"Thin_Film_Thickness": picture.outputs[0], "Base_Color": shade.outputs[0]}
    node = tree.add("BsdfMetallic", **values)
    result, rows = convert(tree.surface(node))
    assert result.surface.film.thickness == pytest.approx(300.0, rel=0.01)
    said = " ".join(row["message"] for row in rows)
    assert "Thin Film Thickness varies" in said
    assert "below a thin film varies" in said
