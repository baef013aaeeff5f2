"""The one door to the engine: a scene goes in as deltas, answers come out as plain data.

Only plain data (dataclasses, numpy arrays, strings) passes, so that the same interface can stand before a process of
its own.
"""

import gc
import json
import math
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, contextmanager
from dataclasses import replace

import numpy as np

from . import VERSION, llvm
from .accuracy.lost_samples import tell_lost
from .accuracy.stopping import Progress, StopRule
from .analysis.explanation import Explanation, explain_rays
from .baking.lumel_sheet import LumelSheet
from .baking.mixed_maps import MixedMap, mix_maps
from .baking.order import BakeOrder, BakeResult
from .cloth.surface import WovenSurface
from .daylight.coefficients import DaylightCoefficients, DaylightOrder
from .errors import Cancelled, SceneError
from .grouped_picture import Rendered, render_groups
from .ink.surface import PrintedSurface
from .light_mix import LightMix
from .live import WatchedView
from .measurements import Measurement, SensorSpectra, SurfaceProbe
from .paint.surface import PaintedSurface
from .requirements.decision import Asked, boxes_of, places_of
from .requirements.plan import Plan, changed_keys, make_plan
from .scene.camera import Camera
from .scene.checks import check_item
from .scene.light import UniformWorld
from .scene.light_groups import WORLD, share_out
from .scene.material import Surface
from .scene.provenance import Provenance
from .scene.scene import Scene, SceneDelta
from .scene.sensor import SensorColour, SensorKind
from .scene.spectrum import Illuminant
from .views import Commit, Display, DisplayMode, Frame, LiveSettings, Picture, ViewSettings

_ONE_AT_A_TIME = threading.RLock()
"""Mitsuba's variant belongs to the process, so jobs of several threads wait for each other."""


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


EXACT = Asked()
"""What a job asks that says nothing: only what changes nothing is simplified."""

EVEN_SKY = UniformWorld(1.0, Illuminant("D65"))
"""World by which daylight is found: of its spectrum is the light of all skies and of the sun."""


