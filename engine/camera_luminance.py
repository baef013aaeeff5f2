"""A camera as a luminance meter: mean luminances of equal parts of its picture, with errors."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .accuracy.stopping import Progress, StopRule
from .errors import SceneError
from .formats.luminance_picture import view_of_camera
from .luminance_meter import (
    FIRST_SAMPLES,
    GROWTH,
    METER_SEEDS,
    MOST_SAMPLES,
    PICTURES,
    MeterReading,
)
from .scene.camera import Camera
from .views import ViewSettings

SIDE = 12
"""Pixels along each side of a part, fewer where there are many parts."""

MOST_PIXELS = 1024
"""Along a side of the picture."""


def find_regions(camera: Camera, shape: tuple[int, int]) -> Camera:
    """Return the camera with as many pixels as parts of its picture need. ``shape``: rows and columns of parts.

    Raises
    ------
    SceneError    The camera has a view that no eye could have, or there are too many parts.
    """
    rows, columns = shape
    if not (min(shape) >= 1 and max(shape) <= MOST_PIXELS):
        raise SceneError(
            f"a picture has 1 to {MOST_PIXELS} rows and columns of parts, not {rows} x {columns}"
        )
    if view_of_camera(camera) is None:
        raise SceneError(f"the camera sees as a {camera.projection.value}, which no eye could")
    side = max(min(SIDE, MOST_PIXELS // max(shape)), 1)
    return replace(camera, width=columns * side, height=rows * side)


def measure_regions(
    session,
    camera: Camera,
    shape: tuple[int, int],
    rule: StopRule,
    seed: int = 0,
    transport: str = "auto",
    method: str = "auto",
    progress: Callable[[Progress], None] | None = None,
) -> MeterReading:
    """Measure mean luminances of the parts of a camera's picture, row by row from the lower left.

    Parameters
    ----------
    session : Session or RemoteSession    With the scene.
    camera : Camera    Its size in pixels does not count.
    shape : (int, int)    Rows and columns of parts.
    rule : StopRule    ``each``, ``limits`` or ``error`` (root mean square over the mean), samples of a pixel, time.

    Raises
    ------
    SceneError    As of `find_regions`.
    Cancelled    After `cancel`.
    """
    camera = find_regions(camera, shape)
    weights = view_of_camera(camera).pixels()[1]
    # Of parts of which nothing is seen, as in the corners of a fisheye, the mean is 0.
    whole = _sums(weights, shape).reshape(shape)
    pixels_of_part = np.ones((camera.height // shape[0], camera.width // shape[1]))
    weights /= np.maximum(np.kron(whole, pixels_of_part), 1e-30)
    settings = ViewSettings(StopRule(samples=1), transport=transport, method=method, shares=False)
    sums, variance = np.zeros((PICTURES, shape[0] * shape[1])), 0.0
    done, seconds, rounds, notes, simplified = 0, 0.0, 0, {}, 0.0
    samples = max(min(FIRST_SAMPLES, rule.samples or FIRST_SAMPLES), 2)
    while True:
        for picture in range(PICTURES):
            own = (seed + METER_SEEDS * (rounds * PICTURES + picture)) % 2**31
            made = session.render(
                camera, replace(settings, rule=StopRule(samples=samples), seed=own)
            )
            luminance = made.tristimulus[..., 1].astype(np.float64)
            sums[picture] += samples * _sums(weights * luminance, shape)
            noise = weights * made.luminance_error
            variance = variance + samples**2 * _sums(noise.astype(np.float64) ** 2, shape)
            notes |= dict.fromkeys(made.provenance.notes)
            seconds += made.provenance.seconds
            simplified = max(simplified, made.provenance.simplified)
        done, rounds = done + samples, rounds + 1
        values = sums.mean(axis=0) / done
        spread = sums.std(axis=0, ddof=1) / np.sqrt(PICTURES) / done
        pixels = np.sqrt(variance) / PICTURES / done
        errors = np.maximum(spread, pixels)
        is_late = rule.seconds is not None and seconds > rule.seconds
        if progress is not None:
            told = float(np.sqrt((errors**2).mean()) / max(values.mean(), rule.floor, 1e-30))
            progress(Progress(0.5, done, told, seconds, None, "camera"))
        if _is_met(rule, values, errors) or is_late or done >= (rule.samples or MOST_SAMPLES):
            # The pictures' samples are independent, but not what is left out of all of them.
            errors = np.hypot(errors, simplified * values)
            return MeterReading(values, errors, done, tuple(notes), simplified)
        samples = min(done * (GROWTH - 1), (rule.samples or MOST_SAMPLES) - done)


def _is_met(rule: StopRule, values, errors) -> bool:
    if rule.limits:
        return bool((errors <= np.array(rule.limits)).all())
    if rule.each is not None:
        return bool((errors <= rule.each * np.maximum(values, rule.floor)).all())
    if rule.error is not None:
        return bool(np.sqrt((errors**2).mean()) <= rule.error * max(values.mean(), rule.floor))
    return False


def _sums(values: np.ndarray, shape) -> np.ndarray:
    """Sums over parts. (h, w) -> (rows * columns,)"""
    rows, columns = shape
    height, width = values.shape
    blocks = values.reshape(rows, height // rows, columns, width // columns)
    return blocks.sum(axis=(1, 3)).ravel()
