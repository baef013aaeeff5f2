"""Mixing of light groups: exact sums, factors and errors, and colours that leave the amount of light."""

from dataclasses import replace

import numpy as np
import pytest

from lumenray.engine.accuracy.estimate import relative_error
from lumenray.engine.errors import SceneError
from lumenray.engine.light_mix import GroupLight, Level, LightMix, mix, tint
from lumenray.engine.photometry.colour import XYZ_TO_REC709, scene_linear
from lumenray.engine.scene.provenance import Provenance
from lumenray.engine.views import Picture

WHITE = np.linalg.inv(XYZ_TO_REC709) @ np.ones(3)
"""X, Y, Z of D65 with Y = 1."""


def light(name, seed, **more):
    rng = np.random.default_rng(seed)
    colour = rng.uniform(0.0, 50.0, (3, 4, 3)).astype(np.float32)
    error = rng.uniform(0.0, 2.0, (3, 4)).astype(np.float32)
    lux, lux_error = (rng.uniform(0.0, 9.0, (3, 4)).astype(np.float32) for _ in range(2))
    fields = {"illuminance": lux, "illuminance_error": lux_error, "backdrop": 0.1 * colour}
    return GroupLight(name, 8, colour, error, **(fields | more))


GROUPS = (light("a", 1), light("b", 2), light("c", 3))


def test_with_factors_of_one_the_mix_is_the_sum_to_the_last_bit():
    made = mix(GROUPS)
    total = sum(group.tristimulus.astype(np.float64) for group in GROUPS).astype(np.float32)
    np.testing.assert_array_equal(made.tristimulus, total)
    same = mix(GROUPS, LightMix((Level("a"), Level("b", 1.0, (0.3, 0.3, 0.3)))))
    for name, values in vars(made).items():
        np.testing.assert_array_equal(values, getattr(same, name))


def test_a_factor_is_a_factor_on_the_light_of_its_group_alone():
    made = mix(GROUPS, LightMix((Level("a", 0.5), Level("b", is_on=False), Level("gone", 7.0))))
    a, _, c = GROUPS
    for name in ("tristimulus", "illuminance", "backdrop"):
        expected = 0.5 * getattr(a, name) + getattr(c, name)
        np.testing.assert_allclose(getattr(made, name), expected, rtol=1e-6)
    for name in ("luminance_error", "illuminance_error"):
        expected = np.hypot(0.5 * getattr(a, name), getattr(c, name))
        np.testing.assert_allclose(getattr(made, name), expected, rtol=1e-6)


def test_mixing_is_linear():
    first, second = (mix(GROUPS, LightMix((Level("b", x, (1.0, 0.4, 0.1)),))) for x in (0.5, 2.5))
    both = mix(
        GROUPS, LightMix((Level("a", 2.0), Level("b", 3.0, (1.0, 0.4, 0.1)), Level("c", 2.0)))
    )
    total = first.tristimulus + second.tristimulus
    np.testing.assert_allclose(both.tristimulus, total, rtol=1e-5, atol=1e-4)


def test_a_group_that_is_off_cannot_spoil_the_mix():
    broken = GroupLight("b", 8, *(np.full(shape, np.nan) for shape in ((3, 4, 3), (3, 4))))
    made = mix(
        (replace(GROUPS[0], backdrop=None, illuminance=None, illuminance_error=None), broken),
        LightMix((Level("b", 0.0),)),
    )
    np.testing.assert_array_equal(made.tristimulus, GROUPS[0].tristimulus)
    np.testing.assert_array_equal(made.luminance_error, GROUPS[0].luminance_error)


@pytest.mark.parametrize("colour", [(1.0, 0.5, 0.2), (0.0, 0.0, 4.0), (2.0, 2.0, 2.0)])
def test_a_colour_sets_the_proportions_of_white_and_leaves_its_luminance(colour):
    made = tint(colour) @ WHITE
    assert made[1] == pytest.approx(1.0, rel=1e-9)
    linear = XYZ_TO_REC709 @ made
    np.testing.assert_allclose(linear * max(colour), np.array(colour) * linear.max(), atol=1e-4)


def test_a_colour_multiplies_the_linear_components_and_keeps_the_relative_error():
    (group,) = groups = (light("a", 4),)
    made = mix(groups, LightMix((Level("a", 3.0, (1.0, 0.5, 0.25)),)))
    before, after = (scene_linear(each.tristimulus, 1.0) for each in (group, made))
    factors = 3.0 * np.array([1.0, 0.5, 0.25]) / (0.2126 + 0.7152 * 0.5 + 0.0722 * 0.25)
    np.testing.assert_allclose(after, before * factors, rtol=1e-4, atol=1e-3)
    relative = group.luminance_error / group.tristimulus[..., 1]
    expected = relative * np.abs(made.tristimulus[..., 1])
    np.testing.assert_allclose(made.luminance_error, expected, rtol=1e-5)
    np.testing.assert_allclose(made.illuminance, 3.0 * group.illuminance, rtol=1e-6)


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({"factor": -0.1}, "the factor is -0.1"),
        ({"factor": float("nan")}, "the factor is nan"),
        ({"colour": (0.0, 0.0, 0.0)}, "one above 0"),
        ({"colour": (1.0, -1.0, 0.0)}, "at least 0"),
    ],
)
def test_levels_that_no_lamp_has_are_refused(values, text):
    with pytest.raises(SceneError, match=text):
        Level("desk", **values)


def test_words_say_what_a_factor_means():
    levels = LightMix(
        (Level("a", 0.5), Level("b", is_on=False), Level("c"), Level("d", 1.0, (1, 0, 0)))
    )
    assert levels.text() == "a at 50 % of its flux, b off, d in another colour"
    assert LightMix((Level("c"),)).text() == ""


def test_a_mixed_picture_has_what_was_left_out_of_all_groups_in_its_errors():
    """Simplifications are wrong in all groups alike, so that they do not add up as the errors of samples do."""
    flat = np.zeros((3, 4), np.float32)
    whole = mix(GROUPS)
    origin = Provenance("0", "mono", "", 0, 8, 1.0, simplified=0.1)
    plain = Picture(
        **vars(whole), relative_error=0.1, depth=flat, normal=flat, object_index=flat, material_index=flat,
        provenance=origin, groups=GROUPS,
    )  # fmt: skip
    levels = LightMix((Level("b", 0.5),))
    own, made = mix(GROUPS, levels), plain.mixed(levels)
    luminance = made.tristimulus[..., 1]
    expected = np.hypot(own.luminance_error, 0.1 * luminance)
    np.testing.assert_allclose(made.luminance_error, expected, rtol=1e-5)
    expected = np.hypot(own.illuminance_error, 0.1 * made.illuminance)
    np.testing.assert_allclose(made.illuminance_error, expected, rtol=1e-5)
    assert made.relative_error == relative_error(luminance, made.luminance_error)
    exact = replace(plain, provenance=replace(origin, simplified=0.0)).mixed(levels)
    np.testing.assert_array_equal(exact.luminance_error, own.luminance_error)
