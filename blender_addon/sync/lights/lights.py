"""Lights of Blender as lights of the engine: our physical parameters, or Blender's own meaning of watts."""

import numpy as np

from ....engine.errors import LumenrayError, SceneError
from ....engine.scene.checks import LARGEST_AMOUNT, check_item
from ....engine.scene.light import (
    AreaLight,
    LineLight,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
)
from ....engine.scene.spectrum import Spectrum, Tabulated
from ...foundation.report import ConversionReport
from ...luminaires.convert import LEFT_OUT, convert_luminaire
from ...luminaires.settings import is_luminaire, settings_of
from ...raysets.convert import convert_rays
from ...raysets.settings import is_rayset, rays_of
from ..nodes.evaluation import Context
from ..nodes.fields import luminance
from ..spectra import check_visible, convert_spectrum, light_spectrum
from ..visibility import is_dark, tell_linking
from .emission_node import evaluate_emission, find_emission, is_emission
from .ies_nodes import convert_ies_light, find_ies_emission

PHYSICAL_QUANTITIES = {
    "POINT": ("LUMINOUS_FLUX", "LUMINOUS_INTENSITY", "ILLUMINANCE", "LUMINANCE", "RADIANT_FLUX"),
    "SPOT": ("LUMINOUS_FLUX", "LUMINOUS_INTENSITY", "ILLUMINANCE", "RADIANT_FLUX"),
    "SUN": ("ILLUMINANCE", "LUMINANCE", "RADIANT_FLUX"),
    "AREA": ("LUMINOUS_FLUX", "LUMINOUS_INTENSITY", "ILLUMINANCE", "LUMINANCE", "RADIANT_FLUX"),
}
"""Quantities that make sense for each kind of Blender light."""


def convert_light(
    source,
    light_id: str,
    name: str,
    matrix,
    scale: float,
    efficacy: float,
    report,
    images=None,
    is_patient=True,
):
    """Convert a light object, or an empty that is a luminaire.

    Parameters
    ----------
    source : bpy.types.Object    Evaluated light or empty.
    light_id, name : str
    matrix : (4, 4) array    World matrix, in Blender units.
    scale : float    Metres per Blender unit.
    efficacy : float    Lumens per Blender watt. [lm/W]
    report : ConversionReport
    images : ImageCache or None    What was read of images before.
    is_patient : bool    Whether to wait for a ray file that is being prepared.

    Returns
    -------
    Light or None    None when it emits nothing, or cannot be computed.
    """
    place = (light_id, name, matrix, scale)
    if is_dark(source, name, report):
        return None
    tell_linking(source, name, report)
    if source.type == "LIGHT" and not source.data.use_shadow:
        report.error(name, "the light casts no shadows in Blender", "it casts them")
    try:
        light = _convert(source, place, efficacy, report, images, is_patient)
        if light is not None:
            check_item(light)
    except LumenrayError as error:
        report.fault(name, error, LEFT_OUT)
        return None
    return light


def is_tube(data) -> bool:
    """Whether a light is a tube, if no file says how it shines."""
    return data.type == "POINT" and data.lumenray.tube_length > 0.0


def place_tube(data, matrix, scale: float) -> tuple[np.ndarray, float, float]:
    """Frame (4, 4) of a tube along its x, length and radius, in the unit of ``scale`` for a Blender unit."""
    matrix = np.array(matrix, dtype=np.float64)
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    frame = _frame(matrix[:3, :3] / np.maximum(lengths, 1e-30), matrix[:3, 3] * scale)
    radius = data.shadow_soft_size * float(np.cbrt(np.prod(lengths))) * scale
    return frame, data.lumenray.tube_length * float(lengths[0]) * scale, radius


def _convert(source, place, efficacy, report, images, is_patient):
    """Convert a light by what decides how it shines."""
    if is_rayset(source) or is_luminaire(source):
        return _convert_from_file(source, place, report, images, is_patient)
    shaped = find_ies_emission(source.data, place[1], report, images)
    if shaped is not None:
        return convert_ies_light(source, shaped, _colour(source.data), *place, efficacy, report)
    return _convert_own(source, *place, efficacy, report, images)


