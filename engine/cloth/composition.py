"""What a cloth is made of, as data: yarns, how they are woven, and a pile on them.

Lengths have their unit in their names; angles are radians; spectra are functions of the wavelength in nm. The warp runs
along y, the weft along x, the front is +z.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from ..optical_constants.curves import Index, Spectrum
from ..paint.composition import Diameters


@dataclass(frozen=True)
class Scatterers:
    """Spheres in the matter of a thread that scatter after Mie.

    Parameters
    ----------
    index : Index    n + i k. [-]
    diameters : Diameters
    volume_fraction : float    Of the thread. [-]
    """

    index: Index
    diameters: Diameters
    volume_fraction: float


@dataclass(frozen=True)
class Yarn:
    """A thread of elliptic section.

    Parameters
    ----------
    width_mm, height_mm : float    Axes of the section, along the cloth and across it.
    index : float    Of the matter between the scatterers. [-]
    roughness : float    alpha of the surface (GGX); 0: smooth. [-]
    scatterers : tuple of Scatterers
    absorption : Spectrum    Of the matter with its dye. [1/mm]
    """

    width_mm: float
    height_mm: float
    index: float
    roughness: float
    scatterers: tuple[Scatterers, ...]
    absorption: Spectrum

    @property
    def radius_mm(self) -> float:
        """Radius of the round thread with the same mean way of light: twice the section's area over its circumference."""
        a, b = 0.5 * self.width_mm, 0.5 * self.height_mm
        # Ramanujan's second formula, 4e-5 off at an axis ratio of 5.
        h = ((a - b) / (a + b)) ** 2
        around = math.pi * (a + b) * (1.0 + 3.0 * h / (10.0 + math.sqrt(4.0 - 3.0 * h)))
        return 2.0 * math.pi * a * b / around


@dataclass(frozen=True, eq=False)
class Weave:
    """How warp and weft cross.

    Parameters
    ----------
    is_warp_up : (i, j) bool array    At end i of the warp and pick j of the weft, of one repeat.
    warp_pitch_mm, weft_pitch_mm : float    From one end, and from one pick, to the next.
    is_orthotropic : bool    Whether the cloth looks the same in mirrors along both of its yarns.
    turns_back : bool    Whether it looks the same after half a turn.
    """

    is_warp_up: np.ndarray
    warp_pitch_mm: float
    weft_pitch_mm: float
    is_orthotropic: bool = False
    turns_back: bool = False


@dataclass(frozen=True)
class Pile:
    """Ends of yarn that stand on the front.

    Parameters
    ----------
    yarn : Yarn
    height_mm : float    Above the middle of the ground.
    density_per_mm2 : float
    lean : float    From the normal, along the warp. [rad]
    """

    yarn: Yarn
    height_mm: float
    density_per_mm2: float
    lean: float = 0.0


@dataclass(frozen=True)
class Cloth:
    """A cloth.

    Parameters
    ----------
    warp, weft : Yarn
    weave : Weave
    pile : Pile or None
    name, description, source : str
    content : dict    The description in JSON that it was made of.
    """

    warp: Yarn
    weft: Yarn
    weave: Weave
    pile: Pile | None = None
    name: str = ""
    description: str = ""
    source: str = ""
    content: dict = field(default_factory=dict, compare=False)

    @property
    def yarns(self) -> tuple[Yarn, ...]:
        """Warp, weft, and that of the pile if there is one."""
        return (
            (self.warp, self.weft) if self.pile is None else (self.warp, self.weft, self.pile.yarn)
        )
