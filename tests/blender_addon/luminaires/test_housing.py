"""Housings that block light: others' light is shadowed as geometry says, the luminaire's own stays what its file says."""

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp
from eulumdat_files import as_bytes, parsed, small
from kept_scenes import KeptScene

from lumenray.blender_addon.luminaires import housing
from lumenray.blender_addon.luminaires.settings import settings_of
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.mesh import Placement

pytestmark = pytest.mark.usefixtures("extension")

HEIGHT = 0.06
"""Of the housing. [m]"""


@pytest.fixture
def luminaire(tmp_path):
    """A luminaire 2 m up that shines down alone, with a housing of 1.2 m by 0.3 m; its settings and half sizes."""
    path = tmp_path / "down.ldt"
    path.write_bytes(as_bytes(small()))
    bpy.ops.lumenray.add_luminaire(filepath=str(path))
    empty = bpy.context.object
    empty.location = (0.0, 0.0, 2.0)
    bpy.context.view_layer.update()
    file = parsed(small())
    return settings_of(empty), 0.5 * np.array(file.housing[:2])


def measure(places, samples=256):
    from lumenray.engine.session import Session

    stage = KeptScene(final=True)
    session = Session()
    session.apply(stage.step().delta)
    up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
    rule = StopRule(samples=samples)
    return session.measure(
        np.asarray(places), up, rule, reflections=0, method="paths", witness=False
    )


def test_a_lamp_above_is_shadowed_as_a_box_shadows_it(luminaire):
    settings, half = luminaire
    add_lamp("Above", value=4.0 * np.pi * 100.0).location = (0.0, 0.0, 4.0)
    settings.dimming = 0.0
    settings.blocks_light = True
    # The upper edges are seen from the lamp before what lies 4 m below it.
    edge = half * 4.0 / (2.0 - HEIGHT)
    inner, outer = 0.99 * edge, 1.01 * edge
    places = [(x, y, 0.0) for x in (0.0, inner[0]) for y in (0.0, inner[1])]
    places += [(outer[0], 0.0, 0.0), (0.0, outer[1], 0.0), (*outer, 0.0)]
    found = measure(places).illuminance
    away = np.linalg.norm(np.array(places) - [0.0, 0.0, 4.0], axis=1)
    bare = 100.0 * 4.0 / away**3
    np.testing.assert_allclose(found, np.where(np.arange(7) < 4, 0.0, bare), rtol=1e-4)
    settings.blocks_light = False
    np.testing.assert_allclose(measure(places).illuminance, bare, rtol=1e-4)


def test_its_own_light_stays_what_the_file_says(luminaire):
    settings, _ = luminaire
    places = [(0.0, 0.0, 1.9), (0.3, 0.1, 1.99), (0.0, 0.0, 0.0), (1.0, 0.5, 0.0), (3.0, 2.0, 0.0)]
    before = measure(places, 4096)
    settings.blocks_light = True
    after = measure(places, 4096)
    error = np.hypot(before.standard_error, after.standard_error)
    assert (np.abs(after.illuminance - before.illuminance) <= 4.0 * error + 1e-6).all()
    assert (error < 0.02 * before.illuminance).all()


def test_a_housing_comes_goes_and_moves_with_its_luminaire(luminaire):
    settings, _ = luminaire
    stage = KeptScene()
    stage.changes()
    settings.blocks_light = True
    changed, _ = stage.changes()
    (placed,) = [item for item in changed if isinstance(item, Placement)]
    np.testing.assert_allclose(placed.frame[:3, 3], [0.0, 0.0, 2.0])
    bpy.context.object.location.x = 1.0
    changed, _ = stage.changes()
    (moved,) = [item for item in changed if isinstance(item, Placement)]
    np.testing.assert_allclose(moved.frame[:3, 3], [1.0, 0.0, 2.0])
    bpy.context.object.scale = (2.0, 2.0, 2.0)
    changed, _ = stage.changes()
    assert all(np.linalg.norm(item.frame[:3, 0]) == pytest.approx(1.0) for item in changed)
    settings.blocks_light = False
    _, removed = stage.changes()
    assert placed.id in removed


def test_where_light_goes_up_a_housing_stands_within_a_box_alone():
    up = small(polars=(0, 90, 180), rows=[[100, 50, 100]] * 8)
    file = parsed(up)
    assert housing.upward_share(file.distribution) == pytest.approx(0.5, abs=0.01)
    with pytest.raises(SceneError, match="own light passes"):
        housing.make_housing(file, file.distribution, file.opening)
    # Luminous heights make a box of the opening.
    up[18:22] = [40] * 4
    file = parsed(up)
    assert file.opening.shape == "box"
    made = housing.make_housing(file, file.distribution, file.opening)
    inside = 0.5 * np.array(file.opening.size)
    assert (np.abs(made.vertices) < inside).all()
    down = parsed(small())
    made = housing.make_housing(down, down.distribution, down.opening)
    assert made.vertices[:, 2].min() > 0.0
    assert made.vertices[:, 2].max() == pytest.approx(HEIGHT)
    corners = made.vertices[made.triangles]
    volume = (
        np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
    )
    assert volume == pytest.approx(1.2 * 0.3 * (HEIGHT - 0.001))


def test_files_without_a_housing_say_so(write_photometry):
    bpy.ops.lumenray.add_luminaire(filepath=write_photometry())
    settings_of(bpy.context.object).blocks_light = True
    stage = KeptScene()
    rows = [str(row) for row in stage.step().report.rows]
    assert any("states no housing" in each for each in rows)
