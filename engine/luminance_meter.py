"""Luminance meters: the mean luminance within a cone about the direction that a meter looks in, through small pictures."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .accuracy.stopping import Progress, StopRule
from .errors import SceneError
from .scene.camera import Camera, Projection
from .views import ViewSettings

SIDE = 24
"""Side of the pictures that hold the cone. [pixel]"""

PICTURES = 4
"""Pictures that are independent of each other, whose spread tells the error."""

FIRST_SAMPLES, GROWTH, MOST_SAMPLES = 8, 4, 1 << 14
"""Samples of a pixel at first, how many times as many there are in every further round, and most of them."""

PARTS = 8
"""Parts of a pixel's side by which is found how much of it lies within the cone."""

NARROWEST, WIDEST = 1e-4, np.deg2rad(120.0)
"""Acceptance angles. [rad]"""

METER_SEEDS = 104_729
"""Distance between the seeds of meters, rounds and pictures."""


@dataclass(frozen=True)
class MeterReading:
    """Luminance of every meter and its standard error (n,) [cd/m2], samples of a pixel at least, and notes for people.

    ``simplified``: as of a `Provenance`, in the errors. [-]
    """

    luminance: np.ndarray
    standard_error: np.ndarray
    samples: int
    notes: tuple[str, ...]
    simplified: float = 0.0


def measure_luminance(
    session,
    positions,
    axes,
    angle: float,
    rule: StopRule,
    seed: int = 0,
    transport: str = "auto",
    method: str = "auto",
    progress: Callable[[Progress], None] | None = None,
) -> MeterReading:
    """Measure luminance.

    Parameters
    ----------
    session : Session or RemoteSession    With the scene.
    positions, axes : (n, 3) array    Where the meters are [m], and where they look.
    angle : float    Acceptance angle, the full width of the cone. [rad]
    rule : StopRule
        ``each``, ``limits`` or ``error``, which every meter has to reach, samples of a pixel, time of all meters together.
    method : str    As of `views.ViewSettings`.
    progress : callable or None    Gets a `Progress`.

    Raises
    ------
    SceneError    The angle makes no sense.
    Cancelled    After `cancel`.
    """
    if not NARROWEST <= angle <= WIDEST:
        raise SceneError(
            f"the acceptance angle is {np.rad2deg(angle):g} degrees, expected 0.01 to 120"
        )
    weights = find_weights(angle)
    values, errors = np.zeros(len(positions)), np.zeros(len(positions))
    least, notes, simplified, start = MOST_SAMPLES, {}, 0.0, time.perf_counter()
    for number, (place, axis) in enumerate(zip(positions, axes, strict=True)):
        end = None
        if rule.seconds is not None:
            end = start + rule.seconds * (number + 1) / len(positions)
        job = _Meter(session, place, axis, angle, weights, transport, method)
        samples = min(FIRST_SAMPLES, rule.samples or FIRST_SAMPLES)
        while True:
            job.look(max(samples, 2), seed + METER_SEEDS * (number * 64 + job.rounds))
            goal = rule.limits[number] if rule.limits else None
            wanted = rule.each if rule.each is not None else rule.error
            if wanted is not None:
                goal = wanted * max(job.value, rule.floor)
            is_known = goal is not None and job.error <= goal
            is_late = end is not None and time.perf_counter() > end
            most = rule.samples or MOST_SAMPLES
            if is_known or is_late or job.samples >= most:
                break
            samples = min(job.samples * (GROWTH - 1), most - job.samples)
        values[number], errors[number] = job.value, job.error
        least = min(least, job.samples)
        notes |= dict.fromkeys(job.notes)
        simplified = max(simplified, job.simplified)
        if progress is not None:
            seconds = time.perf_counter() - start
            done = (number + 1) / len(positions)
            stage = f"luminance meter {number + 1} of {len(positions)}"
            progress(Progress(done, job.samples, np.inf, seconds, None, stage))
    # The pictures' samples are independent, but not what is left out of all of them.
    errors = np.hypot(errors, simplified * values)
    return MeterReading(values, errors, least, tuple(notes), simplified)


class _Meter:
    """One meter: pictures so far."""

    def __init__(self, session, place, axis, angle, weights, transport, method):
        self._session, self._weights = session, weights
        self._camera = _look_along(place, axis, angle)
        self._settings = ViewSettings(
            StopRule(samples=1), transport=transport, method=method, shares=False
        )
        self.rounds = self.samples = 0
        self._sums, self._variances = np.zeros(PICTURES), np.zeros(PICTURES)
        self.notes: dict[str, None] = {}
        self.simplified = 0.0

    def look(self, samples: int, seed: int) -> None:
        """Take more samples in all pictures."""
        for picture in range(PICTURES):
            own = replace(
                self._settings,
                rule=StopRule(samples=samples),
                seed=(seed * PICTURES + picture) % 2**31,
            )
            made = self._session.render(self._camera, own)
            luminance = made.tristimulus[..., 1].astype(np.float64)
            self._sums[picture] += samples * float((self._weights * luminance).sum())
            noise = self._weights * made.luminance_error
            self._variances[picture] += samples**2 * float((noise**2).sum())
            self.notes |= dict.fromkeys(made.provenance.notes)
            self.simplified = max(self.simplified, made.provenance.simplified)
        self.samples += samples
        self.rounds += 1

    @property
    def value(self) -> float:
        return float(self._sums.mean()) / self.samples

    @property
    def error(self) -> float:
        """The larger one of what the spread of the pictures and what their pixels tell."""
        spread = float(self._sums.std(ddof=1)) / np.sqrt(PICTURES) / self.samples
        pixels = float(np.sqrt(self._variances.sum())) / PICTURES / self.samples
        return max(spread, pixels)


def find_weights(angle: float) -> np.ndarray:
    """Share of each pixel of a picture in the solid angle of a cone that fills its width. (h, w), their sum is 1"""
    half = np.tan(0.5 * angle)
    fine = (np.arange(SIDE * PARTS) + 0.5) / (0.5 * SIDE * PARTS) - 1.0
    square = (half * fine[None]) ** 2 + (half * fine[:, None]) ** 2
    solid = np.where(square <= half**2, (1.0 + square) ** -1.5, 0.0)
    shares = solid.reshape(SIDE, PARTS, SIDE, PARTS).sum(axis=(1, 3))
    return shares / shares.sum()


def _look_along(place, axis, angle: float) -> Camera:
    """Camera at a place whose film just holds a cone about an axis."""
    z = -np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
    x = np.cross([0.0, 0.0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frame[:3, 3] = place
    extent = 2.0 * float(np.tan(0.5 * angle))
    return Camera(frame, Projection.PERSPECTIVE, SIDE, SIDE, extent, extent)
