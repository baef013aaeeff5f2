"""Radiance as an instrument: oconv and rtrace, as they come with the package `pyradiance`."""

import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from importlib import util
from pathlib import Path

import numpy as np

from ..bench import CannotStateError, Query, Readings
from .contents import check_query, extent, sort_items
from .flat_lights import is_near
from .radiance_scene import LUMENS_PER_WATT, LUMINAIRE_RADIUS, RadianceScene, write_scene

PATIENCE = 300.0
"""Longest that one of the programs may take. [s]"""

REPEATS = 16
"""How often every sensor is measured where something is random; the spread gives the error."""

ROUND_REPEATS = 20_000
"""The same for a sun's disk or a sphere and nothing else random: each time one point of it is looked at."""

LEAST_DIVISIONS, MOST_DIVISIONS = 16, 1 << 16
"""Of the hemisphere, for one measurement."""

FINENESS = "0.03"
"""Size of the parts of a light over their distance (rtrace -ds). Much finer, grazing light is lost without a word."""

FLAT_REPEATS = 256
"""How often flat lights are looked at where nothing else is random."""

REST = 5e-4
"""Share of the light that may be left when reflections are no longer followed."""

MOST_BOUNCES = 1000

BOUNCE_COST = 8.0
"""Time of a reflection over that of a ray that ends at once; measured."""

MESH_COST = 4.0
"""What large meshes make of it."""

LIFT = 1e-6
"""How far sensors are lifted off the surface that they may lie on. [m], or share of the scene's size if that is less"""

OWN_LIFT = 1e-4
"""How far rtrace itself lifts them (rtrace.c, irradiance calculation), in units of its scene."""

UNIT = 1e-3
"""Length that is 1 for rtrace, which knows no lengths below 1e-6. [m], or share of the scene's size if that is less"""


