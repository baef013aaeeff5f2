"""Glare of rendered pictures beside Radiance's evalglare on the same files."""

import subprocess
import tempfile
from importlib import util
from pathlib import Path

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.analysis.picture_glare import rate_picture
from ...engine.formats.luminance_picture import read_luminance
from ...engine.scene.camera import Camera, Projection
from ...engine.scene.light import AreaLight, Output, Quantity
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Constant
from ...engine.session import Session
from ...engine.views import ViewSettings
from ..common import interiors
from ..common.interiors import make_matt
from ..common.office import load_office
from ..common.pieces import make_mesh, rigid_frame, side_of_box

SIZE, REPEAT, SAMPLES = 300, 4, 8
"""Sides of the pictures [pixel], how often every pixel is repeated in the file that both read, and samples of each:
evalglare takes the place of a source at the corner of a pixel, which must be near."""

PATIENCE = 900.0
"""Longest that evalglare may take. [s]"""

WHITE = 179.0
"""Of Radiance: luminous efficacy of its white. [lm/W]"""

FIGURES = {"dgp": "dgp", "dgi": "dgi", "ugr": "ugr", "veiling": "Lveil_cie"}
"""Ours, and evalglare's names."""


def is_possible() -> bool:
    """Whether evalglare is there; it comes with the package `pyradiance`."""
    return util.find_spec("pyradiance") is not None


def measure(say) -> list[dict]:
    """Rate five pictures by both; a row each with the figures of both."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, items, camera in _scenes():
            path = Path(folder) / "picture.hdr"
            degrees = _render(items, camera, path)
            ours, theirs = rate_picture(*read_luminance(path)), _ask_evalglare(path)
            row = {"name": name, "degrees": degrees, "sources": len(ours.indices)}
            for own, other in FIGURES.items():
                value = getattr(ours, own)
                row[own] = [0.0 if value is None else float(value), theirs[other]]
            rows.append(row)
            say(f"judgement: glare of the picture '{name}'")
    return rows


def largest_difference(rows: list[dict]) -> float:
    """Largest difference of any figure that has a value. [%]"""
    pairs = [row[name] for row in rows for name in FIGURES if row[name][1] > 0.0]
    return max(100.0 * abs(ours / theirs - 1.0) for ours, theirs in pairs)


def _scenes():
    """Names, items and cameras."""
    office = load_office()
    place = np.asarray(office.camera.frame)[:3, 3]
    ahead = -np.asarray(office.camera.frame)[:3, 2]
    ahead[2] = 0.0
    yield "office", office.items, _eye(place, ahead)
    window = interiors.build_window()
    yield "window", window, _eye((3.4, 2.2, 1.3), (0.45, 1.0, -0.1))
    yield "window, perspective", window, _eye((3.4, 2.6, 1.3), (0.2, 1.0, 0.0), 90.0)
    panels = _build_panels()
    yield "panels", panels, _eye((2.0, 0.3, 1.2), (0.0, 1.0, 0.0))
    yield "panels, across", panels, _eye((0.3, 3.2, 1.2), (1.0, -0.4, 0.0))


def _build_panels() -> tuple:
    """Room of 4 x 6 x 2.8 m with six panels in its ceiling."""
    room = ((0.0, 0.0, 0.0), (4.0, 6.0, 2.8))
    names = ("bottom", "top", "-y", "+y", "-x", "+x")
    walls = make_mesh("walls", [side_of_box(*room, name) for name in names], "paint")
    flux = Output(Quantity.LUMINOUS_FLUX, 3200.0)
    lamps = [
        AreaLight(f"{x} {y}", f"{x} {y}", flux, rigid_frame((x, y, 2.79), (0, 0, -1)), 0.6, 0.6)
        for x in (1.0, 3.0)
        for y in (1.5, 3.0, 4.5)
    ]
    return (make_matt("paint", Constant(0.6)), walls, *lamps)


def _eye(place, ahead, degrees: float = 180.0) -> Camera:
    """Camera that looks ahead: a fisheye of a hemisphere, or a perspective of less."""
    backwards = -np.asarray(ahead, dtype=np.float64)
    backwards /= np.linalg.norm(backwards)
    right = np.cross((0.0, 0.0, 1.0), backwards)
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(backwards, right), backwards], axis=1)
    frame[:3, 3] = place
    if degrees < 180.0:
        extent = 2.0 * np.tan(np.radians(degrees / 2.0))
        return Camera(frame, Projection.PERSPECTIVE, SIZE, SIZE, extent, extent)
    return Camera(frame, Projection.EQUIDISTANT, SIZE, SIZE, np.pi, np.pi, field=np.pi)


def _render(items, camera: Camera, path: Path) -> float:
    """Render a view into a Radiance picture; return its angle. [degree]"""
    session = Session(witness=False)
    session.apply(SceneDelta(changed=tuple(items)))
    settings = ViewSettings(StopRule(samples=SAMPLES), seed=1)
    luminance = session.render(camera, settings).tristimulus[..., 1].astype(np.float64)
    luminance = np.repeat(np.repeat(np.maximum(luminance, 0.0), REPEAT, 0), REPEAT, 1)
    is_fisheye = camera.projection is Projection.EQUIDISTANT
    degrees = 180.0 if is_fisheye else 2.0 * np.degrees(np.arctan(camera.extent_x / 2.0))
    view = (
        f"-vta -vh {degrees} -vv {degrees}" if is_fisheye else f"-vtv -vh {degrees} -vv {degrees}"
    )
    head = f"#?RADIANCE\nVIEW= {view} -vp 0 0 0 -vd 0 1 0 -vu 0 0 1\nFORMAT=32-bit_rle_rgbe\n\n"
    side = len(luminance)
    body = _encode(luminance[::-1] / WHITE).tobytes()
    path.write_bytes(f"{head}-Y {side} +X {side}\n".encode() + body)
    return float(degrees)


def _encode(values: np.ndarray) -> np.ndarray:
    """Grey pixels as Radiance packs them: three mantissas and their exponent. (h, w) -> (h, w, 4) uint8"""
    mantissa, exponent = np.frexp(values)
    byte = np.floor(256.0 * mantissa)
    made = np.stack([byte, byte, byte, exponent + 128.0], axis=-1)
    return np.where(values[..., None] > 1e-30, np.clip(made, 0.0, 255.0), 0.0).astype(np.uint8)


def _ask_evalglare(path: Path) -> dict:
    program = Path(util.find_spec("pyradiance").origin).parent / "bin" / "evalglare"
    told = subprocess.run(
        [program, "-d", path], capture_output=True, text=True, timeout=PATIENCE, check=True
    )
    line = next(each for each in told.stdout.splitlines() if each.startswith("dgp,"))
    names, values = line.split(": ")
    return dict(zip(names.split(","), map(float, values.split()), strict=True))
