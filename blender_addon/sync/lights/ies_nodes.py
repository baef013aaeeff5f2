"""Lights that an IES texture shapes in their node tree, with the meaning that Cycles gives them.

Cycles makes of the texture a factor 4 pi / 177.83 times candelas, so that a point or spot light of 1 W gives the file's
candelas at 177.83 lm/W. It counts the angles in other axes than the standard: C runs clockwise, from -Y. Where Cycles errs
about the file itself (the second factor of editions since 1995, files that it cannot read), the file is right.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ....engine.errors import LumenrayError, SceneError
from ....engine.luminaires.amount import tilt_factor
from ....engine.luminaires.coordinates import FRAMES
from ....engine.luminaires.distribution import flux, intensity, peak
from ....engine.luminaires.formats.record import RADIANT
from ....engine.photometry.units import BLENDER_EFFICACY
from ....engine.scene.distribution import IntensityDistribution
from ....engine.scene.light import Luminaire, Output, Quantity
from ...file_assets.kind import NoFileError
from ...file_assets.settings import LIGHT_TYPES
from ...foundation.pose import pose_of
from ...foundation.report import ConversionReport
from ...luminaires.convert import LEFT_OUT, NOTHING_VISIBLE, own_opening, reflected, tilt_of
from ...luminaires.files import Reading, photometric_files
from ..nodes.evaluation import Context
from ..nodes.fields import luminance
from ..spectra import convert_spectrum, light_spectrum
from .cone import within_cone
from .emission_node import evaluate_emission, find_emission, is_emission
from .kinds import is_ellipse, is_spread_out, sizes_of

CYCLES_FRAMES = {
    "C": np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "A": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "B": np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
}
"""Axes of the grid of each photometric type as Cycles takes them, as columns, in the light's axes."""

FACTOR_PER_CANDELA = 4.0 * np.pi / BLENDER_EFFICACY
"""What the texture gives for a candela at a strength of 1."""

TOLERANCE = 1e-4
"""Relative departure from proportion at which what nodes make of an IES texture is no mere factor."""


@dataclass(frozen=True, eq=False)
class IesEmission:
    """What arrives at a light's Emission node.

    Parameters
    ----------
    node : bpy.types.ShaderNodeTexIES
    reading : Reading    Of its file.
    colour : (3,) float64 array    Colour times strength where the texture gives 1, its own strength included.
    """

    node: bpy.types.Node
    reading: Reading
    colour: np.ndarray


class _Trial(Context):
    """Conversion in which all IES textures give the same number, so that what nodes make of it shows."""

    def __init__(self, datablock, report, images, value):
        super().__init__(datablock, report, images)
        self.value = value
        self.nodes: dict[int, bpy.types.Node] = {}

    def take_profile(self, node) -> float:
        self.nodes[node.as_pointer()] = node
        return self.value


def find_ies_emission(data, name: str, report: ConversionReport, images) -> IesEmission | None:
    """Find the IES texture that shapes a light.

    Parameters
    ----------
    data : bpy.types.Light
    name : str    For the report.
    report : ConversionReport    Where departures of the nodes go if there is such a texture.
    images : ImageCache or None

    Returns
    -------
    IesEmission or None    None if there is no such texture.

    Raises
    ------
    LumenrayError    There are several, nodes do more with it than multiplying it, or its file cannot be read.
    """
    origin = find_emission(data) if data.type in LIGHT_TYPES else None
    if origin is None or not is_emission(origin):
        return None

    def emit(value, where):
        trial = _Trial(name, where, images, value)
        colour, strength = evaluate_emission(origin, trial)
        return colour * strength, trial.nodes

    rows = ConversionReport()
    nodes = emit(1.0, rows)[1]
    if not nodes:
        return None
    report.include(rows)
    if len(nodes) > 1:
        raise SceneError("several IES textures shape the light, expected one")
    node = next(iter(nodes.values()))
    reading = read_profile(node)
    # What clamps and curves do shows at the numbers that the texture really gives.
    largest = FACTOR_PER_CANDELA * peak(reading.distribution)[0] or 1.0
    none, half, whole = (emit(largest * s, ConversionReport())[0] for s in (0.0, 0.5, 1.0))
    allowed = TOLERANCE * max(float(np.abs(whole).max()), 1e-12)
    if np.abs(none).max() > allowed or np.abs(whole - 2.0 * half).max() > allowed:
        raise SceneError(
            "nodes do more with the IES texture than multiplying it, which cannot be taken over"
        )
    return IesEmission(node, reading, whole / largest)


