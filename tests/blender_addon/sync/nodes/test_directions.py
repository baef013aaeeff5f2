"""Nodes that turn and compare vectors, beside Cycles."""

import pytest
from material_trees import add_texture, noise_image, output_of

pytestmark = pytest.mark.blender

ROTATIONS = ("AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ")


@pytest.fixture
def picture(tree):
    """A picture that varies, at the pixels that are compared."""
    return add_texture(tree, noise_image(3)).outputs[0]


@pytest.mark.parametrize("is_inverse", [False, True])
@pytest.mark.parametrize("kind", ROTATIONS)
def test_vectors_are_turned_as_in_cycles(tree, agree, picture, kind, is_inverse):
    settings = {"rotation_type": kind, "invert": is_inverse}
    values = {"Center": (0.1, -0.2, 0.3)}
    if kind == "EULER_XYZ":
        values["Rotation"] = (0.3, 0.7, -0.4)
    else:
        values["Angle"] = 0.8
    if kind == "AXIS_ANGLE":
        values["Axis"] = (0.4, 0.2, -1.3)
    node = tree.add("VectorRotate", attributes=settings, Vector=picture, **values)
    agree(tree, node.outputs[0])


def test_an_angle_that_varies_turns_every_place_by_its_own(tree, agree, picture):
    angle = add_texture(tree, noise_image(4)).outputs[0]
    node = tree.add("VectorRotate", Vector=picture, Angle=angle)
    agree(tree, node.outputs[0])


@pytest.mark.parametrize("output", ["Normal", "Dot"])
def test_a_direction_is_compared_as_in_cycles(tree, agree, picture, output):
    node = tree.add("Normal", Normal=picture)
    node.outputs["Normal"].default_value = (0.6, 0.3, 0.2)
    agree(tree, output_of(node, output))