def _convert_from_file(source, place, report, images, is_patient):
    """Convert a light that shines as a ray file or a photometric file says."""
    name = place[1]

    def own_spectrum():
        return _own_spectrum(source, name, report, images)

    if is_rayset(source):
        if is_luminaire(source):
            # The switches exclude each other, but files, scripts and animation can hold both.
            report.error(
                name,
                "the light has both a photometric file and a ray set switched on",
                "the ray set gives the light; switch one off",
            )
        return convert_rays(source, rays_of(source), *place, report, own_spectrum, is_patient)
    return convert_luminaire(source, settings_of(source), *place, report, own_spectrum)


def _convert_own(source, light_id, name, matrix, scale, efficacy, report, images):
    """Convert a light that shines as its kind does."""
    data = source.data
    matrix = np.array(matrix, dtype=np.float64)
    position = matrix[:3, 3] * scale
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    axes = matrix[:3, :3] / np.maximum(lengths, 1e-30)
    rgb = _colour(data)
    tint, strength = _node_emission(data, name, report, images)
    rgb = rgb * tint
    output = _output(data, name, rgb, strength, lengths, efficacy, report)
    if output is None:
        return None
    _tell_scales(data, name, lengths, scale, report)
    match data.type:
        case "POINT":
            if is_tube(data):
                placed = place_tube(data, matrix, scale)
                return LineLight(light_id, name, output, *placed, source.visible_camera)
            radius = data.shadow_soft_size * float(np.cbrt(np.prod(lengths))) * scale
            return PointLight(light_id, name, output, position, radius, source.visible_camera)
        case "SPOT":
            return SpotLight(
                light_id,
                name,
                output,
                position,
                -axes[:, 2],
                0.5 * data.spot_size,
                data.spot_blend,
                data.shadow_soft_size * float(np.cbrt(np.prod(lengths))) * scale,
            )
        case "SUN":
            return SunLight(light_id, name, output, -axes[:, 2], data.angle)
        case "AREA":
            return _area(
                data, source, light_id, name, output, axes, position, lengths * scale, report
            )
    report.error(name, f"lights of type {data.type} are unknown", "the light is left out")
    return None


def _tell_scales(data, name, lengths, scale, report) -> None:
    """Note what Blender makes of the scales of the object and of the scene, and this engine does not."""
    if data.type == "SPOT" and lengths.max() > 1.001 * lengths.min():
        report.error(
            name,
            "the spot is scaled unevenly, which makes its cone an ellipse in Blender",
            "the cone is round, of the angle that is stated; scale all axes alike",
        )
    if scale != 1.0 and data.type != "SUN" and not data.lumenray.use_physical:
        report.warn(
            "Unit scale",
            f"a Blender unit is {scale:g} m, which Blender's own renders leave out",
            f"distances are in metres: lights in watts light {scale**-2:.4g} times what Blender shows",
        )


def _area(data, source, light_id, name, output, axes, position, lengths, report):
    size_x = data.size * lengths[0]
    size_y = (data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size) * lengths[1]
    if abs(np.dot(axes[:, 0], axes[:, 1])) > 1e-4:
        report.warn(name, "the area light is sheared", "its sides are taken as perpendicular")
    frame = _frame(axes, position)
    shape = "ellipse" if data.shape in {"DISK", "ELLIPSE"} else "rectangle"
    return AreaLight(
        light_id, name, output, frame, size_x, size_y, shape, data.spread, source.visible_camera
    )


def _frame(axes, position) -> np.ndarray:
    """Rigid placement that keeps the direction of x. (4, 4)"""
    frame = np.eye(4)
    z = axes[:, 2] - axes[:, 0] * np.dot(axes[:, 0], axes[:, 2])
    frame[:3, 0] = axes[:, 0]
    frame[:3, 2] = z / np.linalg.norm(z)
    frame[:3, 1] = np.cross(frame[:3, 2], frame[:3, 0])
    frame[:3, 3] = position
    return frame


