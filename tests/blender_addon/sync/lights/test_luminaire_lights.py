"""Lights and empties with a photometric file: size, axes, amount and spectrum of the engine's light."""

import gc

import bpy
import numpy as np
import pytest
from blender_luminaires import add_luminaire, candelas
from conversion import converted_light
from mathutils import Euler, Matrix
from photometric_files import EVEN, FOUR, FULL_FLUX, SIDEWAYS, write_ies

from lumenray.blender_addon.luminaires.settings import settings_of
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import Luminaire, PointLight, Quantity
from lumenray.engine.scene.scene import content_digest
from lumenray.engine.scene.spectrum import Blackbody, Illuminant, Rgb
from lumenray.engine.session import Session

pytestmark = pytest.mark.usefixtures("extension")


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA", "EMPTY"])
def test_every_kind_takes_a_file(kind, write_photometry):
    lamp = add_luminaire(kind, write_photometry())
    lamp.location = (1.0, 2.0, 3.0)
    light, rows = converted_light(lamp)
    assert isinstance(light, Luminaire)
    assert rows == []
    assert light.output.quantity is Quantity.LUMINOUS_FLUX
    assert light.output.value == pytest.approx(FULL_FLUX)
    assert (light.opening.shape, light.opening.size) == ("rectangle", (1.2, 0.3, 0.0))
    np.testing.assert_allclose(light.frame[:3, 3], (1, 2, 3))
    np.testing.assert_allclose(light.frame[:3, :3], np.eye(3), atol=1e-7)
    settings_of(lamp).use_file = False
    before = converted_light(lamp)[0] if kind != "EMPTY" else None
    assert not isinstance(before, Luminaire)


def test_a_sun_takes_none():
    assert settings_of(add_luminaire("SUN")) is None


@pytest.mark.parametrize(
    ("kind", "shape", "size"),
    [
        ("POINT", "ellipsoid", (0.5, 0.5, 0.5)),
        ("SPOT", "ellipsoid", (0.5, 0.5, 0.5)),
        ("AREA", "ellipse", (0.4, 0.8, 0.0)),
        ("EMPTY", "point", (0.0, 0.0, 0.0)),
    ],
)
def test_a_light_shines_from_its_own_size(kind, shape, size, write_photometry):
    lamp = add_luminaire(kind, write_photometry())
    settings_of(lamp).emission = "LIGHT"
    if kind == "AREA":
        lamp.data.shape, lamp.data.size, lamp.data.size_y = "ELLIPSE", 0.2, 0.8
        lamp.scale.x = 2.0
    elif kind != "EMPTY":
        lamp.data.shadow_soft_size = 0.25
    opening = converted_light(lamp)[0].opening
    assert opening.shape == shape
    assert opening.size == pytest.approx(size)
    settings_of(lamp).emission = "POINT"
    assert converted_light(lamp)[0].opening.shape == "point"


def test_the_beam_follows_the_object_and_c0_its_x_axis(write_photometry):
    lamp = add_luminaire(path=write_photometry(FOUR))
    lamp.rotation_euler = turn = Euler((0.3, -0.7, 1.9))
    light, _ = converted_light(lamp)
    world = SIDEWAYS @ np.array(turn.to_matrix()).T
    np.testing.assert_allclose(candelas(light, world), [100, 200, 300, 400], rtol=1e-5)
    np.testing.assert_allclose(light.frame[:3, :3], turn.to_matrix(), atol=1e-6)


def test_the_rotation_turns_c0_but_not_the_opening(write_photometry):
    lamp = add_luminaire(path=write_photometry(FOUR.replace("2 0 0 0\n", "2 0.3 1.2 0\n")))
    settings_of(lamp).rotation = np.pi / 2
    light, _ = converted_light(lamp)
    # C0 now looks along +y, so +x sees what was C270.
    np.testing.assert_allclose(candelas(light, SIDEWAYS), [400, 100, 200, 300], rtol=1e-5)
    np.testing.assert_allclose(light.frame[:3, :3], np.eye(3), atol=1e-7)
    assert light.opening.size == (1.2, 0.3, 0.0)


