"""Write the photometric files and ``luminaires.json`` of this folder.

``python -m lumenray.libraries.luminaires.make_luminaires`` writes them where they lie, with ``-o`` elsewhere.

All distributions are formulas (`make_distributions`) with the numbers stated here; none is measured, none is copied from a
product. Fluxes, watts and sizes are those of usual products of their kind. The same sources give the same bytes.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from . import make_distributions as shapes
from .make_files import Photometry, write_ies, write_ldt
from .make_lamps import LAMPS

FOLDER = Path(__file__).parent

DEFAULTS = {
    "format": 1,
    "maker": "Lumenray",
    "licence": "CC0-1.0",
    "author": "The Lumenray developers",
}
"""What holds for all models of the library."""

COLOURS = {
    "LED-B1": ("2733 K", "80"),
    "LED-B2": ("2998 K", "80"),
    "LED-B3": ("4103 K", "80"),
    "LED-B4": ("5109 K", "80"),
    "LED-B5": ("6598 K", "80"),
    "LED-BH1": ("2851 K", "90"),
    "FL11": ("4000 K", "80"),
    "A": ("2856 K", "100"),
}
"""Correlated colour temperature (CIE 15:2018, tables of illuminants) and class of rendering of the spectra."""


def steps(*parts) -> np.ndarray:
    """Angles of several even parts (first, last, step), each once. [degree]"""
    angles = [np.arange(first, last + step / 2.0, step) for first, last, step in parts]
    return np.unique(np.round(np.concatenate(angles), 6))


def mirrored(angles: np.ndarray) -> np.ndarray:
    """Angles and their negatives."""
    return np.unique(np.concatenate([-angles, angles]))


HALF = steps((0.0, 90.0, 2.5))
"""Polar angles of light that only goes down. [degree]"""

WHOLE = steps((0.0, 180.0, 2.5))
"""Polar angles of light that goes all around. [degree]"""

AROUND = steps((0.0, 360.0, 10.0))
"""C planes of smooth distributions. [degree]"""

FINE = steps((0.0, 360.0, 5.0))
"""C planes of distributions with edges. [degree]"""

LEVEL = np.zeros(1)
"""The one plane of rotational ones. [degree]"""


class Model:
    """One luminaire of the library: its file and what the catalogue says."""

    def __init__(self, name, category, title, description, spectrum, photometry, **more):
        self.name, self.extension = name, more.pop("extension", "ies")
        if isinstance(spectrum, str):
            spectrum = {"illuminant": spectrum}
        colour, rendering = COLOURS.get(spectrum.get("illuminant"), ("", ""))
        self.photometry = Photometry(**photometry, colour=colour, rendering=rendering)
        self.entry = {
            "file": f"photometry/{name}.{self.extension}",
            "title": title,
            "description": description,
            "category": category,
            "spectrum": spectrum,
            "luminous_flux_lm": self.photometry.flux,
            "watts": self.photometry.watts,
            **more,
        }

    def content(self) -> bytes:
        """Return the bytes of the photometric file."""
        write = {"ies": write_ies, "ldt": write_ldt}[self.extension]
        # Both formats are plain ASCII here.
        return write(self.photometry, self.name, self.entry["title"].replace("°", " deg"))


def _round(formula, vertical, flux, watts, diameter, **more):
    """Rotational, of type C, from a disk."""
    return {
        "formula": formula,
        "kind": "C",
        "symmetry": "rotational",
        "horizontal": LEVEL,
        "vertical": vertical,
        "flux": flux,
        "watts": watts,
        "opening": ("ellipse", (diameter, diameter, 0.0)),
        **more,
    }


def _planes(formula, symmetry, vertical, flux, watts, sides, **more):
    """Of type C by planes, from a rectangle with sides along x and y."""
    return {
        "formula": formula,
        "kind": "C",
        "symmetry": symmetry,
        "horizontal": more.pop("horizontal", AROUND),
        "vertical": vertical,
        "flux": flux,
        "watts": watts,
        "opening": ("rectangle", (*sides, 0.0)),
        **more,
    }


def _downlight(width, flux, watts, diameter, spectrum, cut=(90.0, 90.1)):
    fine = width / 30.0 if width < 40 else 1.0
    vertical = steps((0.0, min(2.0 * width, 90.0), fine), (50.0, 90.0, 2.5))
    return Model(
        f"downlight_{width}",
        "Indoor/General/Downlights",
        f"Downlight {width}°",
        f"Recessed LED downlight whose intensity falls to half at {width / 2:g} degrees from the axis.",
        spectrum,
        _round(shapes.beam(width, *cut), vertical, flux, watts, diameter),
        mount="ceiling",
        tags=["downlight", "recessed", "LED"],
    )


def luminaires() -> list[Model]:
    """Return all models of one emitter."""
    return [*_indoor(), *_workplaces(), *_living(), *_outdoor(), *_others()]


def _indoor() -> list[Model]:
    return [
        _downlight(15, 900.0, 10.5, 0.06, "LED-B2"),
        _downlight(24, 1200.0, 12.0, 0.07, "LED-B2"),
        _downlight(40, 1500.0, 14.0, 0.09, "LED-B3"),
        _downlight(60, 2000.0, 18.0, 0.14, "LED-B3", (55.0, 72.0)),
        _downlight(90, 2400.0, 20.0, 0.17, "LED-B3", (60.0, 80.0)),
        Model(
            "wall_washer",
            "Indoor/Accent/Wall washers",
            "Wall washer",
            "Recessed LED wall washer; C90 (+y) points to the wall, at about a third of the wall's height from it.",
            "LED-B3",
            _planes(shapes.wall_washer, "none", HALF, 2500.0, 22.0, (0.24, 0.06), horizontal=FINE),
            mount="ceiling",
            tags=["wall washer", "asymmetric", "recessed", "LED"],
        ),
        Model(
            "spot_6",
            "Indoor/Accent/Spots",
            "Accent spot 6°",
            "Narrow LED spotlight for small things from afar; half its peak at 3 degrees.",
            "LED-BH1",
            _round(
                shapes.beam(6.0), steps((0, 9, 0.2), (9, 20, 1), (20, 90, 10)), 450.0, 7.0, 0.045
            ),
            mount="aimed",
            tags=["spot", "accent", "museum", "LED"],
        ),
        Model(
            "pencil_beam_2",
            "Indoor/Accent/Spots",
            "Pencil beam 2°",
            "Effect projector with a beam of 2 degrees.",
            "LED-B4",
            _round(
                shapes.beam(2.0), steps((0, 3, 0.05), (3, 6, 0.5), (10, 90, 10)), 120.0, 5.0, 0.04
            ),
            mount="aimed",
            tags=["spot", "effect", "stage", "LED"],
        ),
        Model(
            "track_oval",
            "Indoor/Retail/Track",
            "Track spot with oval lens 60° x 15°",
            "Track-mounted LED spotlight that draws a band, wide along its local x axis.",
            "LED-BH1",
            {
                "formula": shapes.elliptic_beam(30.0, 7.5, 0.004),
                "kind": "B",
                "symmetry": "right",
                "horizontal": mirrored(steps((0, 60, 2.5), (60, 90, 10))),
                "vertical": mirrored(steps((0, 22.5, 1.25), (25, 40, 5), (50, 90, 10))),
                "flux": 1800.0,
                "watts": 19.0,
                "opening": ("ellipse", (0.08, 0.08, 0.0)),
            },
            mount="aimed",
            tags=["spot", "track", "shop", "type B", "LED"],
        ),
    ]


def _workplaces() -> list[Model]:
    return [
        Model(
            "batwing_office",
            "Indoor/Office/Suspended",
            "Linear office luminaire, batwing",
            "Direct light in two wings across the luminaire, which keep reflections off the screen and the desk evenly lit.",
            "LED-B3",
            _planes(shapes.batwing, "quadrant", HALF, 4000.0, 29.0, (0.06, 1.17), horizontal=FINE),
            extension="ldt",
            mount="pendant",
            tags=["office", "linear", "batwing", "LED"],
        ),
        Model(
            "pendant_direct_indirect",
            "Indoor/Office/Suspended",
            "Linear pendant, direct and indirect",
            "Suspended line: 55 % of the light on the desk, 45 % on the ceiling.",
            "LED-B3",
            _planes(
                shapes.direct_indirect(0.55),
                "quadrant",
                WHOLE,
                6000.0,
                42.0,
                (0.06, 1.5),
                horizontal=FINE,
            ),
            extension="ldt",
            mount="pendant",
            tags=["office", "linear", "pendant", "indirect", "LED"],
        ),
        Model(
            "linear_indirect",
            "Indoor/Office/Suspended",
            "Linear pendant, indirect",
            "Suspended line that lights the ceiling only, evenly.",
            "LED-B3",
            _planes(
                shapes.uplight_line(1),
                "quadrant",
                steps((90.0, 180.0, 2.5)),
                5000.0,
                36.0,
                (1.45, 0.06),
                horizontal=FINE,
            ),
            mount="pendant",
            tags=["office", "linear", "pendant", "indirect", "LED"],
        ),
        Model(
            "troffer_600_prismatic",
            "Indoor/Office/Recessed",
            "Recessed luminaire 600 x 600, micro-prisms",
            "LED luminaire for the grid ceiling; below 3000 cd/m2 from 65 degrees on, as screens need it.",
            "LED-B3",
            _planes(shapes.prismatic, "quadrant", HALF, 3600.0, 28.0, (0.57, 0.57)),
            mount="ceiling",
            tags=["office", "recessed", "troffer", "UGR", "LED"],
        ),
        Model(
            "panel_600_opal",
            "Indoor/Office/Recessed",
            "Recessed panel 600 x 600, opal",
            "LED panel with an opal cover: the same luminance from everywhere.",
            "LED-B3",
            {
                **_round(shapes.lambertian, HALF, 3800.0, 30.0, 0.0),
                "opening": ("rectangle", (0.57, 0.57, 0.0)),
            },
            mount="ceiling",
            tags=["office", "recessed", "panel", "LED"],
        ),
        Model(
            "desk_task_light",
            "Indoor/Office/Task lights",
            "Desk task light",
            "Head of a desk lamp; C90 (+y) points away from the foot.",
            "LED-B3",
            _planes(shapes.task, "none", HALF, 650.0, 8.0, (0.22, 0.06)),
            mount="table",
            height_m=0.45,
            tags=["desk", "task", "asymmetric", "LED"],
        ),
        Model(
            "high_bay",
            "Indoor/Industry/High bays",
            "High bay luminaire 80°",
            "LED luminaire for halls of 8 m and more.",
            "LED-B4",
            _round(shapes.beam(80.0, 58.0, 80.0), steps((0, 90, 1)), 20000.0, 140.0, 0.35),
            mount="open",
            height_m=9.0,
            tags=["industry", "high bay", "LED"],
        ),
        Model(
            "low_bay_wide",
            "Indoor/Industry/Low bays",
            "Low bay luminaire, wide",
            "LED luminaire for low halls: even on the floor out to 45 degrees.",
            "LED-B4",
            _round(shapes.even_floor(45.0, 74.0), steps((0, 90, 1)), 12000.0, 95.0, 0.40),
            mount="open",
            height_m=5.0,
            tags=["industry", "low bay", "batwing", "LED"],
        ),
        Model(
            "batten_t8_36w",
            "Indoor/Industry/Battens",
            "Bare batten 1 x T8 36 W",
            "Bare fluorescent tube below a narrow channel, along its local x axis.",
            "FL11",
            {
                "formula": shapes.batten,
                "kind": "C",
                "symmetry": "quadrant",
                "horizontal": FINE,
                "vertical": WHOLE,
                "flux": 3015.0,
                "watts": 36.0,
                "opening": ("cylinder", (1.16, 0.026, 0.026)),
                "lamp": "T8 36 W/840",
                "lamp_flux": 3350.0,
            },
            mount="ceiling",
            drop_m=0.1,
            tags=["industry", "batten", "fluorescent", "T8"],
        ),
        Model(
            "escape_route",
            "Indoor/Safety/Escape routes",
            "Escape route luminaire",
            "Emergency luminaire that lights a band of the floor along its local x axis.",
            "LED-B5",
            _planes(
                shapes.escape_route, "quadrant", HALF, 220.0, 4.0, (0.05, 0.05), horizontal=FINE
            ),
            extension="ldt",
            mount="open",
            tags=["emergency", "escape route", "LED"],
        ),
        Model(
            "step_light",
            "Indoor/Circulation/Stairs",
            "Step light",
            "Recessed in the wall beside a stair; C90 (+y) points out of the wall.",
            "LED-B1",
            _planes(shapes.step, "none", HALF, 70.0, 1.6, (0.10, 0.02), horizontal=FINE),
            mount="wall",
            height_m=0.35,
            tags=["stair", "orientation", "asymmetric", "LED"],
        ),
    ]


def _living() -> list[Model]:
    return [
        Model(
            "opal_globe_300",
            "Indoor/Living/Pendants",
            "Opal globe 300 mm",
            "Sphere of opal glass on a suspension.",
            "LED-B1",
            _round(
                shapes.globe,
                WHOLE,
                1000.0,
                11.0,
                0.0,
                opening=("ellipsoid", (0.3, 0.3, 0.3)),
            ),
            mount="pendant",
            tags=["globe", "opal", "pendant", "decorative"],
        ),
        Model(
            "torchiere",
            "Indoor/Living/Floor lamps",
            "Torchiere",
            "Floor lamp with a linear halogen lamp whose bowl lights the ceiling.",
            "A",
            _round(
                shapes.torchiere,
                steps((90, 180, 2.5)),
                2640.0,
                200.0,
                0.25,
                lamp="QT-DE 12 200 W",
                lamp_flux=3520.0,
            ),
            mount="floor",
            height_m=1.8,
            tags=["floor lamp", "uplight", "halogen"],
        ),
        Model(
            "candle",
            "Indoor/Living/Candles",
            "Candle flame",
            "Flame of a candle, 12 x 35 mm, about one candela to the side.",
            {"blackbody_K": 1900.0},
            _round(
                shapes.flame(0.006, 0.035),
                WHOLE,
                10.0,
                0.0,
                0.0,
                opening=("ellipsoid", (0.012, 0.012, 0.035)),
                lamp="Candle",
            ),
            mount="table",
            height_m=0.2,
            tags=["candle", "flame", "decorative"],
        ),
    ]


def _outdoor() -> list[Model]:
    return [
        Model(
            "street_type_2",
            "Outdoor/Roads",
            "Street luminaire, type II",
            "For roads as wide as the mast is high; C90 (+y) points to the road.",
            "LED-B3",
            _planes(
                shapes.street(14.0, 67.0, 11.0, 6.5, 0.5),
                "C90-C270",
                HALF,
                8000.0,
                62.0,
                (0.30, 0.20),
                horizontal=FINE,
            ),
            extension="ldt",
            mount="open",
            height_m=8.0,
            tags=["street", "road", "type II", "LED"],
        ),
        Model(
            "street_type_3",
            "Outdoor/Roads",
            "Street luminaire, type III",
            "For roads wider than the mast is high; C90 (+y) points to the road.",
            "LED-B3",
            _planes(
                shapes.street(30.0, 69.0, 13.0, 6.5, 0.8),
                "none",
                HALF,
                12000.0,
                90.0,
                (0.35, 0.25),
                horizontal=FINE,
            ),
            mount="open",
            height_m=10.0,
            tags=["street", "road", "type III", "LED"],
        ),
        Model(
            "post_top",
            "Outdoor/Paths/Post tops",
            "Post-top luminaire",
            "Lantern on a low mast for paths and squares; no light above the horizontal.",
            "LED-B2",
            _round(
                shapes.ring(62.0, 17.0, 0.35, 72.0, 88.0),
                HALF,
                3200.0,
                28.0,
                0.0,
                opening=("cylinder", (0.2, 0.2, 0.25)),
            ),
            mount="open",
            height_m=4.0,
            tags=["pedestrian", "path", "post top", "LED"],
        ),
        Model(
            "bollard",
            "Outdoor/Paths/Bollards",
            "Bollard",
            "Low luminaire beside a path, all around and below the horizontal.",
            "LED-B2",
            _round(
                shapes.ring(68.0, 12.0, 0.10, 74.0, 89.0),
                HALF,
                600.0,
                8.0,
                0.0,
                opening=("cylinder", (0.16, 0.16, 0.06)),
            ),
            mount="open",
            height_m=0.9,
            tags=["path", "garden", "bollard", "LED"],
        ),
        Model(
            "flood_narrow",
            "Outdoor/Floodlights",
            "Floodlight, symmetrical, 14°",
            "Sports and building floodlight; type B photometry.",
            "LED-B4",
            {
                "formula": shapes.elliptic_beam(7.0, 7.0, 0.002),
                "kind": "B",
                "symmetry": "right",
                "horizontal": mirrored(steps((0, 21, 1), (25, 40, 5), (50, 90, 10))),
                "vertical": mirrored(steps((0, 21, 1), (25, 40, 5), (50, 90, 10))),
                "flux": 90000.0,
                "watts": 750.0,
                "opening": ("rectangle", (0.5, 0.5, 0.0)),
            },
            mount="aimed",
            height_m=12.0,
            tags=["flood", "sports", "facade", "type B", "LED"],
        ),
        Model(
            "flood_asymmetric",
            "Outdoor/Floodlights",
            "Floodlight, asymmetric",
            "Mounted with its glass level it throws its beam 55 degrees towards C90 (+y) and none to the sky.",
            "LED-B3",
            _planes(
                shapes.asymmetric_flood,
                "C90-C270",
                HALF,
                20000.0,
                160.0,
                (0.35, 0.25),
                horizontal=FINE,
            ),
            extension="ldt",
            mount="open",
            height_m=12.0,
            tags=["flood", "area", "asymmetric", "LED"],
        ),
        Model(
            "wall_up_down",
            "Outdoor/Facades",
            "Wall luminaire up and down",
            "Two equal fluxes along a wall: 40 degrees down, 24 degrees up.",
            "LED-B2",
            _round(
                shapes.beams(40.0, 24.0),
                steps((0, 90, 1.25), (90, 180, 1.25)),
                900.0,
                11.0,
                0.0,
                opening=("cylinder", (0.09, 0.09, 0.18)),
            ),
            mount="wall",
            height_m=1.4,
            tags=["facade", "wall", "up and down", "LED"],
        ),
        Model(
            "bulkhead",
            "Outdoor/Bulkheads",
            "Bulkhead",
            "Opal drum, 280 mm wide and 90 mm deep, on a ceiling or a wall.",
            "LED-B3",
            _round(
                shapes.drum(0.28, 0.09),
                steps((0, 95, 2.5), (180, 180, 1)),
                1100.0,
                12.0,
                0.0,
                opening=("cylinder", (0.28, 0.28, 0.09)),
            ),
            extension="ldt",
            mount="ceiling",
            drop_m=0.05,
            tags=["bulkhead", "opal", "cellar", "LED"],
        ),
    ]


def _others() -> list[Model]:
    return [
        Model(
            "headlamp_low_beam",
            "Vehicles/Headlamps",
            "Headlamp, low beam",
            "Passing beam for traffic on the right with its cut-off; type A photometry.",
            "LED-B5",
            {
                "formula": shapes.low_beam,
                "kind": "A",
                "symmetry": "none",
                "horizontal": mirrored(
                    steps((0, 8, 0.5), (8, 20, 1), (20, 40, 2.5), (40, 60, 5), (60, 90, 10))
                ),
                "vertical": steps(
                    (-90, -30, 10),
                    (-30, -10, 2.5),
                    (-10, -3, 0.5),
                    (-3, 3, 0.25),
                    (-1, 0.25, 0.125),
                    (3, 10, 1),
                    (10, 30, 5),
                    (30, 90, 10),
                ),
                "flux": 900.0,
                "watts": 20.0,
                "opening": ("rectangle", (0.12, 0.06, 0.0)),
            },
            mount="level",
            height_m=0.7,
            tags=["vehicle", "headlamp", "low beam", "type A", "LED"],
        ),
    ]


def catalogue() -> dict:
    """Return the content of ``luminaires.json``."""
    return {
        **DEFAULTS,
        "models": [model.entry for model in luminaires()] + [lamp.entry for lamp in LAMPS],
    }


def write(folder: Path) -> list[Path]:
    """Write all files; return them."""
    (folder / "photometry").mkdir(parents=True, exist_ok=True)
    paths = []
    for item in (*luminaires(), *LAMPS):
        path = folder / item.entry["file"]
        path.write_bytes(item.content())
        paths.append(path)
    path = folder / "luminaires.json"
    text = json.dumps(catalogue(), indent=1, ensure_ascii=False)
    path.write_bytes(f"{text}\n".encode())
    return [*paths, path]


def main() -> None:
    """Write the library."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=FOLDER, help="folder for the files")
    for path in write(parser.parse_args().output):
        print(f"{path}  {path.stat().st_size / 1e3:.1f} kB")


if __name__ == "__main__":
    main()
