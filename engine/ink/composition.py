"""What a dense pigment layer is made of, as data."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..optical_constants.curves import Index, Spectrum
from ..scene.scattering import ScatterTable
from .particles import Population


@dataclass(frozen=True, eq=False)
class Pigment:
    """Particles of one matter; without a diameter they count as dissolved.

    Parameters
    ----------
    index : Index    n + i k. [-]
    population : Population
    name : str
    """

    index: Index
    population: Population
    name: str = ""

    @property
    def is_dissolved(self) -> bool:
        """Whether it has no particles but changes the mean permittivity alone."""
        return self.population.diameter <= 0.0


@dataclass(frozen=True)
class Relief:
    """A random upper face.

    Parameters
    ----------
    height, length : float    Standard deviation of the height, and the length of its Gaussian correlation. [um]
    """

    height: float
    length: float


@dataclass(frozen=True)
class Solving:
    """What a description states of how it is to be solved; None: as follows from the particles."""

    cell: float | None = None
    steps_per_diameter: float | None = None
    band_step: float | None = None
    realisations: int | None = None
    incidences: int | None = None
    tolerance: float | None = None
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Ink:
    """A pigment layer on its substrate.

    Parameters
    ----------
    thickness : float    Mean. [um]
    thickness_spread : float    Half the width of its even distribution, relative. [-]
    binder : Index
    pigments : tuple of Pigment
    relief : Relief or None    None: a smooth upper face.
    substrate : Spectrum or ScatterTable    Reflectance of a matt one, or what it scatters, of light within ``below``.
    below : float    Index under the layer: 1 where air is between it and the substrate.
    solving : Solving
    name, description, source : str
    content : dict    The description in JSON that it was made of.
    """

    thickness: float
    thickness_spread: float
    binder: Index
    pigments: tuple[Pigment, ...]
    relief: Relief | None
    substrate: Spectrum | ScatterTable
    below: float = 1.0
    solving: Solving = Solving()
    name: str = ""
    description: str = ""
    source: str = ""
    content: dict = field(default_factory=dict, compare=False)

    @property
    def particles(self) -> tuple[Pigment, ...]:
        """Pigments that are not dissolved."""
        return tuple(each for each in self.pigments if not each.is_dissolved)

    @property
    def is_alike_from_both_sides(self) -> bool:
        """Whether light from below meets, on average, what light from above does."""
        return self.below == 1.0 and self.relief is None

    def matrix(self, wavelength: float) -> complex:
        """Permittivity of the binder with what is dissolved in it; that takes its share from the binder. [nm] -> [-]"""
        binder = complex(self.binder.at([wavelength])[0]) ** 2
        solid = sum(each.population.share for each in self.particles)
        made = binder
        for each in self.pigments:
            if each.is_dissolved:
                own = complex(each.index.at([wavelength])[0]) ** 2
                made += each.population.share / (1.0 - solid) * (own - binder)
        return made

    def mean_permittivity(self, wavelength: float) -> complex:
        """Mean over the layer, in the limit of small particles all that counts. [nm] -> [-]"""
        made = matrix = self.matrix(wavelength)
        for each in self.particles:
            own = complex(each.index.at([wavelength])[0]) ** 2
            made += each.population.share * (own - matrix)
        return made

    def largest_index(self, wavelengths) -> float:
        """Largest real index of all matter. [nm] -> [-]"""
        indices = [self.binder, *(each.index for each in self.pigments)]
        return float(max(np.max(np.real(each.at(wavelengths))) for each in indices))
