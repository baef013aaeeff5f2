"""What a report tells, as plain data; every number stands here once, and all files are written from it."""

from dataclasses import dataclass, field

import numpy as np
from PIL import Image

from ..accuracy.readings import Figures
from ..analysis.sheet import Sheet
from ..analysis.ugr_table import UgrTable
from ..judgement.assessment import Assessment
from ..judgement.schedule import Fitting, Schedule
from ..judgement.verdict import State, Verdict, join_states, overall


@dataclass(frozen=True, eq=False)
class Grid:
    """Sensors in rows and columns.

    Parameters
    ----------
    x, y : (columns,), (rows,) array    Places in their plane, ascending. [m]
    values, errors : (rows, columns) array    NaN where no sensor stands.
    """

    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    errors: np.ndarray


@dataclass(frozen=True, eq=False)
class SensorArea:
    """What sensors that belong together tell in a lighting scene.

    Parameters
    ----------
    name, quantity, unit : str
    figures : Figures
    positions, normals : (n, 3) array    [m]
    values, errors : (n,) array    Readings and their standard errors, in ``unit``.
    samples, seed : int
    method, scene_hash : str
    grid : Grid or None    Of a grid with more than one row and column.
    plan : Sheet or None    Of the grid.
    assessment : Assessment or None    None: nothing is required of them, or `problem` says why it is not judged.
    problem : str    Why they are not judged although something is required.
    changed : str    What has changed in the scene since they were measured; empty: nothing.
    simplified : float    Largest relative error by what was not modelled; it is in the errors. [-]
    observers : tuple of Verdict    On the UGR of each, where the sensors are observers' eyes.
    light : tuple of (str, str)    Labels and values of the light's action on the eye and of its colour, where it is known.
    """

    name: str
    quantity: str
    unit: str
    figures: Figures
    positions: np.ndarray
    normals: np.ndarray
    values: np.ndarray
    errors: np.ndarray
    samples: int
    seed: int
    method: str
    scene_hash: str
    grid: Grid | None = None
    plan: Sheet | None = None
    assessment: Assessment | None = None
    problem: str = ""
    changed: str = ""
    observers: tuple[Verdict, ...] = ()
    simplified: float = 0.0
    light: tuple[tuple[str, str], ...] = ()

    @property
    def is_rating(self) -> bool:
        """Whether the values are ratings of glare, NaN where nothing dazzles."""
        return self.unit == "UGR"

    @property
    def state(self) -> State | None:
        """Of what is required of them; None: they are not judged."""
        if self.assessment is not None:
            return self.assessment.state
        return overall(self.observers) if self.observers else None


@dataclass(frozen=True, eq=False)
class Shown:
    """A picture of the report: pixels, or a drawing, with what it shows."""

    caption: str
    picture: Image.Image | Sheet


@dataclass(frozen=True, eq=False)
class LightingScene:
    """All sensors with the light groups at certain levels.

    Parameters
    ----------
    name : str    Empty: the report has no scenes of its own.
    levels : str    How the groups shine, in words.
    areas : tuple of SensorArea
    pictures : tuple of Shown
    """

    name: str
    levels: str
    areas: tuple[SensorArea, ...]
    pictures: tuple[Shown, ...] = ()

    @property
    def state(self) -> State:
        """Of all that is required."""
        states = [area.state for area in self.areas if area.state is not None]
        return join_states(states)


@dataclass(frozen=True, eq=False)
class LuminaireSheet:
    """What a report tells of a kind of luminaire.

    Parameters
    ----------
    fitting : Fitting
    facts : tuple of (str, str)    Labels and values.
    diagram : Image or None    Polar diagram.
    ugr : UgrTable or None    By CIE 190.
    problem : str    Why there is no table of glare.
    """

    fitting: Fitting
    facts: tuple[tuple[str, str], ...]
    diagram: Image.Image | None = None
    ugr: UgrTable | None = None
    problem: str = ""


@dataclass(frozen=True)
class OtherLight:
    """Lights without a photometric file. ``amount``: of all of them together, in ``unit`` (lm, of suns lx)."""

    name: str
    count: int
    amount: float
    unit: str


@dataclass(frozen=True)
class Floor:
    """The floor that installed power is stated for. ``illuminance``: mean over it in the first lighting scene, if known."""

    name: str
    area: float
    illuminance: float | None = None


@dataclass(frozen=True, eq=False)
class Report:
    """A report.

    Parameters
    ----------
    title, client, author, date, file : str    Of the cover; what is empty is left out.
    version, transport : str    Of the engine; how spectra were treated.
    scenes : tuple of LightingScene    At least one.
    schedule : Schedule
    luminaires : tuple of LuminaireSheet
    others : tuple of OtherLight
    floor : Floor or None
    settings : tuple of (str, str)    Labels and values.
    remarks : tuple of str    What was left out or assumed, the worst first.
    maintenance : float    Factor on illuminances in verdicts. [-]
    """

    title: str
    file: str
    version: str
    transport: str
    scenes: tuple[LightingScene, ...]
    schedule: Schedule = field(default_factory=lambda: Schedule(()))
    luminaires: tuple[LuminaireSheet, ...] = ()
    others: tuple[OtherLight, ...] = ()
    floor: Floor | None = None
    settings: tuple[tuple[str, str], ...] = ()
    remarks: tuple[str, ...] = ()
    maintenance: float = 1.0
    client: str = ""
    author: str = ""
    date: str = ""
