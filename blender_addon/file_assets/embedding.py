"""Files that can be embedded: a text data-block for every content, in place of the path that they were read from."""

from collections.abc import Callable
from pathlib import Path

import bpy

from ...engine.errors import FileFormatError, LumenrayError
from ...engine.reading.content import holds, read_bytes
from .kind import FileKind, NoFileError
from .places import digest_of, stored_path, write_copy
from .texts import head_of, new_text, stated_digest, unwrap, wrap


class EmbeddableKind(FileKind):
    """A kind of file that settings hold as a ``text``, or name by their ``filepath`` where they hold none.

    Unless a kind says otherwise, texts hold bytes as `texts.wrap` codes them.
    """

    folder: str
    """Where copies are written, beside the .blend file."""

    ending = ""
    """Of copies; empty: that of the file's name."""

    # ---- what differs ----

    def packed(self, data: bytes, reading) -> bytes:
        """Return what is embedded of a file's content."""
        return data

    def content_of(self, text) -> bytes:
        """Return the bytes of an embedded file.

        Raises
        ------
        FileFormatError    It is not what was embedded.
        """
        return unwrap(text.as_string(), self.noun, text.name)[0]

    def stated_digest(self, text) -> str:
        """Return the SHA-256 that a text states of its content, empty if it states none."""
        return stated_digest(head_of(text), self.noun)

    def make_text(self, data: bytes, name: str, origin: str):
        """Make a text data-block of a content."""
        return new_text(name, wrap(data, self.noun, origin))

    def hold(self, settings, text, data: bytes) -> None:
        """Let settings hold a content as a text; with None they name it by their path.

        The text of before goes when Blender saves, if nothing uses it: a render that is under way may still read it.
        """
        settings.text = text

    # ---- where it is, and reading ----

    def name_of(self, settings) -> str:
        name = super().name_of(settings)
        return settings.text.name if not name and settings.text is not None else name

    def place_of(self, settings) -> str:
        if settings.text is not None:
            return "Embedded in the Blender file"
        return super().place_of(settings)

    def source(self, settings) -> tuple[tuple, Callable]:
        if settings.text is None:
            return super().source(settings)
        return self.source_of_text(settings.text, self.terms_of(settings))

    def source_of_text(self, text, terms) -> tuple[tuple, Callable]:
        """As `source`, of an embedded file."""
        self.require(text)
        name = text.name

        def prepare():
            # At once, as the thread must not look at it.
            content = text.as_string()

            def read(job):
                data, origin = unwrap(content, self.noun, name)
                return self.read(job, data, name, terms, origin)

            return read

        return (text.session_uid, head_of(text), terms), prepare

    def require(self, text) -> None:
        """Raise `NoFileError` if a text is missing in the file that it is linked from."""
        if text.is_missing:
            raise NoFileError(f"the embedded {self.noun} '{text.name}' is missing")

    def reload(self, settings) -> None:
        """Have the file of settings read anew from its path; one that is embedded is embedded anew.

        Raises
        ------
        LumenrayError    It cannot be read; what is embedded stays.
        """
        super().reload(settings)
        text = settings.text
        if text is None:
            return
        settings.text = None
        try:
            self.pack(settings)
        except LumenrayError:
            settings.text = text
            raise

    # ---- embedding and linking ----

    def embed(self, data: bytes, name: str, origin: str = ""):
        """Return the text data-block of a content: the one that is there already, or a new one.

        Parameters
        ----------
        data : bytes
        name : str    Of the file.
        origin : str    Format of the file that it was made of.

        Raises
        ------
        LumenrayError    It cannot be embedded.
        """
        digest = digest_of(data)
        for text in bpy.data.texts:
            is_same = text.library is None and self.stated_digest(text) == digest
            if is_same and self._holds(text, data):
                return text
        return self.make_text(data, name, origin)

    def _holds(self, text, data: bytes) -> bool:
        """Whether a text was not changed since it was made of a content."""
        try:
            return self.content_of(text) == data
        except FileFormatError:
            return False

    def pack(self, settings) -> None:
        """Embed the file that is linked.

        Raises
        ------
        LumenrayError    It cannot be read or embedded.
        """
        reading = self.obtain(settings)
        data = self.packed(read_bytes(self.absolute_path(settings), self.largest), reading)
        self.hold(settings, self.embed(data, self.name_of(settings), reading.file.format), data)

    def unpack(self, settings, folder: str = "") -> str:
        """Link the file that is embedded and return its path; it is written unless its own path still holds it.

        Parameters
        ----------
        settings : PropertyGroup
        folder : str    Where it is written; empty: into a folder beside the .blend file.

        Raises
        ------
        LumenrayError    There is no place for it, or it cannot be written.
        """
        data, path = self.content_of(settings.text), self.absolute_path(settings)
        if folder or not path or not holds(path, data):
            if not folder and not bpy.data.filepath:
                raise LumenrayError(
                    f"save the Blender file first: the {self.noun} is written beside it"
                )
            name = self.name_of(settings)
            if self.ending:
                name = f"{Path(name).stem}{self.ending}"
            path = str(write_copy(data, folder or f"//{self.folder}", name))
            settings.filepath = stored_path(path)
        self.hold(settings, None, data)
        return path
