"""What a scene's report is called, what it has, and where it is written; reached as ``scene.lumenray.report``."""

from bpy.props import BoolProperty, StringProperty
from bpy.types import PropertyGroup

from ..foundation.settings import PATH_OPTIONS


class LumenrayReportSettings(PropertyGroup):
    """Cover and extent of the report."""

    title: StringProperty(
        name="Title",
        description="Of the report, such as the project's name. Default empty: the name of the file",
        maxlen=200,
    )
    client: StringProperty(
        name="Client", description="Whom the report is for. Default empty: left out", maxlen=200
    )
    author: StringProperty(
        name="By", description="Who has made the design. Default empty: left out", maxlen=200
    )
    filepath: StringProperty(
        name="File",
        description=(
            "HTML file of the report; CSV and JSON with all values are written beside it. Default: beside the .blend file"
        ),
        subtype="FILE_PATH",
        default="//report.html",
        options=PATH_OPTIONS,
    )
    use_pdf: BoolProperty(
        name="PDF",
        description="Write the report as a PDF file too. Default off: browsers print the HTML file",
        default=False,
    )
    use_picture: BoolProperty(
        name="Picture",
        description=(
            "Render what the camera sees for the report, with the settings of renders; lighting scenes share that one "
            "render. Default on: clients look at pictures first"
        ),
        default=True,
    )


CLASSES = (LumenrayReportSettings,)
"""For registration."""
