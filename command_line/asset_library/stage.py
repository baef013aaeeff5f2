"""The small scene on which a luminaire is shown by the light it throws: floor, walls, sometimes a ceiling, neutral and matt.

A stage is laid out for one height of the luminaire and scaled to the height that the model states, so that a street with its
mast and a desk with its lamp fill the picture alike. What throws light towards its own +y has the back wall there.
"""

from dataclasses import dataclass

import numpy as np

from ...engine.luminaires.distribution import flux
from ...engine.scene.camera import Camera, Projection
from ...engine.scene.distribution import Opening
from ...engine.scene.light import Luminaire, Output, Quantity, UniformWorld
from ...engine.scene.material import Diffuse, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.spectrum import Blackbody, Constant, Daylight, Illuminant
from ...libraries.luminaires import Model

WALL, FLOOR, CEILING = 0.50, 0.30, 0.65
"""Reflectances of the stage."""

STAGE_INDEX = 1
"""Of the stage in the picture's index pass; luminaires have 0."""

GAP = 0.004
"""Between a luminaire and the surface that it is mounted on, over the height of the stage."""


@dataclass(frozen=True)
class Stage:
    """Where everything is, for a luminaire at ``height``. [m]

    Parameters
    ----------
    height : float    Of the luminaire above the floor.
    back, left, right, front : float    Ends of the floor: the back wall (+y), the left wall (-x, if any), the open sides.
    top : float    Of the walls.
    eye, target : (float, float, float)    Of the camera.
    field : float    Of the camera, from side to side. [degree]
    has_ceiling, has_left : bool
    place : (float, float)    Of the luminaire over the floor.
    beam, up : (float, float, float)    Where its -z and its +y point.
    """

    height: float
    back: float
    left: float
    right: float
    front: float
    top: float
    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    field: float
    has_ceiling: bool = False
    has_left: bool = True
    place: tuple[float, float] = (0.0, 0.0)
    beam: tuple[float, float, float] = (0.0, 0.0, -1.0)
    up: tuple[float, float, float] = (0.0, 1.0, 0.0)


_ROOM = {
    "height": 2.5,
    "back": 1.0,
    "left": -1.5,
    "right": 2.6,
    "front": -3.4,
    "top": 2.5,
    "eye": (1.75, -4.6, 1.45),
    "target": (-0.02, 0.6, 1.22),
    "field": 38.0,
    "has_ceiling": True,
}

STAGES = {
    "ceiling": Stage(**_ROOM),
    "pendant": Stage(**_ROOM),
    "aimed": Stage(
        **{**_ROOM, "place": (0.35, -1.6)}, beam=(-0.12, 0.86, -0.5), up=(0.0, 1.0, 1.0)
    ),
    "floor": Stage(**{**_ROOM, "height": 1.8, "place": (-0.4, 0.3)}),
    "open": Stage(
        height=8.0,
        back=14.0,
        left=-70.0,
        right=70.0,
        front=-40.0,
        top=10.0,
        eye=(5.0, -37.0, 19.0),
        target=(0.0, 2.0, 1.6),
        field=42.0,
        has_left=False,
    ),
    "wall": Stage(
        height=1.0,
        back=0.0,
        left=-1.5,
        right=2.2,
        front=-2.6,
        top=2.2,
        eye=(1.3, -3.9, 2.1),
        target=(0.0, -0.45, 0.72),
        field=37.0,
        beam=(0.0, 0.0, -1.0),
        up=(0.0, -1.0, 0.0),
    ),
    "table": Stage(
        height=0.45,
        back=0.45,
        left=-0.5,
        right=0.9,
        front=-0.8,
        top=0.9,
        eye=(0.75, -1.7, 0.75),
        target=(0.0, 0.05, 0.30),
        field=33.0,
    ),
    "level": Stage(
        height=0.7,
        back=10.0,
        left=-12.0,
        right=12.0,
        front=-6.0,
        top=6.0,
        eye=(0.9, -4.5, 2.1),
        target=(0.0, 10.0, 0.75),
        field=46.0,
        has_left=False,
        beam=(0.0, 1.0, 0.0),
        up=(0.0, 0.0, 1.0),
    ),
}
"""Stages by how a luminaire is mounted (`libraries.luminaires.model.MOUNTS`)."""


def set_stage(model: Model, file, spectrum, size: int) -> tuple[tuple, Camera]:
    """Return the items of a scene that shows a model, and the camera.

    Parameters
    ----------
    model : Model
    file : LuminaireFile    Read from the model's file.
    spectrum : Spectrum    Of its light.
    size : int    Of the picture. [pixel]
    """
    stage = STAGES[model.mount]
    scale = model.height / stage.height
    top = stage.top * scale + model.drop
    items = [*_surfaces(stage, scale, top), *_lights(model, file, spectrum, stage, scale)]
    return tuple(items), _camera(stage, scale, size)


