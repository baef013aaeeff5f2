"""What users may order: kinds of jobs and their options, as one table that requests are checked by and that is published.

A job is a command of `lumenray`, so that its numbers, its remarks and its exit codes are those of the command line.
"""

import math
import re
from dataclasses import dataclass
from pathlib import Path

from .refusals import bad, conflict

SCENE_FILE = "scene.blend"
"""Of a scene's folder: what was uploaded, as Blender keeps it."""

WEATHER_FILE = "weather.epw"
"""Of a scene's folder."""

MOST_NAMES = 1000
"""Objects that one option names."""

LONGEST_NAME = 255
"""Of an object or a material in Blender. [byte]"""

_SIZE = re.compile(r"([1-9]\d{0,4})x([1-9]\d{0,4})")

_REQUIREMENT = re.compile(r"[a-z][a-z0-9_]*(\.[a-z0-9_]+)+(:[a-z]+)?")


@dataclass(frozen=True)
class Option:
    """One option of a kind of job.

    Parameters
    ----------
    words : str    What it does, for people.
    kind : str
        ``integer``, ``number`` or ``boolean`` of JSON, ``names`` (array of names of objects), ``size``, ``requirement``
        or ``choice``.
    least, most : float    Of a number, both included.
    choices : tuple of str
    flag : str    Option of the command line; empty: its own name.
    """

    words: str
    kind: str
    least: float = 0.0
    most: float = math.inf
    choices: tuple[str, ...] = ()
    flag: str = ""

    def check(self, name: str, value):
        """Return the value; refuse it if it is not what was expected."""
        if not self._accepts(value):
            raise bad(f"option '{name}': expected {self.expected}, found {str(value)[:80]!r}")
        return value

    @property
    def expected(self) -> str:
        """What a value has to be, for people."""
        if self.kind in {"integer", "number"}:
            noun = "a whole number" if self.kind == "integer" else "a number"
            return f"{noun} from {self.least:g} to {self.most:g}"
        if self.kind == "choice":
            return f"one of {', '.join(self.choices)}"
        if self.kind == "names":
            return f"a list of 1 to {MOST_NAMES} names of objects without commas"
        if self.kind == "requirement":
            return "a requirement such as office.writing or office.writing:task"
        if self.kind == "size":
            return "WIDTHxHEIGHT such as 640x400, each from 4 to 16384"
        return "true or false"

    @property
    def schema(self) -> dict:
        """JSON Schema of a value."""
        if self.kind in {"integer", "number"}:
            made = {"type": self.kind, "minimum": self.least, "maximum": self.most}
        elif self.kind == "choice":
            made = {"type": "string", "enum": list(self.choices)}
        elif self.kind == "names":
            names = {"type": "string", "minLength": 1, "pattern": "^[^,]+$"}
            made = {"type": "array", "items": names, "minItems": 1, "maxItems": MOST_NAMES}
        elif self.kind == "requirement":
            made = {"type": "string", "pattern": f"^{_REQUIREMENT.pattern}$", "maxLength": 100}
        elif self.kind == "size":
            made = {"type": "string", "pattern": f"^{_SIZE.pattern}$"}
        else:
            made = {"type": "boolean"}
        return made | {"description": self.words}

    def _accepts(self, value) -> bool:
        if self.kind == "boolean":
            return isinstance(value, bool)
        if self.kind in {"integer", "number"}:
            fits = isinstance(value, int if self.kind == "integer" else int | float)
            return fits and not isinstance(value, bool) and self.least <= value <= self.most
        if self.kind == "choice":
            return isinstance(value, str) and value in self.choices
        if self.kind == "requirement":
            fits = isinstance(value, str) and len(value) <= 100
            return fits and _REQUIREMENT.fullmatch(value) is not None
        if self.kind == "size":
            found = _SIZE.fullmatch(value) if isinstance(value, str) else None
            return found is not None and all(4 <= int(side) <= 16384 for side in found.groups())
        return (
            isinstance(value, list)
            and 1 <= len(value) <= MOST_NAMES
            and all(isinstance(each, str) and is_name(each) and "," not in each for each in value)
        )

    def arguments(self, name: str, value) -> list[str]:
        """Return it for the command line; a value stands behind ``=``, so that none is taken for an option."""
        flag = "--" + (self.flag or name.replace("_", "-"))
        if self.kind == "boolean":
            return [flag] if value else []
        return [f"{flag}={','.join(value) if self.kind == 'names' else value}"]


