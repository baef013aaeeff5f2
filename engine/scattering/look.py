"""Parameters of Blender's Principled BSDF that come near measured scattering: for views that know no tables.

Along a plane of incidence the values are taken as those of a matt surface and a GGX lobe, Lambert's albedo / pi plus a
factor times D G / (4 cos cos). The roughness is that of the best fit in the logarithm; the amounts come from the light that
is scattered altogether, so that a picture is as bright as it should be. Light that passes goes the same way, about the
direction straight on.
"""

from dataclasses import dataclass

import numpy as np

from ..photometry.colour import REC709_LUMINANCE
from ..scene.scattering import Scatter, ScatterTable
from .data.evaluation import albedo, evaluate
from .data.record import ScatteringFile
from .data.table import direct_share, direction_of, turned
from .data.tristimulus import linear_colour, weights_of

NEAR_NORMAL = np.radians(8.0)
"""Incidence at which amounts and colours are taken. [rad]"""

OBLIQUE = np.radians(30.0)
"""Incidence at which the width of the lobe is taken. [rad]"""

REACH, POINTS = np.radians(85.0), 64
"""How far from the mirror direction values are taken to either side [rad], and how many; they crowd about it."""

STEEPEST = np.radians(80.0)
"""Directions farther from the normal are left out. [rad]"""

FLOOR = 0.01
"""Share of a matt surface's value below which tables are not exact; see `ScatterTable.error`."""

ROUGHNESS = (0.02, 1.0)
"""Range of roughness that is looked through; the GGX width is its square."""

TURNS = np.arange(12) * np.pi / 12.0
"""Planes of incidence in which the lobe of an anisotropic surface is looked at. [rad]"""

LEAST_LOBE = 0.002
"""Share of the light below which a lobe is taken for none."""

LEAST_METAL, METAL_FLOOR = 0.2, 0.15
"""A metal reflects this share of the light at least, and at most this share of that is matt."""

METAL_INDEX = 1.5
"""Blender's own; it does not count for metals."""

LEAST_ANISOTROPY = 0.1
"""Below it a lobe is taken for round: a table's grid makes as much."""

PASSES = 3
"""How often the lobe is fitted, each time with the rise towards grazing that follows from the last."""

LEAST_GLOSS = 0.02
"""Reflectance at normal incidence below which no surface rises from. [-]"""

LARGEST_GLOSS = 0.25
"""Of surfaces that are no metal, at normal incidence."""

LEAST_PASSED = 0.01
"""Share of the light below which nothing passes."""


@dataclass(frozen=True)
class Look:
    """Parameters of a Principled BSDF, and of a Translucent BSDF mixed with it.

    Parameters
    ----------
    base_colour : (float, float, float)    Linear Rec. 709.
    metallic : float    0 or 1.
    roughness : float    The GGX width is its square.
    ior : float    By which the surface reflects at normal incidence what it should.
    anisotropy : float    Blender's: 1 - 0.9 of it is the ratio of the smaller to the larger width.
    grain : float    Azimuth of the larger width from the sample's +x, 0 to pi. [rad]
    transmission : float    Share of the Principled BSDF's light that passes in a lobe.
    translucency : float    Share of the Translucent BSDF.
    translucent_colour : (float, float, float)    Linear Rec. 709.
    """

    base_colour: tuple[float, float, float]
    metallic: float = 0.0
    roughness: float = 1.0
    ior: float = 1.0
    anisotropy: float = 0.0
    grain: float = 0.0
    transmission: float = 0.0
    translucency: float = 0.0
    translucent_colour: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def overall_colour(self) -> tuple[float, float, float]:
        """One colour for all of it, for views without nodes."""
        share = self.translucency
        mixed = zip(self.base_colour, self.translucent_colour, strict=True)
        return tuple((1.0 - share) * base + share * passed for base, passed in mixed)


@dataclass(frozen=True, eq=False)
class _Parts:
    """Linear colours of what one scatter does with light from near the normal.

    ``lobe`` is the light that the lobe holds, ``gloss`` what its facets reflect, ``floor`` the share of the light that is
    matt by the fit.
    """

    matt: np.ndarray
    lobe: np.ndarray
    gloss: np.ndarray
    floor: float
    alpha: float
    anisotropy: float
    grain: float


