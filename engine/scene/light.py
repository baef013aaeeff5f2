"""Lights as pure data. What a light emits is a quantity with a unit (`Output`); shape and place are separate."""

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from .distribution import IntensityDistribution, Opening
from .ray_emission import RayEmission
from .spectrum import Constant, Spectrum
from .texture import ImageTexture


class Quantity(Enum):
    """What the value of an `Output` means."""

    LUMINOUS_FLUX = "luminous_flux"  # lm, total emitted
    LUMINOUS_INTENSITY = "luminous_intensity"  # cd, on the axis
    ILLUMINANCE = "illuminance"  # lx, at 1 m on the axis; sun: on a plane facing it
    LUMINANCE = "luminance"  # cd/m2, area lights
    RADIANT_FLUX = (
        "radiant_flux"  # W within 360..830 nm, total emitted; sun: W/m2 on a plane facing it
    )


@dataclass(frozen=True)
class Output:
    """How much light: a quantity, its value in SI units, and the relative spectrum it is distributed over."""

    quantity: Quantity
    value: float
    spectrum: Spectrum = Constant(1.0)


class Light:
    """What gives light. Each kind has an ``id``, a ``name`` and an ``output``."""

    @property
    def fault(self) -> str:
        """What is wrong with its numbers, empty if nothing is."""
        return ""


class PlacedLight(Light):
    """Light that stands somewhere: with a ``place`` and a ``reach``."""


class _Positioned(PlacedLight):
    """Light at a ``position`` with a ``radius``."""

    @property
    def place(self) -> np.ndarray:
        """Where it stands. (3,) [m]"""
        return np.asarray(self.position, dtype=np.float64)

    @property
    def reach(self) -> float:
        """Radius of a sphere about the place that holds its body. [m]"""
        return float(self.radius)


class _Framed(PlacedLight):
    """Light in a ``frame``."""

    @property
    def place(self) -> np.ndarray:
        """Where it stands. (3,) [m]"""
        return np.asarray(self.frame, dtype=np.float64)[:3, 3]


@dataclass(frozen=True, eq=False)
class PointLight(_Positioned):
    """Sphere of uniform luminance (``radius`` > 0) or point (``radius`` = 0). [m]"""

    id: str
    name: str
    output: Output
    position: np.ndarray
    radius: float = 0.0
    visible_to_camera: bool = True


@dataclass(frozen=True, eq=False)
class SpotLight(_Positioned):
    """Point of constant intensity inside a cone, with a smoothstep edge as Blender draws it.

    ``half_angle`` [rad] is where the light ends; ``blend`` 0..1 is the share of the cone taken by the soft edge;
    ``radius`` [m] spreads the source over a disk for soft shadows. ``direction`` is the beam's axis, unit length.
    """

    id: str
    name: str
    output: Output
    position: np.ndarray
    direction: np.ndarray
    half_angle: float
    blend: float = 0.0
    radius: float = 0.0


@dataclass(frozen=True, eq=False)
class SunLight(Light):
    """Parallel light, or a disk at infinity.

    Parameters
    ----------
    direction : (3,) array    The way light travels.
    angle : float    Angular diameter. [rad]
    limb_darkening : float    Part of the middle's luminance that the edge lacks, 0 to 1; the true sun has some 0.6. [-]
    """

    id: str
    name: str
    output: Output
    direction: np.ndarray
    angle: float = 0.0
    limb_darkening: float = 0.0

    @property
    def fault(self) -> str:
        """As of `Light`."""
        if 0.0 <= self.limb_darkening <= 1.0:
            return ""
        return f"its limb darkening is {self.limb_darkening:g}, expected 0 to 1"


