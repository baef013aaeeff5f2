"""Ray sets in Blender: files, settings, what becomes of them in the engine, bodies and the library."""

import bpy
import numpy as np
import pytest
from mathutils import Euler
from panels import context, draw, interface
from ray_files import zemax

from lumenray.benchmarks.common.ray_sources import disk, even_numbers
from lumenray.blender_addon.foundation.report import ConversionReport, Severity
from lumenray.blender_addon.raysets import cloud_drawing
from lumenray.blender_addon.raysets import readout as rayset_readout
from lumenray.blender_addon.raysets.files import ray_files
from lumenray.blender_addon.raysets.settings import rays_of
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.raysets import cloud, emission
from lumenray.engine.raysets.index import index_path
from lumenray.engine.scene.light import Luminaire, PointLight
from lumenray.engine.scene.scene import Scene
from lumenray.engine.scene.spectrum import Blackbody, Illuminant, Rgb, Tabulated
from lumenray.engine.session import Session
from lumenray.libraries.raysets import PREFIX
from lumenray.libraries.raysets.catalogue import ENTRIES

FLUX, COUNT = 12.0, 1500


@pytest.fixture(autouse=True)
def _fewer_rays(extension, monkeypatch):
    # Fewer rays tell intensities and moments: sooner, and well enough for what is asked here.
    monkeypatch.setattr(emission, "GENERATED", 1 << 17)
    monkeypatch.setattr(emission, "PIECE", 1 << 17)
    monkeypatch.setattr(cloud, "MADE", 1 << 14)
    yield
    ray_files.detach()


@pytest.fixture
def led(tmp_path):
    """Path of a ray file of a disk of 2 mm that shines along +z by the cosine law."""
    path = tmp_path / "led.dat"
    position, direction = disk(even_numbers(COUNT, 1))
    path.write_bytes(
        zemax(
            np.column_stack([1e3 * position, direction, np.full(COUNT, FLUX / COUNT)]), total=FLUX
        )
    )
    return str(path)


def add_lamp(path="", kind="POINT"):
    data = bpy.data.lights.new("Lamp", kind)
    lamp = bpy.data.objects.new("Lamp", data)
    bpy.context.scene.collection.objects.link(lamp)
    bpy.context.view_layer.objects.active = lamp
    if path:
        settings = data.lumenray.rayset
        settings.filepath, settings.use_file = path, True
    return lamp


def converted(lamp, is_patient=True):
    report = ConversionReport()
    evaluated = lamp.evaluated_get(bpy.context.evaluated_depsgraph_get())
    made = convert_light(
        evaluated, "light:1", "Lamp", evaluated.matrix_world, 1.0, 683.0, report, None, is_patient
    )
    return made, report


def test_a_file_shines_downwards_from_the_light_with_its_own_flux(led):
    lamp = add_lamp(led)
    lamp.location = (1.0, 2.0, 3.0)
    light, report = converted(lamp)
    assert isinstance(light, Luminaire)
    assert light.output.value == pytest.approx(FLUX, rel=1e-4)
    np.testing.assert_allclose(light.frame[:3, 3], (1, 2, 3), atol=1e-4)
    assert light.rays.direction[:, 2].mean() < -0.5
    assert not [row for row, _ in report.rows if row.severity is Severity.ERROR]


def test_turned_and_scaled_lights_keep_the_size_of_their_rays(led):
    lamp = add_lamp(led)
    lamp.rotation_euler = Euler((np.pi / 2, 0.0, 0.0))
    lamp.scale = (3.0, 3.0, 3.0)
    light, report = converted(lamp)
    # Its -Z looks along +y now.
    np.testing.assert_allclose(light.frame[:3, :3] @ [0, 0, -1], [0, 1, 0], atol=1e-6)
    assert light.rays.size == pytest.approx(0.002, rel=0.02)
    assert any("scaled" in row.message for row, _ in report.rows)


