"""Metals reflect what Mitsuba's own files of them say, and all rough ones are one model."""

import numpy as np
import pytest

from lumenray.engine.scene.material import Conductor, Glossy
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba

COUNT = 64


@pytest.fixture(autouse=True)
def _spectral():
    backend.start(spectral=True)


def plugin(surface):
    import mitsuba as mi

    from lumenray.engine.materials import plugins
    from lumenray.engine.transport.compiled.surfaces import bsdf
    from lumenray.engine.transport.compiled.textures import TextureMaker

    plugins.register()
    return mi.load_dict(bsdf(surface, TextureMaker(np.ones(471))), optimize=False)


def looked_at():
    """Places in many wavelengths, seen from the side."""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.arrays import upload

    si = dr.zeros(mi.SurfaceInteraction3f, COUNT)
    si.wi = mi.Vector3f(0.8, 0.0, 0.6)
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    rng = np.random.default_rng(0)
    for k in range(len(si.wavelengths)):
        si.wavelengths[k] = upload(mi.Float, rng.random(COUNT) * 470.0 + 360.0)
    return si


@pytest.mark.parametrize("metal", ["Cr", "Cu", "Au", "Ag", "Al"])
def test_a_metal_is_that_of_its_file(metal):
    import mitsuba as mi

    si, context = looked_at(), mi.BSDFContext()
    wo = mi.Vector3f(-si.wi.x, si.wi.y, si.wi.z)
    # So smooth that next to no light comes by more than one facet.
    own = plugin(Conductor(metal, 0.2))
    known = mi.load_dict(
        {"type": "roughconductor", "material": metal, "alpha": 0.04, "distribution": "ggx"}
    )
    found = np.array(own.eval(context, si, wo))
    assert found.min() > 0.0
    # Between nanometres a file may bend where the table is straight.
    np.testing.assert_allclose(found, np.array(known.eval(context, si, wo)), rtol=2e-3)


def test_a_perfect_mirror_reflects_all_of_its_colour():
    import mitsuba as mi

    si = looked_at()
    sample = mi.Point2f(0.3, 0.6)
    for colour in (0.0, 0.37, 1.0):
        weight = plugin(Glossy(Constant(colour), 0.0)).sample(
            mi.BSDFContext(), si, mi.Float(0.5), sample, True
        )[1]
        np.testing.assert_allclose(np.array(weight), colour, rtol=1e-6)


def test_all_rough_metals_are_one_model():
    import drjit as dr
    import mitsuba as mi

    surfaces = (
        Conductor("Cr", 0.4),
        Conductor("Au", 0.1),
        Glossy(Constant(0.8), 0.3),
        Glossy(Rgb(0.8, 0.4, 0.2), 0.5),
        Glossy(Constant(1.0), 0.5),
        Glossy(Rgb(0.8, 0.4, 0.2), 0.5, Constant(1.0)),
        Glossy(Constant(0.8), 0.5, Rgb(0.8, 0.4, 0.2)),
    )
    models = []
    for surface in surfaces:
        si, model = looked_at(), plugin(surface)
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            dr.eval(model.eval(mi.BSDFContext(), si, mi.Vector3f(-si.wi.x, si.wi.y, si.wi.z)))
            models.append([entry["hash"] for entry in dr.kernel_history() if "hash" in entry])
    assert models[0]
    assert all(model == models[0] for model in models)


@pytest.mark.parametrize("tint", [1.0, 0.4])
def test_the_edge_of_a_metal_is_schlicks_times_its_tint(tint):
    import mitsuba as mi

    surface = Glossy(Constant(0.3), 0.04, Constant(tint))
    for degrees in (0.0, 30.0, 60.0, 81.7868):
        angle = np.radians(degrees)
        si = looked_at()
        si.wi = mi.Vector3f(float(np.sin(angle)), 0.0, float(np.cos(angle)))
        sample = mi.Point2f(0.3, 0.6)
        bs, weight = plugin(surface).sample(mi.BSDFContext(), si, mi.Float(0.5), sample, True)
        # Facets lie a little aslant.
        cosine = np.sqrt(0.5 * (1.0 + np.array(bs.wo)[:, 0] @ np.array(si.wi)[:, 0]))
        seen = 0.3 + 0.7 * (1.0 - cosine) ** 5
        grazing = 0.3 + 0.7 * (6.0 / 7.0) ** 5
        bent = cosine * (1.0 - cosine) ** 6 / ((1.0 / 7.0) * (6.0 / 7.0) ** 6)
        seen -= grazing * (1.0 - tint) * bent
        np.testing.assert_allclose(np.array(weight)[0], seen, rtol=0.02)


def test_an_ideal_mirror_says_that_it_has_no_edge():
    from lumenray.engine.transport.compiled.surfaces import approximations

    assert "from all sides" in approximations(Glossy(Constant(0.5), 0.0, Constant(1.0)))[0]
    assert approximations(Glossy(Constant(0.5), 0.0)) == []
    assert approximations(Glossy(Constant(0.5), 0.3, Constant(1.0))) == []
