"""Reflectance models: sampling agrees with the stated density, energy and reciprocity hold."""

import numpy as np
import pytest
from sampled_surfaces import albedo, flux, interaction, plugin
from scattering_models import towards
from scipy import stats

from lumenray.engine.scene.film import Film
from lumenray.engine.scene.material import (
    Black,
    Blend,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    Grain,
    Mix,
    Sheen,
    ThinGlass,
    Toon,
    Transparent,
    Varnish,
    blend_cosines,
)
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.transport import backend

FACING = np.stack([np.stack([blend_cosines(), 1.0 - blend_cosines()])] * 2)
"""Weights of a blend whose second part shows at the edges."""

SUM = np.ones_like(FACING)

GREY, FILM = Constant(0.5), Film(420.0, 1.9)

SMOOTH = {
    "matt": Diffuse(Constant(0.6)),
    "rough matt": Diffuse(Rgb(0.9, 0.6, 0.3), None, 0.8),
    "gloss over rough": Coated(Rgb(0.9, 0.6, 0.3), 1.5, 0.3, 1.0, 0.8),
    "sheet": Diffuse(Constant(0.3), Constant(0.5)),
    "gloss paint": Coated(Rgb(0.6, 0.3, 0.2), 1.5, 0.3),
    "tinted gloss": Coated(Rgb(0.6, 0.3, 0.2), 1.8, 0.4, 1.0, 0.0, Rgb(0.1, 0.5, 0.9)),
    "satin": Coated(Constant(0.2), 1.6, 0.7),
    "rough gloss": Glossy(Rgb(0.9, 0.6, 0.3), 0.8),
    "rough metal": Conductor("Au", 0.5),
    "tinted edge": Glossy(Rgb(0.9, 0.6, 0.3), 0.4, Rgb(0.3, 0.5, 0.9)),
    "varnished paint": Varnish(Coated(Rgb(0.9, 0.6, 0.3)), 0.7, 1.6, 0.3, Rgb(0.3, 0.6, 0.9)),
    "varnished metal": Varnish(Glossy(Rgb(0.9, 0.6, 0.3), 0.6), 1.0, 1.5, 0.2),
    "brushed metal": Glossy(Rgb(0.9, 0.6, 0.3), 0.5, Constant(0.7), Grain(2.5, 0.15)),
    "brushed paint": Coated(Rgb(0.6, 0.3, 0.2), 1.6, 0.5, 1.0, 0.0, None, Grain(0.5, 0.4)),
    "fibres": Sheen(Black(), 1.0, Rgb(0.9, 0.6, 0.3), 0.3),
    "velvet": Sheen(Black(), 1.0, Rgb(0.9, 0.6, 0.3), 0.4, True),
    "paint under fibres": Sheen(Coated(Rgb(0.6, 0.3, 0.2)), 0.8, Rgb(0.3, 0.6, 0.9), 0.6),
    "fibres on varnish": Sheen(Varnish(Diffuse(Constant(0.5)), 1.0, 1.5, 0.3), 1.0),
    "by facing": Blend(Diffuse(Constant(0.5)), Glossy(Constant(0.8), 0.5), FACING),
    "sum": Blend(Diffuse(Rgb(0.7, 0.4, 0.2)), Glossy(Constant(0.9), 0.5), SUM),
    "toon": Toon(Rgb(0.7, 0.4, 0.2), 0.4, 0.3),
    "glossy toon": Toon(Rgb(0.7, 0.4, 0.2), 0.3, 0.3, True),
    "paint under a film": Coated(Rgb(0.6, 0.3, 0.2), 1.5, 0.5, film=FILM),
    "metal under a film": Glossy(Rgb(0.9, 0.6, 0.3), 0.5, Constant(0.7), film=FILM),
    "brushed paint under a film": Coated(GREY, 1.5, 0.5, grain=Grain(2.0, 0.15), film=FILM),
    "brushed metal under a film": Glossy(GREY, 0.5, Constant(0.7), Grain(2.0, 0.15), FILM),
    "varnish over a film": Varnish(Coated(GREY, 1.5, 0.5, film=FILM), 0.8, 1.5, 0.3),
    "mixture": Mix(Diffuse(Constant(0.5)), Glossy(Constant(0.8), 0.5), 0.4),
}


@pytest.fixture(autouse=True)
def _spectral():
    backend.start(spectral=True)


