"""Thin films: closed forms of interference, tables that hold them, and surfaces that answer by the tables."""

import numpy as np
import pytest
from sampled_surfaces import albedo, flux, interaction, plugin
from scattering_models import towards
from scipy.interpolate import RegularGridInterpolator

from lumenray.engine.errors import SceneError
from lumenray.engine.materials.facets import directional_reflectance, fresnel
from lumenray.engine.materials.film import (
    LONGEST,
    facet_shares,
    grid,
    mean_over_hemisphere,
    metal_index,
    reflectance,
)
from lumenray.engine.scene.film import Film
from lumenray.engine.scene.material import Cauchy, Coated, Dielectric, Glossy
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.transport import backend

COSINES = np.linspace(0.02, 1.0, 25)

WAVELENGTHS = (450.0, 550.0, 600.0, 650.0)
"""Of `interaction`. [nm]"""


def layered(thickness, ior, base, cosine, wavelength):
    """Reflectance by products of matrices over both polarisations (Born and Wolf 1.6.4), another way than Airy's sum."""
    squared = 1.0 - cosine**2
    inside, below = (np.sqrt(1.0 - squared / complex(n) ** 2) for n in (ior, base))
    delta = 2.0 * np.pi * ior * thickness * inside / wavelength
    total = 0.0
    for first, film, last in (
        (cosine, ior * inside, base * below),
        (1.0 / cosine, ior / inside, base / below),
    ):
        b = np.cos(delta) - 1j * np.sin(delta) * last / film
        c = last * np.cos(delta) - 1j * film * np.sin(delta)
        total += 0.5 * abs((first * b - c) / (first * b + c)) ** 2
    return total


@pytest.mark.parametrize("base", [1.0, 1.5, 2.4, 0.2 + 3.0j, 1.4 + 7.0j])
@pytest.mark.parametrize("film", [Film(80.0, 1.33), Film(400.0, 2.0), Film(2500.0, 1.6)])
def test_reflectance_is_what_products_of_matrices_give(film, base):
    for wavelength in (380.0, 555.0, 780.0):
        for cosine in (0.05, 0.4, 0.8, 1.0):
            expected = layered(film.thickness, film.ior, base, cosine, wavelength)
            found = reflectance(film, base, cosine, wavelength)
            assert found == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("film", [Film(0.0, 1.8), Film(300.0, 1.0), Film(300.0, 1.5)])
def test_a_film_that_is_no_boundary_leaves_plain_fresnel(film):
    assert reflectance(film, 1.5, COSINES, 550.0) == pytest.approx(fresnel(COSINES, 1.5), abs=1e-12)


def test_a_quarter_of_a_wave_keeps_glass_from_reflecting():
    film, base = 1.38, 1.52
    expected = ((film**2 - base) / (film**2 + base)) ** 2
    assert reflectance(Film(550.0 / 4 / film, film), base, 1.0, 550.0) == pytest.approx(expected)
    assert reflectance(Film(550.0 / 2 / film, film), base, 1.0, 550.0) == pytest.approx(
        fresnel(1.0, base)
    )


def test_a_film_reflects_no_more_than_comes_up_to_grazing_light():
    cosine = np.array([0.0, 1e-9, 1e-5, *COSINES])[:, None]
    wavelengths = np.linspace(360.0, 830.0, 97)
    for film in (Film(500.0, 1.0), Film(500.0, 1.33), Film(5000.0, 2.5)):
        for base in (1.0, 1.0001, 1.5, 0.05 + 4.0j):
            found = reflectance(film, base, cosine, wavelengths)
            assert np.isfinite(found).all()
            assert found.min() >= 0.0
            assert found.max() <= 1.0
            if film.ior > 1.0:
                assert found[0] == pytest.approx(1.0)


def test_a_thick_film_has_the_mean_of_all_phases():
    """The closed form for light without interference, R1 + T1^2 R2 / (1 - R1 R2); by quadrature over one turn."""
    film, just = Film(1e4, 1.8), 0.5 * LONGEST / 1.8
    wavelengths = 2.0 * 1.8 * just / (20.0 + np.arange(256) / 256)
    turn = reflectance(Film(just, 1.8), 1.5, 1.0, wavelengths).mean()
    upper, lower = ((1.8 - 1.0) / 2.8) ** 2, ((1.8 - 1.5) / 3.3) ** 2
    assert reflectance(film, 1.5, 1.0, 550.0) == pytest.approx(turn, rel=1e-6)
    assert turn == pytest.approx(upper + (1.0 - upper) ** 2 * lower / (1.0 - upper * lower))