def test_clockwise_files_are_mirrored(write_photometry):
    lamp = add_luminaire(path=write_photometry(FOUR))
    settings_of(lamp).mirror = True
    np.testing.assert_allclose(candelas(converted_light(lamp)[0], SIDEWAYS), [100, 400, 300, 200])
    settings_of(lamp).rotation = np.pi / 2
    np.testing.assert_allclose(
        candelas(converted_light(lamp)[0], SIDEWAYS), [200, 100, 400, 300], rtol=1e-5
    )


def test_type_b_can_be_flipped_left_for_right(write_photometry):
    angles = [-90, -45, 0, 45, 90]
    text = write_ies(
        lambda h, v: 500.0 + 100.0 * np.sin(h) + 10.0 * np.sin(v) * np.cos(h), angles, angles, "B"
    )
    lamp = add_luminaire(path=write_photometry(text))
    right, left, up = [1, 0, -1], [-1, 0, -1], [0, 1, -1]
    side = 100.0 * np.sin(np.pi / 4)
    above = 10.0 * np.sin(np.pi / 4)
    light, _ = converted_light(lamp)
    expected = [500 + side, 500 - side, 500 + above]
    np.testing.assert_allclose(candelas(light, [right, left, up]), expected, rtol=1e-5)
    settings_of(lamp).flip_h = True
    light, _ = converted_light(lamp)
    expected = [500 - side, 500 + side, 500 + above]
    np.testing.assert_allclose(candelas(light, [right, left, up]), expected, rtol=1e-5)
    settings_of(lamp).mirror = True
    np.testing.assert_allclose(
        candelas(converted_light(lamp)[0], [right, left, up]), expected, rtol=1e-5
    )