def _colour(data) -> np.ndarray:
    rgb = np.array(data.color, dtype=np.float64)
    if getattr(data, "use_temperature", False):
        # Blender's colour of a temperature has luminance 1, so lumens do not change.
        rgb = rgb * np.array(data.temperature_color)
    return rgb


def _own_spectrum(source, name, report, images) -> Spectrum:
    """Return the spectrum that is chosen for a luminaire in Blender."""
    if source.type == "EMPTY":
        settings = source.lumenray.luminaire
        return convert_spectrum(settings, settings.color, report, name)
    data = source.data
    rgb = _colour(data) * _node_emission(data, name, report, images)[0]
    if data.lumenray.use_physical:
        return convert_spectrum(data.lumenray, rgb, report, name)
    return light_spectrum(rgb)


def _node_emission(data, name: str, report: ConversionReport, images) -> tuple[np.ndarray, float]:
    """Colour and strength of the light's own node tree, (1, 1, 1) and 1 without one."""
    white = np.ones(3)
    origin = find_emission(data)
    if origin is None:
        return white, 1.0
    if not is_emission(origin):
        report.error(
            name,
            "the light's nodes do not end in an Emission node",
            "colour and power of the light are used",
        )
        return white, 1.0
    return evaluate_emission(origin, Context(name, report, images))


def _check_amount(value: float) -> None:
    """Refuse light that is none. Raises `SceneError`."""
    if not 0.0 <= value <= LARGEST_AMOUNT:
        raise SceneError(
            f"its amount of light is {value:.3g}, expected a number from 0 to {LARGEST_AMOUNT:g}"
        )


def _output(data, name, rgb, strength, lengths, efficacy, report) -> Output | None:
    settings = data.lumenray
    if settings.use_physical:
        if settings.value == 0.0:
            return None
        _check_amount(settings.value)
        if settings.quantity not in PHYSICAL_QUANTITIES[data.type]:
            report.error(
                name,
                f"{settings.quantity.replace('_', ' ').lower()} is not defined for a {data.type.lower()} light",
                "the light is left out; choose another quantity",
            )
            return None
        spectrum = convert_spectrum(settings, rgb, report, name)
        quantity = Quantity[settings.quantity]
        if isinstance(spectrum, Tabulated):
            check_visible(spectrum, quantity is Quantity.RADIANT_FLUX, name, report)
        return Output(quantity, settings.value, spectrum)
    lumens = (
        data.energy
        * 2.0 ** getattr(data, "exposure", 0.0)
        * strength
        * efficacy
        * float(np.ravel(luminance(rgb))[0])
    )
    if lumens == 0.0:
        return None
    _check_amount(lumens)
    spectrum = light_spectrum(rgb)
    spread_out = not getattr(data, "normalize", True)
    match data.type:
        case "POINT" if is_tube(data):
            # What a ball of the same settings sends, and of its luminance.
            if spread_out:
                return Output(Quantity.LUMINANCE, lumens / np.pi, spectrum)
        case "POINT" | "SPOT":
            factor = (
                (data.shadow_soft_size * float(np.cbrt(np.prod(lengths)))) ** 2
                if spread_out
                else 0.25 / np.pi
            )
            return Output(Quantity.LUMINOUS_INTENSITY, lumens * factor, spectrum)
        case "SUN":
            factor = np.pi * np.sin(0.5 * data.angle) ** 2 if spread_out else 1.0
            return Output(Quantity.ILLUMINANCE, lumens * factor, spectrum)
        case "AREA" if spread_out:
            return Output(Quantity.LUMINANCE, lumens / np.pi, spectrum)
    return Output(Quantity.LUMINOUS_FLUX, lumens, spectrum)