def test_flux_dimming_and_spectrum_follow_the_settings(led):
    lamp = add_lamp(led)
    settings = rays_of(lamp)
    settings.amount, settings.luminous_flux, settings.dimming = "LUMENS", 50.0, 0.4
    lamp.data.color = (1.0, 0.5, 0.2)
    light, _ = converted(lamp)
    assert light.output.value == pytest.approx(20.0)
    assert isinstance(light.output.spectrum, Rgb)
    lamp.data.lumenray.use_physical = True
    lamp.data.lumenray.spectrum = "BLACKBODY"
    assert isinstance(converted(lamp)[0].output.spectrum, Blackbody)
    settings.dimming = 0.0
    assert converted(lamp)[0] is None


def test_a_file_that_cannot_be_read_leaves_the_light_out_and_says_why(tmp_path):
    bad = tmp_path / "bad.ray"
    bad.write_bytes(b"nothing of the kind")
    lamp = add_lamp(str(bad))
    light, report = converted(lamp)
    assert light is None
    errors = [row for row, _ in report.rows if row.severity is Severity.ERROR]
    assert "bad.ray" in errors[0].message
    assert ray_files.state_of(rays_of(lamp)).problem
    rays_of(lamp).filepath = str(tmp_path / "gone.ray")
    assert "cannot be opened" in converted(lamp)[1].rows[0][0].message
    rays_of(lamp).filepath = ""
    assert converted(lamp)[0] is None
    rays_of(lamp).use_file = False
    assert isinstance(converted(lamp)[0], PointLight)


def test_a_light_with_both_kinds_of_file_on_is_an_error_and_shines_by_its_rays(led, tmp_path):
    """The switches exclude each other, but a file may hold both: as here, where no switch is pressed."""
    lamp = add_lamp(led)
    lamp.data.lumenray.luminaire["use_file"] = True
    path = str(tmp_path / "both.blend")
    bpy.context.view_layer.update()
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    lamp = bpy.data.objects["Lamp"]
    own = lamp.data.lumenray
    assert own.luminaire.use_file
    assert own.rayset.use_file
    light, report = converted(lamp)
    assert light.rays is not None
    (row,) = [row for row, _ in report.rows if row.severity is Severity.ERROR]
    assert row.datablock == "Lamp"
    assert "both a photometric file and a ray set" in row.message
    assert "switch one off" in row.remedy
    where = context(light=lamp.data, object=lamp)
    with interface():
        assert any("ray set is on too" in text for text in draw("LUMENRAY_PT_luminaire", where))
        own.luminaire.use_file = False
        assert not any("on too" in text for text in draw("LUMENRAY_PT_luminaire", where))
    light, report = converted(lamp)
    assert light.rays is not None
    assert not [row for row, _ in report.rows if row.severity is Severity.ERROR]


def test_the_live_view_does_not_wait_and_sends_no_rays(led):
    lamp = add_lamp(led)
    light, report = converted(lamp, is_patient=False)
    assert light is None
    assert "being prepared" in report.rows[0][0].message
    ray_files.obtain(rays_of(lamp))
    light, _ = converted(lamp, is_patient=False)
    assert len(light.rays.threshold) == 0
    assert light.rays.half.max() > 0.0


def test_a_file_is_prepared_once_for_all_lights_and_again_when_it_changes(led):
    first, second = add_lamp(led), add_lamp(led)
    made = ray_files.obtain(rays_of(first))
    assert ray_files.obtain(rays_of(second)) is made
    rays_of(second).symmetry = "OFF"
    other = ray_files.obtain(rays_of(second))
    assert other is not made
    assert other.emission.axis is None
    assert made.emission.axis is not None


def test_prepared_rays_are_kept_beside_the_file_on_request(led):
    lamp = add_lamp(led)
    ray_files.obtain(rays_of(lamp))
    assert not index_path(led).exists()
    ray_files.detach()
    rays_of(lamp).keep_index = True
    ray_files.obtain(rays_of(lamp))
    assert index_path(led).exists()


