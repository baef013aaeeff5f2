"""What generated rays count for by direction, and what thinned and blurred sets state of themselves."""

import drjit as dr
import numpy as np
import pytest

from lumenray.benchmarks.common.ray_sources import disk, even_numbers, numbers, sphere
from lumenray.engine.raysets.blur import find_blur
from lumenray.engine.raysets.body import find_body
from lumenray.engine.raysets.cloud import Fluctuation, make_cloud, order_rays, thin_rays
from lumenray.engine.raysets.direction_weight import fit_weight
from lumenray.engine.raysets.record import Rays
from lumenray.engine.raysets.symmetry import find_axis
from lumenray.engine.scene.ray_emission import BANDS, DirectionWeight

UP = np.array([0.0, 0.0, 1.0])


def lambert(count, seed):
    return disk(numbers(count, seed))[1].astype(np.float64)


def bands_of(direction, flux=None, count=12):
    """Light in bands about the axis that would have as much each, over the mean."""
    return np.histogram(direction[:, 2] ** 2, count, (0.0, 1.0), weights=flux)[0] / (
        (len(direction) if flux is None else flux.sum()) / count
    )


def ones(direction):
    return np.ones(len(direction), np.float32)


def test_light_that_was_moved_comes_back():
    """A tenth is missing within ten degrees of the horizon, and lies beside."""
    rng = np.random.default_rng(1)
    made, asked = lambert(1 << 19, 2), lambert(1 << 18, 3)
    low = (made[:, 2] < np.sin(np.deg2rad(10.0))) & (rng.random(len(made)) < 0.3)
    made[low, 2] += 0.2
    made /= np.linalg.norm(made, axis=1, keepdims=True)
    before = np.abs(bands_of(made) - 1.0).max()
    after = np.abs(bands_of(made, fit_weight(made, asked, ones(asked), UP).of(made)) - 1.0).max()
    assert before > 0.07
    assert after < 0.02


def test_the_chance_of_few_rays_is_not_followed():
    """Directions of one law: 1000 rays scatter by 0.3 in each of the bands; their weight differs from 1 by much less."""
    made, square = lambert(1 << 16, 4), 0.0
    for seed in range(20):
        asked = lambert(1000, 10 + seed)
        found = fit_weight(made, asked, ones(asked), UP)
        bands = np.interp(found.place(made), np.arange(BANDS + 1), found.bands)
        square += ((bands - 1.0) ** 2).mean() / 20
    assert np.sqrt(square) < 0.05


def test_the_moments_are_those_of_the_rays():
    made, asked = lambert(1 << 16, 5), lambert(4000, 6)
    flux = (1.0 + 0.6 * asked[:, 0]).astype(np.float32)
    weight = fit_weight(made, asked, flux)
    of = weight.of(made)
    assert of.mean() == pytest.approx(1.0, abs=1e-12)
    expected = flux.astype(float) / flux.sum(dtype=float)
    np.testing.assert_allclose(of @ made / len(made), expected @ asked, atol=1e-3)
    np.testing.assert_allclose(of @ made**2 / len(made), expected @ asked**2, atol=1e-3)
    assert abs(expected @ asked[:, 0]) > 0.1


@pytest.mark.parametrize("angle", [1e-3, 0.05, 1.5])
@pytest.mark.mitsuba
def test_kernels_weigh_as_the_host_does(angle, transport):
    """Of beams of any width: directions next to the axis are told apart in single precision."""
    import mitsuba as mi

    from lumenray.engine.transport import backend
    from lumenray.engine.transport.light_tracing.ray_weight import RayWeight

    backend.start(transport == "spectral")
    rng = np.random.default_rng(7)
    axis = np.array([0.6, 0.0, 0.8])
    across = np.linalg.svd(axis[None])[2][1:]
    turn, off = rng.uniform(0, 2 * np.pi, 1000), angle * rng.random(1000)
    aside = np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1]
    direction = np.cos(off)[:, None] * axis + np.sin(off)[:, None] * aside
    middle = np.tan(0.25 * angle) ** 2
    other = DirectionWeight.even()
    own = DirectionWeight(
        axis, middle, rng.uniform(0.5, 2.0, BANDS + 1), 0.1 * rng.standard_normal(9), 1.3
    )
    weigh = RayWeight([other, own]).of_set(mi.UInt32(1), True)
    found = np.array(weigh(mi.Vector3f(direction.T.astype(np.float32))))
    # Sixteen millionths of the way in single precision, over bands that differ by up to four times.
    np.testing.assert_allclose(found, own.of(direction), rtol=1e-5 / angle + 1e-5)
    assert dr.width(weigh(mi.Vector3f(0.0, 0.0, 1.0))) == 1


