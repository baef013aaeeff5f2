"""The door to a cluster, used like `engine.session.Session`: workers compute the chunks of jobs, which are merged here.

What a job gives follows from its chunks alone, so it has the same bits for the same chunks: those of a number of samples, or
of an error, are the same however many workers there are and whatever becomes of them; those of a time are as many as were
done in it, and the result says how many samples that makes.
"""

import itertools
import secrets
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..accuracy.stopping import Clock, Progress, StopRule, excess_of
from ..analysis.explanation import Explanation
from ..baking.lumel_sheet import LumelSheet
from ..baking.order import BakeOrder, BakeResult
from ..daylight.coefficients import DaylightCoefficients, DaylightOrder
from ..errors import Cancelled, SceneError
from ..measurements import Measurement
from ..requirements.decision import Asked
from ..scene.camera import Camera
from ..scene.scene import Scene, SceneDelta
from ..scene.sensor import SensorKind
from ..session import EXACT, Session
from ..views import Picture, ViewSettings
from .chunks import Chunk, Grain, cut
from .crew import Crew
from .dispatch import Dispatcher, Job
from .lux_sum import LuxSum
from .merging import CoefficientSum, MeasurementSum, PictureSum
from .parcels import pack

LEAST_PATHS, MOST_PATHS = 1 << 21, 1 << 26
"""Paths of the first and of the longest chunks, of all values together: some seconds, and a minute."""

BELIEVED = 1 << 14
"""Samples of a sensor from which errors of single sensors are believed, as on one machine."""

MOST_DELTAS = 64
"""Changes of the scene that are kept to bring workers up to date; others get it anew."""

SENSOR_STEP, SKY_STEP, PIXEL_STEP = 16, 10, 2
"""Independent groups in a chunk, which have as many samples each."""

FEWEST_OF_SENSOR, FEWEST_OF_SKY, FEWEST_OF_PIXEL = 1024, 2560, 32
"""Samples of a value in a chunk at least: fewer do not tell their own error well, or take less time than finding cells."""

LUX_GRAIN = Grain(64, 1024)
"""Of lux maps: from a number of samples of a lumel on for which a pilot pays, to one of some minutes of large scenes."""

MOST_OF_VALUE = 1 << 22
"""Samples of a value in a chunk at most."""


