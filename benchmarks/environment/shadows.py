"""Shadow catchers and photomontages: against sensors, pictures without them, and renders of all that a photo shows."""

from dataclasses import replace

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.scene.camera import Camera, Projection
from ...engine.scene.light import (
    Ground,
    ImageWorld,
    Output,
    Photo,
    Quantity,
    SunLight,
    UniformWorld,
)
from ...engine.scene.material import Diffuse, Glossy, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Constant, Illuminant
from ...engine.scene.texture import ImageTexture
from ...engine.session import Session
from ...engine.sky.shadow_sun import find_sun
from ...engine.views import ViewSettings
from ..common.shapes import make_ball

TOWARDS = np.array([0.5, -0.35, 0.7]) / np.linalg.norm([0.5, -0.35, 0.7])
"""To the sun."""

SKY, SUN, ANGLE = 2000.0, 40_000.0, np.radians(8.0)
"""Luminance of the sky [cd/m2], illuminance by the sun [lx] and its angular diameter, which is large for wide penumbras."""

SIDE, SPREAD = 12, 0.75
"""Pixels of a picture from above, and half width of their filter [pixel]."""

HORIZON = 12
"""Rows of a picture below the horizon and above it that are not compared."""

GROUND_SIZE = 60.0
"""Half a side of the ground. [m]"""

PIXEL = 1.0 / 600.0
"""What a hand that drags is off by at most, as a share of the film. [-]"""


def measure_shadows(say) -> dict:
    """Measure shadows on catchers and on the ground of a photo.

    Returns
    -------
    dict
        ``unshadowed_change``: largest relative change of a pixel that nothing shades [-]; ``shadow_error_percent``: root of
        the mean square of the difference between the ratio that is shown and that of sensors; ``direction_error_deg``:
        largest error of the sun's direction by dragging; ``composite_error_percent``: mean difference between a
        photomontage and the render of all, over the mean; ``mirror_error_percent``: the same of what a chrome sphere on
        the ground of a map shows, its own shadow among it; ``caustic_error_percent``: of what it throws on that ground.
    """
    made = {"unshadowed_change": _unshadowed(), "shadow_error_percent": 100.0 * _ratios()}
    say(
        f"shadows: pixels without any change by {made['unshadowed_change']:.1e}, "
        f"ratios are {made['shadow_error_percent']:.2f} % off"
    )
    degrees, composite = _photomontage()
    made |= {"direction_error_deg": degrees, "composite_error_percent": 100.0 * composite}
    say(f"photomontage: sun {degrees:.2f} degrees off, picture {100.0 * composite:.2f} % off")
    mirror, caustic = _chrome_sphere()
    made |= {"mirror_error_percent": 100.0 * mirror, "caustic_error_percent": 100.0 * caustic}
    say(
        f"chrome sphere: what it shows is {100.0 * mirror:.2f} % off, what it throws {100.0 * caustic:.2f} %"
    )
    return made


# ---- catchers ----


def _unshadowed() -> float:
    """Largest relative change that a catcher under nothing makes to a coloured picture behind it. [-]"""
    draw = np.random.default_rng(5)
    pixels = draw.uniform(0.5, 20.0, (32, 64, 3)).astype(np.float32)
    world, sun = ImageWorld(ImageTexture(pixels), 100.0), _sun()
    floor = replace(_ground("paint"), is_catcher=True)
    plain, caught = (
        _look(_session(_paint(0.5), sun, world, *items), _above(), 64) for items in ((), (floor,))
    )
    return float(np.abs(caught / plain - 1.0).max())


def _ratios() -> float:
    """Root of the mean square by which ratios of a picture differ from those of sensors in its pixels. [-]"""
    items = (_paint(0.5), _sun(), UniformWorld(SKY, seen=UniformWorld(1.0)))
    floor, block = _ground("paint"), _block("paint", (-0.25, -0.1), 0.5, 0.7)
    view = _above()
    session = _session(*items, replace(floor, is_catcher=True), block)
    shown = _look(session, view, 4096)[..., 1]
    # Places that the pixels' filter takes, by the inverse of a tent's running sum.
    steps = (np.arange(4) + 0.5) / 4
    low = steps < 0.5
    root = np.sqrt(np.where(low, 2.0 * steps, 2.0 * (1.0 - steps)))
    offset = SPREAD * np.where(low, root - 1.0, 1.0 - root)
    x = ((np.arange(SIDE) + 0.5)[:, None] + offset).ravel() / SIDE - 0.5
    places = np.stack([*np.meshgrid(x * view.extent_x, x * view.extent_y)], axis=-1)
    places = np.concatenate([places, np.zeros((*places.shape[:2], 1))], axis=-1).reshape(-1, 3)
    found = []
    for more in ((block,), ()):
        session = _session(*items, floor, *more)
        measured = session.measure(
            places,
            np.broadcast_to([0.0, 0.0, 1.0], places.shape),
            StopRule(samples=1024),
            method="paths",
            witness=False,
        )
        found.append(measured.illuminance.reshape(SIDE, 4, SIDE, 4).mean(axis=(1, 3)))
    ratio = found[0] / found[1]
    hole = replace(block, is_holdout=True)
    # What lies under the block or is hidden by it shows no ground.
    seen = _look(_session(*items, floor, hole), view, 4096, covers=True) < 1e-6
    return float(np.sqrt(((shown - ratio)[seen] ** 2).mean()))


# ---- photomontage ----


