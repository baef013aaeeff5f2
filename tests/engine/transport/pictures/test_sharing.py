"""Light that pixels share, on made-up light whose true values are known, and in small rooms."""

import numpy as np
import pytest
from small_pictures import ROOMS, look_in
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.transport.pictures.allocation import TILE
from lumenray.engine.transport.pictures.pixel_light import DIRECT, GATHERED, VIEW
from lumenray.engine.transport.pictures.sharing import (
    SHIFTS,
    SIDES,
    Parts,
    PixelSharing,
    Tiles,
    Tiling,
    weigh_tilings,
)
from lumenray.engine.views import ViewSettings

WIDTH, HEIGHT = 161, 118
"""No multiples of a tile."""

Z = 4.0


def sharing_of(reflectance, surface, colour=None):
    """Sharing of a picture whose pixels show matt surfaces. (h, w) each; ``surface``: numbers 0 and 1."""
    stages = []
    for side in SIDES:
        tilings = []
        for shift, weight in zip(SHIFTS, weigh_tilings(WIDTH, HEIGHT, side), strict=True):
            tiles = Tiles(WIDTH, HEIGHT, int(shift * side), side)
            inside = tiles.pixels >= 0
            amounts = np.zeros((*tiles.pixels.shape, 3), dtype=np.float32)
            for number in (0, 1):
                part = (reflectance * (surface == number)).ravel()[np.maximum(tiles.pixels, 0)]
                amounts[..., number] = part * inside
            nothing = Parts(0.0 * amounts, 0 * inside > 0)
            tilings.append(Tiling(tiles, Parts(amounts, inside), nothing, weight))
        stages.append(tilings)
    return PixelSharing(stages, [0, 1, 2], colour)


def lights():
    """True light, reflectance and surfaces of pictures (h, w), by what is in them."""
    y, x = np.mgrid[:HEIGHT, :WIDTH] / HEIGHT
    plain = np.ones((HEIGHT, WIDTH))
    halves = (x + 0.3 * y > 0.8).astype(int)
    texture = 0.5 + 0.3 * np.sin(40.0 * x) * np.cos(57.0 * y)
    return {
        "slope": (1.0 + x + 0.5 * y, plain, 0 * halves),
        "texture": ((1.0 + x) * texture, texture, 0 * halves),
        "two surfaces": (np.where(halves, 3.0 - x, 1.0 + y), plain, halves),
        "edge of a shadow": (np.where(halves, 1.0, 0.2), plain, 0 * halves),
        "ripples": (1.0 + 0.05 * np.sin(60.0 * x), plain, 0 * halves),
    }


def grille():
    """As of `lights`: all that a plane misses is in waves of two to three pixels."""
    true = 1.0 + 0.1 * np.sign(np.sin(300.0 * np.mgrid[:HEIGHT, :WIDTH][1] / HEIGHT))
    return true, np.ones_like(true), np.zeros_like(true, dtype=int)


def make_halves(true, reflectance, surface, noise, seed):
    """Means of halves with such a relative noise, their sharing, and what it changes of them. (2, n, 3)"""
    draw = np.random.default_rng(seed)
    halves = true.ravel()[None, :, None] * np.ones((2, 1, 3))
    sigma = noise * true.ravel()
    halves = halves + draw.normal(size=(2, halves.shape[1], 1)) * sigma[None, :, None]
    own = sharing_of(reflectance, surface)
    means = {GATHERED: halves.astype(np.float32)}
    return halves, own, own.share(means, {GATHERED: np.stack([sigma**2] * 2)}).change


def share(true, reflectance, surface, noise, seed):
    """True relative square of the error of a shared picture, the stated one, and their parts by pixel. (n,) each"""
    halves, own, change = make_halves(true, reflectance, surface, noise, seed)
    shared = halves + change
    smoothed = own.smoothed_away(change, true.ravel())[:, 1]
    stated = ((shared[0] - shared[1])[:, 1] / 2.0) ** 2 + smoothed
    error = (shared.mean(axis=0)[:, 1] - true.ravel()) ** 2
    scale = true.ravel() ** 2
    return error / scale, stated / scale, halves.mean(axis=0)[:, 1], shared.mean(axis=0)[:, 1]


def test_light_without_noise_stays_as_it_is():
    true, reflectance, surface = lights()["edge of a shadow"]
    means = {GATHERED: np.tile(true.ravel()[None, :, None], (2, 1, 3)).astype(np.float32)}
    made = sharing_of(reflectance, surface).share(means, {GATHERED: np.zeros((2, true.size))})
    assert not made.change.any()
    assert (made.left[GATHERED] == 1.0).all()


