"""From an empty that is a sensor to the places of its sensors in the world."""

from dataclasses import dataclass

import numpy as np

from ...engine.errors import SceneError
from ...engine.scene import sensor_layout
from ...engine.scene.camera import Camera
from ...engine.scene.sensor import SensorKind
from ..foundation.identity import identity_of
from ..foundation.pose import pose_of
from ..foundation.units import metres_per_unit
from .camera_regions import camera_signature, lay_regions
from .goniometers import Sphere, lay_sphere

LEVEL = 0.95
"""Least upward part of the normal of a floor's triangle. [-]"""

FLAT, NEAR = 0.999, 0.005
"""Least cosine between the normal of a triangle and the axis of its sensors [-], largest distance from their plane [m]."""

UPRIGHT = 1e-3
"""Length of the level part of an axis below which it points up. [-]"""

KINDS = {
    "PLANAR": SensorKind.PLANAR,
    "VERTICAL": SensorKind.PLANAR,
    "CYLINDRICAL": SensorKind.CYLINDRICAL,
    "SEMICYLINDRICAL": SensorKind.SEMICYLINDRICAL,
    "SPHERICAL": SensorKind.SPHERICAL,
}
"""Kinds of the engine by quantity; luminance and glare have none."""

LUMINANCE, GLARE, INTENSITY = "LUMINANCE", "GLARE", "INTENSITY"
"""Quantities that are no illuminances."""

UNITS = {LUMINANCE: "cd/m²", GLARE: "UGR", INTENSITY: "cd"}
"""Units of quantities, where they are not lx."""

SETTINGS = (
    "layout", "quantity", "acceptance", "length", "width", "band", "height", "border", "use_spacing", "spacing",
)  # fmt: skip
"""Settings that say where sensors stand and what they are."""

SPHERE_SETTINGS = ("radius", "plane_step", "polar_step", "use_distance", "distance")
"""Further settings of goniometers."""


@dataclass(frozen=True, eq=False)
class PlacedSensors:
    """Sensors of one empty.

    Parameters
    ----------
    uid, name : str    Of the empty.
    quantity : str    One of `settings.QUANTITIES`.
    positions, normals : (n, 3) float64 array    In the world. [m]
    frame : (4, 4) float64 array    Of the plane that they lie in: columns are its x, y, normal and origin. [m]
    plane : (n, 2) float64 array    Places in it. [m]
    cells : (n,) int array    Which cell of a grid each stands in, row by row.
    shape : (int, int)    Rows and columns of the grid; a line is one row.
    acceptance : float    Of luminance meters, the full width of their cone. [rad]
    camera : Camera or None    Whose picture's parts the sensors are.
    sphere : Sphere or None    Of a goniometer, whose detectors the sensors are.
    wants_spectrum : bool    Whether the spectrum of the light is to be found, of illuminances.
    """

    uid: str
    name: str
    quantity: str
    positions: np.ndarray
    normals: np.ndarray
    frame: np.ndarray
    plane: np.ndarray
    cells: np.ndarray
    shape: tuple[int, int]
    acceptance: float = 0.0
    camera: Camera | None = None
    sphere: Sphere | None = None
    wants_spectrum: bool = False

    @property
    def kind(self) -> SensorKind | float | str | tuple[str, str]:
        """What sensors share that are measured together.

        Kind of the engine, of luminance meters their acceptance angle, of observers
        `GLARE`, of cameras and goniometers their own.
        """
        if self.camera is not None:
            return "camera", self.uid
        if self.sphere is not None:
            return INTENSITY, self.uid
        if self.quantity == GLARE:
            return GLARE
        return self.acceptance if self.quantity == LUMINANCE else KINDS[self.quantity]


def place_sensors(empty, depsgraph) -> PlacedSensors:
    """Return where the sensors of an empty stand.

    Raises
    ------
    SceneError    The settings give no sensor; the sentence names the empty.
    """
    try:
        return _place(empty, depsgraph)
    except SceneError as error:
        raise SceneError(f"sensors '{empty.name}': {error}") from None