@pytest.mark.parametrize("angle", [10, 60, 130])
@pytest.mark.parametrize("name", SMOOTH)
def test_sampled_directions_follow_the_stated_density(name, angle):
    import mitsuba as mi

    bsdf = plugin(SMOOTH[name])
    count = 1 << 17
    stream = mi.PCG32(size=count, initstate=5)
    si = interaction(towards(angle), count)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    bs, weight = bsdf.sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    # Mitsuba's rough glass returns a density with directions that it gives no light.
    valid = (np.array(bs.pdf) > 0.0) & (np.array(bsdf.pdf(mi.BSDFContext(), si, bs.wo, True)) > 0.0)
    wo = np.stack([np.array(c) for c in bs.wo], axis=1)[valid]
    bins = (16, 24)

    def cells(z, phi):
        return np.clip(((z + 1) / 2 * bins[0]).astype(int), 0, bins[0] - 1) * bins[1] + np.clip(
            ((phi / (2 * np.pi)) % 1.0 * bins[1]).astype(int), 0, bins[1] - 1
        )

    observed = np.bincount(
        cells(wo[:, 2], np.arctan2(wo[:, 1], wo[:, 0])), minlength=bins[0] * bins[1]
    )
    # Expected counts: the density integrated over each cell with 24 x 24 points.
    fine = 24
    z = (np.arange(bins[0] * fine) + 0.5) / (bins[0] * fine) * 2 - 1
    phi = (np.arange(bins[1] * fine) + 0.5) / (bins[1] * fine) * 2 * np.pi
    zz, pp = (m.ravel() for m in np.meshgrid(z, phi, indexing="ij"))
    radius = np.sqrt(1 - zz**2)
    direction = mi.Vector3f(
        mi.Float((radius * np.cos(pp)).astype(np.float32)),
        mi.Float((radius * np.sin(pp)).astype(np.float32)),
        mi.Float(zz.astype(np.float32)),
    )
    grid = interaction(towards(angle), len(zz))
    pdf = np.array(bsdf.pdf(mi.BSDFContext(), grid, direction, True), dtype=float)
    expected = np.bincount(cells(zz, pp), weights=pdf, minlength=bins[0] * bins[1])
    expected *= 4 * np.pi / len(zz) * count
    enough = expected > 8
    chi = ((observed - expected)[enough] ** 2 / expected[enough]).sum()
    assert stats.chi2.sf(chi, enough.sum() - 1) > 1e-4
    assert abs(observed.sum() - expected.sum()) < 5 * np.sqrt(count) + 0.004 * count
    # The weight is value / density.
    value = bsdf.eval(mi.BSDFContext(), si, bs.wo, True)
    ratio = np.array(value)[:, valid] / np.array(bs.pdf)[valid]
    assert np.allclose(np.array(weight)[:, valid], ratio, rtol=2e-3, atol=1e-4)


RECIPROCAL = (
    *("tinted gloss", "matt", "rough matt", "gloss paint", "gloss over rough", "satin"),
    *("rough gloss", "rough metal", "tinted edge", "varnished paint", "varnished metal", "sum"),
    *("brushed metal", "brushed paint", "paint under a film", "metal under a film"),
    *("brushed paint under a film", "brushed metal under a film", "varnish over a film"),
    *("fibres", "velvet", "paint under fibres", "fibres on varnish"),
)


@pytest.mark.parametrize("name", RECIPROCAL)
def test_reflection_is_reciprocal(name):
    import mitsuba as mi

    bsdf = plugin(SMOOTH[name])
    rng = np.random.default_rng(3)
    for _ in range(20):
        a, b = rng.normal(size=(2, 3))
        a[2], b[2] = abs(a[2]) + 0.05, abs(b[2]) + 0.05
        a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
        there = (
            np.array(
                bsdf.eval(mi.BSDFContext(), interaction(a, 1), mi.Vector3f(*map(float, b)), True)
            )
            / b[2]
        )
        back = (
            np.array(
                bsdf.eval(mi.BSDFContext(), interaction(b, 1), mi.Vector3f(*map(float, a)), True)
            )
            / a[2]
        )
        assert np.allclose(there, back, rtol=1e-3)


