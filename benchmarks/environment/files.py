"""Files: what those of a collection hold, and what becomes of ones that are damaged, odd or very large."""

import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from ...engine.environment.analysis import analyse, format_range, format_ratio
from ...engine.environment.map_file import read_map, write_map
from ...engine.errors import LumenrayError
from ...engine.photometry.units import RADIANCE_EFFICACY
from .drawn_maps import Spot, make_map

LARGE = (8192, 16384)
"""Height and width of the largest map. [pixel]"""

SUN = Spot(40.0, 120.0, illuminance=12.0)


def describe_maps(folder: Path, say) -> list[dict]:
    """Analyse all pictures of a folder, by Radiance's scale."""
    rows = []
    for path in sorted(each for each in folder.iterdir() if each.suffix in {".hdr", ".exr"}):
        try:
            image, remarks = read_map(path)
            made = analyse(image, RADIANCE_EFFICACY)
        except LumenrayError as error:
            rows.append({"file": path.name, "refused": str(error)})
            continue
        sun = made.sun
        rows.append(
            {
                "file": path.name,
                "size": f"{made.width} x {made.height}",
                "range": format_range(made.range),
                "horizontal_lx": made.horizontal,
                "sun_to_rest": None if made.ratio is None else format_ratio(made.ratio),
                "sun_elevation_deg": None if sun is None else sun.elevation,
                "sources": len(made.sources),
                "error_percent": 100.0 * abs(made.conserved - 1.0),
                "verdict": "; ".join(made.verdict),
                "remarks": "; ".join(remarks),
            }
        )
        say(f"{path.name}: {made.verdict[0]}")
    return rows


def try_files(say) -> list[dict]:
    """Read and analyse odd and damaged files, and tell what was said of each."""
    with tempfile.TemporaryDirectory() as folder:
        return [_try(name, make, Path(folder), say) for name, make in _FILES.items()]


def _try(name: str, make, folder: Path, say) -> dict:
    path = make(folder)
    before = time.process_time()
    try:
        image, remarks = read_map(path)
        made = analyse(image, RADIANCE_EFFICACY)
    except LumenrayError as error:
        row = {"file": name, "refused": True, "said": str(error).replace(str(path), path.name)}
    else:
        nan, infinite, negative = made.faults
        told = [*remarks]
        told += (
            [f"{nan} NaN, {infinite} infinite, {negative} negative pixels"]
            if any(made.faults)
            else []
        )
        row = {"file": name, "refused": False, "said": "; ".join([*told, *made.verdict])}
        row["error_percent"] = 100.0 * abs(made.conserved - 1.0)
    row["seconds"] = time.process_time() - before
    row["peak_gb"] = _peak()
    path.unlink()
    say(f"{name}: {row['said']}")
    return row


def _peak() -> float:
    """Most memory that this process has held so far. [GB]"""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e9


def _faulty(folder: Path) -> Path:
    pixels = make_map(256, [SUN])
    pixels[10, 20], pixels[200, 300, 1], pixels[100, 50] = np.nan, np.inf, -3.0
    return write_map(folder / "faulty.exr", pixels)


def _single(folder: Path) -> Path:
    return write_map(folder / "single.exr", np.full((1, 1, 3), 2.0))


def _square(folder: Path) -> Path:
    return write_map(folder / "square.exr", make_map(64, [])[:, :64])


def _half_exr(folder: Path) -> Path:
    path = write_map(folder / "half.exr", make_map(64, []))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return path


def _half_hdr(folder: Path) -> Path:
    return _write_radiance(folder / "half.hdr", make_map(64, []), 2)


def _text(folder: Path) -> Path:
    path = folder / "text.hdr"
    path.write_text("no picture")
    return path


def _large(folder: Path) -> Path:
    """A map of the largest size, drawn small and made of equal blocks, with a sun."""
    return _write_radiance(folder / "large.hdr", make_map(1024, [SUN]), 1, LARGE[0] // 1024)


def _write_radiance(path: Path, values: np.ndarray, parts: int, blocks: int = 1) -> Path:
    """Write a picture without packing; of ``parts`` only the first, each value as a block of pixels."""
    mantissa, exponent = np.frexp(values.max(axis=2))
    scale = np.where(mantissa > 0.0, np.ldexp(256.0, -exponent), 0.0)
    stored = np.concatenate(
        [values * scale[..., None], (exponent + 128.0)[..., None]], axis=2
    ).astype(np.uint8)[::-1]
    height, width = (blocks * side for side in values.shape[:2])
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    with path.open("wb") as file:
        file.write(head.encode())
        for row in stored[: len(stored) // parts]:
            line = np.repeat(row, blocks, axis=0).tobytes()
            for _ in range(blocks):
                file.write(line)
    return path


_FILES = {
    "NaN, infinite and negative pixels": _faulty,
    "1 x 1": _single,
    "64 x 64": _square,
    "half of an OpenEXR file": _half_exr,
    "half of a Radiance picture": _half_hdr,
    "text": _text,
    f"{LARGE[1]} x {LARGE[0]}": _large,
}
"""What each file is, and how it is made."""
