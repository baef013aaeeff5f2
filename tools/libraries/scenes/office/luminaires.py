"""The lights of the office and what holds them: four LED panels and a desk lamp."""

import numpy as np

from ..assembly import Assembly
from ..shapes import Part, blocks, curve, cylinder, lathe, quad, tube
from ..staging import new_light
from . import room
from .furniture import PLACES, on_desk

PANEL_FLUX = 3600.0
"""Of one LED panel. [lm]"""

PANEL_SIDE = 0.55
"""Luminous side of an LED panel. [m]"""

LAMP_FLUX = 350.0
"""Of the lamp in the desk lamp, a 60 W replacement. [lm]"""

LAMP_AT = ("A", -0.60, -0.22)
"""Desk, and place on it, of the desk lamp's foot. [m]"""


def _panel(index, center, palette, collection):
    """Build one recessed panel: housing, rim, opal sheet, and the light just below that."""
    half, bottom = 0.2955, room.HEIGHT + 0.0010
    inner = PANEL_SIDE / 2 + 0.003
    edges = (-half, -inner, inner, half)
    rim = blocks(edges, edges, (bottom, bottom + 0.008), lambda i, j, _: (i, j) != (1, 1))
    edges = (-half, -half + 0.001, half - 0.001, half)
    levels = (bottom + 0.0085, bottom + 0.05, bottom + 0.051)
    pan = blocks(edges, edges, levels, lambda i, j, k: k == 1 or (i, j) != (1, 1))
    side = 2.0 * inner + 0.02
    sheet = quad((-side / 2, -side / 2, bottom + 0.0083), (0, side, 0), (side, 0, 0))
    item = Assembly().add(palette["White Steel"], rim, pan).add(palette["Opal Diffuser"], sheet)
    item.build(f"LED Panel {index} Housing", collection, (*center, 0.0))
    light = new_light(
        f"LED Panel {index}",
        "AREA",
        collection,
        (*center, bottom - 0.0003),
        "LUMINOUS_FLUX",
        PANEL_FLUX,
        "ILLUMINANT",
        illuminant="LED-B4",
    )
    light.data.shape = "SQUARE"
    light.data.size = PANEL_SIDE


def _desk_lamp(palette, collection):
    """Build the lamp; its own +y points to the user, its shade hangs over the desk."""
    foot = [(0.0, 0.0), (0.088, 0.0), (0.092, 0.004), (0.092, 0.012), (0.084, 0.018)]
    foot += [(0.030, 0.024), (0.016, 0.032), (0.012, 0.045), (0.0, 0.045)]
    lamp = Assembly().add(palette["Lamp Green"], lathe(foot, 64))
    lower = np.array([(0.0, 0.0, 0.04), (0.0, -0.05, 0.27)])
    elbow = [
        (0, -0.05, 0.27),
        (0, 0.02, 0.40),
        (0, 0.09, 0.455),
        (0, 0.15, 0.462),
        (0, 0.168, 0.448),
    ]
    upper = curve(elbow, 8)
    lamp.add(palette["Brass"], tube(lower, 0.006, 16), tube(upper, 0.006, 16))
    joint = cylinder(0.013, 0.024, 32, 0.003).turned("y", 90.0)
    lamp.add(palette["Brass"], joint.moved(-0.012, -0.05, 0.27))
    at = (0.0, 0.17, 0.30)
    outer = [(0.100, 0.0), (0.0985, 0.012), (0.088, 0.045), (0.070, 0.078), (0.045, 0.105)]
    outer += [(0.026, 0.120)]
    inner = [(r - 0.0022, z - 0.0012) for r, z in outer[-2:0:-1]]
    shade = lathe([*outer, (0.024, 0.120), *inner, (0.0978, 0.0)], 64)
    # The faces follow the profile: first the enamel outside, then the rims and the white inside.
    outside = 64 * (len(outer) - 1)
    for name, faces in (
        ("Lamp Green", shade.faces[:outside]),
        ("Porcelain", shade.faces[outside:]),
    ):
        lamp.add(palette[name], Part(shade.points, faces).moved(*at))
    socket = [(0.0, 0.100), (0.015, 0.100), (0.019, 0.104), (0.0235, 0.112), (0.0265, 0.1215)]
    socket += [(0.0265, 0.132), (0.018, 0.142), (0.010, 0.150), (0.0, 0.150)]
    lamp.add(palette["Brass"], lathe(socket, 48).moved(*at))
    cord = [
        (0.0, -0.085, 0.008),
        (0.0, -0.12, 0.004),
        (0.03, -0.15, 0.0035),
        # It disappears in the joint of the two desks.
        (0.05, -0.175, 0.0045),
        (0.05, -0.188, -0.004),
        (0.05, -0.190, -0.080),
    ]
    lamp.add(palette["Rubber"], tube(curve(cord, 6), 0.003, 8))
    desk, x, y = LAMP_AT
    turn = PLACES[desk][1]
    lamp.build("Desk Lamp", collection, on_desk(desk, x, y), turn)
    bulb = on_desk(desk, x + at[0], y + at[1], at[2] + 0.048)
    light = new_light(
        "Desk Lamp Bulb",
        "POINT",
        collection,
        bulb,
        "LUMINOUS_FLUX",
        LAMP_FLUX,
        "BLACKBODY",
        colour_temperature=2700.0,
    )
    light.data.shadow_soft_size = 0.03
    light.data.color = (1.0, 0.62, 0.32)


def build_luminaires(palette, collection):
    """Build the luminaires and their lights."""
    for index, center in enumerate(room.panel_centers(), start=1):
        _panel(index, center, palette, collection)
    _desk_lamp(palette, collection)
