"""The command ``lumenray brdf check``: energy, reciprocity and stated totals of scattering files."""

from ..file_list import add_files, tell_each
from ..output import percent
from .file import add_tolerance, open_scattering, totals_of

ENERGY_ROUNDING = 0.01
"""By which a total may exceed 1: what instruments and integration leave open. [-]"""

STATED_TOLERANCE = 0.02
"""By which totals may differ from what the file itself states. [-]"""

STEEP_INCIDENCE = 45.0
"""Data for less than this angle of incidence tell little of a room, where most light comes from the side. [deg]"""


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    check = tasks.add_parser("check", help="energy, reciprocity, stated totals; 1 if one is bad")
    add_files(check, "scattering file", "*.xml")
    add_tolerance(check)
    check.set_defaults(run=run)


def run(options) -> int:
    """Judge files; return the exit code, 1 if one is bad."""
    from ...engine.scattering.file_names import ENDINGS

    return tell_each(
        options,
        ENDINGS,
        lambda name: {"checks": judge(open_scattering(options, name))},
        tell,
        is_good=lambda row: all(check["good"] for check in row["checks"]),
    )


def tell(row: dict) -> str:
    """Text for people about the checks of a file."""
    lines = [
        f"  {'good' if check['good'] else 'BAD':<6}{check['what']:<16}{check['text']}"
        for check in row["checks"]
    ]
    return "\n".join([row["file"], *lines])


def judge(file) -> list[dict]:
    """Check a file: rows with ``what``, ``good`` and ``text``."""
    import numpy as np

    from ...engine.scattering.data.evaluation import (
        GOOD_RECIPROCITY,
        incidences_of,
        measure_reciprocity,
    )
    from ...engine.scattering.data.surface import excess_of

    made = []

    def add(what, good, text):
        made.append({"what": what, "good": bool(good), "text": text})

    for side in ("front", "back"):
        parts = [file.sides.get(f"{side}_{kind}") for kind in ("reflection", "transmission")]
        if any(part is not None for part in parts):
            excess = excess_of(*parts)
            text = f"{side}: at most {percent(excess, '.2f')} of the light leaves again"
            if excess > 1.0 + ENERGY_ROUNDING:
                text += "; values look like luminance factors or per cent, or are badly calibrated"
            add("energy", excess <= 1.0 + ENERGY_ROUNDING, text)
    for side in ("front", "back"):
        scatter = file.sides.get(f"{side}_reflection")
        if scatter is not None:
            found = measure_reciprocity(scatter)
            add(
                "reciprocity",
                found.worst <= GOOD_RECIPROCITY,
                f"{side}: {_tell_reciprocity(found)}",
            )
    both = [file.sides.get(f"{side}_transmission") for side in ("front", "back")]
    if all(part is not None for part in both):
        found = measure_reciprocity(*both)
        text = f"transmission of both sides: {_tell_reciprocity(found)}"
        add("reciprocity", found.worst <= GOOD_RECIPROCITY, text)
    for side, stated in file.stated.items():
        if np.isfinite(stated).any():
            worst, incidence = _off_by(file, side, stated)
            text = (
                f"{side.replace('_', ' ')}: the file's values are at most {percent(worst, '.2f')} from the totals "
                f"that it states (at {np.degrees(incidence):.3g} deg)"
            )
            add("stated totals", worst <= STATED_TOLERANCE, text)
    for side, scatter in file.sides.items():
        last = float(np.degrees(incidences_of(scatter)[-1]))
        text = f"{side.replace('_', ' ')}: data up to {last:.4g} deg; beyond, the last hold"
        add("incidences", last >= STEEP_INCIDENCE, text)
    return made


def _tell_reciprocity(found) -> str:
    return (
        f"residual {percent(found.residual)}, beside peaks {percent(found.scattered)}, largest difference "
        f"{percent(found.largest)} of the largest value"
    )


def _off_by(file, side: str, stated) -> tuple[float, float]:
    """Largest difference of stated totals from those of the values as they stand in the file [-], and its incidence [rad].

    Readers bring values to stated totals; what these were before, the factors tell.
    """
    import numpy as np

    known = np.isfinite(stated)
    places = file.incidences[known]
    factors = file.factors.get(side)
    if factors is None:
        differences = np.abs(totals_of(file.sides[side], file.incidences) - stated)[known]
    else:
        told = np.interp([place for place, _ in factors], places, stated[known])
        differences = np.abs(told * (1.0 - 1.0 / np.array([factor for _, factor in factors])))
        places = np.array([place for place, _ in factors])
    worst = int(np.argmax(differences)) if len(differences) else 0
    return (float(differences[worst]), float(places[worst])) if len(differences) else (0.0, 0.0)
