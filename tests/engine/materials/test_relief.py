"""Reliefs: light by normals that vary by place, none of it made, and illuminance as without them."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake_in, lamp
from scattering_models import towards
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, Quantity, SunLight
from lumenray.engine.scene.material import (
    Cauchy,
    Coated,
    Dielectric,
    Diffuse,
    Glossy,
    Material,
    Mix,
    Raised,
    ThinGlass,
    raise_surface,
)
from lumenray.engine.scene.mesh import Geometry, Placement
from lumenray.engine.scene.relief import Axes, Heights, Normals
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.session import Session
from lumenray.engine.transport import backend
from lumenray.engine.views import ViewSettings

SURFACES = {
    "matt": Diffuse(Constant(1.0)),
    "sheet": Diffuse(Constant(0.6), Constant(0.4)),
    "varnish": Coated(Constant(1.0), 1.5, 0.3),
    "rough metal": Glossy(Constant(1.0), 0.5),
    "mirror": Glossy(Constant(1.0), 0.0),
    "rough glass": Dielectric(Cauchy(1.5), 0.5),
}


def tilted(angle, azimuth=0.0, **more):
    """A picture of the same normal everywhere: by angles from the surface's normal and from U. [degree]"""
    a, b = np.radians(angle), np.radians(azimuth)
    vector = (np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a))
    return Normals(ImageTexture(np.array([[vector]], np.float32)), **more)


def plugin(surface):
    from lumenray.engine.materials import plugins
    from lumenray.engine.transport.compiled.surfaces import bsdf
    from lumenray.engine.transport.compiled.textures import TextureMaker

    backend.start(spectral=False)
    plugins.register()
    make = TextureMaker(np.ones(471))
    made = bsdf(surface, make)
    make.bitmaps.table.commit()
    if isinstance(made, dict):
        import mitsuba as mi

        made = mi.load_dict(made)
    return made


def view(direction, count=1):
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = mi.Vector3f(*map(float, direction))
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    si.dp_du, si.dp_dv = mi.Vector3f(2, 0, 0), mi.Vector3f(0, 2, 0)
    si.uv = mi.Point2f(0.3, 0.6)
    return si


def answer(model, wi, wo):
    import mitsuba as mi

    value, pdf = model.eval_pdf(mi.BSDFContext(), view(wi), mi.Vector3f(*map(float, wo)), True)
    return float(np.array(value)[0, 0]), float(np.array(pdf)[0])


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("angle", [20, 75, 130])
@pytest.mark.parametrize("name", [*SURFACES])
def test_a_white_surface_with_a_relief_makes_no_light(name, angle):
    import mitsuba as mi

    count = 1 << 16
    for tilt in (15.0, 50.0):
        for azimuth in (0.0, 180.0):
            model = plugin(Raised(SURFACES[name], tilted(tilt, azimuth)))
            stream = mi.PCG32(size=count, initstate=7)
            sample = mi.Point2f(stream.next_float32(), stream.next_float32())
            si = view(towards(angle), count)
            bs, weight = model.sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
            # Radiance in glass grows with the square of its index; what arrives does not.
            found = np.array(weight)[0] * np.array(bs.eta) ** 2
            error = found.std() / np.sqrt(count)
            assert found.mean() < 1.0 + 4.0 * error + 1e-3
            assert found.mean() > 0.3


@pytest.mark.parametrize("name", ["matt", "sheet", "varnish", "rough metal"])
def test_sampled_light_is_the_integral_of_the_answers(name):
    import mitsuba as mi

    count = 1 << 18
    model = plugin(Raised(SURFACES[name], tilted(35.0, 200.0)))
    stream = mi.PCG32(size=count, initstate=9)
    si = view(towards(50), count)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    _, weight = model.sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    wo = mi.warp.square_to_uniform_sphere(mi.Point2f(stream.next_float32(), stream.next_float32()))
    value, _ = model.eval_pdf(mi.BSDFContext(), si, wo, True)
    drawn, even = np.array(weight)[0], 4.0 * np.pi * np.array(value)[0]
    error = np.hypot(drawn.std(), even.std()) / np.sqrt(count)
    assert drawn.mean() == pytest.approx(even.mean(), abs=4.0 * error)


