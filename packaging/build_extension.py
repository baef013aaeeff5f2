"""Build the Blender extension: one zip for each platform and Python version.

The wheels come unmodified from the package index that pip is set up with. Which ones is told by
the exact pins in ``pyproject.toml`` (numpy is not pinned: each Blender brings its own). Their
SHA-256 sums are recorded in ``packaging/wheels.lock``, and a file that differs is refused. The lock
is written by ``--update``, in the format of ``sha256sum``.
"""

import argparse
import hashlib
import os
import platform
import re
import shlex
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
"""Root of the repository, which is the root of the extension too."""

LOCK = ROOT / "packaging" / "wheels.lock"
"""SHA-256 sum and file name of every wheel that a zip may hold."""

WHEEL_PLATFORMS = {
    "linux-x64": [f"manylinux_2_{minor}_x86_64" for minor in (28, 27, 24, 17)]
    + ["manylinux2014_x86_64"],
    "windows-x64": ["win_amd64"],
    "macos-arm64": [f"macosx_{major}_0_arm64" for major in (14, 13, 12, 11)],
}
"""Platforms as Blender names them, and the platform tags of the wheels that run there."""

PYTHONS = {"cp311": "3.11", "cp313": "3.13"}
"""Python tags: Blender 4.2 to 5.0 bring Python 3.11; 5.1, and Debian's 4.3, run on 3.13."""

NOT_SHIPPED = (
    ".*",
    "__pycache__",
    "*.py[cod]",
    "make_*.py",
    "benchmarks",
    "command_line",
    "validation",
)
"""Names of files and folders inside the packages that the extension does without."""

ZIP_TIME = (2020, 1, 1, 0, 0, 0)
"""Time of every zip entry, so that the same sources give the same zip."""

REQUIRED_KEYS = (
    "schema_version", "id", "name", "version", "tagline", "maintainer", "type", "license",
    "blender_version_min", "platforms", "wheels",
)  # fmt: skip
"""Keys of the manifest without which Blender, or we ourselves, would refuse it."""

TAGLINE_LENGTH = 64
"""Longest tagline that Blender accepts."""


class BuildError(Exception):
    """The extension cannot be built; the message says why and what helps."""


@dataclass(frozen=True)
class Wheel:
    """One recorded wheel: its file name and the SHA-256 sum of its bytes."""

    filename: str
    sha256: str

    def fits(self, name, version, blender_platform, python_tag):
        """Tell whether this is the wheel of a pinned package for a platform and a Python."""
        parts = self.filename.removesuffix(".whl").split("-")
        return (
            normalised(parts[0]) == normalised(name)
            and parts[1] == version
            and python_tag in parts[-3].split(".")
            and any(tag in WHEEL_PLATFORMS[blender_platform] for tag in parts[-1].split("."))
        )


def normalised(name):
    """Return the name of a package as package indices compare it."""
    return re.sub(r"[-_.]+", "_", name).lower()


def read_project():
    """Return what ``pyproject.toml`` says under ``[project]`` and ``[tool.setuptools]``."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return data["project"], data["tool"]["setuptools"]


def read_pins(project):
    """Return (name, version) of each package that is shipped as a wheel."""
    pins = [entry.split("==") for entry in project["dependencies"] if "==" in entry]
    return [(name.strip(), version.strip()) for name, version in pins]


def read_lock():
    """Return the recorded wheels."""
    if not LOCK.exists():
        return []
    lines = LOCK.read_text(encoding="utf-8").splitlines()
    rows = [line.split() for line in lines if line and not line.startswith("#")]
    return [Wheel(filename, sha256) for sha256, filename in rows]


def write_lock(wheels):
    """Record wheels, sorted by file name, in the format of ``sha256sum``."""
    rows = [f"{wheel.sha256}  {wheel.filename}" for wheel in wheels]
    rows.sort(key=lambda row: row.split()[1])
    LOCK.write_text("\n".join(rows) + "\n", encoding="utf-8")


def cache_folder():
    """Return the folder in which downloaded wheels are kept, made if need be."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = base / "lumenray" / "wheels"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def sha256_of(path):
    """Return the SHA-256 sum of a file in hexadecimal digits."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def download(pins, blender_platform, python_tag, folder):
    """Let pip put the wheels of some pinned packages into a folder."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    command += ["--no-input", "--progress-bar", "off", "--no-deps", "--only-binary=:all:"]
    command += ["--implementation", "cp", "--python-version", PYTHONS[python_tag]]
    for tag in WHEEL_PLATFORMS[blender_platform]:
        command += ["--platform", tag]
    command += ["--dest", str(folder), *(f"{name}=={version}" for name, version in pins)]
    if subprocess.run(command, stdin=subprocess.DEVNULL, check=False).returncode:
        raise BuildError(f"pip could not download the wheels for {blender_platform} {python_tag}")