class ClusterSession:
    """Keeps a scene and has workers answer questions about it, on the calling thread.

    Parameters
    ----------
    crew : Crew
    name : str    Unlike those of all other sessions of the crew's workers; empty: drawn.
    interrupt : callable or None    Called while workers are waited for, as of `engine.session.Session`.
    """

    def __init__(self, crew: Crew, name: str = "", interrupt: Callable[[], None] | None = None):
        self.scene = Scene()
        self.revision = 0
        self._name = name or secrets.token_hex(8)
        self._crew, self._dispatcher = crew, Dispatcher(crew)
        self._interrupt = interrupt
        self._deltas: dict[int, SceneDelta] = {}
        self._parcels: dict[int | None, bytes] = {}
        self._jobs = itertools.count()
        self._cancel = self._stop = False
        # What makes pages of lux maps, while it does.
        self._own: Session | None = None

    def apply(self, delta: SceneDelta) -> None:
        """Change the scene; workers learn of it when the next answer is asked for.

        Raises
        ------
        SceneError    The delta does not fit the scene, which stays as it was.
        """
        self.scene.apply(delta)
        self._deltas[self.revision] = delta
        self.revision += 1
        self._deltas.pop(self.revision - MOST_DELTAS - 1, None)
        self._parcels.clear()

    def cancel(self) -> None:
        """Ask the running job to end; it raises `Cancelled`."""
        self._cancel = True
        if self._own is not None:
            self._own.cancel()

    def stop(self) -> None:
        """Ask the running job to end with the chunks that it has, as soon as there is one."""
        self._stop = True

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
        """Illuminance at points, as `Session.measure`, computed as exactly as that does what is asked without an error.

        Raises
        ------
        SceneError, Cancelled    As of `Session.measure`.
        EngineFault, EngineLost    As of `Dispatcher.run`.
        """
        places = tuple(
            np.asarray(each, dtype=np.float64).reshape(-1, 3) for each in (positions, normals)
        )
        options = {"transport": transport, "kind": kind, "reflections": reflections}
        how = {"colour": colour, "method": method, "witness": False, "spectrum": spectrum}
        job, sums = _Following(rule, "illuminance", progress), MeasurementSum()
        grain = grain_of(len(places[0]), FEWEST_OF_SENSOR, SENSOR_STEP)

        def ask(chunk: Chunk) -> tuple[tuple, dict]:
            return (*places, StopRule(samples=chunk.samples)), {"seed": chunk.seed} | options | how

        for made in self._chunks("measure", ask, cut(rule, seed, grain), job):
            sums.add(made)
            found, asked = sums.estimate(), sums.rule_for_samples(rule)
            excess = excess_of(asked, found) if sums.samples >= BELIEVED else None
            if job.is_done(sums.samples, found.relative_error(), excess, asked):
                break
        whole = self._marked(sums.merged(seed, job.clock.seconds))
        if not witness:
            return whole
        return self._whole("confirm", (*places, whole), {"seed": seed} | options, job)

    def measure_sensors(
        self,
        key: str,
        rule: StopRule,
        seed: int = 0,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
        method: str = "auto",
    ) -> Measurement:
        """Illuminance at the sensors of one of the scene's sets, by its id; else as of `measure`. [lx]"""
        sensors = self.scene.sensors.get(key)
        if sensors is None:
            raise SceneError(f"the scene holds no sensors with the id {key}")
        places = sensors.positions, sensors.normals
        kind = sensors.kind
        return self.measure(*places, rule, seed, transport, progress, kind=kind, method=method)

    def render(
        self, camera: Camera, settings: ViewSettings, progress: Callable | None = None
    ) -> Picture:
        """Render a view, as `Session.render`; its pixels do not share light, and errors as of `measure`."""
        rule = settings.rule
        job, sums = _Following(rule, "picture", progress), PictureSum()
        grain = grain_of(camera.width * camera.height, FEWEST_OF_PIXEL, PIXEL_STEP)

        def ask(chunk: Chunk) -> tuple[tuple, dict]:
            own = StopRule(samples=chunk.samples)
            return (camera, replace(shared, rule=own, seed=chunk.seed)), {}

        shared = replace(settings, spectral_file=None, shares=False)
        for made in self._chunks("render", ask, cut(rule, settings.seed, grain), job):
            sums.add(made)
            job.preview = sums.tristimulus
            if job.is_done(sums.samples, sums.scatter(), None, sums.rule_for_samples(rule)):
                break
        picture = self._marked(sums.merged(settings.seed, job.clock.seconds))
        if settings.spectral_file and picture.bands is not None:
            self.write_spectral(settings.spectral_file, picture)
        return picture

    def find_daylight(
        self,
        positions,
        normals,
        order: DaylightOrder,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
    ) -> DaylightCoefficients:
        """What points have of sky and sun, as `Session.find_daylight`; errors as of `measure`."""
        places = tuple(
            np.asarray(each, dtype=np.float64).reshape(-1, 3) for each in (positions, normals)
        )
        job, sums = _Following(order.rule, "daylight", progress), CoefficientSum()
        grain = grain_of(len(places[0]), FEWEST_OF_SKY, SKY_STEP)

        def ask(chunk: Chunk) -> tuple[tuple, dict]:
            own = replace(order, rule=StopRule(samples=chunk.samples), seed=chunk.seed)
            return (*places, own), {"transport": transport}

        for made in self._chunks("find_daylight", ask, cut(order.rule, order.seed, grain), job):
            sums.add(made)
            if job.is_done(sums.samples, sums.error()):
                break
        return self._marked(sums.merged(order.seed, job.clock.seconds))

    def bake_objects(
        self,
        order: BakeOrder,
        progress: Callable[[Progress], None] | None = None,
    ) -> BakeResult:
        """Lux maps of objects, as `Session.bake_objects`; this machine makes pages of the passes, and hears the witness.

        Raises
        ------
        SceneError    As there, and where the order's checkpoint is there: what goes on has to do so where it began.
        Cancelled    After `cancel`; nothing is kept.
        """
        if order.checkpoint is not None and Path(order.checkpoint).exists():
            raise SceneError(
                f"{order.checkpoint}: a bake that was interrupted goes on without a cluster only; leave out the cluster, "
                "or begin anew"
            )
        rule, sums = order.rule, LuxSum()
        # A rule may name an error in lux, of which this clock knows nothing.
        job = _Following(
            replace(rule, absolute=None) if _has_more(rule) else _NEVER, "lux maps", progress
        )

        def ask(chunk: Chunk) -> tuple[tuple, dict]:
            own = StopRule(samples=chunk.samples)
            part = replace(shared, rule=own, pass_seed=chunk.seed)
            return (part,), {}

        shared = replace(order, folder=None, checkpoint=None, conversion=())
        for made in self._chunks("sum_lux", ask, cut(rule, order.seed, LUX_GRAIN), job):
            sums.add(made)
            relative, whole = sums.errors()
            is_close = rule.absolute is not None and whole <= rule.absolute
            if job.is_done(sums.samples, relative) or is_close:
                break
        states = sums.finished(rule, job.clock.seconds)
        self._own = Session(interrupt=self._interrupt)
        self._own.apply(self.scene.snapshot())
        try:
            return self._own.bake_objects(replace(order, checkpoint=None), progress, states=states)
        finally:
            self._own = None

    def find_lumels(
        self,
        order: BakeOrder,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
    ) -> LumelSheet:
        """Places of lumels of objects, as `Session.find_lumels`, by one worker."""
        job = _Following(StopRule(samples=1), "lumels", progress)
        return self._whole("find_lumels", (order,), {"transport": transport}, job)

    def explain(
        self,
        transport: str = "auto",
        asked: Asked = EXACT,
        has_trial: bool = True,
        progress: Callable | None = None,
    ) -> Explanation:
        """How the scene would be computed, as `Session.explain`, by one worker."""
        options = {"transport": transport, "asked": asked, "has_trial": has_trial}
        job = _Following(StopRule(samples=1), "explanation", progress)
        return self._whole("explain", (), options, job)

    def write_spectral(self, path: str, picture: Picture, progress: Callable | None = None) -> None:
        """Write the bands of a picture here, as `Session.write_spectral`."""
        Session().write_spectral(path, picture)

    # ---- private ----

    def _chunks(self, method: str, ask, chunks: Iterator[Chunk], job: "_Following") -> Iterator:
        """What a method gives for each chunk, in their order, until the job is to end."""
        name = f"{self._name}-{next(self._jobs)}"
        self._cancel = self._stop = False

        def task_of(chunk: Chunk) -> dict:
            arguments, options = ask(chunk)
            return {
                "scene": self._name,
                "revision": self.revision,
                "job": name,
                "method": method,
                "arguments": arguments,
                "options": options,
            }

        running = self._dispatcher.run(Job(self._scene_of, self.revision, task_of), chunks)
        has_any = False
        try:
            for answer in running:
                if self._cancel:
                    raise Cancelled("cancelled")
                if answer is not None:
                    has_any = True
                    yield answer[1]
                job.tell(len(self._crew.workers()))
                if self._interrupt is not None:
                    self._interrupt()
                if has_any and (self._stop or job.is_out_of_time):
                    return
        finally:
            running.close()

    def _marked(self, made):
        """A result with a note where workers were unlike each other."""
        makes = sorted(self._dispatcher.makes)
        if len(makes) < 2:
            return made
        note = (
            f"workers are unlike ({'; '.join(makes)}): the same chunks by others give the same within rounding, but not the "
            "same bits"
        )
        return replace(made, provenance=made.provenance.with_words("", (note,)))

    def _whole(self, method: str, arguments: tuple, options: dict, job: "_Following"):
        """What a method gives that is not cut."""
        only = iter([Chunk(0, 0, 0)])
        (made,) = self._chunks(method, lambda _: (arguments, options), only, job)
        return made

    def _scene_of(self, known: int | None) -> bytes:
        """Parcel that brings a worker's scene up to date, as of `Job`."""
        if known == self.revision:
            return b""
        if known is not None and known not in self._deltas:
            known = None
        if known not in self._parcels:
            deltas = (self.scene.snapshot(),)
            if known is not None:
                deltas = tuple(self._deltas[k] for k in range(known, self.revision))
            news = {"name": self._name, "base": known, "revision": self.revision, "deltas": deltas}
            self._parcels[known] = pack(news)
        return self._parcels[known]


