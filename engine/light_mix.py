"""Pictures of light groups, mixed after rendering: each group's light times a factor, in a colour, or left out.

Light adds up, so the sum of the groups' pictures is the picture, and a group's picture times a factor is that of the same
lights with as many times their flux. A colour acts on what is seen, not on spectra, see `tint`.
"""

import json
from dataclasses import dataclass

import numpy as np

from .errors import SceneError
from .photometry.colour import XYZ_TO_REC709

WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class GroupLight:
    """What the lights of one group give to a picture. Row 0 is the bottom row.

    Parameters
    ----------
    name : str    Of the group.
    samples : int    Per pixel.
    tristimulus : (h, w, 3) float32    X, Y, Z with Y the luminance. [cd/m2]
    luminance_error : (h, w) float32    Standard error of Y. [cd/m2]
    illuminance, illuminance_error : (h, w) float32 or None    Of the surface that is seen. [lx]
    backdrop : (h, w, 3) float32 or None    Part of ``tristimulus`` by surroundings that are seen straight. [cd/m2]
    shared_error : (h, w) float32 or None
        Part of ``luminance_error`` that depends on those of other groups, with a sign: such parts add up as they are. What
        shadow catchers show has one, as its light is divided by that of all groups. [cd/m2]
    """

    name: str
    samples: int
    tristimulus: np.ndarray
    luminance_error: np.ndarray
    illuminance: np.ndarray | None = None
    illuminance_error: np.ndarray | None = None
    backdrop: np.ndarray | None = None
    shared_error: np.ndarray | None = None


@dataclass(frozen=True)
class Level:
    """How a group of the mix shines.

    Parameters
    ----------
    name : str    Of the group.
    factor : float    On the flux of its lights. [-]
    colour : (float, float, float)    Linear Rec. 709; only the proportions count, the flux stays.
    is_on : bool
    """

    name: str
    factor: float = 1.0
    colour: tuple[float, float, float] = WHITE
    is_on: bool = True

    def __post_init__(self):
        """Refuse what no lamp can be set to."""
        if not 0.0 <= self.factor < np.inf:
            raise SceneError(
                f"light group '{self.name}': the factor is {self.factor}, expected a number of at least 0"
            )
        if not all(0.0 <= part < np.inf for part in self.colour) or not max(self.colour) > 0.0:
            raise SceneError(
                f"light group '{self.name}': the colour is {self.colour}, expected components of at least 0 and one "
                "above 0"
            )

    @property
    def flux(self) -> float:
        """Factor on the flux of the group's lights, 0 while they are off. [-]"""
        return self.factor if self.is_on else 0.0

    @property
    def is_white(self) -> bool:
        """Whether the group keeps its colour."""
        return self.colour[0] == self.colour[1] == self.colour[2]

    @property
    def is_neutral(self) -> bool:
        """Whether it changes nothing."""
        return self.flux == 1.0 and self.is_white


@dataclass(frozen=True)
class LightMix:
    """Levels of groups; groups without one shine as they are."""

    levels: tuple[Level, ...] = ()

    @property
    def is_neutral(self) -> bool:
        """Whether the sum of all groups is all it asks for."""
        return all(level.is_neutral for level in self.levels)

    @property
    def is_dimmed(self) -> bool:
        """Whether a group shines with less than its flux, but shines."""
        return any(0.0 < level.flux < 1.0 for level in self.levels)

    def level(self, name: str) -> Level:
        """Level of a group."""
        return next((level for level in self.levels if level.name == name), Level(name))

    def text(self) -> str:
        """Say what is changed, in words; empty if nothing is."""
        changed = [level for level in self.levels if not level.is_neutral]
        return ", ".join(f"{level.name} {_describe(level)}" for level in changed)

    def key(self) -> str:
        """Text by which two mixes are told to ask for the same."""
        changed = sorted((e for e in self.levels if not e.is_neutral), key=lambda e: e.name)
        return json.dumps([[e.name, round(e.flux, 6), *_proportions(e)] for e in changed])


NEUTRAL = LightMix()


@dataclass(frozen=True)
class MixedLight:
    """Sum of groups at their levels, as in `GroupLight`."""

    tristimulus: np.ndarray
    luminance_error: np.ndarray
    illuminance: np.ndarray | None
    illuminance_error: np.ndarray | None
    backdrop: np.ndarray | None


