"""What the user sees of luminaires: the polar solid against closed forms, its place in the world, and the panels."""

import math
import threading
import time

import bpy
import numpy as np
import pytest
from lumenray import ui
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.luminaires import files
from lumenray.blender_addon.luminaires import places as luminaire_places
from lumenray.blender_addon.luminaires import preview as luminaire_pictures
from lumenray.blender_addon.luminaires.solid import make_curve, make_outline, make_solid
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.engine.luminaires.coordinates import FRAMES
from lumenray.engine.luminaires.distribution import intensity
from lumenray.engine.reading.remarks import Remark
from lumenray.engine.scene.distribution import IntensityDistribution, Opening
from lumenray.ui import luminaire_overlay
from lumenray.ui.luminaire import LuminaireChild
from mathutils import Euler, Matrix
from panels import context, draw, interface, new_light
from photometric_files import write_ies

DEGREES = np.arange(181.0)
POLAR = np.radians(DEGREES)


def rotational(values, polar=POLAR):
    """Return a distribution that is the same all around. ``values`` (p,) [cd]"""
    return IntensityDistribution(np.zeros(1), polar, np.asarray(values, float)[None])


def pointed(azimuth, polar, kind="C"):
    """Return a distribution with light about one pair of angles of the grid alone. [degree]"""
    azimuths = np.radians(np.arange(0.0, 361.0, 10.0))
    values = np.zeros((len(azimuths), len(POLAR)))
    values[round(azimuth / 10.0), round(polar)] = 700.0
    return IntensityDistribution(azimuths, POLAR, values, FRAMES[kind])


def volume(solid):
    """Volume that the triangles enclose, positive if they are counter-clockwise from outside."""
    a, b, c = (solid.vertices[solid.triangles[:, corner]].astype(float) for corner in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def farthest(solid):
    return solid.vertices[np.argmax(np.linalg.norm(solid.vertices, axis=1))]


def test_solid_of_a_lambertian_source_is_a_sphere_that_touches_it():
    solid = make_solid(rotational(50.0 * np.clip(np.cos(POLAR), 0.0, None)), 72, 60)
    used = solid.vertices[np.unique(solid.triangles)]
    assert np.linalg.norm(used - np.array([0.0, 0.0, -0.5]), axis=1) == pytest.approx(0.5, abs=1e-4)
    assert volume(solid) == pytest.approx(np.pi / 6.0, rel=5e-3)
    assert solid.brightness.min() > 0.0
    assert solid.brightness.max() <= 1.0


@pytest.mark.parametrize("kind", ["A", "B", "C"])
def test_vertices_lie_as_far_out_as_the_intensity_in_their_direction(kind):
    rng = np.random.default_rng(3)
    azimuth, polar = np.radians(np.arange(0.0, 361.0, 15.0)), np.radians(np.arange(0.0, 181.0, 5.0))
    values = rng.uniform(1.0, 9.0, (len(azimuth), len(polar)))
    values[-1] = values[0]
    # At the poles all azimuths are one direction.
    values[:, 0], values[:, -1] = 2.0, 5.0
    distribution = IntensityDistribution(azimuth, polar, values, FRAMES[kind])
    solid = make_solid(distribution, 48, 36)
    reach = np.linalg.norm(solid.vertices, axis=1)
    assert reach == pytest.approx(intensity(distribution, solid.vertices) / values.max(), rel=1e-4)
    assert reach.max() == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("distribution", "direction"),
    [
        (pointed(0, 60), (np.sin(np.radians(60)), 0.0, -0.5)),
        (pointed(90, 60), (0.0, np.sin(np.radians(60)), -0.5)),
        (pointed(0, 150), (0.5, 0.0, np.sin(np.radians(60)))),
        # LM-75: H of type A turns to the right, V of type B to above.
        (pointed(20, 90, "A"), (np.sin(np.radians(20)), 0.0, -np.cos(np.radians(20)))),
        (pointed(30, 90, "B"), (0.0, 0.5, -np.cos(np.radians(30)))),
    ],
)
def test_solid_points_where_the_light_goes(distribution, direction):
    assert farthest(make_solid(distribution, 48, 36)) == pytest.approx(direction, abs=1e-5)


