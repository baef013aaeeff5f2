"""Pictures kept by light group: each is that of its lights alone, all add up, and the rule is met by the sum."""

from dataclasses import replace
from itertools import cycle
from types import SimpleNamespace

import numpy as np
import pytest
from live_scenes import camera_at, lamp
from luminaires import OPENINGS, luminaire
from ray_lamps import lamp_at
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.grouped_picture import Rendered, render_groups
from lumenray.engine.light_mix import Level, LightMix
from lumenray.engine.scene.light import Output, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.material import Emission
from lumenray.engine.scene.spectrum import Blackbody, Constant
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

CAMERA = camera_at(2, 2, 2.0, 40, 30)
GLOW = paint(0.2, "glow", emission=Emission(Constant(1.0), 60.0))
PANEL = quad("panel", (0.4, 1.2, 1.95), (0, 0.6, 0), (0.6, 0, 0), "glow")
ROOM = (box(4, 4, 3, "paint"), paint(0.5), PANEL)
LAMPS = (lamp("a", 1, 2, 2.5), lamp("b", 3, 2, 2.5))
GROUPS = (LightGroup("one", ("a",)), LightGroup("glow", ("glow",)))


def rendered(session, samples=64, groups=(), **more):
    more = {"rule": StopRule(samples=samples)} | more
    return session.render(
        CAMERA, ViewSettings(groups=groups, illuminance=True, shares=False, **more)
    )


def ratio(a, b, name, error):
    """Root mean square of the difference over what the errors make of it."""
    gap = (getattr(a, name) - getattr(b, name)).astype(float)
    gap = gap[..., 1] if gap.ndim == 3 else gap
    expected = np.hypot(getattr(a, error).astype(float), getattr(b, error))
    return np.sqrt((gap**2).mean() / (expected**2).mean())


@pytest.fixture(scope="module")
def session():
    return session_of(*ROOM, GLOW, *LAMPS)


@pytest.fixture(scope="module")
def grouped(session):
    return rendered(session, 128, GROUPS, seed=5)


def test_groups_add_up_to_the_picture_and_share_its_samples(session, grouped):
    assert [group.name for group in grouped.groups] == ["one", "glow", "rest"]
    plain = rendered(session, 128)
    assert 0.85 < ratio(grouped, plain, "tristimulus", "luminance_error") < 1.15
    assert 0.85 < ratio(grouped, plain, "illuminance", "illuminance_error") < 1.15
    for name in ("tristimulus", "illuminance"):
        total = sum(getattr(group, name).astype(float) for group in grouped.groups)
        np.testing.assert_array_equal(getattr(grouped, name), total.astype(np.float32))
    for name in ("luminance_error", "illuminance_error"):
        squares = sum(getattr(group, name).astype(float) ** 2 for group in grouped.groups)
        np.testing.assert_allclose(getattr(grouped, name), np.sqrt(squares), rtol=1e-6)
    samples = [group.samples for group in grouped.groups]
    assert 128 <= grouped.provenance.samples == sum(samples) < 128 + 2 * len(samples) + 1
    # The dim panel makes little noise, so it gets few.
    assert samples[1] < min(samples[0], samples[2])
    np.testing.assert_array_equal(grouped.depth, plain.depth)


def test_each_group_is_the_picture_of_its_lights_alone(grouped):
    off = paint(0.2, "glow")
    for group, items in zip(
        grouped.groups, ((off, LAMPS[0]), (GLOW,), (off, LAMPS[1])), strict=True
    ):
        alone = rendered(session_of(*ROOM, *items), 64)
        assert 0.85 < ratio(group, alone, "tristimulus", "luminance_error") < 1.15
        assert group.tristimulus[..., 1].mean() == pytest.approx(
            alone.tristimulus[..., 1].mean(), rel=0.02
        )


def test_a_mixed_picture_is_that_of_the_dimmed_scene(grouped):
    made = grouped.mixed(LightMix((Level("one", 0.25), Level("rest", is_on=False))))
    dimmed = replace(LAMPS[0], output=replace(LAMPS[0].output, value=0.25 * LAMPS[0].output.value))
    alone = rendered(session_of(*ROOM, GLOW, dimmed), 64)
    assert 0.85 < ratio(made, alone, "tristimulus", "luminance_error") < 1.15
    assert 0.85 < ratio(made, alone, "illuminance", "illuminance_error") < 1.15
    assert made.relative_error > grouped.relative_error
    assert grouped.mixed(LightMix((Level("one"),))) is grouped


