"""Blender's side: a worker is the engine in a process of its own, and its sessions are used like those in this process.

Nothing that happens to the engine happens to Blender: a worker that crashed, hung or ran out of memory is told of in words
(`EngineLost`), and a new one takes its place.
"""

import sys
import threading
import weakref
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..accuracy.stopping import Progress, StopRule
from ..analysis.explanation import Explanation
from ..baking.mixed_maps import MixedMap
from ..cloth.surface import WovenSurface
from ..daylight.coefficients import DaylightCoefficients, DaylightOrder
from ..errors import EngineLost
from ..ink.surface import PrintedSurface
from ..light_mix import LightMix
from ..measurements import Measurement
from ..paint.surface import PaintedSurface
from ..requirements.decision import Asked
from ..scene.camera import Camera
from ..scene.scene import SceneDelta
from ..scene.sensor import SensorKind
from ..session import EXACT, BakeOrder, BakeResult, LumelSheet
from ..transport.backend import BackendStatus
from ..views import Display, Frame, LiveSettings, Picture, ViewSettings
from . import faults
from .link import CANCEL_PATIENCE, Link
from .process import Process
from .pulse import HUNG_AFTER

START_PATIENCE = 30.0
"""How long the process may take to say its first word. [s]"""

CLOSE_PATIENCE = 2.0
"""How long it may take to end by itself. [s]"""

PREVIEW_INTERVAL = 1.0
"""Shortest time between two pictures of a render under way; each copies the whole picture. [s]"""


