"""Ray files for tests, written byte by byte from the formats' descriptions, not by the code under test."""

import struct

import numpy as np

COUNT = 200


def lambert_rays(count: int = COUNT, seed: int = 1) -> np.ndarray:
    """Rays of a disk of 2 mm radius that shines by the cosine law upwards. (n, 7): mm, unit vector, flux 0.5"""
    rng = np.random.default_rng(seed)
    radius, turn = 2.0 * np.sqrt(rng.random(count)), 2.0 * np.pi * rng.random(count)
    sine, azimuth = np.sqrt(rng.random(count)), 2.0 * np.pi * rng.random(count)
    columns = (
        radius * np.cos(turn),
        radius * np.sin(turn),
        np.full(count, 3.0),
        sine * np.cos(azimuth),
        sine * np.sin(azimuth),
        np.sqrt(1.0 - sine**2),
        np.full(count, 0.5),
    )
    return np.stack(columns, axis=1).astype("<f4")


def tm25(
    rows,
    flags=(1, 1, 0, 0, 1, 0, 0, 0),
    kind=0,
    lumens=None,
    watts=None,
    spectra=(),
    single=np.nan,
    more=(),
    text="",
) -> bytes:
    """A TM-25-13 file. ``rows``: (n, columns); totals that are None are unknown."""
    head = bytearray(36288)
    head[:4] = b"TM25"
    totals = [np.nan if value is None else value for value in (lumens, watts)]
    struct.pack_into("<iiff", head, 4, 2013, 0, *totals)
    struct.pack_into(
        "<Q28sii3f", head, 20, len(rows), b"2020-01-02T03:04:05", 0, kind, single, np.nan, np.nan
    )
    raw = text.encode("utf-32-le")
    raw += bytes(-len(raw) % 32)
    struct.pack_into("<3i", head, 76, len(spectra), len(more), len(raw))
    struct.pack_into("<8i", head, 256, *flags)
    name = "lamp of tests".encode("utf-32-le")
    head[288 : 288 + len(name)] = name
    tables = b"".join(
        struct.pack("<i", len(each)) + np.asarray(each, dtype="<f4").tobytes() for each in spectra
    )
    tables += bytes(-len(tables) % 32)
    names = b"".join(each.encode("utf-32-le").ljust(512, b"\0") for each in more)
    return bytes(head) + tables + names + raw + np.asarray(rows, dtype="<f4").tobytes()


def zemax(rows, unit=4, kind=0, quantity=1, total=100.0, wavelength=0.0) -> bytes:
    """A binary source file; ``rows``: (n, 7) or (n, 8) with micrometres."""
    head = bytearray(208)
    struct.pack_into("<iI100s", head, 0, 1010, len(rows), b"lamp of tests")
    struct.pack_into("<3f", head, 108, total, total, wavelength)
    struct.pack_into("<I", head, 136, unit)
    struct.pack_into("<2i", head, 192, kind, quantity)
    return bytes(head) + np.asarray(rows, dtype="<f4").tobytes()


def lighttools(
    rows, quantity=1, far=0, colour=0, unit=1, total=100.0, end=b"LTRFEND", major=2
) -> bytes:
    """A binary LightTools file; ``rows``: (n, 7) or (n, 8) with nanometres."""
    head = b"LTRF" + struct.pack("<6I", major, 0, quantity, far, colour, unit)
    return head + struct.pack("<4f", 0, 0, 0, total) + np.asarray(rows, dtype="<f4").tobytes() + end


def speos(rows, watts=2.0, lumens=100.0) -> bytes:
    """A SPEOS file; ``rows``: (n, 8), wavelength [nm] before the relative weight."""
    return (
        struct.pack("<7f", watts, 2, 2, 2, 2, 2, lumens) + np.asarray(rows, dtype="<f4").tobytes()
    )


def asap(rows, words=7) -> bytes:
    """A distribution file of rays."""
    records = [
        struct.pack("<7i", 247 + 1024 * words, *[0] * 6),
        b"lamp of tests".ljust(24) + struct.pack("<i", 1),
        bytes(28),
        b"Y".ljust(16) + struct.pack("<ffi", 0.0, 0.0, -len(rows)),
        b"X".ljust(16) + struct.pack("<ffi", 0.0, 0.0, words),
    ]
    return b"".join(records) + np.asarray(rows, dtype="<f4").tobytes()


def text_of(rows) -> str:
    """Rows as text, exact."""
    return "".join(" ".join(f"{value:.9g}" for value in row) + "\n" for row in rows)


def zemax_text(rows, unit=4, kind=0, quantity=1) -> bytes:
    """A Zemax text."""
    return f"{len(rows)} {unit} {kind} {quantity}\n{text_of(rows)}".encode()


def lighttools_text(
    rows, units="millimeters", kind="luminous_flux", colour="none", total=100.0
) -> bytes:
    """A LightTools text."""
    key = "lt_luminous_flux" if "luminous" in kind else "lt_radiant_flux"
    head = (
        "# LightTools 8.7.0\nlt_rdf_version: 2.0\ndataname: lamp\n"
        f"lt_datatype: {kind}\nlt_far_field_data: no\nlt_color_info: {colour}\nlt_length_units: {units}\n"
        f"lt_data_origin: 0 0 0\n{key}: {total}\nlt_startofdata\n"
    )
    return (head + text_of(rows) + "lt_endofdata\n").encode()


def tracepro_text(rows, factor=1000.0) -> bytes:
    """Rows with the comment lines that TracePro writes."""
    head = f"!! Lamp of tests\n# Rotation 0 0 0\nConversion Factor From Meters {factor:g}\nX Y Z kx ky kz flux\n"
    return (head + text_of(rows)).encode()