@pytest.mark.parametrize("name", [*lights(), "grille"])
@pytest.mark.parametrize("noise", [0.02, 0.1, 0.5])
def test_the_stated_error_is_the_true_one_whatever_the_light(name, noise):
    light = (lights() | {"grille": grille()})[name]
    true, stated = zip(*(share(*light, noise, seed)[:2] for seed in range(24)), strict=True)
    ratios = np.mean(stated, axis=1) - np.mean(true, axis=1)
    error = ratios.std(ddof=1) / np.sqrt(len(ratios))
    # A negative sum counts as none, which the mean over pictures shows a little.
    assert abs(ratios.mean()) < Z * error + 0.03 * np.mean(true)


def test_chance_makes_little_of_what_is_smoothed_away_in_long_waves():
    """Much less than it makes of the products of the halves' changes, whose mean is the same."""
    light, noise, drawn, plain = lights()["ripples"], 0.5, [], []
    for seed in range(16):
        _, own, change = make_halves(*light, noise, seed)
        scale = light[0].ravel()
        drawn.append((own.smoothed_away(change, scale)[:, 1] / scale**2).mean())
        plain.append((change[0, :, 1] * change[1, :, 1] / scale**2).mean())
    assert np.std(drawn) < 0.6 * np.std(plain)
    assert abs(np.mean(drawn) - np.mean(plain)) < 0.15 * np.mean(plain) + Z * np.std(plain) / 4.0


@pytest.mark.parametrize("name", ["slope", "texture"])
def test_light_that_is_a_plane_has_the_error_of_all_samples_of_a_tile(name):
    true = np.mean([share(*lights()[name], 0.1, seed)[0].mean() for seed in range(6)])
    # Three numbers of a plane from the pixels of a tile of the first stage; the second one finds them of more.
    assert true < 0.1**2 / 2.0 * 0.6 * 3.0 / TILE**2


@pytest.mark.parametrize("name", lights())
@pytest.mark.parametrize("noise", [0.001, 0.1, 0.5])
def test_shared_light_is_no_worse_than_each_pixels_own(name, noise):
    light = lights()[name]
    true = np.mean([share(*light, noise, seed)[0].mean() for seed in range(6)])
    assert true < 1.02 * noise**2 / 2.0


def test_light_of_one_colour_is_shared_by_its_luminance_alone():
    true, reflectance, surface = lights()["two surfaces"]
    colour = np.array([0.9, 1.0, 1.3], np.float32)
    draw = np.random.default_rng(4)
    noisy = true.ravel() * (1.0 + 0.1 * draw.normal(size=(2, true.size)))
    means = {GATHERED: (noisy[..., None] * colour).astype(np.float32)}
    variances = {GATHERED: np.stack([(0.1 * true.ravel()) ** 2] * 2)}
    each, alone = (
        sharing_of(reflectance, surface, known).share(means, variances).change
        for known in (None, colour)
    )
    np.testing.assert_allclose(alone, each, atol=1e-5)


def test_an_edge_stays_as_soon_as_it_stands_out_of_the_noise():
    true = lights()["edge of a shadow"]
    shared = share(*true, 0.02, 1)[3]
    assert np.abs(shared - true[0].ravel()).max() < 6.0 * 0.02


