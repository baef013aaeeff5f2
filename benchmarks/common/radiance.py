"""Radiance's programs as they come with the package `pyradiance`, and direct illuminance by them."""

import os
import subprocess
import tempfile
from dataclasses import dataclass
from importlib import metadata, util
from pathlib import Path

import numpy as np

from ...engine.errors import LumenrayError

LUMENS_PER_WATT = 179.0
"""Radiance's own factor between its white radiance and luminance. [lm/W]"""

POINT_RADIUS = 0.0005
"""Radius of the sphere that stands for a point, the least that ies2rad takes. [m]"""

PATIENCE = 120.0
"""Longest that one of the programs may take. [s]"""

DIRECT_ONLY = ("-ab", "0", "-dj", "0", "-dt", "0", "-dc", "1", "-dr", "0", "-lw", "0")
"""Of rtrace: no indirect light, every source looked at exactly once and at its middle."""


@dataclass(frozen=True)
class Answer:
    """What Radiance says about a file.

    Parameters
    ----------
    illuminance : (n,) float64 array    [lx]
    shape : str    Of the source as Radiance builds it: ``sphere``, ``rectangle or box`` or ``disk or cylinder``.
    emits_sideways : bool    Whether all of a box, cylinder or sphere shines, not only its top or bottom.
    """

    illuminance: np.ndarray
    shape: str
    emits_sideways: bool


def is_installed() -> bool:
    """Whether the package `pyradiance` is there."""
    return util.find_spec("pyradiance") is not None


def version() -> str:
    """Version of `pyradiance`."""
    return metadata.version("pyradiance")


def measure(
    path, rotation, place, positions, normals, is_point=True, subdivision: float = 0.02
) -> Answer:
    """Direct illuminance of planes at points, from one luminaire in empty space.

    Parameters
    ----------
    path : Path    LM-63 file.
    rotation : (3, 3) array    Turns ies2rad's axes (0 degrees along x, light towards -z) into the world's.
    place : (3,) array    Of the luminaire. [m]
    positions, normals : (n, 3) array    [m]
    is_point : bool    A tiny sphere instead of the file's luminous opening.
    subdivision : float    Size of the parts of an opening over their distance (rtrace -ds).

    Raises
    ------
    LumenrayError    One of Radiance's programs refuses, with what it says.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "luminaire.ies").write_bytes(Path(path).read_bytes())
        # A lamp of the type "default" is white, whatever the file's keywords say.
        options = ["-t", "default", "-o", "luminaire"]
        if is_point:
            options += ["-i", str(POINT_RADIUS)]
        run_program(folder, "ies2rad", *options, "luminaire.ies")
        source = (folder / "luminaire.rad").read_text(encoding="utf-8", errors="replace")
        move = f"!xform {_turns(rotation)} -t {_numbers(place)} luminaire.rad\n"
        (folder / "scene.rad").write_text(move, encoding="utf-8")
        (folder / "scene.oct").write_bytes(run_program(folder, "oconv", "scene.rad"))
        rays = "\n".join(_numbers([*p, *n]) for p, n in zip(positions, normals, strict=True))
        fineness = "0" if is_point else str(subdivision)
        answer = run_program(
            folder, "rtrace", "-h", "-w-", "-I", *DIRECT_ONLY, "-ds", fineness, "scene.oct",
            sent=rays + "\n",
        )  # fmt: skip
    values = np.array(answer.split(), dtype=np.float64).reshape(-1, 3)
    if len(values) != len(positions):
        raise LumenrayError(f"{path}: rtrace answered {len(values)} of {len(positions)} points")
    is_flat = "flatcorr" in source
    return Answer(LUMENS_PER_WATT * values[:, 1], _shape(source), not is_flat)


def _shape(source: str) -> str:
    if " polygon " in source:
        return "rectangle or box"
    return "disk or cylinder" if " ring " in source else "sphere"


def _numbers(values) -> str:
    return " ".join(f"{value:.9g}" for value in values)


def _turns(rotation) -> str:
    """Options of xform that turn by a matrix: about x, then y, then z."""
    r = np.asarray(rotation, dtype=np.float64)
    about_y = np.arcsin(np.clip(-r[2, 0], -1.0, 1.0))
    about_x, about_z = np.arctan2(r[2, 1], r[2, 2]), np.arctan2(r[1, 0], r[0, 0])
    x, y, z = (f"{np.rad2deg(angle):.12g}" for angle in (about_x, about_y, about_z))
    return f"-rx {x} -ry {y} -rz {z}"


def run_program(
    folder: Path, program: str, *options: str, sent: str | bytes = "", patience: float = PATIENCE
) -> bytes:
    """Run one of Radiance's programs in a folder.

    Parameters
    ----------
    folder : Path
    program : str    Its name.
    options : str
    sent : str or bytes    Its standard input.
    patience : float    Longest that it may take. [s]

    Returns
    -------
    bytes    Its standard output.

    Raises
    ------
    LumenrayError    It refuses, with what it says, takes too long or cannot be run.
    """
    import pyradiance

    home = Path(pyradiance.__file__).parent
    # Some of them start others.
    paths = os.pathsep.join([str(pyradiance.BINPATH), os.environ.get("PATH", "")])
    surroundings = os.environ | {
        "RAYPATH": os.pathsep.join([".", str(home / "lib")]),
        "PATH": paths,
    }
    try:
        made = subprocess.run(
            [pyradiance.BINPATH / program, *options],
            cwd=folder,
            env=surroundings,
            input=sent.encode() if isinstance(sent, str) else sent,
            capture_output=True,
            timeout=patience,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise LumenrayError(f"Radiance's {program} takes longer than {patience:g} s") from None
    except OSError as error:
        raise LumenrayError(f"Radiance's {program} cannot be run ({error.strerror})") from None
    if made.returncode:
        said = made.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
        raise LumenrayError(f"Radiance's {program}: {'; '.join(said)}")
    return made.stdout