def test_beam_of_two_degrees_keeps_its_length_and_volume():
    spread = np.radians(1.2)
    polar = np.radians(np.linspace(0.0, 180.0, 1801))
    solid = make_solid(rotational(1e6 * np.exp(-((polar / spread) ** 2)), polar), 48, 36)
    assert farthest(solid) == pytest.approx((0.0, 0.0, -1.0), abs=1e-6)
    # A third of the integral of (I / peak)^3 over the sphere, for small angles.
    assert volume(solid) == pytest.approx(np.pi * spread**2 / 9.0, rel=0.1)


def test_light_that_ends_at_the_edge_of_the_grid_is_closed_there():
    half = rotational(np.ones(3), np.radians([0.0, 45.0, 90.0]))
    assert volume(make_solid(half, 72, 60)) == pytest.approx(2.0 * np.pi / 3.0, rel=5e-3)
    quarter = IntensityDistribution(np.radians([0.0, 45.0, 90.0]), POLAR, np.ones((3, 181)))
    assert volume(make_solid(quarter, 72, 60)) == pytest.approx(np.pi / 3.0, rel=5e-3)


def test_mirrored_grid_is_not_inside_out():
    distribution = IntensityDistribution(
        np.radians([0.0, 90.0, 180.0, 270.0, 360.0]),
        POLAR,
        np.ones((5, 181)),
        np.diag([1.0, -1.0, 1.0]),
    )
    assert volume(make_solid(distribution, 72, 60)) == pytest.approx(4.0 * np.pi / 3.0, rel=5e-3)


def test_dark_distribution_has_neither_solid_nor_curve():
    dark = rotational(np.zeros(181))
    assert len(make_solid(dark, 48, 36).triangles) == 0
    assert len(make_curve(dark, 0.0, 100)) == 0


def test_curves_lie_in_their_planes_and_show_c180_on_the_other_side():
    azimuth = np.radians([0.0, 90.0, 180.0, 270.0, 360.0])
    downwards = np.clip(np.cos(POLAR), 0.0, None)
    values = np.array([1.0, 2.0, 3.0, 4.0, 1.0])[:, None] * downwards
    distribution = IntensityDistribution(azimuth, POLAR, values)
    first = make_curve(distribution, 0.0, 400)
    assert np.abs(first[:, 1]).max() < 1e-12
    # The largest sideways reach of k cos gamma is k / 2.
    assert first[:, 0].max() == pytest.approx(0.5 * 1.0 / 4.0, rel=1e-3)
    assert first[:, 0].min() == pytest.approx(-0.5 * 3.0 / 4.0, rel=1e-3)
    second = make_curve(distribution, np.pi / 2.0, 400)
    assert np.abs(second[:, 0]).max() < 1e-12
    assert second[:, 1].max() == pytest.approx(0.5 * 2.0 / 4.0, rel=1e-3)
    assert second[:, 1].min() == pytest.approx(-0.5, rel=1e-3)
    assert first[0] == pytest.approx(first[-1])


@pytest.mark.parametrize(
    ("opening", "lines"),
    [
        (Opening("rectangle", (1.2, 0.3, 0.0)), 4),
        (Opening("rectangle", (1.2, 0.0, 0.3), "y"), 4),
        (Opening("ellipse", (0.4, 0.2, 0.0)), 32),
        (Opening("box", (1.0, 0.5, 0.1)), 12),
        (Opening("cylinder", (1.5, 0.04, 0.04), "x"), 68),
        (Opening("ellipsoid", (0.3, 0.3, 0.2)), 96),
    ],
)
def test_outline_has_the_size_of_the_opening(opening, lines):
    outline = make_outline(opening)
    assert outline.shape == (lines, 2, 3)
    points = outline.reshape(-1, 3)
    assert points.max(axis=0) == pytest.approx(0.5 * np.array(opening.size), rel=1e-9)
    assert points.min(axis=0) == pytest.approx(-0.5 * np.array(opening.size), rel=1e-9)


