"""Measured surfaces in scenes: lux maps, sensors, pictures and the way to the engine's process."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake, lamp
from scattering_models import ggx, lambert
from small_scenes import box, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, Quantity, SunLight
from lumenray.engine.scene.material import Diffuse, Material, Measured
from lumenray.engine.scene.scattering import PatchBasis, PatchMatrix, TensorTree
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.views import ViewSettings
from lumenray.engine.worker import codec

pytestmark = pytest.mark.mitsuba


def matt(reflectance):
    """Lambert's law as a table, with a hair of colour so that nothing is simplified."""
    return resample(lambert(reflectance), [550.0], incidences=np.radians([0.0, 40.0, 89.0]))


@pytest.mark.slow
def test_lux_maps_in_a_measured_room_are_those_of_a_matt_one():
    table = matt(0.6)
    maps = []
    for surface in (Measured(table, table), Diffuse(Constant(0.6))):
        room, wall = box(2.0, 2.0, 2.0, "wall"), Material("wall", "Wall", surface)
        made = bake((room, wall, lamp((1.0, 1.0, 1.4))), ("box",), samples=256, density=4.0)
        maps.append(made.maps[0])
    ours, theirs = maps
    noise = np.hypot(ours.mean_standard_error, theirs.mean_standard_error)
    # Maps of matt surfaces read interreflection from cells, whose stated bias is below 0.5 %.
    assert abs(ours.mean - theirs.mean) < 4 * noise + 0.005 * theirs.mean
    # And the closed form: with all light together 1 / (1 - rho) of the lamp's, on 24 m2.
    assert ours.mean == pytest.approx(1000.0 / 24.0 / (1.0 - 0.6), rel=0.01)


def test_light_through_a_measured_sheet_is_that_of_a_matt_one():
    back, through = matt(0.3), matt(0.5)
    readings = []
    for surface in (Measured(back, back, through, through), Diffuse(Constant(0.3), Constant(0.5))):
        session = session_of(
            Material("opal", "Opal", surface),
            quad("sheet", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "opal"),
            lamp((0.0, 0.0, 1.0), radius=0.05),
        )
        places = np.array([[x, 0.0, -0.5] for x in (-0.6, 0.0, 0.6)])
        made = session.measure(places, np.tile([0.0, 0.0, 1.0], (3, 1)), StopRule(samples=1 << 14))
        readings.append(made)
    ours, theirs = readings
    noise = np.hypot(ours.standard_error, theirs.standard_error)
    assert (np.abs(ours.illuminance - theirs.illuminance) < 4 * noise).all()
    assert theirs.illuminance.min() > 10 * noise.max()


def test_klems_blinds_pass_light_one_way():
    # All light that comes within 5 degrees of the normal goes to the ring of 40 degrees on the side of +x, half of it.
    basis = PatchBasis(
        np.radians([0, 5, 15, 25, 35, 45, 55, 65, 75, 90.0]),
        np.array([1, 8, 16, 20, 24, 24, 24, 16, 12], np.int32),
    )
    count = int(basis.counts.sum())
    values = np.zeros((count, count, 1), np.float32)
    target = 1 + 8 + 16 + 20
    solid = np.pi * (np.cos(np.radians(35)) ** 2 - np.cos(np.radians(45)) ** 2) / 24
    values[0, target, 0] = 0.5 / solid
    from lumenray.engine.scattering.data.patches import transposed

    matrix = PatchMatrix(basis, basis, np.array([550.0]), values)
    surface = Measured(front_transmission=matrix, back_transmission=transposed(matrix))
    # The sheet faces up, a sun stands at the zenith: light comes to its front.
    sun = SunLight(
        "sun", "Sun", Output(Quantity.ILLUMINANCE, 1000.0), np.array([0.0, 0.0, -1.0]), 0.0
    )
    session = session_of(
        Material("blind", "Blind", surface),
        quad("sheet", (-0.5, -0.5, 0), (1, 0, 0), (0, 1, 0), "blind"),
        sun,
    )
    reach = np.tan(np.radians(40.0))
    places = np.array([[reach * 1.0, 0.0, -1.0], [-reach * 1.0, 0.0, -1.0]])
    made = session.measure(places, np.tile([0.0, 0.0, 1.0], (2, 1)), StopRule(samples=1 << 15))
    # Both see the sun beside the sheet. In the beam: luminance by 1000 lx * 0.5 / solid over the patch, all of which the
    # sheet fills: 500 lx more.
    direct, error = 1000.0, made.standard_error[0]
    assert made.illuminance[0] == pytest.approx(direct + 500.0, abs=4 * error + 2.0)
    assert error < 20.0
    assert made.illuminance[1] == pytest.approx(direct, rel=1e-4)


@pytest.mark.slow
def test_the_grain_follows_the_coordinates():
    """Turning the coordinates by 90 degrees, or the sample, is the same."""
    table = resample(
        ggx(0.5, along=0.12),
        [550.0],
        incidences=np.radians([0.0, 25.0, 50.0]),
        rotations=np.arange(8) * np.pi / 4,
        is_symmetric=False,
        tolerance=0.5,
        most=1 << 15,
    )
    lit = lamp((0.0, 0.5, 0.6), radius=0.02)
    readings = []
    flat = quad("plate", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "metal")
    turned = replace(flat, uv_maps={"UV": flat.uv_maps["UV"][..., ::-1].copy()})
    look = Camera(np.eye(4), Projection.ORTHOGRAPHIC, 8, 8, 1.6, 1.6)
    frame = np.eye(4)
    frame[2, 3] = 3.0
    for mesh, rotation in ((flat, 0.0), (turned, 0.0), (flat, np.pi / 2)):
        metal = Material("metal", "Metal", Measured(table, table, rotation=rotation))
        session = session_of(metal, mesh, lit)
        picture = session.render(replace(look, frame=frame), ViewSettings(StopRule(samples=256)))
        readings.append((picture.tristimulus[..., 1], picture.luminance_error))
    straight, by_coordinates, by_rotation = readings
    both = np.hypot(by_coordinates[1], by_rotation[1])
    assert (np.abs(by_coordinates[0] - by_rotation[0]) < 4.5 * both + 0.01 * by_rotation[0]).all()
    # The streak of light goes the other way: somewhere it is many times brighter, and not only where next to none is.
    least = 1e-3 * by_rotation[0].max()
    assert (straight[0] > 5.0 * np.maximum(by_rotation[0], least)).any()


def test_scattering_arrives_in_the_engines_process():
    table = replace(matt(0.5), direct=np.full((1, 3, 1), 0.1, np.float32), error=0.01)
    basis = PatchBasis(np.radians([0.0, 45.0, 90.0]), np.array([1, 4], np.int32))
    matrix = PatchMatrix(basis, basis, np.array([550.0]), np.full((5, 5, 1), 0.1, np.float32))
    tree = TensorTree(
        3, np.full((1, 8), -1, np.int32), np.array([550.0]), np.array([[0.2]], np.float32)
    )
    surface = Measured(table, tree, matrix, matrix, 0.3, 0.9)
    tree_, parts, size = codec.encode(Material("m", "M", surface))
    block = bytearray(size)
    for offset, array in parts:
        block[offset : offset + array.nbytes] = array.tobytes()
    made = codec.decode(codec.from_text(codec.to_text(tree_)), bytes(block)).surface
    assert made.factor == 0.9
    assert np.array_equal(made.front_reflection.values, table.values)
    assert np.array_equal(made.front_reflection.direct, table.direct)
    assert np.array_equal(made.back_reflection.children, tree.children)
    assert np.array_equal(made.front_transmission.incoming.bounds, basis.bounds)