def spectrum_of(model: Model, file_spectrum):
    """Return the spectrum that a model's description states, that of its file if it states none."""
    light = model.light
    if light is None:
        return file_spectrum
    if light.kind == "illuminant":
        return Illuminant(light.name)
    return {"blackbody": Blackbody, "daylight": Daylight}[light.kind](light.temperature)


def part_opening(part) -> Opening:
    """Return the luminous opening of a part of a lamp."""
    return Opening(part.shape, part.size, part.opening_axis)


def part_frame(part) -> np.ndarray:
    """Where a part of a lamp stands in the lamp's axes: turned the shortest way. (4, 4), [m]"""
    frame = np.eye(4)
    frame[:3, 3] = part.position
    z = np.asarray(part.axis)
    x = np.array([0.0, 0.0, -1.0]) if z[0] > 0.99 else np.array([1.0, 0.0, 0.0])
    x = x - z * (x @ z)
    x /= np.linalg.norm(x)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    return frame


def _surfaces(stage: Stage, scale: float, top: float) -> list:
    """Floor, walls and ceiling with their materials, and the dark around them."""
    items = [UniformWorld(0.0)]
    left, right, back, front = (
        scale * side for side in (stage.left, stage.right, stage.back, stage.front)
    )
    wide, deep = right - left, back - front
    rectangles = {"floor": ((left, front, 0.0), (wide, 0.0, 0.0), (0.0, deep, 0.0), FLOOR)}
    rectangles["back"] = ((left, back, 0.0), (wide, 0.0, 0.0), (0.0, 0.0, top), WALL)
    if stage.has_left:
        rectangles["left"] = ((left, front, 0.0), (0.0, deep, 0.0), (0.0, 0.0, top), WALL)
    if stage.has_ceiling:
        rectangles["ceiling"] = ((left, front, top), (0.0, deep, 0.0), (wide, 0.0, 0.0), CEILING)
    for name, (corner, u, v, reflectance) in rectangles.items():
        points = np.array(corner) + np.array([np.zeros(3), u, np.add(u, v), v])
        items += [
            Material(f"{name} paint", f"{name} paint", Diffuse(Constant(reflectance))),
            Mesh(
                name,
                name,
                points,
                np.array([[0, 1, 2], [0, 2, 3]], np.int32),
                (f"{name} paint",),
                np.zeros(2, np.int32),
                index=STAGE_INDEX,
            ),
        ]
    return items


def _lights(model: Model, file, spectrum, stage: Stage, scale: float) -> list[Luminaire]:
    """The luminaire, or the parts of a lamp, where the stage has them."""
    frame = _frame(stage.beam, stage.up)
    frame[:3, 3] = (*(scale * np.asarray(stage.place)), model.height)
    size = np.asarray(file.opening.size)
    if model.mount in {"ceiling", "wall"}:
        # Clear of what it is mounted on.
        axis = 2 if model.mount == "ceiling" else 1
        away = -frame[:3, 2] if axis == 2 else frame[:3, 1]
        frame[:3, 3] += away * (0.5 * size[axis] + GAP * model.height)
    total = flux(file.distribution)

    def light(name, place, opening, amount):
        output = Output(Quantity.LUMINOUS_FLUX, amount, spectrum)
        return Luminaire(name, name, output, place, file.distribution, opening)

    if not model.parts:
        return [light("luminaire", frame, file.opening, total)]
    return [
        light(f"part {n}", frame @ part_frame(part), part_opening(part), part.share * total)
        for n, part in enumerate(model.parts)
    ]


def _frame(beam, up) -> np.ndarray:
    """Placement whose -z points along the beam and whose +y is as near to ``up`` as can be. (4, 4)"""
    z = -np.asarray(beam, dtype=np.float64)
    z /= np.linalg.norm(z)
    x = np.cross(np.asarray(up, dtype=np.float64), z)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    return frame


def _camera(stage: Stage, scale: float, size: int) -> Camera:
    eye, target = (scale * np.asarray(point) for point in (stage.eye, stage.target))
    frame = _frame(target - eye, (0.0, 0.0, 1.0))
    frame[:3, 3] = eye
    extent = 2.0 * np.tan(np.radians(0.5 * stage.field))
    return Camera(frame, Projection.PERSPECTIVE, size, size, extent, extent)
