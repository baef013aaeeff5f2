"""Recipes of the luminaires that ship, which ``recipes.json`` holds, and the files and the catalogue that they make.

All distributions are formulas (`distributions`) with the numbers that the recipes state; none is measured, none is copied
from a product. Fluxes, watts and sizes are those of usual products of their kind. The same recipes give the same bytes.

A recipe is an entry of the catalogue (`libraries.luminaires.catalogue`) with how its light is computed::

    {"file": "photometry/NAME.ies", …,
     "parts": ["fluorescent_tube", 1.16, 0.026],
     "photometry": {"formula": ["beam", 15.0], "kind": "C", "symmetry": "rotational",
                    "horizontal": [[0, 360, 5]], "vertical": [[0, 30, 0.5], [50, 90, 2.5]],
                    "opening": ["ellipse", [0.06, 0.06, 0.0]], "lamp": "LED", "lamp_flux": 3350.0, "colour": "3000 K"}}

``formula``, ``vertical`` and ``opening`` must be there. A formula is a name of `distributions.FORMULAS`, or a list of one of
`distributions.FAMILIES` and its numbers or formulas; ``parts``, of lamps of several emitters, is a list of one of
`parts.PARTS` and its numbers. Angles are ranges of first, last and step. The rest is that of `photometric_files.Photometry`.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....engine.errors import FileFormatError
from ....libraries.entries import UnusableError, path_inside
from ....libraries.luminaires import FOLDER
from ....libraries.luminaires.catalogue import LARGEST_JSON, LIST
from ....libraries.luminaires.description import describe
from ....libraries.luminaires.model import SHAPES
from ....libraries.plain_files import UnreadableError, read_object
from .distributions import FAMILIES, FORMULAS
from .parts import PARTS
from .photometric_files import STORED, SYMMETRIES, TYPES, Photometry, write_ies, write_ldt

RECIPES = Path(__file__).with_name("recipes.json")

COLOURS = {
    "LED-B1": ("2733 K", "80"),
    "LED-B2": ("2998 K", "80"),
    "LED-B3": ("4103 K", "80"),
    "LED-B4": ("5109 K", "80"),
    "LED-B5": ("6598 K", "80"),
    "LED-BH1": ("2851 K", "90"),
    "FL11": ("4000 K", "80"),
    "A": ("2856 K", "100"),
}
"""Correlated colour temperature (CIE 15:2018, tables of illuminants) and class of rendering of the spectra."""

WRITERS = {".ies": write_ies, ".ldt": write_ldt}
"""By the end of a file's name."""

SMALLEST_STEP = 0.01
"""Between angles. [degree]"""


@dataclass(frozen=True, eq=False)
class Recipe:
    """A luminaire: its entry in the catalogue, and what its file says."""

    entry: dict
    photometry: Photometry

    def content(self) -> bytes:
        """Return the bytes of the photometric file."""
        file = Path(self.entry["file"])
        # Both formats are plain ASCII here.
        title = self.entry["title"].replace("°", " deg")
        return WRITERS[file.suffix](self.photometry, file.stem, title)


def write(folder: Path) -> list[Path]:
    """Write the photometric files and the catalogue; return them."""
    (folder / "photometry").mkdir(parents=True, exist_ok=True)
    common, recipes = read_recipes()
    paths = [folder / recipe.entry["file"] for recipe in recipes]
    for path, recipe in zip(paths, recipes, strict=True):
        path.write_bytes(recipe.content())
    catalogue = {**common, "models": [recipe.entry for recipe in recipes]}
    text = json.dumps(catalogue, indent=1, ensure_ascii=False)
    (folder / LIST).write_bytes(f"{text}\n".encode())
    return [*paths, folder / LIST]


def read_recipes(path: Path = RECIPES) -> tuple[dict, list[Recipe]]:
    """Return what holds for all luminaires, and the recipe of each.

    Raises
    ------
    FileFormatError    The file cannot be read, or a recipe says what cannot be.
    """
    try:
        common = read_object(path, LARGEST_JSON)
    except UnreadableError as error:
        raise FileFormatError(path, str(error)) from None
    models = common.pop("models", None)
    if not isinstance(models, list):
        raise FileFormatError(path, "'models' should be a list")
    recipes = []
    for number, says in enumerate(models, 1):
        try:
            recipes.append(_recipe(says))
        except (UnusableError, TypeError, ValueError) as error:
            raise FileFormatError(path, f"luminaire {number}: {error}") from error
    return common, recipes


def _recipe(says: dict) -> Recipe:
    entry = dict(says)
    fields = dict(entry.pop("photometry", {}))
    file = path_inside(FOLDER, entry.get("file"))
    if file is None:
        raise UnusableError("needs a 'file' in the library's folder")
    _one_of(WRITERS, file.suffix, "end of the file's name")
    if "parts" in entry:
        name, *numbers = entry["parts"]
        entry["parts"] = PARTS[_one_of(PARTS, name, "'parts'")](*numbers)
    # As entries of users' folders are checked.
    model = describe(FOLDER, file, entry)
    if model.luminous_flux is None or model.watts is None:
        raise UnusableError("needs a 'luminous_flux_lm' and 'watts'")
    if not {"formula", "vertical", "opening"} <= fields.keys():
        raise UnusableError("its 'photometry' needs a 'formula', a 'vertical' and an 'opening'")
    fields["formula"] = _formula(fields["formula"])
    for key in ("horizontal", "vertical"):
        if key in fields:
            fields[key] = _angles(key, fields[key])
    colour, rendering = COLOURS.get(model.light and model.light.name, ("", ""))
    fields = {"colour": colour, "rendering": rendering, **fields}
    photometry = Photometry(flux=model.luminous_flux, watts=model.watts, **fields)
    is_eulumdat = file.suffix == ".ldt"
    _one_of(("C",) if is_eulumdat else TYPES, photometry.kind, "'kind'")
    _one_of(STORED if is_eulumdat else SYMMETRIES, photometry.symmetry, "'symmetry'")
    shape, sides = photometry.opening
    _one_of(SHAPES, shape, "shape of the 'opening'")
    if len(sides) != 3 or min(sides) < 0.0:
        raise UnusableError("the 'opening' needs three sides, none negative")
    return Recipe(entry, photometry)


def _one_of(known, word, where: str):
    if word not in known:
        raise UnusableError(f"the {where} is '{word}', expected one of {', '.join(known)}")
    return word


def _formula(says):
    if isinstance(says, str):
        return FORMULAS[_one_of(FORMULAS, says, "'formula'")]
    name, *arguments = says
    family = FAMILIES[_one_of(FAMILIES, name, "family of the 'formula'")]
    return family(*(_formula(a) if isinstance(a, str | list) else a for a in arguments))


def _angles(key: str, ranges: list) -> np.ndarray:
    """Angles of all ranges, each once. (n,) [degree]"""
    for first, last, step in ranges:
        if not -360.0 <= first <= last <= 360.0 or not step >= SMALLEST_STEP:
            raise UnusableError(
                f"'{key}' has the range {[first, last, step]}, expected a first, a last and a step of at least "
                f"{SMALLEST_STEP:g} degrees"
            )
    angles = [np.arange(first, last + step / 2.0, step) for first, last, step in ranges]
    return np.unique(np.round(np.concatenate(angles), 6))
