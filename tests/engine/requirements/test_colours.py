"""Whether light needs wavelengths: the bound of doing without, and scenes that must not."""

import numpy as np
import pytest
from small_scenes import box, paint, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.photometry.spectra import (
    GRID,
    evaluate_emission,
    evaluate_reflectance,
    luminous_efficiency,
)
from lumenray.engine.requirements import colours
from lumenray.engine.requirements.decision import Asked
from lumenray.engine.requirements.facts import Facts
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import ImageWorld, Output, PointLight, Quantity
from lumenray.engine.scene.material import (
    Cauchy,
    Coated,
    Dielectric,
    Diffuse,
    Material,
    Mix,
    Toon,
    Transparent,
)
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.scene.spectrum import Constant, Illuminant, Rgb, Tabulated
from lumenray.engine.scene.texture import ImageTexture

PERCENT = Asked(0.01, has_colour=False)


def lamp(spectrum="D65", name="lamp", place=(1.0, 1.0, 1.0)):
    output = Output(Quantity.LUMINOUS_INTENSITY, 100.0, Illuminant(spectrum))
    return PointLight(name, name, output, np.array(place))


def coloured(surface, name="paint"):
    return Material(name, name, surface)


def scene_of(*items):
    scene = Scene()
    scene.apply(SceneDelta(changed=(box(2, 2, 2), *items)))
    return scene


def bound_of(*items):
    return colours.find_bound(Facts(scene_of(*items)))


def test_lamps_of_any_spectra_light_neutral_surfaces_without_wavelengths():
    scene = scene_of(paint(0.7), lamp("A", "a"), lamp("FL11", "b"))
    plan = make_plan(scene, PERCENT)
    assert (plan.spectral, plan.spent) == (False, 0.0)
    assert "neutral" in plan.reasons[0]
    # Colours are another matter.
    assert make_plan(scene, Asked(0.01)).spectral


@pytest.mark.parametrize("name", ["D65", "A", "FL11"])
@pytest.mark.parametrize("walls", [(0.8, 0.79, 0.77), (0.5, 0.48, 0.5), (0.7, 0.4, 0.3)])
def test_the_bound_holds_in_an_integrating_sphere(name, walls):
    """Closed form: light from walls of reflectance r is r / (1 - r) of the direct light, by wavelength."""
    values = evaluate_reflectance(Rgb(*walls), GRID)
    weights = evaluate_emission(Illuminant(name), GRID) * luminous_efficiency()
    weights /= weights.sum()
    mean = weights @ values
    exact, approximate = weights @ (values / (1.0 - values)), mean / (1.0 - mean)
    error = abs(approximate / exact - 1.0)
    bound = bound_of(coloured(Diffuse(Rgb(*walls))), lamp(name))
    assert error < bound
    # And it is no excuse for never doing it.
    assert bound < max(20.0 * error, 1e-5) or walls == (0.7, 0.4, 0.3)


@pytest.mark.mitsuba
def test_stated_errors_hold_what_is_left_out():
    """Sensors in a room of off-white paint, with and without wavelengths."""
    items = box(2, 2, 2), coloured(Coated(Rgb(0.80, 0.79, 0.77))), lamp("A")
    places, up = [[0.5, 0.5, 0.1], [1.5, 1.0, 0.1]], [[0, 0, 1.0]] * 2
    session = session_of(*items)
    made = session.measure(places, up, StopRule(error=0.02), seed=2)
    full = session_of(*items).measure(places, up, StopRule(samples=1 << 15), 3, "spectral")
    assert "alike" in made.provenance.decisions[0]
    assert not made.provenance.variant.startswith("llvm_ad_spectral")
    spent = make_plan(session.scene, Asked(0.02, has_colour=False)).spent
    assert 0.0 < spent <= 0.02 / 3.0
    assert (made.standard_error > spent * made.illuminance).all()
    error = np.hypot(made.standard_error, full.standard_error)
    assert (np.abs(made.illuminance - full.illuminance) < 3.5 * error).all()


def test_of_no_error_nothing_is_spent_and_switches_decide():
    scene = scene_of(coloured(Diffuse(Rgb(0.8, 0.79, 0.77))), lamp())
    assert make_plan(scene, Asked(None, False)).spectral
    plan = make_plan(scene, PERCENT)
    assert not plan.spectral
    assert plan.spent == sum(each.bound for each in plan.decisions) <= plan.allowed
    scene.apply(SceneDelta(changed=(Modelling((("colours", Switch.OFF),)),)))
    assert make_plan(scene, PERCENT).spectral
    scene.apply(SceneDelta(changed=(Modelling((("colours", Switch.FORCE),)),)))
    forced = make_plan(scene, Asked(1e-6, False))
    assert not forced.spectral
    assert forced.spent > forced.allowed
    assert "simplifications: at most" in forced.reasons[-1]