@pytest.mark.parametrize("angle", [0, 45, 80])
@pytest.mark.parametrize("roughness", [0.1, 0.5, 1.0])
def test_a_white_base_under_a_coat_loses_at_most_what_single_scattering_loses(roughness, angle):
    # Single scattering of a rough coat loses a few percent at grazing angles; nothing may be gained.
    assert 0.93 < albedo(Coated(Constant(1.0), 1.5, roughness), angle) < 1.003


@pytest.mark.parametrize("angle", [0, 45, 80, 110])
@pytest.mark.parametrize(
    "base", [Diffuse(Constant(1.0)), Glossy(Constant(1.0), 0.5), Transparent()]
)
def test_white_fibres_take_from_a_white_base_what_they_send_on(base, angle):
    found = albedo(Sheen(base, 0.7, Constant(1.0), 0.6), angle, 1 << 17)
    assert found == pytest.approx(1.0, abs=4e-3)


@pytest.mark.parametrize("angle", [0, 45, 80, 110])
@pytest.mark.parametrize("roughness", [0.2, 1.0])
def test_a_white_rough_base_reflects_everything(roughness, angle):
    found = albedo(Diffuse(Constant(1.0), None, roughness), angle, 1 << 18)
    assert found == pytest.approx(1.0, abs=2.5e-3)


def test_a_rough_base_is_brightest_towards_the_light():
    """Fujii's closed form for light and eye at 60 degrees: 1 + sigma sin^2 / cos together, 1 - sigma sin^2 opposite."""
    import mitsuba as mi

    # So dark that no light comes by two facets.
    sigma, reflectance, sine = 0.7, 1e-3, float(np.sqrt(0.75))
    scale = 1.0 / (1.0 + sigma * (0.5 - 2.0 / (3.0 * np.pi)))
    bsdf = plugin(Diffuse(Constant(reflectance), None, sigma))
    si = interaction((sine, 0.0, 0.5), 1)
    for wo, t in (((sine, 0.0, 0.5), 1.5), ((-sine, 0.0, 0.5), -0.75), ((0.0, sine, 0.5), 0.0)):
        value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*wo), True)
        expected = reflectance / np.pi * 0.5 * scale * (1.0 + sigma * t)
        np.testing.assert_allclose(np.array(value)[0], expected, rtol=1e-4)


@pytest.mark.parametrize("angle", [0, 45, 80, 120])
def test_a_blend_by_facing_reflects_as_its_parts_at_that_angle(angle):
    parts = Diffuse(Constant(0.2)), Diffuse(Constant(0.7))
    cosine = abs(np.cos(np.radians(angle)))
    found = albedo(Blend(*parts, FACING), angle, 1 << 14)
    assert found == pytest.approx(0.2 * cosine + 0.7 * (1.0 - cosine), abs=2e-3)


def test_a_blend_of_front_and_back_is_another_surface_from_behind():
    weights = np.zeros_like(FACING)
    weights[0, 0] = weights[1, 1] = 1.0
    surface = Blend(Diffuse(Constant(0.2)), Diffuse(Constant(0.7)), weights)
    assert albedo(surface, 30, 1 << 10) == pytest.approx(0.2, abs=1e-4)
    assert albedo(surface, 150, 1 << 10) == pytest.approx(0.7, abs=1e-4)


@pytest.mark.parametrize("angle", [0, 45, 85, 110])
@pytest.mark.parametrize(
    "parts",
    [
        (Diffuse(Constant(1.0)), Glossy(Constant(1.0), 0.3)),
        (Coated(Constant(0.5), 1.5, 0.3), Diffuse(Constant(0.5))),
        (Glossy(Rgb(0.9, 0.3, 0.1), 0.0), Dielectric()),
    ],
)
def test_a_sum_of_surfaces_makes_no_light(parts, angle):
    assert flux(Blend(*parts, SUM), angle, 1 << 16) < 1.003


def test_a_sum_holds_every_wavelength_within_what_comes():
    """Spectra of saturated colours rise above the colour itself: 0.5 and a red of 0.4 are more than 1 beyond 650 nm."""
    import mitsuba as mi

    surface = Blend(Diffuse(Rgb(0.4, 0.2, 0.1)), Diffuse(Constant(0.5)), SUM)
    si = interaction(towards(30), 1)
    si.wavelengths = mi.Spectrum(550.0, 600.0, 700.0, 760.0)
    values = np.array(plugin(surface).eval(mi.BSDFContext(), si, mi.Vector3f(0, 0, 1), True))
    parts = [
        np.array(plugin(part).eval(mi.BSDFContext(), si, mi.Vector3f(0, 0, 1), True))
        for part in (surface.first, surface.second)
    ]
    assert (sum(parts) * np.pi).max() > 1.05
    np.testing.assert_allclose(values, np.minimum(sum(parts), 1.0 / np.pi), rtol=2e-3)


