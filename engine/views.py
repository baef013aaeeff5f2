"""Pictures and live views: what is asked for, and what comes back."""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from .accuracy.estimate import relative_error
from .accuracy.stopping import StopRule
from .light_mix import NEUTRAL, GroupLight, LightMix, mix
from .scene.light_groups import LightGroup
from .scene.provenance import Provenance


@dataclass(frozen=True)
class ViewSettings:
    """What a picture has to contain.

    ``spectral_file``: where its bands are written as a spectral OpenEXR; ``transparent``: whether to tell what of it is the
    surroundings behind everything; ``groups``: light groups that are kept apart, to be mixed afterwards, with lights in
    none of them as one more, which share the samples; ``preview``: levels of the groups in pictures on the way; the finished
    one has all as they are; ``method``: ``cells`` reads light beyond the first bounce from cells, ``paths`` follows it to
    its end, ``auto`` decides by the scene and says why; ``guides``: whether filters of noise will want theirs; ``unbiased``:
    whether what cells change is corrected by full paths, so that the expected picture is theirs; ``shares``: whether pixels
    share light that is even, where the method is not ``paths``.
    """

    rule: StopRule
    seed: int = 0
    illuminance: bool = False
    bands: int = 0
    transport: str = "auto"
    spectral_file: str | None = None
    transparent: bool = False
    groups: tuple[LightGroup, ...] = ()
    preview: LightMix = NEUTRAL
    method: str = "auto"
    guides: bool = False
    unbiased: bool = False
    shares: bool = True


@dataclass(frozen=True)
class Picture:
    """A rendered view. Row 0 is the bottom row.

    Parameters
    ----------
    tristimulus : (h, w, 3) float32    X, Y, Z with Y the luminance. [cd/m2]
    luminance_error : (h, w) float32    Standard error of Y. [cd/m2]
    relative_error : float    Root mean square over the pixels of their error over the larger of their own and the mean
        luminance. [-]
    depth : (h, w) float32    Along the view axis, at the pixel's centre; 1e10 where nothing is seen. [m]
    normal : (h, w, 3) float32    World space, at the pixel's centre; 0 where nothing is seen.
    object_index, material_index : (h, w) float32
    illuminance, illuminance_error : (h, w) float32 or None
        Of the surface that is seen, through panes. [lx]
    bands : (h, w, b) float32 or None    Spectral radiance per band. [W/(m2 sr nm)]
    band_edges : (b + 1,) float64 or None    [nm]
    backdrop : (h, w, 3) float32 or None    Part of ``tristimulus`` by surroundings that are seen straight. [cd/m2]
    coverage : (h, w) float32 or None    Share of a pixel that shows anything else, and no hole of a holdout. [-]
    denoising_albedo : (h, w, 3) float32 or None
        Guides of filters of noise are means over the pixel, of what is seen through panes and in mirrors: reflectance in
        red, green and blue, 1 where light comes from. [-]
    denoising_normal : (h, w, 3) float32 or None    World space; 0 where nothing is seen.
    denoising_depth : (h, w) float32 or None    Length of the way; 0 where nothing is seen. [m]
    groups : tuple of GroupLight    What each light group gives, where they were kept apart; they add up to the picture.
    luminance_floor, illuminance_floor : (h, w) float32 or None
        Part of the errors that more samples do not lower; None: nothing. [cd/m2] [lx]
    """

    tristimulus: np.ndarray
    luminance_error: np.ndarray
    relative_error: float
    depth: np.ndarray
    normal: np.ndarray
    object_index: np.ndarray
    material_index: np.ndarray
    provenance: Provenance
    illuminance: np.ndarray | None = None
    illuminance_error: np.ndarray | None = None
    bands: np.ndarray | None = None
    band_edges: np.ndarray | None = None
    backdrop: np.ndarray | None = None
    coverage: np.ndarray | None = None
    denoising_albedo: np.ndarray | None = None
    denoising_normal: np.ndarray | None = None
    denoising_depth: np.ndarray | None = None
    groups: tuple[GroupLight, ...] = ()
    luminance_floor: np.ndarray | None = None
    illuminance_floor: np.ndarray | None = None

    def widened(self, bound: float) -> "Picture":
        """Return the picture with errors that hold a share of its light as well; those of its groups stay. [-]"""
        if not bound:
            return self
        share, luminance = np.float32(bound), self.tristimulus[..., 1]
        error = np.hypot(self.luminance_error, share * luminance)
        made = replace(
            self,
            luminance_error=error,
            relative_error=relative_error(luminance, error),
            luminance_floor=_raised(self.luminance_floor, share * luminance),
        )
        if made.illuminance_error is None:
            return made
        more = share * made.illuminance
        return replace(
            made,
            illuminance_error=np.hypot(made.illuminance_error, more),
            illuminance_floor=_raised(self.illuminance_floor, more),
        )

    def mixed(self, levels: LightMix) -> "Picture":
        """Return the picture with its groups at other levels, bands aside; itself where nothing is changed."""
        if not self.groups or levels.is_neutral:
            return self
        made = mix(self.groups, levels)
        error = relative_error(made.tristimulus[..., 1], made.luminance_error)
        mixed = replace(self, **vars(made), relative_error=error, bands=None, band_edges=None)
        # What is left out is wrong in all groups alike, so that it is not in their own errors.
        return mixed.widened(self.provenance.simplified)