def test_point_has_no_outline():
    assert make_outline(Opening()).shape == (0, 2, 3)


def perspective(near=0.1, far=1000.0):
    """Return the projection of an eye at the origin that looks along -z, 90 degrees high and wide."""
    matrix = np.zeros((4, 4))
    matrix[0, 0] = matrix[1, 1] = 1.0
    matrix[2, 2:] = (far + near) / (near - far), 2.0 * far * near / (near - far)
    matrix[3, 2] = -1.0
    return matrix


def test_solids_are_the_finer_the_larger_they_are_on_the_screen():
    # At a distance d, 1 m is 500 / d pixels of a region 1000 pixels high.
    centres = [(0, 0, -2), (0, 0, -10), (0, 0, -40), (0, 0, -200), (0, 0, 0.2)]
    sizes = luminaire_places.screen_radius(centres[:4], 1.0, perspective(), 1000)
    assert sizes == pytest.approx([250.0, 50.0, 12.5, 2.5])
    levels = luminaire_places.choose_levels(centres, 1.0, perspective(), 1000)
    assert levels.tolist() == [0, 1, 2, -1, 0]


def test_solids_beside_and_behind_the_view_are_left_out():
    centres = [(0, 0, 5), (20, 0, -10), (0, -20, -10), (10.5, 0, -10)]
    assert luminaire_places.choose_levels(centres, 1.0, perspective(), 1000).tolist() == [
        -1,
        -1,
        -1,
        1,
    ]


def test_only_the_largest_of_very_many_solids_are_drawn():
    centres = np.zeros((500, 3))
    centres[:, 2] = -np.linspace(5.0, 6.0, 500)
    levels = luminaire_places.choose_levels(centres, 1.0, perspective(), 1000)
    assert (levels >= 0).sum() == luminaire_places.MOST_SOLIDS
    assert (levels[: luminaire_places.MOST_SOLIDS] >= 0).all()


# ---- in the world ----


def ies(azimuths=(0, 90, 180, 270, 360), peaks=(9, 1, 1, 1, 9), kind=1, size=(0.3, 0.6, 0.0)):
    """Return an LM-63 file whose planes have 1 cd down, their peak at 45 degrees, and nothing at 90 and above."""
    polars = (0, 45, 90) if kind == 1 else (-90, 0, 45, 90)
    rows = [(1, peak, 0) if kind == 1 else (0, 0, peak, 0) for peak in peaks]
    numbers = [*polars, *azimuths, *(value for row in rows for value in row)]
    return (
        "IESNA:LM-63-2002\n[TEST] made for a test\n[MANUFAC] Example\n[LUMINAIRE] Spot\n"
        "[LAMP] LED 4000 K\nTILT=NONE\n"
        f"1 -1 1 {len(polars)} {len(azimuths)} {kind} 2 {size[0]} {size[1]} {size[2]}\n1 1 5\n"
        + "\n".join(str(number) for number in numbers)
        + "\n"
    )


@pytest.fixture
def new_luminaire(tmp_path):
    """Return a function that makes a light, or an empty, which shines as a file says."""

    def make(content, kind="POINT", matrix=None, name="lamp.ies"):
        path = tmp_path / name
        path.write_text(content, encoding="utf-8")
        data = None if kind == "EMPTY" else bpy.data.lights.new("Lamp", kind)
        source = bpy.data.objects.new("Lamp", data)
        bpy.context.scene.collection.objects.link(source)
        source.matrix_world = matrix or Matrix()
        bpy.context.view_layer.update()
        settings = source.lumenray.luminaire if data is None else data.lumenray.luminaire
        files.load(settings, str(path))
        return source, settings

    return make


