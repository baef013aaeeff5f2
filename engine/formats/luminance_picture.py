"""Luminance pictures for rating glare: OpenEXR of ours or with a channel of luminance, and Radiance pictures."""

import json
import math
from pathlib import Path

import numpy as np

from .. import llvm
from ..analysis.picture_view import Mapping, PictureView
from ..errors import FileFormatError, SceneError
from ..photometry.colour import REC709_LUMINANCE
from ..scene.camera import Camera, Projection
from . import radiance_picture

VIEW = "lumenrayView"
"""Attribute of OpenEXR files that says how the picture was taken, as JSON."""

CHANNELS = ("Luminance.Y", "Y")
"""Names of channels that hold luminances. [cd/m2]"""

RADIANCE_EFFICACY = 179.0
"""Luminous efficacy that Radiance gives white light. [lm/W]"""

RADIANCE_LUMINANCE = np.array([0.2651, 0.6701, 0.0648])
"""Luminance of Radiance's red, green and blue, as far as the file names no primaries of its own. [-]"""

_MAPPINGS = {
    Projection.PERSPECTIVE: Mapping.PERSPECTIVE,
    Projection.EQUIRECTANGULAR: Mapping.EQUIRECTANGULAR,
    Projection.EQUIDISTANT: Mapping.EQUIDISTANT,
    Projection.EQUISOLID: Mapping.EQUISOLID,
}

_TYPES = {"v": Mapping.PERSPECTIVE, "a": Mapping.EQUIDISTANT, "h": Mapping.ORTHOGRAPHIC}
"""Of Radiance's views, by the letter after -vt."""


def view_of_camera(camera: Camera) -> PictureView | None:
    """Return the view of a camera; None where no eye could have it."""
    mapping = _MAPPINGS.get(camera.projection)
    if mapping is None:
        return None
    extent, shift = (camera.extent_x, camera.extent_y), (camera.shift_x, camera.shift_y)
    size = camera.width, camera.height
    return PictureView(mapping, *size, extent, shift, float(camera.field))


def describe_view(view: PictureView) -> str:
    """Return a view as the text of the attribute `VIEW`."""
    stated = {
        "mapping": view.mapping.value,
        "extent": list(view.extent),
        "shift": list(view.shift),
        "field_rad": view.field,
    }
    return json.dumps(stated)


