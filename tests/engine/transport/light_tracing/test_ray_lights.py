"""Lights from ray sets: near light is traced, far light comes from their intensities, and both add up to the exact light."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake, moved
from ray_lamps import (
    BLACK,
    FLUX,
    SIZE,
    WHITE,
    exact_disk,
    floor,
    lamp_at,
    light_of,
    lumels_of,
    rays_of,
)
from small_scenes import box, paint, quad, session_of

from lumenray.benchmarks.common.ray_sources import disk, helix, sphere
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.photometry.spectra import GRID, luminous_efficiency
from lumenray.engine.raysets.cloud import make_cloud
from lumenray.engine.raysets.emission import make_emission
from lumenray.engine.raysets.reduction import TO_LUMINAIRE
from lumenray.engine.scene.distribution import Opening
from lumenray.engine.scene.material import (
    Cauchy,
    Dielectric,
    Glossy,
    Material,
    TabulatedPane,
    ThinGlass,
)
from lumenray.engine.scene.spectrum import Constant, Lines

# ---- preparation ----


@pytest.mark.slow
def test_a_file_becomes_a_light_with_its_flux_and_place():
    made = light_of(disk)
    assert made.luminous_flux == pytest.approx(FLUX, rel=1e-4)
    assert made.emission.size == pytest.approx(SIZE, rel=0.01)
    np.testing.assert_allclose(made.emission.half[:2], 0.5 * SIZE, rtol=0.03)
    assert made.emission.half[2] < 1e-3 * SIZE
    np.testing.assert_allclose(made.centre, 0.0, atol=1e-3)
    # Up in the file is down for a luminaire.
    assert made.emission.direction[:, 2].max() <= 1e-3


def test_the_error_of_a_point_falls_with_the_distance():
    """Of a Lambertian disk on its axis it is 1 - 4 d^2 / (4 d^2 + 1): 0.06 at two sizes and 0.01 at five."""
    made = light_of(disk).emission
    errors = dict(zip(np.round(made.far_distances / made.size), made.far_errors, strict=True))
    assert errors[1] > 3.0 * errors[2] > 3.0 * errors[5]
    assert errors[5] < 0.015
    assert errors[20] < 0.005


@pytest.mark.mitsuba
@pytest.mark.parametrize("error", [0.04, 0.001])
def test_results_say_that_a_file_has_few_rays(error):
    lamp = lamp_at((0.0, 0.0, 1.0))
    lamp = replace(lamp, rays=replace(lamp.rays, information_error=error))
    session = session_of(BLACK, floor(1.0), lamp)
    made = session.measure(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), StopRule(samples=16))
    told = [note for note in made.provenance.notes if "few rays" in note]
    assert len(told) == (error > 0.01)
    assert all("within 4 %" in note for note in told)


@pytest.mark.mitsuba
@pytest.mark.parametrize("source", [disk, sphere, helix])
@pytest.mark.slow
def test_kernels_draw_the_same_rays_as_the_host(source):
    from lumenray.engine.transport import backend

    backend.start(spectral=False)
    import mitsuba as mi

    from lumenray.engine.transport.light_tracing.ray_source import RaySource

    rays = rays_of(source, 4000)
    cloud = make_cloud(rays, 1.0)
    emission = make_emission(cloud, np.zeros(3), np.zeros(0), np.zeros(0))
    count = 1 << 18
    position, direction, weight, colour = RaySource(emission).draw(
        mi.PCG32(size=count, initstate=3)
    )
    assert colour is None
    drawn = cloud.draw(count, np.random.default_rng(4))
    ours = [np.array(each).T for each in (position, direction)]
    theirs = [drawn.position @ TO_LUMINAIRE, drawn.direction @ TO_LUMINAIRE]
    flux = [np.array(weight) / count, drawn.flux]
    assert flux[0].sum() == pytest.approx(1.0, rel=2e-3)
    np.testing.assert_allclose(np.linalg.norm(ours[1], axis=1), 1.0, atol=1e-5)
    features = []
    for p, d in (ours, theirs):
        columns = np.column_stack([p / emission.size, d])
        features.append(
            np.column_stack(
                [columns, *(columns * np.roll(columns, k, axis=1) for k in range(4)), columns**3]
            )
        )
    # Means of all products agree within chance.
    means = [f.T @ w for f, w in zip(features, flux, strict=True)]
    spread = np.sqrt(features[1].var(axis=0) * 2.0 / count) * 1.3
    assert (np.abs(means[0] - means[1]) < 4.5 * spread + 1e-5).all()


# ---- light on surfaces ----


def baked_error(result, mesh, exact):
    """Relative root mean square difference by area of one map, and the part of chance in it."""
    values, places = lumels_of(result, mesh)
    light = values.illuminance.astype(float)
    true = exact(places)
    area = values.area / values.area.sum()
    mean = area @ true
    rms = np.sqrt(area @ (light - true) ** 2) / mean
    chance = np.sqrt(area @ values.standard_error.astype(float) ** 2) / mean
    return (area @ light) / mean, rms, chance


@pytest.mark.mitsuba
@pytest.mark.parametrize("sizes", [1.0, 2.0, 4.0])
@pytest.mark.slow
def test_near_light_on_a_plane_is_the_exact_one(sizes):
    height = sizes * SIZE
    centre = np.array([0.0, 0.0, height])
    side = 2.0 * height
    result = bake(
        (floor(side), BLACK, lamp_at(centre)), ("floor",), 2048, density=24.0 / side, margin=1
    )
    mean, rms, chance = baked_error(result, floor(side), lambda places: exact_disk(places, centre))
    assert mean == pytest.approx(1.0, abs=0.01)
    # The file's own error, and what lumels smooth.
    assert np.sqrt(max(rms**2 - chance**2, 0.0)) < 0.03


@pytest.mark.mitsuba
@pytest.mark.parametrize("transport", ["mono", pytest.param("spectral", marks=pytest.mark.slow)])
def test_near_and_far_light_join_without_a_seam(transport):
    """A floor that is near in the middle and far outside: no light is missing or counted twice at five sizes."""
    centre = np.array([0.0, 0.0, 0.35])
    result = bake(
        (floor(1.6), BLACK, lamp_at(centre)),
        ("floor",),
        1024,
        density=20.0,
        margin=1,
        transport=transport,
    )
    values, places = lumels_of(result, floor(1.6))
    true = exact_disk(places, centre)
    away = np.linalg.norm(places - centre, axis=1) / SIZE
    ratio = values.illuminance / true
    for low, high in ((0.0, 4.5), (4.5, 5.5), (5.5, 9.0)):
        ring = (away >= low) & (away < high)
        assert ring.sum() > 20
        # The set's own error is 2.4 %, of rings less.
        assert np.mean(ratio[ring]) == pytest.approx(1.0, abs=0.02)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_pane_between_takes_its_share_of_near_light():
    centre = np.array([0.0, 0.0, 0.3])
    even = np.full(2, 0.7)
    glass = Material("pane", "pane", TabulatedPane(np.array([0.0, 90.0]), even, 0.0 * even))
    pane = quad("pane", (-1, -1, 0.15), (2, 0, 0), (0, 2, 0), "pane")
    floor_, lamp = floor(0.5), lamp_at(centre)
    means = [
        bake(items, ("floor",), 512, density=16.0, margin=1).maps[0].mean
        for items in ((floor_, BLACK, lamp), (floor_, BLACK, glass, pane, lamp))
    ]
    assert means[1] / means[0] == pytest.approx(0.7, abs=0.01)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_near_light_is_reflected_on():
    """A closed white box around the lamp: all of its flux ends in the walls, F rho / (1 - rho) of it after reflections."""
    room = box(0.6, 0.6, 0.6)
    lamp = lamp_at(np.array([0.3, 0.3, 0.3]), sphere)
    result = bake((room, paint(0.5), lamp), ("box",), 512, density=16.0)
    values = result.lumels(0)
    flux = float(values.illuminance.astype(float) @ values.area)
    assert flux == pytest.approx(FLUX / (1.0 - 0.5), rel=0.01)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_light_through_a_lens_is_traced_at_any_distance():
    """A slab of glass before the lamp: beyond five sizes too the light arrives, less what the surfaces mirror."""
    centre = np.array([0.0, 0.0, 1.5])
    glass = Material("glass", "glass", Dielectric(Cauchy(1.5)))
    slab = moved(box(3.0, 3.0, 0.05, "glass", inwards=False), "slab", (-1.5, -1.5, 1.2))
    lamp = lamp_at(centre)
    free, shut = (
        bake(items, ("floor",), 512, density=16.0, margin=1).maps[0].mean
        for items in ((floor(0.4), BLACK, lamp), (floor(0.4), BLACK, glass, slab, lamp))
    )
    # Two surfaces, reflected back and forth: (1 - R) / (1 + R), R = 0.04; the bend moves the image nearer by a third of
    # the thickness.
    expected = (0.96 / 1.04) * (1.5 / (1.5 - 0.05 / 3.0)) ** 2
    assert shut / free == pytest.approx(expected, rel=0.02)


@pytest.mark.mitsuba
def test_a_body_within_the_rays_casts_no_shadow():
    """The lamp's own mesh around its centre does not stop what begins outside of it."""
    centre = np.array([0.0, 0.0, 1.2])
    body = moved(box(0.04, 0.04, 0.04, "black", inwards=False), "body", centre - 0.02)
    lamp = lamp_at(centre, sphere, count=2000)
    free, clad = (
        bake(items, ("floor",), 256, density=16.0, margin=1).maps[0].mean
        for items in ((floor(0.4), BLACK, lamp), (floor(0.4), BLACK, body, lamp))
    )
    assert clad == pytest.approx(free, rel=0.01)