OFF_WHITE = Rgb(0.8, 0.79, 0.77)

RED, GREEN = Rgb(0.7, 0.1, 0.1), Rgb(0.1, 0.7, 0.1)

LINES = Tabulated(
    np.array([500.0, 540.0, 541.0, 600.0, 601.0, 640.0]), np.array([0.3, 0.3, 0.7, 0.7, 0.3, 0.3])
)


@pytest.mark.parametrize(
    "items",
    [
        # What these send on is not in proportion to their reflectance.
        (coloured(Diffuse(OFF_WHITE, roughness=0.3)), lamp()),
        (coloured(Coated(Constant(0.5), tint=OFF_WHITE)), lamp()),
        (coloured(Toon(OFF_WHITE)), lamp()),
        # Light may pass any number of sheets before it has met anything.
        (coloured(Transparent(OFF_WHITE)), lamp()),
        # A sheet of which nearly all light goes on, to one side or the other.
        (coloured(Diffuse(Rgb(0.49, 0.48, 0.46), Rgb(0.49, 0.48, 0.46))), lamp()),
        # Light between red and green walls is nearly nothing, whatever each reflects by itself.
        (coloured(Mix(Diffuse(RED), Diffuse(GREEN), 0.5)), lamp()),
        (coloured(Diffuse(Rgb(0.5, 0.3, 0.2))), lamp()),
        # The reflectance under each lamp is another, and none is that of their mean.
        (coloured(Diffuse(LINES)), lamp("FL11", "a"), lamp("A", "b")),
        # Glass that sends colours into other directions.
        (coloured(Dielectric(Cauchy(1.5, 0.01))), lamp()),
        # Light whose colour goes with its direction, on coloured walls.
        (
            coloured(Diffuse(Rgb(0.8, 0.79, 0.77))),
            ImageWorld(
                ImageTexture(np.full((4, 8, 3), 1.0, np.float32) * np.float32([1, 0.5, 0.2])), 1e2
            ),
        ),
        # What a picture holds is not bounded.
        (
            coloured(Diffuse(ImageTexture(np.float32([[[0.8, 0.79, 0.77], [0.8, 0.79, 0.76]]])))),
            lamp(),
        ),
    ],
)
def test_scenes_that_need_wavelengths_get_them(items):
    assert make_plan(scene_of(*items), PERCENT).spectral


def test_paths_of_many_reflections_widen_the_bound():
    """White walls that are hardly coloured make light very yellow in the end."""
    dark, bright = (bound_of(coloured(Diffuse(Rgb(x, x, x - 0.02))), lamp()) for x in (0.3, 0.95))
    assert bright > 5.0 * dark
    assert bound_of(coloured(Diffuse(Rgb(0.99, 0.99, 0.9))), lamp()) > 0.01


SPECTRA = ("D65", "A", "FL11", "FL2")


def painted(colours_, lamps):
    """Scene with a surface of every colour, and lamps of spectra by name."""
    scene = Scene()
    items = []
    for k, colour in enumerate(colours_):
        one = np.array([[0, 1, 2]], np.int32)
        items += [
            Mesh(f"m{k}", f"m{k}", np.eye(3), one, (f"p{k}",), np.zeros(1, np.int32)),
            coloured(Diffuse(colour), f"p{k}"),
        ]
    scene.apply(SceneDelta(changed=(*items, *(lamp(name, name) for name in lamps))))
    return scene


def exchange(forms, direct, colours_, lamps):
    """Irradiance of patches that light each other, with wavelengths and without. (l, n) -> (n,), (n,)"""
    values = np.stack([evaluate_reflectance(colour, GRID) for colour in colours_])
    weights = [evaluate_emission(Illuminant(name), GRID) * luminous_efficiency() for name in lamps]
    weights = np.array([weight / weight.sum() for weight in weights])
    photometric = values @ (direct.sum(axis=1) @ weights / direct.sum())
    solve, unit = np.linalg.solve, np.eye(len(forms))
    exact = 0.0
    for own, weight in zip(direct, weights, strict=True):
        systems = unit - forms[None] * values.T[:, None]
        exact += weight @ solve(systems, np.broadcast_to(own, (471, len(own)))[..., None])[..., 0]
    return exact, solve(unit - forms * photometric[None], direct.sum(axis=0))