def test_a_metal_by_its_colours_reflects_them_along_its_normal():
    normal = np.linspace(0.0, 0.99, 12)
    for edge in (0.3, 1.0):
        index = metal_index(normal, np.full(12, edge))
        assert abs((index - 1.0) / (index + 1.0)) ** 2 == pytest.approx(normal, abs=1e-9)


@pytest.mark.parametrize(
    ("film", "base", "most", "mean"),
    [
        (Film(100.0, 1.33), 1.5, 2e-3, 2e-5),
        (Film(1000.0, 2.0), 1.5, 2e-3, 2e-4),
        (Film(5900.0, 1.01), 1.5, 2e-3, 2e-4),
        (Film(2950.0, 2.0), 1.5, 2e-3, 2e-4),
        (Film(2950.0, 2.0), 0.2 + 3.0j, 8e-3, 5e-4),
        (Film(4000.0, 1.33), 0.05 + 4.0j, 8e-3, 5e-4),
    ],
)
def test_tables_hold_every_fringe(film, base, most, mean):
    """Largest error up to 72 degrees, beyond which light goes to and fro many times; mean of all that the sky sends."""
    cosines, wavelengths = grid(film)
    values = reflectance(film, base, cosines[:, None], wavelengths)
    rng = np.random.default_rng(2)
    root, wavelength = rng.random(40_000), rng.uniform(360.0, 830.0, 40_000)
    places = np.stack([root, 1.0 / 360.0 - 1.0 / wavelength], axis=1)
    read = RegularGridInterpolator((np.sqrt(cosines), 1.0 / 360.0 - 1.0 / wavelengths), values)
    error = np.abs(read(places) - reflectance(film, base, root**2, wavelength))
    assert error[root**2 > 0.3].max() < most
    assert (error * 4.0 * root**3).mean() < mean


@pytest.mark.parametrize("alpha", [0.01, 0.3])
def test_facets_under_a_film_that_is_none_reflect_as_facets_without(alpha):
    cosines, _ = grid(Film(0.0, 1.0))
    for eta, bare in ((1.5, fresnel(cosines, 1.5)), (np.inf, np.ones_like(cosines))):
        found = facet_shares(alpha, len(cosines)) @ bare
        assert found == pytest.approx(directional_reflectance(alpha, eta), abs=2e-4)
    # 2 * integral of c^2 and of c.
    assert mean_over_hemisphere(np.stack([cosines, np.ones_like(cosines)], axis=1)) == (
        pytest.approx([2.0 / 3.0, 1.0], rel=1e-4)
    )


@pytest.mark.parametrize(
    ("film", "words"), [(Film(-1.0), "-1 nm"), (Film(np.nan), "nan nm"), (Film(9.0, 0.9), "0.9")]
)
def test_what_is_no_film_is_refused(film, words):
    with pytest.raises(SceneError, match=words):
        film.check()


@pytest.fixture
def spectral():
    backend.start(spectral=True)


FILM = Film(420.0, 1.9)


@pytest.mark.mitsuba
@pytest.mark.usefixtures("spectral")
@pytest.mark.parametrize("angle", [0, 50, 80, 150, 170])
def test_smooth_glass_reflects_and_passes_the_closed_form_both_ways(angle):
    """From inside as from outside on the same way; R + T is all light at each wavelength."""
    import mitsuba as mi

    surface = Dielectric(Cauchy(1.5), film=FILM)
    cosine = abs(np.cos(np.radians(angle)))
    if angle > 90:
        cosine = np.sqrt(1.0 - 1.5**2 * (1.0 - cosine**2))
    expected = reflectance(FILM, 1.5, cosine, np.array(WAVELENGTHS))
    count = 1 << 14
    si = interaction(towards(angle), count)
    choice = (np.arange(count) + 0.5) / count
    bs, weight = plugin(surface).sample(
        mi.BSDFContext(), si, mi.Float(choice.astype(np.float32)), mi.Point2f(0.5), True
    )
    is_mirrored = np.array(bs.wo.z) * np.cos(np.radians(angle)) > 0.0
    light = np.array(weight) * np.array(bs.eta) ** 2
    assert (light * is_mirrored).mean(axis=1) == pytest.approx(expected, abs=2e-3)
    assert (light * ~is_mirrored).mean(axis=1) == pytest.approx(1.0 - expected, abs=2e-3)


