"""The one door to the engine: a scene goes in as deltas, answers come out as plain data.

Only plain data (dataclasses, numpy arrays, strings) passes, so that the same interface can stand before a process of
its own.
"""

import gc
import threading
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from enum import Enum

import numpy as np

from . import VERSION
from .accuracy.stopping import Progress, StopRule
from .analysis.explanation import Explanation, explain_rays
from .baking.order import BakeOrder, BakeResult
from .errors import SceneError
from .scene.camera import Camera
from .scene.checks import check_item
from .scene.material import Surface
from .scene.provenance import Provenance
from .scene.scene import Scene, SceneDelta
from .scene.sensor import SensorKind


@dataclass(frozen=True)
class ViewSettings:
    """What a picture has to contain.

    ``spectral_file``: where its bands are written as a spectral OpenEXR; ``transparent``: whether to tell what of it is the
    surroundings behind everything.
    """

    rule: StopRule
    seed: int = 0
    illuminance: bool = False
    bands: int = 0
    transport: str = "auto"
    spectral_file: str | None = None
    transparent: bool = False


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
    backdrop : (h, w, 3) float32 or None    Part of ``tristimulus`` by surroundings that are seen straight. [cd/m2]
    coverage : (h, w) float32 or None    Share of a pixel that shows anything else. [-]
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
    backdrop: np.ndarray | None = None
    coverage: np.ndarray | None = None


@dataclass(frozen=True)
class LiveSettings:
    """What a live view has to compute. ``samples`` per pixel are the most it goes to."""

    samples: int = 1024
    seed: int = 0
    illuminance: bool = False
    transport: str = "auto"


class DisplayMode(Enum):
    """What a live view shows."""

    PICTURE = "picture"  # scene-linear colour, 1 at the white luminance
    LUMINANCE = "luminance"  # the same without colour
    FALSE_LUMINANCE = "false_luminance"  # cd/m2 in false colours
    FALSE_ILLUMINANCE = "false_illuminance"  # lx in false colours


@dataclass(frozen=True)
class Display:
    """How a live view turns numbers into what is seen.

    Parameters
    ----------
    mode : DisplayMode
    white : float or None    Luminance that becomes 1; None: from the picture itself. [cd/m2]
    low, high : float    Ends of the false colours' scale; ``high`` 0: from the picture itself. [cd/m2 or lx]
    logarithmic : bool    Whether the scale of the false colours is logarithmic.
    """

    mode: DisplayMode = DisplayMode.PICTURE
    white: float | None = 200.0
    low: float = 0.0
    high: float = 0.0
    logarithmic: bool = False


@dataclass(frozen=True)
class Commit:
    """What bringing the engine's objects up to date took.

    Parameters
    ----------
    items : int    Items that the deltas since the last time named.
    action : str    For people: what had to be done.
    seconds : float    For the objects.
    first_sample_seconds : float    From then to the first samples.
    """

    items: int = 0
    action: str = ""
    seconds: float = 0.0
    first_sample_seconds: float = 0.0


@dataclass(frozen=True)
class Frame:
    """State of a live view. Row 0 is the bottom row; smaller than the view while it is coarse.

    Parameters
    ----------
    pixels : (h, w, 4) float32
        Scene-linear colour and 1 (pictures and luminance), or display colours in sRGB (false colours).
    is_display_referred : bool    Whether ``pixels`` are display colours that no view transform must touch.
    low, high : float    Ends of the scale, in ``unit``; ``is_logarithmic``: whether equal ratios are equal lengths.
    revision : int    Number of the scene's state: how many deltas had been applied.
    samples : int    Per pixel.
    relative_error : float    As in `Picture`; infinite while unknown.
    is_final : bool    Whether no better frame will come.
    """

    pixels: np.ndarray
    is_display_referred: bool
    is_logarithmic: bool
    low: float
    high: float
    unit: str
    revision: int
    samples: int
    relative_error: float
    is_final: bool
    commit: Commit


