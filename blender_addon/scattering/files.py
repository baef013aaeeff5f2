"""Scattering files behind materials. Large ones take up to a minute to be read and resampled.

A file is embedded in our own compact format, whatever its own was.
"""

from dataclasses import dataclass, is_dataclass, replace

import bpy

from ...engine.scattering.file_names import MAXIMUM_SIZE, SUFFIX
from ...imports import loaded_when_used
from ...libraries.materials import FOLDER, PREFIX
from ..file_assets.embedding import EmbeddableKind
from ..file_assets.places import Library, digest_of

with loaded_when_used():
    import numpy as np

    from ...engine.scattering import look as scattering_look
    from ...engine.scattering import summary
    from ...engine.scattering.data import record, store, surface
    from ...engine.scattering.readers import reader

MEASURED = "MEASURED"
"""Name of the model of a surface in the settings of a material."""

KEPT = 256
"""Files that are kept: more than scenes have, as each reading of all of them would else read all anew."""


def is_measured(material) -> bool:
    """Whether a material scatters as a file says."""
    settings = material.lumenray
    return settings.use_override and settings.model == MEASURED


@dataclass(frozen=True, eq=False)
class Reading:
    """A scattering file as it was read; shared by all materials with this content. Its arrays are read-only.

    Parameters
    ----------
    file : ScatteringFile
    digest : str    SHA-256 of the content, in hexadecimal.
    sides : dict of str to SideSummary
    look : Look
    """

    file: "record.ScatteringFile"
    digest: str
    sides: "dict[str, summary.SideSummary]"
    look: "scattering_look.Look"


class ScatteringFiles(EmbeddableKind):
    """Files that materials scatter as."""

    noun = "scattering file"
    folder = "materials"
    ending = SUFFIX
    largest = MAXIMUM_SIZE
    library = Library(PREFIX, FOLDER, SUFFIX)

    def terms_of(self, settings) -> "reader.Wish":
        return reader.Wish(settings.tolerance)

    def read(self, job, data, path, terms, origin="") -> Reading:
        digest = digest_of(data)
        return self._shelf.shared((digest, terms), lambda: _make(data, path, origin, terms, digest))

    def users(self):
        return (material for material in bpy.data.materials if is_measured(material))

    def packed(self, data, reading) -> bytes:
        return data if store.is_store(data) else store.pack(reading.file)


scattering_files = ScatteringFiles(KEPT, "lumenray-scattering")


def _make(data: bytes, path: str, origin: str, wish: "reader.Wish", digest: str) -> Reading:
    """Read a content, and find everything that is asked of it."""
    file = reader.parse_scattering(data, path, wish)
    if origin:
        file = replace(file, format=origin)
    for scatter in set(file.sides.values()):
        _freeze(scatter)
        # Found here once and remembered, as it takes a while.
        surface.excess_of(scatter, None)
    return Reading(file, digest, summary.summarise(file), scattering_look.fit_look(file))


def _freeze(value) -> None:
    """Make all arrays of a scatter read-only: what follows from them is remembered then."""
    for part in vars(value).values():
        if isinstance(part, np.ndarray):
            part.flags.writeable = False
        elif is_dataclass(part):
            _freeze(part)
