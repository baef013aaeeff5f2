"""Maps with known suns: illuminance kept, directions, shadows, times and suns that are rebuilt."""

from datetime import UTC, datetime
from functools import partial

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.environment.extraction import clip_sources
from ...engine.environment.repair import (
    choose_time,
    find_sun_of,
    find_times,
    find_tolerance,
    rebuild_sun,
)
from ...engine.environment.sources import find_sources
from ...engine.scene.light import CieSky, Output, Quantity, SunLight
from ...engine.scene.material import Black, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.scene.texture import ImageTexture
from ...engine.session import Session
from ...engine.sky.availability import usual_illuminance
from ...engine.sky.picture import find_illuminance
from ...engine.sky.place import Place, find_zone
from ...engine.sky.skies import find_luminances
from ...engine.sky.solar_position import RADIUS, find_sun
from ...engine.sky.sunlight import direct_illuminance
from .drawn_maps import Spot, make_map

HEIGHT = 1024
"""Of the maps. [pixel]"""

CLIPS = (None, 5000.0, 500.0, 50.0)
"""Largest values that are kept, over the sky's 1; None: nothing is clipped."""

MAPS = {
    "a sun": (Spot(52.0, 140.0, illuminance=12.0),),
    "two suns": (Spot(40.0, 100.0, illuminance=6.0), Spot(35.0, 250.0, illuminance=4.0)),
    "a sun on the map's border": (Spot(35.0, 270.0, illuminance=12.0),),
    "a sun over the pole": (Spot(89.9, 30.0, illuminance=12.0),),
    "a low sun": (Spot(4.0, 200.0, illuminance=12.0),),
    "a lamp that is no sun": (Spot(60.0, 200.0, 5.0, 3.0),),
    "none": (),
}
"""Disks over an even sky of 1 and a ground of 0.2."""

UP = np.array([0.0, 0.0, 1.0])

PLACES = (
    Place(52.52, 13.405, "Europe/Berlin", 34.0),
    Place(-33.87, 151.21, "Australia/Sydney", 20.0),
    Place(1.35, 103.82, "Asia/Singapore", 15.0),
    Place(64.15, -21.94, "Atlantic/Reykjavik", 40.0),
)

NEAR_NOON = 5400.0
"""Times nearer to noon than this are listed by themselves: there the height says little. [s]"""

LOW_SUN = 10.0
"""Suns lower than this are listed alone: their light changes by more than 5 % a degree, and a clipped pixel is off by half
of one. [degree]"""

LIMB = 0.6
"""Darkening of the sun at its limb. [-]"""


def measure_maps(say) -> list[dict]:
    """Extract the sources of all maps at all levels of clipping."""
    rows = []
    for name, spots in MAPS.items():
        for clip in CLIPS:
            image = ImageTexture(make_map(HEIGHT, spots, clip=clip))
            image.pixels.flags.writeable = False
            rows.append({"map": name, "clip": clip, **_measure_map(image, spots)})
            say(f"{name}, clip {clip}: {rows[-1]['error_percent']:.2e} % off")
    return rows


def _measure_map(image: ImageTexture, spots) -> dict:
    search, clipped = find_sources(image), clip_sources(image)
    before, after = (find_illuminance(each, np.eye(3), UP) for each in (image, clipped))
    after += sum(source.on(UP) for source in search.sources)
    off = [
        min((_angle(spot.towards, each.towards) for each in search.sources), default=180.0)
        for spot in spots
    ]
    return {
        "expected": len(spots),
        "found": len(search.sources),
        "has_sun": find_sun_of(search) is not None,
        "error_percent": 100.0 * abs(after / before - 1.0),
        "direction_deg": max(off, default=0.0),
    }


def _angle(first, second) -> float:
    """Angle between unit vectors. [degree]"""
    return float(np.degrees(2.0 * np.arcsin(min(0.5 * np.linalg.norm(first - second), 1.0))))


# ---- shadows ----


