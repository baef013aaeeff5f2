"""Pixels of Blender images as linear numbers."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

from ....engine.errors import FileFormatError
from ....imports import loaded_when_used

with loaded_when_used():
    from ....engine.formats import radiance_picture

LOOKED_AT = 1 << 16
"""Pixels by which it is judged what mixing encoded values changes."""

ROUNDING = 1e-3
"""By how much values that are whole numbers of a byte differ from them in single precision, at most. [-]"""

MISSING = 0.5
"""Grey value that stands for a picture that cannot be read. [-]"""

_DATA_SPACES = {"Non-Color", "Raw", "Generic Data", ""}
_LINEAR_SPACES = {"Linear Rec.709", "Linear", "Linear BT.709", "scene_linear"}


def decode_srgb(values: np.ndarray) -> np.ndarray:
    """Turn sRGB-encoded values into linear ones.

    References
    ----------
    IEC 61966-2-1:1999, 5.2.
    """
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encode_srgb(values: np.ndarray) -> np.ndarray:
    """Turn linear values into sRGB-encoded ones, as `decode_srgb`."""
    high = 1.055 * np.maximum(values, 0.0031308) ** (1.0 / 2.4) - 0.055
    return np.where(values <= 0.0031308, 12.92 * values, high)


def is_mixed_encoded(image) -> bool:
    """Whether Cycles mixes encoded values between the pixels of an image, and decodes what comes of it."""
    return not image.is_float and image.colorspace_settings.name == "sRGB"


def mixing_loss(pixels: np.ndarray) -> float:
    """Tell how much of the mean is lost where encoded values are mixed between pixels, and not light. [-]

    By Simpson's rule over the squares between four pixels, of evenly spread rows. ``pixels``: linear, (h, w, c).
    """
    height, width = pixels.shape[:2]
    rows = np.arange(0, height, max(height * width // LOOKED_AT, 1))
    near, far = (encode_srgb(pixels[each]) for each in (rows, (rows + 1) % height))
    along, across = 0.5 * (near + np.roll(near, -1, axis=1)), 0.5 * (near + far)
    middle = 0.5 * (across + np.roll(across, -1, axis=1))
    parts = ((near, 4.0), (along, 8.0), (across, 8.0), (middle, 16.0))
    sums = [weight * float(decode_srgb(part).mean()) for part, weight in parts]
    whole = 9.0 * sums[0]
    return max(1.0 - sum(sums) / whole, 0.0) if whole > 0.0 else 0.0


def read_pixels(image, is_straight: bool, note: Callable[[str, str], None]):
    """Read a Blender image as Cycles shows it to an Image Texture node.

    Parameters
    ----------
    image : bpy.types.Image or None    What to read.
    is_straight : bool
        Whether the colour is wanted without its alpha, which Cycles does when the node's Alpha is
        used as well; otherwise transparent pixels are dark.
    note : callable    Told (message, remedy) about everything that is not taken over.

    Returns
    -------
    (height, width, 4) float32 array or None
        Linear Rec. 709 and alpha, row 0 at the bottom; None when there are no pixels.
    """
    if image is None:
        return None
    if image.source in {"TILED", "SEQUENCE", "MOVIE"}:
        # Surfaces read all tiles; worlds and lights have no coordinates beyond the first.
        part = "first tile" if image.source == "TILED" else "current frame"
        note(f"Image {image.name!r} has several pictures", f"only the {part} is used")
    try:
        header, stored = _read_radiance(image)
    except FileFormatError as error:
        note(str(error), "the picture is left out")
        return None
    pixels = _read_loaded(image, is_straight, note) if stored is None else stored
    if header is not None and pixels is not None:
        _follow_header(pixels, header, image, note)
    return pixels


def _read_radiance(image):
    """Header of a Radiance picture, None of others, and its pixels where Blender cannot read them or turns them."""
    packed = image.packed_file
    if image.source != "FILE" or not (packed or image.filepath):
        return None, None
    path = Path(bpy.path.abspath(image.filepath, library=image.library))
    data = bytes(packed.data[: len(radiance_picture.MAGIC)]) if packed else b""
    try:
        if not packed and path.is_file():
            with path.open("rb") as file:
                data = file.read(radiance_picture.MAXIMUM_HEADER)
        if not data.startswith(radiance_picture.MAGIC):
            return None, None
        data = bytes(packed.data) if packed else data
        header = radiance_picture.read_header(data, path)
        usual = header.encoding == radiance_picture.RGBE and header.order == radiance_picture.PLAIN
        if usual or image.is_dirty:
            return header, None
        decoded = radiance_picture.decode(data if packed else path.read_bytes(), header, path)
    except (OSError, ValueError):
        # What cannot be opened is Blender's to tell.
        return None, None
    alpha = np.ones((*decoded.shape[:2], 1), np.float32)
    return header, np.concatenate([decoded, alpha], axis=2)


def _follow_header(pixels, header, image, note):
    """Take exposures out of the pixels in place, and say what else the header asks for."""
    name = f"Image {image.name!r}"
    if header.encoding == radiance_picture.XYZE:
        note(
            f"{name} holds CIE X, Y, Z (FORMAT={header.encoding})",
            "its Y is read as the format says, in cd/m2: a world that shows it needs the unit cd/m2",
        )
    multiplier = header.exposure * np.array(header.correction)
    if (multiplier != 1.0).any():
        shown = f"{header.exposure:g}" + (
            " and COLORCORR " + " ".join(f"{each:g}" for each in header.correction)
            if set(header.correction) != {1.0}
            else ""
        )
        if image.is_dirty:
            note(f"{name} is edited and not saved", f"its EXPOSURE {shown} is not taken out")
        else:
            note(f"{name} states EXPOSURE {shown}", "its pixels are divided by it")
            pixels[..., :3] /= multiplier.astype(np.float32)
    if header.primaries is not None and not np.allclose(
        header.primaries, radiance_picture.REC709, atol=2e-3
    ):
        note(f"{name} states PRIMARIES of its own", "its colours are read as Rec. 709")
    if header.gamma != 1.0:
        note(f"{name} states GAMMA {header.gamma:g}", "its values are read as linear")


def _read_loaded(image, is_straight, note):
    """Read what Blender holds, as `read_pixels`."""
    width, height = image.size
    if width * height == 0 or len(image.pixels) == 0:
        return None
    channels = len(image.pixels) // (width * height)
    flat = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(flat)
    pixels = _four_channels(flat.reshape(height, width, channels))
    if image.alpha_mode == "NONE":
        pixels[..., 3] = 1.0
    elif image.alpha_mode != "CHANNEL_PACKED":
        _apply_alpha(pixels, image, is_straight)
    if not image.is_float:
        _decode(pixels, image, note)
    return pixels


def _four_channels(pixels):
    height, width, channels = pixels.shape
    if channels == 4:
        return pixels
    full = np.ones((height, width, 4), np.float32)
    full[..., :3] = pixels[..., :3] if channels == 3 else pixels[..., :1]
    if channels == 2:
        full[..., 3] = pixels[..., 1]
    return full


def _decode(pixels, image, note):
    """Linearise in place; float pictures are linear already when Blender hands them out."""
    space = image.colorspace_settings.name
    if space in _DATA_SPACES or space in _LINEAR_SPACES:
        return
    if space != "sRGB":
        taken_as = "linear Rec. 709" if space.startswith("Linear") else "sRGB"
        note(
            f"Image {image.name!r} is in the colour space {space!r}",
            f"its pixels are read as {taken_as}",
        )
        if space.startswith("Linear"):
            return
    pixels[..., :3] = _decode_bytes(pixels[..., :3])


def _decode_bytes(values: np.ndarray) -> np.ndarray:
    """As `decode_srgb`, much faster of values that a byte can have."""
    codes = np.rint(values * np.float32(255.0))
    if np.abs(codes - values * np.float32(255.0)).max(initial=0.0) > ROUNDING:
        # Alpha was multiplied in.
        return decode_srgb(values)
    table = decode_srgb(np.arange(256) / 255.0).astype(np.float32)
    return table[codes.astype(np.uint8)]


def _apply_alpha(pixels, image, is_straight):
    """Multiply or divide by alpha in place; Cycles multiplies encoded values, and so does this."""
    colour, alpha = pixels[..., :3], pixels[..., 3:]
    if image.is_float:
        # Blender keeps float pixels multiplied by alpha, byte pixels not.
        if is_straight:
            np.divide(colour, alpha, out=colour, where=alpha > 0)
    elif image.colorspace_settings.name not in _DATA_SPACES:
        colour *= (alpha > 0) if is_straight else alpha