class Radiance:
    """Radiance's rtrace without its caches and shortcuts.

    Parameters
    ----------
    rays : int    About how many rays a query may take, all sensors together.

    Raises
    ------
    CannotStateError    The package `pyradiance` is missing.
    """

    name = "Radiance"

    def __init__(self, rays: int = 8_000_000):
        if util.find_spec("pyradiance") is None:
            raise CannotStateError("pyradiance is not installed (run 'make setup')")
        self.rays = rays

    def measure(self, items, query: Query, seed: int) -> Readings:
        """Return illuminances; their errors come from repeats, 0 where nothing is random. rtrace takes no seed."""
        check_query(query)
        contents = sort_items(items)
        positions = np.asarray(query.positions, dtype=np.float64)
        middle, size = extent(contents, positions)
        normals = query.normals / np.linalg.norm(query.normals, axis=1, keepdims=True)
        size = min(1.0, size) if size > 0.0 else 1.0
        unit = UNIT * size
        # In empty space there is nothing to lift a sensor from.
        lifted = positions + (LIFT * size if contents.parts else 0.0) * normals
        near = is_near(contents, positions)
        values, errors = np.zeros(len(near)), np.zeros(len(near))
        for aims in (True, False):
            chosen = near != aims
            if not chosen.any():
                continue
            sensors = (lifted[chosen] - middle) / unit
            scene = write_scene(contents, sensors, middle, unit, query.reflections == 0, aims)
            rays = np.concatenate([sensors - OWN_LIFT * normals[chosen], normals[chosen]], axis=1)
            values[chosen], errors[chosen] = self._trace(scene, rays)
        return Readings(values, errors)

    def _trace(self, scene: RadianceScene, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        repeats, options = self._options(scene, len(rays))
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            _build(folder, scene)
            parts = np.array_split(rays, min(os.cpu_count() or 1, len(rays)))
            with ThreadPoolExecutor(len(parts)) as pool:
                answers = list(
                    pool.map(lambda part: _rtrace(folder, options, part, repeats), parts)
                )
        made = np.concatenate(answers, axis=1)
        spread = made.std(axis=0, ddof=1) / np.sqrt(repeats) if repeats > 1 else 0.0 * made[0]
        return made.mean(axis=0), spread

    def _options(self, scene: RadianceScene, sensors: int) -> tuple[int, list[str]]:
        """Repeats, and options of rtrace."""
        bounces, cost = 0, 1.0
        if scene.scatter > 0.0:
            bounces = int(np.ceil(np.log(REST) / np.log(min(scene.scatter, 0.999))))
            bounces = min(max(bounces, 1), MOST_BOUNCES)
            each = BOUNCE_COST * (MESH_COST if scene.meshes else 1.0)
            # Into the open most paths end early.
            length = 1.0 / (1.0 - scene.scatter) if scene.is_open else bounces
            cost += each * min(length, bounces) * max(scene.lights, 1)
        bounces += scene.has_glow
        jitter = scene.has_extent or scene.has_round
        share = self.rays / (cost * sensors)
        repeats = int(np.clip(share / LEAST_DIVISIONS, 2, REPEATS)) if jitter or bounces else 1
        if jitter and not bounces:
            repeats = ROUND_REPEATS if scene.has_round else FLAT_REPEATS
        divisions = int(np.clip(share / repeats, LEAST_DIVISIONS, MOST_DIVISIONS))
        return repeats, [
            *("-ab", str(bounces), "-aa", "0", "-as", "0", "-ad", str(divisions)),
            *("-aw", "0", "-av", "0", "0", "0"),
            *("-dt", "0", "-dc", "1", "-dp", "0", "-dj", "1" if jitter else "0"),
            *("-ds", "0.2" if scene.scatter > 0.0 else FINENESS),
            *("-dr", "0" if not scene.mirrors else ("48" if scene.mirrors <= 2 else "6")),
            *("-lw", "0", "-lr", str(bounces + 100), "-u+"),
        ]


def _build(folder: Path, scene: RadianceScene) -> None:
    """Write all files and make the octree."""
    for name, data in scene.files.items():
        (folder / name).write_bytes(data)
    for name, (vertices, triangles) in scene.meshes.items():
        made = _compile_mesh(vertices.tobytes(), triangles.astype(np.int64).tobytes())
        (folder / f"{name}.rtm").write_bytes(made)
    lines = list(scene.text)
    for name, move in scene.luminaires:
        factor = f"{LUMENS_PER_WATT:g}"
        _run(
            folder, "ies2rad", "-t", "default", "-m", factor, "-i", str(LUMINAIRE_RADIUS),
            "-o", name, f"{name}.ies",
        )  # fmt: skip
        lines.append(f"!xform {move} {name}.rad\n")
    bounds = ("-b", *(f"{value:.12g}" for value in scene.cube)) if scene.cube else ()
    (folder / "scene.rad").write_text("\n".join(lines), encoding="ascii")
    (folder / "scene.oct").write_bytes(_run(folder, "oconv", *bounds, "scene.rad"))


@lru_cache(maxsize=4)
def _compile_mesh(vertices: bytes, triangles: bytes) -> bytes:
    """Radiance's mesh of float64 vertices and int64 triangles; kept, as scenes of a case share theirs."""
    places = np.frombuffer(vertices).reshape(-1, 3)
    corners = np.frombuffer(triangles, dtype=np.int64).reshape(-1, 3) + 1
    lines = [f"v {x:.12g} {y:.12g} {z:.12g}" for x, y, z in places]
    lines += [f"f {a} {b} {c}" for a, b, c in corners]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "mesh.obj").write_text("\n".join([*lines, ""]), encoding="ascii")
        _run(folder, "obj2mesh", "mesh.obj", "mesh.rtm")
        return (folder / "mesh.rtm").read_bytes()


def _rtrace(folder: Path, options: list[str], rays: np.ndarray, repeats: int) -> np.ndarray:
    """Illuminances (repeats, n). [lx]"""
    sent = np.tile(rays, (repeats, 1)).astype("<f8").tobytes()
    said = _run(folder, "rtrace", "-h", "-w-", "-I", "-fdd", *options, "scene.oct", sent=sent)
    made = np.frombuffer(said, dtype="<f8")
    if made.size != 3 * repeats * len(rays):
        raise CannotStateError(f"rtrace answers {made.size // 3} of {repeats * len(rays)} rays")
    return made.reshape(repeats, len(rays), 3)[:, :, 1]


def _run(folder: Path, program: str, *options: str, sent: bytes = b"") -> bytes:
    import pyradiance

    home = Path(pyradiance.__file__).parent
    paths = os.pathsep.join([str(pyradiance.BINPATH), os.environ.get("PATH", "")])
    surroundings = os.environ | {
        "RAYPATH": os.pathsep.join([".", str(home / "lib")]),
        "PATH": paths,
    }
    try:
        made = subprocess.run(
            [Path(pyradiance.BINPATH) / program, *options],
            cwd=folder,
            env=surroundings,
            input=sent,
            capture_output=True,
            timeout=PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        # Its own words are the whole command, with paths of this machine.
        raise CannotStateError(f"Radiance's {program} takes longer than {PATIENCE:g} s") from None
    except OSError as error:
        raise CannotStateError(f"Radiance's {program} cannot be run ({error.strerror})") from None
    if made.returncode:
        said = made.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
        raise CannotStateError(f"Radiance's {program}: {'; '.join(said)}")
    return made.stdout
