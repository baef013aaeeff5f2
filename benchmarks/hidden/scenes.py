"""Scenes whose light is hard to find and whose true values are known: panes, bulbs, keyholes, white rooms and more."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...engine.scene.camera import Camera, Projection
from ...engine.scene.light import Output, PointLight, Quantity, SunLight, UniformWorld
from ...engine.scene.material import (
    Black,
    Cauchy,
    Dielectric,
    Diffuse,
    Emission,
    Material,
    ThinGlass,
)
from ...engine.scene.spectrum import Constant
from ..common.shapes import make_ball, make_box, make_rectangle
from . import truths

UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)

DISK = float(np.radians(0.53))
"""Diameter of suns. [rad]"""

INDEX = 1.52
"""Of panes, which absorb nothing."""

BULB, BULB_INDEX = 0.03, 1.5
"""Radius [m] and refractive index of bulbs."""

SHELL = 2.0
"""Radius of the room of bulbs at sensors and in pictures. [m]"""

PLACE = (0.5, 0.2, 0.6)
"""Of the bulb in there. [m]"""

RESTING = 1e-4
"""Height of sensors over a wall of facets. [m]"""

FACETED = 2e-3
"""Share that facets of balls and shells may change. [-]"""

PIXELS = 16
"""Along the sides of pictures."""

PANE = Material("glass", "glass", ThinGlass(INDEX, Constant(1.0)))

CLEAR = Material("glass", "glass", Dielectric(Cauchy(BULB_INDEX)))

HALF = 200.0
"""Half side of panes that stand for endless ones. [m]"""


@dataclass(frozen=True)
class Sensors:
    """Illuminances to be measured.

    Parameters
    ----------
    labels : tuple of str
    places, normals : (n, 3) array-like    [m]
    true : (n,) array-like    [lx]
    samples : int    Per sensor.
    """

    labels: tuple[str, ...]
    places: object
    normals: object
    true: object
    samples: int = 1 << 14


@dataclass(frozen=True)
class Map:
    """A mean over the lux map of the object ``room``, times ``area`` [m2] where that is given: a flux.

    Parameters
    ----------
    true : float    [lx] or [lm].
    samples, density : float    Of lumels, and lumels per metre.
    """

    true: float
    samples: int
    density: float = 6.0
    area: float | None = None
    caustics: str = "auto"


@dataclass(frozen=True)
class View:
    """A mean over a picture. ``true``: [cd/m2]."""

    camera: Camera
    true: float
    samples: int


@dataclass(frozen=True)
class Scene:
    """What is asked about what.

    Parameters
    ----------
    words : str    For people.
    items : tuple    Of the scene.
    asked : tuple of Sensors, Map or View
    margin : float    Share of a true value that its closed form and the facets of the scene leave open. [-]
    """

    words: str
    items: tuple
    asked: tuple
    margin: float = 2e-4


def make_scenes() -> dict[str, Callable[[], Scene]]:
    """All scenes by name; each is made when it is called."""
    made: dict[str, Callable[[], Scene]] = {}
    for tilt in (35, 65, 82):
        made[f"panes-{tilt}"] = lambda tilt=tilt: _panes(tilt, 0.0)
        made[f"panes-{tilt}-disk"] = lambda tilt=tilt: _panes(tilt, DISK)
    made["pane-lamp"] = _lamp_at_pane
    made["pane-room"] = _room_with_pane
    for name, radius, is_mesh in (("bulb-10mm", 0.01, False), ("bulb-1mm", 0.001, False),
                                  ("bulb-point", 0.0, False), ("bulb-mesh", 0.01, True)):  # fmt: skip
        made[f"{name}-box"] = lambda r=radius, m=is_mesh: _bulb_in_box(r, m)
        made[f"{name}-sphere"] = lambda r=radius, m=is_mesh: _bulb_in_sphere(r, m)
    for millimetres in (5, 30):
        made[f"keyhole-{millimetres}mm"] = lambda mm=millimetres: _keyhole(1e-3 * mm)
    made["lamp-at-wall"] = _lamp_at_wall
    made["lamp-at-shell"] = _lamp_at_shell
    made["white-room"] = _white_room
    made["facets-sun"] = lambda: _facets(True)
    made["facets-world"] = lambda: _facets(False)
    made["penumbra"] = _penumbra
    return made


def _panes(degrees: int, angle: float) -> Scene:
    """Sun of 10 klx behind two panes, at a sensor and on a small grey card."""
    tilt = np.radians(degrees)
    towards = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1e4), towards, angle)
    true = truths.sun_through_panes(tilt, 1e4, INDEX, 1.0, angle)
    card = _card((1.0, 0.0, 0.0), faces_up=True)
    view = View(look((1.0, 0.4, 0.6), (1.0, 0.0, 0.0), 0.01), 0.5 * true / np.pi, 64)
    kind = "a disk" if angle else "a point"
    return Scene(
        f"sun ({kind}) at {degrees}° from the normal of two panes",
        (PANE, _endless("low", 1.0), _endless("high", 1.5), sun, _paint(0.5), card),
        (Sensors(("behind",), [[0.0, 0.0, 0.0]], [UP], [true]), view),
    )


def _lamp_at_pane() -> Scene:
    """Lamp of 1000 cd at 1 m over a pane, at places that see nothing but its reflection."""
    lamp = PointLight("lamp", "lamp", Output(Quantity.LUMINOUS_INTENSITY, 1000.0), np.array(UP))
    places = [(1.0, 0.0, 0.5), (2.0, -1.0, 0.2)]
    true = [truths.lamp_in_pane(place, DOWN, UP, 1000.0, INDEX, 1.0) for place in places]
    centre = (0.0, 1.0, 0.5)
    seen = truths.lamp_in_pane(centre, DOWN, UP, 1000.0, INDEX, 1.0)
    view = View(look((0.0, 1.3, 0.1), centre, 0.01), 0.5 * seen / np.pi, 64)
    return Scene(
        "point lamp over a pane, its reflection alone",
        (PANE, _endless("pane", 0.0), lamp, _paint(0.5), _card(centre, faces_up=False)),
        (Sensors(("near", "far"), places, [DOWN, DOWN], true), view),
    )


def _room_with_pane() -> Scene:
    """Room of 3 m that a pane divides, baked without caustics."""
    pane = make_rectangle("pane", (2.0, 0.0, 0.0), (0.0, 3.0, 0.0), (0.0, 0.0, 3.0), "glass")
    true = truths.closed_room(1250.0, 0.2, 54.0)
    return Scene(
        "point lamp in a room that a pane divides, caustics off",
        (_paint(0.2), PANE, make_box((3.0, 3.0, 3.0)), pane, _lamp((1.2, 1.4, 1.3), 1250.0)),
        (Map(true, 64, caustics="off"),),
    )


def _bulb_in_box(radius: float, is_mesh: bool) -> Scene:
    flux, absorbing = _bulb_light(1250.0, radius, is_mesh)
    room = make_box((3.0, 3.0, 3.0))
    items = _bulb((1.5, 1.5, 1.6), 1250.0, radius, is_mesh)
    true = truths.closed_room(flux, 0.5, 54.0, absorbing)
    return Scene(
        f"{_name_lamp(radius, is_mesh)} in a ball of glass, box of 3 m",
        (_paint(0.5), room, *items),
        (Map(true, 128),),
        FACETED,
    )


def _bulb_in_sphere(radius: float, is_mesh: bool) -> Scene:
    flux, absorbing = _bulb_light(1000.0, radius, is_mesh)
    shell = make_ball("room", SHELL, (0.0, 0.0, 0.0), "paint", 256, inwards=True, smooth=False)
    aims = np.array([[-0.4, 0.3, -0.5 * np.sqrt(3.0)], [0.9, 0.1, 0.3 * np.sqrt(2.0)]])
    places = (SHELL - RESTING) * aims
    true = truths.in_sphere(places, PLACE, flux, 0.5, SHELL, absorbing)
    seen = truths.in_sphere(SHELL * aims[1:], PLACE, flux, 0.5, SHELL, absorbing)[0]
    view = View(look((-0.4, 0.3, -0.5), SHELL * aims[1], 0.02), 0.5 * seen / np.pi, 128)
    return Scene(
        f"{_name_lamp(radius, is_mesh)} in a ball of glass, sphere of 2 m",
        (_paint(0.5), shell, *_bulb(PLACE, 1000.0, radius, is_mesh)),
        (Sensors(("far", "near"), places, -aims, true, 1 << 16), view),
        FACETED,
    )


def _bulb(place, flux: float, radius: float, is_mesh: bool) -> tuple:
    """Glass, ball and lamp."""
    ball = make_ball("bulb", BULB, place, "glass", 96)
    if not is_mesh:
        return CLEAR, ball, _lamp(place, flux, radius)
    body = make_ball("body", radius, place, "glow", 48, smooth=False)
    glow = Emission(Constant(1.0), flux / (np.pi * float(body.areas().sum())), None, False)
    return CLEAR, ball, Material("glow", "glow", Black(), glow), body


def _bulb_light(flux: float, radius: float, is_mesh: bool) -> tuple[float, float]:
    """Flux that leaves a bulb [lm], and area by which it absorbs [m2]; lamps that are no meshes absorb nothing."""
    if not is_mesh:
        return flux, 0.0
    back, absorbing = truths.body_in_bulb(radius, BULB, BULB_INDEX)
    return flux * (1.0 - back), absorbing


def _name_lamp(radius: float, is_mesh: bool) -> str:
    if radius == 0.0:
        return "ideal point"
    return f"{'glowing mesh' if is_mesh else 'sphere lamp'} of {1000.0 * radius:.0f} mm"


def _keyhole(width: float) -> Scene:
    """Sun of 100 klx on the lid of a box of 1 m, at a slant."""
    towards = np.array([0.2, 0.1, -1.0])
    normal = 1e5 * float(np.linalg.norm(towards))
    sun = SunLight(
        "sun", "sun", Output(Quantity.ILLUMINANCE, normal), towards / np.linalg.norm(towards), DISK
    )
    room = make_box((1.0, 1.0, 1.0), width)
    true = truths.keyhole(width, 1e5, towards, 0.7)
    return Scene(
        f"sun through a hole of {1000.0 * width:.0f} mm into a box of 1 m",
        (_paint(0.7), room, sun),
        (Map(true, 1 << 14, area=float(room.areas().sum())),),
        1e-3,
    )


def _lamp_at_wall() -> Scene:
    return Scene(
        "point lamp at 0.1 mm from a wall, room of 3 m",
        (_paint(0.5), make_box((3.0, 3.0, 3.0)), _lamp((1e-4, 1.4, 1.3), 1000.0)),
        (Map(truths.closed_room(1000.0, 0.5, 54.0), 1024),),
    )


def _lamp_at_shell() -> Scene:
    """Lamp so close to a sphere's wall that what it lights there is found by asking for it alone."""
    lamp = np.array([0.0, 0.0, SHELL - 0.005])
    shell = make_ball("room", SHELL, (0.0, 0.0, 0.0), "paint", 256, inwards=True, smooth=False)
    aims = np.array([[np.cos(0.3), 0.0, np.sin(0.3)], [0.0, 0.0, -1.0]])
    places = (SHELL - RESTING) * aims
    true = truths.in_sphere(places, lamp, 1000.0, 0.5, SHELL)
    seen = truths.in_sphere(SHELL * aims[:1], lamp, 1000.0, 0.5, SHELL)[0]
    view = View(look((-0.4, 0.3, -0.5), SHELL * aims[0], 0.02), 0.5 * seen / np.pi, 128)
    return Scene(
        "point lamp at 5 mm from the wall of a sphere of 2 m",
        (_paint(0.5), shell, _lamp(lamp, 1000.0)),
        (Sensors(("side", "foot"), places, -aims, true, 1 << 16), view),
        FACETED,
    )