@pytest.mark.mitsuba
def test_nothing_is_traced_where_all_is_far_and_pictures_see_points_again():
    from lumenray.engine.transport.light_tracing.light_paths import LightTracer

    session = session_of(floor(2.0), BLACK, lamp_at(np.array([0.0, 0.0, 1.5])))
    scene = session._prepare("auto", False)
    scene.settle()
    assert not LightTracer(scene).is_needed
    session = session_of(floor(2.0), BLACK, lamp_at(np.array([0.0, 0.0, 0.3])))
    scene = session._prepare("auto", False)
    scene.settle()
    tracer = LightTracer(scene)
    palette = scene.lights.palette
    assert tracer.is_needed
    assert "traced" in tracer.reason
    # Not all that lands within five sizes: what lands farther out is right as a point within half a percent.
    assert 0.3 < np.array(palette._limits)[0] <= 5.01 * SIZE
    tracer.close()
    assert np.array(palette._limits)[0] == 0.0


@pytest.mark.mitsuba
def test_many_lamps_of_one_file_shine_each():
    places = [(-0.4, 0.0, 0.2), (0.4, 0.0, 0.2), (0.0, 0.4, 0.3)]
    lamps = [replace(lamp_at(np.array(p)), id=f"led{i}") for i, p in enumerate(places)]
    lamps[1] = replace(lamps[1], output=replace(lamps[1].output, value=3.0 * FLUX))
    result = bake((floor(1.4), BLACK, *lamps), ("floor",), 1024, density=16.0, margin=1)

    def exact(where):
        weights = (1.0, 3.0, 1.0)
        return sum(w * exact_disk(where, np.array(p)) for w, p in zip(weights, places, strict=True))

    mean, rms, chance = baked_error(result, floor(1.4), exact)
    assert mean == pytest.approx(1.0, abs=0.01)
    assert np.sqrt(max(rms**2 - chance**2, 0.0)) < 0.04


