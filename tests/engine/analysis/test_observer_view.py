"""What observers see against the formula of CIE 117, and which way their eyes look."""

import numpy as np
import pytest
from small_scenes import box, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.analysis.glare import (
    FlatOpenings,
    Observer,
    guth_position_index,
    sight_angles,
    solid_angles,
    unified_glare_rating,
)
from lumenray.engine.analysis.observer_glare import rate_observer
from lumenray.engine.analysis.observer_view import eye_camera
from lumenray.engine.errors import SceneError
from lumenray.engine.formats.luminance_picture import view_of_camera
from lumenray.engine.scene.material import Diffuse, Emission, Material
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.views import ViewSettings

EYE, AHEAD = np.array([0.0, 0.0, 1.2]), np.array([0.0, 1.0, 0.0])

CENTRES = np.array([(-1.5, 2.5, 3.0), (1.5, 2.5, 3.0), (-1.5, 5.0, 3.0), (1.5, 5.0, 3.0)])

SIDE = 0.6


@pytest.mark.mitsuba
@pytest.mark.slow
def test_panels_are_rated_as_by_the_formula():
    """Four panels of 5000 cd/m2 before surroundings of 30 cd/m2, whose light alone is indirect."""
    black = Diffuse(Constant(0.0))
    walls = Material("walls", "walls", black, Emission(luminance=30.0))
    bright = Material("panel", "panel", black, Emission(luminance=5000.0, two_sided=False))
    shell = box(20.0, 20.0, 20.0, "walls")
    shell = type(shell)(**{**vars(shell), "vertices": shell.vertices - 10.0})
    panels = [
        quad(f"{k}", (x - SIDE / 2, y - SIDE / 2, z), (0.0, SIDE, 0.0), (SIDE, 0.0, 0.0), "panel")
        for k, (x, y, z) in enumerate(CENTRES)
    ]
    camera = eye_camera(EYE, AHEAD, 800)
    session = session_of(walls, bright, shell, *panels)
    pictures = []
    for seed in (1, 2):
        settings = ViewSettings(StopRule(samples=4), seed, method="paths")
        pictures.append(session.render(camera, settings).tristimulus[..., 1])
    made = rate_observer(np.stack(pictures), view_of_camera(camera))
    observer = Observer(EYE, AHEAD)
    openings = FlatOpenings(CENTRES, np.tile([0.0, 0.0, -1.0], (4, 1)), np.full(4, SIDE**2))
    index = guth_position_index(*sight_angles(observer, CENTRES))
    solid = solid_angles(observer, openings)
    # The panels hide a little of the surroundings.
    background = 30.0 * (
        1.0 - (solid * CENTRES[:, 1] / np.linalg.norm(CENTRES - EYE, axis=1)).sum() / np.pi
    )
    wanted = unified_glare_rating(background, np.full(4, 5000.0), solid, index)
    value, error = made["background"]
    assert abs(value - background) < 3.0 * error
    assert error < 0.03 * background
    # The openings are not as small as the formula takes them for.
    value, error = made["ugr"]
    assert abs(value - wanted) < 3.0 * error
    assert error < 0.25


@pytest.mark.parametrize("ahead", [(0, 1, 0), (1, -2, 0.5), (0, 0, 1), (0, 0, -3)])
def test_the_picture_of_an_eye_has_its_line_of_sight_in_the_middle(ahead):
    camera = eye_camera(EYE, ahead, 101)
    frame = np.asarray(camera.frame)
    middle, _ = view_of_camera(camera).directions(50.5, 50.5)
    assert np.allclose(frame[:3, :3] @ middle, np.array(ahead) / np.linalg.norm(ahead))
    assert np.allclose(frame[:3, :3].T @ frame[:3, :3], np.eye(3))
    assert np.linalg.det(frame[:3, :3]) == pytest.approx(1.0)
    # Up in the picture is up in the world, as far as it can be.
    assert frame[2, 1] >= -1e-12


def test_an_observer_needs_a_line_of_sight():
    with pytest.raises(SceneError, match="line of sight"):
        eye_camera(EYE, (0.0, 0.0, 0.0), 64)
