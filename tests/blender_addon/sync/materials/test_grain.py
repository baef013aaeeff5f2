"""Anisotropy of shader nodes: widths as Cycles splits them, and what the tangent follows."""

import numpy as np
import pytest

from lumenray.engine.scene.material import Coated, Glossy, Grain
from lumenray.engine.scene.texture import ImageTexture

pytestmark = pytest.mark.blender


def widths(surface):
    """Widths of the facets along the tangent and across it."""
    alpha = surface.roughness**2
    return alpha * surface.grain.stretch, alpha / surface.grain.stretch


def test_principled_splits_the_width_by_the_aspect(tree, convert):
    values = {"Metallic": 1.0, "Roughness": 0.5, "Anisotropic": 0.8, "Anisotropic_Rotation": 0.25}
    result, rows = convert(tree.surface(tree.add("BsdfPrincipled", **values)))
    assert isinstance(result.surface, Glossy)
    aspect = np.sqrt(1.0 - 0.9 * 0.8)
    np.testing.assert_allclose(widths(result.surface), (0.25 / aspect, 0.25 * aspect), rtol=1e-5)
    assert result.surface.grain.rotation == pytest.approx(0.25)
    assert result.surface.grain.axis == 2
    assert [row["severity"] for row in rows] == ["info"]


def test_the_base_and_the_metal_lie_alike(tree, convert):
    values = {"Metallic": 0.5, "Roughness": 0.3, "Anisotropic": 0.5}
    result, _ = convert(tree.surface(tree.add("BsdfPrincipled", **values)))
    assert isinstance(result.surface.first, Coated)
    assert result.surface.first.grain == result.surface.second.grain
    assert result.surface.first.grain is not None


@pytest.mark.parametrize(("amount", "stretch"), [(0.6, 0.4), (-0.6, 2.5)])
def test_glossy_is_narrower_along_the_tangent_by_its_anisotropy(tree, convert, amount, stretch):
    node = tree.add("BsdfAnisotropic", Roughness=0.2, Anisotropy=amount)
    result, rows = convert(tree.surface(node))
    assert result.surface.grain == Grain(pytest.approx(stretch), 0.0, 2)
    assert rows == []


@pytest.mark.parametrize(
    ("settings", "axis", "uv_map"),
    [
        ({"direction_type": "RADIAL", "axis": "X"}, 0, ""),
        ({"direction_type": "RADIAL", "axis": "Y"}, 1, ""),
        ({"direction_type": "UV_MAP", "uv_map": "Other"}, None, "Other"),
    ],
)
def test_a_tangent_node_says_what_facets_lie_along(tree, convert, settings, axis, uv_map):
    tangent = tree.nodes.new("ShaderNodeTangent")
    for name, value in settings.items():
        setattr(tangent, name, value)
    node = tree.add("BsdfMetallic", Roughness=0.2, Anisotropy=0.5, Tangent=tangent.outputs[0])
    result, rows = convert(tree.surface(node))
    assert (result.surface.grain.axis, result.surface.grain.uv_map) == (axis, uv_map)
    assert result.surface.has_grain == (axis is None)
    assert rows == []


def test_a_rotation_may_vary_by_place(tree, convert):
    picture = tree.add("TexChecker", Vector=tree.add("UVMap").outputs[0], Scale=2.0)
    node = tree.add("BsdfMetallic", Roughness=0.2, Anisotropy=0.5, Rotation=picture.outputs[1])
    result, _ = convert(tree.surface(node))
    assert isinstance(result.surface.grain.rotation, ImageTexture)
    assert result.surface.pictures == (result.surface.grain.rotation,)


def test_a_tangent_of_another_kind_is_told(tree, convert):
    other = tree.add("CombineXYZ", X=1.0)
    node = tree.add("BsdfMetallic", Roughness=0.2, Anisotropy=0.5, Tangent=other.outputs[0])
    result, (row,) = convert(tree.surface(node))
    assert result.surface.grain.axis == 2
    assert "tangent" in row["message"]
