"""What a dispatcher needs of workers, whoever they are and however they are reached."""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Reply:
    """What came of an errand, by its name: a parcel, or in words why there is none.

    ``is_lost``: whether the worker is gone, so that the errand says nothing about itself.
    """

    errand: str
    parcel: bytes = b""
    trouble: str = ""
    is_lost: bool = False


class Crew(Protocol):
    """Workers that come and go. Nothing but `replies` waits."""

    def workers(self) -> dict[str, float]:
        """Workers that are there, and for how long each has not been heard. [s]

        Raises
        ------
        EngineLost    The cluster is gone.
        """

    def send(self, errand: str, worker: str, scene: bytes, task: bytes) -> None:
        """Send a worker to work, see `workplace.work`; ``errand``: a name that no other has."""

    def replies(self, seconds: float) -> list[Reply]:
        """What has come, waiting no longer than this. [s]"""

    def recall(self, errand: str) -> None:
        """Tell a worker to leave an errand, which it then replies to."""

    def drop(self, errand: str) -> None:
        """Recall an errand and forget it: no reply comes."""
