"""Radiance as a rival: rtrace -I at places of the same lumels, exactly and with its cache of indirect light."""

import os
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib import util
from pathlib import Path

import numpy as np

from ...engine.scene.scene import Scene, SceneDelta
from ...validation.bench import CannotStateError
from ...validation.peers import radiance as peer
from ...validation.peers.contents import extent, sort_items
from ...validation.peers.radiance_scene import write_scene
from .lumels import LumelPlaces
from .scenes import AtlasScene

PLACES = 16
"""Places of a lumel that are asked for; their mean stands for it."""

REST = 2e-3
"""Share of the light that may be left when reflections are no longer followed: below what is asked for."""

WEIGHT = 2e-3
"""Weight of a ray below which Russian roulette decides on it, as rtrace does by itself (rtrace -lw)."""


@dataclass(frozen=True)
class Setting:
    """Options of rtrace for indirect light: -ad, -as, -aa, -ar and -ab; ``bounces`` 0: as many as the light takes."""

    divisions: int
    supersamples: int = 0
    accuracy: float = 0.0
    resolution: int = 0
    bounces: int = 0

    @property
    def options(self) -> list[str]:
        """As rtrace takes them."""
        return [
            *("-ad", str(self.divisions), "-as", str(self.supersamples)),
            *("-aa", f"{self.accuracy:g}", "-ar", str(self.resolution)),
        ]


EXACT = tuple(Setting(count) for count in (4, 16, 64, 256, 1024))
"""Every place for itself."""

CACHED = (
    Setting(128, 0, 0.25, 16, 6),
    Setting(128, 0, 0.25, 16, 8),
    Setting(256, 64, 0.2, 32, 8),
    Setting(512, 128, 0.15, 64, 8),
    Setting(1024, 256, 0.1, 128, 10),
)
"""With the cache, from coarse to fine (G. W. Larson, R. Shakespeare: Rendering with Radiance, 1998, ch. 12).
More bounces take many times longer."""


class RadianceRace:
    """Radiance's programs on one scene, written once.

    Parameters
    ----------
    scene : AtlasScene    Plain, see `variants.make_plain`.
    places : LumelPlaces

    Raises
    ------
    CannotStateError    The package `pyradiance` is missing, or Radiance has nothing for a part of the scene.
    """

    def __init__(self, scene: AtlasScene, places: LumelPlaces):
        if util.find_spec("pyradiance") is None:
            raise CannotStateError("pyradiance is not installed (run 'make setup')")
        held = Scene()
        held.apply(SceneDelta(changed=scene.items))
        items = [
            *held.materials.values(),
            *(held.mesh(key) for key in held.meshes),
            *held.lights.values(),
            *([held.world] if held.world is not None else []),
        ]
        contents = sort_items(items)
        rows = _spread_rows(places)
        positions, normals = places.positions[rows], places.geometric_normals[rows]
        middle, _ = extent(contents, positions)
        lifted = (positions + peer.LIFT * normals - middle) / peer.UNIT
        self._scene = write_scene(contents, lifted, middle, peer.UNIT, False, True)
        self._rays = np.concatenate([lifted - peer.OWN_LIFT * normals, normals], axis=1)
        self._folder = tempfile.TemporaryDirectory()
        peer._build(Path(self._folder.name), self._scene)
        scatter = min(max(self._scene.scatter, 0.1), 0.99)
        self.bounces = int(np.ceil(np.log(REST) / np.log(scatter))) + self._scene.has_glow

    def run(self, setting: Setting, longest: float) -> tuple[np.ndarray, float] | None:
        """Illuminances (n,) [lx], and the whole time of rtrace on all processors [s]; None where it takes too long.

        Parameters
        ----------
        setting : Setting
        longest : float    [s]
        """
        bounces = setting.bounces or self.bounces
        options = [
            *("-ab", str(bounces), *setting.options, "-aw", "0", "-av", "0", "0", "0"),
            *("-dt", "0", "-dc", "1", "-dp", "0", "-ds", "0.2", "-dr", "0"),
            *("-dj", "1" if self._scene.has_extent or self._scene.has_round else "0"),
            # A limit below 0 asks for Russian roulette.
            *("-lw", str(WEIGHT), "-lr", str(-bounces - 10), "-u+"),
        ]
        # Neighbours share a cache.
        parts = np.array_split(self._rays, min(os.cpu_count() or 1, len(self._rays)))
        begin = time.perf_counter()
        with ThreadPoolExecutor(len(parts)) as pool:
            answers = list(pool.map(lambda part: self._trace(options, part, longest), parts))
        seconds = time.perf_counter() - begin
        if any(answer is None for answer in answers):
            return None
        return np.concatenate(answers).reshape(-1, PLACES).mean(axis=1), seconds

    def _trace(self, options: list[str], rays: np.ndarray, longest: float) -> np.ndarray | None:
        import pyradiance

        home = Path(pyradiance.__file__).parent
        library = os.pathsep.join([".", str(home / "lib")])
        try:
            made = subprocess.run(
                [
                    Path(pyradiance.BINPATH) / "rtrace",
                    *("-h", "-w-", "-I", "-fdd"),
                    *options,
                    "scene.oct",
                ],
                cwd=self._folder.name,
                env=os.environ | {"RAYPATH": library},
                input=rays.astype("<f8").tobytes(),
                capture_output=True,
                timeout=longest,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return None
        except OSError as error:
            raise CannotStateError(f"rtrace cannot be run ({error})") from None
        values = np.frombuffer(made.stdout, dtype="<f8")
        if made.returncode or values.size != 3 * len(rays):
            said = made.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
            raise CannotStateError(f"rtrace: {said[-1]}")
        return values.reshape(-1, 3)[:, 1]

    def close(self) -> None:
        """Delete its files."""
        self._folder.cleanup()


def _spread_rows(places: LumelPlaces) -> np.ndarray:
    """Rows of `PLACES` places of every lumel, evenly drawn out of its own. (n PLACES,)"""
    numbers = np.random.default_rng(3).random((len(places), PLACES)) + np.arange(PLACES)
    chosen = (numbers / PLACES * places.count[:, None]).astype(np.int64)
    return (places.start[:, None] + np.minimum(chosen, places.count[:, None] - 1)).ravel()
