"""Aims: where the light of a bent light seems to come from, by the lines on which a pilot's light arrives."""

from dataclasses import dataclass, replace

import numpy as np

from .emission_rays import IDEAL, SUN, EmissionRays, TracedLight
from .light_paths import send_pilot

PILOT = 1 << 17
"""Paths that tell by which lines light arrives."""

MOST_PARTS, ALL_PARTS, FEWEST_PARTS = 32, 64, 4
"""Most parts of one light's lines with an aim each; of all lights' together, about; and of one light in any case."""

LEAST_SHARE = 1e-4
"""Share of all bent light below which a light's is left out of account. [-]"""

LEAST_PART = 3e-3
"""Share of a light's below which a part of its lines is not parted again. [-]"""

NARROW = 0.03
"""Angle within which a light seems to be in one place for all that are lit, so that it needs but one aim. [rad]"""

FEWEST_LINES, MOST_LINES = 32, 1 << 14
"""Lines that an aim is made of, at least, and those of a light that are looked at."""

POINT_SIZE = 0.01
"""Radius for which an ideal point is taken, relative to its distance from what bends its light. [-]"""

SUN_RADIUS = 0.00465
"""Angular radius for which suns that have less are taken: that of the true one. [rad]"""

QUANTILES = (0.5, 0.99)
"""Shares of the light within the inner and the outer cone of an aim. [-]"""

SPARE = 1.1
"""By which aims are larger than what the pilot saw. [-]"""

PLACE, DIRECTION = 0, 1
"""What an aim is: a place where light seems to come from, or a direction."""


@dataclass(frozen=True)
class Aim:
    """Where light of one source that comes from a part of what bends it seems to come from.

    Parameters
    ----------
    flux : float    That the pilot saw land. [lm]
    kind : int    `PLACE` or `DIRECTION`.
    centre : (3,) array    Place in the scene's frame [m], or unit vector towards the light.
    sizes : (2,) array    Radii about the place [m], or 1 - cos of angles about the direction, by `QUANTILES`.
    sphere : (4,) array    Holds all places where this light leaves for where it lands; in the end those of all of a light's
        aims. [m]
    spread : float    Angle within which it seems to come from there. [rad]
    along : (3,) array    Unit vector by which it goes to a place where it is gathered, before which it comes from the other
        side; 0 where the place lies behind, as images in bulbs and convex mirrors do.
    """

    flux: float
    kind: int
    centre: np.ndarray
    sizes: np.ndarray
    sphere: np.ndarray
    spread: float
    along: np.ndarray


@dataclass(frozen=True)
class AimedLight:
    """A light and its aims. ``size``: radius of an ideal point [m], or 1 - cos of the angular radius of a sun."""

    light: TracedLight
    name: str
    flux: float
    size: float
    aims: tuple[Aim, ...]


@dataclass(frozen=True)
class Lines:
    """Last lines on which light arrives at what it lights, of the pilot's paths.

    Parameters
    ----------
    start, end : (m, 3) array    Where they leave what bends them, and where they land, in the scene's frame. [m]
    light : (m,) array    Places of their lights among those that are aimed at.
    """

    start: np.ndarray
    end: np.ndarray
    light: np.ndarray


