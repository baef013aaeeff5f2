"""Points and spots whose light is not the same about their axis: by nodes of the direction, or by an uneven scale.

They become luminaires: candelas on a grid of directions, as a photometric file would state them.
"""

from dataclasses import dataclass, replace

import numpy as np

from ....engine.errors import SceneError
from ....engine.luminaires.coordinates import directions
from ....engine.luminaires.distribution import flux
from ....engine.photometry.filtered_light import filtered_luminance
from ....engine.scene.distribution import IntensityDistribution
from ....engine.scene.light import Luminaire, Output, Quantity
from ...foundation.pose import pose_of
from ...foundation.report import ConversionReport
from ...luminaires.convert import own_opening, reflected
from ..nodes.evaluation import evaluate_field
from ..nodes.fields import LUMINANCE, Field, map_fields, rgb
from ..nodes.graph import find_socket
from ..spectra import convert_spectrum, light_spectrum
from .emission_node import find_emission, is_emission
from .ies_nodes import physical_output
from .kinds import Place, Spot, is_scaled_unevenly, kind_of
from .light_directions import LAYOUT, LightContext, knows_directions
from .readings import Reading

ROWS, COLUMNS = 361, 720
"""Polar angles over what is lit, and azimuths, of the grid."""

WIDEST = np.deg2rad(89.0)
"""Half angle of a scaled cone from which on the whole sphere is taken."""

SAME_COLOUR = 1e-3
"""Difference, relative to the largest number, up to which all directions have the same colour. [-]"""


@dataclass(frozen=True, eq=False)
class Shape:
    """What a light's nodes give by the direction.

    ``azimuth``, ``polar``: of the grid [rad]; ``values``: colour times strength. (a, p, 3) [-]
    """

    azimuth: np.ndarray
    polar: np.ndarray
    values: np.ndarray


def find_shape(data, matrix, name: str, report: ConversionReport, images) -> Shape | None:
    """Find out whether a light's directions differ otherwise than by a round cone.

    Parameters
    ----------
    data : bpy.types.Light
    matrix : (4, 4) array    World matrix, in Blender units.
    name, report, images    As of `sync.lights.convert_light`.

    Returns
    -------
    Shape or None    None where they do not, or where nodes give what is not known.
    """
    if data.type not in {"POINT", "SPOT"} or data.lumenray.tube_length > 0.0:
        return None
    linear = np.array(matrix, dtype=np.float64)[:3, :3]
    lengths = np.linalg.norm(linear, axis=0)
    is_uneven = data.type == "SPOT" and is_scaled_unevenly(lengths)
    origin = find_emission(data)
    if origin is not None and not is_emission(origin):
        origin = None
    if lengths.min() < 1e-9 or not (is_uneven or (origin and knows_directions(data.node_tree))):
        return None
    half = 0.5 * data.spot_size if data.type == "SPOT" else None
    azimuth = np.linspace(0.0, 2.0 * np.pi, COLUMNS + 1)
    polar = np.linspace(0.0, _reach(half, lengths), ROWS)
    field = Field(np.ones(1, np.float32))
    if origin is not None:
        own = ConversionReport()
        context = LightContext(name, own, images, azimuth, polar, linear, half)
        inputs = origin.socket.node.inputs
        colour, strength = (
            evaluate_field(find_socket(inputs, key), context, origin.groups)
            for key in ("Color", "Strength")
        )
        field = map_fields(
            lambda c, s: c * s, colour, strength, note=lambda *words: own.warn(name, *words)
        )
        if field.is_stand_in or (field.is_constant and not is_uneven):
            return None
        if not field.is_constant and field.layout is not LAYOUT:
            return None
        report.include_new(own)
    values = rgb(np.asarray(field.values, dtype=np.float64))
    if field.is_constant:
        values = np.broadcast_to(values, (ROWS, COLUMNS + 1, 3))
    return Shape(azimuth, polar, np.swapaxes(values, 0, 1))


def read_ellipse(reading: Reading, quantity: Quantity, data, lengths) -> Reading:
    """Return what an unevenly scaled spot gives. ``reading``: of its round cone; ``quantity``: in which it is stated."""
    half = 0.5 * data.spot_size
    azimuth = np.linspace(0.0, 2.0 * np.pi, COLUMNS + 1)
    polar = np.linspace(0.0, _reach(half, lengths), ROWS)
    share = _within_cone(data, azimuth, polar, lengths)
    per_candela = flux(IntensityDistribution(azimuth, polar, share))
    if quantity in {Quantity.LUMINOUS_FLUX, Quantity.RADIANT_FLUX}:
        candelas = reading.flux / per_candela
        return replace(reading, intensity=candelas, illuminance=candelas)
    return replace(reading, flux=reading.intensity * per_candela)


