"""What operators on the file behind a light or a material share: when they can be used, and how they report."""

from bpy.props import StringProperty

from ..engine.errors import LumenrayError


class FileOperator:
    """Operator on the file of what is active.

    Each kind of file gives ``kind``, its `FileKind`; ``find``, which returns the settings by the context, None if there are
    none; and ``nobody``, why the operator cannot be used then.
    """

    bl_options = {"REGISTER", "UNDO"}
    elsewhere = "It is linked from another file, where it can be changed"
    """Why the operator cannot be used on what is linked."""

    @classmethod
    def poll(cls, context):
        problem = cls.problem(cls.find(context))
        if problem:
            cls.poll_message_set(problem)
        return not problem

    @classmethod
    def problem(cls, settings) -> str:
        """Say why the operator cannot be used, empty if it can."""
        if settings is None:
            return cls.nobody
        return cls.elsewhere if settings.id_data.library is not None else ""

    def execute(self, context):
        try:
            self.report(*self.work(context, self.find(context)))
        except LumenrayError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class LoadFile(FileOperator):
    """Operator that chooses a file."""

    filepath: StringProperty(
        description="Path of the file; empty asks for one",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )

    def invoke(self, context, event):
        if self.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}


class WithFile(FileOperator):
    """Operator that needs a file to be chosen."""

    @classmethod
    def problem(cls, settings) -> str:
        found = super().problem(settings)
        if found or cls.kind.name_of(settings):
            return found
        return f"No {cls.kind.noun} is chosen"


class ReloadFile(WithFile):
    """Operator that reads a file anew; ``take_up`` says what was read."""

    @classmethod
    def problem(cls, settings) -> str:
        found = super().problem(settings)
        if not found and not settings.filepath:
            return "It is not known where the file was read from"
        return found

    def work(self, context, settings):
        self.kind.reload(settings)
        return self.take_up(settings)


class PackFile(WithFile):
    """Operator that embeds a file."""

    @classmethod
    def problem(cls, settings) -> str:
        found = super().problem(settings)
        if not found and settings.text is not None:
            return "The file is embedded already"
        return found

    def work(self, context, settings):
        self.kind.pack(settings)
        return {"INFO"}, f"{self.kind.name_of(settings)} is embedded"


class UnpackFile(FileOperator):
    """Operator that links an embedded file."""

    @classmethod
    def problem(cls, settings) -> str:
        found = super().problem(settings)
        if not found and settings.text is None:
            return "No file is embedded"
        return found

    def work(self, context, settings):
        return {"INFO"}, f"linked to {self.kind.unpack(settings)}"


def tell(words: str, remarks) -> tuple[set[str], str]:
    """Report what was read, and what is to be known of it."""
    if not remarks:
        return {"INFO"}, words
    count = f"{len(remarks)} remarks, the first: " if len(remarks) > 1 else ""
    return {"WARNING"}, f"{words}; {count}{remarks[0]}"
