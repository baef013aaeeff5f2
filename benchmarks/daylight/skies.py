"""Skies beside those of Radiance: `gensky` (clear, intermediate, overcast) and `gendaylit` (hours by the model of Perez).

What is compared are the formulas that the two programs hand to a scene, with the numbers they print, evaluated by Radiance's
`rcalc` at the middles of cells of half a degree. Near the horizon the files mix a formula with the ground's brightness, a
smoothing that no sky has; it is left out, as `gendaymtx` leaves it out. Both sides are brought to the same level, by the
same sum over the cells, before luminances are compared.

`gendaylit` levels its sky by a plain mean over 145 directions and not by the integral, so that its sky gives another
horizontal illuminance than it was told. So three numbers are told of illuminances: what it aims at, found by its own mean,
against ours; and what its sky gives by the sum over the cells, over what it aims at, which is its own shortfall.

The CIE has no intermediate sky (its general skies of S 011 took the place of that formula). Here it is a sky by a table:
luminances every degree, as they would be measured, against the formula between them.
"""

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.scene.light import CieSky, ImageWorld, PerezSky
from ...engine.sky.cie import CLEAR, OVERCAST, sun_direction
from ...engine.sky.measured import SkyGrid, make_grid_world
from ...engine.sky.perez import find_class, find_daylight
from ...engine.sky.picture import find_illuminance
from ...engine.sky.skies import find_luminances
from ...engine.sky.weather import Weather, find_hours
from ..common.radiance import run_program

HOURS = 20
"""That are compared with gendaylit."""

ELEVATION, AZIMUTH = 50.0, 210.0
"""Of the sun in the skies of gensky, on a place of the table of the intermediate one. [degree]"""

ROWS, COLUMNS = 180, 720
"""Cells above the horizon."""

DIM = 0.01
"""Luminances below this share of the mean are compared as if they were as bright. [-]"""

WATER = 20.0
"""That gendaylit knows no other amount of. [kg/m2]"""

SUN_RADIUS = 0.2665
"""Of the disk that gendaylit divides the sun's illuminance by. [degree]"""

DAY_ZERO = 1.00011 + 0.034221 * np.cos(2 * np.pi / 365) - 0.00128 * np.sin(2 * np.pi / 365)
DAY_ZERO += 0.000719 * np.cos(4 * np.pi / 365) - 0.000077 * np.sin(4 * np.pi / 365)
"""Inverse square of the sun's distance that gendaylit takes where no date is stated."""

PATCH_ROWS = ((6, 30), (18, 30), (30, 24), (42, 24), (54, 18), (66, 12), (78, 6), (90, 1))
"""Elevation of a row of the 145 directions [degree], and their number; the first is at the sun's azimuth."""

GENSKY = {
    "clear": ("+s", "sunnysky", CLEAR),
    "intermediate": ("+i", "intersky", None),
    "overcast": ("-c", "cloudysky", OVERCAST),
}
"""Option, name of the formula, and type of the CIE."""

CLASSES = (
    (1.02, 190.0),
    (1.15, 260.0),
    (1.36, 240.0),
    (1.72, 210.0),
    (2.35, 170.0),
    (3.60, 130.0),
    (5.30, 100.0),
    (8.00, 75.0),
)
"""Clearness and diffuse irradiance [W/m2] of the built-in hours, a pair for each of the model's classes."""

ELEVATIONS = (12.0, 33.0, 61.0, 20.0, 47.0, 74.0, 8.0)
"""Of the sun in the built-in hours, in turn. [degree]"""


@dataclass(frozen=True)
class Hour:
    """Sun [degree] and irradiances [W/m2] of an hour. ``azimuth``: from north over east."""

    elevation: float
    azimuth: float
    direct: float
    diffuse: float


