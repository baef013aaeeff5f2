"""Lights of Blender as lights of the engine: our physical parameters, or Blender's own meaning of watts."""

import numpy as np

from ....engine.errors import LumenrayError, SceneError
from ....engine.scene.checks import LARGEST_AMOUNT, check_item
from ....engine.scene.light import Output, Quantity
from ....engine.scene.spectrum import Spectrum, Tabulated
from ...foundation.report import ConversionReport
from ...luminaires.convert import LEFT_OUT, convert_luminaire
from ...luminaires.settings import is_luminaire, settings_of
from ...raysets.convert import convert_rays
from ...raysets.settings import is_rayset, rays_of
from ..departures import LIGHT, tell
from ..nodes.dependencies import nodes_of
from ..nodes.fields import luminance
from ..nodes.rays import RayContext
from ..spectra import check_visible, convert_spectrum, light_spectrum
from ..visibility import is_dark, tell_linking
from .emission_node import evaluate_emission, find_emission, is_emission
from .ies_nodes import convert_ies_light, find_ies_emission
from .kinds import Kind, Place, kind_of
from .shaped import convert_shaped_light, find_shape


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
    if source.type == "LIGHT":
        tell(LIGHT, source.data, name, report)
        if not source.data.use_shadow:
            report.error(
                name,
                "the light casts no shadows in Blender",
                "it casts them; switch off the ray visibility for light of what is to cast none",
            )
    try:
        light = _convert(source, place, efficacy, report, images, is_patient)
        if light is not None:
            check_item(light)
    except LumenrayError as error:
        report.fault(name, error, LEFT_OUT)
        return None
    return light


def _convert(source, place, efficacy, report, images, is_patient):
    """Convert a light by what decides how it shines."""
    if is_rayset(source) or is_luminaire(source):
        return _convert_from_file(source, place, report, images, is_patient)
    shaped = find_ies_emission(source.data, place[1], report, images)
    if shaped is not None:
        return convert_ies_light(source, shaped, _colour(source.data), *place, efficacy, report)
    shape = find_shape(source.data, place[2], place[1], report, images)
    if shape is not None:
        _tell_scale(source.data, place[3], report)
        return convert_shaped_light(source, shape, _colour(source.data), *place, efficacy, report)
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
    data, kind = source.data, kind_of(source.data)
    tint, strength = _node_emission(data, name, report, images)
    is_seen = source.visible_camera and _is_seen(data, tint * strength, name, report, images)
    place = Place(light_id, name, matrix, scale, is_seen)
    output = _output(data, kind, place, _colour(data) * tint, strength, efficacy, report)
    if output is None:
        return None
    fault = kind.find_fault(data, place)
    if fault is not None:
        report.error(name, *fault)
    _tell_scale(data, scale, report)
    return kind.make(data, place, output)


def _tell_scale(data, scale: float, report) -> None:
    """Note what metres change of a light that is stated in watts."""
    is_flux = kind_of(data).whole is Quantity.LUMINOUS_FLUX
    if scale != 1.0 and is_flux and not data.lumenray.use_physical:
        report.warn(
            "Unit scale",
            f"a Blender unit is {scale:g} m, which Blender's own renders leave out",
            f"distances are in metres: lights in watts light {scale**-2:.4g} times what Blender shows",
        )


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
    return evaluate_emission(origin, RayContext(name, report, images))


def _is_seen(data, given, name: str, report: ConversionReport, images) -> bool:
    """Tell whether the camera sees a light by its nodes. ``given``: colour times strength of its light. (3,)"""
    origin = find_emission(data)
    if origin is None or not is_emission(origin):
        return True
    if all(node.bl_idname != "ShaderNodeLightPath" for node in nodes_of(data.node_tree)):
        return True
    context = RayContext(name, ConversionReport(), images, is_camera=True)
    tint, strength = evaluate_emission(origin, context)
    seen = tint * strength
    if not seen.any():
        return False
    if not np.allclose(seen, given, rtol=1e-3):
        report.warn(
            name,
            "the camera sees the light otherwise than it lights",
            "pictures show what gives light; hide it from the camera, or show it by a mesh that light does not meet",
        )
    return True


def _check_amount(value: float) -> None:
    """Refuse light that is none. Raises `SceneError`."""
    if not 0.0 <= value <= LARGEST_AMOUNT:
        raise SceneError(
            f"its amount of light is {value:.3g}, expected a number from 0 to {LARGEST_AMOUNT:g}"
        )


def _output(data, kind: Kind, place: Place, rgb, strength, efficacy, report) -> Output | None:
    settings, name = data.lumenray, place.name
    if settings.use_physical:
        if settings.value == 0.0:
            return None
        _check_amount(settings.value)
        if settings.quantity not in kind.quantities:
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
    watts = data.energy * 2.0 ** getattr(data, "exposure", 0.0)
    lumens = watts * strength * efficacy * float(np.ravel(luminance(rgb))[0])
    if lumens == 0.0:
        return None
    _check_amount(lumens)
    return Output(*kind.amount(data, place, lumens), light_spectrum(rgb))