def read_luminance(path) -> tuple[np.ndarray, PictureView | None]:
    """Read a luminance picture and its view.

    Parameters
    ----------
    path : str or Path    Its name ends in .exr, or .hdr or .pic for Radiance pictures.

    Returns
    -------
    luminance : (h, w) float64 array    Row 0 is the bottom row. [cd/m2]
    view : PictureView or None    None where the file does not say it.

    Raises
    ------
    FileFormatError    It cannot be read, or holds no luminances.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending == ".exr":
        return _read_exr(path)
    if ending in {".hdr", ".pic"}:
        return _read_radiance(path)
    raise FileFormatError(path, "expected an OpenEXR (.exr) or Radiance picture (.hdr, .pic)")


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise FileFormatError(path, f"cannot be read ({error.strerror})") from None


def _read_exr(path: Path) -> tuple[np.ndarray, PictureView | None]:
    llvm.settle()
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant("scalar_rgb")
    data = _content(path)
    try:
        stream = mi.MemoryStream()
        stream.write(data)
        stream.seek(0)
        bitmap = mi.Bitmap(stream, mi.Bitmap.FileFormat.OpenEXR)
    except RuntimeError as error:
        raise FileFormatError(
            path, f"is no OpenEXR picture ({str(error).splitlines()[0]})"
        ) from None
    names = [field.name for field in bitmap.struct_()]
    pixels = np.array(bitmap, dtype=np.float64)
    pixels = pixels.reshape(bitmap.height(), bitmap.width(), -1)[::-1]
    stated = bitmap.metadata()
    found = next((name for name in CHANNELS if name in names), None)
    if found is not None:
        luminance = pixels[..., names.index(found)]
    elif {"R", "G", "B"} <= set(names) and "whiteLuminance" in stated:
        colour = pixels[..., [names.index(name) for name in "RGB"]]
        luminance = colour @ REC709_LUMINANCE * float(stated["whiteLuminance"])
    else:
        raise FileFormatError(
            path,
            f"holds the channels {', '.join(names[:8])}, expected Luminance.Y or Y in cd/m2, or R, G, B and the attribute "
            "whiteLuminance",
        )
    return _checked(path, luminance), _view_of(path, stated, luminance.shape)


def _view_of(path: Path, stated, shape) -> PictureView | None:
    if VIEW not in stated:
        return None
    try:
        said = json.loads(str(stated[VIEW]))
        extent, shift = (tuple(map(float, said[key])) for key in ("extent", "shift"))
        mapping, field = Mapping(said["mapping"]), float(said["field_rad"])
        return PictureView(mapping, shape[1], shape[0], extent, shift, field)
    except (ValueError, KeyError, TypeError, SceneError):
        raise FileFormatError(path, f"the attribute {VIEW} cannot be understood") from None


def _read_radiance(path: Path) -> tuple[np.ndarray, PictureView | None]:
    data = _content(path)
    header = radiance_picture.read_header(data, path)
    pixels = radiance_picture.decode(data, header, path).astype(np.float64)
    if header.encoding != radiance_picture.XYZE:
        pixels = _to_middles(pixels)
    pixels /= header.exposure * np.array(header.correction)
    weights = RADIANCE_LUMINANCE
    if header.encoding == radiance_picture.XYZE or header.primaries == radiance_picture.REC709:
        weights = REC709_LUMINANCE
    luminance = RADIANCE_EFFICACY * pixels @ weights
    return _checked(path, luminance), _radiance_view(path, data[: header.start], luminance.shape)


def _to_middles(pixels: np.ndarray) -> np.ndarray:
    """Move colours (..., 3) by half a step of their bytes: Radiance cuts off when it writes and takes middles when it reads.

    The largest component has a byte from 128 on, which tells the step of all three.
    """
    _, exponent = np.frexp(pixels.max(axis=-1, keepdims=True))
    return np.where(
        pixels.max(axis=-1, keepdims=True) > 0.0, pixels + np.ldexp(0.5, exponent - 8), 0.0
    )


def _radiance_view(path: Path, head: bytes, shape) -> PictureView | None:
    """View of the last VIEW line; those of pictures that this one was made of are indented and do not count."""
    lines = [line for line in head.decode("latin-1").splitlines() if line.startswith("VIEW=")]
    if not lines:
        return None
    words = lines[-1][len("VIEW=") :].split()
    kind, angles = "v", {"-vh": 45.0, "-vv": 45.0, "-vs": 0.0, "-vl": 0.0}
    for number, word in enumerate(words):
        if word.startswith("-vt") and len(word) == len("-vtv"):
            kind = word[-1]
        elif word in angles:
            try:
                angles[word] = float(words[number + 1])
            except (IndexError, ValueError):
                raise FileFormatError(
                    path, f"the view '{lines[-1][:80]}' is not complete"
                ) from None
    if kind not in _TYPES or angles["-vs"] or angles["-vl"]:
        raise FileFormatError(
            path, "its view is none that is known: expected -vta, -vth or -vtv without shift"
        )
    try:
        across, along = (math.radians(angles[key]) for key in ("-vh", "-vv"))
        return PictureView.of_angles(_TYPES[kind], shape[1], shape[0], across, along)
    except SceneError as error:
        raise FileFormatError(path, str(error)) from None


def _checked(path: Path, luminance: np.ndarray) -> np.ndarray:
    if not np.isfinite(luminance).all():
        raise FileFormatError(path, "holds pixels that are no numbers")
    # Filters and colours outside the gamut leave a trace below 0.
    return np.ascontiguousarray(np.maximum(luminance, 0.0))
