"""What a luminaire's photometry says: luminous intensity by direction, and the size of what shines."""

from dataclasses import dataclass, field

import numpy as np

SHAPES = ("point", "rectangle", "ellipse", "box", "ellipsoid", "cylinder")
"""Kinds of luminous openings."""


@dataclass(frozen=True, eq=False)
class IntensityDistribution:
    """Luminous intensity on a grid of directions, bilinear between them.

    A direction has the azimuth C and the polar angle gamma of a grid whose own axes are the columns of ``frame``:
    ``d = frame @ (sin(gamma) cos(C), sin(gamma) sin(C), -cos(gamma))``. Of type C the frame is the identity: gamma counts
    from the luminaire's -z, C counter-clockwise seen from above, from its +x. Types A and B are the same grid about another
    polar axis (see `engine/luminaires/coordinates.py`), so they are interpolated in their own angles, as they were measured.

    Parameters
    ----------
    azimuth : (a,) float64 array    Ascending, spanning at most a full turn. [rad] One value: the same all around. Where the
        span is less than a full turn, nothing is emitted outside it.
    polar : (p,) float64 array    Ascending within 0..pi, at least two. [rad] Nothing is emitted outside.
    intensity : (a, p) float64 array    Not negative. [cd] Only proportions count where a light states its flux.
    frame : (3, 3) float64 array    Orthogonal; a determinant of -1 mirrors.
    colours : (a, p, 3) float32 array or None
        Linear Rec. 709 colours at the nodes, on the light's own spectrum, of which only proportions count: the intensity is
        the amount. The grid is even then, and has two azimuths at least. None: all directions have the light's own spectrum.
    """

    azimuth: np.ndarray
    polar: np.ndarray
    intensity: np.ndarray
    frame: np.ndarray = field(default_factory=lambda: np.eye(3))
    colours: np.ndarray | None = None


@dataclass(frozen=True)
class Opening:
    """The luminous opening as a convex body around the photometric centre, sides along the luminaire's axes.

    Parameters
    ----------
    shape : str    One of `SHAPES`.
    size : (float, float, float)    Full extent along the luminaire's x, y and z. [m] 0 along ``axis`` for flat shapes.
    axis : str    ``x``, ``y`` or ``z``: the normal of a rectangle or ellipse, the axis of a cylinder.
    """

    shape: str = "point"
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: str = "z"
