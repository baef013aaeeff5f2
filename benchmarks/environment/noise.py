"""Noise on a plane under a sunny map: of sensors in and beside shadows, with the sun as a light over with it in the map."""

import time

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.environment.extraction import clip_sources
from ...engine.environment.sources import find_sources
from ...engine.scene.light import CieSky, ImageWorld, Output, Quantity, SunLight
from ...engine.scene.material import Diffuse, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Constant, Illuminant
from ...engine.scene.texture import ImageTexture
from ...engine.session import Session
from ...engine.sky.picture import WHITE
from ...engine.sky.skies import find_luminances
from ...engine.sky.solar_position import RADIUS
from .drawn_maps import Spot, make_map

HEIGHT, SAMPLES, LIMB = 512, 1 << 15, 0.6
"""Of the map [pixel], for each sensor, and the sun's darkening at its limb [-]."""

SEEDS = (7, 8, 9)
"""Of runs that variances and times are means of; one more before them compiles the kernels."""


def measure_noise(say) -> dict:
    """Measure sensors on the ground round a wall with both.

    Returns
    -------
    dict    By "map" and "lights": mean and standard errors of 64 sensors [lx], seconds of the processors; and ``gain``,
        variance times seconds of the map over that of the lights.
    """
    sun = Spot(40.0, 120.0, illuminance=80.0)
    sky = CieSky(12, sun.towards, 11_000.0)
    pixels = make_map(HEIGHT, [sun], lambda d: 1e-3 * find_luminances(sky, d), 0.7)
    pixels.flags.writeable = False
    image = ImageTexture(pixels)
    (source,) = find_sources(image).sources
    # Of the picture's own white, as the light that is taken out of a grey map is.
    output = Output(Quantity.ILLUMINANCE, 1000.0 * source.illuminance, Illuminant(WHITE))
    light = SunLight("sun", "sun", output, -source.towards, np.radians(2.0 * RADIUS), LIMB)
    worlds = {
        "map": (ImageWorld(image, 1000.0),),
        "lights": (ImageWorld(clip_sources(image), 1000.0), light),
    }
    result = {name: _measure(items) for name, items in worlds.items()}
    cost = {name: row["variance"] * row["seconds"] for name, row in result.items()}
    result["gain"] = cost["map"] / cost["lights"]
    say(f"noise: the map's variance at equal time is {result['gain']:.2f} that of the lights")
    return result


def _measure(items) -> dict:
    material = Material("grey", "grey", Diffuse(Constant(0.3)))
    ground = _quad("ground", (-20, -20, 0), (40, 0, 0), (0, 40, 0))
    wall = _quad("wall", (-3, 0, 0), (6, 0, 0), (0, 0, 2.5))
    session = Session(witness=False)
    session.apply(SceneDelta(changed=(*items, material, ground, wall)))
    x, y = np.meshgrid(np.linspace(-5, 5, 8), np.linspace(-4.6, 4.4, 8))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.01)], axis=1)
    normals = np.tile([0.0, 0.0, 1.0], (len(places), 1))
    means, variances, seconds = [], [], []
    for seed in (0, *SEEDS):
        start = time.process_time()
        made = session.measure(places, normals, StopRule(samples=SAMPLES), seed=seed)
        seconds.append(time.process_time() - start)
        means.append(made.illuminance.mean())
        variances.append((made.standard_error**2).mean())
    return {
        "mean": float(np.mean(means[1:])),
        "variance": float(np.mean(variances[1:])),
        "seconds": float(np.mean(seconds[1:])),
    }


def _quad(name, corner, along, up) -> Mesh:
    corner, along, up = (np.asarray(each, float) for each in (corner, along, up))
    corners = np.stack([corner, corner + along, corner + along + up, corner + up])
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return Mesh(name, name, corners, faces, ("grey",), np.zeros(2, np.int32))
