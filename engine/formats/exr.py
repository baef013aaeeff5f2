"""OpenEXR files, written and read by Mitsuba's own copy of the library.

The OpenEXR package for Python must not be loaded into Blender's process: both export the same C names, and the calls of
one end up in the other. Mitsuba's copy has names of its own.
"""

from pathlib import Path

import numpy as np

from .. import llvm
from ..errors import FileFormatError
from ..photometry.colour import scene_linear
from ..reading.content import read_bytes
from ..reading.whole_file import write_whole
from .exr_structure import check_whole

MAGIC = b"\x76\x2f\x31\x01"
"""First bytes of every OpenEXR file."""

LARGEST = 1 << 31
"""Largest file that is read. [byte]"""


def write_channels(path, channels: dict[str, np.ndarray], attributes: dict | None = None) -> Path:
    """Write 32-bit float channels.

    Parameters
    ----------
    path : str or Path    Its folder is made if need be.
    channels : dict of str to (h, w) array    Row 0 is the bottom row.
    attributes : dict    Strings and floats for the header.

    Raises
    ------
    FileFormatError    The file cannot be written.
    """
    llvm.settle()
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant("scalar_rgb")
    names = sorted(channels)
    pixels = np.stack(
        [np.asarray(channels[name], dtype=np.float32)[::-1] for name in names], axis=-1
    )
    bitmap = mi.Bitmap(
        np.ascontiguousarray(pixels),
        pixel_format=mi.Bitmap.PixelFormat.MultiChannel,
        channel_names=names,
    )
    metadata = bitmap.metadata()
    for key, value in (attributes or {}).items():
        metadata[key] = value
    content = mi.MemoryStream()
    bitmap.write(content, mi.Bitmap.FileFormat.OpenEXR)
    with write_whole(path) as file:
        file.write(content.raw_buffer())
    return Path(path)


def read_channels(path) -> dict[str, np.ndarray]:
    """Read all channels of an OpenEXR file as 32-bit floats: names and (h, w) arrays, row 0 at the bottom.

    Raises
    ------
    FileFormatError    The file is none, or cannot be read.
    """
    path = Path(path)
    llvm.settle()
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant("scalar_rgb")
    data = read_bytes(path, LARGEST)
    if not data.startswith(MAGIC):
        raise FileFormatError(path, "is no OpenEXR file")
    try:
        stream = mi.MemoryStream()
        stream.write(data)
        stream.seek(0)
        bitmap = mi.Bitmap(stream, mi.Bitmap.FileFormat.OpenEXR)
        names = [field.name for field in bitmap.struct_()]
        pixels = np.array(bitmap, dtype=np.float32)
    except (RuntimeError, ValueError) as error:
        words = str(error).splitlines()[-1].strip()
        raise FileFormatError(path, f"cannot be read ({words})") from None
    pixels = pixels.reshape(*pixels.shape[:2], -1)[::-1]
    return {name: np.ascontiguousarray(pixels[..., k]) for k, name in enumerate(names)}


def spectral_channels(bands: np.ndarray, edges: np.ndarray) -> dict[str, np.ndarray]:
    """Name band radiances (h, w, b) [W/(m2 sr nm)] by their central wavelength, after Fichet et al.

    References
    ----------
    A. Fichet, R. Pacanowski, A. Wilkie: An OpenEXR Layout for Spectral Images, JCGT 10(3), 2021.
    """
    centres = 0.5 * (edges[1:] + edges[:-1])
    return {
        f"S0.{nm:.6f}nm".replace(".", ",").replace("S0,", "S0.", 1): bands[..., i]
        for i, nm in enumerate(centres)
    }


def write_spectral(path, picture) -> Path:
    """Write a picture's bands (`views.Picture`) as a spectral OpenEXR with a preview in R, G, B."""
    channels = spectral_channels(picture.bands, picture.band_edges)
    preview = scene_linear(picture.tristimulus, 1.0)
    channels |= {name: preview[..., i] for i, name in enumerate("RGB")}
    return write_channels(path, channels, SPECTRAL_ATTRIBUTES)


SPECTRAL_ATTRIBUTES = {"spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1", "EV": 0.0}
"""Header of a spectral picture; the radiance is a density per nanometre, as the layout's own software integrates it."""


def read_colours(path, data: bytes) -> np.ndarray:
    """Read the colours of a file.

    Parameters
    ----------
    path : str or Path    For errors.
    data : bytes    The whole file.

    Returns
    -------
    (height, width, 3) float32 array    R, G and B of the first layer that has them, or luminance three times; row 0 is the
        bottom row.

    Raises
    ------
    FileFormatError    It is damaged, ends early or holds no such channels.
    """
    check_whole(path, data)
    llvm.settle()
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant("scalar_rgb")
    stream = mi.MemoryStream(len(data))
    stream.write(data)
    stream.seek(0)
    try:
        bitmap = mi.Bitmap(stream, mi.Bitmap.FileFormat.OpenEXR)
    except RuntimeError as error:
        # The last sentence says why, those before it which stream.
        words = " ".join(str(error).rpartition("]")[2].split()).strip('". ')
        raise FileFormatError(path, f"is damaged or ends early ({words})") from None
    if bitmap.pixel_format() == mi.Bitmap.PixelFormat.MultiChannel:
        kinds = {mi.Bitmap.PixelFormat.RGB, mi.Bitmap.PixelFormat.RGBA}
        layers = [layer for _, layer in bitmap.split() if layer.pixel_format() in kinds]
        if not layers:
            raise FileFormatError(path, "expected channels R, G and B, or Y")
        bitmap = layers[0]
    bitmap = bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.ascontiguousarray(np.array(bitmap, dtype=np.float32)[::-1])