def _place(empty, depsgraph) -> PlacedSensors:
    settings = empty.lumenray.sensor
    metres = metres_per_unit(depsgraph.scene)
    if settings.layout == "CAMERA":
        return _place_regions(empty, depsgraph, metres)
    frame = pose_of(empty.evaluated_get(depsgraph).matrix_world, metres).frame
    if settings.layout == "SPHERE":
        return _place_sphere(empty, frame)
    if settings.quantity == INTENSITY:
        raise SceneError("only a goniometer tells intensities; set the layout to Goniometer")
    spacing = settings.spacing if settings.use_spacing else None
    heights = None
    if settings.layout == "FLOOR":
        frame = _level(frame)
        plane, heights, cells, shape = _lay_floor(settings, frame, depsgraph, metres, spacing)
    elif settings.layout == "FACE":
        triangles = _face_triangles(settings, frame, depsgraph, metres)
        plane, cells, shape = sensor_layout.lay_over(triangles, settings.border, spacing)
    elif settings.layout == "BAND":
        plane, cells, shape = _lay_band(settings, frame, depsgraph, metres, spacing)
    else:
        plane, shape = _lay_own(settings, spacing)
        cells = np.arange(len(plane))
    local = np.column_stack([plane, np.zeros(len(plane)) if heights is None else heights])
    positions = local @ frame[:3, :3].T + frame[:3, 3]
    looks_level = settings.quantity in {"VERTICAL", "SEMICYLINDRICAL"}
    facing = _level_axis(frame[:3, 0]) if looks_level else frame[:3, 2]
    if settings.quantity in {LUMINANCE, GLARE}:
        facing = frame[:3, 0]
    normals = np.tile(facing, (len(plane), 1))
    if heights is not None:
        frame = frame.copy()
        frame[:3, 3] += frame[:3, 2] * float(np.median(heights))
    return PlacedSensors(
        identity_of(empty),
        empty.name,
        settings.quantity,
        positions,
        normals,
        frame,
        plane,
        cells,
        shape,
        settings.acceptance,
        wants_spectrum=settings.use_spectrum,
    )


def _place_regions(empty, depsgraph, metres: float) -> PlacedSensors:
    """Return the parts of a camera's picture as sensors."""
    settings = empty.lumenray.sensor
    camera, positions, normals, frame, plane = lay_regions(empty, depsgraph, metres)
    return PlacedSensors(
        identity_of(empty),
        empty.name,
        settings.quantity,
        positions,
        normals,
        frame,
        plane,
        np.arange(len(plane)),
        (settings.rows, settings.columns),
        camera=camera,
    )


def _place_sphere(empty, frame) -> PlacedSensors:
    """Return the detectors of a goniometer as sensors, plane by plane."""
    settings = empty.lumenray.sensor
    sphere = lay_sphere(settings, frame)
    detectors = sphere.detectors
    count = len(detectors.positions)
    return PlacedSensors(
        identity_of(empty),
        empty.name,
        settings.quantity,
        detectors.positions,
        detectors.normals,
        frame,
        np.zeros((count, 2)),
        np.arange(count),
        (len(detectors.azimuth), len(detectors.polar)),
        sphere=sphere,
    )


def _lay_own(settings, spacing) -> tuple[np.ndarray, tuple[int, int]]:
    """Places and shape of layouts that need no mesh."""
    if settings.layout == "POINT":
        return np.zeros((1, 2)), (1, 1)
    if settings.layout == "LINE":
        points = sensor_layout.lay_line(settings.length, spacing)
        return points, (1, len(points))
    half = 0.5 * np.array([settings.length, settings.width])
    return sensor_layout.lay_rectangle(-half, half, 0.0, spacing)


def _lay_band(settings, frame, depsgraph, metres: float, spacing):
    """Places on the band around a rectangle, over the surface if there is one, their cells and shape."""
    half = 0.5 * np.array([settings.length, settings.width])
    outer = half + settings.band
    plane, shape = sensor_layout.lay_rectangle(-outer, outer, 0.0, spacing)
    chosen = (np.abs(plane) > half).any(axis=1)
    if settings.surface is not None:
        corners = _floor_triangles(settings, depsgraph, metres)
        floor = ((corners - frame[:3, 3]) @ frame[:3, :3])[..., :2]
        chosen &= sensor_layout.find_within(plane, floor, settings.border)
    if not chosen.any():
        raise SceneError("no sensor of the band is left; take a wider band or a smaller spacing")
    cells = np.flatnonzero(chosen)
    return plane[cells], cells, shape


def _level(frame: np.ndarray) -> np.ndarray:
    """The frame turned so that its z is up, with x as level as before."""
    made = frame.copy()
    made[:3, 2] = (0.0, 0.0, 1.0)
    made[:3, 0] = _level_axis(frame[:3, 0], "is upright, so that the grid has no direction")
    made[:3, 1] = np.cross(made[:3, 2], made[:3, 0])
    return made


