"""Radiance's two-phase chain: `rfluxmtx` for coefficients, `gendaymtx` for the skies, `dctimestep` for their product.

In the plain chain the sun is spread over the patches next to it. With its exact sun, what the patches gave straight is taken
away, and every hour's sun is asked for itself, as in the last step of the five-phase method: `gendaymtx` writes a source for
each hour, `rcontrib` tells what each of them gives straight to each sensor.

Times are those of the processors, of all programs that were started, so that what else the machine does counts little.
Radiance takes no seed; another number of divisions makes other random choices.
"""

import os
import re
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.sky.weather import Weather
from ..common.radiance import LUMENS_PER_WATT, run_program
from .room import Room, radiance_text
from .weather_year import write_wea

PATIENCE = 3600.0
"""Longest that a program may take. [s]"""

STRETCH = 1.1
"""Divisions of a second run over those of the first, so that it makes other random choices."""

LUMINOUS = np.array([0.265, 0.670, 0.065])
"""Weights of Radiance's three channels in a luminance."""

SKY = """#@rfluxmtx h=u u=+Y
void glow ground_glow
0
0
4 1 1 1 0
ground_glow source ground
0
0
4 0 0 -1 180
#@rfluxmtx h=r{factor} u=+Y
void glow sky_glow
0
0
4 1 1 1 0
sky_glow source sky
0
0
4 0 0 1 180
"""

STRAIGHT = ("-ab", "0", "-dj", "0", "-dt", "0", "-dc", "1", "-dr", "0", "-lw", "0")
"""Of rcontrib: each sun looked at exactly once."""

MINUTES = 1440
"""Of a day, by which `gendaymtx` counts the names of its suns."""


@dataclass(frozen=True)
class Settings:
    """How much Radiance does.

    Parameters
    ----------
    divisions : int    Rays from each sensor (-ad).
    bounces : int    (-ab)
    weight : float    Rays of less weight are ended by chance (-lw).
    factor : int    Into so many parts squared Tregenza's patches are divided (MF): 1, 2, 4 or 6.
    has_exact_sun : bool    Whether the sun is asked for itself.
    """

    divisions: int
    bounces: int = 6
    weight: float = 1e-4
    factor: int = 1
    has_exact_sun: bool = False

    @property
    def words(self) -> str:
        """In short."""
        sun = ", exact sun" if self.has_exact_sun else ""
        return f"-ad {self.divisions} -ab {self.bounces} -lw {self.weight:g}, MF {self.factor}{sun}"

    def again(self) -> "Settings":
        """Return what makes other random choices with almost the same work."""
        return replace(self, divisions=round(self.divisions * STRETCH))


@dataclass(frozen=True, eq=False)
class TwoPhase:
    """A year by the chain.

    Parameters
    ----------
    illuminance : (sensors, hours) array    0 where Radiance has no sun: it leaves out hours whose middle is dark. [lx]
    seconds : dict    Time of the processors by program. [s]
    """

    illuminance: np.ndarray
    seconds: dict[str, float]

    @property
    def total(self) -> float:
        """[s]"""
        return sum(self.seconds.values())


def run_two_phase(room: Room, weather: Weather, settings: Settings) -> TwoPhase:
    """Compute a year.

    Parameters
    ----------
    room : Room
    weather : Weather    Of whole hours.
    settings : Settings

    Raises
    ------
    LumenrayError    Radiance is not installed, or one of its programs refuses.
    """
    with tempfile.TemporaryDirectory() as name:
        chain = _Chain(Path(name), room, weather)
        columns = chain.skies("sky.smx", settings.factor, "-D", "suns.rad", "-M", "suns.mod")
        chain.coefficients("dc.mtx", settings)
        found = chain.product("dc.mtx", "sky.smx")
        if settings.has_exact_sun:
            chain.skies("sun.smx", settings.factor, "-d")
            chain.coefficients("dc1.mtx", replace(settings, bounces=1))
            found += chain.suns() - chain.product("dc1.mtx", "sun.smx")
        made = np.zeros((len(room.positions), len(weather)))
        made[:, columns] = found
        return TwoPhase(made, chain.seconds)


def run_suns(room: Room, weather: Weather) -> TwoPhase:
    """Return the illuminance that the sun gives straight, as its annual exposure is counted by."""
    with tempfile.TemporaryDirectory() as name:
        chain = _Chain(Path(name), room, weather)
        columns = chain.skies("sky.smx", 1, "-D", "suns.rad", "-M", "suns.mod")
        made = np.zeros((len(room.positions), len(weather)))
        made[:, columns] = chain.suns()
        return TwoPhase(made, chain.seconds)