@dataclass(frozen=True, eq=False)
class AreaLight(_Framed):
    """One-sided Lambertian rectangle or ellipse.

    Parameters
    ----------
    frame : (4, 4) float64 array    Rigid placement: emits along local -z, sides along local x and y. [m]
    size_x, size_y : float    Full width and height (or diameters). [m]
    shape : str    ``rectangle`` or ``ellipse``.
    spread : float    Blender's beam spread; pi is Lambertian. [rad]
    """

    id: str
    name: str
    output: Output
    frame: np.ndarray
    size_x: float
    size_y: float
    shape: str = "rectangle"
    spread: float = np.pi
    visible_to_camera: bool = True

    @property
    def area(self) -> float:
        """Luminous area. [m2]"""
        area = self.size_x * self.size_y
        return area * np.pi / 4.0 if self.shape == "ellipse" else area

    @property
    def reach(self) -> float:
        """Radius of a sphere about the place that holds its body. [m]"""
        return 0.5 * float(np.hypot(self.size_x, self.size_y))


@dataclass(frozen=True, eq=False)
class LineLight(_Framed):
    """Straight tube of uniform luminance whose curved side shines by the cosine law; its ends are dark.

    Parameters
    ----------
    frame : (4, 4) float64 array    Rigid placement of its middle; the tube lies along local x. [m]
    length, radius : float    Above 0. [m]
    """

    id: str
    name: str
    output: Output
    frame: np.ndarray
    length: float
    radius: float
    visible_to_camera: bool = True

    @property
    def fault(self) -> str:
        """As of `Light`."""
        if min(self.length, self.radius) > 0.0:
            return ""
        return f"its tube has a length of {self.length:g} m and a radius of {self.radius:g} m, expected both above 0"

    @property
    def area(self) -> float:
        """Luminous area. [m2]"""
        return 2.0 * np.pi * self.radius * self.length

    @property
    def reach(self) -> float:
        """Radius of a sphere about the place that holds its body. [m]"""
        return float(np.hypot(0.5 * self.length, self.radius))


@dataclass(frozen=True, eq=False)
class Luminaire(_Framed):
    """Light with a measured or made intensity distribution, from a point or from its luminous opening.

    Seen from afar it gives the distribution, scaled so that its flux is the output's; close by, every part of the opening
    gives its share of it.

    Parameters
    ----------
    output : Output    A luminous or radiant flux: the total emitted.
    frame : (4, 4) float64 array    Rigid placement of the luminaire's axes. [m]
    distribution : IntensityDistribution
    opening : Opening    ``point`` is an ideal point, which no ray can meet.
    rays : RayEmission or None    Of a light from a ray set, whose opening is a point: what shines close by, where it counts.
    """

    id: str
    name: str
    output: Output
    frame: np.ndarray
    distribution: IntensityDistribution
    opening: Opening = Opening()
    visible_to_camera: bool = True
    rays: RayEmission | None = None

    @property
    def reach(self) -> float:
        """Radius of a sphere about the place that holds its body. [m]"""
        return 0.5 * float(np.linalg.norm(self.opening.size))


@dataclass(frozen=True, eq=False)
class Ground:
    """Plane that the lower half of the surroundings lies on, as it was seen from the place where they were taken.

    Rays that meet the plane within a radius about that place see what was seen in the direction from there to where they
    meet it; from half of the radius on that passes into what lies at infinity.

    Parameters
    ----------
    centre : (3,) float64 array    Where the surroundings were seen from, above the plane. World space. [m]
    level : float    Height of the plane, which is level. [m]
    radius : float    [m]
    """

    centre: np.ndarray
    level: float
    radius: float


@dataclass(frozen=True, eq=False)
class Photo:
    """Photo that covers a part of the surroundings: what the camera saw that took it.

    Parameters
    ----------
    image : ImageTexture    Stretched over the film, linear between the middles of its pixels.
    luminance_per_unit : float    Luminance of a pixel whose Rec. 709 luminance is 1. [cd/m2]
    frame : (3, 3) float64 array    Columns: the camera's right, up and backward axis in world space.
    extent_x, extent_y, shift_x, shift_y : float    Of its film, as of a perspective `Camera`. [-]
    """

    image: ImageTexture
    luminance_per_unit: float
    frame: np.ndarray
    extent_x: float
    extent_y: float
    shift_x: float = 0.0
    shift_y: float = 0.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Surroundings:
    """What worlds of all kinds may have besides.

    Parameters
    ----------
    ground : Ground or None    None: all of it is at infinity.
    photo : Photo or None    What covers a part of it, on the ground too.
    """

    ground: Ground | None = None
    photo: Photo | None = None


