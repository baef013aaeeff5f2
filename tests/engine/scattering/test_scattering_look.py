"""The look of measured materials: tables of known surfaces give their parameters back."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scattering_models import ggx, lambert, schlick

from lumenray.engine.photometry.colour import XYZ_TO_REC709
from lumenray.engine.scattering.data.record import ScatteringFile
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scattering.data.tristimulus import linear_colour, tristimulus
from lumenray.engine.scattering.look import energy_of_lobe, fit_look
from lumenray.engine.scattering.readers.colour import spectra_of_rgb
from lumenray.engine.scattering.summary import summarise

INCIDENCES = np.radians([0.0, 8.0, 30.0, 60.0])


def table(*parts, wavelengths=(550.0,), **options):
    """A table of the sum of some evaluators."""
    return resample(
        lambda wi, wo: sum(part(wi, wo) for part in parts),
        wavelengths,
        **({"incidences": INCIDENCES, "tolerance": 0.03} | options),
    )


def look(reflected=None, passed=None, side="front"):
    sides = {f"{side}_reflection": reflected, f"{side}_transmission": passed}
    found = {name: each for name, each in sides.items() if each is not None}
    return fit_look(ScatteringFile(Path("sample"), "test", found))


def mirror(share):
    return lambda cosine: np.full_like(cosine, share)


def with_direct(made, share):
    shape = (len(made.rotations), len(made.incidences), len(made.wavelengths))
    return replace(made, direct=np.full(shape, share, np.float32))


@pytest.mark.parametrize("reflectance", [0.02, 0.5, 0.9])
def test_a_matt_surface_has_its_reflectance_and_no_gloss(reflectance):
    found = look(table(lambert(reflectance)))
    assert found.base_colour == pytest.approx([reflectance] * 3, abs=1e-4)
    assert (found.metallic, found.ior, found.transmission, found.translucency) == (0, 1, 0, 0)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("roughness", [0.1, 0.2, 0.3, 0.5, 0.7])
@pytest.mark.parametrize("reflectance", [0.02, 0.3, 0.7])
def test_a_coated_surface_gives_back_roughness_index_and_colour(roughness, reflectance):
    found = look(table(lambert(reflectance), ggx(roughness**2, schlick)))
    assert found.metallic == 0.0
    assert found.roughness == pytest.approx(roughness, abs=0.03)
    # Glass of 4 % has the index 1.5.
    assert found.ior == pytest.approx(1.5, abs=0.05)
    # The Principled BSDF has the coat's reflection taken off the light that reaches its base.
    assert found.base_colour == pytest.approx([reflectance / 0.96] * 3, abs=0.02)


@pytest.mark.parametrize("roughness", [0.1, 0.2, 0.3])
def test_a_metal_is_one_with_its_own_reflectance(roughness):
    found = look(table(ggx(roughness**2, mirror(0.8))))
    assert found.metallic == 1.0
    assert found.roughness == pytest.approx(roughness, abs=0.03)
    assert found.base_colour == pytest.approx([0.8] * 3, abs=0.02)


def test_a_black_gloss_is_no_metal():
    found = look(table(ggx(0.01, schlick)))
    assert found.metallic == 0.0
    assert found.ior == pytest.approx(1.5, abs=0.03)
    assert max(found.base_colour) < 0.01


@pytest.mark.parametrize("rgb", [(0.8, 0.55, 0.2), (0.2, 0.3, 0.7)])
@pytest.mark.parametrize("is_metal", [True, False])
def test_colours_are_those_under_daylight(rgb, is_metal):
    wavelengths, (spectrum,) = spectra_of_rgb([rgb])
    shape = ggx(0.04) if is_metal else lambert(1.0)
    found = look(table(lambda wi, wo: shape(wi, wo) * spectrum, wavelengths=wavelengths))
    assert found.metallic == float(is_metal)
    assert found.base_colour == pytest.approx(rgb, abs=0.02)


@pytest.mark.parametrize("turn", [0.0, 0.5, 2.0])
def test_brushed_metal_gives_back_both_widths_and_their_direction(turn):
    across, along = 0.06, 0.24
    brushed = ggx(across, mirror(0.8), along=along)
    cos_t, sin_t = np.cos(turn), np.sin(turn)
    back = np.array([[cos_t, -sin_t, 0.0], [sin_t, cos_t, 0.0], [0.0, 0.0, 1.0]])
    made = resample(
        lambda wi, wo: brushed(wi @ back, wo @ back),
        [550.0],
        incidences=INCIDENCES[:3],
        rotations=np.arange(24) * np.pi / 12.0,
        is_symmetric=False,
        tolerance=0.1,
    )
    found = look(made)
    assert found.roughness == pytest.approx((across * along) ** 0.25, abs=0.03)
    assert 1.0 - 0.9 * found.anisotropy == pytest.approx(across / along, abs=0.03)
    assert np.cos(2.0 * (found.grain - turn)) == pytest.approx(1.0, abs=0.01)


def test_a_mirror_and_a_pane_have_their_direct_shares():
    dark = table(lambert(1e-3))
    found = look(with_direct(dark, 0.9))
    assert (found.metallic, found.roughness) == (1.0, 0.0)
    assert found.base_colour == pytest.approx([0.9] * 3, abs=0.005)
    found = look(with_direct(dark, 0.08), with_direct(dark, 0.85))
    assert found.transmission == pytest.approx(1.0, abs=0.01)
    assert found.roughness == 0.0
    assert ((found.ior - 1.0) / (found.ior + 1.0)) ** 2 == pytest.approx(0.08, abs=0.001)


def test_a_diffuser_is_translucent_in_proportion():
    found = look(table(lambert(0.2)), table(lambert(0.6)))
    assert found.translucency == pytest.approx(0.75, abs=0.01)
    # Both shaders together send back and let through what the sheet does.
    reflected = (1.0 - found.translucency) * found.base_colour[1]
    passed = found.translucency * found.translucent_colour[1]
    assert (reflected, passed) == pytest.approx((0.2, 0.6), abs=0.01)
    assert found.overall_colour == pytest.approx([0.8] * 3, abs=0.01)


def test_frosted_glass_passes_light_in_a_lobe():
    found = look(table(lambert(0.1)), table(ggx(0.05, mirror(0.7))))
    assert found.transmission == pytest.approx(0.7 / 0.8, abs=0.02)
    assert found.roughness == pytest.approx(np.sqrt(0.05), abs=0.03)
    assert found.translucency < 0.02


def test_what_is_not_known_of_the_front_is_taken_from_the_back():
    back = table(lambert(0.3))
    assert look(back, side="back").base_colour == pytest.approx([0.3] * 3, abs=1e-3)
    sides = {"back_reflection": back, "front_transmission": table(lambert(0.6))}
    found = fit_look(ScatteringFile(Path("sheet"), "test", sides))
    assert found.translucency == pytest.approx(2.0 / 3.0, abs=0.01)


def test_light_of_the_lobe_is_that_of_its_table():
    for alpha in (0.05, 0.25, 0.6):
        made = table(ggx(alpha, mirror(1.0)), tolerance=0.01)
        (figures,) = summarise(
            ScatteringFile(Path("x"), "test", {"front_reflection": made})
        ).values()
        assert figures.near_normal[0] == pytest.approx(
            energy_of_lobe(alpha, np.radians(8.0)), abs=0.01
        )


def test_tristimulus_of_even_reflectances_is_that_of_the_illuminant():
    # CIE 15: the white points of D65 and A for the 2-degree observer.
    for name, x, y in (("D65", 0.31272, 0.32903), ("A", 0.44757, 0.40745)):
        seen = tristimulus([0.5], [560.0], name)
        assert seen[1] == pytest.approx(0.5)
        assert seen[:2] / seen.sum() == pytest.approx([x, y], abs=2e-5)
    assert linear_colour([1.0, 1.0], [400.0, 700.0]) == pytest.approx([1.0] * 3, abs=1e-3)
    with_bands = tristimulus(np.linspace(0.0, 1.0, 31), np.linspace(400.0, 700.0, 31))
    assert XYZ_TO_REC709 @ with_bands == pytest.approx(
        linear_colour([0.0, 1.0], [400.0, 700.0]), abs=1e-9
    )


def test_figures_of_a_file_are_those_of_its_surface():
    made, passed = table(lambert(0.4)), with_direct(table(lambert(0.1)), 0.3)
    sides = {"front_reflection": made, "back_reflection": made, "front_transmission": passed}
    found = summarise(ScatteringFile(Path("x"), "test", sides))
    assert found["front_reflection"] is found["back_reflection"]
    front = found["front_reflection"]
    assert front.near_normal == pytest.approx([0.4], abs=1e-4)
    assert front.tristimulus("A")[1] == pytest.approx(0.4, abs=1e-4)
    assert front.reciprocity == pytest.approx(0.0, abs=1e-4)
    assert front.symmetry == "isotropic"
    assert front.incidences == pytest.approx(INCIDENCES)
    assert found["front_transmission"].near_normal == pytest.approx([0.4], abs=1e-4)
