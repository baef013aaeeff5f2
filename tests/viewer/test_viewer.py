"""Exported scenes in a viewer of other people's making: three.js in a Chromium without a window, and Khronos' validator.

``setup.sh`` beside this file installs what is needed; without that these tests are skipped.
"""

import base64
import json
import math
import shutil
import subprocess
import threading
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from baked_rooms import COLOURS, bake, lamp_light, materials, room
from PIL import Image
from small_scenes import quad

from lumenray.engine.formats.gltf import GltfLimits, write_gltf

HERE = Path(__file__).parent

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)

WHITE = 150.0

TOP = 1000.0
"""Of the scale of false colours. [lx]"""

STOPS = (
    "#0d0833",
    "#1f268f",
    "#1266b8",
    "#0f9e8f",
    "#5cc24c",
    "#d9d42e",
    "#fa9921",
    "#e03d21",
    "#fce6e0",
)
"""Colours of the scale as they are in the legends of the guide's pictures."""

LIMIT = 180
"""Longest time for the whole visit. [s]"""

pytestmark = pytest.mark.skipif(
    CHROMIUM is None or not shutil.which("node") or not (HERE / "node_modules" / "three").is_dir(),
    reason="needs Chromium, Node and three.js: run tests/viewer/setup.sh",
)


class Handler(SimpleHTTPRequestHandler):
    """Serves the page, and under /models/ the files of the test."""

    def __init__(self, *args, models, **more):
        self.models = models
        super().__init__(*args, directory=str(HERE), **more)

    def translate_path(self, path):
        if path.startswith("/models/"):
            return str(self.models / Path(path).name.partition("?")[0])
        if path == "/favicon.ico":
            return str(HERE / "viewer.html")
        return super().translate_path(path)

    def log_message(self, *args):
        """Say nothing."""


@contextmanager
def served(folder):
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, models=folder))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()
        thread.join(10)


def upright(places):
    """Y up."""
    x, y, z = np.moveaxis(np.asarray(places, float), -1, 0)
    return np.stack([x, z, -y], axis=-1)


OFFSET = np.array([5000.0, -3000.0, 20.0])

SHARES = [(u, v) for u in (0.15, 0.4, 0.62, 0.88) for v in (0.2, 0.45, 0.8)]
"""Places on every surface, in shares of its edges."""