@dataclass(frozen=True)
class Measurement:
    """Illuminance at sensors.

    Parameters
    ----------
    illuminance, standard_error : (n,) float64    [lx]
    tristimulus : (n, 3) float64 or None    X, Y, Z with Y the illuminance, where colour was asked for. [lx]
    tristimulus_error : (n, 3) float64 or None    Standard errors. [lx]
    balance : dict or None    Energy of the whole by the pilot from the lights, see `WitnessReport.balance`. [lm]
    """

    illuminance: np.ndarray
    standard_error: np.ndarray
    provenance: Provenance
    tristimulus: np.ndarray | None = None
    tristimulus_error: np.ndarray | None = None
    balance: dict | None = None


@dataclass(frozen=True)
class SurfaceProbe:
    """What a goniometer reads of a surface.

    Parameters
    ----------
    angles : (n,) float64 or None    Between the normal and the direction that light came from; None: even light. [deg]
    reflectance, transmittance : (n,) float64    Shares of the arriving energy, into all directions together. [-]
    reflectance_error, transmittance_error : (n,) float64    Standard errors. [-]
    """

    angles: np.ndarray | None
    reflectance: np.ndarray
    transmittance: np.ndarray
    reflectance_error: np.ndarray
    transmittance_error: np.ndarray


SENSOR_GROUPS = 16
"""Independent groups for sensors: enough for an error of each, within 18 % of itself."""

FRAME_INTERVAL = 0.08
"""Shortest time between two frames of a live view. [s]"""

FRAME_SHARE = 0.25
"""Largest share of a live view's time that is spent on making frames."""

_ONE_AT_A_TIME = threading.RLock()
"""Mitsuba's variant belongs to the process, so jobs of several threads wait for each other."""


@dataclass
class _View:
    """The live view that was asked for, and its state of work."""

    camera: Camera
    settings: LiveSettings
    display: Display
    work: object = None
    revision: int = -1
    is_shown: bool = False
    shown_at: float = 0.0
    frame_seconds: float = 0.0


