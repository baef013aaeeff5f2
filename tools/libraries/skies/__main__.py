"""Command ``python -m lumenray.tools.libraries.skies``: write the spectral table of Hosek and Wilkie, from Mitsuba's data.

Mitsuba ships the published numbers for its emitter ``sunsky``, under the licence that stands beside the table.
"""

import csv
import struct
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ....libraries.skies import FOLDER, WAVELENGTHS


def main():
    """Write the table."""
    folder = Path(find_spec("mitsuba").origin).parent
    fields = read_tensors((folder / "data" / "sunsky" / "sunsky_datasets.bin").read_bytes())
    # By turbidity, albedo, point and wavelength there.
    numbers, radiances = (
        np.moveaxis(fields[name], 3, 0) for name in ("sky_params_spec", "sky_rad_spec")
    )
    with (FOLDER / "hosek_wilkie_spectral.csv").open("w", newline="") as table:
        writer = csv.writer(table, lineterminator="\n")
        names = (f"c{i}" for i in range(numbers.shape[-1]))
        writer.writerow(["nm", "albedo", "turbidity", "point", *names, "radiance"])
        for number, wavelength in enumerate(WAVELENGTHS):
            for albedo in range(2):
                for turbidity in range(10):
                    for point in range(6):
                        at = number, turbidity, albedo, point
                        values = (*numbers[at], radiances[at])
                        row = (wavelength, albedo, turbidity + 1, point)
                        writer.writerow([*row, *(f"{value:.7g}" for value in values)])


def read_tensors(data: bytes) -> dict[str, np.ndarray]:
    """Return the arrays of double precision in a file of tensors, by name."""
    (count,) = struct.unpack_from("<I", data, 14)
    place, made = 18, {}
    for _ in range(count):
        (length,) = struct.unpack_from("<H", data, place)
        name = data[place + 2 : place + 2 + length].decode()
        place += 2 + length
        dimensions, _, offset = struct.unpack_from("<HBQ", data, place)
        shape = struct.unpack_from(f"<{dimensions}Q", data, place + 11)
        place += 11 + 8 * dimensions
        made[name] = np.frombuffer(data, "<f8", int(np.prod(shape)), offset).reshape(shape)
    return made


if __name__ == "__main__":
    main()
