"""Kinds of surfaces that a user can state in place of a node tree; `sync.materials.overrides` makes them."""

from dataclasses import dataclass

from .scattering.files import MEASURED

PAINT = "PAINT"
"""Model of paints by their composition, see `paints`."""

INK = "INK"
"""Model of dense pigment layers by their composition, see `inks`."""

CLOTH = "CLOTH"
"""Model of cloths by their composition, see `cloths`."""


@dataclass(frozen=True)
class Model:
    """A kind of surface as a user states it.

    Parameters
    ----------
    title, description : str    For people.
    number : int    By which saved files know it.
    settings : tuple of str    What the panel shows, by names of properties or of `ui.material.DRAWN`.
    """

    title: str
    description: str
    number: int
    settings: tuple[str, ...]


MODELS = {
    "DIFFUSE": Model(
        "Diffuse",
        "Matt reflection and, if set, diffuse transmission",
        0,
        ("reflectance", "transmittance"),
    ),
    "COATED": Model(
        "Coated",
        "Matt base under a clear gloss coat: paint, plastic, varnish",
        1,
        ("reflectance", "roughness", "ior"),
    ),
    "CONDUCTOR": Model("Metal", "Metal by its complex refractive index", 2, ("metal", "roughness")),
    "DIELECTRIC": Model("Solid Glass", "Transparent body that refracts", 3, ("roughness", "ior")),
    "THIN_GLASS": Model("Pane", "Thin sheet of glass as one surface", 4, ("pane",)),
    "EMITTER": Model(
        "Emitter",
        "Luminous surface, black by itself",
        5,
        ("luminance", "two_sided", "spectrum"),
    ),
    MEASURED: Model(
        "Measured",
        "Scattering measured or computed: a BRDF or BTDF file",
        6,
        ("measured",),
    ),
    "FABRIC": Model(
        "Fabric",
        "Roller blind, net or perforated sheet: some light passes straight, the rest is spread",
        7,
        ("reflectance", "openness", "transmittance"),
    ),
    PAINT: Model(
        "Paint",
        "Effect paint by its composition: layers with binder, flakes and pigments",
        8,
        ("paint",),
    ),
    INK: Model(
        "Pigment Layer",
        "Printed layer by its composition: particles packed in a binder on a substrate, by the wave equation",
        9,
        ("ink",),
    ),
    CLOTH: Model(
        "Cloth",
        "Woven cloth by its composition: yarns, weave and pile; curtains, screens, upholstery",
        10,
        ("cloth",),
    ),
}
"""Kinds of surfaces, by their names in scripts."""


def is_modelled(material, model: str) -> bool:
    """Whether a material is a surface of a kind, by its name in scripts."""
    settings = material.lumenray
    return settings.use_override and settings.model == model


def model_items() -> list[tuple[str, str, str, int]]:
    """Items of the enumeration of models."""
    return [(name, model.title, model.description, model.number) for name, model in MODELS.items()]
