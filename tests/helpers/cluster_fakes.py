"""Workers in this process that die, stall and fail as a test says, on a clock of the test's own."""

import random
from dataclasses import dataclass, field

from lumenray.engine.cluster import workplace
from lumenray.engine.cluster.crew import Reply
from lumenray.engine.cluster.parcels import pack, unpack


@dataclass
class FakeCrew:
    """A crew whose workers take ``seconds`` for an errand.

    Attributes
    ----------
    answers : callable    ``answers(worker, scene, order)`` gives what `workplace.work` would, as plain data.
    paces : dict of str to float    By worker: times as long as others; infinite: it is stopped, and silent.
    """

    names: list
    answers: object
    seconds: float = 1.0
    paces: dict = field(default_factory=dict)
    now: float = 0.0
    sent: list = field(default_factory=list)
    recalled: list = field(default_factory=list)
    under_way: dict = field(default_factory=dict)
    stopped_since: dict = field(default_factory=dict)
    events: list = field(default_factory=list)

    def clock(self):
        return self.now

    def at(self, time, event):
        """Have something happen at a time."""
        self.events.append((time, event))
        self.events.sort(key=lambda each: each[0])

    def kill(self, worker):
        self.names.remove(worker)
        for errand in [k for k, each in self.under_way.items() if each[0] == worker]:
            del self.under_way[errand]

    def stop(self, worker):
        self.paces[worker] = float("inf")
        self.stopped_since[worker] = self.now

    def workers(self):
        return {name: self.now - self.stopped_since.get(name, self.now) for name in self.names}

    def send(self, errand, worker, scene, task):
        order = unpack(task)
        self.sent.append((worker, bool(scene), order))
        end = self.now + self.seconds * self.paces.get(worker, 1.0)
        self.under_way[errand] = (worker, end, scene, order)

    def replies(self, seconds):
        self.now += seconds
        while self.events and self.events[0][0] <= self.now:
            self.events.pop(0)[1]()
        done = [k for k, each in self.under_way.items() if each[1] <= self.now]
        found = []
        for errand in done:
            worker, _, scene, order = self.under_way.pop(errand)
            found.append(Reply(errand, pack(self.answers(worker, scene, order))))
        return found

    def recall(self, errand):
        self.recalled.append(errand)
        if errand in self.under_way:
            worker, end, scene, _ = self.under_way[errand]
            if end != float("inf"):
                self.under_way[errand] = (worker, self.now, scene, None)

    def drop(self, errand):
        self.recalled.append(errand)
        self.under_way.pop(errand, None)


class RoomCrew:
    """Workers that are this very process: each errand is done when it is asked after, in an order drawn at random.

    All share one workplace, so that every chunk meets a session on which others were computed before.
    """

    def __init__(self, names=("a", "b"), seed=0):
        self._names, self._draw = tuple(names), random.Random(seed)  # noqa: S311
        self._waiting = {}
        self.sent = []

    def workers(self):
        return dict.fromkeys(self._names, 0.0)

    def send(self, errand, worker, scene, task):
        self.sent.append((worker, len(scene)))
        self._waiting[errand] = (scene, task)

    def replies(self, _seconds):
        if not self._waiting:
            return []
        errand = self._draw.choice(list(self._waiting))
        return [Reply(errand, workplace.work(*self._waiting.pop(errand)))]

    def recall(self, errand):
        workplace.recall(errand)

    def drop(self, errand):
        self._waiting.pop(errand, None)
