"""Files of spectra as software of instruments writes them, made by the rules of CGATS."""

import numpy as np

NM = np.arange(380, 731, 10)
"""Wavelengths of most hand-held instruments. [nm]"""


def grey(share: float) -> np.ndarray:
    """Reflectance that rises a little towards red."""
    return share * (0.9 + 0.2 * (NM - 380) / 350.0)


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"'


def table(fields, sets, first="CGATS.17", more=(), between="\t") -> str:
    """A text of one table.

    Parameters
    ----------
    fields : sequence of str
    sets : sequence of sequences    Numbers, and texts, which are quoted.
    first : str    What it begins with.
    more : sequence of str    Lines of the head.
    between : str    What parts words.
    """
    rows = [
        between.join(_quoted(v) if isinstance(v, str) else f"{v:.6g}" for v in row) for row in sets
    ]
    return "\n".join(
        [
            first,
            "",
            'ORIGINATOR "i1Profiler"',
            'CREATED "3/27/2024"  # Time: 19:04',
            'KEYWORD "MEASUREMENT_CONDITION"',
            *more,
            f"NUMBER_OF_FIELDS {len(fields)}",
            "BEGIN_DATA_FORMAT",
            between.join(fields),
            "END_DATA_FORMAT",
            f"NUMBER_OF_SETS {len(sets)}",
            "BEGIN_DATA",
            *rows,
            "END_DATA",
            "",
        ]
    )


def samples(name="SPECTRAL_NM{}", factor=1.0, **options) -> str:
    """Three samples of a chart, with what else is measured of them."""
    fields = ["SAMPLE_ID", "SAMPLE_NAME", "LAB_L", *(name.format(nm) for nm in NM)]
    sets = [
        [k + 1, f"A {k + 1}", 50.0, *(factor * grey(share))]
        for k, share in enumerate((0.2, 0.5, 0.8))
    ]
    return table(fields, sets, **options)


def argyll(values, first=380.0, last=730.0, norm=1.0, kind="EMISSION", spectra=1) -> str:
    """A ``.sp`` file of ArgyllCMS: wavelengths are rounded in its fields' names."""
    wavelengths = np.linspace(first, last, len(values))
    stated = {
        "SPECTRAL_BANDS": f"{len(values)}",
        "SPECTRAL_START_NM": f"{first:f}",
        "SPECTRAL_END_NM": f"{last:f}",
        "SPECTRAL_NORM": f"{norm:f}",
    }
    more = [f'MEAS_TYPE "{kind}"']
    for key, value in stated.items():
        more += [f'KEYWORD "{key}"', f'{key} "{value}"']
    fields = [f"SPEC_{nm:03.0f}" for nm in wavelengths]
    return table(fields, [list(values)] * spectra, "SPECT   ", more, " ")


def pairs(kind="SPECTRAL_PCT", factor=100.0, wrap=7) -> str:
    """Pairs of wavelength and value, in lines that are broken every few words."""
    fields = ["SAMPLE_ID", *("SPECTRAL_NM", kind) * len(NM)]
    lines = table(
        fields, [["A1", *np.stack([NM, factor * grey(0.5)], 1).ravel()]], between=" "
    ).split("\n")
    place = lines.index("BEGIN_DATA") + 1
    words = lines[place].split(" ")
    lines[place : place + 1] = [" ".join(words[k : k + wrap]) for k in range(0, len(words), wrap)]
    return "\n".join(lines)