def tint(colour) -> np.ndarray:
    """Matrix by which X, Y, Z take on a colour: factors on linear Rec. 709, that leave the luminance of its white. (3, 3)

    It is exact for light whose spectra and surfaces three numbers tell, and else what a filter of a graphics program does:
    a lamp of another spectrum has to be rendered to be known.
    """
    colour = np.asarray(colour, dtype=np.float64)
    to_xyz = np.linalg.inv(XYZ_TO_REC709)
    factors = colour / (to_xyz[1] @ colour)
    return to_xyz @ (factors[:, None] * XYZ_TO_REC709)


def mix(groups: tuple[GroupLight, ...], levels: LightMix = NEUTRAL) -> MixedLight:
    """Add groups up at their levels.

    Sums are made in double precision and in the order of the groups. Errors of groups are independent and add up as squares,
    but for the part that they share. In another colour a group keeps the relative error of its luminance. Illuminance
    follows the flux alone.
    """
    return MixedLight(
        tristimulus=add_colours([group.tristimulus for group in groups], groups, levels),
        luminance_error=_add_errors(groups, levels),
        illuminance=_add(groups, levels, "illuminance"),
        illuminance_error=_add(groups, levels, "illuminance_error", squared=True),
        backdrop=None
        if groups[0].backdrop is None
        else add_colours([group.backdrop for group in groups], groups, levels),
    )


def add_colours(images, groups, levels: LightMix) -> np.ndarray:
    """Add up X, Y, Z of groups at their levels. ``images``: one for each, (..., 3); ``groups``: with their names."""
    total = np.zeros(images[0].shape)
    for image, group in zip(images, groups, strict=True):
        level = levels.level(group.name)
        if level.flux > 0.0:
            total += level.flux * _coloured(image, level)
    return total.astype(np.float32)


def undim(groups: tuple[GroupLight, ...], levels: LightMix) -> np.ndarray:
    """Luminance of the groups that shine at some levels, were none of them dimmed.

    Returns
    -------
    (c, h, w) float32 array    One picture for all groups that are dimmed alike, for at least one of them shines. [cd/m2]
    """
    made: dict[float, np.ndarray] = {}
    for group in groups:
        level = levels.level(group.name)
        if level.flux > 0.0:
            light = max(level.flux, 1.0) * _coloured(group.tristimulus, level)[..., 1]
            dimming = min(level.flux, 1.0)
            made[dimming] = made.get(dimming, 0.0) + light
    return np.stack(list(made.values())).astype(np.float32)


def _coloured(image, level: Level):
    """X, Y, Z in a level's colour."""
    return image if level.is_white else image @ tint(level.colour).T


def _add_errors(groups, levels: LightMix) -> np.ndarray:
    total, shared = (np.zeros(groups[0].luminance_error.shape) for _ in range(2))
    for group in groups:
        level = levels.level(group.name)
        if level.flux == 0.0:
            continue
        factor = level.flux
        if not level.is_white:
            before = group.tristimulus[..., 1].astype(np.float64)
            after = np.abs(group.tristimulus @ tint(level.colour)[1])
            factor = factor * np.divide(after, before, out=np.ones_like(before), where=before > 0.0)
        error = factor * group.luminance_error.astype(np.float64)
        total += error**2
        if group.shared_error is not None:
            part = factor * group.shared_error.astype(np.float64)
            total -= part**2
            shared += part
    return np.sqrt(np.maximum(total, 0.0) + shared**2).astype(np.float32)


def _add(groups, levels: LightMix, name: str, squared: bool = False) -> np.ndarray | None:
    """Add up what follows the flux alone, None where it was not computed."""
    if getattr(groups[0], name) is None:
        return None
    total = np.zeros(getattr(groups[0], name).shape)
    for group in groups:
        flux = levels.level(group.name).flux
        if flux > 0.0:
            part = flux * getattr(group, name).astype(np.float64)
            total += part**2 if squared else part
    return (np.sqrt(total) if squared else total).astype(np.float32)


def _proportions(level: Level) -> list[float]:
    """Colour of a level over its largest component; nothing of one that is dark or keeps its own."""
    if level.is_white or level.flux == 0.0:
        return []
    return [round(part / max(level.colour), 6) for part in level.colour]


def _describe(level: Level) -> str:
    if level.flux == 0.0:
        return "off"
    words = [] if level.flux == 1.0 else [f"at {100.0 * level.flux:.4g} % of its flux"]
    if not level.is_white:
        words.append("in another colour")
    return " ".join(words)
