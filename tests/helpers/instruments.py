"""A scattering instrument that measures a known material: with noise, holes, a dark signal, and a lamp that drifts."""

import numpy as np

from lumenray.engine.scattering.data.table import direction_of
from lumenray.engine.scattering.measuring.raw_measurement import (
    Instrument,
    RawMeasurement,
    RawSlice,
)

WHITE = 0.98 / np.pi
"""BRDF of the white sample. [1/sr]"""

RADIALS = np.radians(
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 19, 22, 26, 30, 35, 40, 46, 52, 58, 65, 73, 81, 90, 100, 115, 130]
)  # fmt: skip

INCIDENCES = np.radians([10.0, 20.0, 30.0, 45.0, 60.0])

AZIMUTHS = np.radians(np.arange(0.0, 181.0, 15.0))

STEEPEST = np.radians(85.0)

DARK, REFERENCE_DARK = 240.0, 35.0


def paint(wavelengths):
    """BRDF of a paint: coloured matt, and a colourless lobe of 8.7 degrees about the mirror direction."""
    colour = 0.15 + 0.7 / (1.0 + np.exp((570.0 - np.asarray(wavelengths)) / 25.0))

    def evaluate(wi, wo):
        mirrored = wi * np.array([-1.0, -1.0, 1.0])
        away = np.arccos(np.clip((mirrored * wo).sum(axis=1), -1.0, 1.0))
        lobe = 1.8 * np.exp(-0.5 * (away / np.radians(8.7)) ** 2)
        return 0.35 / np.pi * colour + lobe[:, None]

    return evaluate


def lift(incidence: float, count: int) -> np.ndarray:
    """The direction of light, so many times. (n, 3)"""
    return np.tile([np.sin(incidence), 0.0, np.cos(incidence)], (count, 1))


def measure(
    evaluate,
    wavelengths,
    incidences=INCIDENCES,
    noise=0.03,
    holes=0.1,
    radials=RADIALS,
    seed=3,
    **known,
) -> RawMeasurement:
    """Counts of a sample and of the white one.

    ``noise`` is that of the BRDF; of every direction a share ``holes`` is not seen at all, and as much of single bands.
    """
    rng = np.random.default_rng(seed)
    wavelengths = np.asarray(wavelengths, dtype=np.float64)
    # How well the instrument sees: by band and direction, which the white sample tells.
    sight = 4e4 * np.exp(-(((wavelengths - 560.0) / 150.0) ** 2))
    slices, seen = [], 0
    for incidence in incidences:
        radial, azimuth = (m.ravel() for m in np.meshgrid(radials, AZIMUTHS, indexing="ij"))
        wo = direction_of(incidence, radial, azimuth)
        above = wo[:, 2] > np.cos(STEEPEST)
        radial, azimuth, wo = radial[above], azimuth[above], wo[above]
        count = len(radial), len(wavelengths)
        true = evaluate(lift(incidence, count[0]), wo)
        place = seen + np.arange(count[0])
        seen += count[0]
        # The lamp fades by a fifth, and flickers; the reference channel sees it.
        lamp = [
            (1.0 - 0.2 * place / 2000.0) * (1.0 + 0.05 * rng.standard_normal(count[0]))
            for _ in range(2)
        ]
        aim = 1.0 + 0.2 * np.sin(3.0 * azimuth + 5.0 * radial)
        spread = noise * rng.standard_normal(count)
        sample = sight * (aim * lamp[0])[:, None] * true * (1.0 + spread) + DARK
        # The white sample was measured more often.
        again = 1.0 + noise / 3.0 * rng.standard_normal(count)
        white = sight * (aim * lamp[1])[:, None] * WHITE * again + DARK
        references = [1e4 * each[:, None] * np.ones(count) + REFERENCE_DARK for each in lamp]
        sample[rng.random(count[0]) < holes] = np.nan
        sample[rng.random(count) < 0.5 * holes] = np.nan
        # A shadowed detector counts as if it were dark.
        white[rng.random(count[0]) < 0.1 * holes] = DARK
        slices.append(
            RawSlice(float(incidence), radial, azimuth, sample, references[0], white, references[1])
        )
    bands = len(wavelengths)
    return RawMeasurement(
        wavelengths,
        tuple(slices),
        np.full(bands, WHITE),
        np.full(bands, DARK),
        np.full(bands, REFERENCE_DARK),
        Instrument(**{"repeatability": noise or 0.01, "lowest": 1.0, **known}),
    )


def text_of(raw, *head) -> bytes:
    lines = ["# lumenray raw measurement 1", f"# white brdf: {WHITE}", *head]
    lines.append("sigma, theta, phi, wavelength, sample, sample_reference, white, white_reference")
    rows = []
    for piece in raw.slices:
        for d in range(len(piece.radial)):
            angles = np.degrees([piece.incidence, piece.radial[d], piece.azimuth[d]])
            for w, wavelength in enumerate(raw.wavelengths):
                channels = (
                    piece.sample,
                    piece.sample_reference,
                    piece.white,
                    piece.white_reference,
                )
                counts = ["" if np.isnan(c[d, w]) else repr(float(c[d, w])) for c in channels]
                rows.append(
                    ", ".join([*map(repr, map(float, angles)), repr(float(wavelength)), *counts])
                )
    np.random.default_rng(1).shuffle(rows)
    return "\n".join(lines + rows).encode()
