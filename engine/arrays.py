"""Arrays on the way to the device, and the numbers by which kernels know objects."""

import drjit as dr
import mitsuba as mi
import numpy as np

SMALLEST_TABLE = 1024
"""Fewest entries of a table by number."""

ALIGNMENT = 64
"""Of memory that is handed over. A kernel that reads unaligned memory is another kernel, so chance must not decide."""


def upload(kind, values):
    """Make a Dr.Jit array of a flat numpy array."""
    half = dr.float16_array_t(mi.Float)
    dtype = {mi.Float: np.float32, half: np.float16, mi.UInt32: np.uint32, mi.Bool: bool}[kind]
    values = np.asarray(values).reshape(-1)
    size = values.size * np.dtype(dtype).itemsize
    memory = np.empty(size + ALIGNMENT, dtype=np.uint8)
    start = -memory.ctypes.data % ALIGNMENT
    aligned = memory[start : start + size].view(dtype)
    aligned[...] = values
    return kind(aligned)


def average(value):
    """Mean over the components of a spectrum or vector, lane by lane.

    Unlike `dr.mean`, which writes the number of lanes into its kernel, so that every other number needs a new one.
    """
    return dr.sum(value) * (1.0 / len(value))


def table_size(count: int) -> int:
    """Entries of a table by number: a power of two that holds them."""
    return max(1 << max(count - 1, 0).bit_length(), SMALLEST_TABLE)


def pointer_id(thing) -> int:
    """Number by which kernels know a shape, emitter or surface; unique among the living of its kind."""
    pointers = {mi.Shape: mi.ShapePtr, mi.Emitter: mi.EmitterPtr, mi.BSDF: mi.BSDFPtr}
    pointer = next(pointer for base, pointer in pointers.items() if isinstance(thing, base))
    return int(dr.reinterpret_array(mi.UInt32, pointer(thing))[0])
