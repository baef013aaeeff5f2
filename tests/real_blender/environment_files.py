"""Draw the photo and the picture of the surroundings that ``environment.py`` works with: ``environment_files.py FOLDER``."""

import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[2]), str(HERE.parent / "helpers")]

from radiance_files import write_picture  # noqa: E402

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map  # noqa: E402
from lumenray.engine.formats.exr import write_channels  # noqa: E402

WIDTH, HEIGHT, FINER = 960, 640, 4
"""Of the photo [pixel], and by how much finer it is drawn."""

EYE, AHEAD = np.array([0.0, -6.0, 1.9]), np.array([0.0, 6.0, -1.4])
"""Where the photo was taken from [m] and whereto; it is 0.75 wide at the distance 1."""

TOWARDS = np.array([0.5, -0.35, 0.7])
"""To the sun, of any length."""

CORNER, SIDE, TALL = np.array([-1.2, 0.6]), 0.12, 1.0
"""Of the post. [m]"""


def project(points) -> list[tuple[float, float]]:
    """Return where points (n, 3) [m] are in the photo. [pixel]"""
    ahead = AHEAD / np.linalg.norm(AHEAD)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    away = np.asarray(points, dtype=np.float64) - EYE
    depth = away @ ahead
    x, y = (away @ axis / depth for axis in (right, np.cross(right, ahead)))
    scale = FINER * WIDTH / 0.75
    return list(zip(0.5 * FINER * WIDTH + scale * x, 0.5 * FINER * HEIGHT - scale * y, strict=True))


def draw_photo() -> Image.Image:
    """Draw a post and its shadow on the ground, under a sky."""
    image = Image.new("RGB", (FINER * WIDTH, FINER * HEIGHT), (176, 198, 224))
    pen = ImageDraw.Draw(image)
    far = 500.0
    pen.polygon(
        project([(-far, -4.0, 0), (far, -4.0, 0), (far, far, 0), (-far, far, 0)]), (182, 176, 164)
    )
    square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * SIDE + CORNER
    low = np.column_stack([square, np.zeros(4)])
    high = low + np.array([0.0, 0.0, TALL])
    thrown = high - np.outer(high[:, 2] / TOWARDS[2], TOWARDS)
    # Shadows of the four sides; together they are the post's.
    for i in range(4):
        j = (i + 1) % 4
        pen.polygon(project([low[i], low[j], thrown[j], thrown[i]]), (92, 96, 108))
    pen.polygon(project(thrown), (92, 96, 108))
    for i, shade in ((1, 205), (0, 228)):
        j = (i + 1) % 4
        pen.polygon(project([low[i], low[j], high[j], high[i]]), (shade, shade - 4, shade - 14))
    return image.resize((WIDTH, HEIGHT), Image.Resampling.BOX)


def main(folder: Path) -> None:
    """Write both files."""
    draw_photo().save(folder / "photo.png")
    pixels = make_map(256, [Spot(35.0, 60.0, 1.5, 6.0)], sky=1.0, ground=0.25)
    (folder / "outside.hdr").write_bytes(write_picture(pixels))
    channels = dict(zip("RGB", np.moveaxis(pixels.astype(np.float32), -1, 0), strict=True))
    write_channels(folder / "outside.exr", channels)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
