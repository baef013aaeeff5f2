"""Which way the pixels of a picture look, and the solid angles that they see."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..errors import SceneError


class Mapping(Enum):
    """How angles to the axis become places on a picture."""

    PERSPECTIVE = "perspective"
    EQUIRECTANGULAR = "equirectangular"
    EQUIDISTANT = "equidistant fisheye"
    EQUISOLID = "equisolid fisheye"
    ORTHOGRAPHIC = "orthographic fisheye"  # Radiance's hemispherical view


@dataclass(frozen=True)
class PictureView:
    """The view of a picture, whose own axes are x to the right, y up and z backwards.

    Parameters
    ----------
    mapping : Mapping
    width, height : int    [pixel]
    extent : (float, float)
        Of the picture: at unit distance for perspective [-], longitude and latitude [rad], angles for equidistant [rad],
        over the focal length for equisolid, twice the sine of the angle for orthographic. [-]
    shift : (float, float)    Of its middle against the axis, in the same measure.
    field : float    Full angle of what a fisheye sees. [rad]
    """

    mapping: Mapping
    width: int
    height: int
    extent: tuple[float, float]
    shift: tuple[float, float] = (0.0, 0.0)
    field: float = 2.0 * np.pi

    def __post_init__(self):
        numbers = np.array([*self.extent, *self.shift, self.field])
        if not np.isfinite(numbers).all() or min(*self.extent, self.field) <= 0.0:
            raise SceneError("the view of the picture needs extents and a field above 0")

    @classmethod
    def of_angles(cls, mapping: Mapping, width: int, height: int, across: float, along: float):
        """Return the view that spans full angles across and along the picture. [rad]

        Raises
        ------
        SceneError    The angles are not above 0, or more than the mapping holds.
        """
        most = np.pi if mapping in {Mapping.PERSPECTIVE, Mapping.ORTHOGRAPHIC} else 2.0 * np.pi
        is_open = mapping is Mapping.PERSPECTIVE
        for angle in (across, along):
            if not 0.0 < angle <= most * (1.0 + 1e-9) or (is_open and angle >= most):
                raise SceneError(
                    f"a view of {np.degrees(angle):g} degrees is not possible in a picture that is {mapping.value}"
                )
        half = np.array([across, along]) / 2.0
        extent = {
            Mapping.PERSPECTIVE: 2.0 * np.tan(half),
            Mapping.EQUISOLID: 4.0 * np.sin(half / 2.0),
            Mapping.ORTHOGRAPHIC: 2.0 * np.sin(half),
        }.get(mapping, 2.0 * half)
        return cls(mapping, width, height, tuple(map(float, extent)), field=max(across, along))

    def directions(self, x, y) -> tuple[np.ndarray, np.ndarray]:
        """Directions in which places of the picture look.

        Parameters
        ----------
        x, y : array    From the lower left corner; pixels have their centres at halves. [pixel]

        Returns
        -------
        directions : (..., 3) float64 array    Of unit length.
        seen : (...) bool array    Whether the place lies in the field.
        """
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        u = (x / self.width - 0.5) * self.extent[0] + self.shift[0]
        v = (y / self.height - 0.5) * self.extent[1] + self.shift[1]
        if self.mapping is Mapping.PERSPECTIVE:
            made = np.stack([u, v, -np.ones_like(u)], axis=-1)
            return made / np.linalg.norm(made, axis=-1, keepdims=True), np.ones(u.shape, bool)
        if self.mapping is Mapping.EQUIRECTANGULAR:
            flat = np.cos(v)
            made = np.stack([np.sin(u) * flat, np.sin(v), -np.cos(u) * flat], axis=-1)
            return made, np.abs(v) <= 0.5 * np.pi * (1.0 + 1e-12)
        radius = np.hypot(u, v)
        # What lies beyond the rim is put onto it, so that pixels there have the solid angle of their inner part.
        angle = {
            Mapping.EQUIDISTANT: lambda: radius,
            Mapping.EQUISOLID: lambda: 2.0 * np.arcsin(np.minimum(0.5 * radius, 1.0)),
            Mapping.ORTHOGRAPHIC: lambda: np.arcsin(np.minimum(radius, 1.0)),
        }[self.mapping]()
        whole = {Mapping.EQUISOLID: 2.0, Mapping.ORTHOGRAPHIC: 1.0}.get(self.mapping, np.inf)
        share = np.divide(np.sin(angle), radius, out=np.ones_like(radius), where=radius > 0.0)
        made = np.stack([share * u, share * v, -np.cos(angle)], axis=-1)
        return made, (angle <= 0.5 * self.field * (1.0 + 1e-12)) & (radius <= whole)

    def pixels(self) -> tuple[np.ndarray, np.ndarray]:
        """Directions of all pixels' centres and the solid angles that they see.

        Returns
        -------
        directions : (h, w, 3) float64 array    Row 0 is the bottom row.
        solid_angles : (h, w) float64 array    0 where the picture shows nothing. [sr]
        """
        columns, rows = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
        made, seen = self.directions(columns, rows)
        edges = np.meshgrid(np.arange(self.width + 1.0), np.arange(self.height + 1.0))
        corners, _ = self.directions(*edges)
        quads = corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]
        solid = _triangle(*quads[:3]) + _triangle(quads[0], *quads[2:])
        return np.where(seen[..., None], made, 0.0), np.where(seen, solid, 0.0)


def _triangle(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Solid angles of triangles of unit vectors (..., 3). [sr]

    A. van Oosterom, J. Strackee: The solid angle of a plane triangle, IEEE Transactions on Biomedical Engineering 30, 1983
    """
    volume = np.abs(np.einsum("...i,...i", a, np.cross(b, c)))
    ab, bc, ca = (np.einsum("...i,...i", *pair) for pair in ((a, b), (b, c), (c, a)))
    return 2.0 * np.arctan2(volume, 1.0 + ab + bc + ca)