def test_a_toon_reflects_its_colour_from_all_sides_less_what_its_edge_takes():
    """Without an edge all; with one what integrates to: cone of 45 degrees, edge of 45, by quadrature."""
    angle = (np.arange(4096) + 0.5) / 4096 * np.pi / 2
    shine = np.clip(2.0 - angle / (np.pi / 4), 0.0, 1.0)
    soft = (shine * np.sin(angle)).sum() * (np.pi / 2) / 4096
    for eye in (0, 70, 130):
        assert albedo(Toon(Constant(0.6), 0.5), eye) == pytest.approx(0.6, abs=1e-3)
        found = albedo(Toon(Constant(0.6), 0.5, 0.5), eye)
        assert found == pytest.approx(0.6 * soft, abs=4e-3)


@pytest.mark.parametrize("roughness", [0.0, 0.2])
def test_glass_with_a_tint_on_both_ways_loses_as_much_of_each(roughness):
    tint = Constant(0.25)
    plain = flux(Dielectric(roughness=roughness), 120, 1 << 16)
    assert plain == pytest.approx(1.0, abs=3e-3)
    both = flux(Dielectric(roughness=roughness, tint=tint, mirror_tint=tint), 120, 1 << 16)
    assert both == pytest.approx(0.25 * plain, rel=5e-3)
    # At 80 degrees 38.8 % are reflected (Fresnel, index 1.5).
    passing = flux(Dielectric(tint=tint), 80, 1 << 18)
    assert passing == pytest.approx(0.388 + 0.612 * 0.25, abs=5e-3)


@pytest.mark.parametrize("reflects", [True, False])
@pytest.mark.parametrize("roughness", [0.0, 0.4])
def test_boundaries_answer_alike_whichever_way_light_is_followed(reflects, roughness):
    """Light from lamps is traced with the radiance that eyes see; Mitsuba's own answers by the index in that case."""
    bsdf = plugin(Dielectric(roughness=roughness, reflects=reflects))
    import mitsuba as mi

    si = interaction(towards(30.0), 256)
    stream = mi.PCG32(256)
    choice, where = stream.next_float32(), mi.Point2f(stream.next_float32(), stream.next_float32())
    seen, sent = (
        np.array(bsdf.sample(mi.BSDFContext(mode), si, choice, where)[1])
        for mode in (mi.TransportMode.Radiance, mi.TransportMode.Importance)
    )
    assert seen.any()
    np.testing.assert_allclose(sent, seen, rtol=1e-5)


@pytest.mark.parametrize("roughness", [0.0, 0.3])
def test_a_refraction_lets_all_light_pass_or_none(roughness):
    surface = Dielectric(roughness=roughness, reflects=False)
    lost = 0.0 if roughness == 0.0 else 0.03
    for angle in (0, 60, 160):
        assert 1.0 - lost - 2e-3 < flux(surface, angle, 1 << 16) < 1.003
    # Beyond the critical angle of 41.8 degrees, far enough for facets that lie aslant.
    assert flux(surface, 110, 1 << 16) < (1e-9 if roughness == 0.0 else 0.05)


def test_a_blend_that_is_not_reciprocal_says_so():
    from lumenray.engine.transport.compiled.surfaces import approximations

    matt = Diffuse(Constant(0.5))
    assert "exchanged" in approximations(Blend(matt, Glossy(), FACING))[0]
    assert approximations(Blend(matt, Glossy(), SUM)) == []
    assert approximations(Blend(Transparent(), Glossy(Constant(1.0), 0.0), FACING)) == []


VARNISHED = {
    "matt": Diffuse(Constant(1.0)),
    "gloss paint": Coated(Constant(1.0), 1.5, 0.3),
    "metal": Glossy(Constant(1.0), 0.5),
    "rough metal": Glossy(Constant(1.0), 1.0),
    "mirror": Glossy(Constant(1.0), 0.0),
    "glass": Dielectric(),
}
"""White bases: none of them keeps light but what the single scattering of a gloss loses."""