def convert_ies_light(
    source,
    emission: IesEmission,
    rgb,
    light_id: str,
    name: str,
    matrix,
    scale: float,
    efficacy: float,
    report: ConversionReport,
) -> Luminaire | None:
    """Convert a light that an IES texture shapes.

    Parameters
    ----------
    source : bpy.types.Object    Evaluated light object.
    emission : IesEmission
    rgb : (3,) array    Colour of the light itself.
    light_id, name, matrix, scale, efficacy, report
        As of `sync.lights.convert_light`.

    Returns
    -------
    Luminaire or None    None when it emits nothing, or its file cannot be read.
    """
    data = source.data
    rgb = np.asarray(rgb) * emission.colour
    reading = emission.reading
    if reading.file.quantity == RADIANT and not data.lumenray.use_physical:
        # Cycles takes the watts for candelas, and shows white light.
        told = f"the IES texture's file holds radiant intensities, {reading.flux:.4g} W without a spectrum"
        report.warn(name, told, NOTHING_VISIBLE, emission.node.name)
        return None
    try:
        pose = pose_of(matrix, scale)
        distribution = _seen_by_cycles(reading)
        if data.type == "SPOT":
            distribution = within_cone(distribution, 0.5 * data.spot_size, data.spot_blend)
        if distribution is None:
            return None
        if data.lumenray.use_physical:
            output = physical_output(data, distribution, rgb, name, report, "with an IES texture")
        else:
            tilt = tilt_factor(reading.file.tilt, tilt_of(pose.frame))
            candelas = tilt * _candelas(data, pose, scale, efficacy, rgb)
            output = Output(
                Quantity.LUMINOUS_FLUX, candelas * flux(distribution), light_spectrum(rgb)
            )
    except LumenrayError as error:
        report.fault(name, error, LEFT_OUT, emission.node.name)
        return None
    if output.value <= 0.0:
        return None
    for remark in reading.file.remarks:
        report.info(name, str(remark), "the file is read so", emission.node.name)
    if data.type == "AREA":
        report.warn(
            name,
            "an IES texture on an area light, which Cycles makes up to four times as bright as the file says",
            "the file's candelas are taken, as on a point light",
            emission.node.name,
        )
    return Luminaire(
        id=light_id,
        name=name,
        output=output,
        frame=pose.frame,
        distribution=reflected(distribution, pose),
        opening=own_opening(data, pose),
        visible_to_camera=source.visible_camera,
    )


def read_profile(node) -> Reading:
    """Read the file of an IES texture.

    Raises
    ------
    LumenrayError    There is none, it is refused, or it is of a format that Cycles does not read.
    """
    if node.mode == "INTERNAL":
        if node.ies is None:
            raise NoFileError("the IES texture has no text data-block")
        reading = photometric_files.obtain_text(node.ies)
    elif node.filepath:
        path = bpy.path.abspath(node.filepath, library=node.id_data.library)
        reading = photometric_files.obtain_path(str(Path(path)))
    else:
        raise NoFileError("the IES texture has no file")
    if not reading.file.format.startswith("LM-63"):
        raise SceneError(
            f"the IES texture's file is {reading.file.format}, expected LM-63; "
            "load it as the light's photometric file instead"
        )
    return reading


def _seen_by_cycles(reading) -> IntensityDistribution:
    distribution, kind = reading.distribution, reading.file.photometric_type
    frame = CYCLES_FRAMES[kind] @ FRAMES[kind].T @ distribution.frame
    return replace(distribution, frame=frame)


def _candelas(data, pose, scale, efficacy, rgb) -> float:
    """Candelas in the scene for each candela of the file."""
    watts = data.energy * 2.0 ** getattr(data, "exposure", 0.0)
    if is_spread_out(data):
        # In Blender units, as Blender does it: its watts then are those of a unit of emitting area.
        x, y, z = (length / scale for length in pose.lengths)
        if data.type == "AREA":
            watts *= float(np.prod(sizes_of(data))) * x * y
            watts *= 0.25 * np.pi if is_ellipse(data) else 1.0
        else:
            watts *= 4.0 * np.pi * (data.shadow_soft_size * float(np.cbrt(x * y * z))) ** 2
    tint = float(np.ravel(luminance(np.asarray(rgb)))[0])
    return watts * tint * efficacy / BLENDER_EFFICACY


def physical_output(data, distribution, rgb, name, report, how: str) -> Output:
    """Return the stated amount of a light whose shape is known. ``how``: it came to that, for people.

    Raises
    ------
    SceneError    It is stated in what such a light does not have.
    """
    settings = data.lumenray
    spectrum = convert_spectrum(settings, rgb, report, name)
    quantity, value = Quantity[settings.quantity], settings.value
    if quantity in {Quantity.LUMINOUS_FLUX, Quantity.RADIANT_FLUX}:
        return Output(quantity, value, spectrum)
    if quantity is Quantity.LUMINANCE:
        raise SceneError(f"the luminance of a light {how} is not defined")
    on_axis = float(intensity(distribution, np.array([0.0, 0.0, -1.0])))
    if on_axis <= 0.0:
        raise SceneError(f"a light {how} gives none on its axis, so that cannot be stated")
    return Output(Quantity.LUMINOUS_FLUX, value * flux(distribution) / on_axis, spectrum)
