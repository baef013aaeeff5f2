"""What each light of a scene gives, as renders get it, and the list of it as short text for a panel.

Lights are converted as for the engine, once for a list: reading it costs nothing.
"""

import time
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..engine.errors import SceneError
from ..engine.photometry.spectra import efficacy
from ..engine.reading.printable import printable
from ..engine.scene.light import AreaLight, Light, Luminaire, Output, Quantity, SunLight
from . import readout
from .foundation.report import ConversionReport
from .foundation.units import metres_per_unit
from .luminaires.convert import LEFT_OUT, NOTHING_VISIBLE
from .luminaires.settings import is_luminaire
from .raysets.convert import JOINS
from .raysets.settings import is_rayset
from .sync.images.cache import ImageCache
from .sync.lights.kinds import read_light
from .sync.lights.lights import convert_light
from .sync.lights.portals import is_portal
from .sync.visibility import find_unrendered, is_rendered

NO_SIZE = "the light has no size, so that it has no luminance"

NOT_LISTED = "Glowing materials and the world are not listed"


@dataclass
class ListedLight:
    """What an object gives: a light, or all lights that it makes as an instancer.

    Parameters
    ----------
    uid : int    Session uid of the object, which can be selected.
    name, icon : str
    amount : float
    unit : str    ``lm``; ``lx`` of suns.
    count : int    Lights.
    """

    uid: int
    name: str
    icon: str
    unit: str
    amount: float = 0.0
    count: int = 0


@dataclass(frozen=True)
class LightList:
    """The lights of a scene.

    Parameters
    ----------
    rows : tuple of ListedLight    Suns first, then the largest amounts.
    off : int    Lights that are hidden in renders or give nothing.
    hidden : int    Lights that are hidden in the viewport alone, where Blender evaluates nothing of them.
    problems : tuple of str    Why lights cannot be computed, each with its name.
    seconds : float    What finding it took. [s]
    """

    rows: tuple[ListedLight, ...] = ()
    off: int = 0
    hidden: int = 0
    problems: tuple[str, ...] = ()
    seconds: float = 0.0

    @cached_property
    def flux(self) -> float:
        """Of all lights but suns. [lm]"""
        return sum(row.amount for row in self.rows if row.unit == "lm")

    @cached_property
    def count(self) -> int:
        """Lights in all rows."""
        return sum(row.count for row in self.rows)

    @cached_property
    def suns(self) -> int:
        """Suns among them."""
        return sum(row.count for row in self.rows if row.unit == "lx")


def amount_of(light: Light) -> tuple[float, str]:
    """Luminous flux of a light with its unit; of a sun the illuminance of a plane that faces it.

    Raises
    ------
    SceneError    Its quantity is not defined for it.
    """
    quantity, value = light.output.quantity, float(light.output.value)
    is_sun = isinstance(light, SunLight)
    if quantity is Quantity.RADIANT_FLUX:
        quantity = Quantity.ILLUMINANCE if is_sun else Quantity.LUMINOUS_FLUX
        value *= efficacy(light.output.spectrum)
    if isinstance(light, Luminaire):
        return value, "lm"
    if isinstance(light, AreaLight) and light.area <= 0.0:
        raise SceneError("the light has no area, so that it gives nothing")
    reading = read_light(replace(light, output=Output(quantity, value)))
    if reading is None:
        raise SceneError(NO_SIZE)
    return (reading.illuminance, "lx") if is_sun else (reading.flux, "lm")


def find_lights(depsgraph) -> LightList:
    """List the lights of a scene.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph    Evaluated.
    """
    start = time.perf_counter()
    scene, unrendered = depsgraph.scene, find_unrendered(depsgraph.view_layer)
    settings = metres_per_unit(scene), scene.lumenray.efficacy
    images, problems, off = ImageCache(), [], 0
    rows: dict[tuple[int, str], ListedLight] = {}
    met: set[int] = set()
    for instance in depsgraph.object_instances:
        source = instance.object
        if not gives_light(source):
            continue
        met.add(source.original.session_uid)
        if not instance.show_self:
            continue
        if not is_rendered(instance, unrendered):
            off += 1
            continue
        report = ConversionReport()
        given = _convert(instance, settings, report, images)
        if given is not None:
            _add(rows, instance, *given)
        elif problem := _why(report):
            problems.append(problem)
        else:
            off += 1
    ordered = sorted(rows.values(), key=lambda row: (row.unit != "lx", -row.amount, row.name))
    unmet = [
        each.hide_render
        for each in depsgraph.view_layer.objects
        if each.session_uid not in met and gives_light(each)
    ]
    off, hidden = off + sum(unmet), len(unmet) - sum(unmet)
    seconds = time.perf_counter() - start
    return LightList(tuple(ordered), off, hidden, tuple(dict.fromkeys(problems)), seconds)


def gives_light(source) -> bool:
    """Whether an object is a light or an empty that is a luminaire, and no portal."""
    if is_luminaire(source) or is_rayset(source):
        return True
    return source.type == "LIGHT" and not is_portal(source.data)


def _convert(instance, settings, report: ConversionReport, images) -> tuple[float, str] | None:
    """Amount and unit of a light; None: it gives nothing, or the report says why it is not known."""
    source, matrix = instance.object, np.array(instance.matrix_world)
    name = source.name_full
    light = convert_light(source, "", name, matrix, *settings, report, images, is_patient=False)
    try:
        return None if light is None else amount_of(light)
    except SceneError as error:
        report.fault(name, error, LEFT_OUT)
        return None


def _why(report: ConversionReport) -> str:
    """Why a light cannot be computed, or not yet; empty: it gives nothing."""
    for row, _ in report.by_weight:
        if row.remedy in {JOINS, NOTHING_VISIBLE} or row.remedy.startswith(LEFT_OUT):
            return f"{row.datablock}: {row.message}"
    return ""


def _add(rows: dict, instance, amount: float, unit: str) -> None:
    """Add a light to the row of the object that people can select for it."""
    source = instance.object.original
    parent = instance.parent if instance.is_instance else None
    owner = source if parent is None else parent.original
    icon = f"LIGHT_{source.data.type}" if owner.type == "LIGHT" else "OUTLINER_OB_LIGHT"
    key = owner.session_uid, unit
    row = rows.setdefault(key, ListedLight(owner.session_uid, owner.name_full, icon, unit))
    row.amount += amount
    row.count += 1


def name_row(row: ListedLight) -> str:
    """Say which object it is, and how many lights it makes."""
    return printable(f"{row.name} (×{row.count})" if row.count > 1 else row.name)


def describe(held: LightList) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about a list as a whole."""
    lines = [
        ("Total", readout.format_amount(held.flux, "lm")),
        ("Lights", f"{held.count}"),
    ]
    if held.suns:
        lines.append(("Suns", f"{held.suns}, not in the total"))
    if held.off:
        lines.append(("Off or hidden in renders", f"{held.off}, left out"))
    if held.hidden:
        lines.append(("Hidden in the viewport", f"{held.hidden}, not listed"))
    return tuple(lines)


def describe_problems(held: LightList) -> str:
    """Say which lights cannot be computed, the first one with its reason; empty: none."""
    if not held.problems:
        return ""
    others = len(held.problems) - 1
    rest = f" (and {others} more)" if others else ""
    return f"Left out: {held.problems[0]}{rest}"
