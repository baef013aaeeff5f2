"""Reference values of C46 to C48: illuminances under skies by quadrature, with nothing of the engine.

`python -m lumenray.validation.sky_values` computes them anew and puts them into ``groups.json``, in place of those of
earlier. Each group states its sky, which the case makes its scene of.

Open sensors are integrated over the hemisphere, sensors in the room over the opening, by midpoints of so many cells that
neither the bright sky about the sun nor the borders of patches matter.
"""

import json

import numpy as np

from .reference import FOLDER
from .sky_formulas import (
    PATCH_COUNTS,
    clear_sky,
    direction,
    grid_sky,
    overcast_sky,
    patch_sky,
    perez_letters,
    perez_sky,
)

CELLS = 1440
"""Along elevation, and along each edge of the opening; twice as many around, so that borders of patches lie between them."""

HORIZONTAL = 100.0
"""Of the skies by formula, so that values are percent of it. [lx]"""

GROUND = 0.3
"""Reflectance of the ground. [-]"""

OPENING = ((1.0, 3.0), (1.0, 2.0))
"""Ranges of x and z of the opening in the wall y = 0, which looks south. [m]"""

NORMALS = {
    "horizontal": (0.0, 0.0, 1.0),
    "north": (0.0, 1.0, 0.0),
    "east": (1.0, 0.0, 0.0),
    "south": (0.0, -1.0, 0.0),
    "west": (-1.0, 0.0, 0.0),
    "sloping": (-0.48, -0.64, 0.6),
}
"""Of the open sensors."""

ROOM = {
    "wall 0.5": ((2.0, 4.0, 0.5), (0.0, -1.0, 0.0)),
    "wall 1.5": ((2.0, 4.0, 1.5), (0.0, -1.0, 0.0)),
    "wall 2.5": ((1.0, 4.0, 2.5), (0.0, -1.0, 0.0)),
    "west 1": ((0.0, 2.0, 1.0), (1.0, 0.0, 0.0)),
    "east 1": ((4.0, 2.0, 1.0), (-1.0, 0.0, 0.0)),
    "floor 0.75": ((2.0, 0.75, 0.0), (0.0, 0.0, 1.0)),
    "floor 1.5": ((2.0, 1.5, 0.0), (0.0, 0.0, 1.0)),
    "floor 2.5": ((2.0, 2.5, 0.0), (0.0, 0.0, 1.0)),
    "floor west": ((0.8, 1.5, 0.0), (0.0, 0.0, 1.0)),
    "floor east": ((3.2, 1.5, 0.0), (0.0, 0.0, 1.0)),
    "ceiling 1": ((2.0, 1.0, 3.0), (0.0, 0.0, -1.0)),
    "ceiling 3": ((2.0, 3.0, 3.0), (0.0, 0.0, -1.0)),
}
"""Places and normals of the sensors in the room. [m]"""

CLOUDINESS = (0.0, 0.25, 0.5, 0.75, 1.0)

CLOUDY_SUN = (60.0, 215.0)
"""Elevation and azimuth. [degree]"""

PEREZ = (
    (1.02, 0.25, 30.0, 200.0),
    (1.15, 0.35, 45.0, 150.0),
    (1.36, 0.30, 60.0, 180.0),
    (1.72, 0.25, 25.0, 230.0),
    (2.35, 0.22, 50.0, 170.0),
    (3.60, 0.18, 35.0, 190.0),
    (5.30, 0.12, 20.0, 160.0),
    (8.00, 0.08, 55.0, 210.0),
)
"""Clearness, brightness, and the sun's elevation and azimuth [degree] by class."""

BRIGHT_PATCH = 49
"""A patch low in the south-west, as if the sun stood there."""

TABLE_STEPS = (10.0, 15.0)
"""Between elevations and between azimuths of the table. [degree]"""


def make_groups() -> list[dict]:
    """Compute all groups, in the form of ``groups.json``."""
    groups = []
    for value in CLOUDINESS:
        sky = {"cloudiness": value, **_sun(*CLOUDY_SUN)}
        groups += _pair("C46", f"c{value:g}", sky, is_absolute=False)
    for number, (clearness, brightness, *sun) in enumerate(PEREZ, start=1):
        sky = {"clearness": clearness, "brightness": brightness, **_sun(*sun)}
        groups += _pair("C47", f"class{number}", sky, is_absolute=False)
    for name, sky in (("patches", _patches()), ("table", _table())):
        groups += _pair("C48", name, sky, is_absolute=True)
    return groups


def _sun(elevation: float, azimuth: float) -> dict:
    return {"sun_elevation": elevation, "sun_azimuth": azimuth}


def _patches() -> dict:
    """Patches that differ from each other, one of them bright."""
    number = np.arange(sum(PATCH_COUNTS))
    luminances = 2000.0 + 100.0 * (37 * number % 61)
    luminances[BRIGHT_PATCH] = 90_000.0
    return {"luminances": luminances.tolist()}


def _table() -> dict:
    """A table whose luminances fall towards the zenith and away from the south-west."""
    rise, turn = TABLE_STEPS
    elevations, azimuths = np.arange(0.0, 90.0 + rise, rise), np.arange(0.0, 360.0, turn)
    height, around = np.radians(elevations)[:, None], np.radians(azimuths - 225.0)
    values = 3000.0 + 5000.0 * np.cos(height) * (1.0 + np.cos(around)) ** 2 + 500.0 * height
    return {
        "elevations": elevations.tolist(),
        "azimuths": azimuths.tolist(),
        "luminances": np.round(values).tolist(),
    }