def measure_skies(weather: Weather | None = None, say=lambda text: None) -> dict:
    """Compare skies.

    Parameters
    ----------
    weather : Weather or None    Whose hours are taken; None: the built-in ones.
    say : callable    Told of every sky.

    Returns
    -------
    dict    ``gensky`` by name and ``gendaylit``, a list by hour: rows with ``luminance``: largest difference after
        levelling, ``illuminance``: difference of the horizontal illuminances, ``given``: what Radiance's sky gives over
        what it aims at; hours have ``sun`` too, the difference of the illuminances by the sun, and their numbers. [-]

    Raises
    ------
    LumenrayError    Radiance is not installed, or refuses.
    """
    directions, weights = cells()
    made = {"gensky": {}, "gendaylit": []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for key in GENSKY:
            row = _compare_gensky(folder, key, directions, weights)
            made["gensky"][key] = row
            say(f"sky: gensky {key}: {_tell(row)}")
        for hour in built_in_hours() if weather is None else weather_hours(weather):
            row = _compare_gendaylit(folder, hour, directions, weights)
            made["gendaylit"].append(row)
            say(f"sky: gendaylit, class {row['class']}: {_tell(row)}")
    return made


def largest_difference(made: dict) -> float:
    """Largest of all differences between gendaylit's hours and ours. [-]"""
    return max(
        abs(row[key]) for row in made["gendaylit"] for key in ("luminance", "illuminance", "sun")
    )


def built_in_hours() -> list[Hour]:
    """Hours of every class of the model under suns of several heights."""
    hours = []
    for k in range(HOURS):
        clearness, diffuse = CLASSES[k % len(CLASSES)]
        elevation = ELEVATIONS[k % len(ELEVATIONS)]
        cubed = 1.041 * np.radians(90.0 - elevation) ** 3
        # A low sun leaves less of the sky too.
        diffuse *= 0.35 + 0.65 * np.sin(np.radians(elevation))
        direct = (clearness - 1.0) * (1.0 + cubed) * diffuse
        hours.append(
            Hour(elevation, (80.0 + 37.0 * k) % 360.0, round(direct, 2), round(diffuse, 2))
        )
    return hours


def weather_hours(weather: Weather, count: int = HOURS, seed: int = 1993) -> list[Hour]:
    """Hours of a weather file, as many of each class of the model as there are."""
    hours = find_hours(weather, None if weather.year.all() else 2001)
    sun, rng = hours.sun, np.random.default_rng(seed)
    is_usable = (sun.elevation > 5.0) & (sun.elevation < 87.0) & (hours.diffuse_horizontal > 0.0)
    is_usable &= np.isfinite(hours.direct_normal)
    found = find_daylight(
        np.where(is_usable, hours.direct_normal, 0.0),
        np.where(is_usable, hours.diffuse_horizontal, 1.0),
        sun.elevation,
        WATER,
        sun.distance,
    )
    kinds = find_class(found.clearness)
    queues = [rng.permutation(np.flatnonzero(is_usable & (kinds == kind))) for kind in range(8)]
    chosen = [queue[k] for k in range(count) for queue in queues if k < len(queue)][:count]
    return [
        Hour(
            float(sun.elevation[i]),
            float(sun.azimuth[i]),
            float(hours.direct_normal[i]),
            float(hours.diffuse_horizontal[i]),
        )
        for i in sorted(chosen)
    ]


def cells() -> tuple[np.ndarray, np.ndarray]:
    """Middles of the cells above the horizon (n, 3), and what they add to a horizontal illuminance (n,). [sr]"""
    height = (np.arange(ROWS) + 0.5) * 0.5 * np.pi / ROWS
    edges = np.sin(np.arange(ROWS + 1) * 0.5 * np.pi / ROWS) ** 2
    turn = 2.0 * np.pi * (np.arange(COLUMNS) + 0.5) / COLUMNS
    directions = np.stack(
        np.broadcast_arrays(
            np.cos(height)[:, None] * np.sin(turn),
            np.cos(height)[:, None] * np.cos(turn),
            np.sin(height)[:, None],
        ),
        axis=-1,
    )
    weights = np.repeat(0.5 * np.diff(edges) * 2.0 * np.pi / COLUMNS, COLUMNS)
    return directions.reshape(-1, 3), weights


# ---- gensky ----


def _compare_gensky(folder: Path, key: str, directions, weights) -> dict:
    option, formula, kind = GENSKY[key]
    asked = 100.0
    text = run_program(
        folder, "gensky", "-ang", f"{ELEVATION:g}", f"{AZIMUTH - 180.0:g}", option, "-B", f"{asked:g}", "-g", "0"
    ).decode()  # fmt: skip
    numbers = [float(word) for word in text.split("skybright.cal")[1].split()[2:]]
    theirs = evaluate(folder, "skybright.cal", formula, numbers, directions)
    towards = sun_direction(np.radians(ELEVATION), np.radians(AZIMUTH))
    given = float(weights @ theirs)
    if kind is None:
        world = _table_of(folder, formula, numbers)
        ours, stated = (
            look_up(world, directions),
            find_illuminance(world.image, world.rotation, (0, 0, 1)),
        )
    else:
        sky = CieSky(kind, towards, given)
        ours, stated = find_luminances(sky, directions), sky.illuminance
    # Whatever level a sky was asked for, its illuminance is that of its luminances.
    return {
        "luminance": difference(ours / (weights @ ours), theirs / given),
        "illuminance": float(stated / (weights @ ours) - 1.0),
        "given": given / asked,
    }


def _table_of(folder: Path, formula: str, numbers: list[float]) -> ImageWorld:
    elevations, azimuths = np.arange(91.0), np.arange(360.0)
    height, turn = (np.radians(x) for x in np.meshgrid(elevations, azimuths, indexing="ij"))
    directions = np.stack(
        [np.cos(height) * np.sin(turn), np.cos(height) * np.cos(turn), np.sin(height)], axis=-1
    )
    values = evaluate(folder, "skybright.cal", formula, numbers, directions.reshape(-1, 3))
    return make_grid_world(SkyGrid(elevations, azimuths, values.reshape(height.shape)))


def look_up(world: ImageWorld, directions) -> np.ndarray:
    """Luminance of directions in a picture of even cells, by the mapping that `ImageWorld` states. [cd/m2]"""
    x, y, z = (np.asarray(directions) @ world.rotation.T).T
    rows, columns = world.image.pixels.shape[:2]
    u = 0.5 - np.arctan2(y, x) / (2.0 * np.pi)
    v = 0.5 + np.arctan2(z, np.hypot(x, y)) / np.pi
    row = np.minimum((v * rows).astype(int), rows - 1)
    pixels = world.image.pixels[row, (u * columns).astype(int) % columns]
    return world.luminance_per_unit * pixels[:, 0].astype(np.float64)


# ---- gendaylit ----


def _compare_gendaylit(folder: Path, hour: Hour, directions, weights) -> dict:
    theirs = ask_gendaylit(folder, hour)
    found = find_daylight(hour.direct, hour.diffuse, hour.elevation, WATER, DAY_ZERO**-0.5)
    towards = sun_direction(np.radians(hour.elevation), np.radians(hour.azimuth))
    illuminance = float(found.diffuse_horizontal)
    sky = PerezSky(float(found.clearness), float(found.brightness), towards, illuminance)
    numbers = theirs["numbers"]
    luminances = evaluate(folder, "perezlum.cal", "intersky", numbers, directions)
    means = mean_directions(hour.azimuth)
    seen = evaluate(folder, "perezlum.cal", "intersky", numbers, means)
    aimed = 2.0 * np.pi * float((seen * means[:, 2]).mean())
    given = float(weights @ luminances)
    ours = find_luminances(sky, directions)
    direct = float(found.direct_normal)
    return {
        "class": int(find_class(found.clearness)) + 1,
        "elevation": hour.elevation,
        "direct": hour.direct,
        "diffuse": hour.diffuse,
        "luminance": difference(ours / (weights @ ours), luminances / given),
        "illuminance": illuminance / aimed - 1.0,
        "sun": direct / theirs["sun"] - 1.0 if direct > 0.0 else 0.0,
        "given": given / aimed,
    }


def ask_gendaylit(folder: Path, hour: Hour) -> dict:
    """Illuminance by the sun [lx] and the ten ``numbers`` of its formula (factor, ground, a to e, direction to the sun)."""
    text = run_program(
        folder, "gendaylit", "-ang", f"{hour.elevation:.6g}", f"{hour.azimuth - 180.0:.6g}",
        "-W", f"{hour.direct:.6g}", f"{hour.diffuse:.6g}", "-O", "2", "-g", "0",
    ).decode()  # fmt: skip
    sun = re.search(r"light solar\s+0\s+0\s+3 (\S+)", text)
    numbers = re.search(r"perezlum.cal\s+0\s+10 (.*)", text)
    if numbers is None:
        raise LumenrayError(f"gendaylit tells no sky: {text.strip()[-120:]}")
    luminance = float(sun[1]) if sun else 0.0
    solid = 2.0 * np.pi * (1.0 - np.cos(np.radians(SUN_RADIUS)))
    return {"sun": luminance * solid, "numbers": [float(word) for word in numbers[1].split()]}


def mean_directions(azimuth: float) -> np.ndarray:
    """The 145 directions that gendaylit levels its sky by. (145, 3)"""
    rows = []
    for elevation, count in PATCH_ROWS:
        turns = np.radians(azimuth) + 2.0 * np.pi * np.arange(count) / count
        rows += [sun_direction(np.radians(elevation), turn) for turn in turns]
    return np.array(rows)


# ---- both ----


def evaluate(folder: Path, file: str, formula: str, numbers, directions) -> np.ndarray:
    """Value of a formula of one of Radiance's files for directions, never below 0. (n,)"""
    arguments = ";".join(f"A{k}:{value!r}" for k, value in enumerate(numbers, start=1))
    sent = np.ascontiguousarray(directions, dtype="<f8").tobytes()
    said = run_program(
        folder, "rcalc", "-id3", "-od", "-f", "rayinit.cal", "-f", file,
        "-e", f"{arguments};Dx=$1;Dy=$2;Dz=$3;$1={formula}", sent=sent,
    )  # fmt: skip
    values = np.frombuffer(said, dtype="<f8")
    if len(values) != len(directions):
        raise LumenrayError(f"rcalc answers {len(values)} of {len(directions)} directions")
    return np.maximum(values, 0.0)


def difference(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest difference relative to the luminance, or to `DIM` of the mean where that is more. [-]"""
    return float(np.max(np.abs(ours - theirs) / np.maximum(theirs, DIM * theirs.mean())))


def _tell(row: dict) -> str:
    return f"luminances within {100 * row['luminance']:.3f} %, illuminance {100 * row['illuminance']:+.3f} %"
