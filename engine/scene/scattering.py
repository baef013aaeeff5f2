"""Measured scattering as pure data: tables, matrices and trees of reflectance and transmittance by pairs of directions.

Directions are unit vectors in a frame whose +z is the normal of the lit side; both point away from the surface. ``wi``
points to where the light comes from, ``wo`` to where it goes; of light that passes, ``wo`` is taken with its z turned up.
On the back of a surface x and y stay what they are in front, and z is turned up.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np


class _Kept:
    """Data whose arrays cannot be written to, so that what follows from them is found once (see `memo`)."""

    def __post_init__(self):
        for field in fields(self):
            array = getattr(self, field.name)
            if isinstance(array, np.ndarray) and array.flags.writeable:
                array = array.view()
                array.flags.writeable = False
                object.__setattr__(self, field.name, array)

    def arrays(self) -> tuple[np.ndarray, ...]:
        """All arrays, those of parts included."""
        found = []
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                found.append(value)
            elif isinstance(value, _Kept):
                found.extend(value.arrays())
        return tuple(found)


class _Scattering(_Kept):
    """What scatters light, by pairs of directions."""

    is_isotropic = False
    """Whether a turn of the sample about its normal changes nothing."""

    has_direct = False
    """Whether some light is reflected as by a mirror, or passes straight."""


@dataclass(frozen=True, eq=False)
class ScatterTable(_Scattering):
    """Scattering on an irregular grid about the direction in which a mirror reflects, or in which light passes straight.

    With the incidence in the xz-plane, wi = (sin s, 0, cos s), the centre is c = (-sin s, 0, cos s), and the direction at
    the angle t from it with the azimuth a is

        wo = cos t c + sin t (cos a h + sin a y),    h = (-cos s, 0, -sin s),  y = (0, 1, 0)

    so a = 0 is the side of the horizon and a = pi that of the normal. Between grid points values are linear in each of
    rotation, incidence, radial angle, azimuth and wavelength; beyond the first and last of each the end holds; below the
    horizon nothing is scattered.

    Parameters
    ----------
    rotations : (p,) float64 array
        Azimuths of wi about the normal from +x, ascending within [0, 2 pi); periodic. One entry: the same for all. Of an
        orthotropic surface from 0 to pi / 2. [rad]
    incidences : (s,) float64 array    Angles of wi to the normal, strictly ascending within [0, pi / 2]. [rad]
    radials : (t,) float64 array    Angles from the centre, strictly ascending from 0 to pi at most. [rad]
    azimuths : (a,) float64 array
        About the centre, strictly ascending: from 0 to pi where both sides of the plane of incidence are alike, else from
        0 to 2 pi. [rad]
    wavelengths : (w,) float64 array    Strictly ascending; one entry: the same at all. [nm]
    values : (p, s, t, a, w) float32 array    BRDF or BTDF, without any cosine. [1/sr]
    direct : (p, s, w) float32 array or None    Share of light reflected as by a mirror, or that passes straight. [-]
    error : float
        Stated error of the values against what they were made from: root mean square, relative to the value plus a
        twentieth of the largest albedo over pi, over light from everywhere to everywhere or over directions crowded about
        the centre, whichever is larger; 0: none is known. [-]
    is_orthotropic : bool
        Whether the surface looks the same in a mirror along x and in one along y, as brushed or woven ones do: its rotations
        are those of a quarter, and the others follow.
    """

    rotations: np.ndarray
    incidences: np.ndarray
    radials: np.ndarray
    azimuths: np.ndarray
    wavelengths: np.ndarray
    values: np.ndarray
    direct: np.ndarray | None = None
    error: float = 0.0
    is_orthotropic: bool = False

    @property
    def is_isotropic(self) -> bool:
        """Whether a turn of the sample about its normal changes nothing."""
        return len(self.rotations) == 1

    @property
    def has_direct(self) -> bool:
        """Whether some light is reflected as by a mirror, or passes straight."""
        return self.direct is not None and bool(self.direct.any())


@dataclass(frozen=True, eq=False)
class PatchBasis(_Kept):
    """A hemisphere cut into rings and these into patches, counted from the pole outwards, each ring from +x to +y.

    Patch j of a ring with n patches spans the azimuths 2 pi (j - 1/2) / n to 2 pi (j + 1/2) / n.

    Parameters
    ----------
    bounds : (r + 1,) float64 array    Polar angles between rings, ascending from 0 to pi / 2. [rad]
    counts : (r,) int32 array    Patches of each ring.
    """

    bounds: np.ndarray
    counts: np.ndarray


@dataclass(frozen=True, eq=False)
class PatchMatrix(_Scattering):
    """Scattering that is constant over pairs of patches (Klems).

    Parameters
    ----------
    incoming, outgoing : PatchBasis    Of wi and wo.
    wavelengths : (w,) float64 array    As of `ScatterTable`. [nm]
    values : (i, o, w) float32 array    BRDF or BTDF for light from patch i to patch o. [1/sr]
    """

    incoming: PatchBasis
    outgoing: PatchBasis
    wavelengths: np.ndarray
    values: np.ndarray


@dataclass(frozen=True, eq=False)
class TensorTree(_Scattering):
    """Scattering that is constant over the leaves of a tree that halves all coordinates at once.

    Of rank 4 the coordinates are (in x, in y, out x, out y) on the unit square, to which Shirley's and Chiu's map brings
    the disk of the directions' x and y; of rank 3 (isotropic) they are (in, out x, out y) with in = (1 - sin of the angle of
    incidence) / 2, and the outgoing direction is turned about the normal so that -wi has the azimuth 0.

    Parameters
    ----------
    rank : int    3 or 4.
    children : (n, 2 ** rank) int32 array
        Of each node, the root first; bit i of a child's number is set where it is the upper half of coordinate i. A number
        from 0 on is a node, one below stands for the value ``-1 - number``.
    wavelengths : (w,) float64 array    As of `ScatterTable`. [nm]
    values : (v, w) float32 array    BRDF or BTDF. [1/sr]
    """

    rank: int
    children: np.ndarray
    wavelengths: np.ndarray
    values: np.ndarray

    @property
    def is_isotropic(self) -> bool:
        """Whether a turn of the sample about its normal changes nothing."""
        return self.rank == 3


Scatter = ScatterTable | PatchMatrix | TensorTree


@dataclass(frozen=True, eq=False)
class Sparkle(_Kept):
    """Flakes of one kind in a surface, of which an eye that is near sees one by one what they mirror.

    What they mirror once, ``first_order``, is a part of the surface's table. Where the camera looks straight at the surface
    it is multiplied by a random factor of mean 1 that tells which of the flakes in sight face the light: see
    `scattering.data.flake_field`.

    Parameters
    ----------
    first_order : ScatterTable    On the same axes as the surface's reflection, and nowhere more. [1/sr]
    density : float    Flakes by area of the surface, as many as there would be if all were lit and seen alike. [1/m2]
    slope : float    Standard deviation of the flakes' slopes per axis, which are Gaussian. [-]
    blur : float    Standard deviation per axis by which one flake alone spreads the slopes of what it mirrors. [-]
    log_spread : float    Standard deviation of the logarithm of the diameters. [-]
    index : float    Refractive index of what the flakes lie in. [-]
    """

    first_order: ScatterTable
    density: float
    slope: float
    blur: float
    log_spread: float = 0.0
    index: float = 1.5
