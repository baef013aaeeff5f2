"""A surface and a light of every kind the engine knows, and rooms in which they meet."""

import numpy as np
from baking_rooms import lamp, pierced_box
from glass_scenes import LUX, ball, slab, sun
from luminaires import luminaire
from scattering_models import ggx
from small_scenes import paint, quad

from lumenray.engine.scattering.data.patches import PatchBasis, PatchMatrix
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scene.distribution import Opening
from lumenray.engine.scene.film import Film
from lumenray.engine.scene.light import (
    AreaLight,
    CieSky,
    CloudySky,
    ImageWorld,
    LineLight,
    Output,
    PerezSky,
    PointLight,
    Quantity,
    SpotLight,
    UniformWorld,
)
from lumenray.engine.scene.material import (
    Black,
    Blend,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Emission,
    Fabric,
    Glossy,
    Grain,
    Material,
    Measured,
    Mix,
    Raised,
    Sheen,
    TabulatedPane,
    ThinGlass,
    Toon,
    Transparent,
    Varnish,
    blend_cosines,
)
from lumenray.engine.scene.relief import Heights, Normals
from lumenray.engine.scene.scattering import Sparkle
from lumenray.engine.scene.spectrum import Constant, Illuminant
from lumenray.engine.scene.texture import ImageTexture

GREY = Constant(0.5)
CHECKS = ImageTexture(
    np.array([[[0.0, 0.2, 0.9], [1.0, 1.0, 1.0]], [[0.5, 0.1, 0.1], [0.0, 0.0, 0.0]]], np.float32)
)
MASK = ImageTexture(np.array([[[0.0], [1.0]], [[0.3], [0.0]]], np.float32), interpolation="closest")

SLOPES = ImageTexture(
    np.array([[[0.3, 0.0, 0.9], [0.0, 0.0, 0.0]], [[-0.9, 0.4, -0.2], [0.0, 1.0, 0.0]]], np.float32)
)
HEIGHTS = ImageTexture(np.array([[[0.0], [0.2]], [[1e3], [-0.1]]], np.float32))


FILM = Film(420.0, 1.9)


def _table():
    return resample(ggx(0.3), [550.0], incidences=np.radians([0.0, 40.0, 89.0]))


def _patches():
    basis = PatchBasis(np.radians([0.0, 45.0, 90.0]), np.array([1, 4], np.int32))
    return PatchMatrix(basis, basis, np.array([550.0]), np.full((5, 5, 1), 0.1, np.float32))


_FACING = np.stack([np.stack([blend_cosines(), 1.0 - blend_cosines()])] * 2)

SURFACES = {
    "matt": Diffuse(GREY),
    "all dark": Diffuse(Constant(0.0)),
    "picture": Diffuse(CHECKS),
    "opal": Diffuse(Constant(0.3), Constant(0.5)),
    "coat": Coated(GREY, 1.5, 0.5, 1.0),
    "smooth coat": Coated(CHECKS, 1.5, 0.0, 1.0),
    "coat without shine": Coated(GREY, 1.5, 0.5, 0.0),
    "coat on nothing": Coated(Constant(0.0), 1.0, 0.1, 1.0),
    "fabric": Fabric(0.1, Constant(0.4), Constant(0.2)),
    "closed fabric": Fabric(0.0, Constant(0.4), Constant(0.2)),
    "mirror": Glossy(Constant(0.9), 0.0),
    "gloss": Glossy(Constant(0.8), 0.3),
    "picture of roughness": Glossy(Constant(0.8), MASK),
    "metal": Conductor("Al", 0.1),
    "smooth metal": Conductor("Cu", 0.0),
    "glass": Dielectric(Cauchy(1.5)),
    "prism": Dielectric(Cauchy(1.5, 0.01)),
    "frosted glass": Dielectric(Cauchy(1.5), 0.3),
    "no glass": Dielectric(Cauchy(1.0)),
    "pane": ThinGlass(1.5, Constant(0.9)),
    "pane of air": ThinGlass(1.0, Constant(0.9)),
    "table of a pane": TabulatedPane(
        np.array([0.0, 60.0, 90.0]), np.array([0.8, 0.6, 0.0]), np.array([0.1, 0.2, 1.0])
    ),
    "hole": Transparent(),
    "cut-out": Mix(Diffuse(GREY), Transparent(), MASK),
    "black": Black(),
    "measured": Measured(_table(), _table()),
    "sparkling": Measured(
        _table(), _table(), sparkles=(Sparkle(_table(), 1e9, 0.05, 0.005, 0.5, 1.45),)
    ),
    "patches": Measured(_patches(), _patches(), _patches(), _patches(), 0.3, 0.9),
    "half a mirror": Mix(Diffuse(GREY), Glossy(Constant(0.9), 0.0), 0.5),
    "only the second": Mix(Black(), Coated(GREY), 1.0),
    "varnish": Varnish(Coated(CHECKS), MASK, 1.5, 0.1, Constant(0.5)),
    "varnished mirror": Varnish(Glossy(Constant(0.9), 0.0)),
    "varnished glass": Varnish(Dielectric(Cauchy(1.5))),
    "brushed": Glossy(GREY, 0.4, None, Grain(2.0, 0.1)),
    "turned": Coated(GREY, 1.5, 0.4, 1.0, 0.0, None, Grain(0.5, MASK, 2)),
    "sheen": Sheen(Coated(CHECKS), MASK, Constant(0.5), 0.4),
    "velvet": Sheen(Black(), 1.0, CHECKS, 0.6, True),
    "by the angle": Blend(Transparent(), Glossy(GREY, 0.0), _FACING),
    "sum": Blend(Coated(CHECKS), Glossy(GREY, 0.3), np.ones_like(_FACING)),
    "refraction alone": Dielectric(Cauchy(1.5), reflects=False),
    "rough refraction alone": Dielectric(Cauchy(1.5), 0.3, reflects=False),
    "tinted highlight": Coated(GREY, 1.5, 0.3, 1.0, 0.0, Constant(0.2)),
    "coloured glass": Dielectric(Cauchy(1.5), 0.0, Constant(0.5), mirror_tint=Constant(0.5)),
    "toon": Toon(CHECKS, 0.5, 0.2),
    "rough paint": Coated(GREY, 1.5, 0.5, 1.0, 0.7),
    "raised": Raised(Coated(GREY), Normals(SLOPES)),
    "raised metal": Raised(Glossy(Constant(0.9), 0.3), Heights(HEIGHTS, below=Normals(SLOPES))),
    "raised mirror": Raised(Glossy(Constant(0.9), 0.0), Heights(HEIGHTS, in_object=True)),
    "film on paint": Coated(CHECKS, 1.5, 0.3, film=FILM),
    "film on metal": Glossy(GREY, 0.3, Constant(0.8), film=FILM),
    "film on glass": Dielectric(Cauchy(1.5), film=FILM),
    "film on rough glass": Dielectric(Cauchy(1.5), 0.3, film=FILM),
    "much mixed": Mix(Mix(Coated(GREY), Glossy(GREY, 0.0), 0.3), Diffuse(CHECKS), MASK),
}

