"""The physics that computes the library's materials, against closed forms, handbooks and another program."""

import numpy as np
import pytest
from library_materials import at

from lumenray.tools.libraries.materials import (
    coats,
    colour,
    flakes,
    fresnel,
    grains,
    indices,
    metals,
    microfacets,
    pigments,
)


def hemisphere(count=200):
    """Directions and weights that integrate f cos over the hemisphere: even in the projected disk."""
    u = (np.arange(count) + 0.5) / count
    r, turn = (m.ravel() for m in np.meshgrid(np.sqrt(u), 2.0 * np.pi * u))
    wo = np.stack([r * np.cos(turn), r * np.sin(turn), np.sqrt(1.0 - r * r)], axis=1)
    return wo, np.pi / len(wo)


def sent(evaluate, polar, count=200):
    """Share of light from an angle that is scattered, by brute force."""
    wo, weight = hemisphere(count)
    return weight * evaluate(np.broadcast_to(at(polar), wo.shape), wo).sum(axis=0)


def test_even_light_is_held_back_inside_as_known():
    """Internal reflectance 0.596 and external 0.092 of a boundary of index 1.5 (Judd; Saunderson)."""
    coat = coats.Coat(1.5)
    assert coat.mean_share == pytest.approx(0.0918, abs=1e-4)
    assert coat.held_back == pytest.approx(0.596, abs=5e-4)


