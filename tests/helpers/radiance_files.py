"""Radiance pictures made for tests."""

import numpy as np

RGBE, XYZE = "32-bit_rle_rgbe", "32-bit_rle_xyze"


def encode(values) -> np.ndarray:
    """Four bytes for each colour: mantissas with the exponent of the largest. (..., 3) -> (..., 4) uint8"""
    values = np.asarray(values, dtype=np.float64)
    largest = values.max(axis=-1)
    _, exponent = np.frexp(largest)
    mantissas = np.floor(np.ldexp(values, 8 - exponent[..., None]))
    made = np.concatenate([mantissas, exponent[..., None] + 128.0], axis=-1)
    made[largest <= 1e-30] = 0.0
    return np.clip(made, 0, 255).astype(np.uint8)


def write_picture(values, lines=(), encoding=RGBE, order="-Y +X", packed=False) -> bytes:
    """Return a picture file.

    Parameters
    ----------
    values : (height, width, 3) array    Row 0 at the bottom.
    lines : sequence of str    Further lines of the header.
    encoding, order : str    What FORMAT and the line of the size say.
    packed : bool    Whether rows are packed in runs, one component after the other.
    """
    first, second = order.split()
    stored = encode(values)
    if first[1] == "X":
        stored = stored.transpose(1, 0, 2)
    if first[0] == "-":
        stored = stored[::-1]
    if second[0] == "-":
        stored = stored[:, ::-1]
    count, length = stored.shape[:2]
    form = [f"FORMAT={encoding}"] if encoding else []
    head = ["#?RADIANCE", *lines, *form, "", f"{first} {count} {second} {length}", ""]
    body = b"".join(_pack(row) if packed else row.tobytes() for row in stored)
    return "\n".join(head).encode() + body


def _pack(row) -> bytes:
    made = bytes((2, 2, len(row) >> 8, len(row) & 255))
    for component in row.T:
        starts = np.flatnonzero(np.diff(component.astype(int), prepend=-1))
        for start, end in zip(starts, [*starts[1:], len(component)], strict=True):
            for begin in range(start, end, 127):
                count = min(127, end - begin)
                value = bytes((component[start],))
                made += bytes((128 + count,)) + value if count > 1 else bytes((1,)) + value
    return made
