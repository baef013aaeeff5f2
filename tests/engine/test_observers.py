"""Luminaires that are seen: pictures, luminance meters and ratings of glare agree with what their file says."""

from types import SimpleNamespace

import numpy as np
import pytest
from luminaires import grid
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.analysis.glare import (
    Observer,
    guth_position_index,
    sight_angles,
    unified_glare_rating,
)
from lumenray.engine.light_mix import GroupLight, Level, LightMix, mix
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.openings import projected_area
from lumenray.engine.luminance_meter import measure_luminance
from lumenray.engine.observers import DARK, rate_mixes, rate_observers
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.distribution import Opening
from lumenray.engine.scene.light import Luminaire, Output, Quantity, UniformWorld
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

EYE = np.array([0.0, 0.0, 1.2])

OPENINGS = {
    "rectangle": Opening("rectangle", (1.2, 0.3, 0.0), "z"),
    "ellipse": Opening("ellipse", (0.5, 0.3, 0.0), "z"),
    "box": Opening("box", (0.6, 0.4, 0.1), "z"),
    "ellipsoid": Opening("ellipsoid", (0.4, 0.4, 0.4), "z"),
    "cylinder": Opening("cylinder", (1.2, 0.1, 0.1), "x"),
}

BATWING = grid(
    np.arange(0.0, 361.0, 15.0),
    np.arange(0.0, 181.0, 2.5),
    lambda c, g: 800.0 * (1.1 + np.cos(g)) * (1.0 + 1.5 * np.sin(g) ** 2 * (1.0 + np.cos(2.0 * c))),
)
"""It shines up and down, unlike along and across. [cd]"""


def hung(opening, place=(0.3, 3.0, 2.8), name="lamp"):
    frame = np.eye(4)
    frame[:3, 3] = place
    output = Output(Quantity.LUMINOUS_FLUX, flux(BATWING), Constant(1.0))
    return Luminaire(name, name, output, frame, BATWING, opening)


def candelas(lamp, eye=EYE):
    """Towards an eye, and the area that the opening shows it."""
    away = eye - lamp.frame[:3, 3]
    return float(intensity(BATWING, away)), float(projected_area(lamp.opening, away))


@pytest.mark.parametrize(
    "shape", [s if s == "box" else pytest.param(s, marks=pytest.mark.slow) for s in OPENINGS]
)
def test_a_luminance_meter_reads_candelas_over_the_area_that_is_seen(shape):
    """A narrow meter on the opening; and a wide one that holds all of it: L times its cone is I over d squared."""
    lamp = hung(OPENINGS[shape])
    session = session_of(lamp)
    towards = lamp.frame[:3, 3] - EYE
    distance = np.linalg.norm(towards)
    candela, area = candelas(lamp)
    rule = StopRule(each=0.003, floor=1e-3)
    narrow = measure_luminance(session, [EYE], [towards], np.deg2rad(0.2), rule)
    assert narrow.luminance[0] == pytest.approx(candela / area, rel=0.01)
    angle = 2.0 * np.arctan(0.75 / distance)
    wide = measure_luminance(session, [EYE], [towards], angle, rule)
    cone = 2.0 * np.pi * (1.0 - np.cos(0.5 * angle))
    # All of it is not quite in one direction: 1.2 m at 3.4 m.
    within = 0.025 if max(lamp.opening.size) > 1.0 else 0.012
    assert wide.luminance[0] * cone == pytest.approx(candela / distance**2, rel=within)


def test_pixels_of_a_picture_have_the_luminance_of_the_file():
    """Each of them by its own direction: a box is seen from below and from its side at once."""
    lamp = hung(OPENINGS["box"], (0.0, 1.5, 2.0))
    session = session_of(lamp)
    forwards = lamp.frame[:3, 3] - EYE
    backwards = -forwards / np.linalg.norm(forwards)
    right = np.cross([0.0, 0.0, 1.0], backwards)
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(backwards, right), backwards], axis=1)
    frame[:3, 3] = EYE
    extent = 0.1
    camera = Camera(frame, Projection.PERSPECTIVE, 16, 16, extent, extent)
    made = session.render(camera, ViewSettings(StopRule(samples=16), 0))
    luminance = made.tristimulus[..., 1]
    middles = extent * ((np.arange(16) + 0.5) / 16 - 0.5)
    across, up = np.meshgrid(middles, middles)
    rays = np.stack([across, up, np.full_like(across, -1.0)], axis=-1) @ frame[:3, :3].T
    expected = intensity(BATWING, -rays) / projected_area(lamp.opening, -rays)
    np.testing.assert_allclose(luminance, expected, rtol=0.005)
    assert expected.max() > 1.005 * expected.min()


