"""Weaves: which yarn is up where, and the lines along which yarns run.

At a crossing the centre of the upper yarn is h/2 above the middle and that of the lower one h/2 below it, h each yarn's own.
They touch: h of the warp and h of the weft are together the heights of both (Peirce). Between crossings of different state
a centre line is half a wave of a cosine, between such of the same state it is straight.

References
----------
F. T. Peirce: The geometry of cloth structure, Journal of the Textile Institute 28, T45-T96, 1937.
"""

import math
from dataclasses import dataclass

import numpy as np

from .composition import Weave

MOST_YARNS = 64
"""Largest repeat, along warp and weft."""


def plain(warp_pitch_mm: float, weft_pitch_mm: float) -> Weave:
    """Each yarn over one, under one."""
    return Weave(twill_pattern(1, 1), warp_pitch_mm, weft_pitch_mm, True, True)


def twill_pattern(over: int, under: int) -> np.ndarray:
    """Warp over so many picks, under so many, each end one pick further. (n, n) bool"""
    steps = np.arange(over + under)
    return (steps[:, None] + steps) % (over + under) < over


def satin_pattern(ends: int, step: int) -> np.ndarray:
    """Warp satin: each end is up but at one pick, ``step`` further from end to end. (n, n) bool

    Raises
    ------
    ValueError    Step and ends have a common divisor, or make a twill.
    """
    if math.gcd(step, ends) != 1 or step % ends in (1, ends - 1):
        raise ValueError(
            f"a satin of {ends} ends cannot have the step {step}; it needs one from 2 to {ends - 2} without a common divisor"
        )
    pattern = np.ones((ends, ends), bool)
    pattern[np.arange(ends), step * np.arange(ends) % ends] = False
    return pattern


@dataclass(frozen=True)
class Jam:
    """The tightest square plain weave of round yarns.

    Parameters
    ----------
    weave_angle : float    Steepest slope of a yarn. [rad]
    pitch : float    Over the sum of both diameters. [-]
    crimp : float    By how much a yarn is longer than the cloth. [-]
    """

    weave_angle: float
    pitch: float
    crimp: float


def jammed_plain() -> Jam:
    """Peirce's closed form: yarns are arcs about each other, without straight parts."""
    # D (1 - cos) per yarn is half the sum D of both diameters; the arc over the pitch is the angle over its sine.
    angle = math.acos(0.5)
    return Jam(angle, math.sin(angle), angle / math.sin(angle) - 1.0)


def heights(states, amplitude: float, places) -> np.ndarray:
    """Height of a centre line over a repeat of crossings.

    Parameters
    ----------
    states : (n,) bool array    Whether the yarn is up; it goes on periodically.
    amplitude : float    h.
    places : (k,) array    Along the yarn in pitches; crossing j lies at j + 1/2.
    """
    states = np.where(np.asarray(states), 0.5, -0.5) * amplitude
    place = np.asarray(places, np.float64) - 0.5
    below = np.floor(place).astype(int)
    first, second = states[below % len(states)], states[(below + 1) % len(states)]
    return 0.5 * (first + second) + 0.5 * (first - second) * np.cos(np.pi * (place - below))


def crimp(states, amplitude: float, pitch: float, steps: int = 2048) -> float:
    """By how much a yarn is longer than the cloth along it. [-]"""
    places = np.linspace(0.0, len(states), steps * len(states) + 1)
    rise = np.diff(heights(states, amplitude, places))
    run = np.diff(places) * pitch
    return float(np.hypot(rise, run).sum() / (pitch * len(states)) - 1.0)