def measure_shadow(say) -> dict:
    """Illuminance by an extracted sun across the shadow of an edge, against the closed form for the disk of the sun.

    The sun stands in the zenith over a plate whose edge is 10 m above the sensors.
    """
    spot = Spot(90.0, 0.0, illuminance=12.0)
    image = ImageTexture(make_map(HEIGHT, [spot], clip=5000.0))
    (source,) = find_sources(image).sources
    height, angle = 10.0, np.radians(2.0 * RADIUS)
    half = height * np.tan(0.5 * angle)
    across = np.linspace(-1.5, 1.5, 31) * half
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), -source.towards, angle, LIMB)
    corners = np.array(
        [[0, -50, height], [100, -50, height], [100, 50, height], [0, 50, height]], float
    )
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    plate = Mesh("plate", "plate", corners, faces, ("black",), np.zeros(2, np.int32))
    session = Session(witness=False)
    session.apply(SceneDelta(changed=(sun, plate, Material("black", "black", Black()))))
    places = np.stack([across, np.zeros_like(across), np.zeros_like(across)], axis=1)
    made = session.measure(places, np.tile(UP, (len(across), 1)), StopRule(samples=1 << 16))
    # The sensor sees the part of the disk beyond the edge, which is on the side of +x.
    shift = height * source.towards[0] / source.towards[2]
    expected = np.array([_part_below(-(x + shift) / half) for x in across])
    seen = made.illuminance / (1000.0 * source.towards[2])
    rising = np.maximum.accumulate(seen[::-1])
    edges = np.interp([0.01, 0.99], rising, across[::-1])
    row = {
        "largest_difference": float(np.abs(seen - expected).max()),
        "standard_error": float(made.standard_error.max() / 1000.0),
        "width_over_disk": float(abs(edges[1] - edges[0]) / (2.0 * half)),
    }
    say(f"shadow of an edge: {row['largest_difference']:.4f} off at most")
    return row


def _part_below(t: float) -> float:
    """Part of a limb-darkened disk's light from x below ``t`` radii."""
    node, weight = np.polynomial.legendre.leggauss(200)
    upper = float(np.clip(t, -1.0, 1.0))
    x = -1.0 + 0.5 * (upper + 1.0) * (node + 1.0)
    # Across the disk at x: sqrt(1 - x^2) either way, of a profile 1 - k (1 - sqrt(1 - x^2 - y^2)).
    chord = np.sqrt(np.maximum(1.0 - x**2, 0.0))
    line = 2.0 * chord * (1.0 - LIMB) + LIMB * 0.5 * np.pi * chord**2
    whole = np.pi * (1.0 - LIMB / 3.0)
    return float((line * weight).sum() * 0.5 * (upper + 1.0) / whole)


# ---- suns mended ----


def measure_repair(say, count: int = 24) -> list[dict]:
    """Draw clear skies with their suns, clipped, for random moments of places, and find time and sun again."""
    rng, rows = np.random.default_rng(29), []
    while len(rows) < count:
        place = PLACES[len(rows) % len(PLACES)]
        month, day, hour = int(rng.integers(1, 13)), int(rng.integers(1, 28)), 24.0 * rng.random()
        seconds = datetime(2026, month, day, tzinfo=UTC).timestamp() + 3600.0 * hour
        sun = find_sun(seconds, place)
        if not 5.0 < float(sun.elevation) < 85.0:
            continue
        rows.append(_mend(rng, place, seconds, sun))
        say(
            f"moment {len(rows)}: {rows[-1]['minutes']:.2f} minutes, {rows[-1]['sun_percent']:.3f} %"
        )
    return rows


def _mend(rng, place: Place, seconds: float, sun) -> dict:
    elevation, turn = float(sun.elevation), 360.0 * rng.random()
    spot = Spot(elevation, turn, illuminance=1e-3 * direct_illuminance(elevation, 3.0))
    sky = CieSky(12, spot.towards, usual_illuminance("clear", elevation))
    clip = float(rng.choice([200.0, 2000.0, 20000.0]))
    image = ImageTexture(make_map(HEIGHT, [spot], partial(_thousandth, sky), 0.5, clip))
    image.pixels.flags.writeable = False
    source = find_sources(image).sources[0]
    height = float(np.degrees(np.arcsin(source.core[2])))
    day = datetime.fromtimestamp(seconds, tz=find_zone(place.zone))
    tolerance = find_tolerance(HEIGHT)
    times = find_times(height, place, day.year, day.month, day.day, False, tolerance)
    found = choose_time(times, float(sun.solar_time) < 12.0)
    picked = Spot(float(rng.uniform(20.0, 70.0)), turn + float(rng.uniform(60.0, 300.0)))
    made = rebuild_sun(image, source.core, picked.towards, tolerance=tolerance)
    bounds = [each.timestamp() for each in (found.first, found.last)]
    return {
        "latitude": place.latitude,
        "elevation_deg": elevation,
        "clip": clip,
        "from_noon_s": abs(float(sun.solar_time) - 12.0) * 3600.0,
        "minutes": abs(found.seconds - seconds) / 60.0,
        "width_minutes": (bounds[1] - bounds[0]) / 60.0,
        "is_within": bounds[0] <= seconds <= bounds[1],
        "sun_percent": 100.0 * abs(made.illuminance / spot.illuminance - 1.0),
        "spread_percent": 100.0 * made.spread,
    }


def _thousandth(sky: CieSky, directions):
    return 1e-3 * find_luminances(sky, directions)