@pytest.mark.mitsuba
@pytest.mark.slow
def test_rays_with_wavelengths_of_their_own_pass_a_coloured_pane_by_them():
    """Half of the lumens at 480 nm, half at 620 nm, through a pane that lets only the red pass."""
    from lumenray.engine.scene.spectrum import Tabulated

    centre = np.array([0.0, 0.0, 0.3])
    efficiency = np.interp([480.0, 620.0], GRID, luminous_efficiency())
    lamp = lamp_at(centre, spectrum=Lines(np.array([480.0, 620.0]), 1.0 / efficiency))
    colours = np.where(np.arange(len(lamp.rays.threshold)) % 2, 480.0, 620.0).astype(np.float32)
    lamp = replace(lamp, rays=replace(lamp.rays, wavelength=colours))
    red = Tabulated(np.array([360.0, 549.0, 551.0, 830.0]), np.array([0.0, 0.0, 1.0, 1.0]))
    pane = quad("pane", (-1, -1, 0.15), (2, 0, 0), (0, 2, 0), "pane")
    means = []
    for colour in (WHITE, red):
        glass = Material("pane", "pane", ThinGlass(1.5, colour))
        items = (floor(0.4), BLACK, glass, pane, lamp)
        means.append(bake(items, ("floor",), 512, density=16.0, margin=1).maps[0].mean)
    assert means[1] / means[0] == pytest.approx(0.5, abs=0.02)


def test_rays_and_an_opening_together_are_refused():
    lamp = lamp_at(np.zeros(3), opening=Opening("ellipse", (0.1, 0.1, 0.0)))
    session = session_of(floor(1.0), BLACK, lamp)
    with pytest.raises(SceneError, match="rays and an opening"):
        session._prepare("auto", False)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_surfaces_near_by_that_are_not_matt_keep_their_light():
    """A satin mirror close to the lamp throws its light on the floor: nothing of it may be lost to what is traced."""
    centre = np.array([0.0, 0.0, 0.4])
    # It shines up.
    lamp = lamp_at(centre)
    turned = lamp.frame.copy()
    turned[:3, :3] = np.diag([1.0, -1.0, -1.0])
    lamp = replace(lamp, frame=turned)
    satin = Material("satin", "satin", Glossy(Constant(0.9), 0.3))
    ceiling = quad("ceiling", (-0.5, 0.5, 0.6), (1, 0, 0), (0, -1, 0), "satin")
    items = (floor(0.8), BLACK, satin, ceiling, lamp)
    means = [
        bake(items, ("floor",), 1024, density=12.0, margin=1, caustics=way).maps[0].mean
        for way in ("auto", "off")
    ]
    assert means[1] > 10.0
    assert means[0] == pytest.approx(means[1], rel=0.03)


@pytest.mark.mitsuba
def test_a_long_source_does_not_shine_through_the_ceiling_above_it():
    """The rays start within a thin bar: what lies beyond the bar shades, though a ball around the bar would reach it."""
    centre = np.array([0.0, 0.0, 1.0])
    thin = np.array([0.001, SIZE * 0.5, 0.001])
    lamp = lamp_at(centre, sphere, count=2000)
    lamp = replace(lamp, rays=replace(lamp.rays, half=thin, near=0.0))
    ceiling = quad("ceiling", (-1.0, -1.0, 1.0 + 0.2 * SIZE), (2, 0, 0), (0, 2, 0), "black")
    above = quad("above", (-0.5, 0.5, 2.0), (1, 0, 0), (0, -1, 0), "black")
    result = bake((above, ceiling, BLACK, lamp), ("above",), 64, density=8.0, caustics="off")
    assert result.maps[0].largest.high == 0.0