def test_light_near_the_horizon_of_a_flat_source_is_right():
    """Fluctuation alone takes a tenth of the light away there."""
    position, direction = disk(even_numbers(1 << 15, 1))
    cloud = make_cloud(Rays(position, direction, ones(direction)), 1.0)
    drawn = cloud.draw(1 << 20, np.random.default_rng(1))
    plain = cloud.generate(1 << 20, np.random.default_rng(1))[2]
    assert bands_of(plain)[0] < 0.93
    np.testing.assert_allclose(bands_of(drawn.direction, drawn.flux), 1.0, atol=0.025)


def test_every_second_ray_of_an_even_sequence_does_not_hide_an_axis():
    """Each half of Sobol's points lies on one side, so rays must not be asked in steps."""
    position, direction = disk(even_numbers(1 << 18, 1))
    rays = Rays(position, direction, ones(direction))
    assert find_axis(rays, find_body(position, direction)) is not None


def test_thinned_rays_carry_all_light_and_little_of_its_error():
    position, direction = sphere(numbers(1 << 15, 1))
    weight = np.random.default_rng(2).exponential(1.0, len(position)).astype(np.float32)
    order = order_rays(position, direction, 0.002)
    rays = Rays(position[order], direction[order], weight[order])
    thin = thin_rays(rays, 1 << 12)
    assert len(thin) <= 1 << 12
    assert thin.weight.sum(dtype=float) == pytest.approx(weight.sum(dtype=float), rel=1e-6)
    # Light by octants: eight neighbours are in one as a rule, whereas 4096 rays by chance scatter by 6 %.
    octant = [(each.direction > 0.0) @ [1, 2, 4] for each in (rays, thin)]
    share = [
        np.bincount(number, each.weight, 8) / each.weight.sum()
        for number, each in zip(octant, (rays, thin), strict=True)
    ]
    np.testing.assert_allclose(share[1], share[0], rtol=0.02)
    fewer = thin_rays(thin, 100)
    assert len(fewer) <= 100
    assert fewer.weight.sum(dtype=float) == pytest.approx(weight.sum(dtype=float), rel=1e-6)


@pytest.mark.slow
def test_a_thinned_set_is_as_good_as_all_of_its_rays():
    """And better than as few by chance: intensities in bands of a sphere, which shines evenly."""
    position, direction = sphere(numbers(1 << 18, 1))

    def error(rays, most=None):
        cloud = make_cloud(rays, 1.0, most=most)
        drawn = cloud.draw(1 << 21, np.random.default_rng(3))
        height = np.histogram(drawn.direction[:, 2], 8, (-1, 1), weights=drawn.flux)[0]
        return np.sqrt(((8.0 * height - 1.0) ** 2).mean()), cloud

    whole, cloud = error(Rays(position, direction, ones(direction)))
    thin, thinned = error(Rays(position, direction, ones(direction)), 1 << 15)
    some = np.random.default_rng(4).permutation(1 << 18)[: 1 << 13]
    few, _ = error(Rays(position[some], direction[some], ones(some)))
    assert len(thinned) <= 1 << 15 < len(cloud)
    assert thin < 0.01
    assert whole < 0.01
    assert few > 1.5 * thin


@pytest.mark.slow
def test_what_fluctuation_blurs_is_stated():
    """Directions that fluctuate by 0.3 rad take light of a disk away from where it goes; a narrow width blurs nothing."""
    position, direction = disk(numbers(1 << 16, 1))
    rays = Rays(position, direction, ones(direction))
    blurs = {}
    for width in (0.02, 0.6):
        cloud = make_cloud(rays, 1.0, Fluctuation(position=0.0, direction=width))
        made = cloud.draw(1 << 20, np.random.default_rng(1))
        exact = bands_of(made.direction, made.flux, 48) - 1.0
        blur = find_blur(made, rays, [cloud.size, 4.0 * cloud.size], 12, 16)
        blurs[width] = blur, float(np.sqrt((exact**2).mean()))
        assert cloud.information_error > 0.9 * blur
    assert blurs[0.02][0] < 0.01
    stated, true = blurs[0.6]
    assert stated > 0.02
    assert 0.3 * true < stated < 3.0 * true