def is_name(text: str) -> bool:
    """Whether a text may be the name of something in Blender."""
    return 0 < len(text.encode("utf-8", "surrogatepass")) <= LONGEST_NAME and text.isprintable()


_RULE = {
    "samples": Option("Paths, at most", "integer", 1, 1 << 20),
    "error": Option("Relative standard error at which it ends", "number", 1e-5, 1.0),
    "time": Option("Seconds after which it ends", "number", 1.0, 86400.0),
    "seed": Option("Same seed, same result", "integer", 0, 2**31 - 1),
}

_REQUIRE = Option("Requirement by which it is judged, such as office.writing", "requirement")

KINDS = {
    "render": _RULE
    | {
        "size": Option("Of the picture, in pixels", "size"),
        "illuminance": Option("Also of the visible surfaces", "boolean"),
        "false_colour": Option("Also in false colours, with a scale", "boolean"),
        "light_groups": Option(
            "Light kept apart, for a mix", "choice", choices=("none", "groups", "each")
        ),
    },
    "bake": _RULE
    | {
        "objects": Option("Of which lux maps are computed; else those of the scene", "names"),
        "error_lx": Option("Standard error at which it ends, in lux", "number", 1e-3, 1e6),
        "lumels_per_m": Option("Density of the maps", "number", 0.01, 200.0),
        "layers": Option(
            "Light kept apart, for a mix", "choice", choices=("none", "groups", "each")
        ),
        "isolux_lines": Option("Also draw isolux lines", "boolean"),
        "require": _REQUIRE,
    },
    "measure": _RULE | {"require": _REQUIRE},
    "daylight": _RULE
    | {
        "floor": Option("Objects above which sensors stand", "names"),
        "spacing": Option("Between sensors, in metres", "number", 0.05, 100.0),
        "height": Option("Of sensors above the floor, in metres", "number", 0.0, 100.0),
    },
}
"""Options of each kind of job, by their names."""

NEEDED = {"daylight": ("floor",)}
"""Options without which a job cannot be."""


def check_order(kind, options) -> dict:
    """Return the options of a job; refuse what is not understood."""
    if not isinstance(kind, str) or kind not in KINDS:
        raise bad(f"'kind': expected one of {', '.join(KINDS)}, found {str(kind)[:80]!r}")
    if not isinstance(options, dict):
        raise bad("'options': expected an object")
    known = KINDS[kind]
    for name in options:
        if name not in known:
            raise bad(
                f"a job of kind {kind} has no option '{name[:80]}'; it has {', '.join(known)}"
            )
    for name in NEEDED.get(kind, ()):
        if name not in options:
            raise bad(f"a job of kind {kind} needs the option '{name}'")
    return {name: known[name].check(name, value) for name, value in options.items()}


def command_of(kind: str, options: dict, scene: Path, files: Path, target: Path) -> list[str]:
    """Return the arguments of the command that does a job.

    Parameters
    ----------
    scene : Path    The .blend file, edits and all.
    files : Path    Folder with what else was uploaded.
    target : Path    Empty folder for the results.
    """
    output = {"render": "picture.exr", "measure": "readings.json"}.get(kind)
    made = [kind, str(scene), f"--output={target if output is None else target / output}"]
    for name, value in options.items():
        made += KINDS[kind][name].arguments(name, value)
    if kind == "bake":
        # Each page a texture of its own: who walks through the room is told the lumels themselves.
        made += [
            f"--gltf={target / 'lux.glb'}",
            "--most-textures=1000",
            "--texture-size=8192",
            "--arrays",
            "--force",
        ]
    if kind == "measure":
        made.append(f"--plans={target}")
    if kind == "daylight":
        weather = files / WEATHER_FILE
        if not weather.is_file():
            raise conflict("daylight needs a weather file: upload one for this scene first")
        made += [f"--weather={weather}", "--force"]
    return made


def schema_of(kind: str) -> dict:
    """JSON Schema of the options of a kind of job."""
    made = {
        "type": "object",
        "additionalProperties": False,
        "properties": {name: option.schema for name, option in KINDS[kind].items()},
    }
    return made | ({"required": list(NEEDED[kind])} if kind in NEEDED else {})
