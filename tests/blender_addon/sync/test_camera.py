"""Cameras of Blender as cameras of the engine: kinds of panoramas, lenses, clipping and parts of the film."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from blender_objects import add_camera

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.rendering.view_camera import camera_of_matrices, part_of_region
from lumenray.blender_addon.sync.camera import FilmPart, convert_camera, panorama_of
from lumenray.engine.scene.camera import Projection

pytestmark = [pytest.mark.blender, pytest.mark.usefixtures("empty_file")]


def converted(scale=1.0, **settings):
    """The scene's camera, 48 x 32 pixels; depth of field by ``dof_`` names."""
    lens = {key[4:]: settings.pop(key) for key in list(settings) if key.startswith("dof_")}
    eye = add_camera((0, 0, 0), (0, 0, 0), **settings)
    for key, value in lens.items():
        setattr(eye.data.dof, key, value)
    scene, report = bpy.context.scene, ConversionReport()
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    bpy.context.view_layer.update()
    made = convert_camera(eye, scene, scale, report)
    assert not list(report.rows)
    return made


def test_clipping_and_lens_are_in_metres():
    made = converted(0.1, lens=40.0, clip_start=0.5, clip_end=70.0, dof_use_dof=True,
                     dof_aperture_fstop=2.0, dof_focus_distance=3.0, dof_aperture_blades=6,
                     dof_aperture_rotation=0.5, dof_aperture_ratio=1.5)  # fmt: skip
    assert (made.clip_start, made.clip_end) == pytest.approx((0.05, 7.0))
    assert made.aperture_radius == pytest.approx(0.1 * 0.5 * 0.04 / 2.0)
    assert made.focus_distance == pytest.approx(0.3)
    assert made.aperture_blades == 6
    assert (made.aperture_rotation, made.aperture_ratio) == pytest.approx((0.5, 1.5))


def test_lenses_of_orthographic_cameras_know_no_focal_length():
    made = converted(type="ORTHO", dof_use_dof=True, dof_aperture_fstop=4.0, lens=80.0)
    assert made.aperture_radius == pytest.approx(0.125)


@pytest.mark.parametrize(
    ("fit", "size"),
    [("AUTO", (36.0, 24.0)), ("HORIZONTAL", (36.0, 24.0)), ("VERTICAL", (30.0, 20.0))],
)
def test_fisheyes_have_the_sensor_behind_them(fit, size):
    if (
        not hasattr(bpy.types.Camera, "bl_rna")
        or "panorama_type" not in bpy.types.Camera.bl_rna.properties
    ):
        pytest.skip("panoramas are Cycles' own in this version")
    made = converted(type="PANO", panorama_type="FISHEYE_EQUISOLID", fisheye_lens=10.0,
                     fisheye_fov=3.0, sensor_height=20.0, sensor_fit=fit, shift_x=0.1)  # fmt: skip
    assert made.projection is Projection.EQUISOLID
    assert (made.extent_x, made.extent_y) == pytest.approx((size[0] / 10.0, size[1] / 10.0))
    assert made.field == pytest.approx(3.0)
    assert made.shift_x == pytest.approx(0.1 * size[0] / 10.0)


def holder(**settings):
    """Settings of a camera before Blender 5, with Cycles or without."""
    cycles = {"cycles": SimpleNamespace(**settings)} if settings else {}
    return SimpleNamespace(name="Eye", shift_x=0.0, shift_y=0.0, sensor_fit="AUTO", sensor_width=36.0,
                           sensor_height=24.0, **cycles)  # fmt: skip


def test_settings_that_come_with_cycles_are_read_there():
    report = ConversionReport()
    render = bpy.context.scene.render
    data = holder(panorama_type="FISHEYE_EQUIDISTANT", fisheye_fov=2.5)
    made = panorama_of(data, render, FilmPart(8, 8), report)
    assert made["projection"] is Projection.EQUIDISTANT
    assert made["field"] == made["extent_x"] == 2.5
    assert not list(report.rows)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"panorama_type": "SPIRAL"}, "spiral panoramas are not supported"),
        ({}, "unknown panoramas"),
    ],
)
def test_panoramas_that_are_not_known_are_told(settings, message):
    report = ConversionReport()
    made = panorama_of(holder(**settings), bpy.context.scene.render, FilmPart(8, 8), report)
    assert made["projection"] is Projection.EQUIRECTANGULAR
    assert (made["extent_x"], made["extent_y"]) == pytest.approx((2.0 * np.pi, np.pi))
    ((row, _),) = report.rows
    assert message in row.message


def test_a_part_of_an_equirectangular_film_is_a_part_of_its_ranges():
    report = ConversionReport()
    data = holder(panorama_type="EQUIRECTANGULAR", longitude_min=-1.0, longitude_max=3.0,
                  latitude_min=0.0, latitude_max=1.0)  # fmt: skip
    data.shift_y = 0.5
    part = FilmPart(8, 8, (0.25, 0.0), (0.5, 1.0))
    made = panorama_of(data, bpy.context.scene.render, part, report)
    assert (made["extent_x"], made["shift_x"]) == pytest.approx((2.0, 2.0))
    assert (made["extent_y"], made["shift_y"]) == pytest.approx((1.0, 1.0))


# ---- views ----


def view_of(matrix):
    """What a view tells that looks through a camera at the origin."""
    from mathutils import Matrix

    return SimpleNamespace(window_matrix=matrix, view_matrix=Matrix())


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_views_through_a_camera_are_that_camera(kind):
    made = converted(type=kind, clip_start=0.2, clip_end=50.0, shift_x=0.1, shift_y=-0.2)
    eye = bpy.context.scene.camera
    matrix = eye.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=48, y=32)
    region = SimpleNamespace(width=48, height=32)
    shown = camera_of_matrices(view_of(matrix), region, 1.0, eye, 50.0)
    for name in ("extent_x", "extent_y", "shift_x", "shift_y", "clip_start", "clip_end"):
        assert getattr(shown, name) == pytest.approx(getattr(made, name), rel=1e-4), name
    assert camera_of_matrices(view_of(matrix), region, 1.0).projection is made.projection


def test_a_view_shows_a_panorama_within_the_frame_of_its_camera():
    """A region that is twice as wide and high as the frame, which stands to the right in it."""
    converted(type="PERSP")
    eye = bpy.context.scene.camera
    matrix = eye.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=48, y=32)
    wide = np.array(matrix)
    wide[:2] *= 0.5
    wide[0, 2] -= 0.3
    corners = eye.data.view_frame(scene=bpy.context.scene)
    region = SimpleNamespace(width=96, height=64)
    part = part_of_region(view_of(wide), region, corners)
    assert (part.width, part.height) == (96, 64)
    assert part.share == pytest.approx((2.0, 2.0))
    # The frame's middle is at 0.3 of half the region, the region's thus as far to the left of it.
    assert part.centre == pytest.approx((-0.3, 0.0), abs=1e-6)
