"""Lights of the scene description as emitters, with their luminous bodies."""

from dataclasses import dataclass, fields

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import pointer_id
from ...errors import SceneError
from ...luminaires.emitters.palette import KINDS, Row, opening_frame
from ...luminaires.emitters.rectangle_plugin import RectangleRow
from ...luminaires.emitters.tables import distribution_digest
from ...luminaires.openings import check_opening
from ...photometry import units
from ...scene.light import (
    AreaLight,
    Light,
    LineLight,
    Luminaire,
    PlacedLight,
    PointLight,
    SpotLight,
)
from . import emission
from .light_bodies import Flat, Sphere, Tube
from .lights import Source
from .opening_bodies import make_body

DELTA_RADIUS = 1e-5
"""Point lights smaller than this are ideal points. [m]"""


@dataclass
class CompiledLight:
    """A light of the scene description at work.

    ``body`` is the shape that is seen and ``outline`` what is known of it, one of `light_bodies` or an `OpeningBody`; None
    for ideal points and spots.
    """

    item: object
    source: Source
    body: object | None = None
    outline: object | None = None

    @property
    def body_id(self) -> int:
        """Number of the shape in kernels."""
        return pointer_id(self.body)

    def put_into(self, pool) -> None:
        """Tell a `SurfacePool` about the body."""
        self.outline.put_into(pool, self.body_id)


@dataclass
class Shared:
    """What the lights of a compiled scene share.

    Parameters
    ----------
    origin : (3,) array    Of the compiled scene's frame. [m]
    nothing : mi.BSDF    What bodies are made of for others' light.
    luminaires : mi.Emitter or None    That of all luminaires of the scene; no other light needs it.
    rectangles : mi.Emitter or None    That of all rectangular area lights, likewise.
    """

    origin: np.ndarray
    nothing: object
    luminaires: object | None = None
    rectangles: object | None = None


def compile_light(light: Light, shared: Shared) -> CompiledLight | None:
    """Make the emitter of a light and its body, None when it gives no light or shines from infinity."""
    if light.output.value <= 0.0 or not isinstance(light, PlacedLight):
        return None
    return MAKERS[type(light)](light, shared)


def change_light(compiled: CompiledLight, light: Light, shared: Shared) -> bool | None:
    """Change a light with a body in place, so that kernels do not change.

    Returns
    -------
    bool or None    Whether its body stands elsewhere or has another size; None when it cannot be done in place.
    """
    old = compiled.item
    if compiled.body is None or type(old) is not type(light) or light.output.value <= 0.0:
        return None
    if isinstance(light, Luminaire):
        return _change_luminaire(compiled, light, shared.origin)
    new = compile_light(light, shared)
    if new is None or new.body is None or new.body.shape_type() != compiled.body.shape_type():
        return None
    if new.source.rectangle is not None:
        compiled.source.rectangle = new.source.rectangle
    else:
        if new.source.emitter.is_narrow != compiled.source.emitter.is_narrow:
            return None
        compiled.source.emitter.__dict__.update(new.source.emitter.__dict__)
    is_moved = not all(
        np.array_equal(getattr(old, entry.name), getattr(light, entry.name))
        for entry in fields(light)
        if entry.name not in {"id", "name", "output", "visible_to_camera", "spread"}
    )
    if is_moved:
        _set_place(compiled.body, mi.traverse(new.body)["to_world"])
    compiled.item, compiled.outline = light, new.outline
    source = compiled.source
    source.flux, source.density = new.source.flux, new.source.density
    source.centre, source.radius = new.source.centre, new.source.radius
    source.axis = new.source.axis
    return is_moved


def is_rectangle(light: Light) -> bool:
    """Whether a light is one of the rectangles that share an emitter."""
    return isinstance(light, AreaLight) and light.shape != "ellipse"


def _tan_spread(spread: float) -> float:
    """Tangent of half of Blender's spread [rad], 0 where all of the half-space is lit as by a Lambertian surface."""
    return float(np.tan(0.5 * spread)) if spread < np.pi - 1e-3 else 0.0


