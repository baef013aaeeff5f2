"""Our own tileable pictures, drawn with numpy from fixed seeds and packed into the file."""

import bpy
import numpy as np

FLOOR_TILE = 2.4
"""Width of floor that one repetition of the oak picture covers. [m]"""


def _noise(rng, size, width_u, width_v):
    """Return periodic Gaussian noise (size, size), unit variance, correlated over fractions."""
    frequency = np.fft.fftfreq(size) * size
    v, u = np.meshgrid(frequency, frequency, indexing="ij")
    spectrum = np.exp(-2.0 * np.pi**2 * ((u * width_u) ** 2 + (v * width_v) ** 2))
    field = np.fft.ifft2(np.fft.fft2(rng.standard_normal((size, size))) * np.sqrt(spectrum)).real
    return (field - field.mean()) / field.std()


def _grain(rng, size):
    """Return a periodic wood figure along u, about -1 to 1: fibres, pores and cathedral lines."""
    fibres = _noise(rng, size, 0.06, 0.0007)
    streaks = _noise(rng, size, 0.25, 0.006)
    warp = _noise(rng, size, 0.12, 0.03)
    rows = np.arange(size)[:, None] / size
    rings = np.sin(2.0 * np.pi * 9.0 * rows + 2.6 * warp)
    pores = np.minimum(0.0, _noise(rng, size, 0.008, 0.0006) + 1.3)
    return 0.30 * fibres + 0.32 * streaks + 0.22 * rings + 0.5 * pores


def _blend(amount, dark, light):
    """Return sRGB (size, size, 3) between two sRGB colours, ``amount`` 0 to 1."""
    amount = np.clip(amount, 0.0, 1.0)[..., None]
    return np.asarray(dark) * (1.0 - amount) + np.asarray(light) * amount


def oak_planks(size=1024, rows=16):
    """Return tileable oak boards, sRGB (size, size, 3): ``rows`` boards across, two along."""
    rng = np.random.default_rng(11)
    grain = _grain(rng, size)
    value = np.zeros((size, size))
    gap = np.zeros((size, size))
    hue = np.zeros((size, size))
    height = size // rows
    # Alternating half offsets with a little chance keep the joints apart, as a layer does it.
    for row in range(rows):
        band = slice(row * height, (row + 1) * height)
        start = int(size * (0.31 * row + rng.uniform(-0.05, 0.05))) % size
        for half in range(2):
            columns = (start + half * size // 2 + np.arange(size // 2)) % size
            piece = np.roll(grain, tuple(rng.integers(0, size, 2)), axis=(0, 1))
            if rng.random() < 0.5:
                piece = piece[:, ::-1]
            value[band, columns] = piece[band, columns] + rng.uniform(-0.75, 0.55)
            hue[band, columns] = rng.uniform(-1.0, 1.0)
            gap[band, columns[0]] = 1.0
        gap[row * height] = 1.0
    colour = _blend(0.60 + 0.24 * value, (0.44, 0.31, 0.20), (0.79, 0.64, 0.46))
    colour *= 1.0 + np.array([0.015, 0.0, -0.035]) * hue[..., None]
    return np.clip(colour * (1.0 - 0.55 * gap[..., None]), 0.0, 1.0)


def light_wood(size=512):
    """Return a pale beech laminate, sRGB (size, size, 3), grain along u, tileable."""
    grain = _grain(np.random.default_rng(23), size)
    return _blend(0.58 + 0.17 * grain, (0.62, 0.48, 0.34), (0.84, 0.72, 0.56))


def landscape(size=512):
    """Return a print for the wall, sRGB (size, size, 3): misty hills under a pale sun."""
    rng = np.random.default_rng(5)
    v, u = np.meshgrid(np.linspace(0, 1, size), np.linspace(0, 1, size), indexing="ij")
    colour = _blend(1.15 * v - 0.25, (0.93, 0.80, 0.66), (0.56, 0.70, 0.80))
    sun = np.hypot(u - 0.68, v - 0.70)
    colour = np.where((sun < 0.07)[..., None], (0.98, 0.93, 0.82), colour)
    hills = [(0.60, 0.05, 0.10), (0.48, 0.07, 0.07), (0.34, 0.07, 0.05), (0.18, 0.06, 0.03)]
    tones = [(0.66, 0.73, 0.74), (0.47, 0.59, 0.60), (0.28, 0.42, 0.43), (0.13, 0.25, 0.27)]
    for (level, swing, width), tone in zip(hills, tones, strict=True):
        ridge = level + swing * _noise(rng, size, width, 1.0)[0]
        depth = ridge[None, :] - v
        haze = np.clip(depth / 0.30, 0.0, 1.0)[..., None]
        shade = np.asarray(tone) * (1.0 - 0.55 * haze) + 0.55 * haze * np.array([0.80, 0.80, 0.78])
        colour = np.where((depth > 0.0)[..., None], shade, colour)
    return np.clip(colour + 0.008 * rng.standard_normal((size, size, 1)), 0.0, 1.0)


def checker(size=128, squares=8):
    """Return a two-colour checker, sRGB (size, size, 3)."""
    rows, columns = np.indices((size, size)) * squares // size
    return _blend(((rows + columns) % 2).astype(float), (0.20, 0.30, 0.45), (0.85, 0.80, 0.70))


def packed_image(name, colour):
    """Return a packed Blender image of ``colour``, sRGB (h, w, 3), first row at the bottom."""
    height, width, _ = colour.shape
    image = bpy.data.images.new(name, width, height, alpha=False)
    image.colorspace_settings.name = "sRGB"
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = colour
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image
