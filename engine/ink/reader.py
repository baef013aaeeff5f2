"""Files of dense pigment layers: JSON by the schema in ``libraries/inks``."""

import json
from functools import lru_cache
from pathlib import Path

from ...libraries import inks
from ..errors import FileFormatError
from ..optical_constants.quantities import Quantities
from ..paint.reader import known_constituents
from ..reading.content import read_json
from ..reading.json_schema import SchemaError, check_value
from ..scene.scattering import ScatterTable
from .composition import Ink, Pigment, Relief, Solving
from .packing import DENSEST
from .particles import Population

LARGEST_FILE = 4 << 20
"""[byte]"""


@lru_cache
def schema() -> dict:
    """Return the JSON schema of a composition."""
    return json.loads(inks.SCHEMA.read_text(encoding="utf-8"))


def read_ink(path) -> Ink:
    """Read a file of a pigment layer.

    Raises
    ------
    FileFormatError    It cannot be read, or says what cannot be; the text says where.
    """
    return parse_ink(read_json(path, LARGEST_FILE), path)


def parse_ink(content: dict, path="ink") -> Ink:
    """Make a pigment layer of its description, as JSON gives it.

    Parameters
    ----------
    path : str or Path    Named by errors; files that the description names lie beside it.

    Raises
    ------
    FileFormatError    As of `read_ink`.
    """
    try:
        check_value(content, schema())
        return _Maker(known_constituents()["indices"], path).ink(content)
    except (SchemaError, ValueError) as error:
        raise FileFormatError(path, str(error)) from None


class _Maker(Quantities):
    """Makes a pigment layer of a checked description."""

    def ink(self, content: dict) -> Ink:
        """Make it."""
        pigments = tuple(
            self.pigment(own, f"pigments[{k}]") for k, own in enumerate(content.get("pigments", []))
        )
        thickness = float(content["thickness_um"])
        spread = float(content.get("thickness_spread", 0.1))
        solid = sum(each.population.share for each in pigments if not each.is_dissolved)
        if sum(each.population.share for each in pigments) > 1.0 or solid > DENSEST + 1e-9:
            raise ValueError(
                f"pigments: particles fill {100 * solid:.3g} % of the volume, expected {100 * DENSEST:g} % at most, and all "
                "pigments together no more than the layer"
            )
        for k, each in enumerate(pigments):
            if each.population.diameter > thickness * (1.0 - spread):
                raise ValueError(
                    f"pigments[{k}].median_um is {each.population.diameter:g}, expected less than the layer is thick "
                    f"where it is thinnest, {thickness * (1.0 - spread):.3g}"
                )
        relief = content.get("relief")
        texts = (content.get(name, "") for name in ("name", "description", "source"))
        return Ink(
            thickness,
            spread,
            self.index(content["binder"]["index"], "binder.index"),
            pigments,
            Relief(float(relief["height_um"]), float(relief["length_um"]))
            if relief and relief["height_um"] > 0.0
            else None,
            self.substrate(content["substrate"]),
            float(content["substrate"].get("contact_index", 1.0)),
            _solving(content.get("solution", {})),
            *texts,
            content,
        )

    def pigment(self, content: dict, place: str) -> Pigment:
        """Make a pigment."""
        clusters = content.get("clusters", {})
        population = Population(
            float(content["volume_fraction"]),
            float(content.get("median_um", 0.0)),
            float(content.get("log_spread", 0.0)),
            content.get("shape", "sphere"),
            float(content.get("alignment", 0.0)),
            float(clusters.get("size", 1.0)),
            float(clusters.get("radius_um", 0.0)),
        )
        return Pigment(
            self.index(content["index"], f"{place}.index"), population, content.get("name", "")
        )

    def substrate(self, content: dict):
        """Make the substrate."""
        if "reflectance" in content:
            return self.spectrum(content["reflectance"], "substrate.reflectance", most=1.0)
        # Readers of scattering are many, and most layers need none.
        from ..scattering.readers.reader import read_scattering

        path = Path(self.path).parent / content["table"]
        side = read_scattering(path).sides.get("front_reflection")
        if not isinstance(side, ScatterTable) or not side.is_isotropic or side.has_direct:
            raise ValueError(
                f"substrate.table: {path.name} has no isotropic reflection as a table without a mirror's part"
            )
        return side


def _solving(content: dict) -> Solving:
    whole = {
        name: int(content[name])
        for name in ("realisations", "incidences", "seed")
        if name in content
    }
    return Solving(
        content.get("cell_um"),
        content.get("steps_per_diameter"),
        content.get("band_step_nm"),
        tolerance=content.get("tolerance"),
        **whole,
    )