def _photomontage() -> tuple[float, float]:
    """Error of the sun's direction [degree], and the mean difference of a montage over the mean of the whole render [-]."""
    eye = _eye()
    sky = UniformWorld(SKY, Illuminant("D65"))
    items = (_paint(0.4), _paint(0.6, "white"), _ground("paint"))
    sun = replace(_sun(), output=Output(Quantity.ILLUMINANCE, SUN, Illuminant("D65")))
    post = _block("white", (-1.2, 0.6), 0.12, 1.0, "post")
    thing = _block("white", (0.7, 0.2), 0.6, 0.6, "thing")
    photo = _look(_session(*items, sky, sun, post), eye, 1024)[..., 1]
    whole = _look(_session(*items, sky, sun, post, thing), eye, 1024)[..., 1]
    towards, degrees = _drag(eye)
    picture = Photo(
        ImageTexture(photo[..., None].astype(np.float32)),
        1.0,
        eye.frame[:3, :3],
        eye.extent_x,
        eye.extent_y,
    )
    ground = Ground(eye.frame[:3, 3], 0.0, GROUND_SIZE)
    world = replace(sky, ground=ground, photo=picture)
    floor = replace(_ground("paint"), is_catcher=True, meets_light=False)
    montage = _look(
        _session(*items[:2], floor, world, replace(sun, direction=-towards), thing), eye, 1024
    )[..., 1]
    return degrees, float(np.abs(montage - whole).mean() / whole.mean())


def _chrome_sphere() -> tuple[float, float]:
    """Mean differences of what a chrome sphere shows, and of the light that it throws, to the render of all, over the means.

    The map of the one is the ground of the other as it is without the sphere.
    """
    eye, reflectance = _eye(), 0.4
    chrome = Material("chrome", "chrome", Glossy(Constant(0.9), 0.0))
    sphere = make_ball("sphere", 0.5, (0.4, 0.0, 0.5), "chrome", 48)
    items = (_paint(reflectance), chrome, _sun())
    luminance = reflectance / np.pi * (np.pi * SKY + SUN * TOWARDS[2])
    pixels = np.full((256, 512, 1), luminance, np.float32)
    pixels[128:] = SKY
    ground = Ground(eye.frame[:3, 3], 0.0, GROUND_SIZE)
    world = ImageWorld(ImageTexture(pixels), 1.0, ground=ground)
    floor = replace(_ground("paint"), is_catcher=True, meets_light=False)
    caught = _look(_session(*items, world, floor, sphere), eye, 1024)[..., 1]
    real = _session(*items, UniformWorld(SKY), _ground("paint"), sphere)
    whole = _look(real, eye, 1024)[..., 1]
    hole = replace(sphere, is_holdout=True)
    shown = _look(_session(*items, UniformWorld(SKY), _ground("paint"), hole), eye, 64, covers=True)
    # The picture's upper edge shows how the ground passes into what is at infinity.
    shown[-HORIZON:] = 0.5
    away = np.abs(caught - whole)
    on, bright = shown > 1.0 - 1e-6, (shown < 1e-6) & (whole > 1.05 * luminance)
    return (
        float(away[on].mean() / whole[on].mean()),
        float(away[bright].mean() / whole[bright].mean()),
    )


def _drag(eye) -> tuple[np.ndarray, float]:
    """Sun's direction by places that a hand has hit to a pixel, and the largest of their errors. (3,), [degree]"""
    foot, top = np.array([-1.14, 0.66, 0.0]), np.array([-1.14, 0.66, 1.0])
    end = top - TOWARDS * (top[2] / TOWARDS[2])
    exact = [_project(eye, each) for each in (foot, top, end)]
    found, errors = TOWARDS, [0.0]
    for way in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        places = [*exact[:2], exact[2] + PIXEL * np.array(way)]
        found = find_sun(eye, 0.0, *places)
        errors.append(float(np.degrees(np.arccos(min(found @ TOWARDS, 1.0)))))
    return found, max(errors)


def _project(eye, point) -> np.ndarray:
    """Where a point shows on the film, as shares of its sides. (2,)"""
    local = np.linalg.inv(eye.frame) @ [*point, 1.0]
    return local[:2] / -local[2] / [eye.extent_x, eye.extent_y] + 0.5


# ---- scenes ----


def _session(*items) -> Session:
    session = Session(witness=False)
    session.apply(SceneDelta(changed=items))
    return session


def _look(session, view, samples, covers=False) -> np.ndarray:
    """X, Y, Z, or coverage, of a picture by paths."""
    settings = ViewSettings(StopRule(samples=samples), method="paths", transparent=covers)
    made = session.render(view, settings)
    return 1.0 - made.coverage if covers else made.tristimulus.astype(np.float64)


def _above() -> Camera:
    frame = np.eye(4)
    frame[2, 3] = 5.0
    return Camera(frame, Projection.ORTHOGRAPHIC, SIDE, SIDE, 3.0, 3.0)


def _eye() -> Camera:
    place, forward = np.array([0.0, -6.0, 1.9]), np.array([0.0, 6.0, -1.4])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(right, forward), -forward], axis=1)
    frame[:3, 3] = place
    return Camera(frame, Projection.PERSPECTIVE, 96, 64, 0.75, 0.5)


def _sun() -> SunLight:
    return SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, SUN), -TOWARDS, ANGLE)


def _paint(reflectance, name="paint") -> Material:
    return Material(name, name, Diffuse(Constant(reflectance)))


def _ground(material) -> Mesh:
    s = GROUND_SIZE
    corners = np.array([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], dtype=np.float64)
    faces = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.int32)
    return Mesh("ground", "ground", corners, faces, (material,), np.zeros(2, np.int32))


def _block(material, corner, side, height, name="block") -> Mesh:
    """Upright box on the ground."""
    x, y = corner
    sides = ((x, x + side), (y, y + side), (0.0, height))
    corners = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Mesh(name, name, corners, np.array(faces, np.int32), (material,), np.zeros(12, np.int32))
