"""What a paint is made of, as data: layers of binder with flakes and pigments on a substrate.

Lengths have their unit in their names; angles are radians. Spectra and indices are functions of the wavelength in nm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ..optical_constants.curves import Curve, Index, Spectrum
from ..scene.scattering import ScatterTable

MEAN_TILT = math.sqrt(math.pi / 2.0)
"""Mean tilt of normals with Gaussian slopes, times the standard deviation of the slope per axis (small tilts). [-]"""

RMS_TILT = math.sqrt(2.0)
"""Root mean square tilt, likewise. [-]"""

LIKELY = 1.2815515655446004
"""Standard deviations below and above which a tenth of a normal distribution lies each. [-]"""


@dataclass(frozen=True)
class Binder:
    """What holds the particles of a layer.

    Parameters
    ----------
    index : Index    Of which the real part bends light, and the imaginary one absorbs it. [-]
    absorption : Spectrum    Beside the index's, along the way of light. [1/um]
    density : float    [g/cm3]
    """

    index: Index
    absorption: Spectrum
    density: float = 1.0

    def absorption_at(self, wavelengths) -> np.ndarray:
        """Absorption with that of the index. (w,) [nm] -> (w,) [1/um]"""
        wavelengths = np.asarray(wavelengths, np.float64)
        inner = 4.0 * np.pi * np.imag(self.index.at(wavelengths)) / (wavelengths * 1e-3)
        return self.absorption.at(wavelengths) + inner


@dataclass(frozen=True)
class Amount:
    """How much of some particles is in a dry layer.

    Parameters
    ----------
    kind : str    ``binder_mass_ratio``, ``mass_fraction``, ``volume_fraction`` or ``area_per_volume_per_um``.
    value : float    [-], of the last [1/um]
    """

    kind: str
    value: float


@dataclass(frozen=True)
class Diameters:
    """Log-normal diameters.

    Parameters
    ----------
    median_um : float    By number. [um]
    log_spread : float    Standard deviation of ln d. [-]
    """

    median_um: float
    log_spread: float = 0.0

    @staticmethod
    def of_mass(low_um: float, middle_um: float, high_um: float, power: int = 2) -> Diameters:
        """Diameters below which 10, 50 and 90 % of the mass lie.

        Parameters
        ----------
        power : int    With which the mass of one goes with its diameter: 2 flakes of one thickness, 3 spheres.
        """
        spread = math.log(high_um / low_um) / (2.0 * LIKELY)
        return Diameters(middle_um * math.exp(-power * spread**2), spread)

    def moment_um(self, power: float) -> float:
        """Mean of a power of the diameter. [um ** power]"""
        return self.median_um**power * math.exp(0.5 * (power * self.log_spread) ** 2)

    @property
    def face_um2(self) -> float:
        """Mean area of a face, by number. [um2]"""
        return 0.25 * math.pi * self.moment_um(2.0)


@dataclass(frozen=True)
class Mirror:
    """A flake that reflects, and perhaps lets pass, a stated share at all angles.

    Parameters
    ----------
    reflectance, transmittance : Spectrum    Together 1 at most. [-]
    """

    reflectance: Spectrum
    transmittance: Spectrum


@dataclass(frozen=True)
class Film:
    """A sheet of one matter.

    Parameters
    ----------
    index : Index    [-]
    thickness_nm : float
    """

    index: Index
    thickness_nm: float


@dataclass(frozen=True)
class Stack:
    """Sheets of a flake that light passes and that interferes in them.

    Parameters
    ----------
    core : Film
    coatings : tuple of Film    On both faces, from the core outwards.
    thickness_spread : float    Standard deviation of the core's thickness from flake to flake, relative. [-]
    """

    core: Film
    coatings: tuple[Film, ...] = ()
    thickness_spread: float = 0.0

    @property
    def thickness_nm(self) -> float:
        """Of the whole flake."""
        return self.core.thickness_nm + 2.0 * sum(each.thickness_nm for each in self.coatings)


@dataclass(frozen=True)
class Flakes:
    """Flakes that are alike in kind.

    Parameters
    ----------
    optics : Mirror or Stack
    amount : Amount
    slope : float    Standard deviation of their slopes per axis. [-]
    density : float    [g/cm3]
    thickness_nm : float    By which volumes become areas.
    diameters : Diameters or None    None: so large that it does not count.
    name : str
    """

    optics: Mirror | Stack
    amount: Amount
    slope: float
    density: float
    thickness_nm: float
    diameters: Diameters | None = None
    name: str = ""


@dataclass(frozen=True)
class Grains:
    """Spheres that scatter after Mie.

    Parameters
    ----------
    index : Index    n + i k. [-]
    diameters : Diameters
    amount : Amount
    density : float    [g/cm3]
    name : str
    """

    index: Index
    diameters: Diameters
    amount: Amount
    density: float
    name: str = ""


@dataclass(frozen=True)
class Medium:
    """Pigment of which extinction, albedo and phase function are given.

    Parameters
    ----------
    extinction : Spectrum    [1/um]
    albedo : Spectrum    Of one encounter. [-]
    asymmetry : float    Of Henyey's and Greenstein's phase function, where no other is given. [-]
    phase : Curve or None    Phase function of any scale over the angle in radians.
    name : str
    """

    extinction: Spectrum
    albedo: Spectrum
    asymmetry: float = 0.0
    phase: Curve | None = None
    name: str = ""


Pigment = Grains | Medium


@dataclass(frozen=True)
class Layer:
    """A layer of a paint.

    Parameters
    ----------
    thickness_um : float
    binder : Binder
    flakes : tuple of Flakes
    pigments : tuple of Pigment
    name : str
    """

    thickness_um: float
    binder: Binder
    flakes: tuple[Flakes, ...] = ()
    pigments: tuple[Pigment, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class Paint:
    """A paint on its substrate.

    Parameters
    ----------
    layers : tuple of Layer    The outermost first.
    substrate : Spectrum or ScatterTable
        Reflectance of a matt one, or a table of what it scatters, both of light inside the innermost layer.
    orange_peel : float    Standard deviation of the slope per axis of long waves of the whole film; 0: smooth. [-]
    name, description, source : str
    content : dict    The description in JSON that it was made of.
    """

    layers: tuple[Layer, ...]
    substrate: Spectrum | ScatterTable
    orange_peel: float = 0.0
    name: str = ""
    description: str = ""
    source: str = ""
    content: dict = field(default_factory=dict, compare=False)


def volume_fractions(layer: Layer) -> list[float]:
    """Share of the layer's volume that is each of its flakes, then each of its grains; 0 of a `Medium`. [-]

    Amounts of mass are all of the dry layer: with a mass m for each gram of binder and the density rho of each, the share is
    (m / rho) / (sum of all m / rho + 1 / rho of the binder). Shares of volume are taken off beforehand.

    Raises
    ------
    ValueError    The shares leave no binder.
    """
    parts = [(each.amount, each.density, each) for each in layer.flakes]
    parts += [
        (each.amount, each.density, each) if isinstance(each, Grains) else None
        for each in layer.pigments
    ]
    parts_of_mass = [each for each in parts if each and each[0].kind == "mass_fraction"]
    fraction = sum(amount.value for amount, _, _ in parts_of_mass)
    by_ratio = sum(each[0].value for each in parts if each and each[0].kind == "binder_mass_ratio")
    if fraction >= 1.0:
        raise ValueError("the mass fractions leave no binder")
    # Mass of all for each gram of binder: 1 + ratios + fractions of the whole.
    whole = (1.0 + by_ratio) / (1.0 - fraction)
    volumes, taken = [], []
    for each in parts:
        volume = share = 0.0
        if each is not None:
            amount, density, part = each
            match amount.kind:
                case "binder_mass_ratio":
                    volume = amount.value / density
                case "mass_fraction":
                    volume = amount.value * whole / density
                case "volume_fraction":
                    share = amount.value
                case _:
                    share = amount.value * part.thickness_nm * 1e-3
        volumes.append(volume)
        taken.append(share)
    rest = 1.0 - sum(taken)
    if rest <= 0.0:
        raise ValueError("the volumes of its particles leave no binder")
    total = sum(volumes) + 1.0 / layer.binder.density
    return [share + rest * volume / total for share, volume in zip(taken, volumes, strict=True)]


def face_densities(layer: Layer) -> list[float]:
    """Area of one face of each kind of flakes by volume of the layer. [1/um]"""
    shares = volume_fractions(layer)[: len(layer.flakes)]
    return [
        share / (each.thickness_nm * 1e-3) for share, each in zip(shares, layer.flakes, strict=True)
    ]
