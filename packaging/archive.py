"""The zip of an extension, of manifest, sources and wheels, and the wheels that we make ourselves."""

import base64
import hashlib
import re
import zipfile
from fnmatch import fnmatch
from pathlib import Path

from project import ROOT, BuildError

NOT_SHIPPED = (
    ".*",
    "__pycache__",
    "*.py[cod]",
    "benchmarks",
    "command_line",
    "tools",
    "service",
    "validation",
)
"""Names of files and folders inside the packages that the extension does without."""

ZIP_TIME = (2020, 1, 1, 0, 0, 0)
"""Time of every zip entry, so that the same sources give the same zip."""


def source_files(rooms) -> list[Path]:
    """Return the files of the extension itself, relative to the root."""
    files = [Path("__init__.py"), Path("imports.py"), Path("LICENSE")]
    for room in rooms:
        for path in sorted((ROOT / room).rglob("*")):
            relative = path.relative_to(ROOT)
            hidden = any(
                fnmatch(name, pattern) for name in relative.parts for pattern in NOT_SHIPPED
            )
            if path.is_file() and not hidden:
                files.append(relative)
    return files


def narrow_manifest(path: Path, platform: str, wheels) -> str:
    """Return the text of a manifest for one zip: one platform, and the wheels beside it."""
    text = path.read_text(encoding="utf-8")
    listing = "".join(f'    "./wheels/{wheel.name}",\n' for wheel in wheels)
    for pattern, line in (
        (r"^platforms = \[.*?\]$", f'platforms = ["{platform}"]'),
        (r"^wheels = \[\]$", f"wheels = [\n{listing}]"),
    ):
        text = _replace_one(path, text, pattern, line)
    return text


def drop_building(path: Path, text: str) -> str:
    """Leave out of a manifest what concerns its building: in the zip it would only puzzle."""
    text = _replace_one(path, text, r"\n\[build\]\n.*\Z", "")
    return _replace_one(path, text, r"^# packaging/build_extension\.py narrows .*?\n(?!#)", "")


def _replace_one(path: Path, text: str, pattern: str, line: str) -> str:
    text, count = re.subn(pattern, line, text, flags=re.MULTILINE | re.DOTALL)
    if count != 1:
        raise BuildError(f"{path.name} has no single part like {pattern!r}")
    return text


def write_zip(path: Path, texts: dict[str, bytes], wheels) -> None:
    """Write an extension: texts squeezed, wheels (which are squeezed already) as they are."""
    part = path.with_suffix(".part")
    with zipfile.ZipFile(part, "w") as archive:
        for name, content in texts.items():
            archive.writestr(_entry(name, zipfile.ZIP_DEFLATED), content)
        for wheel in wheels:
            archive.writestr(_entry(f"wheels/{wheel.name}", zipfile.ZIP_STORED), wheel.read_bytes())
    part.replace(path)


def write_wheel(path: Path, files: dict[str, bytes]) -> None:
    """Write a wheel with the RECORD of its files, which hold one ``.dist-info/WHEEL``."""
    info = next(name for name in files if name.endswith(".dist-info/WHEEL")).rpartition("/")[0]
    rows = []
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        rows.append(f"{name},sha256={digest},{len(content)}\n")
    record = f"{info}/RECORD"
    rows.append(f"{record},,\n")
    part = path.with_suffix(".part")
    with zipfile.ZipFile(part, "w") as archive:
        for name, content in {**files, record: "".join(rows).encode()}.items():
            archive.writestr(_entry(name, zipfile.ZIP_DEFLATED), content)
    part.replace(path)


def _entry(name: str, compression: int) -> zipfile.ZipInfo:
    """Return the head of an entry that is the same whenever and wherever it is written."""
    info = zipfile.ZipInfo(name, ZIP_TIME)
    info.compress_type = compression
    info.external_attr = 0o100644 << 16
    return info
