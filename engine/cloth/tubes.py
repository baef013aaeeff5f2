"""Yarns of one repeat of a cloth as tubes: their frames along them, and triangles.

Every tube has the same numbers of rings and of corners around, so that the number of a triangle and a place in it tell
where along and around which tube it is. The point of a ring at the angle v is c + b cos v e1 + a sin v e2 with e1 across
the cloth, e2 = t x e1, and t along the yarn. From ring to ring there is the same area. Lengths are mm.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .composition import Cloth
from .weave import heights

CORNERS = 32
"""Corners around a tube. [-]"""

ABOUT = 128
"""Cuts of half a section, between which its area grows evenly. A power of two."""

SHARPEST = 0.95
"""Largest curvature of a yarn times half its height; a sharper bend would fold its surface. [-]"""

RINGS_PER_CROSSING = 12

FINER = 16
"""Steps from ring to ring by which a yarn's length is measured."""

LEAST_RINGS = 24
"""Rings of a tube."""

MARGIN = 4
"""Crossings that are there about a repeat."""

PILE_MARGIN = 2
"""Likewise, at most, where there is a pile, of which many ends would be there."""

TIP = 0.15
"""Share of a pile's length that narrows to its end."""

MOST_PILE = 400
"""Largest number of pile ends in one repeat."""


@dataclass(frozen=True, eq=False)
class Tubes:
    """Tubes of a repeat, and of its neighbours as far as they reach into it.

    Parameters
    ----------
    size : (2,) array    Of the repeat along x and y. [mm]
    pad : (2,) array    How far beyond it all yarns are there. [mm]
    low, high : float    Bounds along z. [mm]
    kinds : (c,) int array    Which yarn each tube is of: 0 warp, 1 weft, 2 pile.
    centres, tangents, ups : (c, k, 3) arrays    c, t and e1 of the rings. [mm], [-], [-]
    widths, heights : (c, k) arrays    2 a and 2 b. [mm]
    bends : (c, k) array    b dt/ds . e1: by how much the upper side is shorter than the centre line. [-]
    steps : (c,) array    Way along the tube from ring to ring, its mean. [mm]
    periods : (c,) array    Rings of a repeat, by which a place along may be shifted; 0: the tube has ends.
    """

    size: np.ndarray
    pad: np.ndarray
    low: float
    high: float
    kinds: np.ndarray
    centres: np.ndarray
    tangents: np.ndarray
    ups: np.ndarray
    widths: np.ndarray
    heights: np.ndarray
    bends: np.ndarray
    steps: np.ndarray
    periods: np.ndarray