def test_the_operator_loads_a_file_or_leaves_all_as_it_was(led, tmp_path):
    lamp = add_lamp()
    assert bpy.ops.lumenray.load_rayset(filepath=led) == {"FINISHED"}
    assert rays_of(lamp).use_file
    assert ray_files.name_of(rays_of(lamp)) == "led.dat"
    bad = tmp_path / "bad.ray"
    bad.write_bytes(b"nothing of the kind")
    with pytest.raises(RuntimeError, match=r"bad\.ray"):
        bpy.ops.lumenray.load_rayset(filepath=str(bad))
    assert ray_files.absolute_path(rays_of(lamp)) == led


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
@pytest.mark.slow
def test_the_library_is_in_the_menu(entry):
    assert bpy.ops.lumenray.add_rayset(entry=entry.name) == {"FINISHED"}
    lamp = bpy.context.object
    settings = rays_of(lamp)
    assert settings.filepath == PREFIX + entry.name
    light, report = converted(lamp)
    assert light.output.value == pytest.approx(entry.luminous_flux, rel=1e-4)
    kind = Blackbody if entry.spectrum.endswith(" K") else Illuminant
    assert isinstance(light.output.spectrum, kind)
    assert not [row for row, _ in report.rows if row.severity is not Severity.INFO]
    lines = dict(rayset_readout.describe(settings, ray_files.obtain(settings)))
    assert lines["Rays"] == "10 000"
    assert lines["Rays in lux maps"].startswith("within")


def test_a_file_with_a_spectrum_gives_it_to_the_light(tmp_path):
    from lumenray.engine.raysets.record import LUMINOUS, Rays
    from lumenray.engine.raysets.writers import write_tm25

    position, direction = disk(even_numbers(500, 1))
    rays = Rays(position, direction, np.full(500, 0.01, np.float32))
    path = tmp_path / "led.tm25ray"
    spectrum = (np.array([450.0, 550.0, 650.0]), np.array([1.0, 2.0, 1.0]))
    write_tm25(path, [rays], LUMINOUS, spectrum)
    lamp = add_lamp(str(path))
    assert isinstance(converted(lamp)[0].output.spectrum, Tabulated)
    rays_of(lamp).spectrum_source = "LIGHT"
    assert not isinstance(converted(lamp)[0].output.spectrum, Tabulated)


def test_a_body_moves_with_its_light_and_is_no_obstacle_unless_asked_for(led):
    lamp = add_lamp(led)
    bpy.ops.mesh.primitive_cube_add(size=0.002, location=(0.0, 0.0, 0.01))
    body = bpy.context.object
    lamp.location = (0.5, 0.0, 0.0)
    lamp.select_set(True)
    bpy.context.view_layer.objects.active = lamp
    bpy.context.view_layer.update()
    assert bpy.ops.lumenray.parent_rayset_body() == {"FINISHED"}
    bpy.context.view_layer.update()
    np.testing.assert_allclose(body.matrix_world.translation, (0.0, 0.0, 0.01), atol=1e-6)
    assert body.parent == lamp
    assert body.lumenray.is_luminaire_body
    bpy.ops.lumenray.parent_rayset_body(is_lit=True)
    assert not body.lumenray.is_luminaire_body
    body.select_set(False)
    assert not bpy.ops.lumenray.parent_rayset_body.poll()


def test_what_is_drawn_lies_where_the_light_starts(led):
    lamp = add_lamp(led)
    made = ray_files.obtain(rays_of(lamp))
    points, ends = cloud_drawing.make_points(made), cloud_drawing.make_rays(made)
    assert np.abs(points[:, 2]).max() < 1e-5
    assert np.hypot(points[:, 0], points[:, 1]).max() < 0.0011
    assert (ends[1::2, 2] < ends[::2, 2]).all()


def test_a_scene_with_a_ray_set_is_baked_and_explained(led):
    bpy.ops.mesh.primitive_plane_add(size=0.1)
    bpy.context.object.name = "Sheet"
    lamp = add_lamp(led)
    lamp.location = (0.0, 0.0, 0.005)
    done = convert_scene(bpy.context.evaluated_depsgraph_get())
    session = Session(witness=False)
    session.apply(done.delta)
    made = session.explain()
    choice = made.choices[0]
    assert (choice.receiver, choice.method) == ("Sheet", "rays")
    assert choice.nearest == pytest.approx(0.005, rel=1e-3)
    assert choice.sizes == pytest.approx(2.5, rel=0.02)
    assert choice.point_error > 0.01
    assert "ray set" in made.traced
    # Sensors see the rays: a point of the peak intensity F / pi would give 4 % too much at two and a half sizes.
    reading = session.measure(
        np.array([[0.0, 0.0, 0.0001]]), np.array([[0.0, 0.0, 1.0]]), _few(), transport="mono"
    )
    disk = FLUX / np.pi / (0.0049**2 + 0.001**2)
    # So few rays blur what comes from straight above by some percent.
    assert reading.illuminance[0] == pytest.approx(disk, rel=0.04)