def shown(scale=1.0):
    bpy.context.view_layer.update()
    return luminaire_places.collect(bpy.context.view_layer, None, scale)


def beam(place):
    """Direction in the world in which the solid reaches farthest."""
    return place.turn @ farthest(make_solid(place.distribution, 48, 36))


HALF = math.sqrt(0.5)


def test_c0_of_an_upright_luminaire_is_along_the_worlds_x(new_luminaire):
    new_luminaire(ies())
    (place,) = shown()
    assert beam(place) == pytest.approx((HALF, 0.0, -HALF), abs=1e-6)


@pytest.mark.parametrize(
    ("changes", "direction"),
    [
        ({"rotation": math.radians(90.0)}, (0.0, HALF, -HALF)),
        ({"rotation": math.radians(30.0)}, (math.cos(math.pi / 6) * HALF, 0.5 * HALF, -HALF)),
    ],
)
def test_settings_turn_the_solid(new_luminaire, changes, direction):
    _, settings = new_luminaire(ies())
    for name, value in changes.items():
        setattr(settings, name, value)
    assert beam(shown()[0]) == pytest.approx(direction, abs=1e-6)


def test_c_counted_clockwise_puts_c90_on_the_other_side(new_luminaire):
    _, settings = new_luminaire(ies(peaks=(1, 9, 1, 1, 1)))
    assert beam(shown()[0]) == pytest.approx((0.0, HALF, -HALF), abs=1e-6)
    settings.mirror = True
    (place,) = shown()
    assert beam(place) == pytest.approx((0.0, -HALF, -HALF), abs=1e-6)
    assert np.linalg.det(place.turn) == pytest.approx(-1.0)


def test_object_turns_moves_and_does_not_stretch_its_solid(new_luminaire):
    turn = Euler((math.radians(90.0), 0.0, 0.0)).to_matrix().to_4x4()
    new_luminaire(ies(), matrix=Matrix.Translation((1, 2, 3)) @ turn @ Matrix.Scale(5.0, 4))
    (place,) = shown(scale=0.01)
    # Turned a quarter about x, what shone down shines along +y.
    assert beam(place) == pytest.approx((HALF, HALF, 0.0), abs=1e-6)
    assert place.centre == pytest.approx((1.0, 2.0, 3.0))


RANDOM = Matrix.Translation((1, 2, 3)) @ Euler((0.3, -0.8, 2.0)).to_matrix().to_4x4()
MIRRORED = RANDOM @ Matrix.Diagonal((1.0, -1.0, 1.0, 1.0))


@pytest.mark.parametrize("matrix", [RANDOM, MIRRORED])
@pytest.mark.parametrize("kind", [1, 2, 3])
def test_solid_stands_as_the_engine_is_told(new_luminaire, matrix, kind):
    planes = {"azimuths": (-90, 0, 30, 90), "peaks": (0, 1, 9, 0)} if kind > 1 else {}
    source, settings = new_luminaire(ies(kind=kind, **planes), matrix=matrix)
    settings.rotation, settings.mirror, settings.flip_h = 0.4, True, True
    light = convert_light(
        source, "l", "l", np.array(source.matrix_world), 1.0, 683.0, ConversionReport()
    )
    (place,) = shown()
    local = beam(place) @ light.frame[:3, :3]
    reach = intensity(light.distribution, local)
    assert reach == pytest.approx(light.distribution.intensity.max(), rel=1e-6)
    assert place.frame == pytest.approx(light.frame[:3, :3])
    assert place.opening == light.opening


def test_only_selected_luminaires_are_shown_where_the_others_are_not_to_be(new_luminaire):
    first, settings = new_luminaire(ies())
    new_luminaire(ies(), kind="EMPTY")
    assert len(shown()) == 2
    settings.show_solid = False
    assert len(shown()) == 1
    first.select_set(True)
    assert len(shown()) == 2
    first.hide_viewport = True
    assert len(shown()) == 1


