"""From the open scene to the decisions that the engine makes of it: read on the main thread, made by the engine."""

from dataclasses import dataclass, field

from ...engine.errors import Cancelled
from ...imports import loaded_when_used
from ..foundation.report import ConversionReport
from .asked import Question

with loaded_when_used():
    from ...engine.analysis import explanation
    from ...engine.requirements import decision
    from ..sync import scene, step

NAME = "modelling"
"""Of the job."""


@dataclass(eq=False)
class ModellingJob:
    """Decisions to be made; they are there after `run`."""

    parts: list
    asked: "decision.Asked"
    transport: str
    answer: "explanation.Explanation | None" = None
    _session: object = field(default=None, repr=False)
    _is_cancelled: bool = False

    def run(self, session, progress=None) -> None:
        """Have the decisions made; ``progress`` is told of nothing.

        Parameters
        ----------
        session : Session or RemoteSession    An empty one.

        Raises
        ------
        Cancelled    After `cancel`.
        LumenrayError    The scene makes no sense.
        """
        self._session = session
        for part in self.parts:
            if self._is_cancelled:
                raise Cancelled("cancelled")
            session.apply(part)
        # The engine holds the scene now.
        self.parts = []
        self.answer = session.explain(self.transport, self.asked, has_trial=False)

    def cancel(self) -> None:
        """End it; may be called from any thread."""
        self._is_cancelled = True
        if self._session is not None:
            self._session.cancel()


def prepare(depsgraph, question: Question) -> tuple[ModellingJob, ConversionReport]:
    """Return the job of the decisions about a scene, and what could not be taken over.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph    Evaluated.
    question : Question    What they are made for.
    """
    converted = scene.convert_scene(depsgraph)
    parts = list(step.split(converted.delta, step.PART_BYTES))
    job = ModellingJob(parts, question.asked(converted.objects), question.transport)
    return job, converted.report
