"""Options that several commands have, and readers of their values."""

import argparse
import math
from pathlib import Path

from ..engine.scene.sensor import SensorKind
from .modelling import add_modelling
from .output import complain


class Parser(argparse.ArgumentParser):
    """Parser of a command and of those below it; its texts keep their lines, and a refusal is one."""

    def __init__(self, **settings):
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **settings)

    def error(self, message):
        """Refuse what cannot be understood, with the exit code 2."""
        complain(f"{message}; '{self.prog} --help' tells more")
        self.exit(2)


def add_group(commands, name: str, words: str, epilog: str, tasks) -> None:
    """Describe a group of commands to argparse; ``tasks`` are the modules of its commands."""
    group = commands.add_parser(name, help=words, epilog=epilog)
    below = group.add_subparsers(dest="task", required=True, metavar="TASK")
    for task in tasks:
        task.add_command(below)


# ---- groups of options ----


def add_scene(parser) -> None:
    """Let a command be about a .blend file."""
    parser.add_argument("file", type=Path, metavar="F.blend", help="Blender file")
    parser.add_argument(
        "--seed",
        type=whole(0, 2**31 - 1),
        metavar="N",
        help="same seed, same result (default: the scene's)",
    )
    parser.add_argument(
        "--transport",
        choices=("auto", "mono", "spectral"),
        help="photometric (mono) or spectral computation (default: the scene's)",
    )
    add_modelling(parser)


def add_sensors(parser, is_required: bool = True) -> None:
    """Let a command be about sensors from a list; where that is not required, about those of the file if none is given."""
    others = "" if is_required else " (default: the sensors that stand in the file)"
    parser.add_argument(
        "--sensors",
        required=is_required,
        type=Path,
        metavar="IN.csv",
        help=f"x,y,z,nx,ny,nz in metres; the normal is where the sensor faces{others}",
    )
    parser.add_argument(
        "--kind",
        choices=[kind.value for kind in SensorKind],
        default=SensorKind.PLANAR.value if is_required else None,
        help="which illuminance; spherical and cylindrical (vertical) ones have no normal (default: planar)",
    )


def add_witness(parser) -> None:
    """Let a command leave the second witness out."""
    parser.add_argument(
        "--witness",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="compare with a few light paths from the lights, so that errors cover what they find (default: yes)",
    )


def add_rule(parser, per: str):
    """Let a command say when it ends; return the group of these options."""
    rule = parser.add_argument_group("when to stop (default: as the scene says)")
    rule.add_argument("--samples", type=whole(), metavar="N", help=f"paths per {per}")
    rule.add_argument(
        "--error", type=share(), metavar="E", help="relative standard error, such as 1%% or 0.01"
    )
    rule.add_argument("--time", type=real(), metavar="S", help="seconds")
    return rule


def seed_of(options, settings) -> int:
    """Return the seed that was asked for, else the scene's."""
    return settings.seed if options.seed is None else options.seed


def transport_of(options, settings) -> str:
    """Return the transport that was asked for, else the scene's."""
    return options.transport or settings.transport.lower()


def rule_of(options, default):
    """Return the stopping rule that was asked for, else what ``default``, a callable, gives."""
    from ..engine.accuracy.stopping import StopRule

    rule = {
        "samples": options.samples,
        "error": options.error,
        "seconds": options.time,
        "absolute": getattr(options, "error_lx", None),
        "each": getattr(options, "each", None),
    }
    return default() if all(end is None for end in rule.values()) else StopRule(**rule)


# ---- readers of values ----

POSITIVE = math.ulp(0.0)
"""Smallest number above 0."""


def whole(least: int = 1, most: float = math.inf):
    """Return a reader of whole numbers between two, both included."""
    return _bounded(int, f"a whole number {_range(least, most)}", least, most)


def real(least: float = POSITIVE, most: float = math.inf):
    """Return a reader of numbers between two, both included; of those above 0 if nothing is said."""
    return _bounded(float, f"a number {_range(least, most)}", least, most)


def share(least: float = POSITIVE, most: float = 1.0):
    """Return a reader of shares between two, both included: 2% and 0.02 are the same."""

    def read(text: str) -> float:
        number = text.strip()
        return 0.01 * float(number[:-1]) if number.endswith("%") else float(number)

    expected = f"a share {_range(least, most, 100.0)} %, such as 2% or 0.02"
    return _bounded(read, expected, least, most)


def _range(least: float, most: float, scale: float = 1.0) -> str:
    low = "above 0" if least == POSITIVE else f"from {scale * least:g}"
    if most == math.inf:
        return low if least == POSITIVE else f"{low} on"
    return f"{low} to {scale * most:g}"


def _bounded(read, expected: str, least: float, most: float):
    def read_bounded(text: str):
        try:
            number = read(text)
        except ValueError:
            number = math.nan
        if not least <= number <= most or number == math.inf:
            raise argparse.ArgumentTypeError(f"expected {expected}, found '{text}'")
        return number

    return read_bounded


def size(least: int, most: int):
    """Return a reader of sizes such as 640x400."""
    side = whole(least, most)

    def read(text: str) -> tuple[int, int]:
        width, _, height = text.lower().partition("x")
        try:
            return side(width), side(height)
        except argparse.ArgumentTypeError:
            words = f"expected WIDTHxHEIGHT such as 640x400, each {_range(least, most)}"
            raise argparse.ArgumentTypeError(f"{words}, found '{text}'") from None

    return read


def stretch(text: str) -> dict:
    """Read months and hours such as months=4-9,hours=9-17 or hours=22-6: what `ClockRange` is made of."""
    readers, made = {"months": whole(1, 12), "hours": real(0.0, 24.0)}, {}
    for part in text.split(","):
        name, _, values = part.strip().partition("=")
        first, _, last = values.partition("-")
        if name not in readers or not first:
            raise argparse.ArgumentTypeError(
                f"expected months or hours such as months=4-9,hours=9-17, found '{text}'"
            )
        made[name] = readers[name](first), readers[name](last or first)
    return made


def level(text: str) -> tuple[str, float]:
    """Read the level of a light group such as Ceiling=0.5, Ceiling=50% or Ceiling=off: its name and its factor."""
    name, _, value = text.rpartition("=")
    states = {"off": 0.0, "on": 1.0}
    try:
        factor = states.get(value.strip().lower())
        factor = share(0.0, math.inf)(value) if factor is None else factor
    except argparse.ArgumentTypeError:
        name = ""
    if not name.strip():
        raise argparse.ArgumentTypeError(
            f"expected NAME=FACTOR such as Ceiling=0.5, Ceiling=50% or Ceiling=off, found '{text}'"
        )
    return name.strip(), factor


def words(text: str) -> tuple[str, ...]:
    """Read words with commas between them."""
    return tuple(word.strip() for word in text.split(",") if word.strip())


def numbers(text: str) -> tuple[int, ...]:
    """Read whole numbers from 1 on with commas between them."""
    return tuple(map(whole(), text.split(",")))
