"""The office at few samples, denoised: its error and its means, beside Cycles with its denoiser at equal processor time."""

from pathlib import Path

import numpy as np

from ...engine.analysis.block_means import block_means
from ...engine.photometry.colour import REC709_LUMINANCE
from ..common.machine import describe_machine
from ..common.output import write_numbers

SIZE = 320, 200
"""Width and height. [pixel]"""

SAMPLES = 8, 32, 128
"""Per pixel, of our pictures."""

REFERENCE = {"Lumenray": 256, "Cycles": 256}
"""Samples per pixel of the pictures that others are held against; what noise these have is taken out of errors."""


def run(keep: Path | None = None, size=SIZE, samples=SAMPLES, reference=None, say=None) -> dict:
    """Measure.

    Parameters
    ----------
    keep : Path or None    Folder where pictures are kept, and taken from where they are already there.
    size : (width, height)    [pixel]
    samples : iterable of int    Per pixel, of our pictures.
    reference : dict or None    As `REFERENCE`.
    say : callable or None    Told in one line what was done.

    Returns
    -------
    dict    Plain data for JSON, but for ``pictures``: (h, w, 3) arrays by name, linear and exposed.
    """
    from .programs import BOUNCES, Cycles, Lumenray

    reference, told = reference or REFERENCE, say or (lambda line: None)

    def take(name: str, make) -> dict:
        path = None if keep is None else keep / f"{name}.npz"
        if path is None or not path.exists():
            made = make()
            if path is None:
                return made
            keep.mkdir(parents=True, exist_ok=True)
            np.savez(path, **made)
        told(f"denoising: {name}")
        with np.load(path) as held:
            return dict(held)

    ours = Lumenray(size)
    held = take("lumenray_reference", lambda: ours.reference(reference["Lumenray"]))
    made = {n: take(f"lumenray_{n}", lambda n=n: ours.picture(n)) for n in samples}
    rows = [_judge_ours(n, each, held) for n, each in made.items()]
    pictures = {"reference": held["colour"]}
    for n, each in made.items():
        pictures |= {f"{n} raw": each["raw"], f"{n} denoised": each["shown"]}

    cycles = Cycles(size)
    held = take("cycles_reference", lambda: cycles.reference(reference["Cycles"]))
    scale = _exposure(pictures["reference"]) / _exposure(held["colour"])
    pictures["Cycles reference"] = held["colour"] * scale
    for row in rows:
        n = row["samples"]
        theirs = take(f"cycles_{n}", lambda row=row: cycles.picture(row["seconds"]))
        row["cycles"] = _judge_theirs(theirs, held)
        pictures[f"{n} Cycles"] = theirs["shown"] * scale
    return {
        "machine": describe_machine(),
        "size": list(size),
        "reference": reference,
        "bounces": BOUNCES,
        "rows": rows,
        "pictures": pictures,
    }


def write_results(result: dict, folder: Path, json_path: Path | None) -> None:
    """Write the document and its picture, and all numbers as JSON if wanted."""
    from .document import write_document, write_pictures

    folder.mkdir(parents=True, exist_ok=True)
    write_pictures(result, folder / "denoising.png")
    write_document(result, folder / "denoising.md")
    write_numbers({k: v for k, v in result.items() if k != "pictures"}, json_path)


def _judge_ours(samples: int, made: dict, held: dict) -> dict:
    return {
        "samples": samples,
        "seconds": float(np.sum(made["seconds"])),
        "denoising_seconds": float(made["seconds"][1]),
        "stated": float(made["stated"]),
        "raw_error": _error(made["raw"], held),
        "error": _error(made["shown"], held),
        "doubt": _doubt(made["shown"], held),
        "network_error": _error(made["network"], held),
        "shift": _shift(made["shown"], made["raw"]),
        "network_shift": _shift(made["network"], made["raw"]),
    }


def _judge_theirs(made: dict, held: dict) -> dict:
    return {
        "samples": int(made["samples"]),
        "seconds": float(made["seconds"]),
        "raw_error": _error(made["raw"], held),
        "error": _error(made["shown"], held),
        "doubt": _doubt(made["shown"], held),
        "shift": _shift(made["shown"], made["raw"]),
    }


def _error(colour: np.ndarray, held: dict) -> float:
    """Root mean square over the pixels of the error over the larger of their own luminance and the logarithmic mean.

    The mean itself may be that of the windows: those of Cycles are brighter beside the room. The reference's own noise is
    taken out.
    """
    return float(np.sqrt(max(_squares(colour, held).mean(), 0.0)))


def _doubt(colour: np.ndarray, held: dict) -> float:
    """Standard error of that, as pixels by chance make it."""
    squares = _squares(colour, held)
    doubt = float(squares.std() / np.sqrt(squares.size))
    return doubt / (2.0 * max(_error(colour, held), np.sqrt(doubt)))


def _squares(colour: np.ndarray, held: dict) -> np.ndarray:
    """Squares of relative errors without those of the reference, by pixel."""
    true = held["colour"] @ REC709_LUMINANCE
    level = np.maximum(true, _exposure(held["colour"]))
    return ((colour @ REC709_LUMINANCE - true) / level) ** 2 - (held["error"] / level) ** 2


def _shift(colour: np.ndarray, raw: np.ndarray) -> float:
    """Largest relative difference between means of blocks."""
    means = [block_means(each @ REC709_LUMINANCE) for each in (colour, raw)]
    return float(np.abs(means[0] / means[1] - 1.0).max())


def _exposure(colour: np.ndarray) -> float:
    """Logarithmic mean of the luminance."""
    seen = colour @ REC709_LUMINANCE
    return float(np.exp(np.log(seen[seen > 0.0]).mean()))