@pytest.mark.parametrize("alpha", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("polar", [0.0, 45.0, 75.0])
def test_a_white_body_under_a_coat_sends_everything_out(alpha, polar):
    paint = coats.Paint(coats.Coat(1.5, alpha), np.ones(1))
    share = sent(paint.evaluate, polar, 400)
    share = share + paint.direct(np.radians([polar]))[0]
    assert share == pytest.approx(1.0, abs=4e-3)


def test_a_slab_without_absorption_loses_nothing():
    slab = coats.Slab(coats.Coat(1.49), np.array([0.3]), np.array([0.7]))
    assert sum(slab.totals()) == pytest.approx(1.0, abs=1e-9)
    assert sum(pigments.layer(0.0, 2.5)) == pytest.approx(1.0, abs=1e-6)
    # Kubelka and Munk without absorption: R = S / (1 + S).
    assert pigments.layer(0.0, 2.5)[0] == pytest.approx(2.5 / 3.5, abs=1e-6)


def test_rough_facets_reflect_and_let_through_what_comes():
    """Walter's BTDF and the BRDF of smooth facets together: 1, but for second hits."""
    glass = microfacets.smooth_to_rough(0.15)
    (share,) = sent(lambda wi, wo: glass.reflection(wi, wo, np.ones_like), 20.0, 600)
    known = float(glass.albedo([np.cos(np.radians(20.0))], np.ones_like))
    assert share == pytest.approx(known, abs=2e-3)
    assert 0.96 < share <= 1.0

    def inward(wi, wo):
        down = wo * [1.0, 1.0, -1.0]
        return glass.transmission(wi, down, 1.5, np.zeros_like)[:, None]

    # Refraction deviates less, so that hardly a facet is met twice.
    assert sent(inward, 20.0, 600) == pytest.approx(1.0, abs=0.01)


def test_grains_keep_white_light_and_are_lambertian_when_smooth():
    for roughness in (0.0, 0.5, 1.0):
        for polar in (8.0, 60.0, 80.0):
            made = sent(grains.Grains(np.ones(1), roughness).evaluate, polar)
            assert made == pytest.approx(1.0, abs=2e-3)
    smooth = grains.Grains(np.array([0.4]), 0.0)
    assert smooth.evaluate(at(60.0), at(20.0, 50.0)) == pytest.approx(0.4 / np.pi)
    rough = grains.Grains(np.array([0.4]), 0.8)
    assert sent(rough.evaluate, 8.0) == pytest.approx(rough.total(), abs=1e-3)


@pytest.mark.parametrize(
    ("films", "nanometres", "expected"),
    [
        ((2.7, 1.5, 2.7), (12, 448, 12), (0.2203, 0.2480, 0.1483, 0.0893, 0.2535, 0.4525)),
        ((2.7, 1.77, 2.7), (165, 230, 165), (0.0309, 0.0545, 0.0561, 0.0576, 0.4075, 0.5932)),
    ],
)
def test_interference_flakes_reflect_as_another_program_finds(films, nanometres, expected):
    """Values of the package tmm for 450 nm in a binder of 1.45."""
    cosines = np.cos(np.radians([0.0, 15.0, 30.0, 45.0, 60.0, 75.0]))
    found = fresnel.stack_reflectance(cosines, [450.0], films, nanometres, 1.45)[:, 0]
    assert found == pytest.approx(expected, abs=1e-4)


def test_single_reflection_at_flakes_is_the_closed_form():
    """Opaque flakes of 0.9, slopes of 3 degrees, 2 per line, binder 1.45; light at 45 degrees, seen at 30, 45, 60."""
    spread = np.tan(np.radians(3.0))
    paint = flakes.Flakes(
        lambda c: 0.9 + 0.0 * c[:, None], np.zeros(1), spread, 2.0, np.zeros(1), 1.45
    )
    wi, wo = np.repeat(at(45.0), 3, axis=0), at([-30.0, -45.0, -60.0])
    found = paint.reflect_once(wi, wo)[:, 0]
    assert found == pytest.approx([1.1187, 3.6709, 1.7700], rel=3e-3)


def test_white_flakes_over_a_white_base_send_everything_out():
    paint = flakes.Flakes(
        lambda c: np.ones((len(c), 1)), np.ones(1), 0.1, 2.0, np.zeros(1), is_wide=True
    )
    for polar in (0.0, 30.0, 60.0, 80.0):
        share = sent(paint.evaluate, polar, 300) + paint.direct(np.radians([polar]))[0]
        assert share == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("metal", "known"),
    # Normal reflectance at 550 nm by handbooks (n, k of Rakic 1995; Johnson and Christy 1972).
    [("Al", 0.92), ("Ag", 0.96), ("Cu", 0.62), ("Au", 0.82), ("Cr", 0.65)],
)
def test_metals_reflect_as_handbooks_say(metal, known):
    index = metals.index_of(metal)[colour.WAVELENGTHS == 550.0]
    assert fresnel.reflectance(1.0, index)[0] == pytest.approx(known, abs=0.04)
    n, k = index[0].real, index[0].imag
    normal = ((n - 1.0) ** 2 + k * k) / ((n + 1.0) ** 2 + k * k)
    assert fresnel.reflectance(1.0, index)[0] == pytest.approx(normal, rel=1e-12)


def test_aluminium_has_the_index_of_rakic():
    index = metals.index_of("Al")[colour.WAVELENGTHS == 550.0][0]
    assert (index.real, index.imag) == pytest.approx((0.96, 6.69), rel=0.02)


@pytest.mark.parametrize(
    ("matter", "index", "abbe", "exactness"),
    # Schott's data sheets; Malitson; IAPWS for 20 degrees; refractiveindex.info.
    [
        ("N-BK7", 1.5168, 64.17, 0.01),
        ("N-SF11", 1.78472, 25.68, 0.01),
        ("fused silica", 1.45846, 67.82, 0.02),
        ("sapphire", 1.7682, 72.3, 0.1),
        ("water", 1.3334, 55.8, 0.1),
        ("polycarbonate", 1.5848, 27.9, 0.1),
        ("diamond", 2.4175, 55.3, 0.1),
    ],
)
def test_glasses_have_their_index_and_abbe_number(matter, index, abbe, exactness):
    formula = indices.CLEAR[matter]
    assert float(formula.index(indices.LINES["d"])) == pytest.approx(index, abs=1e-4)
    assert indices.abbe_number(formula) == pytest.approx(abbe, abs=exactness)
