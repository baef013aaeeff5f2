"""What we find for the reference's values, by their names: (value, standard error or 0)."""

import json
from functools import lru_cache
from pathlib import Path

import mitsuba as mi
import numpy as np

from ...engine.cloth import weave
from ...engine.cloth.boundary import reflect_share
from ...engine.cloth.composition import Cloth, Yarn
from ...engine.cloth.records import BINS, DrawnExits, Records
from ...engine.cloth.thread_walk import ThreadOptics, walk_inside
from ...engine.cloth.tracer import KINDS, WovenScene
from ...engine.cloth.tubes import lay_out_straight
from ...engine.optical_constants.curves import Curve
from ...engine.paint.fresnel import face_reflectance

INDEX = 1.557

PHOTONS, THICK_PHOTONS, RAYS = 100_000, 8_000, 800_000


@lru_cache
def entries() -> dict:
    """Return the reference's values."""
    return json.loads(Path(__file__).with_name("reference.json").read_text(encoding="utf-8"))


def forward(g: float) -> np.ndarray:
    """Cosines of scattering after Henyey and Greenstein, at even chances."""
    u = np.linspace(0.0, 1.0, 1025)
    if g == 0.0:
        return 2.0 * u - 1.0
    s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u)
    return (1.0 + g * g - s * s) / (2.0 * g)


def _walk(optics: ThreadOptics, axial, offset, seed: int = 1):
    return walk_inside(optics, mi.Float(axial), mi.Float(offset), seed)


def find_values(say) -> dict:
    """Find all of them."""
    found = {}
    for name in entries():
        say(name)
        kind, *parts = name.split(".", 1)
        match kind:
            case "B1":
                found[name] = _uncollided(float(parts[0].removeprefix("uncollided.tau")))
            case "B2":
                index, rest = parts[0].removeprefix("meanpath.n").split(".mus")
                depth, g = rest.split(".g")
                found[name] = _mean_way(float(index), float(depth), float(g))
            case "B3":
                found[name] = _lobes(parts[0].removeprefix("lobes").removeprefix("_abs."))
            case "B4":
                found[name] = _thick(float(parts[0].removeprefix("thick.mus")))
            case "B5":
                cosines = np.cos(np.radians([0.0, 45.0, 75.0]))
                alpha = float(parts[0].removeprefix("ggx.alpha"))
                found[name] = reflect_share(cosines, np.inf, alpha), 0.0
            case "B6" if "jam" in name:
                jam = weave.jammed_plain()
                found[name] = [np.degrees(jam.weave_angle), jam.pitch, jam.crimp], 0.0
            case "B6":
                ratio = float(parts[0].removeprefix("sine_crimp."))
                found[name] = weave.crimp([True, False], ratio, 1.0), 0.0
            case "B7":
                found[name] = _cover()
            case "B8":
                found[name] = _cylinders(
                    *map(float, parts[0].removeprefix("cylinders.").split("."))
                )
    return found


def _uncollided(depth: float):
    offset = 2.0 * np.random.default_rng(4).random(PHOTONS) - 1.0
    made = _walk(ThreadOptics(1.0, depth, forward(0.0)), np.zeros(PHOTONS), offset)
    share = float((np.abs(np.array(made.axial)) < 1e-6).mean())
    return share, np.sqrt(share * (1.0 - share) / PHOTONS)


def _mean_way(index: float, depth: float, g: float):
    u, v = np.random.default_rng(3).random((2, PHOTONS))
    axial, around = np.sqrt(u) * np.cos(2 * np.pi * v), np.sqrt(u) * np.sin(2 * np.pi * v)
    made = _walk(ThreadOptics(index, depth, forward(g)), axial, around / np.sqrt(1.0 - axial**2))
    enters = 1.0 - face_reflectance(np.sqrt(u), 1.0, index)
    ways = enters * np.array(made.length)
    return float(ways.mean()), float(ways.std() / np.sqrt(PHOTONS))


def _lobes(absorbed: str):
    offset = (np.arange(PHOTONS) + 0.5) / PHOTONS
    made = _walk(ThreadOptics(INDEX, 0.0, forward(0.0)), np.zeros(PHOTONS), offset)
    way = np.array(made.length)
    crossings = np.rint(way / (2.0 * np.sqrt(1.0 - (offset / INDEX) ** 2)))
    enters = 1.0 - face_reflectance(offset, 1.0, INDEX)
    kept = enters * np.exp(-(float(absorbed) if absorbed else 0.0) * way)
    lobes = [float(kept[crossings == k].sum() / PHOTONS) for k in (1, 2)]
    error = np.sqrt(np.array(lobes) / PHOTONS)
    if absorbed:
        return lobes[:1], error[:1]
    return [1.0 - float(enters.mean()), *lobes], np.array([0.0, *error])


def _thick(depth: float):
    made = _walk(ThreadOptics(INDEX, depth, forward(0.0)), *np.zeros((2, THICK_PHOTONS)))
    enters = 1.0 - float(face_reflectance(0.0, 1.0, INDEX))
    kept = enters * np.exp(-0.01 * depth * np.array(made.length))
    # The reference is another walk, of 100 000 photons.
    return float(kept.mean()), float(np.hypot(kept.std() / np.sqrt(THICK_PHOTONS), 0.0016))


def _straight(pitch: float, kind: int, exits: np.ndarray) -> WovenScene:
    clear = Curve(np.array([550.0]), np.zeros(1))
    yarn = Yarn(0.14, 0.14, 1.0, 0.0, (), clear)
    tubes = lay_out_straight(Cloth(yarn, yarn, weave.plain(pitch, pitch)), kind)
    drawn = DrawnExits([Records(np.tile(exits, (BINS * BINS, 1)), len(exits), 0.0)] * KINDS)
    return WovenScene(
        tubes, [ThreadOptics(1.0, 0.0, np.zeros(2))] * KINDS, drawn, 1, [0.07] * KINDS
    )


def _cover():
    """Of two nets on each other what is open is the product."""
    down = np.array([[0.0, 0.0, -1.0]])
    scenes = [_straight(0.2, kind, np.zeros((1, 6), np.float32)) for kind in (0, 1)]
    open_shares = [float(each.straight_shares(down, PHOTONS)[0]) for each in scenes]
    return 1.0 - open_shares[0] * open_shares[1], 0.3 * np.sqrt(0.3 / PHOTONS)


def _cylinders(incidence: float, exitance: float):
    """f / rho of touching Lambert cylinders, by light that met one."""
    count = 4096
    square, turn = (np.arange(count) + 0.5) / count, 2.399963 * np.arange(count)
    exits = np.zeros((count, 6), np.float32)
    exits[:, 2], exits[:, 3] = np.sqrt(square), np.sqrt(1.0 - square) * np.cos(turn)
    exits[:, 4] = np.sqrt(1.0 - square) * np.sin(turn)
    a = np.radians(incidence)
    made = _straight(0.14, 0, exits).trace([np.sin(a), 0.0, -np.cos(a)], RAYS, 5)
    x, y, z = (np.array(each) for each in (made.x, made.y, made.z))
    once = (np.array(made.events) == 1) & (z > 0.0)
    half, wide = 0.07, 0.15
    low, high = (np.sin(np.radians(exitance) + side * half) for side in (-1.0, 1.0))
    across = -x / np.sqrt(1.0 - y * y)
    there = (once & (across > low) & (across < high) & (np.abs(y) < wide)).sum()
    area = RAYS * (high - low) * 2.0 * (wide - wide**3 / 6.0)
    return float(there / area), float(np.sqrt(there) / area)
