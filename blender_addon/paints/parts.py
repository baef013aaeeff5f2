"""What can be added to a paint: constituents of the library, and a few descriptions to begin with."""

from copy import deepcopy

from ...engine.errors import LumenrayError
from ...engine.paint.reader import known_constituents

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


def names_of(kind: str) -> list[str]:
    """Return the names of what can be added of a kind, ours first."""
    return [*BEGINNINGS[kind], *known_constituents()[kind]]


def new_part(kind: str, name: str) -> dict:
    """Return the description of a part; the first there is where no name is given.

    Raises
    ------
    LumenrayError    There is none of the name.
    """
    name = name or next(iter(BEGINNINGS[kind]))
    if name in BEGINNINGS[kind]:
        return {"name": name} | deepcopy(BEGINNINGS[kind][name])
    known = known_constituents()[kind]
    if name not in known:
        raise LumenrayError(f"there is no '{name}' among the {kind} of the library")
    content = {"constituent": name}
    if "medium" not in known[name] and "amount" not in known[name]:
        content["amount"] = dict(AMOUNT[kind])
    return content


def new_layer() -> dict:
    """Return the description of a layer of clear binder."""
    return {"name": "Clear coat", "thickness_um": 40, "binder": {"index": 1.5}}
