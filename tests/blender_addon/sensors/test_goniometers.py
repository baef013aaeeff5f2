"""Goniometers as objects: a file comes back, what is modelled about one counts; what is elsewhere does not."""

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp
from blender_luminaires import add_luminaire
from blender_objects import add_quad, new_material
from mathutils import Matrix
from photometric_files import write_peaks

from lumenray.blender_addon.sensors import adding, asked, drawing, files, pictures, results, words
from lumenray.blender_addon.sensors.goniometers import error_of, measured_of
from lumenray.blender_addon.sensors.places import place_sensors, signature_of
from lumenray.blender_addon.sensors.readings import read_readings, readings_of, write_readings
from lumenray.engine.errors import SceneError
from lumenray.engine.light_mix import NEUTRAL
from lumenray.engine.luminaires.coordinates import directions
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.reader import read_luminaire

pytestmark = pytest.mark.usefixtures("extension")

PLACE = Matrix.Translation((3.0, -2.0, 5.0)) @ Matrix.Rotation(0.7, 4, (1.0, 2.0, -1.0))


def new_goniometer(matrix=None, **settings):
    bpy.context.view_layer.objects.active = None
    empty = adding.add_sensors(bpy.context, "SPHERE")
    empty.matrix_world = Matrix() if matrix is None else matrix
    for name, value in settings.items():
        setattr(empty.lumenray.sensor, name, value)
    return empty


def measure():
    from lumenray.engine.session import Session

    bpy.context.view_layer.update()
    job, _ = asked.prepare(bpy.context.evaluated_depsgraph_get())
    job.run(Session())
    results.store(job)
    return job


def test_a_luminaire_of_a_file_comes_back_whatever_else_is_in_the_scene(tmp_path):
    """It is turned, a lamp shines beside it, and a ceiling goes through the ball."""
    (tmp_path / "peaks.ies").write_text(write_peaks())
    lamp = add_luminaire("EMPTY", str(tmp_path / "peaks.ies"))
    lamp.matrix_world = PLACE
    add_lamp("Elsewhere", value=5000.0).location = (3.0, -2.0, 8.0)
    ceiling = add_quad("Ceiling")
    ceiling.scale, ceiling.location = (9.0, 9.0, 1.0), (0.0, -5.0, 5.2)
    empty = new_goniometer(PLACE, plane_step=np.deg2rad(22.5), polar_step=np.deg2rad(5.0))
    job = measure()
    assert "no part of it: Ceiling" in " ".join(job.notes)
    readings = readings_of(empty)
    file = read_luminaire(tmp_path / "peaks.ies")
    measured = measured_of(readings)
    ways = directions(measured.distribution.azimuth[:, None], measured.distribution.polar[None])
    exact = intensity(file.distribution, ways)
    found = measured.distribution.intensity
    limit = 0.005 * exact.max() + 3.0 * measured.standard_error
    assert (np.abs(found - exact) <= limit).all()
    assert 0.0 < error_of(measured) < 0.005
    # What a person writes is what was measured.
    bpy.context.view_layer.objects.active = empty
    for end in ("ldt", "ies"):
        out = tmp_path / f"out.{end}"
        assert bpy.ops.lumenray.write_photometric_file(filepath=str(out)) == {"FINISHED"}
        again = read_luminaire(out)
        written = intensity(again.distribution, ways)
        assert np.abs(written - exact).max() <= 0.005 * exact.max() + 3.0 * readings.errors.max()


@pytest.mark.slow
def test_what_is_modelled_about_a_lamp_counts():
    """A white plate above a lamp sends what it catches down by the cosine law, and hides the lamp from above."""
    lamp = add_lamp("Lamp", value=1000.0)
    lamp.location = (0.0, 0.0, -0.1)
    plate = bpy.data.meshes.new("Plate")
    plate.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    paint = new_material("White", "ShaderNodeBsdfDiffuse")
    paint.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.8, 0.8, 0.8, 1.0)
    plate.materials.append(paint)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Plate", plate))
    empty = new_goniometer(radius=2.0, plane_step=np.pi / 2, polar_step=np.pi / 4)
    measure()
    measured = measured_of(readings_of(empty))
    bare = 1000.0 / (4.0 * np.pi)
    caught = 1000.0 / np.pi * np.arcsin(1.0 / (1.0 + 0.1**2))
    found = measured.distribution.intensity.mean(axis=0)
    down = np.cos(np.deg2rad([0.0, 45.0]))
    np.testing.assert_allclose(found[:2], bare + 0.8 * caught / np.pi * down, rtol=0.01)
    assert found[4] < 0.01 * bare
    near = new_goniometer(
        radius=2.0, plane_step=np.pi / 2, polar_step=np.pi / 4, use_distance=True, distance=4.0
    )
    bpy.data.objects.remove(empty)
    measure()
    # By quadrature over the plate, for the detector 4 m below its middle.
    x = (np.arange(400) + 0.5) / 200.0 - 1.0
    square = x[:, None] ** 2 + x**2
    lit = 0.8 * bare * 0.1 / (square + 0.01) ** 1.5 / np.pi
    exact = bare * (4.0 / 3.9) ** 2 + 4.0**2 * (lit * 16.0 / (square + 16.0) ** 2).sum() / 200.0**2
    assert readings_of(near).values[0, 0] == pytest.approx(exact, rel=0.01)


def test_what_a_goniometer_has_found_is_kept_told_and_drawn(tmp_path):
    add_lamp("Lamp", value=1000.0).location = (0.0, 0.0, 0.0)
    empty = new_goniometer(plane_step=np.pi / 2, polar_step=np.pi / 12)
    measure()
    readings = readings_of(empty)
    assert read_readings(write_readings(readings)).size == readings.size
    assert readings.unit == "cd"
    measured = measured_of(readings)
    assert len(measured.distribution.azimuth) == 1
    assert flux(measured.distribution) == pytest.approx(1000.0, rel=0.003)
    assert "lm" in dict(words.describe(empty))["luminous flux"]
    assert not pictures.has_plan(readings)
    shown = drawing.make_drawing(bpy.context.scene)
    assert shown.scale is None
    assert [label.text for label in shown.labels] == [words.brief(readings)]
    away = np.linalg.norm(shown.lines - readings.frame[:3, 3], axis=1)
    np.testing.assert_allclose(away, 0.5, rtol=0.01)
    row = files.describe_readings("Goniometer", readings, NEUTRAL)
    assert row["luminous_flux_lm"] == pytest.approx(1000.0, rel=0.003)
    assert "uniformity_u0" not in row
    before = signature_of(empty)
    empty.lumenray.sensor.radius = 0.4
    assert signature_of(empty) != before


def test_settings_that_make_no_goniometer_are_refused():
    def placed(**settings):
        empty = new_goniometer(**settings)
        return place_sensors(empty, bpy.context.evaluated_depsgraph_get())

    with pytest.raises(SceneError, match="no whole number of steps of 7"):
        placed(polar_step=np.deg2rad(7.0))
    with pytest.raises(SceneError, match="lies within the radius"):
        placed(radius=2.0, use_distance=True, distance=1.0)
    with pytest.raises(SceneError, match="set the quantity to Intensity"):
        placed(quantity="PLANAR")
    for empty in list(bpy.data.objects):
        bpy.data.objects.remove(empty)
    new_goniometer()
    with pytest.raises(SceneError, match=r"no light lies within the goniometer's radius of 0.5 m"):
        measure()
