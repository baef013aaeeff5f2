"""The skies of Preetham and of Hosek and Wilkie: what their papers print, and another implementation's."""

import numpy as np
import pytest

from lumenray.engine.sky.atmosphere import hosek_wilkie, preetham
from lumenray.engine.sky.atmosphere.directions import onto_sphere, towards

ZENITH = np.array([[0.0, 0.0, 1.0]])


@pytest.mark.parametrize("turbidity", [2.0, 4.0, 8.0])
@pytest.mark.parametrize("elevation", [0.2, 0.8, 1.3])
def test_the_zenith_has_the_luminance_and_chromaticity_of_the_paper(elevation, turbidity):
    """Appendix A.2 of Preetham and others, 1999, with its thousands of cd/m2."""
    sun = 0.5 * np.pi - elevation
    angle = (4.0 / 9.0 - turbidity / 120.0) * (np.pi - 2.0 * sun)
    level = (4.0453 * turbidity - 4.9710) * np.tan(angle) - 0.2155 * turbidity + 2.4192
    squared, once, none = (
        0.00166 * sun**3 - 0.00375 * sun**2 + 0.00209 * sun,
        -0.02903 * sun**3 + 0.06377 * sun**2 - 0.03202 * sun + 0.00394,
        0.11693 * sun**3 - 0.21196 * sun**2 + 0.06052 * sun + 0.25886,
    )
    x = squared * turbidity**2 + once * turbidity + none
    made = preetham.find_light(ZENITH, towards(elevation, 0.4), turbidity)[0]
    assert made[1] == pytest.approx(0.06 * level, rel=1e-9)
    assert made[0] / made.sum() == pytest.approx(x, rel=1e-9)


def test_below_the_horizon_it_is_as_at_the_horizon_but_for_the_angle_to_the_sun():
    sun = towards(0.5, 0.0)
    low = np.stack([towards(-0.7, 0.5 * np.pi), towards(-1.2, 0.5 * np.pi)])
    for find in (
        lambda d: preetham.find_light(d, sun, 3.0),
        lambda d: hosek_wilkie.find_light(d, sun, 3.0, 0.3),
    ):
        assert np.all(np.isfinite(find(low)))
        assert np.all(find(low) > 0.0)


@pytest.mark.mitsuba
@pytest.mark.parametrize(("elevation", "turbidity", "albedo"), [(0.6, 3.0, 0.0), (0.15, 5.5, 0.4)])
def test_luminances_are_those_of_mitsubas_sky(elevation, turbidity, albedo):
    """Its spectra come of another fit to the same atmospheres, which ends at 720 nm."""
    from lumenray.engine.transport import backend

    backend.start("llvm_ad_spectral")
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.photometry.spectra import GRID, luminous_efficiency

    sun = towards(elevation, 0.0)
    generator = np.random.default_rng(3)
    directions = generator.normal(size=(300, 3))
    directions[:, 2] = np.abs(directions[:, 2]) + 0.1
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    away = directions @ sun < np.cos(0.2)
    directions = directions[away]
    emitter = mi.load_dict(
        {
            "type": "sunsky",
            "sun_direction": [float(x) for x in sun],
            "turbidity": turbidity,
            "albedo": {"type": "uniform", "value": albedo},
            "sun_scale": 0.0,
        }
    )
    si = dr.zeros(mi.SurfaceInteraction3f, len(directions))
    si.wi = mi.Vector3f(*(-directions.T))
    theirs = np.zeros(len(directions))
    step = 10
    for nm in range(360, 721, step):
        si.wavelengths = mi.UnpolarizedSpectrum(float(nm))
        value = np.array(emitter.eval(si))[0]
        theirs += value * luminous_efficiency()[int(nm - GRID[0])] * step
    ours = hosek_wilkie.find_light(directions, sun, turbidity, albedo)[:, 1] / hosek_wilkie.LEVEL
    ratio = ours / theirs / np.median(ours / theirs)
    assert np.percentile(np.abs(ratio - 1.0), 95) < 0.05


def test_turbidities_and_suns_beyond_the_table_are_taken_at_its_ends():
    above = onto_sphere(np.array([(0.3, 0.2, 0.5), (0.0, 0.5, 0.9)]))
    sun = towards(0.5, 0.0)
    np.testing.assert_allclose(
        hosek_wilkie.find_light(above, sun, 1.0, 0.3), hosek_wilkie.find_light(above, sun, 0.2, 0.3)
    )
    whole = hosek_wilkie.find_light(above, sun, 10.0, 0.3)
    np.testing.assert_allclose(whole, hosek_wilkie.find_light(above, sun, 9.999999, 0.3), rtol=1e-5)
    assert np.all(np.isfinite(hosek_wilkie.find_light(above, towards(-0.2, 0.0), 3.0, 0.3)))
