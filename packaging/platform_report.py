"""Check every zip of a folder, and tell in one table what was run and what was only checked by reading."""

import argparse
import sys
import tomllib
from pathlib import Path

from built_wheels import LEFT_OUT
from checks import Inspection, as_text, check_zip
from project import ROOT, BuildError, read_project
from targets import ANY_PYTHON, PYTHONS

MEASURED = ROOT / "packaging" / "measured.toml"
"""What was run and how long it took, by the target's name, and what a set-up from nothing takes."""

BLENDERS = {
    "cp311": "4.2 to 5.0",
    "cp313": "5.1, 5.2",
    "cp314": "on Python 3.14",
    ANY_PYTHON: "4.2 and newer",
}
"""Versions of Blender that have a Python."""

HEADS = (
    "zip", "Blender", "MB", "files", "native libraries", "asks for at least", "run", "enable [s]", "first picture [s]",
)  # fmt: skip


PAGE = """# Platforms

Made by `python packaging/platform_report.py -o docs/platforms.md` from the zips in `dist/`, which `make zips-check` makes
there, in continuous integration too. Every zip was checked by reading it: its names and its manifest; that the
tags of every wheel fit; that each native library finds what it asks for in the zip, in Blender with its Python, or
in the system; how new a system it wants. What was also *run* is told in the table. The rest was **not** run, for want
of such a machine.

{table}

Files are those that Blender writes when it installs the zip.

## What is missing where

{missing}
- Windows: the Visual C++ runtime (`msvcp140.dll`, `vcruntime140.dll`, `vcruntime140_1.dll`) is in no zip. Blender has
  one in `blender.crt`, but its `python.exe`, which runs the engine, is not known to look there, and that of Blender 4.2
  to 5.0 is too old (see below). So the runtime has to be part of the system, and 14.40 or newer: Microsoft's current
  *Visual C++ Redistributable (x64)*, which most computers have.
- Linux: Dr.Jit asks for `libatomic.so.1`, which a bare system may lack (Debian: `libatomic1`).

## What asks for a newer system than Blender 4.2

{newer}

## The Start panel before and after its steps

As Blender starts, with the room, after its bake, and when all is done (`tests/real_blender/start_panel.sh`).

![Blender 4.3](pictures/start_panel_4.3.png)

![Blender 5.2](pictures/start_panel_5.2.png)

## From nothing

{from_nothing}"""


def inspect_folder(folder: Path) -> list[Inspection]:
    """Check all zips of a folder."""
    version = read_project().version
    found = [check_zip(path, version) for path in sorted(folder.glob("lumenray*.zip"))]
    if not found:
        raise BuildError(f"{folder} has no zip of ours: run packaging/build_extension.py first")
    return found


def read_measured() -> dict:
    """Read what was measured."""
    return tomllib.loads(MEASURED.read_text(encoding="utf-8"))


def rows_of(found: list[Inspection]) -> list[tuple]:
    """Return the table's rows as texts, below `HEADS`."""
    measured = read_measured()
    rows = []
    for each in found:
        known = measured.get(each.pack + str(each.target).removesuffix(f"-{ANY_PYTHON}"), {})
        rows.append(
            (
                each.name,
                BLENDERS[each.target.python],
                f"{each.size / 1e6:.0f}",
                str(each.files),
                str(len(each.libraries)),
                ", ".join(
                    f"{what} {as_text(version)}" for what, version in sorted(each.needs.items())
                ),
                known.get("run", "only checked by reading"),
                str(known.get("enable", "–")),
                str(known.get("picture", "–")),
            )
        )
    return rows


def compose_text(found: list[Inspection]) -> str:
    """Return the table for a terminal."""
    rows = [HEADS, *rows_of(found)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEADS))]
    lines = [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True))
        for row in rows
    ]
    return "\n".join(
        [
            *(line.rstrip() for line in lines),
            *(f"{each.name}: {text}" for each in found for text in each.newer),
        ]
    )


def compose_markdown(found: list[Inspection]) -> str:
    """Return the page ``docs/platforms.md``."""
    lines = [
        f"| {' | '.join(HEADS)} |",
        f"|{'---|' * len(HEADS)}",
        *(f"| {' | '.join(row)} |" for row in rows_of(found)),
    ]
    missing = [
        f"- {target.platform} with Python {PYTHONS[target.python]}: {name} {why}."
        for (target, name), why in LEFT_OUT.items()
    ]
    newer = [f"- {each.name}: {text}." for each in found for text in each.newer]
    return PAGE.format(
        table="\n".join(lines),
        missing="\n".join(missing),
        newer="\n".join(newer or ["Nothing does."]),
        from_nothing=read_measured()["from_nothing"],
    )


def main(arguments=None) -> int:
    """Check the zips and write the report; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "folder", nargs="?", type=Path, default=ROOT / "dist", help="folder of the zips"
    )
    parser.add_argument("-o", "--output", type=Path, help="page to write, as Markdown")
    options = parser.parse_args(arguments)
    try:
        found = inspect_folder(options.folder)
    except BuildError as error:
        print(f"platform_report: {error}", file=sys.stderr)
        return 1
    print(compose_text(found))
    if options.output:
        options.output.write_text(compose_markdown(found), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