class _Following:
    """Follows a job against its rule and tells of it."""

    def __init__(self, rule: StopRule, stage: str, progress: Callable | None):
        self.rule, self.progress, self.preview = rule, progress, None
        self.stage, self.clock = stage, Clock(rule, stage)
        # As it was when the last chunk came.
        self._state = self.clock.progress(0, float("inf"))

    @property
    def is_out_of_time(self) -> bool:
        """Whether the rule's time is over."""
        return self.rule.seconds is not None and self.clock.seconds >= self.rule.seconds

    def is_done(
        self,
        samples: int,
        error: float,
        excess: float | None = None,
        rule: StopRule | None = None,
    ) -> bool:
        """Take note of a chunk, as of `Clock.is_done`. ``rule``: what is asked of samples by now; None: all that is."""
        self.clock.rule = rule or self.rule
        is_done = self.clock.is_done(samples, error, excess)
        self._state = self.clock.progress(samples, error)
        return is_done

    def tell(self, workers: int) -> None:
        """Tell how far it is."""
        if self.progress is None:
            return
        who = f"{workers} workers" if workers != 1 else "1 worker"
        known, seconds = self._state, self.clock.seconds
        left, done = known.seconds_left, known.done
        if left is not None:
            left = max(left - (seconds - known.seconds), 0.0)
            done = seconds / max(seconds + left, 1e-9)
        state = replace(
            known, seconds=seconds, seconds_left=left, done=done, stage=f"{self.stage}, {who}"
        )
        if self.stage == "picture":
            self.progress(state, self.preview)
        else:
            self.progress(state)


_NEVER = StopRule(samples=MOST_OF_VALUE)
"""Ends nothing that something else does not end before."""


def _has_more(rule: StopRule) -> bool:
    """Whether a rule says more than an error in lux."""
    return any(each is not None for each in (rule.samples, rule.error, rule.seconds))


def grain_of(values: int, fewest: int, step: int) -> Grain:
    """How finely a job for so many values is cut; ``fewest``, ``step``: samples of a value, as of `Grain`."""

    def samples(paths: int, least: int) -> int:
        each = 1 << max((paths // max(values, 1)).bit_length() - 1, 0)
        return -(-min(max(each, least), MOST_OF_VALUE) // step) * step

    least = samples(LEAST_PATHS, fewest)
    return Grain(least, max(samples(MOST_PATHS, fewest), least), step)
