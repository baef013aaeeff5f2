"""Sheen of the Principled BSDF and the Sheen BSDF."""

import pytest

from lumenray.engine.scene.material import Black, Coated, Glossy, Mix, Sheen, Varnish
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.scene.texture import ImageTexture

pytestmark = pytest.mark.blender


def test_sheen_lies_over_the_coat_and_all_parts(tree, convert):
    values = {"Sheen_Weight": 0.4, "Sheen_Roughness": 0.3, "Coat_Weight": 1.0, "Metallic": 0.5}
    result, rows = convert(tree.surface(tree.add("BsdfPrincipled", **values)))
    assert rows == []
    assert isinstance(result.surface, Mix)
    for part, base in ((result.surface.first, Coated), (result.surface.second, Glossy)):
        assert isinstance(part, Sheen)
        assert part.weight == pytest.approx(0.4)
        assert part.roughness == pytest.approx(0.3)
        assert not part.is_velvet
        assert isinstance(part.base, Varnish)
        assert isinstance(part.base.base, base)


@pytest.mark.parametrize(
    ("distribution", "is_velvet"), [("MICROFIBER", False), ("ASHIKHMIN", True)]
)
def test_the_sheen_shader_is_fibres_alone(tree, convert, distribution, is_velvet):
    node = tree.add("BsdfSheen", Color=(0.8, 0.4, 0.2), Roughness=0.7)
    node.distribution = distribution
    result, rows = convert(tree.surface(node))
    surface = result.surface
    assert rows == []
    assert isinstance(surface.base, Black)
    assert isinstance(surface.tint, Rgb)
    assert (surface.weight, surface.is_velvet) == (1.0, is_velvet)
    assert surface.roughness == pytest.approx(0.7)


def test_the_weight_may_vary_by_place_and_a_varying_tint_becomes_its_mean(tree, convert):
    picture = tree.add("TexChecker", Vector=tree.add("UVMap").outputs[0], Scale=2.0)
    values = {"Sheen_Weight": picture.outputs[1], "Sheen_Tint": picture.outputs[0]}
    result, (row,) = convert(tree.surface(tree.add("BsdfPrincipled", **values)))
    assert isinstance(result.surface.weight, ImageTexture)
    assert not isinstance(result.surface.tint, ImageTexture)
    assert "tint of the sheen" in row["message"]


def test_sheen_dims_the_light_below_it(tree, convert):
    values = {"Emission_Strength": 1.0, "Sheen_Roughness": 1.0}
    plain, _ = convert(tree.surface(tree.add("BsdfPrincipled", **values)))
    dimmed, (row,) = convert(tree.surface(tree.add("BsdfPrincipled", Sheen_Weight=1.0, **values)))
    # Microfibres of a roughness of 1 send on 45 % of even light.
    share = dimmed.emission.luminance / plain.emission.luminance
    assert share == pytest.approx(0.553, abs=0.01)
    assert row["severity"] == "info"


def test_white_fibres_are_white(tree, convert):
    result, _ = convert(tree.surface(tree.add("BsdfSheen", Color=(1.0, 1.0, 1.0))))
    assert result.surface.tint == Constant(1.0)
