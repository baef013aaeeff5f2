"""Materials as pure data: a tree of surfaces with spectra and textures at its leaves."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .scattering import Scatter
from .spectrum import Constant, Spectrum
from .texture import ImageTexture

Colour = Spectrum | ImageTexture
"""A quantity per wavelength that may vary over the surface."""

Scalar = float | ImageTexture
"""A plain number that may vary over the surface (one-channel texture)."""


@dataclass(frozen=True)
class Cauchy:
    """Refractive index n(lambda) = a + b / lambda^2 with lambda in micrometres; ``b`` = 0 means no dispersion. [-]"""

    a: float = 1.5
    b: float = 0.0


@dataclass(frozen=True, eq=False)
class IorTable:
    """Measured refractive index. ``wavelengths`` (n,) [nm] strictly ascending, ``values`` (n,) [-]."""

    wavelengths: np.ndarray
    values: np.ndarray


RefractiveIndex = Cauchy | IorTable


@dataclass(frozen=True)
class Diffuse:
    """Lambertian reflection of both sides and, if given, Lambertian transmission; their sum must not exceed 1."""

    reflectance: Colour = Constant(0.5)
    transmittance: Colour | None = None


@dataclass(frozen=True)
class Coated:
    """A diffuse base under a clear dielectric coat (varnish, plastic, gloss paint).

    ``roughness`` is Blender's: the microfacet alpha is its square. ``specular`` scales the coat's reflection.
    """

    reflectance: Colour = Constant(0.5)
    ior: float = 1.5
    roughness: float = 0.5
    specular: float = 1.0


@dataclass(frozen=True)
class Glossy:
    """Metal-like reflection with a constant reflectance (no Fresnel term). ``roughness`` as in `Coated`."""

    reflectance: Colour = Constant(0.8)
    roughness: Scalar = 0.5


@dataclass(frozen=True)
class Conductor:
    """A metal by the name of its complex refractive index in `libraries/spectra/conductors.csv`."""

    metal: str = "Al"
    roughness: float = 0.1


@dataclass(frozen=True)
class Dielectric:
    """A solid transparent body: refracts at its boundary. ``tint`` multiplies what is transmitted per crossing."""

    ior: RefractiveIndex = Cauchy(1.5)
    roughness: float = 0.0
    tint: Colour = Constant(1.0)


@dataclass(frozen=True)
class ThinGlass:
    """A pane modelled as one surface: no refraction, both faces reflect, light passes straight through.

    ``transmittance`` is that of the glass body alone at normal incidence (without the losses at the two faces).
    """

    ior: float = 1.5
    transmittance: Colour = Constant(1.0)


@dataclass(frozen=True, eq=False)
class TabulatedPane:
    """A clear pane known by its data sheet: transmittance and reflectance by angle, the same from both sides.

    Parameters
    ----------
    angles : (n,) float64 array    To the normal, strictly ascending; beyond the last the last value holds. [deg]
    transmittance, reflectance : (n,) float64 array    Linear in the angle between; their sum must not exceed 1. [-]
    """

    angles: np.ndarray
    transmittance: np.ndarray
    reflectance: np.ndarray


@dataclass(frozen=True)
class Transparent:
    """Nothing there: light passes straight on, times ``transmittance``; 1 marks an opening that daylight enters by."""

    transmittance: Colour = Constant(1.0)


@dataclass(frozen=True)
class Black:
    """Absorbs everything."""


@dataclass(frozen=True, eq=False)
class Measured:
    """A surface known by what was measured or computed of its scattering, side by side; None: nothing.

    Parameters
    ----------
    front_reflection, back_reflection : Scatter or None    Of light that comes to that side.
    front_transmission, back_transmission : Scatter or None    Of light that comes to that side and leaves by the other.
    rotation : float    By which the sample is turned about the normal, from the surface's U to its V. [rad]
    factor : float    On everything, for studies of how much a result depends on it. [-]
    """

    front_reflection: Scatter | None = None
    back_reflection: Scatter | None = None
    front_transmission: Scatter | None = None
    back_transmission: Scatter | None = None
    rotation: float = 0.0
    factor: float = 1.0


@dataclass(frozen=True)
class Mix:
    """``factor`` 0 gives ``first``, 1 gives ``second``."""

    first: Surface
    second: Surface
    factor: Scalar = 0.5


Surface = (
    Diffuse
    | Coated
    | Glossy
    | Conductor
    | Dielectric
    | ThinGlass
    | TabulatedPane
    | Transparent
    | Black
    | Measured
    | Mix
)


@dataclass(frozen=True)
class Emission:
    """Lambertian emission of a surface.

    Parameters
    ----------
    spectrum : Spectrum    Relative spectral power.
    luminance : float    Of the surface, in every direction. [cd/m2]
    pattern : ImageTexture or None
        Factor on the luminance by place; its Rec. 709 luminance is used and its colour with it.
    two_sided : bool    Both sides emit (Blender's meaning) or only the side that the normal points to.
    """

    spectrum: Spectrum = Constant(1.0)
    luminance: float = 0.0
    pattern: ImageTexture | None = None
    two_sided: bool = True


@dataclass(frozen=True)
class Material:
    """What a mesh is made of. ``id`` is stable and unique; ``index`` is the user's number for the index pass."""

    id: str
    name: str
    surface: Surface = field(default_factory=Diffuse)
    emission: Emission | None = None
    index: int = 0