@pytest.mark.parametrize("angle", [0, 45, 80])
@pytest.mark.parametrize("name", VARNISHED)
def test_a_base_under_varnish_reflects_what_the_varnish_leaves(name, angle):
    """In all directions together: 1 - w C of what it would reflect, and w C from the varnish, C by Fresnel (smooth)."""
    weight, count = 0.6, 1 << 17
    base = VARNISHED[name]
    surface = Varnish(base, weight, 1.5, 0.03)
    cos_i = np.cos(np.radians(angle))
    cos_t = np.sqrt(1.0 - (1.0 - cos_i**2) / 2.25)
    mirror = 0.5 * (
        ((cos_i - 1.5 * cos_t) / (cos_i + 1.5 * cos_t)) ** 2
        + ((1.5 * cos_i - cos_t) / (1.5 * cos_i + cos_t)) ** 2
    )
    under, found = flux(base, angle, count), flux(surface, angle, count)
    expected = weight * mirror + (1.0 - weight * mirror) * under
    assert found == pytest.approx(expected, abs=5e-3)
    assert found < 1.003


def test_tinted_varnish_over_a_white_base_lets_both_ways_pass_as_one():
    """Blender's tint is that of both ways together, by the way that is slanted like the eye's."""
    tint, angle = 0.3, 60
    surface = Varnish(Diffuse(Constant(1.0)), 1.0, 1.5, 0.03, Constant(tint))
    clear = Varnish(Diffuse(Constant(0.0)), 1.0, 1.5, 0.03)
    own = albedo(clear, angle, 1 << 17)
    length = 1.0 / np.sqrt(1.0 - np.sin(np.radians(angle)) ** 2 / 2.25)
    found = albedo(surface, angle, 1 << 17)
    assert found - own == pytest.approx((1.0 - own) * tint**length, rel=0.015)


@pytest.mark.parametrize("angle", [0, 45, 80, 110])
@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.52, 0.75, 1.0])
def test_white_facets_reflect_everything(roughness, angle):
    found = albedo(Glossy(Constant(1.0), roughness), angle, 1 << 18)
    assert found == pytest.approx(1.0, abs=2.5e-3)


@pytest.mark.parametrize("angle", [0, 45, 80, 110, 170])
@pytest.mark.parametrize("roughness", [0.1, 0.4, 0.7, 1.0])
def test_clear_rough_glass_sends_all_light_on(roughness, angle):
    """Radiance grows with the square of the index, so the flux that goes on is the weight times the square of eta."""
    import mitsuba as mi

    count = 1 << 18
    stream = mi.PCG32(size=count, initstate=9)
    si = interaction(towards(angle), count)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    glass = plugin(Dielectric(roughness=roughness))
    bs, weight = glass.sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    flux = np.array(weight)[0] * np.array(bs.eta) ** 2
    assert flux.mean() == pytest.approx(1.0, abs=3e-3)
    # The weight is value over density.
    value, pdf = glass.eval_pdf(mi.BSDFContext(), si, bs.wo, True)
    valid = (np.array(pdf) > 1e-3) & (flux > 0.0)
    ratio = np.array(value)[0][valid] / np.array(pdf)[valid]
    assert np.allclose(np.array(weight)[0][valid], ratio, rtol=0.02)


@pytest.mark.parametrize("roughness", [0.3, 0.7])
def test_what_facets_reflect_once_and_what_comes_by_more_of_them(roughness):
    """Mitsuba's own rough conductor knows single reflections only; its masking and shadowing know nothing of each other."""
    import mitsuba as mi

    from lumenray.engine.materials.rough_metal import tables

    count, angle, colour = 1 << 18, 45, 0.5
    stream = mi.PCG32(size=count, initstate=9)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    known = mi.load_dict(
        {"type": "roughconductor", "material": "none", "alpha": roughness**2, "distribution": "ggx"}
    )
    si = interaction(towards(angle), count)
    _, weight = known.sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    theirs = float(np.array(weight).mean())
    rows, means = tables()
    places = np.linspace(0.0, 1.0, len(rows))
    root = np.sqrt(np.cos(np.radians(angle)))
    by_roughness = [np.interp(root, np.linspace(0.0, 1.0, row.size), row) for row in rows]
    once = np.interp(roughness, places, by_roughness)
    assert theirs - 0.002 < once < theirs + 0.006
    mean = np.interp(roughness, places, means)
    # A geometric series over the facets that light meets, each of which lets E_mean of it go.
    more = (1.0 - once) * colour**2 * mean / (1.0 - colour * (1.0 - mean))
    found = albedo(Glossy(Constant(colour), roughness), angle, count)
    assert found == pytest.approx(colour * once + more, abs=3e-3)