def test_the_bound_holds_for_all_light_between_surfaces_of_many_colours():
    """Radiosity of patches with random form factors, paints and lamps: the mean over all light, in closed form."""
    draw, ratios = np.random.default_rng(5), []
    for _ in range(60):
        count = int(draw.integers(2, 9))
        apart = 10.0 ** draw.uniform(-3.0, -0.5, 1)
        paints = np.clip(
            draw.uniform(0.05, 0.9, (count, 1)) * (1 + apart * draw.normal(size=(count, 3))),
            0.01,
            0.95,
        )
        paints = [Rgb(*map(float, each)) for each in paints]
        lamps = list(draw.choice(SPECTRA, int(draw.integers(1, 4)), replace=False))
        bound = colours.find_bound(Facts(painted(paints, lamps)))
        if not np.isfinite(bound):
            continue
        openings = draw.exponential(size=(count, count)) ** draw.uniform(0.5, 4.0)
        openings += openings.T
        areas = openings.sum(axis=1)
        direct = draw.exponential(size=(len(lamps), count)) ** 3
        exact, approximate = exchange(openings / areas[:, None], direct, paints, lamps)
        error = abs((areas @ exact) / (areas @ approximate) - 1.0)
        assert error <= bound + 1e-12
        ratios.append(bound / max(error, 1e-9))
    assert len(ratios) > 30
    assert np.median(ratios) < 1000.0


def test_light_that_comes_late_has_a_bound_of_its_own():
    """A row of patches of which each sees its neighbours alone: what comes to the last has met all others."""
    count = 12
    forms = 0.5 * (np.eye(count, k=1) + np.eye(count, k=-1))
    paints, lamps = [OFF_WHITE] * count, ["A"]
    direct = np.eye(1, count)
    exact, approximate = exchange(forms, direct, paints, lamps)
    facts = Facts(painted(paints, lamps))
    bound, late = colours.find_bound(facts), colours.find_late(facts)
    error = abs(exact[-1] / approximate[-1] - 1.0)
    assert error > bound
    assert late[0].reflections < count <= late[1].reflections
    assert error < bound + late[1].more
    # Maps do not find out, so that theirs has to hold wherever light comes late.
    in_maps = colours.find_bound(facts, colours.ALREADY_IN_MAPS)
    assert error < in_maps
    for share, spent in ((1.5, 0.0), (4.5, in_maps)):
        asked = Asked(share * in_maps, False, frozenset({"m0"}))
        assert make_plan(facts.scene, asked).spent == spent
    assert make_plan(facts.scene, Asked(0.1, False)).spent == bound


def corridor(turns):
    """Walls of a corridor of 1 m that goes to and fro, and the middle of its end."""
    half = 0.1
    width, length = 1.0, 2.0
    total = turns * (width + half)
    parts = [box(total + half, length, 1.0)]
    for k in range(1, turns):
        # Walls from one side, which leave a gap of a corridor's width at the other.
        x = k * (width + half) - half
        low = 0.0 if k % 2 else width
        wall = box(half, length - width, 1.0, inwards=False)
        parts.append(
            Mesh(
                f"wall{k}",
                f"wall{k}",
                wall.vertices + np.array([x, low, 0.0]),
                wall.triangles,
                ("paint",),
                wall.material_index,
            )
        )
    end = [total - 0.6 * width, 0.5 * length, 0.01]
    return parts, end


@pytest.mark.slow
@pytest.mark.mitsuba
def test_sensors_find_that_light_reaches_them_late():
    """At the end of a corridor that goes to and fro photometric light is off by more than its bound elsewhere."""
    parts, end = corridor(3)
    yellow = coloured(Diffuse(Rgb(0.85, 0.8, 0.5)))
    forced = Modelling((("colours", Switch.FORCE),))
    items = (*parts, yellow, lamp("A", place=(0.5, 0.5, 0.8)))
    places, up, rule = [end, [0.5, 1.5, 0.01]], [[0, 0, 1.0]] * 2, StopRule(samples=1 << 16)
    session = session_of(*items, forced)
    bound = make_plan(session.scene, PERCENT).spent
    made = session.measure(places, up, rule, seed=2)
    assert sum("reaches 1 sensors after so many" in each for each in made.provenance.notes) == 1
    full = session_of(*items).measure(places, up, rule, 3, "spectral")
    off = np.abs(made.illuminance / full.illuminance - 1.0)
    stated, noise = (each.standard_error / each.illuminance for each in (made, full))
    assert off[0] - 2.0 * noise[0] > bound
    assert (off < stated + 2.0 * noise).all()
    assert stated[0] > 2.0 * bound
    assert stated[1] == pytest.approx(bound, rel=0.1)