def _white_room() -> Scene:
    return Scene(
        "sphere lamp of 50 mm in a room of 3 m, reflectance 0.99",
        (_paint(0.99), make_box((3.0, 3.0, 3.0)), _lamp((1.5, 1.4, 1.3), 1500.0, 0.05)),
        (Map(truths.closed_room(1500.0, 0.99, 54.0), 1024),),
    )


def _facets(is_sun: bool) -> Scene:
    """Ball of 8 rings and 16 meridians that is shaded smoothly."""
    ball = make_ball("room", 1.0, (0.0, 0.0, 0.0), "paint", 8)
    words = "ball of few facets, shaded smoothly, "
    if not is_sun:
        # A body without hollows sees half of the world from everywhere.
        asked = Map(100.0 * np.pi, 256, density=8.0)
        return Scene(words + "even world", (_paint(0.5), ball, UniformWorld(100.0)), (asked,))
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), np.array(DOWN), DISK)
    # What faces a light overhead has a polygon of 16 sides for its shadow.
    asked = Map(1000.0 * 8.0 * np.sin(np.pi / 8.0), 256, 8.0, float(ball.areas().sum()))
    return Scene(words + "sun overhead", (_paint(0.5), ball, sun), (asked,))


def _penumbra() -> Scene:
    """Sun at 61 degrees behind the edge of a screen at 10 m, from 45 mm in the shade to 45 mm in the light."""
    elevation, height = np.radians(61.0), 10.0
    towards = np.array([-np.cos(elevation), 0.0, -np.sin(elevation)])
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1e5), towards, DISK)
    # The screen covers what is on the zenith's side of its edge, x = 0, so that places look below it into the sun.
    screen = make_rectangle(
        "screen", (-40.0, -50.0, height), (40.0, 0.0, 0.0), (0.0, 100.0, 0.0), "paint"
    )
    middle = -height / np.tan(elevation)
    offsets = np.array([-0.045, -0.03, -0.015, 0.0, 0.015, 0.03, 0.045])
    places = np.stack([middle + offsets, 0.0 * offsets, 0.0 * offsets], axis=1)
    tilts = np.arctan2(height, -places[:, 0])
    true = [truths.disk_behind_edge(elevation, DISK, 1e5, tilt) for tilt in tilts]
    labels = tuple(f"{1000.0 * offset:+.0f} mm" for offset in offsets)
    aside = (middle, 2.0, 0.0)
    view = View(look((middle, 2.3, 0.5), aside, 0.005), 0.5 * true[3] / np.pi, 1024)
    return Scene(
        "penumbra of a sun at 61° behind an edge at 10 m",
        (_paint(0.5), screen, sun, _card(aside, faces_up=True)),
        (Sensors(labels, places, np.tile(UP, (len(places), 1)), true, 1 << 16), view),
    )