def surface_emitter(luminance, two_sided=False, pattern=None, spread=np.pi):
    """Emitter of a luminous surface. ``luminance``: its luminance; ``pattern``: texture that multiplies it."""
    plugin = {"type": "lumenray_surface", "radiance": luminance.texture(), "two_sided": two_sided}
    if pattern is not None:
        plugin["pattern"] = pattern
    plugin["tan_spread"] = _tan_spread(spread)
    return mi.load_dict(plugin)


def _make_point(light: PointLight, shared: Shared) -> CompiledLight:
    intensity = emission.point_intensity(light)
    flux, centre = 4.0 * np.pi * intensity.amount, light.place - shared.origin
    place = [float(x) for x in centre]
    if light.radius < DELTA_RADIUS:
        emitter = mi.load_dict(
            {"type": "point", "position": place, "intensity": intensity.texture()}
        )
        return CompiledLight(light, Source(emitter, flux, intensity.density, centre))
    emitter = surface_emitter(
        intensity.scaled(units.luminance_from_intensity_sphere(1.0, light.radius))
    )
    emitter.set_ball(place, float(light.radius))
    shape = {"type": "sphere", "center": place, "radius": float(light.radius)}
    source = Source(emitter, flux, intensity.density, centre, float(light.radius))
    return _with_body(light, shape, source, shared, Sphere(centre, float(light.radius)))


def _make_spot(light: SpotLight, shared: Shared) -> CompiledLight:
    intensity = emission.spot_intensity(light)
    centre = light.place - shared.origin
    plugin = {
        "type": "lumenray_spot",
        "intensity": intensity.texture(),
        "position": [float(x) for x in centre],
        "direction": [float(x) for x in light.direction],
        "cap": float(2.0 * np.sin(0.5 * light.half_angle) ** 2),
        "blend": float(light.blend),
        "radius": float(light.radius),
    }
    flux = intensity.amount * units.spot_solid_angle(light.half_angle, light.blend)
    axis = np.asarray(light.direction, dtype=np.float64)
    source = Source(
        mi.load_dict(plugin),
        flux,
        intensity.density,
        centre,
        light.radius,
        axis / np.linalg.norm(axis),
        cone=float(np.cos(light.half_angle)),
    )
    return CompiledLight(light, source)


def _make_area(light: AreaLight, shared: Shared) -> CompiledLight:
    if light.area <= 0.0:
        raise SceneError(f"area light '{light.name}' has no area; give it a size above 0")
    luminance = emission.area_luminance(light)
    flux = luminance.amount * np.pi * light.area / units.spread_axis_factor(light.spread)
    frame = _local(light.frame, shared.origin)
    is_ellipse = not is_rectangle(light)
    # Blender's area lights shine along -z, Mitsuba's flat shapes along +z: turn about x.
    placed = frame @ np.diag([0.5 * light.size_x, -0.5 * light.size_y, -1.0, 1.0])
    shape = {"type": "disk" if is_ellipse else "rectangle", "to_world": _transform(placed)}
    row, emitter = None, shared.rectangles
    if is_ellipse:
        emitter = surface_emitter(luminance, spread=light.spread)
    else:
        row = RectangleRow(
            *placed[:3, [3, 0, 1]].T,
            luminance.known_amount,
            luminance.density,
            _tan_spread(light.spread),
        )
    source = Source(
        emitter, flux, luminance.density, frame[:3, 3], light.reach, -frame[:3, 2], rectangle=row
    )
    flat = Flat(frame, light.size_x, light.size_y, light.area, is_ellipse, light.spread)
    return _with_body(light, shape, source, shared, flat)