def lay_out(
    cloth: Cloth, repeats: int = 1, margin: int = MARGIN, rings: int = RINGS_PER_CROSSING
) -> Tubes:
    """Place the yarns of a cloth.

    Parameters
    ----------
    repeats : int    Of the weave along both, which then are one repeat.
    margin : int
        Crossings by which tubes go on beyond it, on all sides; with 0 copies beside each other join without a seam.
    rings : int    Of each crossing.

    Raises
    ------
    SceneError    The repeat has more pile ends than `MOST_PILE`.
    """
    up = np.tile(cloth.weave.is_warp_up, (repeats, repeats))
    ends, picks = up.shape
    if cloth.pile is not None:
        margin = min(margin, PILE_MARGIN)
    pitch = np.array([cloth.weave.warp_pitch_mm, cloth.weave.weft_pitch_mm])
    size = pitch * [ends, picks]
    # Warp and weft bend alike.
    both = cloth.warp.height_mm + cloth.weft.height_mm
    amplitudes = 0.5 * both, 0.5 * both
    count = max(LEAST_RINGS, rings * (max(ends, picks) + 2 * margin)) + 1
    parts = []
    for kind, (yarn, amplitude) in enumerate(
        zip((cloth.warp, cloth.weft), amplitudes, strict=True)
    ):
        along, across = (1, 0) if kind == 0 else (0, 1)
        crossings = up.shape[along]
        for number in range(-margin, up.shape[across] + margin):
            states = up[number % ends, :] if kind == 0 else ~up[:, number % picks]
            fine = np.linspace(-margin, crossings + margin, FINER * (count - 1) + 1)
            rise = np.diff(heights(states, amplitude, fine))
            way = np.append(0.0, np.cumsum(np.hypot(rise, np.diff(fine) * pitch[along])))
            places = np.interp(np.linspace(0.0, way[-1], count), way, fine)
            centre = np.zeros((count, 3))
            centre[:, across] = (number + 0.5) * pitch[across]
            centre[:, along] = places * pitch[along]
            centre[:, 2] = heights(states, amplitude, places)
            repeat = np.interp(crossings, fine, way) - np.interp(0.0, fine, way)
            period = (count - 1) * repeat / way[-1]
            parts.append((kind, centre, np.ones(count), yarn, period))
    high = 0.25 * both + 0.51 * max(cloth.warp.height_mm, cloth.weft.height_mm)
    top = high
    if cloth.pile is not None:
        parts += _pile(cloth, size, pitch * (margin - 1) if margin else None, count)
        top = max(high, cloth.pile.height_mm + cloth.pile.yarn.width_mm)
    centres = np.array([part[1] for part in parts])
    tangents = np.gradient(centres, axis=1)
    if not margin:
        # Where copies join a yarn goes on as it began.
        yarns = np.array([part[0] < 2 for part in parts])
        steps = centres[yarns][:, [1, -1]] - centres[yarns][:, [0, -2]]
        tangents[yarns, 0] = tangents[yarns, -1] = 0.5 * steps.sum(axis=1)
    tangents /= np.linalg.norm(tangents, axis=2, keepdims=True)
    side = np.where(
        np.array([part[0] for part in parts])[:, None, None] == 1, [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]
    )
    ups = np.cross(side, tangents)
    flip = (ups[..., 2] < 0.0)[..., None] & (np.abs(ups[..., 2:]) > 1e-9)
    ups = np.where(flip, -ups, ups)
    ups /= np.linalg.norm(ups, axis=2, keepdims=True)
    narrow = np.array([part[2] for part in parts])
    lengths = np.linalg.norm(np.diff(centres, axis=1), axis=2).mean(axis=1)
    high_mm = narrow * np.array([part[3].height_mm for part in parts])[:, None]
    turns = np.gradient(tangents, axis=1) / np.linalg.norm(
        np.gradient(centres, axis=1), axis=2, keepdims=True
    )
    bends = np.clip(0.5 * high_mm * (turns * ups).sum(axis=2), -SHARPEST, SHARPEST)
    return Tubes(
        size,
        pitch * (margin - 1),
        -high,
        top,
        np.array([part[0] for part in parts]),
        centres,
        tangents,
        ups,
        narrow * np.array([part[3].width_mm for part in parts])[:, None],
        high_mm,
        bends,
        lengths,
        np.array([part[4] for part in parts], np.float64),
    )


def lay_out_straight(cloth: Cloth, kind: int, count: int = LEAST_RINGS + 1) -> Tubes:
    """Place the yarns of one kind, 0 warp or 1 weft, straight and side by side, as if there were no others."""
    yarn = cloth.yarns[kind]
    pitch = np.array([cloth.weave.warp_pitch_mm, cloth.weave.weft_pitch_mm])
    along, across = (1, 0) if kind == 0 else (0, 1)
    numbers = np.arange(-MARGIN, 1 + MARGIN)
    # Longer than any way along a thread, of which few are longer than some widths.
    reach = MARGIN * max(pitch[along], 2.0 * yarn.width_mm)
    size, pad = pitch.copy(), pitch * (MARGIN - 1)
    pad[along] = reach - 0.5 * size[along]
    centres = np.zeros((len(numbers), count, 3))
    centres[..., across] = ((numbers + 0.5) * pitch[across])[:, None]
    centres[..., along] = 0.5 * size[along] + np.linspace(-reach, reach, count)
    whole = np.ones(centres.shape[:2])
    high = 0.51 * yarn.height_mm
    step = 2.0 * reach / (count - 1)
    return Tubes(
        size,
        pad,
        -high,
        high,
        np.full(len(numbers), kind),
        centres,
        np.broadcast_to(np.eye(3)[along], centres.shape),
        np.broadcast_to([0.0, 0.0, 1.0], centres.shape),
        whole * yarn.width_mm,
        whole * yarn.height_mm,
        0.0 * whole,
        np.full(len(numbers), step),
        np.full(len(numbers), size[along] / step),
    )


