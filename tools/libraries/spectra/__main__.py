"""Command ``python -m lumenray.tools.libraries.spectra``: write the CSV tables anew from colour-science (development extra).

The tables are the published CIE data: CIE 1931 2-degree observer (ISO/CIE 11664-1), illuminants (CIE 15:2018,
ISO/CIE 11664-2) and the daylight components S0, S1, S2 (CIE 15:2018, table T.2).
"""

import csv

import numpy as np

from ....libraries.spectra import FOLDER

ILLUMINANTS = (
    *("C", "E"),
    *(f"FL{i}" for i in range(1, 13)),
    *(f"FL3.{i}" for i in range(1, 16)),
    *(f"HP{i}" for i in range(1, 6)),
    *(f"LED-B{i}" for i in range(1, 6)),
    *("LED-BH1", "LED-RGB1", "LED-V1", "LED-V2"),
)


def write(name, header, rows):
    """Write one table with Unix line ends."""
    with (FOLDER / name).open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def main():
    """Write all tables."""
    import colour

    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    rows = [
        (int(nm), *(f"{v:.10g}" for v in xyz))
        for nm, xyz in zip(observer.wavelengths, observer.values, strict=True)
    ]
    write("observer_1931.csv", ("nm", "x", "y", "z"), rows)

    basis = colour.colorimetry.SDS_BASIS_FUNCTIONS_CIE_ILLUMINANT_D_SERIES
    wavelengths = np.arange(300, 831, 5)
    components = []
    for key in ("S0", "S1", "S2"):
        sd = basis[key]
        components.append(np.interp(wavelengths, sd.wavelengths, sd.values))
    rows = [
        (int(nm), *(f"{v:.6g}" for v in values))
        for nm, *values in zip(wavelengths, *components, strict=True)
    ]
    write("daylight_components.csv", ("nm", "S0", "S1", "S2"), rows)

    table = colour.SDS_ILLUMINANTS
    grid = np.arange(360, 831, 5)
    columns = []
    for name in ILLUMINANTS:
        sd = table[name]
        columns.append(np.interp(grid, sd.wavelengths, sd.values, left=0.0, right=0.0))
    rows = [
        (int(nm), *(f"{v:.6g}" for v in values)) for nm, *values in zip(grid, *columns, strict=True)
    ]
    write("illuminants.csv", ("nm", *ILLUMINANTS), rows)


if __name__ == "__main__":
    main()