@pytest.mark.mitsuba
@pytest.mark.usefixtures("spectral")
@pytest.mark.parametrize("angle", [0, 60])
def test_narrow_facets_reflect_the_closed_form_at_each_wavelength(angle):
    import mitsuba as mi

    cosine, at = np.cos(np.radians(angle)), np.array(WAVELENGTHS)
    index = metal_index(np.array([0.6]), np.array([0.6 + 0.4 * (6 / 7) ** 5]))
    for surface, base in (
        (Coated(Constant(0.0), 1.5, 0.05, film=FILM), 1.5),
        (Glossy(Constant(0.6), 0.05, Constant(1.0), film=FILM), index),
    ):
        count = 1 << 15
        stream = mi.PCG32(size=count, initstate=9)
        sample = mi.Point2f(stream.next_float32(), stream.next_float32())
        si = interaction(towards(angle), count)
        _, weight = plugin(surface).sample(
            mi.BSDFContext(), si, stream.next_float32(), sample, True
        )
        expected = reflectance(FILM, base, cosine, at)
        assert np.array(weight).mean(axis=1) == pytest.approx(expected, abs=4e-3)


@pytest.mark.mitsuba
@pytest.mark.usefixtures("spectral")
@pytest.mark.parametrize("angle", [0, 45, 80, 110])
@pytest.mark.parametrize(
    "surface",
    [
        Dielectric(roughness=0.3, film=FILM),
        Dielectric(roughness=0.8, film=Film(150.0, 1.38)),
        Dielectric(Cauchy(1.0), 0.3, film=FILM),
        Dielectric(Cauchy(1.0), 0.0, film=Film(300.0, 1.33)),
        Coated(Constant(1.0), 1.5, 0.3, film=FILM),
        Coated(Constant(1.0), 1.0, 0.9, film=FILM),
        Coated(Constant(1.0), 1.5, 0.5, film=FILM, tint=Constant(0.2)),
        Glossy(Constant(1.0), 0.6, Constant(1.0), film=FILM),
    ],
)
def test_no_light_is_lost_under_a_clear_film(surface, angle):
    assert flux(surface, angle, 1 << 17) == pytest.approx(1.0, abs=5e-3)


@pytest.mark.mitsuba
@pytest.mark.usefixtures("spectral")
@pytest.mark.parametrize("angle", [20, 65, 150])
def test_rough_glass_draws_directions_as_it_answers_them(angle):
    """By wavelength and side: the mean weight of samples and the integral of values over all directions."""
    import mitsuba as mi

    count = 1 << 19
    glass = plugin(Dielectric(roughness=0.7, film=FILM))
    si = interaction(towards(angle), count)
    stream = mi.PCG32(size=count, initstate=9)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    bs, weight = glass.sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    everywhere = mi.warp.square_to_uniform_sphere(
        mi.Point2f(stream.next_float32(), stream.next_float32())
    )
    value, pdf = glass.eval_pdf(mi.BSDFContext(), si, everywhere, True)
    sphere, above = 4.0 * np.pi, np.cos(np.radians(angle)) > 0.0
    for is_up in (True, False):
        drawn, met = (np.array(w.z > 0.0) == is_up for w in (bs.wo, everywhere))
        found = np.array(weight) * drawn
        expected = np.array(value) * met * sphere
        noise = np.hypot(found.std(axis=1), expected.std(axis=1)) / np.sqrt(count)
        assert (np.abs(found.mean(axis=1) - expected.mean(axis=1)) < 4.5 * noise + 2e-3).all()
        if is_up == above:
            # Mitsuba draws some directions of refraction that its density does not know.
            share = (np.array(pdf) * met * sphere).mean()
            assert (np.array(bs.pdf) > 0.0)[drawn].sum() / count == pytest.approx(share, abs=0.02)


@pytest.mark.mitsuba
@pytest.mark.parametrize("angle", [0, 60])
def test_photometric_variants_have_the_mean_that_eyes_weigh(angle):
    from lumenray.engine.photometry.spectra import GRID, luminous_efficiency

    backend.start(spectral=False)
    weight = luminous_efficiency() / luminous_efficiency().sum()
    expected = reflectance(FILM, 1.5, np.cos(np.radians(angle)), GRID) @ weight
    found = albedo(Coated(Constant(0.0), 1.5, 0.05, film=FILM), angle, 1 << 15)
    assert found == pytest.approx(expected, abs=3e-3)