class Session:
    """Keeps a scene and answers questions about it, in this process and on the calling thread.

    Parameters
    ----------
    interrupt : callable or None
        Called between the launches of long jobs; it may use other sessions.
    witness : bool
        Whether bakes and measurements that ask for a second witness get it; not where only their own samples matter.
    keeps_cells : bool
        Whether pictures share cells; not where a picture must not depend on those that were made before it.
    """

    def __init__(
        self,
        interrupt: Callable[[], None] | None = None,
        witness: bool = True,
        keeps_cells: bool = True,
    ):
        self.scene = Scene()
        self._has_witness = witness
        self._keeps_cells = keeps_cells
        self.revision = 0
        self.commit = Commit()
        self._interrupt = interrupt
        self._compiled = None
        self._variant = ""
        self._planned: tuple | None = None
        # What stands for items of the scene in the compiled one.
        self._simplified: dict[str, object] = {}
        self._pending: dict[str, None] = {}
        self._view: WatchedView | None = None
        # Cells of the compiled scene for pictures and views, see `transport.pictures.kept_cells`.
        self._kept = None
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
        asked = Asked(settings.rule.relative_goal, places=places_of(camera))
        with self._engine(settings.transport, asked) as compiled:
            start = time.perf_counter()
            self._kept.begin()
            spent = compiled.requirements.spent
            settings = replace(settings, rule=settings.rule.beside(spent))
            shares = share_out(self.scene, settings.groups) if settings.groups else []
            if shares:
                from .transport.paths.catchers import layout_of

                layout = layout_of(compiled, settings.bands)

                def render(own, follow):
                    return self._render(compiled, camera, own, follow, layout is not None)

                made = render_groups(compiled, shares, camera, settings, render, progress, layout)
            else:
                made = self._render(compiled, camera, settings, progress)
            notes = (*made.notes, *tell_lost(made.lost))
            provenance = self._provenance(
                compiled, settings.seed, made.samples, start, notes, made.decisions
            )
            finished = Picture(**made.fields, provenance=provenance).widened(spent)
            if settings.spectral_file and finished.bands is not None:
                from .formats.exr import write_spectral

                write_spectral(settings.spectral_file, finished)
        return finished

    def write_spectral(self, path: str, picture: Picture, progress: Callable | None = None) -> None:
        """Write the bands of a picture as a spectral OpenEXR; ``progress`` is told of nothing.

        Raises
        ------
        FileFormatError    The file cannot be written.
        """
        from .formats.exr import write_spectral

        write_spectral(path, picture)

    def mix_maps(
        self, folder: str, levels: LightMix, target: str, progress: Callable | None = None
    ) -> tuple[MixedMap, ...]:
        """Add up the lux maps of a bake's light groups, see `baking.mixed_maps`; ``progress`` is told of nothing.

        Raises
        ------
        LumenrayError    As of `mixed_maps.mix_maps`.
        """
        return tuple(mix_maps(folder, levels, target)[0])

    def compute_paint(
        self, description: str, progress: Callable[[Progress], None] | None = None
    ) -> PaintedSurface:
        """Compute what a paint scatters; it has nothing to do with the scene.

        Parameters
        ----------
        description : str    JSON text of its composition.

        Raises
        ------
        FileFormatError    The description breaks its schema or names what there is not.
        SceneError    The paint cannot be solved.
        Cancelled    After `cancel`.
        """
        # Scenes without paints never ask for it.
        from .paint.painted import paint_surface

        self._cancel = False
        return paint_surface(json.loads(description), self._reporter("paint", progress))

    def compute_cloth(
        self,
        description: str,
        draft: bool = False,
        progress: Callable[[Progress], None] | None = None,
    ) -> WovenSurface:
        """Compute what a cloth scatters; it has nothing to do with the scene, and others work meanwhile.

        What was computed is kept for this user, and found again by what is asked.

        Parameters
        ----------
        description : str    JSON text of its composition.
        draft : bool    As of `cloth.plan.rays_of`.

        Raises
        ------
        FileFormatError    The description breaks its schema or names what there is not.
        SceneError    The cloth cannot be computed.
        Cancelled    After `cancel`.
        """
        from .transport import backend

        with self._alone():
            before = self._variant
            # Pauses bring it back, whatever others need.
            self._variant = backend.start(spectral=False)
            # Its arrays are of the variant that has been started.
            from .cloth.weaving import weave_surface

            report = self._reporter("cloth", progress)
            try:
                return weave_surface(json.loads(description), draft=draft, report=report)
            finally:
                # What is compiled of the scene is of that.
                self._variant = before

    def _reporter(self, noun: str, progress: Callable[[Progress], None] | None):
        """What a job without a scene tells the share that is done: it pauses, ends the job after `cancel`, and forecasts."""
        start = time.perf_counter()

        def report(share: float) -> None:
            if self._cancelled():
                raise Cancelled(f"the {noun} was not computed: cancelled")
            if progress is not None:
                seconds = time.perf_counter() - start
                left = seconds * (1.0 - share) / share if share > 0.0 else None
                progress(Progress(share, 0, math.inf, seconds, left, noun))

        return report

    def compute_ink(
        self,
        description: str,
        draft: bool = False,
        processes: int = 1,
        progress: Callable[[Progress], None] | None = None,
    ) -> PrintedSurface:
        """Compute what a dense pigment layer scatters; it has nothing to do with the scene, and others work meanwhile.

        What is solved is kept where the commands keep it, so a job that was ended goes on.

        Parameters
        ----------
        description : str    JSON text of its composition.
        draft : bool    As of `ink.plan.make_plan`.
        processes : int    That solve side by side.

        Raises
        ------
        FileFormatError    The description breaks its schema or names what there is not.
        SceneError    The layer cannot be solved.
        EngineLost    A process that solves ended by itself.
        Cancelled    After `cancel`.
        """
        # Scenes without prints never ask for it.
        from .ink.prints import print_surface

        self._cancel = False

        def report(state) -> None:
            if self._cancelled():
                raise Cancelled(
                    "the pigment layer was not computed: cancelled; what was solved is kept"
                )
            if progress is not None:
                left = state.left if math.isfinite(state.left) else None
                share = state.done / state.total
                progress(Progress(share, 0, math.inf, state.seconds, left, "pigment layer"))

        content = json.loads(description)
        return print_surface(content, draft=draft, processes=processes, report=report)

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
        method: str = "auto",
        witness: bool = True,
        spectrum: bool = False,
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
        method : str
            ``cells`` reads the light of matt surfaces from cells, ``paths`` follows it to its end, ``auto`` decides by what
            is needed and says why.
        witness : bool
            Whether a pilot from the lights tells what the sensors receive, so that the errors cover what it finds.
        spectrum : bool    Whether spectra and alpha-opic quantities are wanted too, and X and Z with them.

        Raises
        ------
        SceneError    A position, a normal or the method is not usable.
        Cancelled    After `cancel`.
        """
        wanted = SensorColour.SPECTRUM if spectrum else SensorColour(int(colour))
        asked = Asked(rule.relative_goal, has_colour=bool(wanted), places=boxes_of(positions))
        with self._engine(transport, asked) as compiled:
            from .transport.sensors.measuring import measure, spectral_fields

            start = time.perf_counter()
            made = measure(
                compiled,
                positions,
                normals,
                rule,
                seed,
                kind,
                reflections,
                wanted,
                method,
                witness and self._has_witness,
                progress,
                self._cancelled,
            )
            estimate = made.estimate
            provenance = self._provenance(
                compiled, seed, estimate.samples, start, made.notes, made.decisions
            )
        mean, error, more = (
            estimate.mean,
            estimate.standard_error,
            (made.balance, made.decisions[0]),
        )
        if wanted:
            light = mean[:, 1], error[:, 1], provenance, mean[:, :3], error[:, :3], *more
            spectra = SensorSpectra(**spectral_fields(estimate)) if spectrum else None
            return Measurement(*light, spectra, made.has_common_errors, estimate.floors)
        return Measurement(
            mean,
            error,
            provenance,
            None,
            None,
            *more,
            has_common_errors=made.has_common_errors,
            floors=estimate.floors,
        )

    def confirm(
        self,
        positions,
        normals,
        made: Measurement,
        seed: int = 0,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
        *,
        kind: SensorKind = SensorKind.PLANAR,
        reflections: int | None = None,
    ) -> Measurement:
        """Have the second witness look at a measurement that was made of parts, which had none; else as of `measure`.

        ``progress`` is told of nothing.

        Returns
        -------
        Measurement    With errors that cover what it finds, its decision and its notes.
        """
        with self._engine(transport) as compiled:
            from .accuracy.estimate import Estimate
            from .transport.sensors.measuring import confirm

            found = Estimate(made.illuminance, made.standard_error, made.provenance.samples)
            asked = positions, normals, kind, found, seed, reflections, self._cancelled
            heard = confirm(compiled, *asked)
        if heard is None:
            return made
        provenance = made.provenance.with_words(heard.decision, heard.notes)
        return replace(made.widened(heard.floors), provenance=provenance, balance=heard.balance)

    def measure_sensors(
        self,
        key: str,
        rule: StopRule,
        seed: int = 0,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
        method: str = "auto",
    ) -> Measurement:
        """Illuminance at the sensors of one of the scene's sets, by its id; ``method`` as of `measure`. [lx]"""
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
            method=method,
        )

    def find_daylight(
        self,
        positions,
        normals,
        order: DaylightOrder,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
    ) -> DaylightCoefficients:
        """Find what points have of every part of the sky and of the sun at every place, lamps and world left out.

        Parameters
        ----------
        positions, normals : (n, 3) array    World space. [m]
        order : DaylightOrder
        progress : callable or None    Gets a `Progress`.

        Raises
        ------
        SceneError    A position or normal is not usable.
        Cancelled    After `cancel`.
        """
        own = self.scene.world
        self.apply(SceneDelta(changed=(EVEN_SKY,)))
        try:
            with self._engine(transport) as compiled:
                from .transport.sensors.sky_job import find_coefficients

                start = time.perf_counter()
                compiled.shine(frozenset({WORLD}))
                try:
                    made = find_coefficients(
                        compiled, positions, normals, order, progress, self._cancelled
                    )
                finally:
                    compiled.shine()
                paths = made.fields["samples"] * max(len(positions), 1)
                notes = (*made.notes, *tell_lost({"samples": (made.fields["lost"], paths)}))
                provenance = self._provenance(
                    compiled, order.seed, made.fields["samples"], start, notes
                )
        finally:
            back = {"changed": (own,)} if own is not None else {"removed": (EVEN_SKY.id,)}
            self.apply(SceneDelta(**back))
        return DaylightCoefficients(**made.fields, provenance=provenance)

    def find_lumels(
        self,
        order: BakeOrder,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
    ) -> LumelSheet:
        """Unwrap objects and find the places of their lumels, without any light.

        Parameters
        ----------
        order : BakeOrder    Of which objects, densities, pages and charts count.
        progress : callable or None    Gets a `Progress`.

        Raises
        ------
        SceneError    None of the objects has a surface, or there are too many lumels.
        Cancelled    After `cancel`.
        """
        llvm.settle()
        from .baking.lumel_sensors import find_lumel_sensors

        return find_lumel_sensors(self._host(), replace(order, transport=transport), progress)

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
        from .requirements.plan import check_transport
        from .transport import backend

        check_transport(transport)
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

    def explain(
        self,
        transport: str = "auto",
        asked: Asked = EXACT,
        has_trial: bool = True,
        progress: Callable | None = None,
    ) -> Explanation:
        """Say how the scene would be computed, and what that costs in exactness.

        Parameters
        ----------
        transport : str    As in `measure`.
        asked : Asked    What is wanted of the scene.
        has_trial : bool    Whether the scene is compiled and a little light sent, which tells what is traced from the lights
            and what is approximated.
        progress : callable or None    Is told of nothing.

        Raises
        ------
        SceneError    Something in the scene makes no sense.
        """
        if not has_trial:
            self.scene.check()
            # What stands for items is not told, and may be large.
            plan = self._plan(transport, asked)
            choices = explain_rays(self._with_planned_lights(plan))
            return Explanation(replace(plan, changes={}), "", (), choices)
        with self._engine(transport, asked) as compiled:
            from .transport.light_tracing.light_paths import LightTracer

            tracer = LightTracer(compiled)
            tracer.close()
            limits = {
                key: tracer.rays.limit_of(source) for key, source in compiled.sources().items()
            }
            return Explanation(
                compiled.requirements,
                tracer.reason,
                tuple(compiled.notes),
                explain_rays(self._with_planned_lights(compiled.requirements), limits),
            )

    def bake_objects(
        self,
        order: BakeOrder,
        progress: Callable[[Progress], None] | None = None,
        options=None,
        states: tuple = (),
    ) -> BakeResult:
        """Unwrap objects, compute their lux maps and write the files.

        Parameters
        ----------
        order : BakeOrder
        progress : callable or None    Gets a `Progress`, with the history of the error once there is one.
        options : transport.lux_maps.job.Options or None    For measuring what parts of the method tell; None: the order's.
        states : tuple of baking.layer_state.LayerState    As of `baking.run.bake`.

        Raises
        ------
        SceneError    None of the objects can be baked, or the order makes no sense.
        Cancelled    After `cancel`; the order's checkpoint stays.
        """
        self._cancel = False
        # What follows imports Dr.Jit, which looks for its library once.
        llvm.settle()
        from .baking.run import bake

        if not self._has_witness:
            order = replace(order, witness=False)
        try:
            return bake(self._host(), order, progress, options, states)
        finally:
            self._stop = False

    def sum_lux(
        self, order: BakeOrder, progress: Callable[[Progress], None] | None = None
    ) -> tuple[dict[str, np.ndarray], ...]:
        """Make a part of the passes of a bake, as `baking.run.sum_passes`. Raises as `bake_objects`."""
        self._cancel = False
        llvm.settle()
        from .baking.run import sum_passes

        return sum_passes(self._host(), order, progress)

    # ---- live view ----

    def watch(self, camera: Camera, settings: LiveSettings, display: Display) -> None:
        """Begin or change the live view; `refine` then works on it."""
        check_item(camera)
        if display.mode is DisplayMode.FALSE_ILLUMINANCE:
            settings = replace(settings, illuminance=True)
        if self._view is None:
            self._view = WatchedView(camera, settings, display)
        else:
            self._view = self._view.changed(camera, settings, display)

    def unwatch(self) -> None:
        """End the live view."""
        if self._view is not None:
            self._view.leave()
        self._view = None

    @property
    def has_view_work(self) -> bool:
        """Whether `refine` would do anything. A session whose own long job runs does not look up from it."""
        view = self._view
        if view is None or self._is_busy:
            return False
        if not view.has_begun(self.revision):
            return True
        return not view.is_done

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
            start = time.perf_counter()
            is_new = not view.has_begun(self.revision)
            if is_new:
                view.begin(compiled, self.scene, self.revision, self._kept)
            is_due = view.refine()
            if is_new:
                seconds = time.perf_counter() - start
                self.commit = replace(self.commit, first_sample_seconds=seconds)
            return view.frame(self.commit) if is_new or is_due else None

    # ---- private ----

    def _with_planned_lights(self, plan: Plan) -> Scene:
        """The scene with what stands for its lights, and nothing left out."""
        lights = {key: item for key, item in plan.changes.items() if key in self.scene.lights}
        return self.scene.with_items(
            {key: item for key, item in lights.items() if item is not None}
        )

    def _host(self):
        from .baking.host import Host

        return Host(
            self.scene,
            self._engine,
            self._compile_aside,
            self._cancelled,
            self._provenance,
            lambda: self._stop,
        )

    def _render(
        self, compiled, camera: Camera, settings: ViewSettings, progress, keeps_caught=False
    ) -> Rendered:
        """Render what shines of a compiled scene. ``keeps_caught``: as of `picture.render`."""
        from .transport.light_tracing.bent_lights import bent_lights
        from .transport.light_tracing.bright_spots import bright_spots
        from .transport.light_tracing.camera_light import CameraLight
        from .transport.light_tracing.near_rays import near_rays
        from .transport.paths.catchers import tell_catchers
        from .transport.paths.film import Film, look
        from .transport.pictures import picture

        uses_cells, reason = picture.choose_method(compiled, camera, settings)
        film = Film(camera, compiled.origin)
        seen = look(compiled, film)
        with ExitStack() as lights:
            kept = lights.enter_context(near_rays(compiled, seen[0]))
            notes = lights.enter_context(bent_lights(compiled))
            if not uses_cells:
                lights.enter_context(bright_spots(compiled, *seen))
            notes = (*notes, *tell_catchers(compiled))
            light = CameraLight(compiled, film, settings, self._cancelled)
            traced = light if light.is_needed else None
            made, samples, lost, more = picture.render(
                compiled,
                camera,
                settings,
                uses_cells,
                progress,
                self._cancelled,
                traced,
                self._kept,
                keeps_caught,
            )
        lost["paths of light"] = light.lost
        return Rendered(made, samples, lost, (*notes, *light.notes, *kept, *more), (reason,))

    @contextmanager
    def _engine(self, transport: str, asked: Asked = EXACT, is_live: bool = False):
        """Give the compiled scene for what is asked, alone with the process's Mitsuba."""
        with self._alone(is_live):
            compiled = self._prepare(transport, is_live, asked)
            if not is_live:
                compiled.shine()
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

    def _prepare(self, transport: str, is_live: bool, asked: Asked = EXACT):
        """Bring the Mitsuba objects up to date with the scene."""
        from .transport import backend

        self.scene.check()
        needs = self._plan(transport, asked)
        if is_live and transport == "auto" and "spectral" in self._variant and self._compiled:
            # A live scene stays spectral, so that no change of colour costs a new start.
            needs = replace(needs, spectral=True)
        variant = backend.start(needs.spectral)
        from .transport.compiled.changes import Outgrown
        from .transport.compiled.compile import CompiledScene
        from .transport.pictures.kept_cells import KeptCells

        start = time.perf_counter()
        compiled, self._compiled = self._compiled, None
        kept, self._kept = self._kept, None
        scene, pending = needs.simplify(self.scene), len(self._pending)
        # What is no longer simplified, or now is, or otherwise, has changed as well.
        named = list(self._pending | dict.fromkeys(changed_keys(self._simplified, needs.changes)))
        self._simplified = needs.changes
        count = pending
        action = ""
        if compiled is not None and self._variant == variant:
            try:
                if named:
                    action = compiled.commit(scene, named, needs).text()
                compiled.requirements = needs
            except Outgrown:
                compiled = None
        else:
            compiled = None
        self._variant = variant
        if compiled is None:
            # What is kept of the old one would keep it, and all its kernels, alive.
            kept = None
            compiled = CompiledScene(scene, needs)
            count = len(self.scene.meshes) + len(self.scene.lights) + len(self.scene.materials)
            action = "everything built"
        if action:
            self.commit = Commit(count, action, time.perf_counter() - start)
        self._pending.clear()
        if not self._keeps_cells:
            kept = None
        self._compiled, self._kept = compiled, kept or KeptCells()
        return compiled

    def _compile_aside(self, scene: Scene, like):
        """Compile another scene for the variant of a compiled one."""
        from .transport.compiled.compile import CompiledScene

        scene.check()
        # With simplifications of its own: those of the other one stand for that one's items.
        needs = like.requirements
        needs = replace(needs, changes=make_plan(scene, needs.asked).changes)
        return CompiledScene(needs.simplify(scene), needs)

    def _plan(self, transport: str, asked: Asked) -> Plan:
        """Decide how the scene has to be computed; kept until it or what is asked changes."""
        key = (self.revision, transport, asked)
        if self._planned is None or self._planned[0] != key:
            self._planned = (key, make_plan(self.scene, asked, transport))
        return self._planned[1]

    def _provenance(
        self,
        compiled,
        seed: int,
        samples: int,
        start: float,
        notes: tuple[str, ...] = (),
        decisions: tuple[str, ...] = (),
    ) -> Provenance:
        return Provenance(
            engine_version=VERSION,
            variant=self._variant,
            scene_hash=self.scene.hash(),
            seed=seed,
            samples=samples,
            seconds=time.perf_counter() - start,
            decisions=(*compiled.requirements.reasons, *decisions),
            notes=(*compiled.notes, *notes),
            simplified=compiled.requirements.spent,
        )