class RemoteSession:
    """A session in a worker, used like `engine.session.Session` and from any thread.

    `apply` and `watch` do not wait. What is wrong with a delta is raised by the next call that does.
    """

    def __init__(self, worker: "Worker", link: Link, name: str):
        # A session keeps its worker alive.
        self._worker = worker
        self._link = link
        self._is_closed = False
        self.name = name

    @property
    def is_lost(self) -> bool:
        """Whether the session's worker is gone, and its scene with it."""
        return self._is_closed or self._link.lost is not None

    @property
    def revision(self) -> int:
        """Number of the scene's state: how many deltas were sent and not refused."""
        return self._link.view(self.name).applied

    @property
    def has_view_work(self) -> bool:
        """Whether better frames of the live view can be expected."""
        view = self._link.view(self.name)
        return not self.is_lost and view.is_watched and not view.is_final and view.error is None

    def apply(self, delta: SceneDelta) -> None:
        """Change the scene.

        Raises
        ------
        EngineLost    The worker is gone: start it again and send the whole scene.
        """
        self._check()
        self._link.apply(self.name, delta)

    def join(self, place: tuple[str, str, str, str] | None) -> None:
        """Have a cluster do what takes long from the next job on, None: this machine; by sessions that know how.

        ``place``: address, and the names of three files, as of `cluster.shared_session.ClusterPlace`.

        Raises
        ------
        EngineLost    The worker is gone: start it again and send the whole scene.
        """
        self._check()
        self._link.post("join", self.name, place)

    def list_workers(self) -> tuple[tuple[str, float], ...]:
        """Workers of the cluster that was joined, as of `cluster.shared_session.SharedSession`. Raises as `render`."""
        return self._wait("list_workers", (), {}, None, None)

    def cancel(self) -> None:
        """Ask the session's jobs to end; whoever waits for them gets `Cancelled`."""
        self._link.cancel_session(self.name)

    def stop(self) -> None:
        """Ask the session's bake to end with what it has; whoever waits for it gets that."""
        self._link.stop_session(self.name)

    def render(
        self,
        camera: Camera,
        settings: ViewSettings,
        progress: Callable | None = None,
        preview_interval: float | None = PREVIEW_INTERVAL,
        idle: Callable[[], None] | None = None,
        patience: float | None = None,
    ) -> Picture:
        """Render a view.

        Parameters
        ----------
        camera : Camera
        settings : ViewSettings
        progress : callable or None    ``progress(Progress, preview)`` on this thread, where ``preview`` is None or gives
            the picture so far as (h, w, 3) X, Y, Z. [cd/m2]
        preview_interval : float or None    Shortest time between two such pictures; None: none are made. [s]
        idle : callable or None    Called on this thread at least ten times a second.
        patience : float or None
            How long the engine may take to obey a cancel before it is ended; None: the worker's own. [s]

        Raises
        ------
        Cancelled    After `cancel`.
        EngineLost    The worker is gone: start it again and send the whole scene.
        LumenrayError    The scene or the machine does not allow it; the text says what to do.
        """
        interval = None if progress is None else preview_interval
        return self._wait(
            "render", (camera, settings), {}, progress, idle, interval, patience=patience
        )

    def write_spectral(self, path: str, picture: Picture) -> None:
        """Write the bands of a picture, as `Session.write_spectral`. Raises as `render`."""
        self._wait("write_spectral", (path, picture), {}, None, None)

    def mix_maps(self, folder: str, levels: LightMix, target: str) -> tuple[MixedMap, ...]:
        """Add up the lux maps of light groups, as `Session.mix_maps`. Raises as `render`."""
        return self._wait("mix_maps", (folder, levels, target), {}, None, None)

    def measure(
        self,
        positions,
        normals,
        rule: StopRule,
        seed: int = 0,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
        idle: Callable[[], None] | None = None,
        *,
        kind: SensorKind = SensorKind.PLANAR,
        reflections: int | None = None,
        colour: bool = False,
        method: str = "auto",
        witness: bool = True,
        spectrum: bool = False,
    ) -> Measurement:
        """Illuminance at points, as `Session.measure`. Raises as `render`. (n, 3), (n, 3) [m -> lx]"""
        points = [np.asarray(each, dtype=np.float64) for each in (positions, normals)]
        options = {
            "seed": seed,
            "transport": transport,
            "kind": kind,
            "reflections": reflections,
            "colour": colour,
            "method": method,
            "witness": witness,
            "spectrum": spectrum,
        }
        return self._wait("measure", (*points, rule), options, _states_only(progress), idle)

    def measure_sensors(
        self,
        key: str,
        rule: StopRule,
        seed: int = 0,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
        idle: Callable[[], None] | None = None,
        method: str = "auto",
    ) -> Measurement:
        """Illuminance at the sensors of a set of the scene, by its id. Raises as `render`. [lx]"""
        options = {"seed": seed, "transport": transport, "method": method}
        return self._wait("measure_sensors", (key, rule), options, _states_only(progress), idle)

    def find_daylight(
        self,
        positions,
        normals,
        order: DaylightOrder,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
        idle: Callable[[], None] | None = None,
    ) -> DaylightCoefficients:
        """What points have of sky and sun, as `Session.find_daylight`. Raises as `render`. (n, 3), (n, 3) [m]"""
        points = [np.asarray(each, dtype=np.float64) for each in (positions, normals)]
        options = {"transport": transport}
        return self._wait("find_daylight", (*points, order), options, _states_only(progress), idle)

    def find_lumels(
        self,
        order: BakeOrder,
        transport: str = "auto",
        progress: Callable[[Progress], None] | None = None,
        idle: Callable[[], None] | None = None,
    ) -> LumelSheet:
        """Places of lumels of objects, as `Session.find_lumels`. Raises as `render`."""
        options = {"transport": transport}
        return self._wait("find_lumels", (order,), options, _states_only(progress), idle)

    def bake_objects(
        self,
        order: BakeOrder,
        progress: Callable[[Progress], None] | None = None,
        idle: Callable[[], None] | None = None,
    ) -> BakeResult:
        """Lux maps of objects of the scene. Raises as `render`."""
        return self._wait("bake_objects", (order,), {}, _states_only(progress), idle)

    def explain(
        self, transport: str = "auto", asked: Asked = EXACT, has_trial: bool = True
    ) -> Explanation:
        """How the scene would be computed, as `Session.explain`. Raises as `render`."""
        options = {"transport": transport, "asked": asked, "has_trial": has_trial}
        return self._wait("explain", (), options, None, None)

    def compute_paint(
        self, description: str, progress: Callable[[Progress], None] | None = None
    ) -> PaintedSurface:
        """What a paint scatters, as `Session.compute_paint`. Raises as `render`."""
        return self._wait("compute_paint", (description,), {}, _states_only(progress), None)

    def compute_ink(
        self,
        description: str,
        draft: bool = False,
        processes: int = 1,
        progress: Callable[[Progress], None] | None = None,
    ) -> PrintedSurface:
        """What a pigment layer scatters, as `Session.compute_ink`. Raises as `render`."""
        options = {"draft": draft, "processes": processes}
        return self._wait("compute_ink", (description,), options, _states_only(progress), None)

    def compute_cloth(
        self,
        description: str,
        draft: bool = False,
        progress: Callable[[Progress], None] | None = None,
    ) -> WovenSurface:
        """What a cloth scatters, as `Session.compute_cloth`. Raises as `render`."""
        told = _states_only(progress)
        return self._wait("compute_cloth", (description,), {"draft": draft}, told, None)

    def watch(self, camera: Camera, settings: LiveSettings, display: Display) -> None:
        """Start or change the live view.

        Raises
        ------
        EngineLost    The worker is gone: start it again and send the whole scene.
        """
        self._check()
        self._link.watch(self.name, (camera, settings, display))

    def unwatch(self) -> None:
        """End the live view."""
        self._link.unwatch(self.name)

    def frame(self) -> Frame | None:
        """Return the newest frame of the live view, once; None while there is no newer one."""
        return self._link.take_frame(self.name)

    def view_error(self) -> str | None:
        """Say why the live view does not go on; None while it does."""
        return self._link.lost or self._link.view(self.name).error

    def close(self) -> None:
        """Let the worker forget the session; its jobs end."""
        if not self.is_lost:
            self.unwatch()
            self.cancel()
            self._link.close_session(self.name)
        self._is_closed = True
        self._worker.forget(self)

    def _check(self) -> None:
        self._link.check()
        if self._is_closed:
            raise EngineLost(f"the session '{self.name}' was closed; ask the worker for a new one")

    def _wait(
        self,
        kind: str,
        arguments: tuple,
        options: dict,
        progress,
        idle,
        interval=None,
        patience=None,
    ):
        self._check()
        body = (arguments, options)
        call = self._link.call(kind, self.name, body, patience=patience, preview_interval=interval)
        return self._link.wait(call, progress, idle)


