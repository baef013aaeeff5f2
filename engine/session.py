"""The one door to the engine: a scene goes in as deltas, answers come out as plain data.

Only plain data (dataclasses, numpy arrays, strings) passes, so that the same interface can stand before a process of
its own.
"""

import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from . import VERSION
from .accuracy.stopping import Progress, StopRule
from .atlas.unwrap import AtlasChart
from .scene.camera import Camera
from .scene.mesh import Mesh
from .scene.scene import Scene, SceneDelta


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from; enough to get it again."""

    engine_version: str
    variant: str
    scene_hash: str
    seed: int
    samples: int
    seconds: float
    decisions: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class ViewSettings:
    """What a picture has to contain."""

    rule: StopRule
    seed: int = 0
    illuminance: bool = False
    bands: int = 0
    transport: str = "auto"


@dataclass(frozen=True)
class Picture:
    """A rendered view. Row 0 is the bottom row.

    Parameters
    ----------
    tristimulus : (h, w, 3) float32    X, Y, Z with Y the luminance. [cd/m2]
    luminance_error : (h, w) float32    Standard error of Y. [cd/m2]
    relative_error : float    Root mean square over the pixels of their error over the larger of their own and the mean
        luminance. [-]
    depth : (h, w) float32    Along the view axis, at the pixel's centre; 1e10 where nothing is seen. [m]
    normal : (h, w, 3) float32    World space, at the pixel's centre; 0 where nothing is seen.
    object_index, material_index : (h, w) float32
    albedo : (h, w, 3) float32    Diffuse reflectance at the pixel's centre, for filters; 1 without a matt part. [-]
    illuminance, illuminance_error : (h, w) float32 or None
        Of the surface that is seen, through panes. [lx]
    bands : (h, w, b) float32 or None    Spectral radiance per band. [W/(m2 sr nm)]
    band_edges : (b + 1,) float64 or None    [nm]
    """

    tristimulus: np.ndarray
    luminance_error: np.ndarray
    relative_error: float
    depth: np.ndarray
    normal: np.ndarray
    object_index: np.ndarray
    material_index: np.ndarray
    albedo: np.ndarray
    provenance: Provenance
    illuminance: np.ndarray | None = None
    illuminance_error: np.ndarray | None = None
    bands: np.ndarray | None = None
    band_edges: np.ndarray | None = None


@dataclass(frozen=True)
class BakeTarget:
    """A mesh and the charts of its lux map."""

    mesh: Mesh
    charts: AtlasChart


@dataclass(frozen=True)
class LuxMap:
    """Illuminance over an unwrapped mesh. Row 0 is the bottom row of the map.

    Parameters
    ----------
    name : str    Of the object.
    illuminance : (h, w) float32    Seams dilated; 0 outside the margin. [lx]
    standard_error : (h, w) float32    Of each lumel. [lx]
    covered : (h, w) bool    Lumels that lie on the surface.
    area : (h, w) float32    Surface in each lumel. [m2]
    mean, minimum, maximum : float    Area-weighted mean and extremes over the covered lumels. [lx]
    relative_standard_error : float    Of the map: area-weighted RMS of the lumels' errors over the mean. [-]
    mean_standard_error : float    Of ``mean``, the lumels being independent. [lx]
    """

    name: str
    illuminance: np.ndarray
    standard_error: np.ndarray
    covered: np.ndarray
    area: np.ndarray
    mean: float
    minimum: float
    maximum: float
    relative_standard_error: float
    mean_standard_error: float
    samples: int
    density: float
    provenance: Provenance


@dataclass(frozen=True)
class Measurement:
    """Illuminance at sensors. ``illuminance`` and ``standard_error``: (n,) float64. [lx]"""

    illuminance: np.ndarray
    standard_error: np.ndarray
    provenance: Provenance


@dataclass
class _Compiled:
    key: tuple
    scene: object
    variant: str
    requirements: object = field(default=None)


SENSOR_GROUPS = 16
"""Independent groups for sensors: enough for an error of each, within 18 % of itself."""


_ONE_AT_A_TIME = threading.Lock()
"""Mitsuba's variant belongs to the process, so jobs of several sessions wait for each other."""