def _few():
    from lumenray.engine.accuracy.stopping import StopRule

    return StopRule(samples=1 << 16)


def test_live_sync_brings_the_light_when_it_is_ready(led):
    lamp = add_lamp(led)
    sync, scene = SceneSync(final=False), Scene()
    step = sync.walk(bpy.context.evaluated_depsgraph_get())
    scene.apply(step.delta)
    assert not scene.lights
    ray_files.obtain(rays_of(lamp))
    lamp.data.update_tag()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    sync.tag(depsgraph.updates)
    scene.apply(sync.walk(depsgraph).delta)
    assert len(scene.lights) == 1


def test_the_command_explains_a_file(led, tmp_path, capsys):
    from lumenray.command_line.main import main

    bpy.ops.mesh.primitive_plane_add(size=0.1)
    bpy.context.object.name = "Sheet"
    lamp = add_lamp(led)
    lamp.location = (0.0, 0.0, 0.005)
    path = tmp_path / "bench.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert main(["explain", str(path)]) == 0
    out = capsys.readouterr().out
    assert "ray set 'Lamp'" in out
    assert "Sheet" in out
    assert "rays" in out


@pytest.mark.slow
def test_preparations_that_nobody_asks_for_any_more_are_stopped_and_reloads_are_fresh(led):
    lamp = add_lamp(led)
    settings = rays_of(lamp)
    settings.keep_index = True
    first = ray_files.obtain(settings)
    ray_files.forget(settings)
    again = ray_files.obtain(settings)
    assert again is not first
    assert index_path(led).exists()
    settings.use_widths = True
    for width in (0.001, 0.002, 0.003):
        settings.width_position = width
        ray_files.state_of(settings)
    asked = ray_files._shelf._jobs
    assert sum(not job.future.done() for job in asked.values()) <= 1
    assert ray_files.obtain(settings).emission.factor[:, 0, 0].max() == pytest.approx(3e-6)


def test_rays_are_kept_when_that_is_asked_for_afterwards_and_failures_are_told(led, tmp_path):
    lamp = add_lamp(led)
    settings = rays_of(lamp)
    ray_files.obtain(settings)
    settings.keep_index = True
    assert index_path(led).exists()
    index_path(led).unlink()
    index_path(led).mkdir()
    ray_files.forget(settings)
    made = ray_files.obtain(settings)
    assert any("not kept" in str(remark) for remark in made.remarks)


@pytest.mark.parametrize("own", [False, True])
def test_panels_show_the_file_its_figures_and_what_can_be_set(led, own):
    with interface():
        lamp = add_lamp()
        where = context(light=lamp.data, object=lamp)
        assert "lumenray.load_rayset" in draw("LUMENRAY_PT_rayset", where)
        settings = rays_of(lamp)
        settings.filepath, settings.use_file = led, True
        settings.use_widths = own
        settings.amount = "LUMENS" if own else "FILE"
        assert not bpy.types.LUMENRAY_PT_light_photometry.poll(where)
        assert "filepath" in draw("LUMENRAY_PT_rayset", where)
        ray_files.obtain(settings)
        for name in ("LUMENRAY_PT_rayset", "LUMENRAY_PT_active_rayset"):
            assert "filepath" in draw(name, where)
        amount = draw("LUMENRAY_PT_rayset_amount", where)
        assert ("luminous_flux" in amount) is own
        rays = draw("LUMENRAY_PT_rayset_rays", where)
        assert ("position_spread" in rays) is own
        assert "symmetry" in rays
        settings.filepath = led + ".gone"
        assert draw("LUMENRAY_PT_rayset", where)