def fit_look(file: ScatteringFile) -> Look:
    """Find the look of a material from its front, and from its back what is not known of the front."""
    reflected, passed = (_take_apart_front(file, kind) for kind in ("reflection", "transmission"))
    dark = np.zeros(3)
    matt, lobe, gloss = (
        (reflected.matt, reflected.lobe, reflected.gloss) if reflected else (dark, dark, dark)
    )
    diffuse, straight = (passed.matt, passed.lobe) if passed else (dark, dark)
    if _y(diffuse + straight) < LEAST_PASSED:
        diffuse = straight = dark
    through = _y(diffuse + straight)
    if reflected and through == 0.0 and _is_metal(reflected):
        return Look(_colour(lobe), 1.0, *_shape(reflected, METAL_INDEX))
    solid = matt + straight
    share = _y(diffuse) / max(_y(solid + diffuse), 1e-9)
    # A lobe that passes is what is looked at: its width counts where it is the stronger one.
    shown = passed if _y(straight) > _y(lobe) else reflected
    ior = _index(_y(gloss) / max(1.0 - share, 0.1))
    roughness, ior, anisotropy, grain = _shape(shown, ior) if shown else (1.0, 1.0, 0.0, 0.0)
    return Look(
        base_colour=_colour(solid / max((1.0 - share) * (1.0 - _y(lobe)), 1e-9)),
        roughness=roughness,
        ior=ior,
        anisotropy=anisotropy,
        grain=grain,
        transmission=_y(straight) / max(_y(solid), 1e-9),
        translucency=share,
        translucent_colour=_colour(diffuse / max(share, 1e-9)),
    )


def _take_apart_front(file: ScatteringFile, kind: str) -> _Parts | None:
    scatter = file.sides.get(f"front_{kind}", file.sides.get(f"back_{kind}"))
    return None if scatter is None else _take_apart(scatter)


def _take_apart(scatter: Scatter) -> _Parts:
    """Find the matt part and the lobe of a scatter."""
    bright = weights_of(scatter.wavelengths)[:, 1]
    whole = albedo(scatter, NEAR_NORMAL)
    direct = np.zeros_like(whole)
    if isinstance(scatter, ScatterTable):
        direct = direct_share(scatter, _toward(NEAR_NORMAL)[None])[0]
    floor = FLOOR * max(float(whole @ bright), 1e-6) / np.pi
    turns = TURNS[:1] if scatter.is_isotropic else TURNS
    fits = [_fit(scatter, turn, bright, floor) for turn in turns]
    widths = np.array([alpha for alpha, _, _ in fits])
    larger, smaller, grain = _widths(widths)
    alpha = np.sqrt(larger * smaller)
    matt = np.mean([each for _, each, _ in fits], axis=0)
    # In one plane of incidence the lobe is as high as both widths make it, and as wide as its own.
    gloss = np.mean([each * (alpha / width) ** 2 for width, _, each in fits], axis=0)
    kept = energy_of_lobe(alpha, NEAR_NORMAL)
    lobe = np.minimum(gloss * kept, whole)
    matt_share = float(matt @ bright) / max(float((whole + direct) @ bright), 1e-9)
    if matt_share < METAL_FLOOR:
        # Hardly anything else: whatever the shape of the lobe, its light is known.
        lobe = whole
        gloss = whole / kept
    if direct @ bright > lobe @ bright:
        alpha, larger, smaller = 0.0, 1.0, 1.0
    anisotropy = float((1.0 - smaller / larger) / 0.9)
    is_round = anisotropy < LEAST_ANISOTROPY
    colours = (whole - lobe, lobe + direct, gloss + direct)
    return _Parts(
        *(np.maximum(linear_colour(each, scatter.wavelengths), 0.0) for each in colours),
        matt_share,
        float(alpha),
        0.0 if is_round else min(anisotropy, 1.0),
        0.0 if is_round else float(grain),
    )


def _is_metal(parts: _Parts) -> bool:
    return _y(parts.lobe + parts.matt) >= LEAST_METAL and parts.floor < METAL_FLOOR


def _shape(parts: _Parts, ior: float) -> tuple[float, float, float, float]:
    """Roughness, index, anisotropy and grain as `Look` has them."""
    if _y(parts.lobe) < LEAST_LOBE:
        return 1.0, 1.0, 0.0, 0.0
    return float(np.sqrt(parts.alpha)), ior, parts.anisotropy, parts.grain


def _index(reflectance: float) -> float:
    """Refractive index by which a surface reflects so much at normal incidence. [-]"""
    root = np.sqrt(np.clip(reflectance, 0.0, LARGEST_GLOSS))
    return float((1.0 + root) / (1.0 - root))


def _colour(values) -> tuple[float, float, float]:
    return tuple(float(value) for value in np.clip(values, 0.0, 1.0))


def _y(colour) -> float:
    return float(colour @ REC709_LUMINANCE)


# ---- the fit ----


def lobe_of_ggx(wi, wo, alpha: float) -> np.ndarray:
    """BRDF of a GGX surface that reflects everything, with Smith's correlated shadowing. (n, 3), (n, 3) -> (n,) [1/sr]

    References
    ----------
    B. Walter et al.: Microfacet models for refraction through rough surfaces, 2007, doi:10.2312/EGWR/EGSR07/195-206
    """
    half = wi + wo
    cosine = half[..., 2] / np.linalg.norm(half, axis=-1)
    square = alpha * alpha
    density = square / (np.pi * (cosine * cosine * (square - 1.0) + 1.0) ** 2)
    ci, co = wi[..., 2], wo[..., 2]
    shadowing = ci * np.sqrt(square + (1.0 - square) * co * co)
    shadowing = shadowing + co * np.sqrt(square + (1.0 - square) * ci * ci)
    return density * 0.5 / shadowing


