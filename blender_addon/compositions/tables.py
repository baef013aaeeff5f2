"""Tables of compositions, computed once for each in the engine's process while Blender goes on."""

from collections.abc import Callable

import bpy

from ...engine.errors import Cancelled
from ..file_assets.kind import FileKind
from ..foundation import engine_process
from ..surface_models import is_modelled
from .description import digest_of, to_text

KEPT = 32
"""Tables of a kind that are kept, of 8 MB each or so."""


class CompositionTables(FileKind):
    """What compositions of one kind scatter; each kind says what differs.

    Parameters
    ----------
    model : str    Of `surface_models`.
    noun : str    What people call it.
    rest : float    How long sliders must have been still before a table is computed. [s]
    """

    is_stopped_unwanted = True

    def __init__(self, model: str, noun: str, rest: float):
        super().__init__(KEPT, f"lumenray-{model.lower()}")
        self.model, self.noun, self.rest = model, noun, rest
        self.under_way = f"its {noun} is being computed ({{share:.0f}} %)"
        self.stopped = f"its {noun} was not computed: stopped"
        self.fault = f"its {noun} cannot be computed ({{cause}}); please send its description to the developers"

    # ---- what differs ----

    def describe(self, settings) -> dict:
        """Return the description that settings state."""
        raise NotImplementedError

    def qualities(self, settings) -> tuple[str, ...]:
        """Return what a table depends on beside its description."""
        return ()

    def compute(self, text: str, qualities: tuple[str, ...], job):
        """Return what a description in JSON scatters; ``qualities`` as of that method, the rest as of `compute_with`."""
        raise NotImplementedError

    # ---- what is alike ----

    def source(self, settings) -> tuple:
        content, qualities = self.describe(settings), self.qualities(settings)

        def prepare():
            text = to_text(content)
            return lambda job: self.compute(text, qualities, job)

        return (digest_of(content, *qualities),), prepare

    def users(self):
        return (each for each in bpy.data.materials if is_modelled(each, self.model))

    def absolute_path(self, settings) -> str:
        return ""

    def place_of(self, settings) -> str:
        return ""

    def name_of(self, settings) -> str:
        return settings.name or self.noun

    def compute_with(self, work: Callable, job):
        """Have a session of the engine compute a table, as soon as sliders are still.

        Parameters
        ----------
        work : callable    Given a session and what it tells its progress to, returns the table.
        job : file_assets.shelf.Job    Told how far it is; its ``stop`` ends the work.

        Raises
        ------
        Cancelled    It was stopped.
        LumenrayError    It cannot be computed.
        """
        if not bpy.app.background and job.stop.wait(self.rest):
            raise Cancelled(self.stopped)
        session = engine_process.open_session(self.model.lower())

        def report(progress):
            job.tell(progress.done, progress.seconds_left)
            if job.stop.is_set():
                session.cancel()

        try:
            if job.stop.is_set():
                raise Cancelled(self.stopped)
            return work(session, report)
        finally:
            session.close()
