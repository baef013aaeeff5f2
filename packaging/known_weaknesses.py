"""The command that looks up pinned versions among known weaknesses: records in OSV's form, which lie in a folder or a zip.

Nothing is asked of a network. OSV (osv.dev) publishes all records of an ecosystem as one zip, ``all.zip``; those of PyPI and
of npm count here. What a record says of a version is found as the OSV schema 1.6 lays down ("Evaluation").

    python packaging/known_weaknesses.py FOLDER_OR_ZIP...
"""

import argparse
import json
import re
import sys
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from packaging.utils import canonicalize_name, parse_sdist_filename, parse_wheel_filename
from packaging.version import InvalidVersion, Version
from project import ROOT, BuildError

PYPI, NPM = "PyPI", "npm"

REQUIREMENTS = ROOT / "requirements.lock"
WHEELS = ROOT / "packaging" / "wheels.lock"
PAGE = ROOT / "tests" / "viewer" / "package-lock.json"

LARGEST = 16 << 20
"""Of a record. [byte]"""

OLD = 30
"""Data that are older are told to be so. [day]"""


@dataclass(frozen=True, order=True)
class Pin:
    """A version that the project states exactly.

    Parameters
    ----------
    ecosystem : str    ``PyPI`` or ``npm``.
    name : str    As the ecosystem compares names.
    version : str
    """

    ecosystem: str
    name: str
    version: str

    def __str__(self):
        return f"{self.name} {self.version}"


@dataclass(frozen=True)
class Weakness:
    """What a record says of a pin.

    Parameters
    ----------
    pin : Pin
    names : tuple of str    Of the record: its own, and those that others have given to the same weakness.
    summary : str
    fixed : tuple of str    Versions without it.
    doubt : str    Why it cannot be told whether the pin has it; empty where it has.
    """

    pin: Pin
    names: tuple[str, ...]
    summary: str
    fixed: tuple[str, ...]
    doubt: str = ""

    def __str__(self):
        remedy = (
            f"; fixed in {', '.join(self.fixed)}"
            if self.fixed
            else "; no version without it is known"
        )
        doubt = f" (cannot be decided: {self.doubt})" if self.doubt else ""
        return f"{self.pin}: {', '.join(self.names)}: {self.summary}{remedy}{doubt}"


@dataclass
class Findings:
    """What was found, and in how much.

    Parameters
    ----------
    records : int    That were read.
    newest : str    When the newest of them was changed, in RFC 3339.
    weaknesses : list of Weakness
    """

    records: int = 0
    newest: str = ""
    weaknesses: list[Weakness] = field(default_factory=list)


def read_pins() -> set[Pin]:
    """Return all versions that the project pins: of the environment, of the wheels that it ships and of the page.

    Raises
    ------
    BuildError    A lock file cannot be read.
    """
    pins = set()
    for number, line in enumerate(REQUIREMENTS.read_text(encoding="utf-8").splitlines(), 1):
        text = line.partition("#")[0].strip()
        if text:
            found = re.fullmatch(r"([A-Za-z0-9._-]+)==(\S+)", text)
            if found is None:
                raise BuildError(
                    f"{REQUIREMENTS}, line {number}: expected NAME==VERSION, found '{text}'"
                )
            pins.add(Pin(PYPI, canonicalize_name(found[1]), found[2]))
    for line in WHEELS.read_text(encoding="utf-8").splitlines():
        file = line.split()[1]
        read = parse_sdist_filename if file.endswith(".tar.gz") else parse_wheel_filename
        name, version, *_ = read(file)
        pins.add(Pin(PYPI, name, str(version)))
    for place, each in json.loads(PAGE.read_text(encoding="utf-8"))["packages"].items():
        if place:
            pins.add(Pin(NPM, place.rpartition("node_modules/")[2], each["version"]))
    return pins


def find_weaknesses(pins, records) -> Findings:
    """Look pins up.

    Parameters
    ----------
    pins : set of Pin
    records : iterable of (str, dict)    Where each is from, and the record.

    Raises
    ------
    BuildError    What is there is no record of OSV's form.
    """
    known: dict[tuple[str, str], list[Pin]] = {}
    for pin in sorted(pins):
        known.setdefault((pin.ecosystem, pin.name), []).append(pin)
    findings = Findings()
    for place, record in records:
        try:
            findings.records += 1
            findings.newest = max(findings.newest, record["modified"])
            if "withdrawn" not in record:
                findings.weaknesses += _judge(record, known)
        except (KeyError, TypeError, AttributeError) as error:
            raise BuildError(f"{place}: is no record of OSV's form ({error!r})") from None
    return findings


def read_records(path: Path) -> Iterator[tuple[str, dict]]:
    """Give the records of a folder, with all folders in it, or of a zip.

    Raises
    ------
    BuildError    There is none, or one that cannot be read.
    """
    count = 0
    for place, content in _contents(path):
        if len(content) > LARGEST:
            raise BuildError(f"{place}: has more than {LARGEST} bytes")
        try:
            record = json.loads(content)
        except ValueError as error:
            raise BuildError(f"{place}: is no JSON ({error})") from None
        count += 1
        yield place, record
    if not count:
        raise BuildError(f"{path}: there is no record in it; expected files of OSV's form, *.json")