def test_the_scene_shines_as_before_afterwards(session):
    plain = rendered(session, 4)
    rendered(session, 4, GROUPS)
    np.testing.assert_array_equal(rendered(session, 4).tristimulus, plain.tristimulus)


def test_the_sum_meets_the_error_of_the_rule(session):
    made = rendered(session, rule=StopRule(error=0.05), groups=GROUPS)
    assert made.relative_error <= 0.05
    # More than asked for, but not by far.
    assert made.relative_error > 0.02
    assert min(group.samples for group in made.groups) >= 8


def test_what_is_said_of_one_group_has_its_name():
    said = cycle(("cells", "paths"))
    shares = [("one", frozenset({"a"})), ("rest", frozenset({"b"}))]
    light = np.ones((2, 2, 3), dtype=np.float32)

    def render(settings, progress):
        fields = {"tristimulus": light, "luminance_error": 0.1 * light[..., 1]}
        return Rendered(fields, settings.rule.samples, {}, ("the same",), (next(said),))

    compiled, settings = SimpleNamespace(shine=lambda *_: None), ViewSettings(StopRule(samples=4))
    made = render_groups(compiled, shares, CAMERA, settings, render)
    assert made.notes == ("the same",)
    assert made.decisions == ("light group one: cells", "light group rest: paths")


def test_groups_can_be_cancelled_and_tell_how_far_they_are(session):
    seen = []

    def follow(state, preview):
        seen.append((state, None if preview is None else preview()))
        if "rest" in state.stage and preview is not None:
            session.cancel()

    with pytest.raises(Cancelled):
        session.render(CAMERA, ViewSettings(StopRule(samples=256), groups=GROUPS), follow)
    assert seen[0][0].stage == "light group one, 1 of 3"
    assert [state.samples for state, _ in seen] == sorted(state.samples for state, _ in seen)
    one, last = seen[0][1], seen[-1][1]
    # The sum so far, not the group alone.
    assert last[..., 1].mean() > 1.5 * one[..., 1].mean()
    off = LightMix((Level("one", is_on=False),))
    settings = ViewSettings(StopRule(samples=4), groups=GROUPS, preview=off)
    seen.clear()
    picture = session.render(CAMERA, settings, lambda state, preview: seen.append(preview()))
    assert seen[0].max() == 0.0
    np.testing.assert_allclose(seen[-1], picture.mixed(off).tristimulus, rtol=1e-5, atol=1e-4)
    assert rendered(session, 4).groups == ()


@pytest.mark.slow
def test_groups_of_all_kinds_of_light_add_up():
    """Luminaires share an emitter, suns and the world another."""
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 900.0), np.array([0.3, 0.2, -1.0]))
    world = UniformWorld(40.0, Blackbody(9000.0))
    luminaires = [
        luminaire("batwing", place=(1.0, 2.0, 2.6), lumens=500.0, key="c"),
        luminaire("lambertian", OPENINGS["ellipse"], (3.0, 2.0, 2.6), lumens=500.0, key="d"),
    ]
    floor = quad("floor", (0, 0, 0), (4, 0, 0), (0, 4, 0), "paint")
    session = session_of(floor, paint(0.5), PANEL, GLOW, sun, world, *luminaires)
    groups = (LightGroup("sky", ("world",)), LightGroup("c", ("c",)), LightGroup("sun", ("sun",)))
    plain = rendered(session, 64)
    made = rendered(session, 128, groups, seed=3)
    assert [group.name for group in made.groups] == ["sky", "c", "sun", "rest"]
    assert 0.85 < ratio(made, plain, "tristimulus", "luminance_error") < 1.15
    assert 0.85 < ratio(made, plain, "illuminance", "illuminance_error") < 1.15
    means = [group.tristimulus[..., 1].mean() for group in made.groups]
    assert min(means) > 0.0


def test_groups_that_make_no_sense_are_refused(session):
    with pytest.raises(SceneError, match="can be in one"):
        rendered(session, 4, (LightGroup("x", ("a",)), LightGroup("y", ("a",))))


def test_a_ray_set_near_a_surface_is_asked_in_the_picture_of_its_own_group_alone():
    lights = (
        lamp_at(np.array([2.0, 2.0, 0.3])),
        luminaire("batwing", place=(1.0, 1.0, 2.5), key="b"),
    )
    session = session_of(*ROOM, paint(0.2, "glow"), *lights)
    made = rendered(session, 64, tuple(LightGroup(each.id, (each.id,)) for each in lights))
    plain = rendered(session, 64, seed=2)
    assert ratio(made, plain, "tristimulus", "luminance_error") == pytest.approx(1.0, abs=0.15)
    assert all(group.tristimulus.any() for group in made.groups[:2])
