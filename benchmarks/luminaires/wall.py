"""Picture of a wall lit by six luminaires, with isolux lines of the wall below it.

Run as ``python -m lumenray.benchmarks.luminaires.wall OUT.png``.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ...engine.accuracy.stopping import StopRule
from ...engine.analysis.false_colour import colours
from ...engine.luminaires.formats.reader import read_luminaire
from ...engine.luminaires.lamp_spectrum import choose_spectrum
from ...engine.photometry.colour import scene_linear
from ...engine.scene.camera import Camera, Projection
from ...engine.scene.light import Luminaire, Output, Quantity
from ...engine.scene.material import Diffuse, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Constant
from ...engine.session import Session
from ...engine.views import ViewSettings

FOLDER = Path(__file__).resolve().parents[2] / "libraries" / "luminaires" / "photometry"

NAMES = (
    "downlight_24.ies", "downlight_60.ies", "wall_up_down.ies",
    "wall_washer.ies", "batwing_office.ldt", "street_type_3.ies",
)  # fmt: skip
"""Luminaires, from left to right."""

LUMENS = 1000.0
"""Of each. [lm]"""

SPACING, HEIGHT, DISTANCE = 2.2, 2.9, 0.5
"""Between luminaires, of them above the floor, and of them from the wall. [m]"""

SIZE = (1200, 300)
"""Of the picture and of the map, each. [pixel]"""

LINES = (5, 10, 20, 50, 100, 200, 500, 1000)
"""Illuminances of the isolux lines. [lx]"""


def build() -> tuple[Session, float]:
    """Return a session with the wall and its luminaires, and the wall's length. [m]"""
    length = SPACING * len(NAMES)
    items = [
        Material("wall", "wall", Diffuse(Constant(0.7))),
        _quad("wall", [0, 0, 0], [length, 0, 0], [0, 0, 3.2], "wall"),
    ]
    for i, name in enumerate(NAMES):
        file = read_luminaire(FOLDER / name)
        frame = np.eye(4)
        # C = 90 degrees looks at the wall, as a street luminaire looks across the road.
        frame[:3, 3] = SPACING * (i + 0.5), -DISTANCE, HEIGHT if i != 2 else 1.6
        spectrum = choose_spectrum(file).spectrum
        output = Output(Quantity.LUMINOUS_FLUX, LUMENS, spectrum)
        items.append(Luminaire(f"light:{i}", name, output, frame, file.distribution, file.opening))
    session = Session(witness=False)
    session.apply(SceneDelta(changed=tuple(items)))
    return session, length


def _quad(name, corner, u, v, material) -> Mesh:
    corner, u, v = (np.asarray(x, dtype=float) for x in (corner, u, v))
    vertices = np.stack([corner, corner + u, corner + u + v, corner + v])
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    return Mesh(name, name, vertices, faces, (material,), np.zeros(2, dtype=np.int32))


def draw(path: Path) -> None:
    """Render and write the picture."""
    session, length = build()
    width, height = SIZE
    frame = np.eye(4)
    # Looking along +y at the wall.
    frame[:3, :3] = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=float)
    frame[:3, 3] = 0.5 * length, -20.0, 1.6
    film = 3.3 * width / height / 20.0
    camera = Camera(frame, Projection.PERSPECTIVE, width, height, film, film * height / width)
    picture = session.render(camera, ViewSettings(StopRule(samples=64)))
    shown = scene_linear(picture.tristimulus[::-1], 60.0).clip(0.0, None)
    # A soft shoulder instead of a hard clip.
    shown = 1.0 - np.exp(-1.4 * shown)
    shown = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    top = Image.fromarray((255.0 * shown.clip(0.0, 1.0) + 0.5).astype(np.uint8))
    bottom = _isolux(session, length)
    whole = Image.new("RGB", (width, 2 * height + 26), "white")
    whole.paste(top, (0, 0))
    whole.paste(bottom, (0, height + 26))
    text = ImageDraw.Draw(whole)
    font = ImageFont.load_default(15)
    for i, name in enumerate(NAMES):
        place = (width * (i + 0.5) / len(NAMES), height + 13)
        text.text(place, name, fill="black", font=font, anchor="mm")
    whole.save(path, optimize=True)


def _isolux(session: Session, length: float) -> Image.Image:
    """Illuminance of the wall in false colours with isolux lines."""
    width, height = SIZE[0] // 4, SIZE[1] // 4
    x, z = np.meshgrid(
        (np.arange(width) + 0.5) / width * length, (height - np.arange(height) - 0.5) / height * 3.2
    )
    points = np.stack([x, np.full_like(x, -1e-3), z], axis=-1).reshape(-1, 3)
    normals = np.broadcast_to([0.0, -1.0, 0.0], points.shape)
    measured = session.measure(points, normals, StopRule(samples=256))
    lux = measured.illuminance.reshape(height, width)
    large = np.array(Image.fromarray(lux.astype(np.float32)).resize(SIZE, Image.Resampling.BICUBIC))
    # The scale is logarithmic, as eyes are.
    share = np.log10(np.maximum(large, LINES[0]) / LINES[0]) / np.log10(LINES[-1] / LINES[0])
    pixels = colours(share, 0.0, 1.0)
    for value in LINES:
        above = large > value
        edge = np.zeros_like(above)
        edge[:, 1:] |= above[:, 1:] != above[:, :-1]
        edge[1:] |= above[1:] != above[:-1]
        pixels[edge] = 255
    made = Image.fromarray(pixels[..., :3])
    text = ImageDraw.Draw(made)
    legend = (
        "isolux lines of the wall: " + ", ".join(map(str, LINES)) + " lx; each luminaire 1000 lm"
    )
    text.text((8, SIZE[1] - 22), legend, fill="white", font=ImageFont.load_default(15))
    return made


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