def _level_axis(
    axis: np.ndarray, words: str = "which the sensors look along, is upright"
) -> np.ndarray:
    level = np.array([axis[0], axis[1], 0.0])
    length = np.linalg.norm(level)
    if length < UPRIGHT:
        raise SceneError(f"the empty's X axis, {words}; turn the empty")
    return level / length


def _corners(settings, depsgraph, metres: float) -> np.ndarray:
    """Corners of the triangles of the surface in the world. (t, 3, 3) [m]"""
    if settings.surface is None:
        raise SceneError("no surface is chosen; take the mesh that the grid is laid on or over")
    thing = settings.surface.evaluated_get(depsgraph)
    mesh = thing.to_mesh()
    try:
        mesh.calc_loop_triangles()
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        corners = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get("vertices", corners)
    finally:
        thing.to_mesh_clear()
    matrix = np.array(thing.matrix_world, dtype=np.float64)
    points = points.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    triangles = metres * points[corners.reshape(-1, 3)]
    # A mirrored object turns the order of corners, and the normals with it.
    return triangles[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0.0 else triangles


def _normals(corners: np.ndarray) -> np.ndarray:
    """Unit normals, 0 where a triangle has no area. (t, 3)"""
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(cross, axis=1, keepdims=True)
    return np.divide(cross, length, out=np.zeros_like(cross), where=length > 1e-12)


def _face_triangles(settings, frame, depsgraph, metres: float) -> np.ndarray:
    """Triangles of the surface that lie in the plane of a frame, in it. (t, 3, 2) [m]"""
    corners = _corners(settings, depsgraph, metres)
    local = (corners - frame[:3, 3]) @ frame[:3, :3]
    chosen = (_normals(corners) @ frame[:3, 2] >= FLAT) & (np.abs(local[..., 2]) <= NEAR).all(
        axis=1
    )
    if not chosen.any():
        raise SceneError(
            f"no face of '{settings.surface.name}' lies in the empty's XY plane and faces its Z axis"
        )
    return local[chosen][..., :2]


def _floor_triangles(settings, depsgraph, metres: float) -> np.ndarray:
    """Triangles of the surface that are level and face up, or down if none faces up. (t, 3, 3) [m]"""
    corners = _corners(settings, depsgraph, metres)
    upward = _normals(corners)[:, 2]
    for chosen in (upward >= LEVEL, upward <= -LEVEL):
        if chosen.any():
            return corners[chosen]
    raise SceneError(f"nothing of '{settings.surface.name}' is level, so that it is no floor")


def _lay_floor(settings, frame, depsgraph, metres: float, spacing):
    """Places over what is level of the surface, their heights in the frame, cells and shape."""
    corners = _floor_triangles(settings, depsgraph, metres)
    local = (corners - frame[:3, 3]) @ frame[:3, :3]
    plane, cells, shape = sensor_layout.lay_over(local[..., :2], settings.border, spacing)
    return plane, sensor_layout.find_heights(plane, local) + settings.height, cells, shape


def floor_area(empty, depsgraph) -> float:
    """Area of what is level of the surface of sensors over a floor, seen from above. [m2]

    Raises
    ------
    SceneError    There is no surface, or nothing of it is level.
    """
    corners = _floor_triangles(empty.lumenray.sensor, depsgraph, metres_per_unit(depsgraph.scene))
    sides = corners[:, 1:, :2] - corners[:, :1, :2]
    return float(0.5 * np.abs(np.linalg.det(sides)).sum())


def signature_of(empty) -> tuple:
    """What of an empty says where its sensors stand; meshes are told of by Blender."""
    settings = empty.lumenray.sensor
    surface = settings.surface
    matrix = tuple(round(float(value), 6) for row in empty.matrix_world for value in row)
    names = SETTINGS + (SPHERE_SETTINGS if settings.layout == "SPHERE" else ())
    own = tuple(
        round(value, 6) if isinstance(value, float) else value
        for value in (getattr(settings, name) for name in names)
    )
    camera = camera_signature(empty) if settings.layout == "CAMERA" else ()
    own += ("spectrum",) if settings.use_spectrum else ()
    return (*own, "" if surface is None else identity_of(surface), matrix, *camera)