@dataclass(frozen=True)
class UniformWorld(Surroundings):
    """The same luminance [cd/m2] from every direction; ``seen``: what the camera sees in its place, None: the same."""

    luminance: float
    spectrum: Spectrum = Constant(1.0)
    id: str = "world"
    seen: "World | None" = None


@dataclass(frozen=True, eq=False)
class ImageWorld(Surroundings):
    """Equirectangular picture of the surroundings.

    Parameters
    ----------
    image : ImageTexture
        Pixels are cells, linear between their middles, or even with ``closest``; any transform and extension is ignored.
    luminance_per_unit : float    Luminance of a pixel whose Rec. 709 luminance is 1. [cd/m2]
    rotation : (3, 3) float64 array    From world directions to the directions of the map, where (x, y, z) is looked up at
        u = 0.5 - atan2(y, x) / (2 pi), v = atan2(z, hypot(x, y)) / pi + 0.5 (Blender's own mapping).
    seen : World or None    What the camera sees in its place; None: the same.
    """

    image: ImageTexture
    luminance_per_unit: float
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    id: str = "world"
    seen: "World | None" = None


@dataclass(frozen=True, eq=False)
class CieSky(Surroundings):
    """Sky without its sun, by one of the luminance distributions of the CIE, over an evenly bright ground.

    Parameters
    ----------
    type : int    1 to 15 of the CIE standard general sky (CIE S 011/E:2003); 16 is the traditional overcast sky.
    towards_sun : (3,) float64 array    Where the sun stands, any length above 0; it shapes the pattern of types 2 to 15
        but 3 and 5. The sun itself is a `SunLight` of its own. World space, +z up.
    illuminance : float    Of an unobstructed horizontal plane by the sky. [lx]
    ground_reflectance : float    Every direction below the horizon has the luminance of a matt ground under this sky:
        reflectance times illuminance over pi. [-]
    spectrum : Spectrum    Relative spectral power of sky and ground.
    seen : World or None    What the camera sees in its place; None: the same.
    """

    type: int
    towards_sun: np.ndarray
    illuminance: float
    ground_reflectance: float = 0.0
    spectrum: Spectrum = Constant(1.0)
    id: str = "world"
    seen: "World | None" = None


@dataclass(frozen=True, eq=False)
class CloudySky(Surroundings):
    """Sky without its sun between the clear and the overcast sky of the CIE (S 003).

    Parameters
    ----------
    cloudiness : float    Part of the illuminance that the overcast sky gives: 0 clear, 1 overcast. [-]
    towards_sun, illuminance, ground_reflectance, spectrum, seen    As of `CieSky`.
    """

    cloudiness: float
    towards_sun: np.ndarray
    illuminance: float
    ground_reflectance: float = 0.0
    spectrum: Spectrum = Constant(1.0)
    id: str = "world"
    seen: "World | None" = None


@dataclass(frozen=True, eq=False)
class PerezSky(Surroundings):
    """Sky without its sun by the all-weather model of Perez (1993).

    Parameters
    ----------
    clearness : float    The model's epsilon, at least 1. [-]
    brightness : float    The model's Delta, above 0. [-]
    towards_sun : (3,) float64 array    Not below the horizon.
    illuminance, ground_reflectance, spectrum, seen    As of `CieSky`.
    """

    clearness: float
    brightness: float
    towards_sun: np.ndarray
    illuminance: float
    ground_reflectance: float = 0.0
    spectrum: Spectrum = Constant(1.0)
    id: str = "world"
    seen: "World | None" = None


FormulaSky = CieSky | CloudySky | PerezSky
"""Skies whose luminance follows a formula."""

World = UniformWorld | ImageWorld | FormulaSky