def test_lights_without_a_usable_file_are_not_shown(new_luminaire):
    _, settings = new_luminaire(ies())
    settings.use_file = False
    assert shown() == []
    settings.use_file = True
    settings.text.from_string("IESNA:LM-63-2002\nTILT=NONE\n1 2 3\n")
    assert shown() == []


def test_instance_of_a_collection_shows_the_luminaires_in_it(new_luminaire):
    source, _ = new_luminaire(ies(), matrix=Matrix.Translation((0, 0, 1)))
    scene = bpy.context.scene.collection
    group = bpy.data.collections.new("Group")
    group.objects.link(source)
    group.instance_offset = (0, 0, 1)
    for number in range(2):
        instance = bpy.data.objects.new("Instance", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", group
        instance.location = (3.0 * number, 0, 2)
        scene.objects.link(instance)
    bpy.context.view_layer.update()
    scene.objects.unlink(source)
    places = shown()
    assert sorted(tuple(place.centre) for place in places) == [(0, 0, 2), (3, 0, 2)]


# ---- panels ----


@pytest.fixture(scope="module", autouse=True)
def _interface(registered):
    with interface():
        yield


def context_of(source):
    return context(light=source.data, object=source)


def children():
    return [kind for kind in ui.CLASSES if issubclass(kind, LuminaireChild)]


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA"])
def test_light_without_a_file_offers_to_open_one(kind):
    where = new_light(kind)
    for name in ("LUMENRAY_PT_luminaire", "LUMENRAY_PT_active_luminaire"):
        seen = draw(name, where)
        assert "lumenray.load_luminaire_file" in seen
        assert "filepath" not in seen
    assert not any(child.poll(where) for child in children())


def test_sun_and_mesh_cannot_be_luminaires():
    mesh = bpy.data.objects.new("Floor", bpy.data.meshes.new("Floor"))
    for where in (new_light("SUN"), context(object=mesh), context()):
        assert draw("LUMENRAY_PT_luminaire", where) is None
        assert draw("LUMENRAY_PT_active_luminaire", where) is None


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA", "EMPTY"])
def test_panel_shows_the_figures_of_the_file(new_luminaire, kind):
    # The same all around, 1 cd at 0 and 45 degrees and none at 90.
    source, settings = new_luminaire(ies(azimuths=(0,), peaks=(1,)), kind)
    where = context_of(source)
    seen = draw("LUMENRAY_PT_luminaire", where)
    edge = math.pi / 4.0
    # 2 pi times the integral of sin up to the edge, and of the line to 0 at 90 degrees times sin beyond.
    lumens = 2.0 * math.pi * (1.0 - math.cos(edge) + math.cos(edge) - (1.0 - math.sin(edge)) / edge)
    assert f"{lumens:.2f} lm" in seen
    for text in ("LM-63-2002", "type C, rotational", "absolute", "1.00 cd", "γ 0°", "135°"):
        assert text in seen, text
    assert f"{lumens / 5.0:.3f} lm/W" in seen
    assert {"rectangle", "600 × 300 mm"} <= set(seen)
    assert any("Embedded" in text for text in seen)
    assert "lumenray.unpack_luminaire_file" in seen
    seen = draw("LUMENRAY_PT_active_luminaire", where)
    assert {"dimming", "rotation", "show_solid", "emission"} <= set(seen)
    assert f"{lumens:.2f} lm" in seen
    for child in children():
        assert draw(child.__name__, where)
        assert not child.poll(context(engine="CYCLES", light=source.data, object=source))
    assert "Example" in draw("LUMENRAY_PT_luminaire_words", where)
    settings.use_file = False
    assert not any(child.poll(where) for child in children())


def test_panels_of_a_file_in_watts_tell_watts_and_that_nothing_is_visible(new_luminaire):
    text = write_ies([[100.0, 100.0]], [0, 180], [0], keywords=("[_INTENSITYUNITS] mW/sr",))
    source, settings = new_luminaire(text)
    where = context_of(source)
    for panel in ("LUMENRAY_PT_luminaire", "LUMENRAY_PT_active_luminaire"):
        seen = draw(panel, where)
        assert "1.26 W" in seen
        assert "0.100 W/sr" in seen
        assert not any(text.endswith((" lm", " cd", " lm/W")) for text in seen)
    assert "none without a spectrum" in draw("LUMENRAY_PT_luminaire", where)
    settings.dimming = 0.5
    seen = draw("LUMENRAY_PT_luminaire_amount", where)
    assert "0.628 W" in seen
    assert "lights nothing visible" in " ".join(map(str, seen))
    assert "nothing visible" in " ".join(map(str, draw("LUMENRAY_PT_luminaire_spectrum", where)))


def test_light_panels_leave_out_what_the_file_states(new_luminaire):
    source, settings = new_luminaire(ies(), "SPOT")
    where = context_of(source)
    assert draw("LUMENRAY_PT_light_photometry", where) is None
    assert draw("LUMENRAY_PT_active_light", where) is None
    assert set(draw("LUMENRAY_PT_light", where)) == {"type"}
    settings.emission = "LIGHT"
    assert set(draw("LUMENRAY_PT_light", where)) == {"type", "shadow_soft_size"}
    settings.use_file = False
    assert draw("LUMENRAY_PT_light_photometry", where)
    assert {"spot_size", "spot_blend"} <= set(draw("LUMENRAY_PT_light", where))


def test_amount_shows_the_flux_after_every_factor(new_luminaire):
    source, settings = new_luminaire(ies())
    settings.amount, settings.luminous_flux = "LUMENS", 1000.0
    settings.dimming, settings.maintenance_factor, settings.lamp_factor = 0.5, 0.8, 1.1
    seen = draw("LUMENRAY_PT_luminaire_amount", context_of(source))
    assert "luminous_flux" in seen
    shown_values = [text for text in seen if text.endswith(" lm")]
    assert shown_values == ["1\u2009000 lm", "1\u2009100 lm", "550 lm", "440 lm", "440 lm"]
    settings.dimming = settings.maintenance_factor = settings.lamp_factor = 1.0
    seen = draw("LUMENRAY_PT_luminaire_amount", context_of(source))
    assert [text for text in seen if text.endswith(" lm")] == ["1\u2009000 lm", "1\u2009000 lm"]


@pytest.mark.parametrize(("kind", "own"), [("POINT", "color"), ("EMPTY", "color")])
def test_spectrum_tells_the_files_reason_or_offers_a_choice(new_luminaire, kind, own):
    source, settings = new_luminaire(ies(), kind)
    said = " ".join(draw("LUMENRAY_PT_luminaire_spectrum", context_of(source)))
    assert "LED" in said
    assert "4000 K" in said
    assert own not in said.split()
    settings.spectrum_source = "LIGHT"
    assert {"spectrum", own} <= set(draw("LUMENRAY_PT_luminaire_spectrum", context_of(source)))


@pytest.mark.parametrize(("kind", "own"), [(1, "mirror"), (2, None), (3, "flip_h")])
def test_mounting_offers_what_the_photometric_type_can_need(new_luminaire, kind, own):
    planes = {"azimuths": (-90, 0, 30, 90), "peaks": (0, 1, 9, 0)} if kind > 1 else {}
    # In LM-63, 2 is type B and 3 is type A.
    own = {2: "flip_h", 3: None}.get(kind, own)
    source, _ = new_luminaire(ies(kind=kind, **planes))
    seen = set(draw("LUMENRAY_PT_luminaire_mounting", context_of(source)))
    assert seen & {"mirror", "flip_h"} == ({own} if own else set())


def test_refused_file_says_what_is_wrong(new_luminaire):
    source, settings = new_luminaire(ies())
    settings.text.from_string("IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 banana\n")
    with pytest.raises(files.FileFormatError) as refused:
        files.read(settings)
    seen = draw("LUMENRAY_PT_luminaire", context_of(source))
    assert " ".join(str(refused.value).split()) in " ".join(" ".join(seen).split())
    assert "Drawing the diagram…" not in seen
    assert "another one is chosen" in " ".join(seen)
    assert not any(child.poll(context_of(source)) for child in children())
    assert str(refused.value)[:20] in " ".join(
        draw("LUMENRAY_PT_active_luminaire", context_of(source))
    )


def test_missing_linked_file_says_so(new_luminaire, tmp_path):
    source, settings = new_luminaire(ies())
    settings.filepath = str(tmp_path / "gone.ies")
    said = " ".join(draw("LUMENRAY_PT_luminaire", context_of(source)))
    assert "cannot be opened" in said
    assert "pack_luminaire_file" in said


def test_edited_file_is_told(new_luminaire):
    source, settings = new_luminaire(ies())
    assert "edited" not in " ".join(draw("LUMENRAY_PT_luminaire", context_of(source)))
    settings.text.from_string(ies(peaks=(5, 1, 1, 1, 5)))
    assert "edited" in " ".join(draw("LUMENRAY_PT_luminaire", context_of(source)))


@pytest.mark.parametrize("count", [0, 1, 5])
def test_warnings_of_the_reader_are_counted_and_listed(new_luminaire, monkeypatch, count):
    source, settings = new_luminaire(ies())
    remarks = tuple(Remark(f"oddity {number}", number + 1) for number in range(count))
    file = files.read(settings).file
    monkeypatch.setattr(type(file), "remarks", remarks, raising=False)
    object.__setattr__(file, "remarks", remarks)
    seen = draw("LUMENRAY_PT_luminaire", context_of(source))
    heading = {0: None, 1: "1 warning about the file", 5: "5 warnings about the file"}[count]
    assert [text for text in seen if "about the file" in text] == [heading] * bool(count)
    assert [text for text in seen if "oddity" in text] == [str(remark) for remark in remarks]


def test_stated_ratio_that_does_not_fit_is_shown_beside_the_computed_one(new_luminaire):
    source, settings = new_luminaire(ies(azimuths=(0,), peaks=(1,)).replace("1 -1 1", "1 10 1"))
    file = files.read(settings).file
    object.__setattr__(file, "light_output_ratio", 0.9)
    seen = draw("LUMENRAY_PT_luminaire", context_of(source))
    assert "39.4 % (stated 90.0 %)" in seen
    assert "10.0 lm" in seen


# ---- pictures ----


def finish(made):
    """Do what Blender's timer does until it is done."""
    end = time.monotonic() + 30.0
    while made.timer() is not None:
        assert time.monotonic() < end
        time.sleep(0.01)


def test_diagram_is_drawn_once_for_every_content(new_luminaire, monkeypatch):
    drawn, allowed = [], threading.Event()

    def diagram(file, size, dark):
        allowed.wait(30.0)
        drawn.append((file, dark))
        pixels = np.zeros((*size[::-1], 4), np.float32)
        pixels[0, 0] = (1.0, 0.5, 0.0, 1.0)
        return pixels

    monkeypatch.setattr(luminaire_pictures, "diagram_pixels", diagram)
    made = luminaire_pictures.Pictures()
    _, settings = new_luminaire(ies())
    reading = files.read(settings)
    # Blender goes on while the picture is drawn.
    assert made.icon(reading, 256, True) == 0
    assert bpy.app.timers.is_registered(made.timer)
    assert made.timer() is not None
    assert drawn == []
    allowed.set()
    for _ in range(3):
        made.icon(reading, 256, True)
        finish(made)
    assert drawn == [(reading.file, True)]
    _, other = new_luminaire(ies(peaks=(2, 1, 1, 1, 2)), name="other.ies")
    made.icon(files.read(other), 256, True)
    made.icon(reading, 256, False)
    finish(made)
    assert drawn[1:] == [(files.read(other).file, True), (reading.file, False)]
    icon = next(iter(made._icons.values()))
    assert tuple(icon.image_size) == (256, 256)
    first = int(icon.image_pixels[0]) & 0xFFFFFFFF
    # Red in the lowest byte, of the bottom left pixel.
    assert first & 0xFF == 255
    assert (first >> 8) & 0xFF == pytest.approx(127, abs=1)
    made.close()
    assert not bpy.app.timers.is_registered(made.timer)


def test_pictures_have_few_sizes_that_fit():
    widths = [luminaire_pictures.side_of(room) for room in (10.0, 255.9, 256.0, 270.0, 5000.0)]
    assert widths == [160, 224, 256, 256, 480]


def test_diagram_of_a_real_file_becomes_an_icon(new_luminaire):
    made = luminaire_pictures.Pictures()
    _, settings = new_luminaire(ies())
    made.icon(files.read(settings), 256, False)
    finish(made)
    (icon,) = made._icons.values()
    pixels = np.empty(256 * 256 * 4, np.float32)
    icon.image_pixels_float.foreach_get(pixels)
    # White paper with something on it.
    assert pixels.max() == 1.0
    assert 0.01 < (pixels < 0.7).mean() < 0.5
    made.close()


# ---- overlay ----


def test_lines_are_curves_as_long_as_the_solid_and_the_opening_in_its_own_size(new_luminaire):
    new_luminaire(ies(size=(0.3, 0.6, 0.0)), matrix=Matrix.Translation((10, 20, 30)))
    metres, radius = 0.01, 50.0
    places = shown(scale=metres)
    view = luminaire_overlay._Shown(places, np.zeros((1, 3)), radius)
    points, colours = luminaire_overlay._lines(view, metres)
    assert len(points) % 2 == 0
    assert colours.shape == (len(points), 4)
    parts = {
        name: points[np.isclose(colours, colour).all(axis=1)] - (10, 20, 30)
        for name, colour in zip(
            ("C0", "C90", "opening"),
            (*luminaire_overlay.CURVE_COLOURS, luminaire_overlay.OPENING_COLOUR),
            strict=True,
        )
    }
    # 0.6 m along x and 0.3 m along y, in units of 1 cm.
    assert np.ptp(parts["opening"], axis=0) == pytest.approx((60.0, 30.0, 0.0), abs=1e-4)
    assert np.linalg.norm(parts["C0"], axis=1).max() == pytest.approx(radius, rel=1e-3)
    assert np.abs(parts["C0"][:, 1]).max() < 1e-4
    assert np.abs(parts["C90"][:, 0]).max() < 1e-4
    # In C90 and C270, 1 of the peak's 9 cd at 0 and at 45 degrees.
    assert np.linalg.norm(parts["C90"], axis=1).max() == pytest.approx(radius / 9.0, rel=1e-3)


def test_views_are_looked_through_anew_only_after_changes_that_can_matter(new_luminaire):
    source, settings = new_luminaire(ies())
    mesh = bpy.data.objects.new("Floor", bpy.data.meshes.new("Floor"))
    bpy.context.scene.collection.objects.link(mesh)
    bpy.context.view_layer.update()
    views = luminaire_overlay._cache.views
    bpy.app.handlers.depsgraph_update_post.append(luminaire_overlay.note_update)

    def is_noted(change):
        views["view"] = None
        change()
        bpy.context.view_layer.update()
        return not views

    def turn():
        settings.rotation = 1.0

    try:
        assert not is_noted(lambda: setattr(mesh, "location", (1, 0, 0)))
        assert is_noted(lambda: setattr(source, "location", (1, 0, 0)))
        assert is_noted(turn)
        assert is_noted(lambda: source.select_set(True))
        assert is_noted(lambda: source.hide_set(True))
        assert is_noted(lambda: bpy.data.objects.remove(source))
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(luminaire_overlay.note_update)
        views.clear()
