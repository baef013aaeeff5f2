"""Decisions that the engine has made about scenes, kept for as long as the file is open, and whether they still hold."""

from dataclasses import dataclass

from bpy.app.handlers import persistent

from ...engine.scene.modelling import Modelling
from ...imports import loaded_when_used
from ..bake.results import MOST_NAMES, Watch
from ..foundation.handlers import leave, listen
from .asked import Question, find_question
from .wishes import read_wishes

with loaded_when_used():
    from ...engine.requirements import plan as requirements_plan


@dataclass(frozen=True)
class Answer:
    """Decisions about a scene.

    Parameters
    ----------
    plan : Plan
    question : Question    What they were made for.
    wishes : Modelling    By which switches.
    watch : Watch    What has changed since.
    """

    plan: "requirements_plan.Plan"
    question: Question
    wishes: Modelling
    watch: Watch

    def why_outdated(self, scene, selected=()) -> str:
        """Say what has changed since they were made; empty: nothing. ``selected``: as of `find_question`."""
        if read_wishes(scene.lumenray.modelling) != self.wishes:
            return "the switches"
        if find_question(scene, selected) != self.question:
            return "what is asked for"
        names = list(self.watch.names)
        return ", ".join(names[:MOST_NAMES] + (["…"] if len(names) > MOST_NAMES else []))


_answers: dict[tuple[int, str], Answer] = {}
"""By `key_of` their scene."""


def key_of(scene) -> tuple[int, str]:
    """What decisions about a scene are kept by: the scene, and what it is computed for."""
    return scene.session_uid, scene.lumenray.modelling.purpose


def store(key: tuple[int, str], answer: Answer) -> None:
    """Keep decisions in place of those before."""
    before = _answers.pop(key, None)
    if before is not None:
        before.watch.end()
    _answers[key] = answer


def find(scene) -> Answer | None:
    """Return the decisions about a scene, None while none were made."""
    return _answers.get(key_of(scene))


def forget() -> None:
    """Forget all decisions."""
    for answer in _answers.values():
        answer.watch.end()
    _answers.clear()


@persistent
def _forget(*_):
    forget()


_HANDLERS = {"load_post": _forget}


def attach():
    """Tie decisions to the file."""
    listen(_HANDLERS)


def detach():
    """Forget decisions for good."""
    leave(_HANDLERS)
    forget()