def quarters_of(values):
    """Sums over the quarters of a picture. (2, 2)"""
    rows = np.add.reduceat(values, [0, HEIGHT // 2], axis=0)
    return np.add.reduceat(rows, [0, WIDTH // 2], axis=1)


def test_no_light_is_lost_over_slopes_that_are_steep_and_noisy():
    """Where light falls by 1/r^4, convex within tiles, and few bright samples make most of it."""
    y, x = np.mgrid[:HEIGHT, :WIDTH] / HEIGHT
    true = 1.0 / (0.05 + (x - 0.2) ** 2 + (y - 0.2) ** 2) ** 2
    reflectance, surface = 0.5 + 0.4 * np.sin(40.0 * x), np.zeros(true.shape, int)
    moved = []
    for seed in range(8):
        draw = np.random.default_rng(seed)
        met = draw.poisson(4.0, (2, true.size)) / 4.0
        halves = (met * (true * reflectance).ravel())[..., None] * np.ones(3)
        variances = halves[..., 1] ** 2 / 4.0
        made = sharing_of(reflectance, surface).share(
            {GATHERED: halves.astype(np.float32)}, {GATHERED: variances}
        )
        change = made.change[..., 1].mean(axis=0).reshape(true.shape)
        assert np.abs(change).mean() > 0.02 * true.mean()
        light = halves[..., 1].mean(axis=0).reshape(true.shape)
        moved.append(quarters_of(change) / quarters_of(light))
        assert abs(change.sum()) < 1e-3 * light.sum()
    assert np.abs(np.mean(moved, axis=0)).max() < 0.002


def test_means_of_blocks_are_kept_and_no_edge_of_a_tile_shows():
    for name in ("slope", "edge of a shadow", "ripples"):
        true, _, own, shared = *lights()[name][:1], *share(*lights()[name], 0.1, 5)[1:]
        before, after = (each.reshape(HEIGHT, WIDTH)[:112, :160] for each in (own, shared))
        blocks = [
            each.reshape(7, 16, 10, 16).mean(axis=(1, 3)) / true[:112, :160].mean()
            for each in (before, after)
        ]
        # Light moves over the edges of blocks by the tiles that lie across them: less than the noise of a block.
        assert np.abs(blocks[1] - blocks[0]).max() < 0.02
    steps = np.abs(np.diff(after / true[:112, :160], axis=1)).mean(axis=0)
    at_edges = np.arange(1, 160) % (TILE // 2) == 0
    assert steps[at_edges].mean() < 1.25 * steps[~at_edges].mean()


def test_a_surface_that_few_pixels_show_keeps_its_light():
    """Its fit is exact but for rounding, so nothing is known of how far it is off."""
    true, reflectance, surface = lights()["slope"]
    surface = surface.copy()
    for count, (y, x) in enumerate([(3, 3), (20, 21), (44, 70), (90, 100)]):
        surface[y, x : x + count + 1] = 1
    before = np.inf
    for noise in (0.2, 0.05):
        error, _, _, shared = share(true, reflectance, surface, noise, 11)
        assert error.mean() < before
        assert error.mean() < 0.6 * noise**2 / 2.0
        assert np.abs(shared - true.ravel()).max() < 6.0 * noise * true.max()
        before = error.mean()


def test_kinds_do_not_mix_and_what_shows_no_matt_surface_keeps_its_own():
    true, reflectance, surface = lights()["slope"]
    own = sharing_of(reflectance, surface)
    draw = np.random.default_rng(3)
    noisy = (true.ravel()[None, :, None] + 0.1 * draw.normal(size=(2, true.size, 3))).astype(
        np.float32
    )
    variance = np.full((2, true.size), 0.01)
    both = own.share(
        {VIEW: noisy, DIRECT: noisy, GATHERED: 2.0 * noisy},
        {VIEW: variance, DIRECT: variance, GATHERED: 4.0 * variance},
    )
    each = [
        own.share({kind: factor * noisy}, {kind: factor**2 * variance}).change
        for kind, factor in ((DIRECT, 1.0), (GATHERED, 2.0))
    ]
    np.testing.assert_allclose(both.change, sum(each), atol=1e-5)
    assert (both.left[VIEW] == 1.0).all()
    assert both.left[GATHERED].mean() < 0.3


@pytest.mark.mitsuba
@pytest.mark.parametrize("room", ["matt", pytest.param("textured floor", marks=pytest.mark.slow)])
@pytest.mark.slow
def test_pictures_that_share_light_are_nearer_to_long_ones(room):
    view = look_in(96, 80)
    made = {}
    for name, samples, seed, shares in (
        ("long", 1024, 9, False),
        ("shared", 16, 1, True),
        ("own", 16, 1, False),
    ):
        settings = ViewSettings(StopRule(samples=samples), seed, method="cells", shares=shares)
        made[name] = session_of(*ROOMS[room]).render(view, settings)
    luminance = {name: each.tristimulus[..., 1].astype(float) for name, each in made.items()}
    long = luminance["long"]
    # Of tiles, as a few pixels at the corners of the lamp make most of the whole error, and have nothing to share.
    true = {name: by_tiles((luminance[name] - long) ** 2) for name in ("shared", "own")}
    assert np.sqrt(np.median(true["shared"] / true["own"])) < 0.6
    stated = by_tiles(made["shared"].luminance_error.astype(float) ** 2)
    assert 0.75 < np.sqrt(np.median(stated / true["shared"])) < 1.5


def by_tiles(values):
    """Means of tiles of a picture (h, w)."""
    height, width = values.shape
    return values.reshape(height // TILE, TILE, width // TILE, TILE).mean(axis=(1, 3))


@pytest.mark.mitsuba
def test_what_sharing_smooths_away_is_told_and_full_paths_share_nothing():
    made = {}
    for method, unbiased in (("cells", False), ("cells", True), ("paths", False)):
        settings = ViewSettings(StopRule(samples=8), 1, method=method, unbiased=unbiased)
        picture = session_of(*ROOMS["matt"]).render(look_in(24, 16), settings)
        made[method, unbiased] = any("pixels share" in note for note in picture.provenance.notes)
    assert made == {("cells", False): True, ("cells", True): False, ("paths", False): False}
