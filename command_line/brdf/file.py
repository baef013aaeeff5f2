"""Scattering files as the commands open them, and their totals."""

from ..options import share


def add_tolerance(parser) -> None:
    """Let a command say which error of resampling it allows."""
    parser.add_argument(
        "--tolerance",
        type=share(1e-3, 0.5),
        metavar="E",
        help="error allowed where data have to be resampled, were before, or are written as RGL; what misses it is "
        "refused (default: 2%%, and what misses it tells by how much)",
    )


def open_scattering(options, path):
    """Read a scattering file with the tolerance that was asked for."""
    from ...engine.scattering.readers.reader import Wish, read_scattering

    if options.tolerance is None:
        return read_scattering(path)
    return read_scattering(path, Wish(options.tolerance, is_strict=True))


def totals_of(scatter, incidences=None):
    """Totals at angles of incidence, weighed by V(lambda) and averaged over the azimuth. (s,)"""
    import numpy as np

    from ...engine.analysis.scattering_picture import luminous_mean
    from ...engine.scattering.data.evaluation import incidences_of, totals
    from ...engine.scattering.data.table import rotations_around
    from ...engine.scene.scattering import ScatterTable

    if scatter.is_isotropic:
        rotations = np.zeros(1)
    elif isinstance(scatter, ScatterTable):
        rotations = rotations_around(scatter)
    else:
        # Twice as many as the finest Klems ring has patches, so that each counts alike.
        rotations = np.arange(48) * np.pi / 24.0
    incidences = incidences_of(scatter) if incidences is None else incidences
    made = luminous_mean(scatter.wavelengths, totals(scatter, incidences, rotations))
    # Rotations may lie unevenly; between them totals are linear.
    gaps = np.diff(rotations, append=rotations[0] + 2.0 * np.pi)
    return np.average(made, axis=0, weights=gaps + np.roll(gaps, 1))
