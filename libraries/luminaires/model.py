"""Models of a library as pure data."""

from dataclasses import dataclass, field
from pathlib import Path

from ..entries import Problem

MOUNTS = ("ceiling", "pendant", "wall", "open", "floor", "table", "aimed", "level")
"""How a luminaire is used: below a ceiling, hung from it, out of a wall, over open ground (on a mast), standing on a floor
or a table, aimed at a wall from above, or shining level."""

SHAPES = ("point", "rectangle", "ellipse", "box", "ellipsoid", "cylinder")
"""Kinds of luminous openings, as the engine knows them."""


@dataclass(frozen=True)
class Light:
    """Spectrum of a lamp: ``illuminant`` (a name of `libraries.spectra`), ``blackbody`` or ``daylight`` (a temperature).

    Parameters
    ----------
    kind : str
    name : str    Of the illuminant.
    temperature : float    [K]
    """

    kind: str
    name: str = ""
    temperature: float = 0.0


@dataclass(frozen=True)
class Part:
    """One emitter of a lamp that has several; all have the distribution of the lamp's file.

    Parameters
    ----------
    position : (float, float, float)    In the lamp's axes. [m]
    axis : (float, float, float)    Where the part's own z axis points, unit length; (0, 0, 1) leaves it as it is.
    share : float    Of the lamp's flux.
    shape : str    One of `SHAPES`.
    size : (float, float, float)    Full extent along the part's own axes. [m]
    opening_axis : str    ``x``, ``y`` or ``z``: the normal of a flat opening, the axis of a cylinder.
    """

    position: tuple[float, float, float]
    share: float
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    shape: str = "point"
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    opening_axis: str = "z"


@dataclass(frozen=True)
class Model:
    """A luminaire of a library.

    Parameters
    ----------
    name : str    Unlike all others of its library.
    file : Path    The photometric file.
    title, description : str    For people.
    category : str    By use, from the general to the special, with slashes.
    maker, author, licence : str    Empty if not stated.
    tags : tuple of str
    light : Light or None    None: as the photometric file says.
    luminous_flux, watts : float or None    Stated beside the file, for comparison. [lm], [W]
    mount : str    One of `MOUNTS`.
    height : float    Of the luminaire above the floor in its picture. [m]
    drop : float    Of the luminaire below the ceiling in its picture. [m]
    thumbnail : Path or None    Picture of the light that it throws; need not exist.
    parts : tuple of Part    Emitters of a composed lamp.
    """

    name: str
    file: Path
    title: str
    description: str = ""
    category: str = ""
    maker: str = ""
    author: str = ""
    licence: str = ""
    tags: tuple[str, ...] = ()
    light: Light | None = None
    luminous_flux: float | None = None
    watts: float | None = None
    mount: str = "ceiling"
    height: float = 2.5
    drop: float = 0.0
    thumbnail: Path | None = None
    parts: tuple[Part, ...] = ()


@dataclass(frozen=True)
class Library:
    """Models of a folder, by category and title, and what could not be used."""

    folder: Path
    models: tuple[Model, ...]
    problems: tuple[Problem, ...] = field(default=())