def _pile(cloth: Cloth, size, pad, count: int):
    """Tubes of the pile: ends on a jittered lattice, and their copies beside the repeat unless ``pad`` is None."""
    pile = cloth.pile
    number = max(1, round(pile.density_per_mm2 * size[0] * size[1]))
    if number > MOST_PILE:
        raise SceneError(
            f"a repeat of '{cloth.name}' has {number} ends of pile, expected {MOST_PILE} at most"
        )
    columns = max(1, round(np.sqrt(number * size[0] / size[1])))
    rows = max(1, round(number / columns))
    rng = np.random.default_rng(5)
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"), -1).reshape(
        -1, 2
    )
    feet = (grid + 0.5 + 0.6 * (rng.random(grid.shape) - 0.5)) / [columns, rows] * size
    shift = pile.height_mm * np.tan(pile.lean)
    share = np.linspace(0.0, 1.0, FINER * (count - 1) + 1)
    narrow = np.sqrt(np.clip((1.0 - share) / TIP, 1e-4, 1.0))
    area = (
        0.5
        * (narrow[1:] + narrow[:-1])
        * np.hypot(np.diff(share) * pile.height_mm, np.diff(share**2) * shift)
    )
    area = np.append(0.0, np.cumsum(area))
    share = np.interp(np.linspace(0.0, area[-1], count), area, share)
    narrow = np.sqrt(np.clip((1.0 - share) / TIP, 1e-4, 1.0))
    reach = shift + pile.yarn.width_mm
    copies = (0, 0)
    if pad is not None:
        copies = 1 + np.ceil((pad + np.array([0.0, reach])) / size).astype(int)
    for foot in feet:
        for x in range(-copies[0], copies[0] + 1):
            for y in range(-copies[1], copies[1] + 1):
                own = foot + size * [x, y]
                low, high = own - pile.yarn.width_mm, own + np.array([pile.yarn.width_mm, reach])
                if pad is not None and ((high < -pad).any() or (low > size + pad).any()):
                    continue
                centre = np.stack(
                    [np.full(count, own[0]), own[1] + share**2 * shift, share * pile.height_mm],
                    axis=1,
                )
                yield 2, centre, narrow, pile.yarn, 0.0


def girths(tubes: Tubes, kinds: int = 3) -> np.ndarray:
    """How the area of rings grows about them from v = 0 to pi.

    Up to v there is the share S(v) - k C(v) of half a ring, times pi, where k is its bend: S is the circumference up to v,
    and C that with the weight cos v, as at a bend one side of a yarn is longer than the other.

    Returns
    -------
    (kinds, `ABOUT` + 1, 2) float64 array    S and C of each kind of yarn. [rad]
    """
    made = np.zeros((kinds, ABOUT + 1, 2))
    v = np.linspace(0.0, np.pi, FINER * ABOUT + 1)
    middle = 0.5 * (v[1:] + v[:-1])
    for kind in np.unique(tubes.kinds):
        row = np.flatnonzero(tubes.kinds == kind)[0]
        a, b = tubes.widths[row, 0], tubes.heights[row, 0]
        arc = np.hypot(a * np.cos(middle), b * np.sin(middle))
        arc *= np.pi / arc.sum()
        for column, grown in enumerate((arc, arc * np.cos(middle))):
            made[kind, 1:, column] = grown.reshape(ABOUT, FINER).sum(axis=1).cumsum()
    return made


def make_triangles(tubes: Tubes, corners: int = CORNERS) -> tuple[np.ndarray, np.ndarray]:
    """Vertices on the tubes, and triangles between them.

    Triangles 2 q and 2 q + 1 are of the quad q = (tube, ring, corner) in this order, with the vertices (r, m), (r + 1, m),
    (r + 1, m + 1) and (r, m), (r + 1, m + 1), (r, m + 1) of ring and corner.

    Returns
    -------
    (n, 3) float64 array, (m, 3) uint32 array
    """
    tube_count, rings = tubes.widths.shape
    turn = 2.0 * np.pi * np.arange(corners) / corners
    across = np.cross(tubes.tangents, tubes.ups)
    points = (
        tubes.centres[:, :, None]
        + 0.5 * tubes.heights[:, :, None, None] * np.cos(turn)[:, None] * tubes.ups[:, :, None]
        + 0.5 * tubes.widths[:, :, None, None] * np.sin(turn)[:, None] * across[:, :, None]
    ).reshape(-1, 3)
    tube, ring, corner = np.meshgrid(
        np.arange(tube_count), np.arange(rings - 1), np.arange(corners), indexing="ij"
    )
    first = (tube * rings + ring) * corners
    following = (corner + 1) % corners
    a, d = first + corner, first + following
    b, c = a + corners, d + corners
    return points, np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3).astype(np.uint32)
