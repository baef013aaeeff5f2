"""Luminous openings as LM-63 codes them: by the signs of width, length and height."""

from ....reading.remarks import Remark
from ....scene.distribution import Opening

_1991 = {
    "000": ("point", "z"),
    "++0": ("rectangle", "z"),
    "+++": ("box", "z"),
    "-00": ("ellipse", "z"),
    "-0+": ("cylinder", "z"),
    "-+0": ("ellipse", "z"),
    "-++": ("cylinder", "z"),
}

_1995 = {
    **_1991,
    "-0-": ("ellipsoid", "z"),
    "0+-": ("cylinder", "x"),
    "+0-": ("cylinder", "y"),
    "+-0": ("ellipse", "z"),
    "+-+": ("cylinder", "z"),
    "-+-": ("ellipsoid", "z"),
    "+--": ("ellipsoid", "z"),
}

_2002 = {
    "000": ("point", "z"),
    "++0": ("rectangle", "z"),
    "+++": ("box", "z"),
    "--0": ("ellipse", "z"),
    "--+": ("cylinder", "z"),
    "---": ("ellipsoid", "z"),
    "-+-": ("cylinder", "x"),
    "+--": ("cylinder", "y"),
    "-0-": ("ellipse", "x"),
}

_IN_THE_WILD = {
    "0++": ("rectangle", "y"),
    "+0+": ("rectangle", "x"),
    "++-": ("box", "z"),
    "0-0": ("ellipse", "z"),
    "0-+": ("cylinder", "z"),
    "0--": ("ellipse", "y"),
    "+00": ("point", "z"),
    "0+0": ("point", "z"),
    "00+": ("point", "z"),
    "00-": ("point", "z"),
}
"""Codes of no edition, by their evident meaning; lines of light have no surface, so they are points."""

SHAPES = {1986: _1991, 1991: _1991, 1995: _1995, 2002: _2002, 2019: _2002}
"""Shape and axis by the signs of width, length and height, of each edition; the axes are those of type C.

References
----------
LM-63-1991, -1995 and -2002, luminous dimensions.
"""


def read_opening(year, size, photometric_type, line, remarks) -> Opening:
    """Return the opening that three signed sizes stand for.

    Parameters
    ----------
    year : int    Of the edition.
    size : (float, float, float)    Width, length and height as signed in the file. [m]
    photometric_type : str    Of type C the length lies along x. Of types A and B the width does, across the beam, and the
        length lies along y, up.
    line : int    For remarks.
    remarks : list of Remark    A code of another edition is remarked on.
    """
    signs = "".join("0" if value == 0.0 else "-" if value < 0.0 else "+" for value in size)
    tables = (SHAPES[year], _1995, _2002, _IN_THE_WILD)
    shape, axis = next(table[signs] for table in tables if signs in table)
    width, length, height = map(abs, size)
    if signs in {"-00", "-0+"} or (signs == "-0-" and shape == "ellipsoid"):
        length = width
    elif signs in {"0-0", "0-+"} or (signs == "0+-" and shape == "cylinder"):
        width = length if signs[1] == "-" else height
    elif signs == "+0-":
        length = height
    x, y = length, width
    if photometric_type != "C":
        x, y = y, x
        axis = {"x": "y", "y": "x"}.get(axis, axis)
    opening = Opening() if shape == "point" else Opening(shape, (x, y, height), axis)
    if signs not in SHAPES[year]:
        sizes = " ".join(f"{value:g}" for value in size)
        text = f"LM-63-{year} has no opening of width, length, height {sizes} m, read as {shape}"
        remarks.append(Remark(text, line))
    return opening


def signed_size(opening: Opening, photometric_type: str) -> tuple[float, float, float]:
    """Return width, length and height [m] of an opening, signed as LM-63-2002 codes it.

    Upright rectangles and the ellipse that faces y have no code there; they get the common ones that `read_opening` knows.
    """
    (x, y, height), axis = opening.size, opening.axis
    if photometric_type != "C":
        x, y = y, x
        axis = {"x": "y", "y": "x"}.get(axis, axis)
    width, length = y, x
    if opening.shape == "point":
        return 0.0, 0.0, 0.0
    signs = (1, 1, 1) if opening.shape in {"rectangle", "box"} else (-1, -1, -1)
    if opening.shape == "cylinder":
        signs = {"x": (-1, 1, -1), "y": (1, -1, -1), "z": (-1, -1, 1)}[axis]
    # Adding 0 turns -0 into 0.
    return tuple(s * value + 0.0 for s, value in zip(signs, (width, length, height), strict=True))