def _make_line(light: LineLight, shared: Shared) -> CompiledLight:
    luminance = emission.line_luminance(light)
    tube = Tube(_local(light.frame, shared.origin), float(light.length), float(light.radius))
    # Mitsuba's cylinder lies along z, from 0 to 1.
    x, y, z = tube.frame[:3, :3].T
    placed = np.eye(4)
    placed[:3] = np.column_stack([y * tube.radius, z * tube.radius, x * tube.length, tube.start])
    shape = {"type": "cylinder", "to_world": _transform(placed)}
    emitter = surface_emitter(luminance)
    emitter.set_tube(tube.start, x * tube.length, tube.radius)
    flux = luminance.amount * np.pi * light.area
    source = Source(emitter, flux, luminance.density, tube.frame[:3, 3], light.reach)
    return _with_body(light, shape, source, shared, tube)


def _make_luminaire(light: Luminaire, shared: Shared) -> CompiledLight:
    row = _row_of(light, shared.origin, distribution_digest(light.distribution))
    flux = emission.luminaire_flux(light)
    source = Source(
        shared.luminaires, flux.amount, flux.density, row.centre, row.radius, luminaire=row
    )
    if light.opening.shape == "point":
        return CompiledLight(light, source)
    opening = make_body(light.opening.shape, row, shared.nothing)
    return CompiledLight(light, source, opening.shape, opening)


MAKERS = {
    PointLight: _make_point,
    SpotLight: _make_spot,
    AreaLight: _make_area,
    LineLight: _make_line,
    Luminaire: _make_luminaire,
}
"""What makes emitter and body of a kind of light, from the light and what all share."""


def _row_of(light: Luminaire, origin, digest: bytes) -> Row:
    check_opening(light.opening, f"luminaire '{light.name}'")
    if light.rays is not None and light.opening.shape != "point":
        raise SceneError(f"luminaire '{light.name}' has rays and an opening; expected one of them")
    frame = np.asarray(light.frame, dtype=np.float64)
    rotation = frame[:3, :3]
    if not np.allclose(rotation.T @ rotation, np.eye(3), atol=1e-4):
        raise SceneError(f"luminaire '{light.name}' is scaled or sheared; its frame must be rigid")
    axes, half = opening_frame(light.opening, rotation)
    flux = emission.luminaire_flux(light)
    return Row(
        light.distribution,
        digest,
        rotation @ light.distribution.frame,
        KINDS[light.opening.shape],
        axes,
        half,
        frame[:3, 3] - origin,
        flux.known_amount,
        flux.density,
        None if light.rays is None else rotation,
        light.rays,
    )


def _change_luminaire(compiled: CompiledLight, light: Luminaire, origin) -> bool | None:
    """As `change_light`: all but place and size are numbers in the palette's table."""
    old = compiled.item
    if (
        old.rays is not light.rays
        or old.opening != light.opening
        or not np.array_equal(old.frame, light.frame)
    ):
        return None
    is_same = old.distribution is light.distribution
    digest = (
        compiled.source.luminaire.digest if is_same else distribution_digest(light.distribution)
    )
    row, flux = _row_of(light, origin, digest), emission.luminaire_flux(light)
    compiled.item = light
    compiled.source.luminaire, compiled.source.flux, compiled.source.density = (
        row,
        flux.amount,
        flux.density,
    )
    return False


def _local(frame, origin) -> np.ndarray:
    """Placement in the scene's frame. (4, 4) [m]"""
    local = np.array(frame, dtype=np.float64)
    local[:3, 3] -= origin
    return local


def _transform(matrix: np.ndarray):
    return mi.ScalarTransform4f([list(row) for row in matrix])


def _with_body(light, shape: dict, source: Source, shared: Shared, outline) -> CompiledLight:
    """Give a light its luminous body; light of others passes it, as in Blender."""
    # An emitter that lights share belongs to no shape.
    own = {"emitter": source.emitter} if source.rectangle is None else {}
    body = mi.load_dict({**shape, "bsdf": shared.nothing, **own})
    # Mitsuba keeps a rectangle's place as a part of kernels until it is set anew.
    _set_place(body, mi.traverse(body)["to_world"])
    return CompiledLight(light, source, body, outline)


def _set_place(shape, place) -> None:
    values = mi.traverse(shape)
    dr.make_opaque(place)
    values["to_world"] = place
    values.update()
