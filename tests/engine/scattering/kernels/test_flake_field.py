"""The field of single flakes: mean and variance in closed form, the same flakes from everywhere, none for lux maps."""

from dataclasses import replace

import numpy as np
import pytest
from device_values import upload, vectors
from scattering_models import lambert

from lumenray.engine.errors import SceneError
from lumenray.engine.scattering.data.flake_field import lay_out
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scattering.data.surface import usable
from lumenray.engine.scene.material import Measured
from lumenray.engine.scene.scattering import Sparkle
from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba

LANES = 1 << 14

FLAKES = Sparkle(None, 3.279e9, np.radians(3.0), np.radians(0.3), 0.0, 1.45)
"""The second sample of the reference: 3279 flakes in a square millimetre."""


@pytest.fixture(autouse=True)
def _mono():
    backend.start(spectral=False)


@pytest.fixture(scope="module")
def one_by_one():
    return resample(lambert(0.2), [550.0], incidences=np.radians([0.0, 40.0, 89.0]))


def seen(width, places, normal=(0.0, 0.0, 1.0), eye=(0.0, 0.0, 1.0)):
    """Places (2, n) of a plane where a pixel of the width is seen from a direction. [m]"""
    import drjit as dr
    import mitsuba as mi

    count = places.shape[1]
    normal, eye = (np.array(v) / np.linalg.norm(v) for v in (normal, eye))
    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.n = mi.Normal3f(vectors(np.tile(normal, (count, 1))))
    si.sh_frame = mi.Frame3f(si.n)
    si.p = mi.Point3f(si.sh_frame.s * upload(places[0]) + si.sh_frame.t * upload(places[1]))
    si.wi = si.to_local(vectors(np.tile(eye, (count, 1))))
    si.duv_dx = mi.Vector2f(upload(np.full(count, width)), 0.0)
    # As data, so that all tests share a kernel.
    dr.eval(si)
    return si


def light_for(wi, slope, index):
    """Direction from which flakes of a slope along x mirror light to ``wi``."""

    def inside(w, index):
        level = w[:2] / index
        return np.append(level, np.sqrt(1.0 - level @ level))

    half = np.array([slope, 0.0, 1.0]) / np.hypot(slope, 1.0)
    own = inside(wi, index)
    return inside(2.0 * (own @ half) * half - own, 1.0 / index)


def field(sparkle, si, slope=0.0, number=0):
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.scattering.kernels.flake_field import Eyed, FlakeField

    ways = upload(np.tile(np.vstack([np.eye(3), np.zeros(3)]), (64, 1, 1)).ravel())
    wo = light_for(np.array(si.wi)[:, 0], slope, sparkle.index)
    wo = vectors(np.tile(wo, (dr.width(si), 1)))
    eyed = Eyed(si, ways, mi.Bool(True))
    return np.array(FlakeField(sparkle, number).evaluate(eyed, mi.Vector3f(si.wi), wo))


def scattered(seed, count=LANES):
    return np.random.default_rng(seed).uniform(-0.5, 0.5, (2, count))


@pytest.mark.parametrize(
    "width, slope, log_spread",
    [(1e-4, 0.0, 0.0), (2.5e-4, 0.06, 0.0), (2e-3, 0.0, 0.0), (3e-4, 0.0, 0.5), (4e-3, 0.1, 0.5)],
)
def test_mean_is_one_and_variance_that_of_poissons_law(width, slope, log_spread):
    from lumenray.engine.scattering.kernels.flake_field import PIXEL_RADIUS

    sparkle = replace(FLAKES, log_spread=log_spread)
    found = field(sparkle, seen(width, scattered(1)), slope)
    variance = lay_out(sparkle).variance(slope, PIXEL_RADIUS * width)
    assert found.mean() == pytest.approx(1.0, abs=4.0 * np.sqrt(variance / LANES))
    # Standard error of a sample's variance, by the sample's own fourth moment.
    fourth = ((found - 1.0) ** 4).mean()
    assert found.var() == pytest.approx(variance, abs=4.0 * np.sqrt(fourth / LANES))
    # Where kernels are flat and flakes alike it is the inverse of their number; those here are within a small factor.
    lit = 3.279e9 * np.pi * (PIXEL_RADIUS * width) ** 2 * lay_out(sparkle).chance(slope)
    assert 1.0 < variance * lit < 20.0


