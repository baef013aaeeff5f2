"""Pixels of Blender images as linear numbers."""

from collections.abc import Callable

import numpy as np

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
        part = "first tile" if image.source == "TILED" else "current frame"
        note(f"Image {image.name!r} has several pictures", f"only the {part} is used")
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
    pixels[..., :3] = decode_srgb(pixels[..., :3])


def _apply_alpha(pixels, image, is_straight):
    """Multiply or divide by alpha in place; Cycles multiplies encoded values, and so does this."""
    colour, alpha = pixels[..., :3], pixels[..., 3:]
    if image.is_float:
        # Blender keeps float pixels multiplied by alpha, byte pixels not.
        if is_straight:
            np.divide(colour, alpha, out=colour, where=alpha > 0)
    elif image.colorspace_settings.name not in _DATA_SPACES:
        colour *= (alpha > 0) if is_straight else alpha