class Session:
    """Keeps a scene and answers questions about it, in this process and on the calling thread."""

    def __init__(self):
        self.scene = Scene()
        self._compiled: _Compiled | None = None
        self._cancel = False
        self._revision = 0

    def apply(self, delta: SceneDelta) -> None:
        """Change the scene."""
        self.scene.apply(delta)
        self._revision += 1

    def cancel(self) -> None:
        """Ask the running job to end; it raises `Cancelled` before its next launch."""
        self._cancel = True

    def render(
        self, camera: Camera, settings: ViewSettings, progress: Callable | None = None
    ) -> Picture:
        """Render a view.

        Parameters
        ----------
        camera : Camera
        settings : ViewSettings
        progress : callable or None    ``progress(Progress, preview)`` where ``preview()`` gives the picture so far
            as (h, w, 3) X, Y, Z. [cd/m2]

        Raises
        ------
        Cancelled    After `cancel`.
        LumenrayError    The scene or the machine does not allow it; the text says what to do.
        """
        with self._engine(settings.transport) as compiled:
            from .transport import picture

            start = time.perf_counter()
            made, samples = picture.render(
                compiled.scene, camera, settings, progress=progress, cancelled=self._cancelled
            )
        return Picture(**made, provenance=self._provenance(compiled, settings.seed, samples, start))

    def measure(
        self,
        positions,
        normals,
        rule: StopRule,
        seed: int = 0,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
    ) -> Measurement:
        """Illuminance at points. ``positions``, ``normals``: (n, 3) world space. [m -> lx]"""
        with self._engine(transport) as compiled:
            from .transport.illuminance import Receivers, compute

            start = time.perf_counter()
            receivers = Receivers.at_points(positions, normals)
            estimate = compute(
                compiled.scene, receivers, rule, seed, SENSOR_GROUPS, progress, self._cancelled
            )
        provenance = self._provenance(compiled, seed, estimate.samples, start)
        return Measurement(estimate.mean, estimate.standard_error, provenance)

    def bake(
        self,
        targets: list[BakeTarget],
        rule: StopRule,
        seed: int = 0,
        margin: int = 4,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
    ) -> list[LuxMap]:
        """Lux maps of unwrapped meshes, all to the same rule; a rule's time is shared by all."""
        from .atlas.lumels import rasterise
        from .atlas.maps import assemble

        # The atlas is laid out before the scene is compiled: bad charts fail fast.
        lumels = [rasterise(target.mesh, target.charts) for target in targets]
        if rule.seconds is not None:
            rule = replace(rule, seconds=rule.seconds / len(targets))
        maps = []
        with self._engine(transport) as compiled:
            from .transport.illuminance import compute

            begin = time.perf_counter()
            for number, (target, lumel) in enumerate(zip(targets, lumels, strict=True)):
                start = time.perf_counter()

                def report(state, number=number, name=target.mesh.name):
                    if progress is not None:
                        progress(_progress_of_part(state, number, len(targets), begin, name))

                own_seed = seed + number
                estimate = compute(
                    compiled.scene, lumel.receivers, rule, own_seed, 2, report, self._cancelled
                )
                provenance = self._provenance(compiled, own_seed, estimate.samples, start)
                finished = assemble(target, lumel, estimate, margin)
                maps.append(LuxMap(**finished, provenance=provenance))
        return maps

    # ---- private ----

    @contextmanager
    def _engine(self, transport: str):
        """Give the compiled scene, alone with the process's Mitsuba."""
        with _ONE_AT_A_TIME:
            yield self._prepare(transport)

    def _cancelled(self) -> bool:
        return self._cancel

    def _prepare(self, transport: str) -> _Compiled:
        """Bring the Mitsuba objects up to date with the scene."""
        from .transport import backend, requirements

        self._cancel = False
        needs = requirements.analyse(self.scene, transport)
        key = (self._revision, needs.spectral)
        if self._compiled is not None and self._compiled.key == key:
            backend.start(needs.spectral)
            return self._compiled
        self._compiled = None
        variant = backend.start(needs.spectral)
        from .transport.compile import compile_scene

        self._compiled = _Compiled(key, compile_scene(self.scene, needs), variant, needs)
        return self._compiled

    def _provenance(self, compiled: _Compiled, seed: int, samples: int, start: float) -> Provenance:
        return Provenance(
            engine_version=VERSION,
            variant=compiled.variant,
            scene_hash=self.scene.hash(),
            seed=seed,
            samples=samples,
            seconds=time.perf_counter() - start,
            decisions=compiled.requirements.reasons,
            notes=tuple(compiled.scene.notes),
        )


def _progress_of_part(
    state: Progress, number: int, count: int, begin: float, name: str
) -> Progress:
    """Progress of a job of ``count`` alike parts from that of one of them."""
    done = (number + state.done) / count
    seconds = time.perf_counter() - begin
    left = seconds * (1.0 - done) / done if done > 0.0 else None
    return Progress(done, state.samples, state.relative_error, seconds, left, name)