@pytest.mark.slow
def test_observers_see_the_glare_that_the_files_tell():
    """CIE 117: four luminaires before an even background of 100 cd/m2, L = I / A, omega = A / d^2."""
    square = Opening("rectangle", (0.6, 0.6, 0.0), "z")
    lamps = [
        hung(square, place, f"lamp {k}")
        for k, place in enumerate(
            [(-1.0, 2.5, 2.8), (1.0, 2.5, 2.8), (-1.0, 4.5, 2.8), (1.0, 4.5, 2.8)]
        )
    ]
    session = session_of(*lamps, UniformWorld(100.0))
    eyes = np.array([EYE, [0.5, -0.5, 1.2]])
    directions = np.array([[0.0, 1.0, 0.0]] * 2)
    found, _ = rate_observers(session, eyes, directions, size=360, samples=16, threshold=500.0)
    for eye, direction, (value, error) in zip(eyes, directions, found["ugr"], strict=True):
        places = np.array([lamp.frame[:3, 3] for lamp in lamps])
        candela, area = np.array([candelas(lamp, eye) for lamp in lamps]).T
        solid = area / ((places - eye) ** 2).sum(axis=1)
        index = guth_position_index(*sight_angles(Observer(eye, direction), places))
        expected = unified_glare_rating(100.0, candela / area, solid, index)
        assert error < 0.3
        assert abs(value - expected) < 0.2 + 2.0 * error
    # Where nothing is as bright there is nothing to rate.
    dark, _ = rate_observers(session, eyes[:1], -directions[:1], size=64, samples=4)
    assert np.isnan(dark["ugr"][0, 0])


class _Dim:
    """Session whose pictures are dark but for some."""

    def __init__(self, *luminances):
        self._left = list(luminances)

    def render(self, camera, settings):
        value = self._left.pop(0)
        origin = SimpleNamespace(notes=(), seconds=0.0)
        picture = np.full((camera.height, camera.width, 3), value)
        return SimpleNamespace(tristimulus=picture, provenance=origin)


def test_observers_in_the_dark_are_not_rated_and_the_others_are():
    eyes, ahead = np.zeros((3, 3)), np.array([[0.0, 1.0, 0.0]] * 3)
    session = _Dim(0.0, 0.0, 0.0, 0.0, 50.0, 50.0, 50.0, 50.0, 50.0, 0.0, 50.0, 50.0)
    found, notes = rate_observers(session, eyes, ahead, size=64, samples=4)
    assert np.isnan(found["ugr"]).all()
    np.testing.assert_allclose(
        found["illuminance"][:, 0], [np.nan, 50.0 * np.pi, np.nan], rtol=0.01
    )
    assert notes == (DARK,)


class _Grouped:
    """Session whose pictures hold a lamp of 3000 cd/m2 and a window of 6000 beside it, in a room that both make less bright.

    A band of the lamp is as bright as 90 000 cd/m2, and the window 2500 at its edge.
    """

    groups = (LightGroup("Lamp", ("lamp",)), LightGroup("Window", ("window",)))

    def render(self, camera, settings):
        rng = np.random.default_rng(settings.seed)
        made = []
        for name, room in (("Lamp", 40.0), ("Window", 70.0)):
            light = room * rng.uniform(0.9, 1.1, (camera.height, camera.width))
            if name == "Lamp":
                light[40:46, 22:32] += 3000.0
                light[42, 24:30] = 90_000.0
            else:
                light[40:46, 33:41] += 6000.0
                light[47, 33:41] = 2500.0
            tristimulus = np.repeat(light[..., None], 3, axis=2).astype(np.float32)
            made.append(GroupLight(name, 8, tristimulus, np.zeros_like(tristimulus[..., 0])))
        origin = SimpleNamespace(notes=(), seconds=0.0)
        return SimpleNamespace(
            groups=made,
            tristimulus=mix(made).tristimulus,
            provenance=origin,
            mixed=lambda levels: mix(made, levels),
        )