def energy_of_lobe(alpha: float, incidence: float) -> float:
    """Share of light that `lobe_of_ggx` reflects; the rest would be reflected twice and more. [-]"""
    # Normals as often as they are.
    draw, turn = np.meshgrid((np.arange(64) + 0.5) / 64.0, (np.arange(32) + 0.5) * np.pi / 32.0)
    tangent = alpha * np.sqrt(draw / (1.0 - draw))
    cosine = 1.0 / np.sqrt(1.0 + tangent * tangent)
    sine = tangent * cosine
    half = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=-1).reshape(-1, 3)
    wi = np.broadcast_to(_toward(incidence), half.shape)
    along = (wi * half).sum(axis=1)
    wo = 2.0 * along[:, None] * half - wi
    good = (wo[:, 2] > 1e-6) & (along > 0.0)
    cosine, square = half[:, 2], alpha * alpha
    density = square / (np.pi * (cosine * cosine * (square - 1.0) + 1.0) ** 2)
    share = np.zeros(len(half))
    lobe = lobe_of_ggx(wi[good], wo[good], alpha)
    share[good] = 4.0 * along[good] * lobe * wo[good, 2] / (density * cosine)[good]
    return float(share.mean())


def _fit(scatter, turn: float, bright, floor: float):
    """Width of the lobe in a plane of incidence, and Lambert's albedo and the lobe's factor by band.

    The factor grows towards grazing by Schlick's formula, from what was found at first.
    """
    radial = REACH * np.linspace(0.0, 1.0, POINTS) ** 2
    radial, azimuth = np.append(radial, radial[1:]), np.repeat([0.0, np.pi], [POINTS, POINTS - 1])
    wo = direction_of(OBLIQUE, radial, azimuth)
    wo = wo[wo[:, 2] > np.cos(STEEPEST)]
    wi = np.broadcast_to(_toward(OBLIQUE), wo.shape)
    values = evaluate(scatter, turned(wi, turn), turned(wo, turn))
    seen = (values @ bright)[:, None]

    half = wi + wo
    away = (1.0 - (wi * half).sum(axis=1) / np.linalg.norm(half, axis=1)) ** 5
    rise = np.zeros_like(away)

    def lobe_at(roughness: float) -> np.ndarray:
        return lobe_of_ggx(wi, wo, roughness * roughness) * (1.0 + rise)

    def misfit(roughness: float) -> float:
        lobe = lobe_at(roughness)
        matt, gloss = _split(seen, lobe, floor)
        made = matt[0] / np.pi + gloss[0] * lobe
        return float((np.log((made + floor) / (seen[:, 0] + floor)) ** 2).mean())

    for _ in range(PASSES):
        low, high = ROUGHNESS
        for _ in range(3):
            tried = np.linspace(low, high, 30)
            best = tried[np.argmin([misfit(roughness) for roughness in tried])]
            step = tried[1] - tried[0]
            low, high = max(best - step, ROUGHNESS[0]), min(best + step, ROUGHNESS[1])
        alpha = float(best * best)
        matt, gloss = _split(values, lobe_at(best), floor)
        normal = np.clip(gloss @ bright, LEAST_GLOSS, 1.0)
        rise = (1.0 - normal) / normal * away
    return alpha, matt, gloss


def _split(values, lobe, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Lambert's albedo and the lobe's factor, neither below 0, by least squares of relative differences. (n, w) -> (w,)"""
    weight = 1.0 / (values + floor)
    a, b, wanted = weight / np.pi, weight * lobe[:, None], weight * values
    aa, ab, bb = (a * a).sum(0), (a * b).sum(0), (b * b).sum(0)
    ay, by = (a * wanted).sum(0), (b * wanted).sum(0)
    determinant = np.maximum(aa * bb - ab * ab, 1e-12 * aa * bb)
    matt, gloss = (bb * ay - ab * by) / determinant, (aa * by - ab * ay) / determinant
    alone_matt, alone_gloss = ay / aa, by / np.maximum(bb, 1e-300)
    return (
        np.where(gloss < 0.0, alone_matt, np.maximum(matt, 0.0)),
        np.where(matt < 0.0, alone_gloss, np.maximum(gloss, 0.0)),
    )


def _widths(widths: np.ndarray) -> tuple[float, float, float]:
    """Larger and smaller width of a lobe and the azimuth of the larger, from those along `TURNS`."""
    if len(widths) == 1:
        return widths[0], widths[0], 0.0
    # Of an ellipse the inverse squares vary with the cosine of twice the azimuth.
    inverse = 1.0 / widths**2
    mean = inverse.mean()
    swing = 2.0 * (inverse * np.exp(2j * TURNS)).mean()
    reach = min(abs(swing), (1.0 - 1e-4) * mean)
    grain = (0.5 * np.angle(-swing)) % np.pi
    return (mean - reach) ** -0.5, (mean + reach) ** -0.5, grain


def _toward(incidence: float) -> np.ndarray:
    return np.array([np.sin(incidence), 0.0, np.cos(incidence)])
