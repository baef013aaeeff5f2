"""Materials as pure data: a tree of surfaces with spectra and textures at its leaves."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from ..errors import SceneError
from .colour import Colour, Scalar, largest_of, scale
from .film import Film
from .relief import Relief, layers, picture_of
from .scattering import Scatter, Sparkle
from .spectrum import Constant, Spectrum
from .texture import ImageTexture

SMOOTH_ROUGHNESS = 0.03
"""Below this roughness (microfacet alpha 0.0009) a surface is computed as an ideal mirror."""

BLEND_STEPS = 512
"""Weights of a `Blend` by the cosine, evenly in its root from 0 to 1."""

ROUNDING = 1e-6
"""By which shares that are stated of light may exceed what energy allows. [-]"""


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
class Grain:
    """How facets lie along a direction of the surface.

    Parameters
    ----------
    stretch : float    Width of their distribution along the direction over that without one; across it is the reverse. [-]
    rotation : Scalar    Turns of the direction about the normal. [-]
    axis : int or None    Axis of the object, 0 to 2, about which the direction goes round; None: it goes along U.
    uv_map : str    The UV map that has U; empty: the default one.
    """

    stretch: float = 1.0
    rotation: Scalar = 0.0
    axis: int | None = None
    uv_map: str = ""

    @property
    def largest_stretch(self) -> float:
        """Larger width over that without a direction. [-]"""
        return max(self.stretch, 1.0 / max(self.stretch, 1e-9))

    def check(self) -> None:
        """Refuse what is no direction.

        Raises
        ------
        SceneError    Says what is wrong with it.
        """
        if not 1e-3 <= self.stretch <= 1e3:
            raise SceneError(
                f"facets along a direction are stretched {self.stretch:g} times, expected 0.001 to 1000"
            )
        if self.axis not in {None, 0, 1, 2}:
            raise SceneError(f"facets lie round axis {self.axis}, expected 0, 1 or 2")


class Surface:
    """What becomes of light at a surface.

    A kind of surface says what differs from this: no light passes, all of it is spread out, and nothing depends on the
    wavelength. What makes its plug-in is in `transport.compiled.surfaces.MAKERS`.
    """

    spectra: tuple[str, ...] = ()
    """Fields that say by wavelength how much is reflected or let through."""

    depth = 0
    """How many mixtures lie in each other."""

    is_opaque = True
    """Whether no light passes."""

    passes_straight = False
    """Whether light can pass without changing its direction, so that shadows see through it."""

    is_window = False
    """Whether daylight enters by it, so that samples of the sky are aimed at it: a pane or an opening."""

    is_mirror = False
    """Whether it is an ideal mirror all over and nothing else."""

    is_mirroring_pane = False
    """Whether it is a pane all over and reflects some of the light as a mirror does."""

    is_bending = False
    """Whether it sends light on in single directions other than straight on."""

    is_purely_specular = False
    """Whether it has no spread-out part: nothing to measure illuminance on."""

    is_dispersive = False
    """Whether it refracts light by its wavelength."""

    has_grain = False
    """Whether it has a direction of its own, which follows U."""

    grain: Grain | None = None
    """How its facets lie along a direction; None: they have none."""

    is_absorbing = False
    """Whether it bounds a body that absorbs light on its way inside."""

    has_own_colour = False
    """Whether it depends on the wavelength by more than its ``spectra``."""

    has_relief = False
    """Whether normals by place turn it, which follow U and V."""

    has_sparkle = False
    """Whether the camera sees flakes of it one by one."""

    @property
    def colours(self) -> tuple[Colour, ...]:
        """What its ``spectra`` hold."""
        values = (getattr(self, name) for name in self.spectra)
        return tuple(value for value in values if value is not None)

    @property
    def pictures(self) -> tuple[ImageTexture, ...]:
        """All pictures, in a fixed order."""
        values = [getattr(self, entry.name) for entry in fields(self)]
        if self.grain is not None:
            values.append(self.grain.rotation)
        return tuple(value for value in values if isinstance(value, ImageTexture))

    @property
    def grains(self) -> tuple[Grain, ...]:
        """How all its facets lie that lie along a direction."""
        return () if self.grain is None else (self.grain,)

    @property
    def grain_maps(self) -> tuple[str, ...]:
        """UV maps whose U its facets lie along."""
        return tuple(grain.uv_map for grain in self.grains if grain.axis is None)

    @property
    def largest(self) -> float:
        """Largest sum of what its spectra say. [-]"""
        return sum(map(largest_of, self.colours), 0.0)

    @property
    def as_coated(self) -> Coated | None:
        """The same as a base under a clear coat, whose ``specular`` is 0 without one; None of what is none."""
        return None

    def scaled(self, factor: float) -> Surface | None:
        """Return one that reflects and lets through ``factor`` times as much of what it lacks no law for; None: nothing.

        What follows from a refractive index is not changed: the mirror reflection of coats, panes and metals.
        """
        held = {name: getattr(self, name) for name in self.spectra}
        changed = {name: scale(own, factor) for name, own in held.items() if own is not None}
        return replace(self, **changed) if changed else None


@dataclass(frozen=True)
class Diffuse(Surface):
    """Lambertian reflection of both sides and, if given, Lambertian transmission; their sum must not exceed 1.

    ``roughness``: as ``base_roughness`` of `Coated`, for opaque ones.
    """

    reflectance: Colour = Constant(0.5)
    transmittance: Colour | None = None
    roughness: float = 0.0

    spectra = ("reflectance", "transmittance")

    @property
    def is_opaque(self) -> bool:
        return self.transmittance is None

    @property
    def as_coated(self) -> Coated | None:
        return Coated(self.reflectance, 1.5, 1.0, 0.0, self.roughness) if self.is_opaque else None


@dataclass(frozen=True)
class Coated(Surface):
    """A diffuse base under a clear dielectric coat (varnish, plastic, gloss paint).

    ``roughness`` is Blender's: the microfacet alpha is its square. ``specular`` scales the coat's reflection, and ``tint``
    what it reflects along its normal. ``base_roughness``, from 0 to 1, is how much the facets of the base lie aslant (Oren
    and Nayar's model). ``grain``: of the coat's facets; ``film``: on them.
    """

    reflectance: Colour = Constant(0.5)
    ior: float = 1.5
    roughness: float = 0.5
    specular: float = 1.0
    base_roughness: float = 0.0
    tint: Spectrum | None = None
    grain: Grain | None = None
    film: Film | None = None

    spectra = ("reflectance",)

    @property
    def has_grain(self) -> bool:
        return bool(self.grain_maps)

    @property
    def has_own_colour(self) -> bool:
        return self.film is not None

    @property
    def colours(self) -> tuple[Colour, ...]:
        """What its ``spectra`` hold, and the tint."""
        return super().colours if self.tint is None else (*super().colours, self.tint)

    @property
    def largest(self) -> float:
        """As of `Surface`; the coat takes no light but what the base lacks."""
        return largest_of(self.reflectance)

    @property
    def as_coated(self) -> Coated:
        return self


@dataclass(frozen=True)
class Fabric(Surface):
    """Woven screen, net or perforated sheet: some light passes straight by its openings, the rest is spread evenly.

    All shares are those of the whole fabric for light along its normal, as data sheets have it; slanted light passes less.

    Parameters
    ----------
    openness : float    Share of light that passes straight, from 0 to 1. [-]
    reflectance, transmittance : Colour    Shares that are spread; the sum of all must not exceed 1.
    """

    openness: float = 0.05
    reflectance: Colour = Constant(0.5)
    transmittance: Colour = Constant(0.0)

    spectra = ("reflectance", "transmittance")
    is_opaque = False

    @property
    def passes_straight(self) -> bool:
        return self.openness > 0.0

    is_window = passes_straight

    @property
    def largest(self) -> float:
        return super().largest + self.openness

    def scaled(self, factor: float) -> Fabric:
        return replace(super().scaled(factor), openness=self.openness * factor)

    def check(self) -> None:
        """Refuse shares that would make light.

        Raises
        ------
        SceneError    Says which.
        """
        if not 0.0 <= self.openness <= 1.0:
            raise SceneError(f"a fabric's openness is {self.openness:g}, expected 0 to 1")
        if self.largest > 1.0 + ROUNDING:
            raise SceneError(
                f"a fabric lets through and reflects {self.largest:g} of the light along its normal, more than all of it"
            )


class _MirrorLike(Surface):
    """An ideal mirror where it is smooth, along the direction of its facets and across it."""

    @property
    def is_mirror(self) -> bool:
        if isinstance(self.roughness, ImageTexture) or getattr(self, "film", None) is not None:
            return False
        wider = 1.0 if self.grain is None else np.sqrt(self.grain.largest_stretch)
        return self.roughness * wider < SMOOTH_ROUGHNESS

    is_bending = is_mirror


@dataclass(frozen=True)
class Glossy(_MirrorLike):
    """Metal-like reflection. ``roughness`` as in `Coated`.

    ``edge`` None: the reflectance is the same from all sides. Else it rises towards 1 at grazing angles by Schlick's
    formula, and is ``edge`` times what that gives at 82 degrees (Blender's F82 tint), unless it is an ideal mirror.
    ``grain``: of its facets; ``film``: on a metal that has these colours without it, of pictures the mean.
    """

    reflectance: Colour = Constant(0.8)
    roughness: Scalar = 0.5
    edge: Colour | None = None
    grain: Grain | None = None
    film: Film | None = None

    spectra = ("reflectance",)

    @property
    def has_grain(self) -> bool:
        return bool(self.grain_maps)

    @property
    def has_own_colour(self) -> bool:
        return self.film is not None

    @property
    def colours(self) -> tuple[Colour, ...]:
        """What its ``spectra`` hold, and the tint of its edge."""
        return super().colours if self.edge is None else (*super().colours, self.edge)

    @property
    def largest(self) -> float:
        """As of `Surface`; whatever its edge is, it reflects no more than all."""
        return largest_of(self.reflectance)

    def scaled(self, factor: float) -> Surface | None:
        return super().scaled(factor) if self.film is None else None


@dataclass(frozen=True)
class Conductor(_MirrorLike):
    """A metal by the name of its complex refractive index in `libraries/spectra/conductors.csv`."""

    metal: str = "Al"
    roughness: float = 0.1

    has_own_colour = True


@dataclass(frozen=True)
class Dielectric(Surface):
    """A solid transparent body: refracts at its boundary, and may absorb light on its way inside.

    Parameters
    ----------
    ior : RefractiveIndex
    roughness : float    As in `Coated`.
    tint : Colour    Multiplies what is transmitted per crossing of the boundary. [-]
    internal : Spectrum or None    Transmittance of ``thickness`` of the body, without its boundaries; None: all passes. [-]
    thickness : float    [m]
    reflects : bool    False: all light passes, as in Blender's Refraction BSDF, and none beyond the critical angle.
    mirror_tint : Colour or None    Multiplies what is reflected, as in Blender. [-]
    film : Film or None    On the outside of its boundary, if that reflects.
    """

    ior: RefractiveIndex = Cauchy(1.5)
    roughness: float = 0.0
    tint: Colour = Constant(1.0)
    internal: Spectrum | None = None
    thickness: float = 1.0
    reflects: bool = True
    mirror_tint: Colour | None = None
    film: Film | None = None

    spectra = ("tint",)

    is_opaque = False

    @property
    def colours(self) -> tuple[Colour, ...]:
        """What its ``spectra`` hold, the tint of what is reflected, and what its body lets through."""
        more = (each for each in (self.mirror_tint, self.internal) if each is not None)
        return (*super().colours, *more)

    @property
    def largest(self) -> float:
        """As of `Surface`; whatever its body lets through, none of it is more than there was."""
        tints = (self.tint,) if self.mirror_tint is None else (self.tint, self.mirror_tint)
        return max(map(largest_of, tints))

    def check(self) -> None:
        """Refuse a body that would make light.

        Raises
        ------
        SceneError    Says what is wrong with it.
        """
        if self.internal is None:
            return
        if not 0.0 < self.thickness < np.inf:
            raise SceneError(
                f"internal transmittance is stated for {self.thickness:g} m, expected a length above 0"
            )
        if isinstance(self.internal, ImageTexture) or largest_of(self.internal) > 1.0 + ROUNDING:
            raise SceneError(
                "internal transmittance has to be a spectrum of shares from 0 to 1, the same all over"
            )

    @property
    def has_own_colour(self) -> bool:
        return self.film is not None

    @property
    def is_smooth(self) -> bool:
        """Whether it sends light on in two directions only."""
        return self.roughness < SMOOTH_ROUGHNESS

    is_bending = is_purely_specular = is_smooth

    @property
    def is_absorbing(self) -> bool:
        return self.internal is not None

    @property
    def is_dispersive(self) -> bool:
        return not isinstance(self.ior, Cauchy) or self.ior.b != 0.0


class _Pane(Surface):
    """Lets light pass straight on and mirrors some."""

    is_opaque = False
    passes_straight = is_window = is_purely_specular = True


@dataclass(frozen=True)
class ThinGlass(_Pane):
    """A pane modelled as one surface: no refraction, both faces reflect, light passes straight through.

    ``transmittance`` is that of the glass body alone at normal incidence (without the losses at the two faces).
    """

    ior: float = 1.5
    transmittance: Colour = Constant(1.0)

    spectra = ("transmittance",)

    @property
    def is_mirroring_pane(self) -> bool:
        return self.ior != 1.0

    is_bending = is_mirroring_pane


@dataclass(frozen=True, eq=False)
class TabulatedPane(_Pane):
    """A clear pane known by its data sheet: transmittance and reflectance by angle, the same from both sides.

    Parameters
    ----------
    angles : (n,) float64 array    To the normal, strictly ascending; beyond the last the last value holds. [deg]
    transmittance, reflectance : (n,) float64 array    Linear in the angle between; their sum must not exceed 1. [-]
    """

    angles: np.ndarray
    transmittance: np.ndarray
    reflectance: np.ndarray

    @property
    def is_mirroring_pane(self) -> bool:
        return bool(np.any(np.asarray(self.reflectance) > 0.0))

    is_bending = is_mirroring_pane

    @property
    def largest(self) -> float:
        return float((np.asarray(self.transmittance) + self.reflectance).max())

    def scaled(self, factor: float) -> TabulatedPane:
        return replace(
            self,
            transmittance=np.asarray(self.transmittance) * factor,
            reflectance=np.asarray(self.reflectance) * factor,
        )

    def check(self) -> None:
        """Refuse a table that says nothing or that would make light.

        Raises
        ------
        SceneError    Says what is wrong with it.
        """
        columns = (self.angles, self.transmittance, self.reflectance)
        angles, transmittance, reflectance = (np.asarray(c, dtype=np.float64) for c in columns)
        named = (("angle", angles), ("transmittance", transmittance), ("reflectance", reflectance))
        shapes = [values.shape for _, values in named]
        if angles.ndim != 1 or angles.size == 0 or len(set(shapes)) > 1:
            raise SceneError(
                "a pane's table needs as many angles as transmittances and reflectances, and one at least; "
                f"found {', '.join(' x '.join(map(str, shape)) or 'a number' for shape in shapes)}"
            )
        for name, values in named:
            if not np.isfinite(values).all():
                raise SceneError(f"a pane's table has a {name} that is not a finite number")
        if angles[0] < 0.0 or angles[-1] > 90.0 or np.any(np.diff(angles) <= 0.0):
            raise SceneError("a pane's angles must ascend strictly from 0 to 90 degrees at most")
        for name, values in named[1:]:
            if values.min() < 0.0 or values.max() > 1.0:
                wrong = values[np.argmax(np.abs(values - 0.5))]
                raise SceneError(f"a pane's {name} is {wrong:g}, expected 0 to 1")
        total = transmittance + reflectance
        if total.max() > 1.0 + ROUNDING:
            place = int(np.argmax(total))
            raise SceneError(
                f"a pane transmits and reflects {total[place]:g} of the light at {angles[place]:g} degrees, more than all "
                "of it"
            )


@dataclass(frozen=True)
class Transparent(Surface):
    """Nothing there: light passes straight on, times ``transmittance``; 1 marks an opening that daylight enters by."""

    transmittance: Colour = Constant(1.0)

    spectra = ("transmittance",)
    is_opaque = False
    passes_straight = is_purely_specular = True

    @property
    def is_window(self) -> bool:
        return not isinstance(self.transmittance, ImageTexture)


@dataclass(frozen=True)
class Black(Surface):
    """Absorbs everything."""


@dataclass(frozen=True)
class Holdout(Black):
    """Cuts a hole into a picture: nothing is seen there, and the picture is transparent. To light it is black."""


@dataclass(frozen=True)
class Catcher(Holdout):
    """Shows what is behind everything, shaded as a matt surface in its place is by what stands on it."""


@dataclass(frozen=True, eq=False)
class Measured(Surface):
    """A surface known by what was measured or computed of its scattering, side by side; None: nothing.

    Parameters
    ----------
    front_reflection, back_reflection : Scatter or None    Of light that comes to that side.
    front_transmission, back_transmission : Scatter or None    Of light that comes to that side and leaves by the other.
    rotation : float    By which the sample is turned about the normal, from the surface's U to its V. [rad]
    factor : float    On everything, for studies of how much a result depends on it. [-]
    sparkles : tuple of Sparkle    Flakes that the camera sees one by one, by their part of the reflection of both sides.
    """

    front_reflection: Scatter | None = None
    back_reflection: Scatter | None = None
    front_transmission: Scatter | None = None
    back_transmission: Scatter | None = None
    rotation: float = 0.0
    factor: float = 1.0
    sparkles: tuple[Sparkle, ...] = ()

    @property
    def parts(self) -> tuple[Scatter | None, ...]:
        """The four scatters, reflections first."""
        return (*self._reflections, *self._transmissions)

    @property
    def _reflections(self) -> tuple[Scatter | None, Scatter | None]:
        return self.front_reflection, self.back_reflection

    @property
    def _transmissions(self) -> tuple[Scatter | None, Scatter | None]:
        return self.front_transmission, self.back_transmission

    @property
    def is_opaque(self) -> bool:
        return self._transmissions == (None, None)

    @property
    def passes_straight(self) -> bool:
        return any(part is not None and part.has_direct for part in self._transmissions)

    is_window = passes_straight

    @property
    def is_bending(self) -> bool:
        return any(part is not None and part.has_direct for part in self._reflections)

    @property
    def is_purely_specular(self) -> bool:
        return not any(part is not None and part.values.any() for part in self.parts)

    @property
    def has_grain(self) -> bool:
        return any(part is not None and not part.is_isotropic for part in self.parts)

    @property
    def has_own_colour(self) -> bool:
        return any(part is not None and len(part.wavelengths) > 1 for part in self.parts)

    @property
    def has_sparkle(self) -> bool:
        return bool(self.sparkles)

    def scaled(self, factor: float) -> Measured:
        return replace(self, factor=self.factor * factor)


def _of_one(name: str) -> property:
    return property(lambda mix: getattr(mix.first, name) or getattr(mix.second, name))


def _of_both(name: str) -> property:
    return property(lambda mix: getattr(mix.first, name) and getattr(mix.second, name))


@dataclass(frozen=True)
class Mix(Surface):
    """``factor`` 0 gives ``first``, 1 gives ``second``. It is what one of them is, or what both are."""

    first: Surface
    second: Surface
    factor: Scalar = 0.5

    is_opaque = _of_both("is_opaque")
    is_purely_specular = _of_both("is_purely_specular")
    passes_straight = _of_one("passes_straight")
    is_bending = _of_one("is_bending")
    is_dispersive = _of_one("is_dispersive")
    is_absorbing = _of_one("is_absorbing")
    has_grain = _of_one("has_grain")
    has_own_colour = _of_one("has_own_colour")
    has_relief = _of_one("has_relief")
    has_sparkle = _of_one("has_sparkle")

    @property
    def depth(self) -> int:
        return 1 + max(self.first.depth, self.second.depth)

    @property
    def colours(self) -> tuple[Colour, ...]:
        return self.first.colours + self.second.colours

    @property
    def pictures(self) -> tuple[ImageTexture, ...]:
        own = (self.factor,) if isinstance(self.factor, ImageTexture) else ()
        return own + self.first.pictures + self.second.pictures

    @property
    def grains(self) -> tuple[Grain, ...]:
        return self.first.grains + self.second.grains

    @property
    def largest(self) -> float:
        return max(self.first.largest, self.second.largest)

    def scaled(self, factor: float) -> Mix | None:
        first, second = self.first.scaled(factor), self.second.scaled(factor)
        if first is None and second is None:
            return None
        return replace(self, first=first or self.first, second=second or self.second)


def _of_inner(name: str) -> property:
    return property(lambda raised: getattr(raised.surface, name))


@dataclass(frozen=True, eq=False)
class Raised(Surface):
    """A surface of one kind with a relief finer than its mesh: it answers light by normals that vary by place.

    What is measured on it, its illuminance, is that of the mesh without the relief. `raise_surface` makes it of any surface.
    """

    surface: Surface
    relief: Relief

    has_relief = True
    is_opaque = _of_inner("is_opaque")
    is_bending = _of_inner("is_bending")
    is_purely_specular = _of_inner("is_purely_specular")
    is_dispersive = _of_inner("is_dispersive")
    has_own_colour = _of_inner("has_own_colour")
    has_grain = _of_inner("has_grain")
    is_absorbing = _of_inner("is_absorbing")
    grains = _of_inner("grains")

    @property
    def colours(self) -> tuple[Colour, ...]:
        return self.surface.colours

    @property
    def pictures(self) -> tuple[ImageTexture, ...]:
        return self.surface.pictures + tuple(map(picture_of, layers(self.relief)))

    @property
    def largest(self) -> float:
        return self.surface.largest

    def scaled(self, factor: float) -> Raised | None:
        surface = self.surface.scaled(factor)
        return None if surface is None else replace(self, surface=surface)

    def check(self) -> None:
        """Refuse a surface that no relief can turn, and pictures of another kind.

        Raises
        ------
        SceneError    Says which.
        """
        if not can_be_raised(self.surface):
            raise SceneError(
                f"a relief cannot lie on a surface of kind {type(self.surface).__name__}"
            )
        for layer in layers(self.relief):
            channels = 3 if hasattr(layer, "vectors") else 1
            if picture_of(layer).pixels.shape[2] != channels:
                raise SceneError(
                    f"a relief's picture has {picture_of(layer).pixels.shape[2]} channels, expected {channels}"
                )


def can_be_raised(surface: Surface) -> bool:
    """Tell whether a relief turns a surface of one kind: not what light passes straight, nor what was measured as it is."""
    return not (
        surface.passes_straight
        or isinstance(
            surface, Black | Blend | Fabric | Holdout | Measured | Mix | Raised | Sheen | Varnish
        )
    )


def raise_surface(surface: Surface | None, relief: Relief | None) -> Surface | None:
    """Return a surface, or all surfaces of a mixture, with a relief, but for those that none can turn."""
    if relief is None or surface is None:
        return surface
    if isinstance(surface, Mix | Blend):
        first, second = (raise_surface(s, relief) for s in (surface.first, surface.second))
        return replace(surface, first=first, second=second)
    if isinstance(surface, Varnish | Sheen):
        return replace(surface, base=raise_surface(surface.base, relief))
    return Raised(surface, relief) if can_be_raised(surface) else surface


@dataclass(frozen=True)
class Toon(Surface):
    """Light goes evenly into a cone about the normal or the mirror direction, as of Blender's Toon BSDF.

    Parameters
    ----------
    reflectance : Colour    Of light that goes into the cone at its middle.
    size, edge : float    Half angle of the cone, and width of its edge, of right angles. [-]
    is_glossy : bool    Whether the cone lies about the mirror direction.
    """

    reflectance: Colour = Constant(0.8)
    size: float = 0.5
    edge: float = 0.0
    is_glossy: bool = False

    spectra = ("reflectance",)


def toon_angles(size: float, edge: float) -> tuple[float, float, float]:
    """Return half angle, edge and whole half angle of a `Toon`'s cone. [rad]"""
    right = 0.5 * np.pi
    inner, soft = min(max(size, 1e-3), 1.0) * right, min(max(edge, 0.0), 1.0) * right
    return inner, soft, min(inner + soft, right)


def blend_cosines() -> np.ndarray:
    """Return the cosines by which a `Blend` has its weights. (n,) [-]"""
    return np.linspace(0.0, 1.0, BLEND_STEPS) ** 2


@dataclass(frozen=True, eq=False)
class Blend(Surface):
    """Two surfaces, weighed by the side and the angle that they are seen from.

    Parameters
    ----------
    first, second : Surface
    weights : (2, 2, n) array    Of the front's parts and the back's, by the cosine (see `blend_cosines`), 0 to 1. [-]
    """

    first: Surface
    second: Surface
    weights: np.ndarray

    is_opaque = _of_both("is_opaque")
    is_purely_specular = _of_both("is_purely_specular")
    passes_straight = _of_one("passes_straight")
    is_window = _of_one("is_window")
    is_bending = _of_one("is_bending")
    is_dispersive = _of_one("is_dispersive")
    is_absorbing = _of_one("is_absorbing")
    has_grain = _of_one("has_grain")
    has_own_colour = _of_one("has_own_colour")
    has_relief = _of_one("has_relief")
    has_sparkle = _of_one("has_sparkle")

    @property
    def depth(self) -> int:
        return 1 + max(self.first.depth, self.second.depth)

    @property
    def colours(self) -> tuple[Colour, ...]:
        return self.first.colours + self.second.colours

    @property
    def pictures(self) -> tuple[ImageTexture, ...]:
        return self.first.pictures + self.second.pictures

    @property
    def grains(self) -> tuple[Grain, ...]:
        return self.first.grains + self.second.grains

    @property
    def is_reciprocal(self) -> bool:
        """Whether its weights are the same for light and eye exchanged."""
        weights = np.asarray(self.weights)
        if not np.array_equal(weights[0], weights[1]):
            return False
        parts = self.first, self.second
        # Mirrors and panes send light on at the angle that it comes by.
        keep_angles = all(each.is_mirror or isinstance(each, _Pane | Transparent) for each in parts)
        return keep_angles or not np.ptp(weights, axis=2).any()

    @property
    def largest(self) -> float:
        parts = np.array([self.first.largest, self.second.largest])
        return float((self.weights * parts[:, None]).sum(axis=1).max())

    def scaled(self, factor: float) -> Blend:
        return replace(self, weights=self.weights * factor)

    def check(self) -> None:
        """Refuse weights that say nothing.

        Raises
        ------
        SceneError    Says what is wrong with them.
        """
        weights = np.asarray(self.weights)
        if weights.shape != (2, 2, BLEND_STEPS):
            raise SceneError(
                f"a blend's weights are {' x '.join(map(str, weights.shape))}, expected 2 x 2 x {BLEND_STEPS}"
            )
        if not (weights.min() >= 0.0 and weights.max() <= 1.0 + ROUNDING):
            raise SceneError("a blend has a weight that is not within 0 and 1")


def _of_base(name: str) -> property:
    return property(lambda surface: getattr(surface.base, name))


class _Laid(Surface):
    """What lies over another surface, ``base``, and has a ``tint`` of its own; light goes where the base lets it."""

    depth = _of_base("depth")
    is_opaque = _of_base("is_opaque")
    passes_straight = _of_base("passes_straight")
    is_window = _of_base("is_window")
    is_bending = _of_base("is_bending")
    is_dispersive = _of_base("is_dispersive")
    is_absorbing = _of_base("is_absorbing")
    has_grain = _of_base("has_grain")
    has_relief = _of_base("has_relief")
    has_sparkle = _of_base("has_sparkle")
    has_own_colour = _of_base("has_own_colour")
    grains = _of_base("grains")

    @property
    def colours(self) -> tuple[Colour, ...]:
        return (*self.base.colours, self.tint)

    @property
    def pictures(self) -> tuple[ImageTexture, ...]:
        return (*self.base.pictures, *super().pictures)


@dataclass(frozen=True)
class Varnish(_Laid):
    """A clear or tinted dielectric coat over any other surface, on both sides of it.

    ``weight`` is the share of the surface that it covers; ``roughness`` as in `Coated`; ``tint`` is what it lets through of
    light on one way along the normal.
    """

    base: Surface
    weight: Scalar = 1.0
    ior: float = 1.5
    roughness: float = 0.03
    tint: Colour = Constant(1.0)

    largest = _of_base("largest")

    def scaled(self, factor: float) -> Varnish | None:
        base = self.base.scaled(factor)
        return None if base is None else replace(self, base=base)


@dataclass(frozen=True)
class Sheen(_Laid):
    """Fibres over any other surface, on both sides of it, which shine at grazing angles.

    Parameters
    ----------
    base : Surface    What lies below; black for fibres alone.
    weight : Scalar    Share of the fibres that is there. [-]
    tint : Colour    Their colour.
    roughness : float    0 to 1. [-]
    is_velvet : bool    Whether they are upright (Ashikhmin's model), and no microfibres.
    """

    base: Surface
    weight: Scalar = 1.0
    tint: Colour = Constant(1.0)
    roughness: float = 0.5
    is_velvet: bool = False

    @property
    def largest(self) -> float:
        return max(self.base.largest, largest_of(self.tint))

    def scaled(self, factor: float) -> Sheen:
        base = self.base.scaled(factor) or self.base
        return replace(self, base=base, tint=scale(self.tint, factor))


@dataclass(frozen=True)
class Emission:
    """Lambertian emission of a surface.

    Parameters
    ----------
    spectrum : Spectrum    Relative spectral power.
    luminance : float    Of the surface, in every direction. [cd/m2]
    pattern : ImageTexture or None    Factor on the luminance by place: its Rec. 709 luminance, and its colour with it.
    two_sided : bool    Both sides emit (Blender's meaning) or only the side that the normal points to.
    """

    spectrum: Spectrum = Constant(1.0)
    luminance: float = 0.0
    pattern: ImageTexture | None = None
    two_sided: bool = True


@dataclass(frozen=True)
class Material:
    """What a mesh is made of.

    Parameters
    ----------
    id : str    Stable and unique.
    name : str    For people.
    surface : Surface
    emission : Emission or None
    index : int    The user's number for the index pass.
    seen : Material or None    What rays of the camera meet in its place, with an id of its own; None: the same as light.
    """

    id: str
    name: str
    surface: Surface = field(default_factory=Diffuse)
    emission: Emission | None = None
    index: int = 0
    seen: Material | None = None


HOLDOUT = Material("holdout", "Holdout", Holdout())
"""What rays of the camera meet of objects that are holdouts."""

CATCHER = Material("catcher", "Shadow catcher", Catcher())
"""What rays of the camera meet of objects that catch shadows."""
