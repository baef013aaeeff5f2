"""Body and luminous opening of TM-33 documents."""

import numpy as np

from ....reading.remarks import Remark
from ....reading.safe_xml import XmlElement
from ....scene.distribution import Opening
from .values import key_of, optional_number, text_of

MAXIMUM_LENGTH = 1000.0
"""Longest side. [m]"""

LARGE = 10.0
"""Luminaires larger than this on a side and nowhere smaller than 1 are measured in mm. [m]"""

SHIFT = 1e-3
"""An opening this far off the photometric centre is remarked on. [m]"""

_IN_MILLIMETRES = "LuminaireOpticalData"
"""Root of the documents of a program that writes millimetres."""

_FACES = {
    "TopFace": ("TopArea", "Width", "Length", ""),
    "BottomFace": ("BottomArea", "Width", "Length", ""),
    "C0Face": ("C0Area", "", "Length", "Height"),
    "C180Face": ("C180Area", "", "Length", "Height"),
    "C90Face": ("C90Area", "Width", "", "Height"),
    "C270Face": ("C270Area", "Width", "", "Height"),
}
"""Areas of each face, and which of their sides lie along the luminaire's x, y and z."""

_FLAT, _ACROSS = {"TopFace", "BottomFace"}, {"C0Face", "C180Face"}


def read_body(
    root: XmlElement, emitters, remarks
) -> tuple[Opening, tuple[float, float, float] | None]:
    """Return the luminous opening, around the photometric centre, and the size of the body as of `LuminaireFile`."""
    dimensions = root.find("Luminaire/Dimensions")
    scale = _scale(root, dimensions, remarks)
    body = tuple(_length(dimensions, name, scale, remarks) or 0.0 for name in _SIDES)
    opening = None
    for emitter in emitters:
        areas = emitter.find("EmissionAreas")
        if areas is not None and opening is None:
            opening = _of_areas(areas, emitter.find("EmitterCenter"), scale, body, remarks)
    if opening is None:
        opening = _of_luminaire(root.find("Luminaire/LuminousOpening"), scale, remarks)
    if opening is None:
        opening = Opening()
        remarks.append(Remark("the size of the luminous opening is not stated, taken as a point"))
    if not any(body):
        return opening, None
    width, length, height = body
    return opening, (width, length, height) if width else (length, 0.0, height)


_SIDES = ("Width", "Length", "Height")
"""Along the luminaire's x, y and z."""


def _scale(root: XmlElement, dimensions: XmlElement | None, remarks) -> float:
    """Metres for the unit of length. The standard's is the metre, but many documents have millimetres."""
    sides = [optional_number(dimensions, name, []) or 0.0 for name in _SIDES]
    stated = [side for side in sides if side]
    if not stated:
        return 0.001 if root.tag == _IN_MILLIMETRES else 1.0
    if root.tag != _IN_MILLIMETRES and (max(stated) <= LARGE or min(stated) < 1.0):
        return 1.0
    text = f"a body of {' x '.join(f'{side:g}' for side in sides)}, taken as mm instead of m"
    remarks.append(Remark(text, dimensions.line))
    return 0.001


def _length(element, name: str, scale: float, remarks) -> float | None:
    """A side. [m]"""
    value = optional_number(element, name, remarks)
    if value is not None and value * scale > MAXIMUM_LENGTH:
        text = f"{value * scale:g} m as {name}, not used"
        remarks.append(Remark(text, element.find(name).line))
        return None
    return None if value is None else value * scale


def _offset(element, side: str, scale: float, remarks) -> float:
    value = optional_number(element, f"{side}Offset", remarks, -MAXIMUM_LENGTH / scale) or 0.0
    return min(value * scale, MAXIMUM_LENGTH)


def _of_areas(areas: XmlElement, centre, scale, body, remarks) -> Opening | None:
    """The smallest body around all areas."""
    faces, boxes, is_round = set(), [], False
    for face, (area, *sides) in _FACES.items():
        for item in areas.findall(f"{face}/{area}"):
            size = [_length(item, name, scale, remarks) if name else None for name in sides]
            if any(name and not side for name, side in zip(sides, size, strict=True)):
                remarks.append(
                    Remark(f"{area} without {' and '.join(filter(None, sides))}", item.line)
                )
                continue
            middle = [_offset(item, name, scale, remarks) if name else np.nan for name in sides]
            size = np.array([np.nan if side is None else side for side in size], dtype=np.float64)
            boxes.append((np.array(middle) - 0.5 * size, np.array(middle) + 0.5 * size))
            faces.add(face)
            is_round = key_of(text_of(item, "Circular")) in {"true", "1"}
    if not boxes:
        return None
    if len(boxes) > 1:
        text = f"{len(boxes)} luminous areas, taken as one body around all of them"
        remarks.append(Remark(text, areas.line))
    low = np.array([np.nanmin([*box, np.inf]) for box in zip(*(b[0] for b in boxes), strict=True)])
    high = np.array(
        [np.nanmax([*box, -np.inf]) for box in zip(*(b[1] for b in boxes), strict=True)]
    )
    known = np.isfinite(low)
    _compare_centre(low, high, known, centre, scale, areas.line, remarks)
    size = tuple(float(side) if k else 0.0 for side, k in zip(high - low, known, strict=True))
    if faces == _FLAT and body[2] > 0.0:
        return Opening("box", (*size[:2], body[2]), "z")
    if faces <= _FLAT:
        return Opening("ellipse" if is_round and len(boxes) == 1 else "rectangle", size, "z")
    if len(faces) == 1:
        axis = "x" if faces <= _ACROSS else "y"
        return Opening("ellipse" if is_round and len(boxes) == 1 else "rectangle", size, axis)
    # Several faces of the body shine; where only one pair does, the body tells how far apart they are.
    size = tuple(side or whole for side, whole in zip(size, body, strict=True))
    if min(size) > 0.0:
        return Opening("box", size, "z")
    return Opening("rectangle", size, "xyz"[size.index(0.0)]) if size.count(0.0) == 1 else None


def _compare_centre(low, high, known, centre, scale, line, remarks) -> None:
    origin = [_offset(centre, name, scale, remarks) for name in _SIDES]
    middle = 0.5 * np.add(low, high, out=2.0 * np.array(origin), where=known)
    shift = (middle - origin)[:2]
    if np.abs(shift).max() > SHIFT:
        text = (
            f"the luminous areas lie {shift[0]:g} m (width) and {shift[1]:g} m (length) off the photometric"
            " centre; the opening is put around the centre"
        )
        remarks.append(Remark(text, line))


def _of_luminaire(element: XmlElement | None, scale, remarks) -> Opening | None:
    """What some programs write instead of emission areas."""
    if element is None:
        return None
    size = element.find("Dimensions")
    length, width = (_length(size, name, scale, remarks) or 0.0 for name in ("Length", "Width"))
    if not length:
        return None
    text = "LuminousOpening, which the schema does not know, read as the opening"
    remarks.append(Remark(text, element.line))
    is_round = "circ" in key_of(text_of(element, "Shape")) or not width
    if is_round:
        return Opening("ellipse", (length, length, 0.0), "z")
    return Opening("rectangle", (width, length, 0.0), "z")