def rate_grouped(*mixes):
    eyes, ahead = np.zeros((1, 3)), np.array([[0.0, 1.0, 0.0]])
    made, _ = rate_mixes(_Grouped(), eyes, ahead, _Grouped.groups, mixes, size=64, samples=8)
    return [table["ugr"][0] for table in made]


def test_dimming_all_light_lowers_its_glare_by_eight_decades_of_the_factor():
    """Even where no pixel is as bright as a glare source any more: L_s^2 / L_b goes with the factor."""
    factors = (0.7, 0.3, 0.01)
    mixes = [LightMix((Level("Lamp", f), Level("Window", f))) for f in factors]
    (full, error), *dimmed = rate_grouped(LightMix(), *mixes)
    assert 15.0 < full < 45.0
    for factor, (value, its) in zip(factors, dimmed, strict=True):
        assert value - full == pytest.approx(8.0 * np.log10(factor), abs=1e-4)
        assert its == pytest.approx(error, abs=1e-4)


def test_a_lamp_that_is_dimmed_beside_a_window_does_not_dilute_it():
    """At a thousandth of its flux it is as if it were off, but that its pixels are no background."""
    off, dimmed, lamp = rate_grouped(
        LightMix((Level("Lamp", is_on=False),)),
        LightMix((Level("Lamp", 1e-3),)),
        LightMix((Level("Window", is_on=False), Level("Lamp", 0.1))),
    )
    assert off[0] < dimmed[0] < off[0] + 0.2
    # A lamp alone that is dimmed to 300 cd/m2 is rated too.
    assert np.isfinite(lamp[0])


@pytest.mark.slow
@pytest.mark.mitsuba
def test_glare_of_light_groups_is_that_of_the_lamps_which_shine():
    """Two panels on a ceiling: with one of them off, and one dimmed, as if the scene had been so."""
    from small_scenes import box, paint, session_of

    from lumenray.engine.scene.light import AreaLight, Output, Quantity
    from lumenray.engine.scene.spectrum import Constant

    def panel(name, x, flux):
        frame = np.eye(4)
        frame[:3, 3] = (x, 3.5, 2.79)
        output = Output(Quantity.LUMINOUS_FLUX, flux, Constant(1.0))
        return AreaLight(name, name, output, frame, 0.6, 0.6)

    def rate(groups, mixes, *fluxes):
        lamps = [
            panel(name, x, flux) for name, x, flux in zip("ab", (1.2, 2.8), fluxes, strict=True)
        ]
        session = session_of(box(4.0, 5.0, 2.8), paint(0.5), *lamps)
        return rate_mixes(session, eyes, ahead, groups, mixes, size=64, samples=32)[0]

    eyes, ahead = np.array([[2.0, 0.5, 1.2]]), np.array([[0.0, 1.0, 0.0]])
    groups = (LightGroup("A", ("a",)), LightGroup("B", ("b",)))
    mixes = (
        LightMix(),
        LightMix((Level("A", is_on=False),)),
        LightMix((Level("A", 0.5), Level("B", 2.0))),
    )
    found = rate(groups, mixes, 4000.0, 4000.0)
    for made, fluxes in zip(
        found, ((4000.0, 4000.0), (1e-6, 4000.0), (2000.0, 8000.0)), strict=True
    ):
        (exact,) = rate((), (LightMix(),), *fluxes)
        value, error = made["ugr"][0]
        other, more = exact["ugr"][0]
        assert abs(value - other) < 4.0 * np.hypot(error, more) + 0.05
    assert found[2]["ugr"][0, 0] > found[0]["ugr"][0, 0] + 1.0