def update_lock(targets, pins):
    """Download the wheels of all targets anew and record their sums.

    Wheels of other targets stay recorded as long as their version is still the pinned one.
    """
    kept = [
        wheel
        for wheel in read_lock()
        if any(
            wheel.fits(*pin, *other)
            for pin in pins
            for other in all_targets()
            if other not in targets
        )
    ]
    found = []
    cache = cache_folder()
    for target in targets:
        with tempfile.TemporaryDirectory(dir=cache) as fresh:
            download(pins, *target, fresh)
            for path in sorted(Path(fresh).glob("*.whl")):
                found.append(Wheel(path.name, sha256_of(path)))
                path.replace(cache / path.name)
    write_lock(set(kept) | set(found))


def fetch_wheels(target, pins, recorded):
    """Return the paths of a target's wheels in the cache, each with the recorded sum."""
    cache = cache_folder()
    paths = []
    for pin in pins:
        wheel = next((wheel for wheel in recorded if wheel.fits(*pin, *target)), None)
        if wheel is None:
            raise BuildError(
                f"packaging/wheels.lock records no wheel of {'=='.join(pin)} for "
                f"{' '.join(target)}; run packaging/build_extension.py --update --all and review "
                "what it records"
            )
        path = cache / wheel.filename
        if not path.exists():
            with tempfile.TemporaryDirectory(dir=cache) as fresh:
                download([pin], *target, fresh)
                arrived = Path(fresh) / wheel.filename
                if not arrived.exists():
                    names = ", ".join(path.name for path in Path(fresh).iterdir())
                    raise BuildError(f"expected {wheel.filename}, but the index gave {names}")
                arrived.replace(path)
        if sha256_of(path) != wheel.sha256:
            raise BuildError(
                f"{path} is not the file that packaging/wheels.lock records; if it was damaged on "
                "this machine, delete it and build again"
            )
        paths.append(path)
    return paths


def source_files(setuptools):
    """Return the files of the extension itself, relative to the root."""
    packages = setuptools["packages"]
    rooms = sorted({name.split(".")[1] for name in packages if "." in name})
    files = [Path("__init__.py"), Path("LICENSE")]
    for room in rooms:
        for path in sorted((ROOT / room).rglob("*")):
            relative = path.relative_to(ROOT)
            names = relative.parts
            hidden = any(fnmatch(name, pattern) for name in names for pattern in NOT_SHIPPED)
            if path.is_file() and not hidden:
                files.append(relative)
    return files


def manifest_for(target, wheels):
    """Return the text of the manifest for one zip: one platform, and the wheels beside it."""
    text = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    listing = "".join(f'    "./wheels/{path.name}",\n' for path in wheels)
    for pattern, line in (
        (r"^platforms = \[.*?\]$", f'platforms = ["{target[0]}"]'),
        (r"^wheels = \[\]$", f"wheels = [\n{listing}]"),
        # What to leave out is decided; in the zip it would only puzzle.
        (r"\n\[build\]\n.*\Z", ""),
        (r"^# packaging/build_extension\.py narrows .*?\n(?!#)", ""),
    ):
        text, count = re.subn(pattern, line, text, flags=re.MULTILINE | re.DOTALL)
        if count != 1:
            raise BuildError(f"blender_manifest.toml has no single part like {pattern!r}")
    return text


def write_zip(path, manifest, files, wheels):
    """Write the extension: sources squeezed, wheels (which are squeezed already) as they are."""
    part = path.with_suffix(".part")
    with zipfile.ZipFile(part, "w") as archive:
        entries = [("blender_manifest.toml", manifest.encode(), zipfile.ZIP_DEFLATED)]
        for name in files:
            entries.append((name.as_posix(), (ROOT / name).read_bytes(), zipfile.ZIP_DEFLATED))
        for wheel in wheels:
            entries.append((f"wheels/{wheel.name}", wheel.read_bytes(), zipfile.ZIP_STORED))
        for name, content, compression in entries:
            info = zipfile.ZipInfo(name, ZIP_TIME)
            info.compress_type = compression
            info.external_attr = 0o100644 << 16
            archive.writestr(info, content)
    part.replace(path)


