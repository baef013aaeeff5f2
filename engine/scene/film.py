"""A clear film on a boundary, so thin that the light of its two faces interferes."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .spectrum import Spectrum


@dataclass(frozen=True)
class Film:
    """A film of even thickness that absorbs nothing.

    Parameters
    ----------
    thickness : float    [nm]
    ior : float    Its refractive index, 1 at least. [-]
    base : Spectrum or None    Real part of the index of a metal below; None: it follows from its colours. [-]
    """

    thickness: float
    ior: float = 1.33
    base: Spectrum | None = None

    def check(self) -> None:
        """Refuse what is no film.

        Raises
        ------
        SceneError    Says what is wrong with it.
        """
        if not 0.0 <= self.thickness < np.inf:
            raise SceneError(f"a film is {self.thickness:g} nm thick, expected 0 or more")
        if not 1.0 <= self.ior < np.inf:
            raise SceneError(f"a film has a refractive index of {self.ior:g}, expected 1 or more")