def convert_shaped_light(
    source, shape: Shape, colour, light_id, name, matrix, scale, efficacy, report
) -> Luminaire | None:
    """Convert a light that has a shape.

    Parameters
    ----------
    source : bpy.types.Object    Evaluated light object.
    shape : Shape
    colour : (3,) array    Of the light itself.
    light_id, name, matrix, scale, efficacy, report
        As of `sync.lights.convert_light`.

    Returns
    -------
    Luminaire or None    None when it emits nothing.

    Raises
    ------
    LumenrayError    It has no directions, or states what it cannot have.
    """
    data, pose = source.data, pose_of(matrix, scale)
    values = shape.values * np.asarray(colour)
    if values.min() < 0.0:
        report.error(name, "the light is negative in some directions", "no light is given there")
        values = np.maximum(values, 0.0)
    amounts = values @ LUMINANCE.astype(np.float64)
    is_coloured = not _is_even(values)
    if is_coloured and data.lumenray.use_physical and data.lumenray.spectrum != "RGB":
        # The lamp's own spectrum takes the place of its colour, and the slide filters it.
        values = np.maximum(shape.values, 0.0)
        lamp = convert_spectrum(data.lumenray, colour, ConversionReport(), name)
        amounts = filtered_luminance(values, lamp)
    if data.type == "SPOT":
        amounts = amounts * _within_cone(data, shape.azimuth, shape.polar, pose.lengths)
    colours = values.astype(np.float32) if is_coloured else None
    distribution = IntensityDistribution(shape.azimuth, shape.polar, amounts, colours=colours)
    whole = flux(distribution) if amounts.any() else 0.0
    if whole <= 0.0:
        return None
    colour = np.ones(3) if is_coloured else _common_colour(values)
    if data.lumenray.use_physical:
        output = physical_output(data, distribution, colour, name, report, "shaped by its nodes")
    else:
        watts = data.energy * 2.0 ** getattr(data, "exposure", 0.0)
        place = Place(light_id, name, matrix, scale)
        quantity, amount = kind_of(data).amount(data, place, watts * efficacy)
        if quantity is not Quantity.LUMINOUS_INTENSITY:
            raise SceneError(f"a shaped light cannot be stated by its {quantity.value}")
        output = Output(Quantity.LUMINOUS_FLUX, amount * whole, light_spectrum(colour))
    if output.value == 0.0:
        return None
    return Luminaire(
        id=light_id,
        name=name,
        output=output,
        frame=pose.frame,
        distribution=reflected(distribution, pose),
        opening=own_opening(data, pose),
        visible_to_camera=source.visible_camera and not isinstance(kind_of(data), Spot),
    )


def _reach(half: float | None, lengths) -> float:
    """Largest polar angle that a light shines at. [rad]"""
    if half is None:
        return np.pi
    if half >= WIDEST:
        return np.pi
    return float(np.arctan(np.tan(half) * max(lengths[:2]) / lengths[2]))


def _within_cone(data, azimuth, polar, lengths) -> np.ndarray:
    """What a spot's cone lets through, which is round before the object's scale. (a, p)"""
    away = directions(azimuth[:, None], polar[None, :]) / np.asarray(lengths)
    cosine = -away[..., 2] / np.linalg.norm(away, axis=-1)
    end = np.cos(0.5 * data.spot_size)
    width = (1.0 - end) * data.spot_blend
    if width <= 0.0:
        return (cosine >= end).astype(np.float64)
    place = np.clip((cosine - end) / width, 0.0, 1.0)
    return place * place * (3.0 - 2.0 * place)


def _common_colour(values: np.ndarray) -> np.ndarray:
    """Colour of the light of all directions, of luminance 1. (3,)"""
    amounts = values @ LUMINANCE.astype(np.float64)
    return values.reshape(-1, 3).sum(axis=0) / amounts.sum()


def _is_even(values: np.ndarray) -> bool:
    """Whether all directions have the same colour."""
    amounts = values @ LUMINANCE.astype(np.float64)
    if amounts.sum() <= 0.0:
        return True
    apart = np.abs(values - amounts[..., None] * _common_colour(values)).max()
    return bool(apart <= SAME_COLOUR * values.max())