def test_a_mirrored_object_mirrors_its_light(write_photometry):
    lamp = add_luminaire(path=write_photometry(FOUR))
    lamp.scale = (-1.0, 1.0, 1.0)
    light, _ = converted_light(lamp)
    assert np.linalg.det(light.frame[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(candelas(light, SIDEWAYS), [300, 200, 100, 400], rtol=1e-5)


def test_scale_moves_but_does_not_enlarge_the_opening(write_photometry):
    lamp = add_luminaire(path=write_photometry())
    lamp.location.x = 300.0
    light, rows = converted_light(lamp, scale=0.01)
    assert light.frame[0, 3] == pytest.approx(3.0)
    assert light.opening.size == (1.2, 0.3, 0.0)
    assert rows == []
    lamp.scale = (2.0, 2.0, 2.0)
    light, rows = converted_light(lamp)
    assert light.opening.size == (1.2, 0.3, 0.0)
    assert "scaled" in rows[0].message
    np.testing.assert_allclose(light.frame[:3, :3], np.eye(3), atol=1e-7)
    lamp.scale = (0.0, 1.0, 1.0)
    light, rows = converted_light(lamp)
    assert light is None
    assert "scale is zero" in rows[0].message


def test_a_sheared_object_keeps_a_rigid_frame(write_photometry):
    lamp = add_luminaire(path=write_photometry())
    parent = add_luminaire("EMPTY")
    parent.scale = (1.0, 3.0, 1.0)
    lamp.parent, lamp.rotation_euler = parent, (0.0, 0.0, 0.6)
    light, rows = converted_light(lamp)
    axes = light.frame[:3, :3]
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-6)
    assert any("sheared" in row.message for row in rows)


def test_every_factor_of_the_amount_counts(write_photometry):
    lamp = add_luminaire(path=write_photometry())
    settings = settings_of(lamp)
    settings.dimming, settings.maintenance_factor, settings.lamp_factor = 0.5, 0.8, 1.25
    assert converted_light(lamp)[0].output.value == pytest.approx(0.5 * FULL_FLUX, rel=1e-6)
    settings.amount, settings.luminous_flux = "LUMENS", 3000.0
    assert converted_light(lamp)[0].output.value == pytest.approx(1500.0, rel=1e-6)
    settings.dimming = 0.0
    assert converted_light(lamp) == (None, [])


@pytest.mark.parametrize(("geometry", "factor"), [(1, 0.8), (2, 1.0), (3, 0.8)])
def test_the_tilt_of_the_object_counts_where_the_lamp_tilts(geometry, factor, write_photometry):
    text = EVEN.replace("TILT=NONE", f"TILT=INCLUDE\n{geometry}\n3\n0 45 90\n1 0.8 0.6")
    lamp = add_luminaire(path=write_photometry(text))
    assert converted_light(lamp)[0].output.value == pytest.approx(FULL_FLUX)
    lamp.rotation_euler = (0.0, np.pi / 4, 2.0)
    assert converted_light(lamp)[0].output.value == pytest.approx(factor * FULL_FLUX, rel=1e-5)


def test_the_spectrum_is_the_files_or_the_lights(write_photometry):
    text = EVEN.replace("[MANUFAC] own", "[MANUFAC] own\n[LAMP] incandescent")
    lamp = add_luminaire(path=write_photometry(text))
    lamp.data.color = (1.0, 0.0, 0.0)
    light, _ = converted_light(lamp)
    assert light.output.spectrum == Illuminant("A")
    settings_of(lamp).spectrum_source = "LIGHT"
    light, _ = converted_light(lamp)
    assert light.output.spectrum == Rgb(1.0, 0.0, 0.0)
    assert light.output.value == pytest.approx(FULL_FLUX)
    lamp.data.lumenray.use_physical, lamp.data.lumenray.spectrum = True, "BLACKBODY"
    lamp.data.lumenray.colour_temperature = 3000.0
    assert converted_light(lamp)[0].output.spectrum == Blackbody(3000.0)


def test_an_empty_has_a_spectrum_of_its_own(write_photometry):
    empty = add_luminaire("EMPTY", write_photometry())
    settings = settings_of(empty)
    settings.spectrum_source, settings.color = "LIGHT", (0.5, 0.25, 0.0)
    light, _ = converted_light(empty)
    assert light.output.spectrum == Rgb(1.0, 0.5, 0.0)
    assert light.output.value == pytest.approx(FULL_FLUX)
    settings.spectrum = "BLACKBODY"
    assert converted_light(empty)[0].output.spectrum == Blackbody(4000.0)


def test_blenders_watts_and_nodes_do_not_count(write_photometry):
    lamp = add_luminaire(path=write_photometry())
    one = content_digest(converted_light(lamp)[0])
    lamp.data.energy, lamp.data.use_nodes = 77.0, True
    assert content_digest(converted_light(lamp)[0]) == one


def test_dimming_can_be_animated(write_photometry):
    lamp = add_luminaire("EMPTY", write_photometry())
    for frame, value in ((1, 1.0), (11, 0.0)):
        settings_of(lamp).dimming = value
        lamp.keyframe_insert("lumenray.luminaire.dimming", frame=frame)
    bpy.context.scene.frame_set(6)
    assert converted_light(lamp)[0].output.value == pytest.approx(0.5 * FULL_FLUX, rel=1e-3)


@pytest.mark.parametrize("kind", ["POINT", "EMPTY"])
def test_the_engine_measures_the_files_candelas(kind, write_photometry):
    """E = I cos / d^2 on the floor 2 m below, towards C0, C90, C180 and C270 of a turned luminaire."""

    def shape(h, v):
        return 1000.0 + 600.0 * np.sin(v) * np.cos(h - 0.5)

    path = write_photometry(write_ies(shape, np.arange(0, 181, 5), np.arange(0, 361, 10)))
    lamp = add_luminaire(kind, path)
    settings_of(lamp).emission = "POINT"
    settings_of(lamp).rotation, settings_of(lamp).dimming = np.deg2rad(30.0), 0.5
    lamp.location, lamp.rotation_euler = (1.0, 2.0, 2.0), (0.0, 0.0, np.deg2rad(60.0))
    bpy.context.view_layer.update()
    session = Session(witness=False)
    session.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    # C0 looks along world +y: turned by 30 degrees about the beam and by 60 with the object.
    points = np.array([[1, 3, 0], [0, 2, 0], [1, 1, 0], [2, 2, 0]], float)
    # Emitters of sessions that are gone must not go while a kernel is traced: Dr.Jit ends the process of it.
    gc.collect()
    made = session.measure(points, np.tile([0.0, 0.0, 1.0], (4, 1)), StopRule(samples=64))
    expected = 0.5 * shape(np.deg2rad([0, 90, 180, 270]), np.arctan(0.5)) * 2.0 / 5.0**1.5
    np.testing.assert_allclose(made.illuminance, expected, rtol=2e-3)


def test_a_light_without_a_file_is_as_before():
    lamp = add_luminaire()
    light, _ = converted_light(lamp)
    assert isinstance(light, PointLight)
    lamp.matrix_world = Matrix.Translation((0, 0, 1))
    assert isinstance(converted_light(lamp)[0], PointLight)