def find_aimed_lights(scene, rays: EmissionRays, sampler) -> tuple[list[AimedLight], Lines]:
    """Trace all lights and see where they seem to be; those that give most first, and the lines of all."""
    landed = send_pilot(scene, rays, sampler, PILOT)
    names = {id(source): name for name, source in scene.named_sources()}
    total, made = max(float(landed["flux"].sum()), 1e-300), []
    parts = int(np.clip(ALL_PARTS // len(rays.lights), FEWEST_PARTS, MOST_PARTS))
    for number, light in enumerate(rays.lights):
        own = landed["light"] == number
        lines = {name: values[own] for name, values in landed.items()}
        flux = float(lines["flux"].sum())
        if flux <= LEAST_SHARE * total:
            continue
        name = "sun" if light.source is None else names.get(id(light.source), "light")
        size = _size_of(light, lines, scene)
        few = {key: values[:MOST_LINES] for key, values in lines.items()}
        few["flux"] = few["flux"] * (flux / few["flux"].sum())
        aims = tuple(_find_aims(light, few, size, scene.radius, parts))
        made.append((AimedLight(light, name, flux, size, aims), lines))
    made.sort(key=lambda each: -each[0].flux)
    if not made:
        return [], Lines(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, dtype=int))
    return [aimed for aimed, _ in made], join_lines([lines for _, lines in made])


def join_lines(of_lights: list[dict]) -> Lines:
    """Lines of all lights together, see `light_paths.send_pilot`."""
    start, direction, way = (
        np.concatenate([lines[name] for lines in of_lights])
        for name in ("start", "direction", "way")
    )
    number = np.repeat(np.arange(len(of_lights)), [len(lines["way"]) for lines in of_lights])
    return Lines(start, start + direction * way[:, None], number)


def _size_of(light: TracedLight, lines: dict, scene) -> float:
    """What an ideal light is taken for: radius of a sphere [m], or 1 - cos of a sun's angular radius; 0 for surfaces."""
    if light.start == SUN:
        cap = float(np.array(scene.surroundings.suns[light.number][2]).ravel()[0])
        return max(cap, 2.0 * np.sin(0.5 * SUN_RADIUS) ** 2)
    return (
        POINT_SIZE * _quantile(lines["reach"], lines["flux"], 0.1) if light.start == IDEAL else 0.0
    )


def _find_aims(light: TracedLight, lines: dict, size: float, radius: float, most: int):
    """Aims of a light by the lines on which its light arrives, see `light_paths.send_pilot`.

    Lines are parted again and again, by where they begin or by where they go, until each part seems to come from one place.
    """
    whole = _aim_of(light, lines, size, radius)
    parts, done = [(whole, lines)], []
    while parts:
        aim, own = parts.pop(int(np.argmax([aim.flux * aim.spread**2 for aim, _ in parts])))
        halves = None
        if aim.spread > NARROW and len(parts) + len(done) + 2 <= most:
            halves = _part(light, own, size, radius)
        if halves is None or aim.flux < LEAST_PART * whole.flux:
            done.append(aim)
        else:
            parts += halves
    for aim in done:
        yield replace(aim, sphere=whole.sphere)


def _part(light: TracedLight, lines: dict, size: float, radius: float) -> list | None:
    """Two parts of lines with their aims, by where they differ most; None where that is no gain."""
    best, least = None, np.inf
    weight = lines["flux"] / lines["flux"].sum()
    for name in ("direction", "start"):
        away = lines[name] - weight @ lines[name]
        _, axes = np.linalg.eigh(away.T @ (weight[:, None] * away))
        is_high = away @ axes[:, -1] > 0.0
        if min(is_high.sum(), (~is_high).sum()) < FEWEST_LINES:
            continue
        made = []
        for half in (is_high, ~is_high):
            own = {key: values[half] for key, values in lines.items()}
            made.append((_aim_of(light, own, size, radius), own))
        square = sum(aim.flux * aim.spread**2 for aim, _ in made)
        if square < least:
            best, least = made, square
    return best


def _aim_of(light: TracedLight, lines: dict, size: float, radius: float) -> Aim:
    """Place or direction that lines of light share best. ``radius``: of the scene. [m]"""
    weight = lines["flux"] / lines["flux"].sum()
    start, direction = lines["start"], lines["direction"]
    mean = weight @ direction
    mean /= max(np.linalg.norm(mean), 1e-300)
    chords = np.linalg.norm(direction - mean, axis=1)
    middle = weight @ start
    away = start - middle
    along = (away * direction).sum(axis=1)
    # The point that all lines pass as closely as possible; parallel ones do not tell it.
    system = np.eye(3) * (1.0 + 1e-9) - direction.T @ (weight[:, None] * direction)
    centre = middle + np.linalg.solve(system, weight @ away - (weight * along) @ direction)
    off = centre - start
    apart = np.linalg.norm(off - (off * direction).sum(axis=1)[:, None] * direction, axis=1)
    landing = start + direction * lines["way"][:, None]
    seen = apart / np.maximum(np.linalg.norm(landing - centre, axis=1), 1e-30)
    spreads = [_quantile(each, weight, QUANTILES[1]) for each in (seen, chords)]
    kind = PLACE if spreads[0] <= spreads[1] else DIRECTION
    # What is taken for larger than it is seems larger too.
    extra = 0.0
    if light.start == SUN and kind == DIRECTION:
        extra = np.sqrt(2.0 * size)
    elif light.start == IDEAL and kind == PLACE:
        extra = 2.0 * size
    values = apart if kind == PLACE else chords
    sizes = np.array([SPARE * _quantile(values, weight, q) + extra for q in QUANTILES])
    sizes = np.maximum(sizes, 1e-6 * radius if kind == PLACE else 1e-6)
    if kind == DIRECTION:
        sizes = np.minimum(0.5 * sizes**2, 2.0)
    low, high = start.min(axis=0), start.max(axis=0)
    ball = 0.5 * (low + high)
    reach = SPARE * float(np.linalg.norm(start - ball, axis=1).max()) + 1e-5 * radius
    return Aim(
        float(lines["flux"].sum()),
        kind,
        centre if kind == PLACE else -mean,
        sizes,
        np.append(ball, reach),
        min(spreads),
        mean if weight @ (off * direction).sum(axis=1) > 0.0 else np.zeros(3),
    )


def _quantile(values, weight, share: float) -> float:
    order = np.argsort(values, kind="stable")
    held = np.cumsum(weight[order])
    return float(values[order][min(np.searchsorted(held, share * held[-1]), len(order) - 1)])