@contextmanager
def _garbage_left_alone():
    """Keep Python from freeing old scenes on its own: Dr.Jit ends the process if that hits the making of a kernel."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


class Session:
    """Keeps a scene and answers questions about it, in this process and on the calling thread.

    Parameters
    ----------
    interrupt : callable or None
        Called between the launches of long jobs; it may use other sessions.
    witness : bool
        Whether bakes and measurements that ask for a second witness get it; not where only their own samples matter.
    """

    def __init__(self, interrupt: Callable[[], None] | None = None, witness: bool = True):
        self.scene = Scene()
        self._has_witness = witness
        self.revision = 0
        self.commit = Commit()
        self._interrupt = interrupt
        self._compiled = None
        self._variant = ""
        self._requirements: tuple | None = None
        self._pending: dict[str, None] = {}
        self._view: _View | None = None
        self._cancel = self._stop = False
        self._is_busy = False

    def apply(self, delta: SceneDelta) -> None:
        """Change the scene. The engine's objects follow when the next answer is asked for.

        Raises
        ------
        SceneError    The delta does not fit the scene, which stays as it was.
        """
        self.scene.apply(delta)
        self.revision += 1
        for key in (
            *delta.removed,
            *(item.id for item in delta.changed),
            *(attachment.id for attachment in delta.attached),
            *(new for new, _ in delta.copies),
        ):
            self._pending[key] = None

    def stop(self) -> None:
        """Ask a bake that runs to end as soon as what it has can be kept with an error; may be called from any thread."""
        self._stop = True

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
        check_item(camera)
        with self._engine(settings.transport) as compiled:
            from .transport.light_tracing.bent_lights import bent_lights
            from .transport.light_tracing.bright_spots import bright_spots
            from .transport.paths import picture

            start = time.perf_counter()
            seen = picture.look(compiled, picture.Film(camera, compiled.origin))
            with bent_lights(compiled) as notes, bright_spots(compiled, *seen):
                made, samples = picture.render(
                    compiled, camera, settings, progress=progress, cancelled=self._cancelled
                )
            provenance = self._provenance(compiled, settings.seed, samples, start, notes)
            finished = Picture(**made, provenance=provenance)
            if settings.spectral_file and finished.bands is not None:
                from .formats.exr import write_spectral

                write_spectral(settings.spectral_file, finished)
        return finished

    def measure(
        self,
        positions,
        normals,
        rule: StopRule,
        seed: int = 0,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
        *,
        kind: SensorKind = SensorKind.PLANAR,
        reflections: int | None = None,
        colour: bool = False,
        witness: bool = True,
    ) -> Measurement:
        """Illuminance at points.

        Parameters
        ----------
        positions, normals : (n, 3) array    World space. [m]
        rule : StopRule
        kind : SensorKind    Which illuminance; not all have a normal.
        reflections : int or None
            Most reflections (scatterings, of any kind but passing straight) that light may have had: 0 gives the direct
            part, None everything.
        colour : bool    Whether X and Z are wanted too.
        witness : bool
            Whether a pilot from the lights tells what the sensors receive, so that the errors cover what it finds.

        Raises
        ------
        SceneError    A position or normal is not usable.
        Cancelled    After `cancel`.
        """
        with self._engine(transport) as compiled:
            from .transport.light_tracing.bent_lights import bent_lights
            from .transport.light_tracing.bright_spots import bright_spots
            from .transport.paths.illuminance import Receivers, compute

            start = time.perf_counter()
            receivers = Receivers.at_points(positions, normals, kind)
            heard = None
            seen = receivers.outlooks(compiled)
            with bent_lights(compiled) as notes, bright_spots(compiled, *seen):
                estimate = compute(
                    compiled,
                    receivers,
                    rule,
                    seed,
                    SENSOR_GROUPS,
                    progress,
                    self._cancelled,
                    reflections,
                    colour,
                )
                if witness and self._has_witness and len(estimate.mean):
                    from .transport.witness.sensors import hear_sensors

                    bright = estimate.channel(1) if colour else estimate
                    heard = hear_sensors(
                        compiled,
                        positions,
                        normals,
                        kind,
                        bright,
                        seed,
                        reflections,
                        self._cancelled,
                    )
                    estimate = estimate.widened(heard.floors)
            provenance = self._provenance(compiled, seed, estimate.samples, start, notes)
        mean, error, balance = estimate.mean, estimate.standard_error, None
        if heard is not None:
            provenance = provenance.with_words(heard.decision, heard.notes)
            balance = heard.balance
        if colour:
            return Measurement(mean[:, 1], error[:, 1], provenance, mean, error, balance)
        return Measurement(mean, error, provenance, balance=balance)

    def measure_sensors(
        self,
        key: str,
        rule: StopRule,
        seed: int = 0,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
    ) -> Measurement:
        """Illuminance at the sensors of one of the scene's sets, by its id. [lx]"""
        sensors = self.scene.sensors.get(key)
        if sensors is None:
            raise SceneError(f"the scene holds no sensors with the id {key}")
        return self.measure(
            sensors.positions,
            sensors.normals,
            rule,
            seed,
            transport,
            progress,
            kind=sensors.kind,
        )

    def probe(
        self,
        surface: Surface,
        angles=None,
        samples: int = 1 << 16,
        seed: int = 0,
        transport: str = "auto",
        wavelength: float = 555.0,
    ) -> SurfaceProbe:
        """Reflectance and transmittance of a surface by itself, whatever the scene holds.

        Parameters
        ----------
        surface : Surface    Without pictures.
        angles : (n,) array or None
            Between the normal and the direction that light comes from; above 90 it comes from behind, which for a solid
            body is inside. None: even light from the front hemisphere, one value. [deg]
        samples : int    Per angle, at least.
        transport : str    ``auto`` and ``spectral``: at the wavelength; ``mono``: for equal-energy white.
        wavelength : float    [nm]

        Raises
        ------
        SceneError    The surface or a number is not usable.
        Cancelled    After `cancel`.
        """
        from .transport import backend, requirements

        requirements.check_transport(transport)
        check_item(surface)
        if angles is not None:
            angles = np.atleast_1d(np.asarray(angles, dtype=np.float64))
        with self._alone():
            backend.start(transport != "mono")
            from .transport import probe

            probe.check(surface, angles, samples, wavelength)
            # No pause in between: it would bring the scene's own variant back.
            r, t = probe.measure(
                surface, angles, samples, seed, wavelength, cancelled=lambda: self._cancel
            )
        return SurfaceProbe(angles, r.mean, t.mean, r.standard_error, t.standard_error)

    def explain(self, transport: str = "auto") -> Explanation:
        """Say how the scene would be computed, and what that costs in exactness.

        Raises
        ------
        SceneError    Something in the scene makes no sense.
        """
        with self._engine(transport) as compiled:
            from .transport.light_tracing.light_paths import LightTracer

            tracer = LightTracer(compiled)
            tracer.close()
            limits = {
                key: tracer.rays.limit_of(source) for key, source in compiled.sources().items()
            }
            return Explanation(
                tuple(compiled.requirements.reasons),
                tracer.reason,
                tuple(compiled.notes),
                explain_rays(self.scene, limits),
            )

    def bake_objects(
        self,
        order: BakeOrder,
        progress: Callable[[Progress], None] | None = None,
        options=None,
    ) -> BakeResult:
        """Unwrap objects, compute their lux maps and write the files.

        Parameters
        ----------
        order : BakeOrder
        progress : callable or None    Gets a `Progress`, with the history of the error once there is one.
        options : transport.lux_job.Options or None    For measuring how the parts of the method tell; None: the order's.

        Raises
        ------
        SceneError    None of the objects can be baked, or the order makes no sense.
        Cancelled    After `cancel`; the order's checkpoint stays.
        """
        self._cancel = False
        from .baking.run import Bake, Host

        if not self._has_witness:
            order = replace(order, witness=False)
        host = Host(
            self.scene,
            self._engine,
            self._compile_aside,
            self._cancelled,
            self._provenance,
            lambda: self._stop,
        )
        try:
            return Bake(host, order, progress, options).run()
        finally:
            self._stop = False

    # ---- live view ----

    def watch(self, camera: Camera, settings: LiveSettings, display: Display) -> None:
        """Begin or change the live view; `refine` then works on it."""
        check_item(camera)
        if display.mode is DisplayMode.FALSE_ILLUMINANCE:
            settings = replace(settings, illuminance=True)
        old = self._view
        self._view = _View(camera, settings, display)
        if old is not None and old.settings == settings and _is_same_view(old.camera, camera):
            self._view = replace(old, camera=camera, display=display, is_shown=False)

    def unwatch(self) -> None:
        """End the live view."""
        self._view = None

    @property
    def has_view_work(self) -> bool:
        """Whether `refine` would do anything. A session whose own long job runs does not look up from it."""
        view = self._view
        if view is None or self._is_busy:
            return False
        if view.revision != self.revision or view.work is None:
            return True
        return not (view.work.is_complete and view.is_shown)

    def refine(self) -> Frame | None:
        """Do one short slice of work on the live view.

        Returns
        -------
        Frame or None    A better image if it is time for one.

        Raises
        ------
        LumenrayError    The scene cannot be shown; it is tried again after the next change.
        """
        if not self.has_view_work:
            return None
        view = self._view
        with self._engine(view.settings.transport, is_live=True) as compiled:
            from .analysis.display import show
            from .transport.paths.live_view import LiveView

            start = time.perf_counter()
            is_new = view.revision != self.revision or view.work is None
            if is_new:
                view.revision, view.work, view.is_shown = self.revision, None, False
                view.work = LiveView(compiled, view.camera, view.settings)
            is_pass_done = not view.work.is_complete and view.work.refine()
            now = time.perf_counter()
            if is_new:
                self.commit = replace(self.commit, first_sample_seconds=now - start)
            waits = max(FRAME_INTERVAL, view.frame_seconds / FRAME_SHARE)
            is_final = view.work.is_complete
            is_due = now - view.shown_at > waits and (is_pass_done or view.work.factor == 1)
            if not (is_new or is_final or is_due or not view.is_shown):
                return None
            image = view.work.image()
            frame = Frame(
                **show(image, view.display.mode.value, view.display),
                revision=view.revision,
                samples=view.work.samples,
                relative_error=view.work.error,
                is_final=is_final,
                commit=self.commit,
            )
            view.is_shown, view.shown_at = True, time.perf_counter()
            view.frame_seconds = view.shown_at - now
        return frame

    # ---- private ----

    @contextmanager
    def _engine(self, transport: str, is_live: bool = False):
        """Give the compiled scene, alone with the process's Mitsuba."""
        with self._alone(is_live):
            compiled = self._prepare(transport, is_live)
            if not is_live:
                compiled.settle()
            yield compiled

    @contextmanager
    def _alone(self, is_live: bool = False):
        """Keep others from the process's Mitsuba, and from the garbage, for a job."""
        with _ONE_AT_A_TIME, _garbage_left_alone():
            self._cancel = False
            self._is_busy = not is_live
            try:
                yield
            finally:
                self._is_busy = False

    def _cancelled(self) -> bool:
        self._pause()
        return self._cancel

    def _pause(self) -> None:
        """Let others work for a moment, and come back to our own variant."""
        gc.collect(1)
        if self._interrupt is None:
            return
        self._interrupt()
        if self._variant:
            from .transport import backend

            backend.start("spectral" in self._variant)

    def _prepare(self, transport: str, is_live: bool):
        """Bring the Mitsuba objects up to date with the scene."""
        from .transport import backend

        self.scene.check()
        needs = self._needs(transport)
        if is_live and transport == "auto" and "spectral" in self._variant and self._compiled:
            # A live scene stays spectral, so that no change of colour costs a new start.
            needs = replace(needs, spectral=True)
        variant = backend.start(needs.spectral)
        from .transport.compiled.compile import CompiledScene, Outgrown

        start = time.perf_counter()
        compiled, self._compiled = self._compiled, None
        named, count = list(self._pending), len(self._pending)
        action = ""
        if compiled is not None and self._variant == variant:
            try:
                if named:
                    action = compiled.commit(self.scene, named, needs).text()
                compiled.requirements = needs
            except Outgrown:
                compiled = None
        else:
            compiled = None
        self._variant = variant
        if compiled is None:
            compiled = CompiledScene(self.scene, needs)
            count = len(self.scene.meshes) + len(self.scene.lights) + len(self.scene.materials)
            action = "everything built"
        if action:
            self.commit = Commit(count, action, time.perf_counter() - start)
        self._pending.clear()
        self._compiled = compiled
        return compiled

    def _compile_aside(self, scene: Scene, like):
        """Compile another scene for the variant of a compiled one."""
        from .transport.compiled.compile import CompiledScene

        scene.check()
        return CompiledScene(scene, like.requirements)

    def _needs(self, transport: str):
        """Decide how the scene has to be computed; kept until it changes."""
        from .transport import requirements

        key = (self.revision, transport)
        if self._requirements is None or self._requirements[0] != key:
            self._requirements = (key, requirements.analyse(self.scene, transport))
        return self._requirements[1]

    def _provenance(
        self, compiled, seed: int, samples: int, start: float, notes: tuple[str, ...] = ()
    ) -> Provenance:
        return Provenance(
            engine_version=VERSION,
            variant=self._variant,
            scene_hash=self.scene.hash(),
            seed=seed,
            samples=samples,
            seconds=time.perf_counter() - start,
            decisions=compiled.requirements.reasons,
            notes=(*compiled.notes, *notes),
        )


def _is_same_view(a: Camera, b: Camera) -> bool:
    return all(
        np.array_equal(getattr(a, entry.name), getattr(b, entry.name)) for entry in fields(Camera)
    )