def _raised(floor: np.ndarray | None, more: np.ndarray) -> np.ndarray:
    return more if floor is None else np.hypot(floor, more)


@dataclass(frozen=True)
class LiveSettings:
    """What a live view has to compute.

    ``samples`` per pixel are the most it goes to; ``groups``: light groups that are kept apart, as in `ViewSettings`, so
    that the display can mix them; ``denoise``: whether its picture is to be denoised once it rests, where Open Image Denoise
    is installed. Groups are not denoised. ``method``: as in `ViewSettings`; cells are read as soon as their light is
    known, and groups are followed by paths.
    """

    samples: int = 1024
    seed: int = 0
    illuminance: bool = False
    transport: str = "auto"
    groups: tuple[LightGroup, ...] = ()
    denoise: bool = False
    method: str = "auto"


class DisplayMode(Enum):
    """What a live view shows."""

    PICTURE = "picture"  # scene-linear colour, 1 at the white luminance
    LUMINANCE = "luminance"  # the same without colour
    FALSE_LUMINANCE = "false_luminance"  # cd/m2 in false colours
    FALSE_ILLUMINANCE = "false_illuminance"  # lx in false colours
    PHOTOGRAPHIC = "photographic"  # by a tone operator, for looking
    VISUAL = "visual"  # as adapted eyes see, for looking

    @property
    def is_looked_at(self) -> bool:
        """Whether it is looked at in colour, so that its noise may be filtered, and nothing is read off it."""
        return self in (DisplayMode.PICTURE, DisplayMode.PHOTOGRAPHIC, DisplayMode.VISUAL)


@dataclass(frozen=True)
class Display:
    """How a live view turns numbers into what is seen.

    Parameters
    ----------
    mode : DisplayMode
    white : float or None    Luminance that becomes 1; None: from the picture itself. [cd/m2]
    low, high : float    Ends of the false colours' scale; ``high`` 0: from the picture itself. [cd/m2 or lx]
    logarithmic : bool    Whether the scale of the false colours is logarithmic.
    mix : LightMix    Levels of the groups that are kept apart.
    lines, values : bool    Whether false colours have lines of equal value, and values at points.
    """

    mode: DisplayMode = DisplayMode.PICTURE
    white: float | None = 200.0
    low: float = 0.0
    high: float = 0.0
    logarithmic: bool = False
    mix: LightMix = NEUTRAL
    lines: bool = False
    values: bool = False


@dataclass(frozen=True)
class Commit:
    """What bringing the engine's objects up to date took.

    Parameters
    ----------
    items : int    Items that the deltas since the last time named.
    action : str    For people: what had to be done.
    seconds : float    For the objects.
    first_sample_seconds : float    From then to the first samples.
    """

    items: int = 0
    action: str = ""
    seconds: float = 0.0
    first_sample_seconds: float = 0.0


@dataclass(frozen=True)
class Frame:
    """State of a live view. Row 0 is the bottom row; smaller than the view while it is coarse.

    Parameters
    ----------
    pixels : (h, w, 4) float32
        Scene-linear colour and 1 (pictures and luminance), or display colours in sRGB (false colours, tone operators).
    is_display_referred : bool    Whether ``pixels`` are display colours that no view transform must touch.
    low, high : float    Ends of the scale, in ``unit``; ``is_logarithmic``: whether equal ratios are equal lengths.
    revision : int    Number of the scene's state: how many deltas had been applied.
    samples : int    Per pixel.
    relative_error : float    As in `Picture`; infinite while unknown.
    is_final : bool    Whether no better frame will come.
    words : str    How its light was found and its noise filtered, for people; empty: by full paths, as computed.
    greys : (n,) array or None    Of tone operators: how bright (sRGB, 0 to 1) what lies on even steps of the scale is shown.
    statement : str    What the picture is, or its lines are of, for people.
    lines, labels, values : array or None    Of false colours, as of `analysis.view_marks.ViewMarks`.
    """

    pixels: np.ndarray
    is_display_referred: bool
    is_logarithmic: bool
    low: float
    high: float
    unit: str
    revision: int
    samples: int
    relative_error: float
    is_final: bool
    commit: Commit
    words: str = ""
    greys: np.ndarray | None = None
    statement: str = ""
    lines: np.ndarray | None = None
    labels: np.ndarray | None = None
    values: np.ndarray | None = None