class Worker:
    """The engine in a process of its own, to be started again as often as need be.

    Parameters
    ----------
    root : Path    Folder of the package.
    memory_limit : int or None    Most address space that the process may use. [byte]
    search_path : list of str or None    Where it looks for modules; None: where this process does.
    device : str    Key of the device it computes on (`transport.devices`); empty: the first that works.
    factory : str or None    ``module:callable`` that makes its sessions; None: the engine's own.
    hung_after : float    Silence after which it counts as hung, unless it computes. [s]
    cancel_patience : float    How long a job may take to obey a cancel. [s]
    """

    def __init__(
        self,
        root: Path,
        memory_limit: int | None = None,
        search_path: list[str] | None = None,
        *,
        device: str = "",
        factory: str | None = None,
        hung_after: float = HUNG_AFTER,
        cancel_patience: float = CANCEL_PATIENCE,
    ):
        self.root = root
        self.memory_limit = memory_limit
        self.search_path = search_path
        self.device = device
        self._factory = factory
        self._hung_after = hung_after
        self._cancel_patience = cancel_patience
        self._lock = threading.RLock()
        self._link: Link | None = None
        self._finalizer: weakref.finalize | None = None
        self._sessions: dict[str, RemoteSession] = {}

    def __enter__(self) -> "Worker":
        self.start()
        return self

    def __exit__(self, *_):
        self.close()

    @property
    def is_alive(self) -> bool:
        """Whether there is a process that serves."""
        link = self._link
        return link is not None and link.lost is None

    @property
    def pid(self) -> int | None:
        """Of the process; None without one."""
        link = self._link
        return link.pid if link is not None and link.lost is None else None

    @property
    def lost(self) -> str | None:
        """Why the last process is gone; None while it serves, before a start and after `close`."""
        link = self._link
        return None if link is None else link.lost

    def start(self, timeout: float = START_PATIENCE) -> None:
        """Start the process and wait for its first word; nothing happens while one serves. [s]

        Raises
        ------
        EngineLost    It cannot be started; the text says why.
        """
        with self._lock:
            if self.is_alive:
                return
            self._drop()
            path = list(sys.path) if self.search_path is None else self.search_path
            process = Process(self.root, path, self.memory_limit, self.device, self._factory)
            self._link = Link(process, self._hung_after, self._cancel_patience)
            # Nobody may wait inside a finalizer: the link's own thread reaps the process.
            self._finalizer = weakref.finalize(self, process.kill)
            self._link.wait_until_ready(timeout)

    def status(self, timeout: float = 120.0) -> BackendStatus:
        """Ask whether the engine can compute; the first answer takes seconds, since it loads libraries. [s]

        Raises
        ------
        EngineLost    The process is gone or did not answer in time.
        """
        link = self._serving()
        return link.wait(link.call("status", ""), seconds=timeout)

    def session(self, name: str) -> RemoteSession:
        """Return the session of a name; a new one has an empty scene.

        Raises
        ------
        EngineLost    There is no process.
        """
        with self._lock:
            link = self._serving()
            session = self._sessions.get(name)
            if session is None or session.is_lost:
                session = self._sessions[name] = RemoteSession(self, link, name)
            return session

    def forget(self, session: RemoteSession) -> None:
        """Drop a session that was closed."""
        with self._lock:
            if self._sessions.get(session.name) is session:
                del self._sessions[session.name]

    def log(self) -> tuple[str, ...]:
        """Return the last lines that the process wrote."""
        link = self._link
        return () if link is None else link.log()

    def close(self, timeout: float = CLOSE_PATIENCE) -> None:
        """End the process, by force after so many seconds; nothing is left of it. [s]"""
        with self._lock:
            self._drop(timeout)

    def _serving(self) -> Link:
        link = self._link
        if link is None:
            raise EngineLost(f"the engine is not running; {faults.AGAIN}")
        link.check()
        return link

    def _drop(self, timeout: float = CLOSE_PATIENCE) -> None:
        self._sessions.clear()
        if self._link is not None:
            # What was ended on purpose is not lost.
            self._link.end(timeout)
            self._link = None
        if self._finalizer is not None:
            self._finalizer.detach()
            self._finalizer = None


def _states_only(progress: Callable | None) -> Callable | None:
    """Adapt what takes a state to what is given a state and a picture."""
    return None if progress is None else lambda state, _: progress(state)