@pytest.mark.parametrize(
    ("name", "tilt", "loss"),
    # Of mirrors, eyes that look along the facets see more than is traced to them.
    [
        ("matt", 25.0, 0.0),
        ("sheet", 25.0, 0.0),
        ("varnish", 25.0, 0.01),
        ("rough metal", 8.0, 0.02),
    ],
)
def test_light_on_its_way_from_a_lamp_is_shared_out_as_it_is_seen(name, tilt, loss):
    import mitsuba as mi

    count = 1 << 18
    model = plugin(Raised(SURFACES[name], tilted(tilt, 120.0)))
    stream = mi.PCG32(size=count, initstate=11)
    light = towards(40)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    context = mi.BSDFContext(mi.TransportMode.Importance)
    _, weight = model.sample(context, view(light, count), stream.next_float32(), sample, True)
    eye = mi.warp.square_to_uniform_sphere(mi.Point2f(stream.next_float32(), stream.next_float32()))
    si = view(light, count)
    si.wi = eye
    value, _ = model.eval_pdf(mi.BSDFContext(), si, mi.Vector3f(*map(float, light)), True)
    # Flux that leaves over flux that comes: radiance towards every eye, by the cosines to the face.
    seen = np.array(value)[0] * np.abs(np.array(eye.z)) / abs(light[2]) * 4.0 * np.pi
    drawn = np.array(weight)[0]
    error = np.hypot(drawn.std(), seen.std()) / np.sqrt(count)
    assert drawn.mean() == pytest.approx(seen.mean(), abs=4.0 * error + loss)
    assert drawn.mean() > 0.3


@pytest.mark.parametrize("name", [*SURFACES])
def test_a_relief_without_slope_changes_nothing(name):
    for relief in (
        tilted(0.0),
        Heights(ImageTexture(np.full((2, 2, 1), 3.0, np.float32))),
    ):
        plain, raised = plugin(SURFACES[name]), plugin(Raised(SURFACES[name], relief))
        for pair in (((0.3, 0.1, 0.9), (-0.5, 0.4, 0.7)), ((0.9, 0.0, 0.2), (-0.9, 0.1, 0.3))):
            wi, wo = (np.array(each) / np.linalg.norm(each) for each in pair)
            for sign in (1.0, -1.0):
                expected = answer(plain, wi, wo * (1.0, 1.0, sign))
                assert answer(raised, wi, wo * (1.0, 1.0, sign)) == pytest.approx(
                    expected, rel=1e-4, abs=1e-7
                )


@pytest.mark.parametrize("name", ["rough metal", "varnish"])
def test_a_relief_is_reciprocal_in_its_own_frame_but_for_its_shadows(name):
    normal = np.array([np.sin(np.radians(20.0)), 0.0, np.cos(np.radians(20.0))])
    surface = SURFACES[name]
    if name == "varnish":
        # Shadows are those of the matt part.
        surface = replace(surface, reflectance=Constant(0.0))
    model = plugin(Raised(surface, tilted(20.0)))
    a, b = np.array([0.6, 0.2, 0.77]), np.array([-0.1, -0.5, 0.86])
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    there, back = answer(model, a, b)[0] / (normal @ b), answer(model, b, a)[0] / (normal @ a)
    assert there == pytest.approx(back, rel=1e-3)
    assert there > 0.0


# ---- scenes ----

CAMERA = Camera(
    np.array([[1, 0, 0, 0.5], [0, 1, 0, 0.5], [0, 0, 1, 2.0], [0, 0, 0, 1.0]]),
    Projection.ORTHOGRAPHIC,
    4,
    4,
    0.5,
    0.5,
)


def shown(surface, direction, *items, frame=None, uv=None, **settings):
    """Luminance and illuminance of a square of 1 m from above, in a sun of 1000 lx across its way."""
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), np.array(direction), 0.0)
    floor = quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), "m")
    if uv is not None:
        floor = replace(floor, uv_maps={"UV": uv(floor.uv_maps["UV"])})
    things = [floor]
    if frame is not None:
        geometry = Geometry(
            "g", floor.vertices, floor.triangles, np.zeros(2, np.int32), uv_maps=floor.uv_maps
        )
        things = [geometry, Placement("floor", "floor", "g", frame, ("m",))]
    session = session_of(*things, Material("m", "m", surface), sun, *items)
    rule = StopRule(samples=16)
    made = session.render(CAMERA, ViewSettings(rule, illuminance=True, **settings))
    return made.tristimulus[..., 1].mean(), made.illuminance.mean()


SUN = np.array([0.6, 0.0, -0.8])
"""Way of the light."""


def lit(normal, up=(0.0, 0.0, 1.0)):
    """Luminance of a matt surface of reflectance 0.5 in the sun, by its normal: Lambert's law and the shadows of facets."""
    normal, up = np.asarray(normal, float), np.asarray(up, float)
    normal = normal / np.linalg.norm(normal)
    tangents = [max(1.0 / c**2 - 1.0, 0.0) for c in (normal @ up, -SUN @ up)]
    shadow = 2.0 / (1.0 + np.sqrt(1.0 + min(tangents[0] / 8.0, 1.0) * tangents[1]))
    return 1000.0 * 0.5 / np.pi * max(-SUN @ normal, 0.0) * shadow


