"""What of a scene may be simplified, reached as ``scene.lumenray.modelling``: a switch for each decision of the engine."""

from bpy.props import EnumProperty, FloatProperty
from bpy.types import PropertyGroup

from ...engine.scene.modelling import DESCRIPTIONS, Modelling
from .. import readout
from ..foundation.settings import percentage, redraw_views, tag_owner

CHOICES = [
    ("AUTO", "Automatic", "Simplified where the bound of its error fits into the asked error", 0),
    ("FORCE", "Force", "Simplified whatever it costs; results have its bound in their errors", 1),
    ("OFF", "Off", "Modelled in full", 2),
]
"""Of every switch; the identifiers are those of the engine's `Switch`."""

SWITCHES = {name: name.replace(" ", "_").replace("-", "_") for name in DESCRIPTIONS}
"""Names of the properties, by the names of the decisions."""

PURPOSES = [
    ("PICTURE", "Picture", "What the camera sees, to the error at which renders stop", 0),
    ("LUX_MAPS", "Lux Maps", "Illuminance of surfaces, to the error at which bakes end", 1),
    ("SENSORS", "Sensors", "What sensors measure, to the error at which measuring ends", 2),
]
"""What a scene may be computed for."""


def _switch(name: str):
    """Property of a decision; its tooltip begins with what the decision does."""
    return EnumProperty(
        name=readout.title_case(name),
        description=f"{DESCRIPTIONS[name]}. Default Automatic: exact, or simplified within the asked error",
        items=CHOICES,
        default="AUTO",
        update=tag_owner,
    )


class LumenrayModellingSettings(PropertyGroup):
    """Who decides what is simplified, and how much of an asked error that may take."""

    __annotations__ = {
        **{key: _switch(name) for name, key in SWITCHES.items()},
        "share": FloatProperty(
            name="Share",
            description=(
                "Part of the asked error that simplifications may take, as a share; samples have the rest, in quadrature. "
                "Default 0.3333: it leaves samples 94 % of the error"
            ),
            default=Modelling.share,
            min=0.0,
            max=0.9,
            precision=4,
            update=tag_owner,
        ),
        "share_percent": percentage(
            "share",
            "Share of Simplifications",
            "Part of the asked error that simplifications may take; samples have the rest, in quadrature. Default 33 %: "
            "it leaves samples 94 % of the error",
            soft_max=90.0,
        ),
        "purpose": EnumProperty(
            name="Computed for",
            description=(
                "What the scene is computed for, which says how large its error may be. Default Picture: what rendering "
                "needs"
            ),
            items=PURPOSES,
            default="PICTURE",
            update=redraw_views,
        ),
    }


CLASSES = (LumenrayModellingSettings,)
"""For registration."""
