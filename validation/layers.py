"""Translucent sheets painted over each other, the right one in front at every pixel."""

from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw

from .canvas import SCALE
from .facets import LOOKS, Sheet
from .view import View

LIGHTING = np.array((-0.35, 0.55, 0.75))
"""Where the light that shapes the drawing comes from: right, up, towards the eye."""

SHADES, EDGE = 61, 62
"""Steps of shading of a layer, and the entry of its table for edges."""

THIN = 0.16
"""Opacity of a sheet that would hide what must be seen, as a share of its own."""

CLEAR = ("glass", "opal", "opening", "mirror")
"""Looks that are kept: one sees through them well enough, and they are what their cases are about."""

MANY_SHEETS = 40
"""More sheets than that are merged, the smallest first."""


def paint_sheets(
    sheets: Sequence[Sheet], view: View, ground: Image.Image, hidden: np.ndarray
) -> Image.Image:
    """Paint sheets on a picture.

    Parameters
    ----------
    sheets : sequence of Sheet
    view : View
    ground : Image    ``SCALE`` times as large as the finished picture.
    hidden : (n, 3) array    Points that must not be hidden: a sheet before one of them is drawn thin. [m]
    """
    layers = []
    for sheet in _merge(sheets):
        if sheet.normal is not None:
            layers.append(_flat(sheet, view, ground.size, hidden))
        else:
            layers += _curved(sheet, view, ground.size)
    if not layers:
        return ground
    picture = np.asarray(ground).astype(np.float32)
    tables = np.stack([layer[2] for layer in layers])
    # Bands of rows keep the memory small.
    for top in range(0, len(picture), 120):
        rows = slice(top, top + 120)
        states = np.stack([layer[0][rows] for layer in layers])
        order = np.argsort(np.stack([layer[1][rows] for layer in layers]), axis=0)
        for which in order:
            state = np.take_along_axis(states, which[None], axis=0)[0]
            if state.any():
                rgba = tables[which, state]
                picture[rows] += rgba[..., 3:] * (rgba[..., :3] - picture[rows])
    return Image.fromarray(np.clip(np.round(picture), 0, 255).astype(np.uint8))