def test_a_black_coated_surface_reflects_the_fresnel_share():
    # Smooth limit at normal incidence: ((n - 1) / (n + 1))^2 = 4 %.
    assert albedo(Coated(Constant(0.0), 1.5, 0.05), 0) == pytest.approx(0.04, rel=0.02)


@pytest.mark.parametrize(("angle", "tint"), [(0, 0.3), (70, 0.3), (70, 0.0)])
def test_a_tint_colours_what_a_coat_reflects_along_its_normal(angle, tint):
    """Fresnel's rise from the normal to grazing light goes on to 1 from where the tint begins."""
    normal = 0.04
    cos_i = np.cos(np.radians(angle))
    cos_t = np.sqrt(1.0 - (1.0 - cos_i**2) / 2.25)
    mirror = 0.5 * (
        ((cos_i - 1.5 * cos_t) / (cos_i + 1.5 * cos_t)) ** 2
        + ((1.5 * cos_i - cos_t) / (1.5 * cos_i + cos_t)) ** 2
    )
    rise = (mirror - normal) / (1.0 - normal)
    expected = normal * tint + (1.0 - normal * tint) * rise
    black, white = (
        Coated(Constant(grey), 1.5, 0.05, 1.0, 0.0, Constant(tint)) for grey in (0.0, 1.0)
    )
    assert albedo(black, angle) == pytest.approx(expected, rel=0.02, abs=1e-5)
    assert albedo(white, angle) == pytest.approx(1.0, abs=3e-3)


def test_a_pane_transmits_what_fresnel_and_its_body_say():
    # n = 1.5, clear, normal incidence with all internal reflections: T = 2 n / (n^2 + 1) = 0.9231.
    import mitsuba as mi

    from lumenray.engine.materials.plugins import pane_optics

    r, t = pane_optics(mi.Float(1.0), 1.5, mi.Spectrum(1.0))
    assert np.allclose(np.array(t), 2 * 1.5 / (1.5**2 + 1), rtol=1e-5)
    assert np.allclose(np.array(r) + np.array(t), 1.0, rtol=1e-5)
    # At Brewster's angle (56.31 deg) p-polarised light passes in full; s: R1 = 0.1479, T = (1-R1)/(1+R1).
    r, t = pane_optics(mi.Float(float(np.cos(np.arctan(1.5)))), 1.5, mi.Spectrum(1.0))
    single = ((1.5**2 - 1) / (1.5**2 + 1)) ** 2
    assert np.allclose(np.array(t), 0.5 * (1 + (1 - single) / (1 + single)), rtol=1e-4)


@pytest.mark.parametrize(
    ("surface", "expected"),
    [
        (Black(), 0.0),
        (Diffuse(Constant(0.7)), 0.7),
        (Diffuse(Constant(0.3), Constant(0.5)), 0.8),
        (ThinGlass(1.5, Constant(1.0)), 1.0),
        (Transparent(Constant(0.4)), 0.4),
        (Dielectric(tint=Constant(1.0)), None),
    ],
    ids=lambda v: type(v).__name__,
)
def test_surfaces_return_the_stated_share(surface, expected):
    made = albedo(surface, 30)
    if expected is None:
        # Radiance in glass is n^2 denser, so the transmitted weight is divided by n^2: R + (1 - R) / n^2.
        reflectance = 0.0415  # Fresnel, n = 1.5, 30 degrees, unpolarised
        expected = reflectance + (1 - reflectance) / 2.25
    assert made == pytest.approx(expected, abs=0.004)


def kinds_of(kind):
    """All kinds of a kind of surface, those that only share code left out."""
    for each in kind.__subclasses__():
        yield from [] if each.__name__.startswith("_") else [each]
        yield from kinds_of(each)


def test_every_kind_of_surface_can_be_computed_and_shown_in_one_colour():
    from lumenray.engine.formats.gltf_colour import LOOKS
    from lumenray.engine.scene.material import Surface
    from lumenray.engine.transport.compiled.surfaces import MAKERS

    assert set(kinds_of(Surface)) == set(MAKERS) == set(LOOKS)
