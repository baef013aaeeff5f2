"""Luminaires of a scene as rows of a schedule."""

from pathlib import Path

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.judgement.schedule import Fitting
from ...engine.reading.printable import printable
from ..foundation.pose import pose_of
from ..foundation.units import metres_per_unit
from ..sync.lights.portals import is_portal
from ..sync.visibility import find_unrendered, is_rendered
from .convert import find_amount
from .files import photometric_files
from .settings import is_luminaire, settings_of

NAMES = ("LUMINAIRE", "LUMCAT")
"""Keywords of photometric files that name what they are of."""


def find_fittings(depsgraph) -> tuple[list[Fitting], list[str], int]:
    """Find luminaires that renders show.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph    Evaluated.

    Returns
    -------
    fittings : list of Fitting    One for each luminaire.
    problems : list of str    Why luminaires could not be taken.
    others : int    Lights without a photometric file, whose power is not known.
    """
    scale, unrendered = metres_per_unit(depsgraph.scene), find_unrendered(depsgraph.view_layer)
    fittings, problems, others = [], [], 0
    for instance in depsgraph.object_instances:
        source = instance.object
        if not instance.show_self or not is_rendered(instance, unrendered):
            continue
        if not is_luminaire(source):
            others += _takes_power(source)
            continue
        settings = settings_of(source)
        frame = pose_of(np.array(instance.matrix_world), scale).frame
        try:
            reading = photometric_files.obtain(settings)
            amount = find_amount(settings, reading, frame)
        except LumenrayError as error:
            problems.append(f"{source.name_full}: {error}")
            continue
        name = _name(reading.file, photometric_files.absolute_path(settings) or source.name_full)
        fittings.append(Fitting(name, amount.luminous_flux, reading.file.watts, file=reading.file))
    return fittings, list(dict.fromkeys(problems)), others


def _takes_power(source) -> bool:
    return source.type == "LIGHT" and source.data.type != "SUN" and not is_portal(source.data)


def _name(file, path: str) -> str:
    words = next((file.metadata[key] for key in NAMES if file.metadata.get(key, "").strip()), "")
    return printable(" ".join(words.split()) or Path(path).name)