@pytest.fixture(scope="module")
def visit(tmp_path_factory):
    """Write the room in three ways and look at it."""
    folder = tmp_path_factory.mktemp("models")
    sheets, lamp = room(OFFSET)
    meshes = [sheet.mesh for sheet in sheets]
    glow = quad("panel", np.add(OFFSET, (2.4, 2.0, 2.3)), (0, 0.6, 0), (0.6, 0, 0), "glow")
    result = bake(sheets, lamp)
    options = {"white": WHITE, "top": TOP}
    write_gltf(folder / "room.glb", [*meshes, glow], materials(), result, **options)
    write_gltf(folder / "room.gltf", meshes, materials(), result, **options)
    few = GltfLimits(2, 256)
    write_gltf(folder / "few.glb", meshes, materials(), result, limits=few, **options)
    points = [p for sheet in sheets for p in sheet.points(np.array(SHARES))]
    points += [np.add(OFFSET, (2.7, 2.3, 2.3))]
    with served(folder) as address:
        view = {
            "width": 640,
            "height": 480,
            "eye": list(upright(np.add(OFFSET, (5.5, -2.5, 1.9)))),
            "target": list(upright(np.add(OFFSET, (1.6, 1.9, 1.1)))),
            "angle": 50,
            "points": upright(points).tolist(),
        }
        names = ["room.glb", "room.glb", "room.gltf", "few.glb"]
        variants = [None, "illuminance", "light", "illuminance"]
        request = folder / "request.json"
        request.write_text(
            json.dumps(
                {
                    "validate": [str(folder / n) for n in ("room.glb", "room.gltf", "few.glb")],
                    "chromium": CHROMIUM,
                    "page": f"{address}/viewer.html",
                    "views": [
                        {**view, "model": f"{address}/models/{name}", "variant": variant}
                        for name, variant in zip(names, variants, strict=True)
                    ],
                }
            )
        )
        done = subprocess.run(
            ["node", str(HERE / "drive.mjs"), str(request)],
            capture_output=True,
            text=True,
            timeout=LIMIT,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    for number, seen in enumerate(report["views"]):
        data = base64.b64decode(seen["png"].partition(",")[2])
        (folder / f"view_{number}.png").write_bytes(data)
        seen["picture"] = np.asarray(Image.open(BytesIO(data)).convert("RGB"))
    return report, sheets, lamp, folder


def encode(linear):
    """IEC 61966-2-1. [-> 0..255]"""
    x = np.clip(linear, 0.0, 1.0)
    return 255.0 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def false_colour(lux):
    """Colour of the scale. [lx -> 0..255]"""
    stops = np.array([[int(s[i : i + 2], 16) for i in (1, 3, 5)] for s in STOPS])
    place = min(lux / TOP, 1.0) * (len(stops) - 1)
    return np.array([np.interp(place, np.arange(len(stops)), stops[:, i]) for i in range(3)])


def places(visit, number):
    """Yield every place with its sheet, its illuminance and what the viewer saw there."""
    report, sheets, lamp, _ = visit
    points = report["views"][number]["points"]
    for i, sheet in enumerate(sheets):
        for share, seen in zip(SHARES, points[len(SHARES) * i :], strict=False):
            place = sheet.points(np.array(share))
            yield sheet, lamp_light(place, sheet.normal, lamp), seen


def test_the_validator_finds_nothing(visit):
    for file in visit[0]["files"]:
        assert (file["errors"], file["warnings"]) == (0, 0), file["messages"]
        assert file["info"]["version"] == "2.0"


def test_the_viewer_loads_it_without_complaint(visit):
    report = visit[0]
    assert report["complaints"] == []
    assert [seen["glError"] for seen in report["views"]] == [0] * 4
    whole, _, beside, few = report["views"]
    assert (whole["meshes"], whole["unlit"], whole["triangles"]) == (4, 4, 8)
    assert whole["variants"] == ["light", "illuminance"]
    assert (beside["meshes"], beside["textures"]) == (3, whole["textures"])
    assert (few["textures"], few["largest"] <= 256) == (1, True)


@pytest.mark.parametrize("number", [0, 2])
def test_every_place_is_as_bright_as_its_luminance(visit, number):
    for sheet, lux, seen in places(visit, number):
        assert seen["object"].replace("_", " ") == sheet.mesh.name
        assert seen["distance"] < 2e-3
        reflectance = np.array(COLOURS[sheet.mesh.materials[0]])
        # Where the brightest material is white the light is cut off.
        most = math.pi * WHITE / max(max(c) for c in COLOURS.values())
        expected = encode(reflectance * min(lux, most) / math.pi / WHITE)
        assert np.abs(seen["colour"] - expected).max() <= 2.0, (sheet.mesh.name, lux)


@pytest.mark.parametrize(("number", "step"), [(1, 3.0), (3, 5.0)])
def test_the_variant_shows_the_illuminance_in_false_colours(visit, number, step):
    for sheet, lux, seen in places(visit, number):
        assert seen["object"].replace("_", " ") == sheet.mesh.name
        # The scale has 256 steps, and from one to the next a component changes by up to 4. Halved pages add what
        # the scale bends between two texels.
        assert np.abs(seen["colour"] - false_colour(lux)).max() <= step, (sheet.mesh.name, lux)


def test_a_lamp_glows_in_both_looks(visit):
    for number in (0, 1):
        seen = visit[0]["views"][number]["points"][-1]
        assert seen["object"] == "panel"
        luminance = np.dot((np.array(seen["colour"]) / 255.0) ** 2.2, (0.2126, 0.7152, 0.0722))
        assert luminance == pytest.approx(90.0 / WHITE, rel=0.03)
