"""Luminaires: agreement with Radiance, speed of look-up, and noise of a next event, in one run."""

from pathlib import Path

from ..common.machine import OtherLoad, describe_machine
from ..common.output import write_numbers
from . import agreement as luminaire_agreement
from . import speed as luminaire_speed
from . import variance as luminaire_variance


def run(folder: Path | None = None, say=None) -> dict:
    """Measure everything.

    Parameters
    ----------
    folder : Path or None    Photometric files for the comparison with Radiance; None: the library's own.
    say : callable or None    Told in one line what was done.

    Returns
    -------
    dict    Plain data, for JSON: ``machine``, ``source``, ``agreement``, ``speed``, ``noise`` and ``other_load`` by part.

    Raises
    ------
    LumenrayError    Radiance is not installed, or the folder holds no photometric files.
    """
    parts = {
        "agreement": lambda: luminaire_agreement.run(folder, say),
        "speed": lambda: luminaire_speed.run(say),
        "noise": lambda: luminaire_variance.run(say),
    }
    result = {
        "machine": describe_machine(),
        "source": "the library" if folder is None else Path(folder).name,
        "other_load": {},
    }
    for name, measure in parts.items():
        load = OtherLoad()
        result[name] = measure()
        result["other_load"][name] = load.share()
    return result


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document and its pictures to a folder, and all numbers to a JSON file if one is named."""
    from .chart import draw_agreement, draw_speed
    from .document import write_document

    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    draw_agreement(result["agreement"], folder / "luminaires_agreement.png")
    draw_speed(result["speed"], folder / "luminaires_speed.png")
    write_document(result, folder / "luminaires.md")