class _Chain:
    """A folder with the files of one run, and the time of each program."""

    def __init__(self, folder: Path, room: Room, weather: Weather):
        self.folder, self.weather = folder, weather
        self.sensors = len(room.positions)
        self.seconds: dict[str, float] = {}
        (folder / "room.rad").write_text(radiance_text(room), encoding="ascii")
        rays = np.concatenate([room.positions, room.normals], axis=1)
        self.rays = rays.astype("<f4").tobytes()
        write_wea(weather, folder / "weather.wea")
        (folder / "room.oct").write_bytes(self._run("oconv", "room.rad"))

    def skies(self, file: str, factor: int, *more: str) -> np.ndarray:
        """Write the matrix of the hours in which the sun is up, without a ground; return which of the year's they are."""
        options = ("-u", "-m", str(factor), "-g", "0", "0", "0", "-of", *more)
        (self.folder / file).write_bytes(self._run("gendaymtx", *options, "weather.wea"))
        if "-D" not in more:
            return np.zeros(0, int)
        names = (self.folder / "suns.mod").read_text(encoding="ascii").split()
        minutes = np.array([int(name.removeprefix("solar")) for name in names])
        starts = np.concatenate([[0], np.cumsum(DAYS)])
        days = starts[self.weather.month - 1] + self.weather.day - 1
        own = np.rint(MINUTES * days + 60.0 * self.weather.hour).astype(int)
        columns = np.flatnonzero(np.isin(own, minutes))
        if len(columns) != len(minutes) or len(columns) != _header(self.folder / file)["NCOLS"]:
            raise LumenrayError("gendaymtx names other suns than the weather has hours")
        return columns

    def coefficients(self, file: str, settings: Settings) -> None:
        """Write the matrix of daylight coefficients."""
        (self.folder / "patches.rad").write_text(
            SKY.format(factor=settings.factor), encoding="ascii"
        )
        made = self._run(
            "rfluxmtx", "-I+", "-fff", "-n", "1", "-y", str(self.sensors), "-ab", str(settings.bounces),
            "-ad", str(settings.divisions), "-lw", f"{settings.weight:g}", "-", "patches.rad", "-i", "room.oct",
            sent=self.rays,
        )  # fmt: skip
        (self.folder / file).write_bytes(made)

    def product(self, coefficients: str, skies: str) -> np.ndarray:
        """Illuminances (sensors, hours). [lx]"""
        said = self._run("dctimestep", "-of", coefficients, skies)
        return _read(said, self.sensors)

    def suns(self) -> np.ndarray:
        """What each hour's sun gives straight (sensors, hours). [lx]"""
        (self.folder / "suns.oct").write_bytes(
            self._run("oconv", "-f", "-i", "room.oct", "suns.rad")
        )
        said = self._run(
            "rcontrib", "-I+", "-V+", "-fff", "-n", "1", "-y", str(self.sensors), *STRAIGHT,
            "-M", "suns.mod", "suns.oct", sent=self.rays,
        )  # fmt: skip
        return _read(said, self.sensors)

    def _run(self, program: str, *options: str, sent: bytes = b"") -> bytes:
        start = _children()
        made = run_program(self.folder, program, *options, sent=sent, patience=PATIENCE)
        self.seconds[program] = self.seconds.get(program, 0.0) + _children() - start
        return made


DAYS = (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30)
"""Of the months but the last, as `gendaymtx` counts them."""


def _children() -> float:
    """Time of the processors that programs took which we waited for. [s]"""
    times = os.times()
    return times.children_user + times.children_system


def _header(path: Path) -> dict[str, int]:
    with path.open("rb") as file:
        head = file.read(4096)
    return _numbers(head)


def _numbers(head: bytes) -> dict[str, int]:
    found = re.findall(rb"^(NROWS|NCOLS|NCOMP)=\s*(\d+)", head, re.MULTILINE)
    return {name.decode(): int(value) for name, value in found}


def _read(data: bytes, rows: int) -> np.ndarray:
    """Luminous values of a matrix of floats. (rows, columns)"""
    head, _, body = data.partition(b"\n\n")
    numbers = _numbers(head + b"\n")
    values = np.frombuffer(body, dtype="<f4")
    columns = numbers.get("NCOLS", 1)
    if len(values) != rows * columns * 3:
        raise LumenrayError("a matrix of Radiance has another size than was asked for")
    return LUMENS_PER_WATT * values.reshape(rows, columns, 3).astype(np.float64) @ LUMINOUS
