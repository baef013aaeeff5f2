"""What scattering files are called, and how large they may be."""

SUFFIX = ".lumbsdf"
"""Of our own."""

ENDINGS = (
    SUFFIX, ".bsdf", ".brdf", ".btdf", ".xml", ".binary", ".mbsdf", ".simplescattering", ".scattering", ".coated",
    ".anisotropicbsdf", ".bsdf180", ".astm", ".csv", ".txt", ".dat",
)  # fmt: skip
"""Of names of scattering files, where files are looked for."""

MAXIMUM_SIZE = 256 << 20
"""Largest file that is read. [byte]"""
