"""Files of cloths: JSON by the schema in ``libraries/cloths``."""

import json
import math
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...libraries import cloths
from ..errors import FileFormatError
from ..optical_constants.curves import Curve
from ..optical_constants.quantities import Quantities
from ..paint.composition import Diameters
from ..reading.content import read_json
from ..reading.json_schema import SchemaError, check_value
from .composition import Cloth, Pile, Scatterers, Weave, Yarn
from .weave import MOST_YARNS, plain, satin_pattern, twill_pattern

LARGEST_FILE, LARGEST_BITMAP = 1 << 20, 1 << 22
"""[byte]"""

INDEX, ROUGHNESS = 1.557, 0.3
"""Of a yarn that states none: cellulose; alpha."""


@lru_cache
def schema() -> dict:
    """Return the JSON schema of a composition."""
    return json.loads(cloths.SCHEMA.read_text(encoding="utf-8"))


def read_cloth(path) -> Cloth:
    """Read a file of a cloth.

    Raises
    ------
    FileFormatError    It cannot be read, or says what cannot be; the text says where.
    """
    return parse_cloth(read_json(path, LARGEST_FILE), path)


def parse_cloth(content: dict, path="cloth") -> Cloth:
    """Make a cloth of its description, as JSON gives it.

    Parameters
    ----------
    path : str or Path    Named by errors; files that the description names lie beside it.

    Raises
    ------
    FileFormatError    As of `read_cloth`.
    """
    try:
        check_value(content, schema())
        warp, weft = (_yarn(content[name], name) for name in ("warp", "weft"))
        weave = _weave(content["weave"], path)
        _check_width(warp, weave.warp_pitch_mm, "warp")
        _check_width(weft, weave.weft_pitch_mm, "weft")
        pile = None
        if "pile" in content:
            own = content["pile"]
            pile = Pile(
                _yarn(own["yarn"], "pile.yarn"),
                float(own["height_mm"]),
                float(own["density_per_mm2"]),
                math.radians(own.get("lean_deg", 0.0)),
            )
    except (SchemaError, ValueError) as error:
        raise FileFormatError(path, str(error)) from None
    words = [content.get(name, "") for name in ("name", "description", "source")]
    return Cloth(warp, weft, weave, pile, *words, content)


def rows_of(pattern: np.ndarray) -> list[str]:
    """Pattern of a weave as ``weave.rows`` of a description. (i, j) bool"""
    return ["".join("X" if is_up else "." for is_up in row) for row in pattern.T]


def whole_content(cloth: Cloth) -> dict:
    """Description of a cloth that names no other file."""
    weave = cloth.content["weave"]
    if "bitmap" not in weave:
        return cloth.content
    weave = {name: value for name, value in weave.items() if name != "bitmap"}
    return cloth.content | {"weave": weave | {"rows": rows_of(cloth.weave.is_warp_up)}}


def _check_width(yarn: Yarn, pitch: float, place: str) -> None:
    if yarn.width_mm > pitch:
        raise ValueError(
            f"{place}.width_mm is {yarn.width_mm:g}, expected {pitch:g} at most: the pitch of its yarns"
        )


def _yarn(content: dict, place: str) -> Yarn:
    width = float(content["width_mm"])
    height = float(content.get("height_mm", width))
    if not 0.1 <= height / width <= 10.0:
        raise ValueError(
            f"{place} is {width:g} mm wide and {height:g} mm high, expected 10 to 1 at most"
        )
    scatterers = tuple(_scatterers(each) for each in content.get("scatterers", []))
    if sum(each.volume_fraction for each in scatterers) > 0.5:
        raise ValueError(f"{place}.scatterers are more than half of the yarn")
    return Yarn(
        width,
        height,
        float(content.get("index", INDEX)),
        float(content.get("roughness", ROUGHNESS)),
        scatterers,
        Quantities({}).spectrum(
            content.get("absorption_per_mm", 0.0), f"{place}.absorption_per_mm"
        ),
    )


def _scatterers(content: dict) -> Scatterers:
    index = complex(content["index"], content.get("absorption_index", 0.0))
    return Scatterers(
        Curve(np.array([550.0]), np.array([index])),
        Diameters(float(content["diameter_um"]), float(content.get("log_spread", 0.0))),
        float(content["volume_fraction"]),
    )


def _weave(content: dict, path) -> Weave:
    pitches = float(content["warp_pitch_mm"]), float(content["weft_pitch_mm"])
    if "pattern" in content:
        return plain(*pitches)
    if "twill" in content:
        return Weave(
            twill_pattern(*_whole(content["twill"], "weave.twill")), *pitches, turns_back=True
        )
    if "satin" in content:
        own = content["satin"]
        steps = _whole([own["ends"], own["step"]], "weave.satin")
        return Weave(satin_pattern(*steps), *pitches, turns_back=True)
    if "rows" in content:
        return Weave(_pattern_of_rows(content["rows"]), *pitches)
    return Weave(_pattern_of_bitmap(Path(path).parent / content["bitmap"]), *pitches)


def _whole(values, place: str) -> list[int]:
    if any(value != int(value) for value in values):
        raise ValueError(f"{place} is {values}, expected whole numbers")
    return [int(value) for value in values]


def _pattern_of_rows(rows: list[str]) -> np.ndarray:
    for number, row in enumerate(rows):
        if len(row) != len(rows[0]) or len(row) < 2 or set(row) - set("X."):
            raise ValueError(
                f"weave.rows[{number}] is '{row[:40]}', expected {max(len(rows[0]), 2)} signs, X or a point each"
            )
    return _checked(np.array([[sign == "X" for sign in row] for row in rows]).T, "weave.rows")


def _pattern_of_bitmap(path: Path) -> np.ndarray:
    from PIL import Image

    try:
        if path.stat().st_size > LARGEST_BITMAP:
            raise ValueError(f"weave.bitmap: {path.name} is larger than {LARGEST_BITMAP >> 20} MiB")
        with Image.open(path) as picture:
            if max(picture.size) > MOST_YARNS or min(picture.size) < 2:
                raise ValueError(
                    f"weave.bitmap: {path.name} has {picture.size[0]} x {picture.size[1]} pixels, expected 2 to "
                    f"{MOST_YARNS} along both, one for each crossing"
                )
            grey = np.asarray(picture.convert("L"))
    except OSError as error:
        raise ValueError(
            f"weave.bitmap: {path.name} cannot be read: {error.strerror or error}"
        ) from None
    return _checked(grey[::-1].T < 128, f"weave.bitmap: {path.name}")


def _checked(pattern: np.ndarray, place: str) -> np.ndarray:
    """Refuse a pattern in which a yarn lies on all others, or below: it would fall off."""
    for name, axis in (("end", 1), ("pick", 0)):
        share = pattern.mean(axis=axis)
        loose = np.flatnonzero((share == 0.0) | (share == 1.0))
        if len(loose):
            raise ValueError(
                f"{place}: {name} {loose[0] + 1} crosses all others on one side, so nothing holds it"
            )
    return pattern