def look(eye, target, extent: float) -> Camera:
    """Square view of PIXELS a side; ``extent`` is its full width at unit distance."""
    back = np.subtract(eye, target)
    back = back / np.linalg.norm(back)
    side = np.cross(UP, back)
    side /= np.linalg.norm(side)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([side, np.cross(back, side), back], axis=1)
    frame[:3, 3] = eye
    return Camera(frame, Projection.PERSPECTIVE, PIXELS, PIXELS, extent, extent)


def _card(centre, faces_up: bool):
    """Card of 20 mm that is painted; too small to send noticeable light back from panes."""
    x, y, z = centre
    edges = ((0.02, 0.0, 0.0), (0.0, 0.02, 0.0))
    return make_rectangle(
        "card", (x - 0.01, y - 0.01, z), *(edges if faces_up else edges[::-1]), "paint"
    )


def _endless(name: str, height: float):
    return make_rectangle(
        name, (-HALF, -HALF, height), (2.0 * HALF, 0.0, 0.0), (0.0, 2.0 * HALF, 0.0), "glass"
    )


def _paint(reflectance: float) -> Material:
    return Material("paint", "paint", Diffuse(Constant(reflectance)))


def _lamp(place, flux: float, radius: float = 0.0) -> PointLight:
    output = Output(Quantity.LUMINOUS_FLUX, flux)
    return PointLight("lamp", "lamp", output, np.asarray(place, float), radius)