def _contents(path: Path) -> Iterator[tuple[str, bytes]]:
    if path.is_dir():
        for each in sorted(path.rglob("*.json")):
            with each.open("rb") as stream:
                yield str(each), stream.read(LARGEST + 1)
        return
    try:
        with zipfile.ZipFile(path) as archive:
            for name in sorted(archive.namelist()):
                if name.endswith(".json"):
                    with archive.open(name) as stream:
                        yield f"{path}: {name}", stream.read(LARGEST + 1)
    except (OSError, zipfile.BadZipFile) as error:
        raise BuildError(
            f"{path}: is neither a folder nor a zip that can be read ({error})"
        ) from None


def _judge(record: dict, known: dict) -> Iterator[Weakness]:
    for affected in record.get("affected", ()):
        package = affected.get("package") or {}
        ecosystem, name = package.get("ecosystem"), package.get("name", "")
        key = ecosystem, canonicalize_name(name) if ecosystem == PYPI else name
        for pin in known.get(key, ()):
            doubt = ""
            try:
                if not _is_affected(pin.version, affected):
                    continue
            except InvalidVersion as error:
                doubt = str(error)
            names = tuple(dict.fromkeys((record["id"], *record.get("aliases", ()))))
            summary = record.get("summary") or record.get("details", "").strip().partition("\n")[0]
            yield Weakness(pin, names, summary[:200], _fixes(affected), doubt)


def _is_affected(version: str, affected: dict) -> bool:
    if version in affected.get("versions", ()):
        return True
    ranges = [
        each for each in affected.get("ranges", ()) if each["type"] in {"ECOSYSTEM", "SEMVER"}
    ]
    return any(_is_within(Version(version), each["events"]) for each in ranges)


def _is_within(version: Version, events: list[dict]) -> bool:
    """Whether a version is in a range; with limits, below one of them."""
    marks = [(_parse(text), kind) for event in events for kind, text in event.items()]
    limits = [at for at, kind in marks if kind == "limit"]
    if limits and not any(version < at for at in limits):
        return False
    is_in = False
    # Of equal versions what begins comes first, so that a fix holds.
    for at, kind in sorted(marks, key=lambda mark: (mark[0], mark[1] != "introduced")):
        if kind == "introduced" and version >= at:
            is_in = True
        elif (kind == "fixed" and version >= at) or (kind == "last_affected" and version > at):
            is_in = False
    return is_in


def _parse(text: str) -> Version:
    # "0" stands for what is before all versions.
    return Version("0.dev0") if text == "0" else Version(text)


def _fixes(affected: dict) -> tuple[str, ...]:
    events = [
        event
        for each in affected.get("ranges", ())
        if each["type"] != "GIT"
        for event in each["events"]
    ]
    return tuple(dict.fromkeys(event["fixed"] for event in events if "fixed" in event))


def _tell_age(newest: str) -> str:
    try:
        days = (datetime.now(UTC) - datetime.fromisoformat(newest).astimezone(UTC)).days
    except ValueError:
        raise BuildError(f"a record has no date, but '{newest[:40]}'") from None
    old = "; they are old, newer ones may tell more" if days > OLD else ""
    return f"the newest record is of {newest[:10]}, {days} days ago{old}"


def main(arguments=None) -> int:
    """Look all pins up; return 0 if nothing is known of them, 1 if something is, 2 if it cannot be told."""
    parser = argparse.ArgumentParser(description="Look pinned versions up among known weaknesses.")
    parser.add_argument(
        "data",
        nargs="*",
        type=Path,
        metavar="DATA",
        help="folders or zips with records of OSV's form",
    )
    parser.add_argument(
        "--accept",
        action="append",
        default=[],
        metavar="ID",
        help="weakness that does not concern the project",
    )
    options = parser.parse_args(arguments)
    if not options.data:
        print(
            "NOT CHECKED: no data on known weaknesses were given; name a folder or a zip with records of OSV's form "
            "(for CI: LUMENRAY_ADVISORIES)"
        )
        return 0
    try:
        pins = read_pins()
        records = (each for path in options.data for each in read_records(path))
        findings = find_weaknesses(pins, records)
        age = _tell_age(findings.newest)
    except BuildError as error:
        print(f"known_weaknesses: {error}", file=sys.stderr)
        return 2
    left = [each for each in findings.weaknesses if not set(each.names) & set(options.accept)]
    for each in left:
        print(each)
    accepted = len(findings.weaknesses) - len(left)
    more = f", {accepted} accepted" if accepted else ""
    print(
        f"{len(pins)} pinned versions, {findings.records} records: {len(left)} known weaknesses{more}; {age}"
    )
    return 1 if left else 0


if __name__ == "__main__":
    sys.exit(main())