_DOWN = np.diag([1.0, -1.0, -1.0, 1.0])


def _frame(x, y, z):
    made = _DOWN.copy()
    made[:3, 3] = x, y, z
    return made


def _lumens(value=500.0, **more):
    return Output(Quantity.LUMINOUS_FLUX, value, **more)


def _sky():
    rng = np.random.default_rng(1)
    return (rng.random((8, 16, 3)) ** 4).astype(np.float32)


LIGHTS = {
    "bulb": lamp((0.3, 0.3, 1.5), 500.0, name="bulb"),
    "point": PointLight("point", "point", _lumens(), np.array([0.7, 0.3, 0.8])),
    "spot": SpotLight(
        "spot", "spot", _lumens(), np.array([0.3, 0.7, 0.9]), np.array([0.0, 0.0, -1.0]), 0.5, 0.2
    ),
    "wide spot": SpotLight(
        "wide", "wide", _lumens(), np.array([0.5, 0.7, 0.9]), np.array([0, 0, -1.0]), 0.9, 0.0, 0.05
    ),
    "area": AreaLight("area", "area", _lumens(), _frame(0.5, 0.3, 0.95), 0.2, 0.1),
    "disk": AreaLight("disk", "disk", _lumens(), _frame(0.3, 0.5, 0.95), 0.2, 0.2, "ellipse", 1.0),
    "line": LineLight("line", "line", _lumens(), _frame(0.7, 0.7, 0.9), 0.3, 0.01),
    "luminaire": luminaire("batwing", Opening(), (0.5, 0.5, 0.9), key="luminaire", lumens=500.0),
    "opening": luminaire(
        "up and down", Opening("box", (0.1, 0.1, 0.05)), (0.7, 0.5, 0.85), key="opening"
    ),
    "sun": sun((0.2, 0.1, -1.0), 0.0093, LUX),
    "sharp sun": sun((0.2, 0.1, -1.0), 0.0, LUX),
    "sky": CieSky(12, np.array([0.3, 0.2, 1.0]), 10_000.0, 0.2, Illuminant("D65")),
    "overcast": CieSky(16, np.array([0.0, 0.0, 1.0]), 10_000.0),
    "cloudy": CloudySky(0.4, np.array([0.3, 0.2, 1.0]), 10_000.0, 0.2),
    "all-weather sky": PerezSky(2.0, 0.25, np.array([0.3, 0.2, 1.0]), 10_000.0, 0.2),
    "even sky": UniformWorld(1000.0),
    "picture of a sky": ImageWorld(ImageTexture(_sky()), 2000.0),
}


def room_with(surfaces, lights, many=6):
    """Room of 1 m whose lid has a hole: a body and a sheet of every surface, and a glowing sheet.

    Parameters
    ----------
    surfaces, lights : sequence of str
    many : int    Places along a side of the floor.

    Returns
    -------
    list    Items; those to be baked are ``room`` and, of every surface, ``body of ..`` and ``sheet of ..``.
    """
    items = [pierced_box(0.6), paint(0.6), *(LIGHTS[name] for name in lights)]
    glow = Material("glow", "glow", Diffuse(GREY), Emission(Constant(1.0), 500.0, CHECKS, True))
    items += [glow, quad("glowing", (0.02, 0.3, 0.3), (0, 0.2, 0), (0, 0, 0.2), "glow")]
    for number, name in enumerate(surfaces):
        x, y = ((each + 0.3) / many for each in divmod(number, many))
        size = 0.4 / many
        body, sheet = f"body of {name}", f"sheet of {name}"
        made = ball(body, 0.5 * size, (x + size, y + size, 0.2), name, 8)
        if number % 2:
            made = slab((x, y, 0.01), (x + size, y + size, 0.1), name, body)
        items += [Material(name, name, SURFACES[name]), made]
        items.append(quad(sheet, (x, y, 0.5), (size, 0.0, 0.3 * size), (0.0, size, 0.0), name))
    return items