@pytest.mark.parametrize(
    "normal, eye", [((1, 1, 1), (1, 1, 1)), ((0.2, 0.9, 0.4), (0.7, 0.6, 0.1)), ((0, 0, -1), (1, 0, -1))]
)  # fmt: skip
def test_slanted_surfaces_and_eyes_see_as_many_flakes_as_there_are(normal, eye):
    from lumenray.engine.scattering.kernels.flake_field import PIXEL_RADIUS

    found = field(FLAKES, seen(1e-4, scattered(2), normal, eye), 0.03)
    cosine = np.dot(normal, eye) / np.linalg.norm(normal) / np.linalg.norm(eye)
    # A pixel covers more of what it looks at aslant.
    variance = lay_out(FLAKES).variance(0.03, PIXEL_RADIUS * 1e-4) * cosine
    assert found.mean() == pytest.approx(1.0, abs=4.0 * np.sqrt(variance / LANES))
    fourth = ((found - 1.0) ** 4).mean()
    assert found.var() == pytest.approx(variance, abs=4.0 * np.sqrt(fourth / LANES))


def test_flakes_stay_where_they_are_as_the_camera_moves():
    line = np.linspace(0.0, 2e-3, 64)
    places = np.stack(np.meshgrid(line, line, indexing="ij")).reshape(2, -1)

    def look(width, eye=(0.0, 0.0, 1.0), number=0):
        return field(FLAKES, seen(width, places, eye=eye), 0.01, number)

    still = look(5e-5)
    assert (still == look(5e-5)).all()
    # Two per cent nearer and a degree aside the same flakes are seen; another kind's have nothing to do with them.
    assert np.corrcoef(still, look(4.9e-5, (0.017, 0.0, 1.0)))[0, 1] > 0.98
    assert abs(np.corrcoef(still, look(5e-5, number=1))[0, 1]) < 0.1
    # From twice as far a pixel shows what is in the four that it covers.
    far = look(1e-4).reshape(64, 64)[1::2, 1::2]
    near = still.reshape(32, 2, 32, 2).mean(axis=(1, 3))
    assert np.corrcoef(far.ravel(), near.ravel())[0, 1] > 0.6


def test_where_no_camera_looks_the_table_counts(one_by_one):
    import mitsuba as mi

    from lumenray.engine.materials import plugins as surface_plugins
    from lumenray.engine.scattering.kernels import plugin as plugins
    from lumenray.engine.transport.compiled.surfaces import bsdf
    from lumenray.engine.transport.compiled.textures import TextureMaker

    surface_plugins.register()
    plugins.register()
    whole = replace(one_by_one, values=2.0 * one_by_one.values)
    plain = Measured(whole, whole)
    flaky = replace(plain, sparkles=(replace(FLAKES, first_order=one_by_one),))
    make = TextureMaker(np.ones(471))
    models = [bsdf(surface, make) for surface in (plain, flaky)]
    models[1].set_coordinates(np.tile(np.vstack([np.eye(3), np.zeros(3)]), (64, 1, 1)))
    values = []
    for width in (0.0, 1e-4):
        si = seen(width, scattered(3, 1 << 12), eye=(0.02, 0.0, 1.0))
        wo = vectors(np.tile([0.0, 0.0, 1.0], (1 << 12, 1)))
        values.append([np.array(m.eval(mi.BSDFContext(), si, wo))[0] for m in models])
    (table, unseen), (_, close) = values
    assert (unseen == table).all()
    # Half of the light is that of single flakes, so no place is darker than half.
    assert close.min() == pytest.approx(0.5 * table.min(), rel=2e-3)
    assert close.mean() == pytest.approx(table.mean(), rel=0.1)
    assert close.std() > 0.3 * table.mean()


def test_flakes_that_are_no_part_of_the_surface_are_refused(one_by_one):
    surface = Measured(one_by_one, one_by_one)
    other = resample(lambert(0.2), [650.0], incidences=np.radians([0.0, 40.0, 89.0]))
    for sparkle, text in (
        (replace(FLAKES, first_order=other), "other axes"),
        (replace(FLAKES, first_order=one_by_one, density=0.0), "density 0, expected"),
        (replace(FLAKES, first_order=one_by_one, slope=np.nan), "slope nan"),
    ):
        with pytest.raises(SceneError, match=text):
            usable(replace(surface, sparkles=(sparkle,)))
