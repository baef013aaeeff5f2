"""A session that computes here, and once it has joined a cluster has the workers do what takes long.

These are pictures, measurements, daylight and bakes; other jobs take moments, or are about what this machine shows.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..errors import EngineLost, LumenrayError
from ..scene.scene import SceneDelta
from ..session import Session
from .dask_crew import DaskCrew
from .security import Certificates, read_address
from .session import ClusterSession


@dataclass(frozen=True)
class ClusterPlace:
    """Where a cluster is, and the files in PEM by which both ends know each other; empty names: none.

    Parameters
    ----------
    address : str    As of `security.read_address`.
    authority, certificate, key : str    As of `security.Certificates`.
    """

    address: str
    authority: str = ""
    certificate: str = ""
    key: str = ""

    def open_crew(self) -> DaskCrew:
        """Reach the cluster's workers.

        Raises
        ------
        LumenrayError    Only some of the files are named, or as of `DaskCrew`.
        """
        files = self.authority, self.certificate, self.key
        if any(files) and not all(files):
            raise LumenrayError(
                "a cluster with TLS needs three files, of which only some are named: the authority's certificate, the own "
                "one and its key"
            )
        certificates = Certificates(*map(Path, files)) if any(files) else None
        return DaskCrew(read_address(self.address), certificates)


class SharedSession(Session):
    """See above; parameters as of `Session`."""

    def __init__(self, interrupt: Callable[[], None] | None = None):
        super().__init__(interrupt=interrupt)
        self._interrupt = interrupt
        self._place: ClusterPlace | None = None
        self._crew: DaskCrew | None = None
        self._shared: ClusterSession | None = None

    def join(self, place: tuple[str, str, str, str] | None) -> None:
        """Have a cluster do what takes long from now on, None: this machine. It is looked for by the next such job.

        ``place``: the fields of a `ClusterPlace`, in their order.
        """
        place = None if place is None else ClusterPlace(*place)
        if place != self._place:
            self.close()
            self._place = place

    def close(self) -> None:
        """Let go of the cluster."""
        crew, self._crew, self._shared, self._place = self._crew, None, None, None
        if crew is not None:
            crew.close()

    def apply(self, delta: SceneDelta) -> None:
        """Change the scene, as of `Session.apply`."""
        super().apply(delta)
        if self._shared is not None:
            self._shared.apply(delta)

    def cancel(self) -> None:
        """Ask the running job to end; it raises `Cancelled`."""
        super().cancel()
        if self._shared is not None:
            self._shared.cancel()

    def stop(self) -> None:
        """Ask a bake that runs to end with what it has."""
        super().stop()
        if self._shared is not None:
            self._shared.stop()

    def render(self, *arguments, **options):
        """Render a view, as of `Session.render`."""
        return self._do("render", arguments, options)

    def measure(self, *arguments, **options):
        """Illuminance at points, as of `Session.measure`."""
        return self._do("measure", arguments, options)

    def measure_sensors(self, *arguments, **options):
        """Illuminance at sensors of the scene, as of `Session.measure_sensors`."""
        return self._do("measure_sensors", arguments, options)

    def find_daylight(self, *arguments, **options):
        """What points have of sky and sun, as of `Session.find_daylight`."""
        return self._do("find_daylight", arguments, options)

    def bake_objects(self, *arguments, **options):
        """Lux maps of objects, as of `Session.bake_objects`."""
        return self._do("bake_objects", arguments, options)

    def list_workers(self, progress=None) -> tuple[tuple[str, float], ...]:
        """Workers of the cluster by their addresses, and for how long each has not been heard; without one none. [s]

        Raises
        ------
        LumenrayError    As of `ClusterPlace.open_crew`.
        """
        if self._place is None:
            return ()
        try:
            self._meet()
            return tuple(sorted(self._crew.workers().items()))
        except EngineLost as error:
            raise self._left(error) from None

    # ---- private ----

    def _do(self, method: str, arguments: tuple, options: dict):
        """Have a job done where that is to be."""
        if self._place is None:
            return getattr(super(), method)(*arguments, **options)
        try:
            self._meet()
            return getattr(self._shared, method)(*arguments, **options)
        except EngineLost as error:
            raise self._left(error) from None

    def _meet(self) -> None:
        """Reach the cluster and give it the scene, unless that is done."""
        if self._shared is not None:
            return
        self._crew = self._place.open_crew()
        shared = ClusterSession(self._crew, interrupt=self._interrupt)
        shared.apply(self.scene.snapshot())
        self._shared = shared

    def _left(self, error: EngineLost) -> LumenrayError:
        """What to say where the cluster is lost, as this process is not. The next job looks for it anew."""
        place = self._place
        self.close()
        self._place = place
        return LumenrayError(str(error))


def make_session(pause: Callable[[], None]) -> SharedSession:
    """Make the session of a worker's process (`worker.client.Worker`, ``factory``)."""
    return SharedSession(pause)
