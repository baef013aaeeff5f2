"""Files of equirectangular pictures: Radiance's (.hdr, .pic) and OpenEXR (.exr), read as linear Rec. 709."""

from pathlib import Path

import numpy as np

from ..errors import FileFormatError
from ..formats import exr, exr_structure, radiance_picture
from ..reading.content import read_bytes
from ..scene.texture import ImageTexture

MAXIMUM_SIZE = 4 << 30
"""Larger files are not read. [byte]"""

LEAST_EXPOSURE = 1e-12
"""Exposures are above this, and below its inverse. [-]"""


def read_map(path) -> tuple[ImageTexture, tuple[str, ...]]:
    """Read an equirectangular picture.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    ImageTexture    Its values divided by what the header's EXPOSURE and COLORCORR lines say; pixels cannot be written to.
    tuple of str    What is odd about it, a sentence each.

    Raises
    ------
    FileFormatError    It is neither kind of file, it is damaged, or it ends early.
    """
    path = Path(path)
    data = read_bytes(path, MAXIMUM_SIZE)
    if data.startswith(radiance_picture.MAGIC):
        pixels, remarks = _read_radiance(path, data)
    elif data.startswith(exr_structure.MAGIC):
        pixels, remarks = exr.read_colours(path, data), []
    else:
        raise FileFormatError(path, "expected a Radiance picture (.hdr) or an OpenEXR file (.exr)")
    height, width = pixels.shape[:2]
    if width != 2 * height:
        remarks.append(
            f"it has {width} x {height} pixels, a full sphere is twice as wide as high; it is stretched over the sphere"
        )
    pixels.flags.writeable = False
    return ImageTexture(pixels, name=path.name), tuple(remarks)


def _read_radiance(path: Path, data: bytes) -> tuple[np.ndarray, list[str]]:
    header = radiance_picture.read_header(data, path)
    pixels = radiance_picture.decode(data, header, path)
    remarks = []
    multiplier = header.exposure * np.array(header.correction)
    if not ((multiplier > LEAST_EXPOSURE) & (multiplier < 1.0 / LEAST_EXPOSURE)).all():
        raise FileFormatError(
            path, f"its EXPOSURE lines come to {header.exposure:g}, which is none of a camera"
        )
    if (multiplier != 1.0).any():
        pixels /= multiplier.astype(np.float32)
        remarks.append(f"it states EXPOSURE {header.exposure:g}, and its values are divided by it")
    if header.encoding == radiance_picture.XYZE:
        remarks.append("it holds CIE X, Y, Z, whose Y is in cd/m2")
    return pixels, remarks


def write_map(path, pixels: np.ndarray) -> Path:
    """Write a picture as OpenEXR with 32 bits.

    Parameters
    ----------
    path : str or Path    Ends in .exr.
    pixels : (height, width, 3 or 1) array    Row 0 is the bottom row.

    Raises
    ------
    FileFormatError    The name ends otherwise, or the file cannot be written.
    """
    if Path(path).suffix.lower() != ".exr":
        raise FileFormatError(path, "expected a name that ends in .exr")
    count = pixels.shape[2]
    channels = {name: pixels[..., i % count] for i, name in enumerate("RGB")}
    return exr.write_channels(path, channels)
