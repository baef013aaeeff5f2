"""Photometric files behind lights and empties, each content read once.

A file is embedded as the text that it is. Blender keeps the line ends of a text as they are, so the bytes come back as they
were.
"""

import re
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import bpy

from ...engine.errors import LumenrayError
from ...engine.reading.content import read_bytes
from ...engine.reading.text import find_encoding
from ...imports import loaded_when_used
from ..file_assets.embedding import EmbeddableKind
from ..file_assets.kind import NoFileError, State
from ..file_assets.places import digest_of, stored_path
from ..file_assets.texts import new_text

with loaded_when_used():
    from ...engine.luminaires import distribution as distributions
    from ...engine.luminaires import lamp_spectrum as lamp_spectra
    from ...engine.luminaires.formats import record
    from ...engine.scene import distribution as scene_distribution

EXTENSIONS = (".ies", ".ldt", ".xml")
"""Of photometric files."""

LONGEST_LINE = 100_000
"""Characters in a line that Blender's texts can take: their time grows with its square, 0.2 s at this length."""

KEPT_BYTES = 1 << 28
"""Content of which the readings are kept. [byte]"""

_TILT_FILE = re.compile(
    rb"^[ \t]*TILT[ \t]*=[ \t]*(?!NONE|INCLUDE)\S", re.IGNORECASE | re.MULTILINE
)


class NotTextError(LumenrayError):
    """A file can be read, but Blender's texts cannot hold it."""


@dataclass(frozen=True, eq=False)
class Reading:
    """A photometric file as it was read; shared by everything with this content.

    Parameters
    ----------
    file : LuminaireFile
    digest : str    SHA-256 of the content, in hexadecimal.
    """

    file: "record.LuminaireFile"
    digest: str

    @property
    def distribution(self) -> "scene_distribution.IntensityDistribution":
        """As it is stored, before any setting turns it."""
        return self.file.distribution

    @cached_property
    def flux(self) -> float:
        """Of the distribution. [lm, of radiant files W]"""
        return distributions.flux(self.file.distribution)

    @cached_property
    def lamp_spectrum(self) -> "lamp_spectra.LampSpectrum":
        """What the file says of its lamp."""
        return lamp_spectra.choose_spectrum(self.file)


def names_tilt_file(data: bytes) -> bool:
    """Whether a content needs another file beside it."""
    return _TILT_FILE.search(data.replace(b"\0", b"")) is not None


class PhotometricFiles(EmbeddableKind):
    """Files that lights and empties shine as. The folder where a TILT file may lie counts beside the content."""

    noun = "photometric file"
    folder = "luminaires"

    def terms_of(self, settings) -> Path | None:
        path = self.absolute_path(settings)
        return Path(path).parent if path else None

    def read(self, job, data, path, terms, origin="") -> Reading:
        # Readers are large, and most files have no luminaire.
        from ...engine.luminaires.formats.reader import parse_luminaire

        job.size, digest = len(data), digest_of(data)

        def make():
            return Reading(parse_luminaire(data, path, terms), digest)

        return make() if names_tilt_file(data) else self._shelf.shared(digest, make)

    def source_of_text(self, text, terms) -> tuple:
        self.require(text)
        data, name = self.content_of(text), text.name
        key = (digest_of(data), name, terms)
        return key, lambda: lambda job: self.read(job, data, name, terms)

    def obtain_path(self, path: str) -> Reading:
        """Read a file on disk.

        Raises
        ------
        FileFormatError    It cannot be opened, or is refused.
        """
        return self.result(*self.source_of_path(path, Path(path).parent))

    def obtain_text(self, text) -> Reading:
        """Read a text data-block.

        Raises
        ------
        NoFileError    It is missing in the file that it is linked from.
        FileFormatError    It is refused.
        """
        return self.result(*self.source_of_text(text, None))

    def state_of(self, settings) -> State:
        state = super().state_of(settings)
        if state.reading is None or not self.has_changed(settings, state.reading):
            return state
        return replace(state, notice=f"{state.notice}, edited since it was loaded")

    def has_changed(self, settings, reading: Reading) -> bool:
        """Whether what is read now differs from what was loaded: the file on disk, or the text in Blender, was edited."""
        text = settings.text
        loaded = text.lumenray.digest if text is not None else settings.digest
        return bool(loaded) and loaded != reading.digest

    # ---- embedding ----

    def content_of(self, text) -> bytes:
        content, encoding = text.as_string(), text.lumenray.encoding or "utf-8"
        try:
            return content.encode(encoding)
        except UnicodeEncodeError:
            # Someone wrote into it what its own encoding lacks.
            return content.encode("utf-8")

    def stated_digest(self, text) -> str:
        return text.lumenray.digest

    def make_text(self, data, name, origin):
        content, encoding = _decode(data, name)
        text = new_text(name, content)
        text.lumenray.digest, text.lumenray.encoding = digest_of(data), encoding
        return text

    def hold(self, settings, text, data) -> None:
        super().hold(settings, text, data)
        settings.digest = digest_of(data)

    def load(self, settings, path: str, is_embedded: bool = True) -> Reading:
        """Choose a file on disk for settings; they stay as they are if it is refused.

        What Blender's texts cannot hold is linked: ``settings.text`` tells whether it was embedded.

        Raises
        ------
        FileFormatError    It cannot be opened or is refused.
        """
        path = str(Path(bpy.path.abspath(path)).absolute())
        data, folder = read_bytes(path), Path(path).parent
        # By its content: it may have changed within the time that its date can tell.
        key = (digest_of(data), path, folder)
        reading = self.result(key, lambda: lambda job: self.read(job, data, path, folder))
        text = None
        if is_embedded:
            with suppress(NotTextError):
                text = self.embed(data, Path(path).name)
        settings.filepath = stored_path(path)
        self.hold(settings, text, data)
        settings.use_file = True
        return reading

    def reload(self, settings) -> Reading:
        """Read a file anew from where it was read; embedded stays embedded.

        Raises
        ------
        LumenrayError    As of `load`, or its place is not known.
        """
        path = self.absolute_path(settings)
        if not path:
            raise NoFileError("it is not known where the photometric file was read from")
        # All, as a TILT file may have changed.
        self.forget()
        return self.load(settings, path, settings.text is not None)

    def clear(self, settings) -> None:
        """Choose no photometric file."""
        settings.use_file = False
        # What was embedded goes with the path.
        settings.filepath = ""


photometric_files = PhotometricFiles(KEPT_BYTES)


def _decode(data: bytes, name: str) -> tuple[str, str]:
    """Return the text that bytes stand for, and in which encoding they come back exactly."""
    encoding = find_encoding(data)
    content = data.decode(encoding)
    if "\0" in content:
        raise NotTextError(f"{name} has NUL characters, which Blender's texts cannot hold")
    longest = max(map(len, re.split(r"[\r\n]", content)))
    if longest > LONGEST_LINE:
        raise NotTextError(
            f"{name} has a line of {longest} characters, Blender's texts take {LONGEST_LINE}"
        )
    return content, encoding
