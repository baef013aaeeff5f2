"""Klems matrices of WINDOW XML: scattering by pairs of patches."""

import re

import numpy as np

from ...errors import FileFormatError
from ...reading.remarks import Remark
from ...reading.safe_xml import XmlElement
from ...scene.scattering import PatchBasis, PatchMatrix
from ..data.patches import MOST_PATCHES, starts_of
from .window_blocks import NEUTRAL, Block, clip, parse_value, text_of, values_of

KLEMS = {
    "lbnl/klems full": (
        (0.0, 5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 90.0),
        (1, 8, 16, 20, 24, 24, 24, 16, 12),
    ),
    "lbnl/klems half": (
        (0.0, 6.5, 19.5, 32.5, 45.5, 58.5, 71.5, 90.0),
        (1, 8, 12, 16, 20, 12, 8),
    ),
    "lbnl/klems quarter": ((0.0, 9.0, 27.0, 45.0, 63.0, 90.0), (1, 8, 12, 12, 8)),
}
"""Bases that files need not define: bounds of the rings [degree] and patches of each."""

_FOREIGN = re.compile(r"[^0-9eE.+\-\s,]", re.ASCII)


def read_bases(layer: XmlElement, path, remarks: list[Remark]) -> dict[str, PatchBasis]:
    """Bases by their names in small letters: those that everybody knows, and those that the file defines."""
    bases = {
        name: PatchBasis(np.radians(bounds), np.array(counts, dtype=np.int32))
        for name, (bounds, counts) in KLEMS.items()
    }
    for element in layer.findall("DataDefinition/AngleBasis"):
        name = text_of(element.find("AngleBasisName")).lower()
        basis = _read_basis(element, name, path)
        known = bases.get(name)
        if name in KLEMS and not (
            np.array_equal(known.counts, basis.counts)
            and np.allclose(known.bounds, basis.bounds, atol=1e-4)
        ):
            remarks.append(
                Remark(f"defines the basis '{name}' otherwise than LBNL does", element.line)
            )
        bases[name] = basis
    return bases


def _read_basis(element: XmlElement, name: str, path) -> PatchBasis:
    bounds, counts = [0.0], []
    for block in element.findall("AngleBasisBlock"):
        lower, upper, count = (
            _number(block, tag, path)
            for tag in ("ThetaBounds/LowerTheta", "ThetaBounds/UpperTheta", "nPhis")
        )
        if abs(lower - bounds[-1]) > 1e-3 or not bounds[-1] < upper <= 90.001:
            raise FileFormatError(
                path,
                f"has a ring from {lower:g} to {upper:g} degrees in the basis '{name}', "
                f"expected one that begins at {bounds[-1]:g}",
                block.line,
            )
        if count != round(count) or not 1 <= count <= MOST_PATCHES - sum(counts):
            raise FileFormatError(
                path,
                f"has the nPhis {count:g}, expected a whole number; a basis has at most {MOST_PATCHES} patches",
                block.line,
            )
        bounds.append(upper)
        counts.append(int(count))
    if abs(bounds[-1] - 90.0) > 1e-3:
        raise FileFormatError(
            path,
            f"has the basis '{name}' whose rings end at {bounds[-1]:g} degrees, expected 90",
            element.line,
        )
    bounds[-1] = 90.0
    return PatchBasis(np.radians(bounds), np.array(counts, dtype=np.int32))


def _number(element: XmlElement, tag: str, path) -> float:
    found = element.find(tag)
    text = text_of(found)
    try:
        value = float(text) if text.isascii() and "_" not in text else np.nan
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise FileFormatError(
            path,
            f"has the {tag} '{text}', expected a number",
            element.line if found is None else found.line,
        )
    return value


def read_matrix(block: Block, bases, by_rows: bool, path, remarks: list[Remark]) -> PatchMatrix:
    """Read one side, row after row: a row is an outgoing patch where incidence goes by columns, else an incoming one.

    The column's basis is that of incidence in both cases, as Radiance takes it.
    """
    incoming, outgoing = (_basis_of(block, tag, bases, path) for tag in ("Column", "Row"))
    text, line = values_of(block, _FOREIGN, path)
    shape = tuple(
        int(basis.counts.sum())
        for basis in ((incoming, outgoing) if by_rows else (outgoing, incoming))
    )
    count = shape[0] * shape[1]
    tokens = text.replace(",", " ").split(None, count)
    if len(tokens) != count:
        raise FileFormatError(
            path,
            f"has {'more' if len(tokens) > count else len(tokens)} values of {block.direction}, "
            f"expected {shape[0]} rows of {shape[1]} by its bases",
            line,
        )
    values = [parse_value(token) for token in tokens]
    if None in values:
        token = tokens[values.index(None)]
        line += text.count("\n", 0, text.find(token))
        raise FileFormatError(path, f"has '{token[:40]}', expected a number", line)
    values = clip(np.array(values).reshape(shape), block, remarks)
    for basis in (incoming, outgoing):
        odd = basis.counts[(basis.counts > 1) & (basis.counts % 2 == 1)]
        if odd.size:
            raise FileFormatError(
                path,
                f"has a ring with {odd[0]} patches, expected 1 or an even number: opposite directions need patches alike",
                line,
            )
    values = values if by_rows else values.T
    ours = values[np.ix_(_turned(incoming, False), _turned(outgoing, True))]
    return PatchMatrix(
        incoming, outgoing, np.array([NEUTRAL]), np.ascontiguousarray(ours[..., None])
    )


def _basis_of(block: Block, kind: str, bases: dict[str, PatchBasis], path) -> PatchBasis:
    element = block.element.find(f"{kind}AngleBasis")
    name = text_of(element)
    if name.lower() not in bases:
        raise FileFormatError(
            path,
            f"has the {kind}AngleBasis '{name}', which it does not define",
            (block.element if element is None else element).line,
        )
    return bases[name.lower()]


def _turned(basis: PatchBasis, half: bool) -> np.ndarray:
    """Numbers of the patches at the azimuths -phi, or pi - phi for ``half``."""
    place = np.concatenate([np.arange(n) for n in basis.counts])
    count = np.repeat(basis.counts, basis.counts)
    return np.repeat(starts_of(basis), basis.counts) + (count // 2 * half - place) % count


def incidences_of_rings(basis: PatchBasis) -> tuple[float, ...]:
    """Angles of incidence in the middle of rings. [rad]"""
    middle = np.where(basis.counts > 1, 0.5 * (basis.bounds[1:] + basis.bounds[:-1]), 0.0)
    return tuple(middle.tolist())