def _merge(sheets: Sequence[Sheet]) -> list[Sheet]:
    """Join the smallest sheets of each look when there are very many."""
    if len(sheets) <= MANY_SHEETS:
        return list(sheets)

    def extent(sheet):
        return np.ptp(np.concatenate(sheet.polygons), axis=0).sum()

    ranked = sorted(sheets, key=extent, reverse=True)
    kept, rest = ranked[: MANY_SHEETS // 2], ranked[MANY_SHEETS // 2 :]
    joined: dict[str, Sheet] = {}
    for sheet in rest:
        whole = joined.setdefault(sheet.look, Sheet(sheet.look, sheet.colour, []))
        whole.polygons += sheet.polygons
    return kept + list(joined.values())


def _table(look: str, colour: np.ndarray, thin: float = 1.0) -> np.ndarray:
    """Colours by state, (EDGE + 1, 4): nothing, shades from dark to light, edge."""
    table = np.zeros((EDGE + 1, 4), dtype=np.float32)
    low, high = (0.92, 1.04) if look == "glowing" else (0.50, 1.16)
    shade = np.linspace(low, high, SHADES)[:, None]
    table[1 : SHADES + 1, :3] = np.minimum(colour * shade, 255.0)
    table[1 : SHADES + 1, 3] = LOOKS[look][1] * thin
    dark = 0.72 if look == "glowing" else 0.42
    table[EDGE] = (*(dark * colour), 0.85 if thin == 1.0 else 0.35)
    return table


def _shade(normal: np.ndarray, view: View) -> int:
    """State of a face; both sides of a sheet are lit alike."""
    seen = np.array([normal @ view.right, normal @ view.up, normal @ view.toward])
    seen = seen if seen[2] >= 0.0 else -seen
    light = 0.5 + 0.5 * seen @ LIGHTING / np.linalg.norm(LIGHTING)
    return 1 + round(float(np.clip(light, 0.0, 1.0)) * (SHADES - 1))


def _flat(sheet: Sheet, view: View, size, hidden: np.ndarray):
    """States, depths and colours of a flat sheet."""
    mask = Image.new("L", size, 0)
    pen = ImageDraw.Draw(mask)
    shade = _shade(sheet.normal, view)
    for polygon in sheet.polygons:
        pen.polygon([tuple(p) for p in SCALE * view.project(polygon)], fill=shade)
    filled = np.asarray(mask)
    thin = THIN if _covers(sheet, filled, view, hidden) else 1.0
    for edge in SCALE * view.project(sheet.edges):
        pen.line([tuple(p) for p in edge], fill=EDGE, width=SCALE)
    states = np.asarray(mask)
    # The plane n.p = d solved for the distance towards the eye.
    n = sheet.normal
    slope = n @ view.toward
    if abs(slope) < 0.02:
        slope = 0.02 if slope >= 0.0 else -0.02
    x, y = _rays(view, size)
    level = n @ (sheet.polygons[0][0] - view.middle)
    depth = (level - x[None, :] * (n @ view.right) - y[:, None] * (n @ view.up)) / slope
    depth = np.where(states > 0, depth, -np.inf).astype(np.float32)
    return states, depth, _table(sheet.look, sheet.colour, thin)


def _covers(sheet: Sheet, filled: np.ndarray, view: View, hidden: np.ndarray) -> bool:
    """Whether a sheet lies between the eye and a point that must be seen."""
    if not len(hidden) or sheet.look in CLEAR:
        return False
    side = (hidden - sheet.polygons[0][0]) @ sheet.normal
    behind = side * np.sign(sheet.normal @ view.toward) < -1e-3 * (
        np.ptp(hidden, axis=0).max() + 1e-9
    )
    places = np.round(SCALE * view.project(hidden)).astype(int)
    inside = (
        (places >= 0).all(axis=1)
        & (places[:, 0] < filled.shape[1])
        & (places[:, 1] < filled.shape[0])
    )
    chosen = places[behind & inside]
    return bool(filled[chosen[:, 1], chosen[:, 0]].any())


def _curved(sheet: Sheet, view: View, size):
    """Layers of a bent surface: its far and its near side, each hiding itself."""
    sides = ([], [])
    for polygon in sheet.polygons:
        normal = np.cross(polygon[1] - polygon[0], polygon[-1] - polygon[0])
        length = np.linalg.norm(normal)
        if length > 0.0:
            sides[int(normal @ view.toward > 0.0)].append((polygon, normal / length))
    return [_side(sheet, side, view, size) for side in sides if side]


def _side(sheet: Sheet, polygons, view: View, size):
    states = np.zeros((size[1], size[0]), dtype=np.uint8)
    depth = np.full(states.shape, -np.inf, dtype=np.float32)
    x, y = _rays(view, size)
    for polygon, normal in polygons:
        places = SCALE * view.project(polygon)
        low = np.clip(np.floor(places.min(axis=0)).astype(int), 0, np.array(size) - 1)
        high = np.clip(np.ceil(places.max(axis=0)).astype(int) + 1, low + 1, size)
        mask = Image.new("L", tuple(int(v) for v in high - low), 0)
        ImageDraw.Draw(mask).polygon([tuple(p) for p in places - low], fill=1)
        rows, columns = slice(low[1], high[1]), slice(low[0], high[0])
        slope = normal @ view.toward
        slope = np.copysign(max(abs(slope), 0.02), slope)
        level = normal @ (polygon[0] - view.middle)
        plane = (
            level - x[None, columns] * (normal @ view.right) - y[rows, None] * (normal @ view.up)
        ) / slope
        ends = (polygon - view.middle) @ view.toward
        plane = np.clip(plane, ends.min(), ends.max())
        front = (np.asarray(mask) > 0) & (plane > depth[rows, columns])
        states[rows, columns][front] = _shade(normal, view)
        depth[rows, columns][front] = plane[front]
    return states, depth, _table(sheet.look, sheet.colour, 0.5)


def _rays(view: View, size) -> tuple[np.ndarray, np.ndarray]:
    """Distances from the middle along right (w,) and up (h,) of each column and row. [m]"""
    x = ((np.arange(size[0]) + 0.5) / SCALE - view.place[0]) / view.scale
    y = (view.place[1] - (np.arange(size[1]) + 0.5) / SCALE) / view.scale
    return x, y
