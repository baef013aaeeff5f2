"""What can be added to a paint: constituents of the libraries, and a few descriptions to begin with.

Users' constituents are written out where they are used, so that files with such paints need no other file.
"""

from copy import deepcopy

from ...engine.errors import LumenrayError
from ...engine.paint.reader import known_constituents, parse_paint, settle_names
from ..foundation import preferences

AMOUNT = {"flakes": {"mass_fraction": 0.08}, "pigments": {"volume_fraction": 0.02}}
"""Of a constituent that states none."""

BEGINNINGS = {
    "flakes": {
        "Aluminium flakes": {
            "mirror": {"index": "aluminium", "thickness_nm": 100},
            "density_g_per_cm3": 2.7,
            "amount": {"mass_fraction": 0.08},
            "tilt_deg": 5,
            "diameter": {"median_um": 12, "log_spread": 0.4},
        },
        "Interference flakes": {
            "stack": {
                "core": {"index": "silica", "thickness_nm": 400},
                "coatings": [{"index": "rutile", "thickness_nm": 90}],
            },
            "density_g_per_cm3": 3.0,
            "amount": {"mass_fraction": 0.1},
            "tilt_deg": 4,
            "diameter": {"median_um": 12, "log_spread": 0.4},
        },
    },
    "pigments": {
        "White grains": {
            "grains": {"index": "rutile", "diameter": {"median_um": 0.25, "log_spread": 0.2}},
            "amount": {"volume_fraction": 0.02},
            "density_g_per_cm3": 4.2,
        },
        "Black pigment": {"medium": {"extinction_per_um": 0.3, "albedo": 0.02, "asymmetry": 0.0}},
    },
}
"""Parts to begin with, by kind and name."""


def known() -> dict[str, dict]:
    """Return the constituents that ship and those of the user, as of `known_constituents`.

    Raises
    ------
    FileFormatError    The user's file cannot be read.
    """
    path = preferences.constituents()
    return known_constituents([path] if path is not None else ())


def names_of(kind: str) -> list[str]:
    """Return the names of what can be added of a kind, ours first; raises as `known`."""
    return [*BEGINNINGS[kind], *known()[kind]]


def new_part(kind: str, name: str) -> dict:
    """Return the description of a part; the first there is where no name is given.

    Raises
    ------
    LumenrayError    There is none of the name; or as `known`.
    """
    name = name or next(iter(BEGINNINGS[kind]))
    if name in BEGINNINGS[kind]:
        return {"name": name} | deepcopy(BEGINNINGS[kind][name])
    constituents = known()
    stated = constituents[kind].get(name)
    if stated is None:
        raise LumenrayError(f"there is no '{name}' among the {kind} of the library")
    content = {"constituent": name}
    if "medium" not in stated and "amount" not in stated:
        content["amount"] = dict(AMOUNT[kind])
    path = preferences.constituents()
    if path is None:
        return content
    layer = {"thickness_um": 10, "binder": {"index": 1.5}, kind: [content]}
    whole = {
        "lumenray_paint": 1,
        "name": name,
        "layers": [layer],
        "substrate": {"reflectance": 0.0},
    }
    whole = settle_names(parse_paint(whole, constituents, path).content, constituents)
    return whole["layers"][0][kind][0]


def new_layer() -> dict:
    """Return the description of a layer of clear binder."""
    return {"name": "Clear coat", "thickness_um": 40, "binder": {"index": 1.5}}