def check_zip(path, version):
    """Check a zip by reading it, as far as that goes without Blender."""
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    missing = [key for key in REQUIRED_KEYS if key not in manifest]
    if missing:
        raise BuildError(f"{path.name}: the manifest lacks {', '.join(missing)}")
    if manifest["version"] != version:
        raise BuildError(
            f"blender_manifest.toml is version {manifest['version']}, pyproject.toml {version}"
        )
    tagline = manifest["tagline"]
    if len(tagline) > TAGLINE_LENGTH or not (tagline[-1].isalnum() or tagline[-1] in ")]}"):
        raise BuildError(f"the tagline must have at most 64 characters and no full stop: {tagline}")
    listed = {wheel.removeprefix("./") for wheel in manifest["wheels"]}
    held = {name for name in names if name.endswith(".whl")}
    if not listed or listed != held:
        raise BuildError(f"{path.name}: the manifest lists other wheels than the zip holds")
    if "__init__.py" not in names:
        raise BuildError(f"{path.name}: no __init__.py at the top")
    if any(name.startswith("wheels/numpy-") for name in names):
        raise BuildError(f"{path.name}: numpy is Blender's own and must not be shipped")


def validate_zip(path):
    """Let Blender judge a zip, if the variable BLENDER names one; tell whether it did."""
    blender = os.environ.get("BLENDER")
    if not blender:
        return False
    command = [*shlex.split(blender), "--command", "extension", "validate", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise BuildError(f"Blender refuses {path.name}:\n{done.stdout}{done.stderr}")
    return True


def all_targets():
    """Return every (platform, Python tag) that the extension is built for."""
    return [(name, tag) for name in WHEEL_PLATFORMS for tag in PYTHONS]


def current_platform():
    """Return this machine's platform as Blender names it, or None if it is none of ours."""
    system = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}.get(platform.system())
    machine = {"x86_64": "x64", "AMD64": "x64", "arm64": "arm64"}.get(platform.machine())
    name = f"{system}-{machine}"
    return name if name in WHEEL_PLATFORMS else None


def select_targets(options):
    """Return the targets that the command line asks for."""
    if options.all:
        return all_targets()
    system = options.platform or current_platform()
    if system is None:
        raise BuildError(f"this machine is none of {', '.join(WHEEL_PLATFORMS)}: use --platform")
    return [(system, tag) for tag in PYTHONS if options.python in (None, tag)]


def build(target, project, setuptools, pins, folder):
    """Build and check the zip of one target; return its path and a line about it."""
    wheels = fetch_wheels(target, pins, read_lock())
    version = project["version"]
    path = folder / f"lumenray-{version}-{'-'.join(target)}.zip"
    write_zip(path, manifest_for(target, wheels), source_files(setuptools), wheels)
    check_zip(path, version)
    judge = "Blender" if validate_zip(path) else "reading it (set BLENDER to ask Blender)"
    return f"{path}  {path.stat().st_size / 1e6:.0f} MB, checked by {judge}"


def parse_arguments(arguments):
    """Return the parsed command line."""
    parser = argparse.ArgumentParser(description="Build the Blender extension.")
    parser.add_argument("--platform", choices=WHEEL_PLATFORMS, help="default: this machine's")
    parser.add_argument("--python", choices=PYTHONS, help="Python tag; default: all")
    parser.add_argument("--all", action="store_true", help="every platform and Python tag")
    parser.add_argument("--update", action="store_true", help="record the wheels' sums anew")
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder of the zips")
    return parser.parse_args(arguments)


def main(arguments=None):
    """Build what the command line asks for; return the exit status."""
    options = parse_arguments(arguments)
    try:
        targets = select_targets(options)
        project, setuptools = read_project()
        pins = read_pins(project)
        if options.update:
            update_lock(targets, pins)
            print(f"recorded {len(read_lock())} wheels in {LOCK}")
            return 0
        options.output.mkdir(parents=True, exist_ok=True)
        for target in targets:
            print(build(target, project, setuptools, pins, options.output), flush=True)
    except BuildError as error:
        print(f"build_extension: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
