"""What a material of the library is made by."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..retroreflection import Sheeting


@dataclass(frozen=True, eq=False)
class Part:
    """What a side reflects or lets through, before it becomes a table.

    Parameters
    ----------
    evaluate : callable    (n, 3), (n, 3) -> (n, w) at `colour.WAVELENGTHS`, or (n, 1) the same at all. [1/sr]
    direct : callable or None    Share mirrored, or passing straight, by angles of incidence [rad]: (s,) -> (s, w). [-]
    is_grained : bool    Whether it has a grain along x: mirrors along x and y change nothing, turns about the normal do.
    tolerance : float    Of the table, see `engine.scattering.data.resampling.resample`. [-]
    """

    evaluate: Callable
    direct: Callable | None = None
    is_grained: bool = False
    tolerance: float = 0.04


@dataclass(frozen=True, eq=False)
class Recipe:
    """A material.

    Parameters
    ----------
    name : str    Also that of its file, without the end.
    category, title, description, source : str    As the catalogue has them.
    tags : tuple of str
    settings : dict    Of the physical override; empty for one with a file of its own.
    make : callable or None
        Its parts by side, as `engine.scattering.data.record.SIDES` names them; the same part may serve several.
    reflectance, transmittance : float or None
        Luminous, under D65: light 8 degrees from the normal, gloss and what passes straight included. [-]
    more : dict    Further figures, by the names of the catalogue's entries.
    """

    name: str
    category: str
    title: str
    description: str
    source: str
    tags: tuple[str, ...]
    settings: dict = field(default_factory=dict)
    make: Callable[[], dict[str, Part | Sheeting]] | None = None
    reflectance: float | None = None
    transmittance: float | None = None
    more: dict = field(default_factory=dict)

    @property
    def entry(self) -> dict:
        """Of the catalogue ``materials.json``."""
        entry = {
            "name": self.name,
            "title": self.title,
            "category": self.category,
            "description": self.description,
            "source": self.source,
            "tags": list(self.tags),
            "settings": self.settings,
        }
        if self.make is not None:
            entry["settings"] = {
                "model": "MEASURED",
                "measured": {"filepath": f"library:{self.name}"},
            }
        for key, value in (
            ("luminous_reflectance", self.reflectance),
            ("luminous_transmittance", self.transmittance),
        ):
            if value is not None:
                entry[key] = value
        return {**entry, **self.more}


def both(part: Part) -> dict[str, Part]:
    """The same reflection from the front and from the back."""
    return {"front_reflection": part, "back_reflection": part}


def through(part: Part) -> dict[str, Part]:
    """The same transmission from the front and from the back."""
    return {"front_transmission": part, "back_transmission": part}


def even(values) -> np.ndarray:
    """A value for all wavelengths, (1,)."""
    return np.full(1, float(values))
