"""Measured surfaces in kernels: the table's values, directions as dense as stated, bounded weights, pictures as analytic."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from device_values import vectors
from scattering_models import directions, ggx, lambert, random_table, schlick, towards
from scipy import stats

from lumenray.engine.scattering.data.evaluation import albedo, evaluate, total
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scene.material import Measured
from lumenray.engine.scene.scattering import ScatterTable
from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba

NM = (450.0, 520.0, 610.0, 680.0)


@pytest.fixture(autouse=True)
def _spectral():
    backend.start(spectral=True)


def plugin(surface, light=None):
    from lumenray.engine.scattering.kernels import plugin as plugins
    from lumenray.engine.transport.compiled.surfaces import bsdf
    from lumenray.engine.transport.compiled.textures import TextureMaker

    plugins.register()
    return bsdf(surface, TextureMaker(np.ones(471) if light is None else light))


def as_seen(surface):
    """What passes to an eye in front came from behind."""
    from lumenray.engine.scattering.kernels.plugin import seen_from_the_eye

    return seen_from_the_eye(surface)


def interaction(direction, count):
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = mi.Vector3f(
        *(mi.Float(np.atleast_1d(c).astype(np.float32)) for c in np.transpose(direction))
    )
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    if mi.is_spectral:
        si.wavelengths = mi.Spectrum(*NM)
    return si


def sampled(bsdf, direction, count, seed=5):
    """Directions, weights (4, n), densities and kinds of samples for one direction."""
    import mitsuba as mi

    stream = mi.PCG32(size=count, initstate=seed)
    si = interaction(direction, count)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    bs, weight = bsdf.sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    return (
        np.stack([np.array(c) for c in bs.wo], axis=1),
        np.array(weight),
        np.array(bs.pdf),
        np.array(bs.sampled_type),
    )


@lru_cache
def paint():
    lobe = ggx(0.1, schlick)
    return resample(lambda wi, wo: lobe(wi, wo) + 0.15, [550.0], tolerance=0.03)


SURFACES = {
    "paint": lambda: Measured(paint(), paint()),
    "random": lambda: Measured(random_table(3), random_table(4), rotation=0.4),
    "grained": lambda: Measured(
        random_table(8, is_orthotropic=True), random_table(9, 4, is_orthotropic=True), rotation=2.0
    ),
    "alike sides": lambda: Measured(random_table(5, 1, True)),
    "sheet": lambda: Measured(
        resample(lambert(0.3), [550.0]), None, random_table(6, 1), resample(lambert(0.4), [550.0])
    ),
}


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.slow
def test_kernels_give_the_values_of_the_table(name):
    import mitsuba as mi

    from lumenray.engine.scattering.data.surface import usable

    surface = SURFACES[name]()
    bsdf = plugin(surface)
    used = as_seen(usable(surface))
    wi, wo = directions(4000, 1), directions(4000, 2)
    wi[::3, 2] *= -1.0
    wo[::4, 2] *= -1.0
    made = np.array(bsdf.eval(mi.BSDFContext(), interaction(wi, 4000), vectors(wo), True))
    for front in (True, False):
        for through in (True, False):
            lanes = ((wi[:, 2] > 0) == front) & ((wi[:, 2] * wo[:, 2] < 0) == through)
            part = getattr(
                used,
                f"{'front' if front else 'back'}_{'transmission' if through else 'reflection'}",
            )
            if part is None:
                assert not made[:, lanes].any()
                continue
            c, s = np.cos(surface.rotation), np.sin(surface.rotation)
            turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            a, b = (v[lanes] @ turn * [1, 1, np.nan] for v in (wi, wo))
            a[:, 2], b[:, 2] = np.abs(wi[lanes, 2]), np.abs(wo[lanes, 2])
            at = evaluate(part, a, b)
            expected = np.stack([_between(part.wavelengths, at, nm) for nm in NM]) * b[:, 2]
            assert np.allclose(made[:, lanes], expected, rtol=2e-3, atol=2e-5)


def _between(wavelengths, values, nm):
    if len(wavelengths) == 1:
        return values[:, 0]
    return np.array([np.interp(nm, wavelengths, row) for row in values])


@pytest.mark.parametrize("angle", [3, 50, 75, 130])
@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.slow
def test_directions_are_as_dense_as_stated_and_weights_are_bounded(name, angle):
    import mitsuba as mi

    surface = SURFACES[name]()
    bsdf = plugin(surface)
    count = 1 << 18
    direction = towards(angle, 40)
    wo, weight, pdf, _ = sampled(bsdf, direction, count)
    if name == "alike sides" and angle > 90:
        assert not weight.any()
        return
    valid = pdf > 0.0
    bins = (20, 16)

    def cells(v):
        z = np.clip(((v[:, 2] + 1) / 2 * bins[0]).astype(int), 0, bins[0] - 1)
        turn = (np.arctan2(v[:, 1], v[:, 0]) / (2 * np.pi)) % 1.0
        return z * bins[1] + np.minimum((turn * bins[1]).astype(int), bins[1] - 1)

    observed = np.bincount(cells(wo[valid]), minlength=np.prod(bins))
    fine = 40
    z = (np.arange(bins[0] * fine) + 0.5) / (bins[0] * fine) * 2 - 1
    turn = (np.arange(bins[1] * fine) + 0.5) / (bins[1] * fine) * 2 * np.pi
    zz, tt = (m.ravel() for m in np.meshgrid(z, turn, indexing="ij"))
    sine = np.sqrt(1 - zz**2)
    grid = np.stack([sine * np.cos(tt), sine * np.sin(tt), zz], axis=1)
    context = mi.BSDFContext()
    density = np.array(
        bsdf.pdf(context, interaction(direction, len(grid)), vectors(grid), True), dtype=float
    )
    expected = np.bincount(cells(grid), weights=density, minlength=np.prod(bins))
    expected *= 4 * np.pi / len(grid) * count
    enough = expected > 20
    # The density jumps at the edges of the table's cells: its integral over a bin is known to 0.5 %.
    spread = expected[enough] + (0.005 * expected[enough]) ** 2
    chi = ((observed - expected)[enough] ** 2 / spread).sum()
    assert stats.chi2.sf(chi, enough.sum() - 1) > 1e-4
    value = np.array(bsdf.eval(context, interaction(direction, count), vectors(wo), True))
    assert np.allclose(weight[:, valid], value[:, valid] / pdf[valid], rtol=5e-3, atol=1e-4)
    # No sample counts for more than a few times the mean.
    assert weight.mean(axis=0).max() < 10.0 * weight.mean()


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("angle", [0, 40, 70, 84])
@pytest.mark.parametrize("name", SURFACES)
def test_the_furnace_gives_the_albedo(name, angle):
    from lumenray.engine.scattering.data.surface import usable

    surface = SURFACES[name]()
    used = as_seen(usable(surface))
    parts = [p for p in (used.front_reflection, used.front_transmission) if p is not None]
    _, weight, _, _ = sampled(plugin(surface), towards(angle, 40), 1 << 18)
    # At normal incidence there is no azimuth of incidence, and 0 stands for it.
    rotation = np.radians(40) - surface.rotation if angle else 0.0
    expected = sum(
        np.interp(NM, p.wavelengths, total(p, np.radians(angle), rotation)) for p in parts
    )
    error = weight.std(axis=1) / np.sqrt(weight.shape[1])
    assert (np.abs(weight.mean(axis=1) - expected) < 4.5 * error + 1e-4).all()
    assert weight.mean(axis=1).max() < 1.002


def test_mirror_and_straight_parts_are_drawn_with_their_shares():
    import mitsuba as mi

    table = resample(lambert(0.2), [550.0], incidences=np.radians([0.0, 60.0]))
    mirror = replace(table, direct=np.array([[[0.1], [0.3]]], dtype=np.float32))
    straight = replace(table, direct=np.array([[[0.4], [0.2]]], dtype=np.float32))
    bsdf = plugin(Measured(mirror, mirror, straight, straight))
    direction = towards(30, 20)
    wo, weight, _, kind = sampled(bsdf, direction, 1 << 17)
    mirrored = kind == +mi.BSDFFlags.DeltaReflection
    passed = kind == +mi.BSDFFlags.Null
    assert np.allclose(wo[mirrored], direction * [-1, -1, 1], atol=1e-6)
    assert np.allclose(wo[passed], -direction, atol=1e-6)
    for lanes, share in ((mirrored, 0.2), (passed, 0.3), (~mirrored & ~passed, 0.4)):
        part = weight[0] * lanes
        assert abs(part.mean() - share) < 4.5 * part.std() / np.sqrt(len(part))
    through = bsdf.eval_null_transmission(interaction(direction, 1), True)
    assert np.array(through)[:, 0] == pytest.approx(0.3, rel=1e-5)


@pytest.mark.parametrize("kind", ["fine bins", "coarse bins", "one interval", "two intervals"])
def test_places_on_axes_are_those_of_a_search(kind):
    import mitsuba as mi

    from lumenray.engine.scattering.data.table import place_on
    from lumenray.engine.scattering.kernels.table_lobe import MOST_BINS, Axis

    rng = np.random.default_rng(3)
    values = {
        "fine bins": np.cumsum(rng.uniform(0.05, 1.0, 40)),
        # Several grid lines in one bin, of which there are so many at most.
        "coarse bins": np.concatenate([np.linspace(0.0, 0.2 / MOST_BINS, 5), [0.5, 1.0]]),
        "one interval": np.array([0.3, 1.7]),
        "two intervals": np.array([0.3, 0.4, 1.7]),
    }[kind].astype(np.float32)
    axis = Axis(values)
    assert (axis.steps > 1) == (kind == "coarse bins")
    span = float(values[-1] - values[0])
    asked = rng.uniform(values[0] - 0.1 * span, values[-1] + 0.1 * span, 20_000)
    asked = np.concatenate([asked, values, values[0] + span * rng.random(500) ** 12])
    below, share = (np.array(made) for made in axis.place(mi.Float(asked.astype(np.float32)), True))
    expected, expected_share = place_on(
        values.astype(float), asked.astype(np.float32).astype(float)
    )
    # At a grid line either neighbour will do: what counts is the place.
    assert np.allclose(below + share, expected + expected_share, atol=2e-3)
    assert below.max() <= len(values) - 2


def test_photometric_transport_weighs_the_bands_by_light_and_eye():
    nm = np.array([400.0, 480.0, 560.0, 640.0, 720.0])
    shares = np.array([0.1, 0.3, 0.8, 0.4, 0.2])
    table = resample(lambda wi, wo: lambert(1.0)(wi, wo) * shares, nm, tolerance=0.005)
    from lumenray.engine.photometry.spectra import GRID, illuminant, luminous_efficiency

    light = illuminant(GRID, "A")
    backend.start(spectral=False)
    import mitsuba as mi

    bsdf = plugin(Measured(table, table), light)
    weight = light * luminous_efficiency()
    expected = (np.interp(GRID, nm, shares) * weight).sum() / weight.sum()
    up = vectors(towards(0)[None])
    made = np.array(bsdf.eval(mi.BSDFContext(), interaction(towards(20), 1), up, True))
    assert made.ravel()[0] == pytest.approx(expected / np.pi, rel=2e-3)


def test_without_data_for_a_side_it_is_black():
    bsdf = plugin(Measured(paint()))
    assert sampled(bsdf, towards(40), 1000)[1].any()
    assert not sampled(bsdf, towards(140), 1000)[1].any()


ANALYTIC = {
    "matt": (lambert(0.6), {"type": "diffuse", "reflectance": {"type": "uniform", "value": 0.6}}),
    "metal": (
        # Mitsuba takes masking and shadowing for independent.
        ggx(0.3, is_joint=False),
        {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": 0.3},
    ),
}


@pytest.mark.parametrize("name", ANALYTIC)
@pytest.mark.slow
def test_pictures_are_those_of_the_analytic_model(name):
    # A ball on a floor of the same stuff, a lamp and a grey sky; both by Mitsuba's own path tracer.
    backend.start(spectral=False)
    import mitsuba as mi

    exact, analytic = ANALYTIC[name]
    table = resample(exact, [550.0], tolerance=0.01)
    measured = plugin(Measured(table, table))
    pictures = []
    for bsdf in (measured, mi.load_dict({"type": "twosided", "nested": analytic})):
        pictures.append([_picture(bsdf, seed) for seed in range(8)])
    ours, theirs = (np.stack(p) for p in pictures)
    mean = theirs.mean(axis=0)
    noise = np.sqrt((ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / 8)
    allowed = 4.5 * noise + max(table.error, 0.002) * 3.0 * mean + 1e-4
    assert (np.abs(ours.mean(axis=0) - mean) < allowed).all()
    assert ours.mean() == pytest.approx(mean.mean(), rel=0.004)


@pytest.mark.slow
def test_pictures_by_an_rgl_file_are_those_of_mitsubas_own_reader(tmp_path):
    import mitsuba as mi

    from lumenray.engine.scattering.readers.reader import Wish, read_scattering
    from lumenray.engine.scattering.readers.tensor_file import write_tensor_file

    lobe, nm = ggx(0.3, schlick), np.array([420.0, 500.0, 580.0, 660.0])
    shares = np.array([0.2, 0.3, 0.6, 0.7])
    path = tmp_path / "paint.bsdf"
    angles = np.radians([0, 10, 20, 30, 40, 50, 60, 70, 78, 84, 88.0])
    write_tensor_file(path, lambda wi, wo: lobe(wi, wo) + shares / np.pi, angles, nm, 32)
    table = read_scattering(path, Wish(0.03)).sides["front_reflection"]
    theirs = mi.load_dict(
        {"type": "twosided", "nested": {"type": "measured", "filename": str(path)}}
    )
    ours = plugin(Measured(table, table))
    a, b = (np.stack([_picture(bsdf, seed) for seed in range(6)]) for bsdf in (ours, theirs))
    mean = b.mean(axis=0)
    noise = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / 6) / mean
    apart = a.mean(axis=0) / mean - 1.0
    assert np.sqrt(max((apart**2).mean() - (noise**2).mean(), 0.0)) < table.error
    assert abs(a.mean() / b.mean() - 1.0) < 0.5 * table.error


def _picture(bsdf, seed):
    """Means of 8 x 8 blocks of a picture of 48 x 48 pixels."""
    import mitsuba as mi

    scene = mi.load_dict(
        {
            "type": "scene",
            "sky": {"type": "constant", "radiance": 0.3},
            "lamp": {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f().look_at([2, -2, 3], [0, 0, 0], [0, 0, 1]),
                "emitter": {"type": "area", "radiance": 6.0},
            },
            "ball": {"type": "sphere", "bsdf": bsdf},
            "floor": {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f().translate([0, 0, -1]).scale(4.0),
                "bsdf": bsdf,
            },
            "sensor": {
                "type": "perspective",
                "fov": 40.0,
                "to_world": mi.ScalarTransform4f().look_at([0, -6, 1.5], [0, 0, 0], [0, 0, 1]),
                "film": {"type": "hdrfilm", "width": 48, "height": 48, "rfilter": {"type": "box"}},
            },
            "integrator": {"type": "path", "max_depth": 4},
        }
    )
    picture = np.array(mi.render(scene, spp=64, seed=seed)).mean(axis=2)
    return picture.reshape(6, 8, 6, 8).mean(axis=(1, 3))


@pytest.mark.slow
def test_brushed_metal_follows_u():
    """Light across the brushing spreads along it: the direction comes from the coordinates of the mesh."""
    rotations = np.arange(8) * np.pi / 4
    table = resample(
        ggx(0.1, along=0.5),
        [550.0],
        rotations=rotations,
        is_symmetric=False,
        tolerance=0.3,
        most=1 << 18,
    )
    assert isinstance(table, ScatterTable)
    along = albedo(table, np.radians(30), 0.0)
    bsdf = plugin(Measured(table, table))
    wo, weight, _, _ = sampled(bsdf, towards(0.5), 1 << 16)
    spread = np.sqrt(np.average(wo**2, axis=0, weights=weight[0]))
    assert spread[0] > 2.5 * spread[1]
    assert along > 0.5


def test_tables_that_end_early_are_sampled_where_their_last_values_hold():
    """Radial angles up to 60 degrees, incidences from 20 to 45: beyond, the ends hold, and nothing is lost."""
    table = resample(lambert(0.5), [550.0], incidences=np.radians([20.0, 45.0]))
    kept = table.radials < np.radians(61.0)
    short = replace(table, radials=table.radials[kept], values=table.values[:, :, kept])
    bsdf = plugin(Measured(short, short))
    for angle in (2, 30, 60, 85):
        _, weight, _, _ = sampled(bsdf, towards(angle), 1 << 16)
        error = weight[0].std() / np.sqrt(weight.shape[1])
        assert abs(weight[0].mean() - 0.5) < 4.5 * error + 1e-4


def test_what_passes_to_an_eye_comes_from_the_other_side():
    """A sheet that lets light from its front through: an eye behind sees it, one in front nothing."""
    import mitsuba as mi

    through = resample(lambert(0.4), [550.0])
    bsdf = plugin(Measured(front_transmission=through))
    context = mi.BSDFContext()
    for eye, expected in ((150, 0.4 / np.pi), (30, 0.0)):
        light = vectors(towards(180 - eye)[None])
        value = np.array(bsdf.eval(context, interaction(towards(eye), 1), light, True))[0, 0]
        assert value == pytest.approx(expected * np.cos(np.radians(30)), rel=1e-4, abs=1e-9)


def test_the_reflectance_of_exitance_maps_has_the_colour_of_the_data():
    nm = np.array([450.0, 550.0, 650.0])
    shares = np.array([0.05, 0.08, 0.6])
    table = resample(lambda wi, wo: lambert(1.0)(wi, wo) * shares, nm)
    made = plugin(Measured(table, table)).eval_diffuse_reflectance(interaction(towards(10), 1))
    assert np.array(made).ravel() == pytest.approx(np.interp(NM, nm, shares), rel=0.02)


def test_another_kind_of_data_for_a_surface_that_is_there_counts_in_full():
    """From a mirror to a matt table by an edit: what next-event estimation asks must not be that of the mirror."""
    from small_scenes import quad, session_of

    from lumenray.engine.accuracy.stopping import StopRule
    from lumenray.engine.scene.light import Output, PointLight, Quantity
    from lumenray.engine.scene.material import Material
    from lumenray.engine.scene.scene import SceneDelta

    matt = resample(lambert(0.5), [550.0])
    mirror = replace(
        matt, values=0 * matt.values, direct=np.full((1, len(matt.incidences), 1), 0.9, np.float32)
    )
    lamp = PointLight(
        "lamp", "Lamp", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([0, 0, 1.0]), 0.0
    )
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "m")
    place, down = np.array([[0.3, 0.0, 0.5]]), np.array([[0.0, 0.0, -1.0]])
    session = session_of(Material("m", "M", Measured(mirror, mirror)), floor, lamp)
    session.measure(place, down, StopRule(samples=64))
    session.apply(SceneDelta((Material("m", "M", Measured(matt, matt)),)))
    edited = session.measure(place, down, StopRule(samples=4096))
    # The lamp lights the floor, and each cell of the floor lights the place.
    steps = (np.arange(400) + 0.5) / 200.0 - 1.0
    x, y = np.meshgrid(steps, steps)
    exitance = 0.5 * 1000.0 / (4.0 * np.pi) / (x**2 + y**2 + 1.0) ** 1.5
    away = (x - 0.3) ** 2 + y**2 + 0.25
    expected = (exitance / np.pi * 0.25 / away**2).sum() / 200.0**2
    assert abs(edited.illuminance[0] - expected) < 4.5 * edited.standard_error[0] + 2e-3 * expected
    assert edited.standard_error[0] < 0.03 * expected
