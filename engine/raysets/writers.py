"""Ray files written: IES TM-25-13 and Zemax binary."""

import struct
from collections.abc import Iterable
from datetime import UTC, datetime

import numpy as np

from ..errors import LumenrayError
from ..reading.whole_file import write_whole
from .binary import MAXIMUM_RAYS
from .record import LUMINOUS, UNITS, Rays
from .tm25 import BLOCK, MAGIC, TABLES_START, TEXT_SIZE, TEXTS, TEXTS_START
from .zemax import HEAD, MICROMETRE

MILLIMETRE = UNITS["mm"]


def write_tm25(
    path,
    pieces: Iterable[Rays],
    quantity: str,
    spectrum=None,
    metadata: dict[str, str] | None = None,
    factor: float = 1.0,
) -> int:
    """Write rays to a TM-25-13 file, with wavelengths where they have them, and return their number.

    Parameters
    ----------
    path : path
    pieces : iterable of Rays    Written as they come.
    quantity : str    `record.RADIANT` or `record.LUMINOUS`.
    spectrum : ((k,), (k,)) arrays or None    Wavelengths [nm] and relative spectral power of all rays.
    metadata : dict of str to str or None    Texts of the head by the keys of `tm25.TEXTS`.
    factor : float    On the weights, which gives flux. [lm or W]

    Raises
    ------
    FileFormatError    The file cannot be written.
    LumenrayError    There are no rays, rays have no flux, or a ray in lumens has a wavelength, which the standard excludes.
    """
    metadata = metadata or {}
    is_luminous = quantity == LUMINOUS
    block = b"" if spectrum is None else _table(*spectrum)
    with write_whole(path) as file:
        file.write(bytes(TABLES_START))
        file.write(block)
        count, total, has_wavelength = _write_rows(file, pieces, factor, is_luminous, 1.0)
        kind = 2 if has_wavelength else 3 if spectrum is not None else 0
        if has_wavelength and (is_luminous or spectrum is not None):
            raise LumenrayError(
                f"{path}: rays with a wavelength each carry watts and need no spectrum besides"
            )
        head = bytearray(TABLES_START)
        nan = float("nan")
        now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S+00:00").encode()
        head[:4] = MAGIC
        lumens, watts = (total, nan) if is_luminous else (nan, total)
        struct.pack_into(
            "<iiffQ28sii3f", head, 4, 2013, 0, lumens, watts, count, now, 0, kind, *([nan] * 3)
        )
        struct.pack_into("<3i", head, 76, int(spectrum is not None), 0, 0)
        flags = (1, 1, not is_luminous, has_wavelength, is_luminous, 0, 0, 0)
        struct.pack_into("<8i", head, 256, *(int(flag) for flag in flags))
        for number, key in enumerate(TEXTS):
            raw = metadata.get(key, "")[: TEXT_SIZE // 4 - 1].encode("utf-32-le")
            start = TEXTS_START + TEXT_SIZE * number
            head[start : start + len(raw)] = raw
        file.seek(0)
        file.write(head)
    return count


def write_zemax(
    path, pieces: Iterable[Rays], quantity: str, description: str = "", factor: float = 1.0
) -> int:
    """Write rays to a binary source file in millimetres, with wavelengths where they have them, and return their number.

    Parameters and errors as of `write_tm25`.
    """
    is_luminous = quantity == LUMINOUS
    with write_whole(path) as file:
        file.write(bytes(HEAD))
        count, total, has_wavelength = _write_rows(
            file, pieces, factor, is_luminous, 1.0 / MICROMETRE
        )
        if has_wavelength and is_luminous:
            raise LumenrayError(f"{path}: rays with a wavelength each carry watts, not lumens")
        if count > 0xFFFFFFFF:
            raise LumenrayError(f"{path}: {count} rays are too many for this format")
        head = bytearray(HEAD)
        struct.pack_into(
            "<iI100s", head, 0, 1010, count, description.encode("latin-1", "replace")[:99]
        )
        struct.pack_into("<fff", head, 108, total, total, 0.0)
        struct.pack_into("<I", head, 136, 4)
        struct.pack_into("<3f", head, 164, 1.0, 1.0, 1.0)
        struct.pack_into("<2i", head, 192, 2 if has_wavelength else 0, int(is_luminous))
        file.seek(0)
        file.write(head)
    return count


def _write_rows(file, pieces, factor: float, is_luminous: bool, wavelength_scale: float):
    """Write rows x y z [mm], k l m, flux, and a wavelength; return their number, the flux, and whether it is there."""
    count, total, has_wavelength = 0, 0.0, None
    for rays in pieces:
        if not len(rays):
            continue
        own = rays.wavelength is not None
        if has_wavelength not in {None, own}:
            raise LumenrayError(
                "some rays have a wavelength and others none; they cannot share a file"
            )
        has_wavelength = own
        columns = [rays.position / MILLIMETRE, rays.direction, (rays.weight * factor)[:, None]]
        if own:
            columns.append((rays.wavelength * wavelength_scale)[:, None])
        rows = np.concatenate(columns, axis=1).astype("<f4")
        total += float(rows[:, 6].sum(dtype=np.float64))
        count += len(rows)
        if count > MAXIMUM_RAYS:
            raise LumenrayError(f"more than {MAXIMUM_RAYS} rays; split them into several files")
        file.write(rows.tobytes())
    if not count or not total > 0.0:
        raise LumenrayError("there are no rays with light to be written")
    return count, total, bool(has_wavelength)


def _table(wavelengths, values) -> bytes:
    """A spectral table, filled up to whole blocks."""
    pairs = np.stack([wavelengths, values], axis=1).astype("<f4")
    raw = struct.pack("<i", len(pairs)) + pairs.tobytes()
    return raw + bytes(-len(raw) % BLOCK)
