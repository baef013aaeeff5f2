"""Pieces of cloth as meshes: seamless side by side, faces outwards, as many as can be held."""

import numpy as np
import pytest

from lumenray.engine.cloth.mesh import KINDS, mesh_of, write_obj
from lumenray.engine.cloth.reader import parse_cloth, read_cloth
from lumenray.engine.errors import SceneError
from lumenray.libraries import cloths

CLOTH = {
    "lumenray_cloth": 1,
    "name": "Twill",
    "warp": {"width_mm": 0.2, "height_mm": 0.1},
    "weft": {"width_mm": 0.16},
    "weave": {"twill": [2, 1], "warp_pitch_mm": 0.3, "weft_pitch_mm": 0.25},
}


def test_copies_join_without_a_seam():
    """The first ring of a yarn, shifted by the size, is its last."""
    mesh = mesh_of(parse_cloth(CLOTH), 2)
    assert mesh.size == pytest.approx([6 * 0.3e-3, 6 * 0.25e-3])
    rings = mesh.points.reshape(12, -1, 16, 3)
    shift = np.zeros((12, 1, 3))
    shift[:6, :, 1], shift[6:, :, 0] = mesh.size[1], mesh.size[0]
    assert np.abs(rings[:, 0] + shift - rings[:, -1]).max() < 1e-9


def test_faces_look_outwards():
    """By the order of corners, as the normals at them do."""
    mesh = mesh_of(parse_cloth(CLOTH))
    one, two, three, four = (mesh.points[mesh.quads[:, k]] for k in range(4))
    facing = np.cross(three - one, four - two)
    outward = (mesh.normals[mesh.quads].sum(axis=1) * facing).sum(axis=1)
    assert (outward > 0.0).all()


def test_obj_can_be_read_back(tmp_path):
    mesh = mesh_of(read_cloth(cloths.presets()["velour"]))
    write_obj(tmp_path / "velour.obj", mesh, "Velour")
    lines = (tmp_path / "velour.obj").read_text().splitlines()
    assert sum(line.startswith("v ") for line in lines) == len(mesh.points)
    assert sum(line.startswith("f ") for line in lines) == len(mesh.quads)
    assert [line[2:] for line in lines if line.startswith("o ")] == list(KINDS)


def test_a_mesh_that_is_too_large_is_said():
    with pytest.raises(SceneError, match="faces, expected"):
        mesh_of(parse_cloth(CLOTH), 64)