GREY = Diffuse(Constant(0.5))


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("method", ["paths", "cells"])
@pytest.mark.parametrize("azimuth", [0.0, 90.0, 180.0])
def test_a_tilted_normal_is_lit_as_a_tilted_facet_and_its_illuminance_is_that_of_the_floor(
    azimuth, method
):
    relief = tilted(25.0, azimuth)
    luminance, illuminance = shown(Raised(GREY, relief), SUN, method=method)
    expected = lit(relief.vectors.pixels[0, 0])
    assert luminance == pytest.approx(expected, rel=2e-3)
    assert illuminance == pytest.approx(800.0, rel=1e-3)


def ramp(slope, **more):
    """Heights that rise by a slope along U of a square of 1 m, and fall back beyond its ends."""
    values = slope * (np.arange(64, dtype=np.float32) + 0.5) / 64
    return Heights(ImageTexture(values[None, :, None].repeat(2, 0), extension="extend"), **more)


def test_heights_turn_the_normal_by_their_slope():
    luminance, _ = shown(Raised(GREY, ramp(0.3)), SUN)
    assert luminance == pytest.approx(lit((-0.3, 0.0, 1.0)), rel=2e-3)


def test_half_of_a_relief_goes_half_of_the_way():
    normal = np.array([-0.3, 0.0, 1.0]) / np.hypot(0.3, 1.0) + (0.0, 0.0, 1.0)
    luminance, _ = shown(Raised(GREY, ramp(0.3, strength=0.5)), SUN)
    assert luminance == pytest.approx(lit(normal), rel=2e-3)


def test_heights_add_up_on_what_lies_below():
    below = ramp(0.2, is_shape=True)
    luminance, _ = shown(Raised(GREY, ramp(0.1, below=below)), SUN)
    # The upper slope is measured along the mesh and across the normal below.
    first = np.array([-0.2, 0.0, 1.0]) / np.hypot(0.2, 1.0)
    rise = np.array([0.1, 0.0, 0.0])
    rise[2] -= rise @ first / first[2]
    assert luminance == pytest.approx(lit(first - rise, first), rel=2e-3)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_mirrored_map_keeps_where_heights_rise(axis):
    def mirrored(uv):
        made = uv.copy()
        made[..., axis] = 1.0 - made[..., axis]
        return made

    luminance, _ = shown(Raised(GREY, ramp(0.3)), SUN, uv=mirrored)
    assert luminance == pytest.approx(lit((0.3 if axis == 0 else -0.3, 0.0, 1.0)), rel=2e-3)


def test_a_mirrored_map_turns_tangents_with_it():
    def mirrored(uv):
        return uv * np.array([1.0, -1.0], np.float32) + np.array([0.0, 1.0], np.float32)

    sideways = np.array([0.0, 0.6, -0.8])
    relief = tilted(25.0, 90.0)
    luminance, _ = shown(Raised(GREY, relief), sideways, uv=mirrored)
    normal = relief.vectors.pixels[0, 0] * (1, -1, 1)
    tangents = [np.tan(np.radians(25.0)) ** 2, (0.6 / 0.8) ** 2]
    shadow = 2.0 / (1.0 + np.sqrt(1.0 + tangents[0] / 8.0 * tangents[1]))
    assert luminance == pytest.approx(500.0 / np.pi * -(sideways @ normal) * shadow, rel=2e-3)


def turned(angle, scale=1.0):
    """Frame of an object that is turned about z about the middle of the square. [degree]"""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    frame = np.eye(4)
    frame[:2, :2] = scale * np.array([[c, -s], [s, c]])
    frame[2, 2] = scale
    frame[:2, 3] = 0.5 - frame[:2, :2] @ (0.5, 0.5)
    return frame


@pytest.mark.parametrize(("axes", "turn"), [(Axes.OBJECT, 90.0), (Axes.WORLD, 0.0)])
def test_normals_in_axes_of_the_object_turn_with_it_and_those_of_the_world_do_not(axes, turn):
    relief = tilted(25.0, 180.0, axes=axes)
    luminance, _ = shown(Raised(GREY, relief), SUN, frame=turned(90.0))
    a, b = np.radians(25.0), np.radians(180.0 + turn)
    expected = lit((np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)))
    assert luminance == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(("in_object", "slope"), [(True, 0.3), (False, 0.1)])
def test_heights_in_units_of_the_object_grow_with_it(in_object, slope):
    relief = ramp(0.3, in_object=in_object)
    luminance, _ = shown(Raised(GREY, relief), SUN, frame=turned(0.0, 3.0))
    assert luminance == pytest.approx(lit((-slope, 0.0, 1.0)), rel=2e-3)


