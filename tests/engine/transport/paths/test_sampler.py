"""Sample points and wavelengths have the distributions that unbiased estimates need."""

import numpy as np
import pytest

from lumenray.engine.photometry.spectra import GRID, illuminant, luminous_efficiency
from lumenray.engine.photometry.units import LUMINOUS_EFFICACY
from lumenray.engine.transport import backend


@pytest.fixture(autouse=True)
def _spectral():
    backend.start(spectral=True)


def points(count, seed, pair):
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.paths.sampler import sobol_pair

    made = sobol_pair(dr.arange(mi.UInt32, count), mi.UInt32(seed), pair)
    return np.stack([np.array(made.x), np.array(made.y)], axis=1)


@pytest.mark.parametrize("pair", [0, 3, 5])
def test_scrambled_pairs_are_nets_in_every_elementary_interval(pair):
    # A (0, 8, 2)-net: each of the 256 dyadic boxes of every shape holds exactly one of 256 points.
    made = points(256, 77, pair)
    for k in range(9):
        count = np.histogram2d(*made.T, bins=[2**k, 2 ** (8 - k)], range=[[0, 1], [0, 1]])[0]
        assert (count == 1).all()


def test_different_pairs_and_seeds_are_uncorrelated():
    a, b, c = points(4096, 1, 0), points(4096, 1, 1), points(4096, 2, 0)
    for other in (b, c):
        for i in range(2):
            for j in range(2):
                assert abs(np.corrcoef(a[:, i], other[:, j])[0, 1]) < 0.06


def test_wavelength_weights_reproduce_a_photometric_integral():
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.paths.wavelengths import WavelengthSampler

    lamp = illuminant(GRID, "FL11")
    expected = LUMINOUS_EFFICACY * (lamp * luminous_efficiency()).sum()
    for steering in (lamp, illuminant(GRID, "A")):
        sampler = WavelengthSampler(steering, "luminance")
        u = (dr.arange(mi.Float, 1 << 16) + 0.5) / (1 << 16)
        wavelengths = sampler.sample(u)
        table = mi.Float(lamp.astype(np.float32))
        cell = mi.UInt32(dr.clip(wavelengths[0] - 359.5, 0, 470))
        value = mi.Spectrum(0.0)
        for k in range(4):
            cell = mi.UInt32(dr.clip(wavelengths[k] - 359.5, 0, 470))
            value[k] = dr.gather(mi.Float, table, cell)
        made = np.array(sampler.luminance(value, wavelengths)).mean()
        assert made == pytest.approx(expected, rel=2e-3)


def test_the_lamps_own_spectrum_makes_photometric_weights_constant():
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.paths.wavelengths import WavelengthSampler

    flat = np.ones(len(GRID))
    sampler = WavelengthSampler(flat, "luminance")
    u = (dr.arange(mi.Float, 4096) + 0.5) / 4096
    made = np.array(sampler.luminance(mi.Spectrum(1.0), sampler.sample(u)))
    assert made.std() < 0.02 * made.mean()


def test_learned_choice_of_lights_does_not_change_the_mean():
    from small_scenes import box, paint, session_of

    from lumenray.engine.accuracy.stopping import StopRule
    from lumenray.engine.scene.light import Output, PointLight, Quantity
    from lumenray.engine.transport.compiled import lights

    items = [box(4, 4, 3), paint(0.6)]
    for i, place in enumerate(np.random.default_rng(0).random((40, 3)) * 2.5 + 0.2):
        output = Output(Quantity.LUMINOUS_FLUX, 10.0 * (1 + i % 7) ** 2)
        items.append(PointLight(f"l{i}", f"l{i}", output, place))
    rule = StopRule(samples=1 << 14)
    sensors = [[1, 1, 0], [3, 2, 0]], [[0, 0, 1]] * 2
    many = session_of(*items).measure(*sensors, rule)
    few = [
        session_of(*items[:2], *items[i : i + 10]).measure(*sensors, rule) for i in (2, 12, 22, 32)
    ]
    assert len(items) - 2 > lights.LOCAL_LIMIT > 10, "both ways of choosing must be compared"
    total = sum(m.illuminance for m in few)
    error = np.sqrt(many.standard_error**2 + sum(m.standard_error**2 for m in few))
    assert (np.abs(many.illuminance - total) < 3.5 * error).all()


@pytest.mark.parametrize("seed", range(6))
def test_numbers_of_rays_and_of_their_walks_are_independent(seed):
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.light_tracing.all_lights import DRAWING
    from lumenray.engine.transport.paths.sampler import launch_stream
    from lumenray.engine.transport.witness.pilot import WALKING

    count, bins = 1 << 17, 8
    lane = dr.arange(mi.UInt32, count)
    rows = []
    for purpose in (DRAWING, WALKING):
        stream = launch_stream(lane, 2, seed, purpose)
        rows.append([np.array(stream.next_float32()) for _ in range(3)])
    expected = count / bins**2
    for first in rows[0]:
        for second in rows[1]:
            found = np.histogram2d(first, second, bins=bins, range=[[0, 1], [0, 1]])[0]
            chi = ((found - expected) ** 2 / expected).sum()
            # 63 degrees of freedom: 1e-5 of trials are above 127.
            assert chi < 127.0