def luminance_of(sky: dict):
    """Luminance over directions above the horizon, up to its level, by what a group states of its sky."""
    if "cloudiness" in sky:
        sun = direction(sky["sun_elevation"], sky["sun_azimuth"])
        share = sky["cloudiness"]
        parts = [lambda x: clear_sky(x, sun), overcast_sky]
        levels = [integrate(part, NORMALS["horizontal"]) for part in parts]
        return lambda x: (1.0 - share) * parts[0](x) / levels[0] + share * parts[1](x) / levels[1]
    if "clearness" in sky:
        sun = direction(sky["sun_elevation"], sky["sun_azimuth"])
        letters = perez_letters(sky["clearness"], sky["brightness"], sky["sun_elevation"])
        return lambda x: perez_sky(x, sun, letters)
    if "elevations" in sky:
        table = sky["elevations"], sky["azimuths"], sky["luminances"]
        return lambda x: grid_sky(x, *table)
    return lambda x: patch_sky(x, sky["luminances"])


def integrate(luminance, normal, cells: int = CELLS) -> float:
    """Illuminance of a plane by all of the sky, nothing below the horizon."""
    height = 0.5 * np.pi * (np.arange(cells) + 0.5) / cells
    turn = 2.0 * np.pi * (np.arange(2 * cells) + 0.5) / (2 * cells)
    total, normal = 0.0, np.asarray(normal, dtype=np.float64)
    edges = np.sin(0.5 * np.pi * np.arange(cells + 1) / cells)
    for k, sine in enumerate(np.sin(height)):
        flat = np.cos(height[k])
        row = np.stack(
            [flat * np.sin(turn), flat * np.cos(turn), np.full(len(turn), sine)], axis=-1
        )
        seen = luminance(row) * np.maximum(row @ normal, 0.0)
        total += seen.sum() * (edges[k + 1] - edges[k])
    return float(total * np.pi / cells)


def of_ground(normal, level: float) -> float:
    """Illuminance of an open plane by an even ground of a luminance."""
    return 0.5 * np.pi * level * (1.0 - normal[2])


def through_opening(luminance, ground: float, place, normal, cells: int = CELLS) -> float:
    """Illuminance of a sensor in the room by what it sees through the opening, sky and ground."""
    (x0, x1), (z0, z1) = OPENING
    x = x0 + (x1 - x0) * (np.arange(cells) + 0.5) / cells
    z = z0 + (z1 - z0) * (np.arange(cells) + 0.5) / cells
    area = (x1 - x0) * (z1 - z0) / cells**2
    total, place, normal = 0.0, np.array(place), np.array(normal)
    for height in z:
        way = np.stack([x, np.zeros(cells), np.full(cells, height)], axis=-1) - place
        distance = np.linalg.norm(way, axis=1)
        way /= distance[:, None]
        seen = luminance(way) if height > place[2] else ground
        # The opening's own normal is +y, from which the sensor is seen.
        total += float((seen * np.maximum(way @ normal, 0.0) * -way[:, 1] / distance**2).sum())
    return total * area


def _pair(case: str, name: str, sky: dict, is_absolute: bool) -> list[dict]:
    """Groups of the open sensors and of the room under one sky."""
    plain = luminance_of(sky)
    level = 1.0 if is_absolute else HORIZONTAL / integrate(plain, NORMALS["horizontal"])

    def luminance(directions):
        return level * plain(directions)

    ground = GROUND * integrate(luminance, NORMALS["horizontal"]) / np.pi
    unit, quantity = ("lx", "illuminance") if is_absolute else ("%", "E/E_hz")
    points = [
        [
            label,
            integrate(luminance, normal) + of_ground(normal, ground),
            [0.0, 0.0, 0.0],
            list(normal),
        ]
        for label, normal in NORMALS.items()
    ]
    made = [_group(f"{case}.open.{name}", quantity, unit, "A", points, sky)]
    points = [
        [label, through_opening(luminance, ground, place, normal), list(place), list(normal)]
        for label, (place, normal) in ROOM.items()
    ]
    return [*made, _group(f"{case}.room.{name}", quantity, unit, "B", points, sky)]


def _group(key: str, quantity: str, unit: str, kind: str, points: list, sky: dict) -> dict:
    rounded = [[label, float(f"{value:.8g}"), *rest] for label, value, *rest in points]
    return {
        "id": key,
        "case": key.partition(".")[0],
        "quantity": quantity,
        "unit": unit,
        "class": kind,
        "relative": {"A": 0.005, "B": 0.01}[kind],
        "absolute": 0.0,
        "points": rounded,
        "tables": {"sky": sky},
    }


def write_groups(groups: list[dict]) -> None:
    """Put groups into ``groups.json``, in place of what it has of their cases."""
    path = FOLDER / "groups.json"
    data = json.loads(path.read_text(encoding="utf-8"))
    cases = {group["case"] for group in groups}
    kept = [group for group in data["groups"] if group["case"] not in cases]
    lines = ",\n".join(json.dumps(group, separators=(",", ":")) for group in [*kept, *groups])
    text = f'{{"classes": {json.dumps(data["classes"])},\n"groups": [\n{lines}\n]}}\n'
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write_groups(make_groups())
