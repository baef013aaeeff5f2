"""Sensitivity: what a result changes per 1 % of a material, against closed forms and against errors made on purpose."""

from dataclasses import replace

import numpy as np
import pytest
from scattering_models import ggx, lambert

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.material import Conductor, Diffuse, Material, Measured
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.sensitivity import measure_sensitivities
from lumenray.engine.session import Session

pytestmark = pytest.mark.mitsuba

CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
BOTTOM_AND_SIDES = np.array(
    [[0, 1, 3], [0, 3, 2], [0, 4, 5], [0, 5, 1], [1, 5, 7], [1, 7, 3], [3, 7, 6], [3, 6, 2], [2, 6, 4], [2, 4, 0]]
)  # fmt: skip
TOP = np.array([[4, 5, 7], [4, 7, 6]])


def part(name, triangles, material, size):
    """Some faces of a box; their normals face inwards."""
    # Triangles of the sides are listed clockwise from outside, so that their normals point inwards.
    return Mesh(
        name, name, CORNERS * size, triangles, (material.id,), np.zeros(len(triangles), np.int32)
    )


def light_box(reflector, diffuser, lamp_place, size=(0.3, 0.2, 0.05)):
    """Session with a box of a reflector under a sheet of a diffuser, a small lamp in it."""
    walls, sheet = (
        Material("reflector", "Reflector", reflector),
        Material("diffuser", "Diffuser", diffuser),
    )
    lamp = PointLight(
        "lamp", "Lamp", Output(Quantity.LUMINOUS_FLUX, 100.0), np.array(lamp_place), 0.004
    )
    size = np.array(size)
    session = Session(witness=False)
    session.apply(
        SceneDelta(
            (
                walls,
                sheet,
                lamp,
                part("box", BOTTOM_AND_SIDES, walls, size),
                part("sheet", TOP, sheet, size),
            )
        )
    )
    return session, walls, sheet


@pytest.mark.parametrize("rho", [0.6, 0.985])
@pytest.mark.slow
def test_in_a_closed_matt_box_the_figure_is_that_of_the_furnace_series(rho):
    # A sphere-like closed box of one reflectance: all light together is 1 / (1 - rho) of the first arrival, so that of the
    # walls' mean illuminance d ln E / d ln rho = rho / (1 - rho). In a box it holds for the mean over all walls.
    wall = Material("wall", "Wall", Diffuse(Constant(rho)))
    lamp = PointLight("lamp", "Lamp", Output(Quantity.LUMINOUS_FLUX, 100.0), np.full(3, 0.5), 0.02)
    faces = np.concatenate([BOTTOM_AND_SIDES, TOP[:, ::-1]])
    session = Session(witness=False)
    session.apply(SceneDelta((wall, lamp, part("box", faces, wall, np.ones(3)))))
    grid = (np.arange(6) + 0.5) / 6
    u, v = (m.ravel() for m in np.meshgrid(grid, grid))
    places, normals = [], []
    for axis in range(3):
        for side in (0.0, 1.0):
            place = np.insert(np.stack([u, v], axis=1), axis, abs(side - 1e-4), axis=1)
            places.append(place)
            normals.append(np.tile(np.eye(3)[axis] * (1 - 2 * side), (len(u), 1)))
    made = measure_sensitivities(
        session,
        np.concatenate(places),
        np.concatenate(normals),
        StopRule(samples=512 if rho < 0.9 else 128),
    )
    assert [one.material for one in made] == ["wall"]
    exact = rho / (1 - rho)
    # Differences of a step h err by (h S)^2.
    assert made[0].mean == pytest.approx(exact, abs=4 * made[0].mean_error + 0.03 * exact)
    assert made[0].mean_error < 0.03 * exact


@pytest.mark.slow
def test_an_error_made_on_purpose_changes_what_the_figure_says():
    # A back-light: a reflector of a gloss white (measured) and an opal sheet (measured), a sensor right above the sheet.
    white = ggx(0.3, lambda cosine: 0.05 + 0.95 * (1 - cosine) ** 5)
    reflector = resample(lambda wi, wo: white(wi, wo) + 0.85 / np.pi, [550.0], tolerance=0.05)
    back, through = (resample(lambert(share), [550.0]) for share in (0.5, 0.4))
    opal = Measured(back, back, through, through)
    session, walls, _ = light_box(Measured(reflector, reflector), opal, (0.07, 0.1, 0.02))
    x, y = np.meshgrid(np.linspace(0.05, 0.25, 5), np.linspace(0.05, 0.15, 3))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.0501)], axis=1)
    up = np.tile([0.0, 0.0, -1.0], (len(places), 1))
    rule = StopRule(samples=4096)
    found = {one.material: one for one in measure_sensitivities(session, places, up, rule)}
    right = session.measure(places, up, StopRule(samples=32768), 99)
    # Another laboratory's table, 5 % too low.
    wrong = replace(reflector, values=reflector.values * np.float32(0.95))
    session.apply(SceneDelta((replace(walls, surface=Measured(wrong, wrong)),)))
    off = session.measure(places, up, StopRule(samples=32768), 98)
    change = off.illuminance.mean() / right.illuminance.mean() - 1.0
    predicted = 0.95 ** found["reflector"].mean - 1.0
    noise = (
        np.hypot(off.standard_error.mean(), right.standard_error.mean()) / right.illuminance.mean()
    )
    # The figure is that of small changes; of 5 % it is right to a tenth of itself.
    assert abs(change - predicted) < 0.1 * abs(change) + 4 * noise
    assert found["reflector"].mean > 1.0
    assert change < -0.05
    # Without the opal nothing would come: its own figure counts what it sends back too.
    assert found["diffuser"].mean > 0.9


def test_the_scene_is_as_before_and_materials_without_a_reflectance_are_left_out():
    session, walls, sheet = light_box(
        Diffuse(Constant(0.8)), Conductor("Al", 0.3), (0.1, 0.1, 0.02)
    )
    places, normals = np.array([[0.1, 0.1, 0.0001]]), np.array([[0.0, 0.0, 1.0]])
    made = measure_sensitivities(session, places, normals, StopRule(samples=64))
    assert [one.material for one in made] == ["reflector"]
    assert session.scene.materials["reflector"] is walls
    with pytest.raises(SceneError, match="no reflectance"):
        measure_sensitivities(session, places, normals, StopRule(samples=64), materials=[sheet.id])
    with pytest.raises(SceneError, match="no material"):
        measure_sensitivities(session, places, normals, StopRule(samples=64), materials=["x"])


def test_surfaces_are_scaled_where_no_law_fixes_them():
    both = Diffuse(Constant(0.5), Constant(0.2)).scaled(0.9)
    assert both.reflectance.value == pytest.approx(0.45)
    assert both.transmittance.value == pytest.approx(0.18)
    assert Conductor("Al").scaled(0.9) is None
    assert Measured(factor=2.0).scaled(0.5).factor == 1.0