def test_an_edit_gives_a_relief_and_takes_it_away():
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), SUN, 0.0)
    floor = quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), "m")
    session = session_of(floor, Material("m", "m", GREY), sun)
    relief = tilted(25.0, 180.0)
    for surface, normal in (
        (GREY, (0.0, 0.0, 1.0)),
        (Raised(GREY, relief), relief.vectors.pixels[0, 0]),
        (Raised(GREY, ramp(0.3)), (-0.3, 0.0, 1.0)),
        (GREY, (0.0, 0.0, 1.0)),
    ):
        session.apply(SceneDelta(changed=(Material("m", "m", surface),)))
        made = session.render(CAMERA, ViewSettings(StopRule(samples=16)))
        assert made.tristimulus[..., 1].mean() == pytest.approx(lit(normal), rel=2e-3)


def waves():
    """Normals that lean to all sides."""
    x, y = np.meshgrid(np.arange(8) / 8, np.arange(8) / 8)
    vectors = np.stack(
        [0.5 * np.sin(2 * np.pi * x), 0.5 * np.cos(2 * np.pi * y), np.ones((8, 8))], axis=2
    )
    return Normals(ImageTexture(vectors.astype(np.float32)))


def room(surface):
    """A closed room of 2 m with a table of a surface in it, under a lamp."""
    table = quad("table", (0.4, 0.4, 0.5), (1.2, 0, 0), (0, 1.2, 0), "m")
    items = (box(2, 2, 2), table, paint(0.6), Material("m", "m", surface), lamp((0.6, 1.0, 1.7)))
    return session_of(*items)


@pytest.mark.slow
def test_a_room_with_a_relief_is_the_same_with_cells_and_by_full_paths():
    frame = np.array([[1, 0, 0, 1.0], [0, 0.8, -0.6, 0.2], [0, 0.6, 0.8, 1.6], [0, 0, 0, 1.0]])
    camera = Camera(frame, Projection.PERSPECTIVE, 8, 8, 1.2, 1.2)
    made = {}
    for method in ("paths", "cells"):
        session = room(Raised(GREY, waves()))
        made[method] = session.render(camera, ViewSettings(StopRule(samples=512), method=method))
    means = [picture.tristimulus[..., 1].mean() for picture in made.values()]
    errors = [np.sqrt((p.luminance_error**2).sum()) / 64 for p in made.values()]
    assert means[0] == pytest.approx(means[1], abs=4.0 * np.hypot(*errors) + 2e-3 * means[0])


@pytest.mark.slow
def test_light_paths_from_the_lamp_find_what_gathering_finds_under_a_relief():
    session = Session(witness=True)
    table = quad("table", (0.4, 0.4, 0.5), (1.2, 0, 0), (0, 1.2, 0), "m")
    surface = Raised(Diffuse(Constant(0.8)), waves())
    items = (box(2, 2, 2), table, paint(0.6), Material("m", "m", surface), lamp((0.6, 1.0, 1.7)))
    session.apply(SceneDelta(changed=items))
    places = [(1.0, 1.0, 1.2), (1.0, 1.0, 0.2)]
    made = session.measure(places, [(0, 0, -1), (0, 0, 1)], StopRule(samples=4096))
    assert not [note for note in made.provenance.notes if "light paths from the lights" in note]


def test_a_map_of_a_relief_is_that_of_the_flat_surface_in_direct_light():
    made = {}
    for name, surface in (("flat", Diffuse(Constant(0.0))), ("raised", Diffuse(Constant(0.0)))):
        relief = waves() if name == "raised" else None
        sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), SUN, 0.0)
        floor = quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), "m")
        session = session_of(floor, Material("m", "m", raise_surface(surface, relief)), sun)
        made[name] = bake_in(session, ("floor",), 16, density=4.0).mean
    assert made["raised"] == pytest.approx(made["flat"], rel=1e-6)
    assert made["raised"] == pytest.approx(800.0, rel=1e-3)


# ---- data ----


def test_a_relief_lies_on_all_parts_that_it_can_turn():
    mixed = Mix(GREY, Mix(ThinGlass(), Glossy(Constant(0.9), 0.3), 0.5), 0.5)
    made = raise_surface(mixed, tilted(10.0))
    assert isinstance(made.first, Raised)
    assert made.second.first == ThinGlass()
    assert isinstance(made.second.second, Raised)
    assert made.has_relief and not mixed.has_relief
    assert not made.second.second.is_mirror


def test_a_relief_on_a_pane_is_refused():
    with pytest.raises(SceneError, match="relief cannot lie on a surface of kind ThinGlass"):
        shown(Raised(ThinGlass(), tilted(10.0)), SUN)


def test_a_picture_of_the_wrong_kind_is_refused():
    heights = Heights(ImageTexture(np.ones((2, 2, 3), np.float32)))
    with pytest.raises(SceneError, match="has 3 channels, expected 1"):
        shown(Raised(GREY, heights), SUN)
