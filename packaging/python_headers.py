"""The headers of a Python version: of one that is installed, else of Debian's package of them."""

import shutil
import subprocess
import tempfile
from pathlib import Path

from project import BuildError

DEBIAN_SUITE = "forky"
"""The Debian that has the newest Python; its packages are signed, and only headers are taken."""

APT = """Dir::State "{folder}";
Dir::State::status "{folder}/status";
Dir::Cache "{folder}";
Dir::Etc::sourceparts "/dev/null";
Dir::Etc::sourcelist "{folder}/sources.list";
APT::Architecture "amd64";
APT::Sandbox::User "";
"""
"""Settings that keep a look into another Debian apart from the machine's own packages."""

MIRROR = [
    "apt-get",
    "indextargets",
    "--format",
    "$(REPO_URI)",
    "Identifier: Packages",
    "Origin: Debian",
]
"""Asks for the places from which this machine has Debian's packages."""

ASK = "import sysconfig; print(sysconfig.get_path('include')); print(sysconfig.get_path('platinclude'))"


def find_headers(version: str, folder: Path) -> list[Path]:
    """Return the folders that hold ``Python.h`` and ``pyconfig.h``.

    Parameters
    ----------
    version : str    Such as 3.14.
    folder : Path    Where headers are kept that had to be fetched.

    Raises
    ------
    BuildError    There is no such Python here, nor can Debian's headers be had.
    """
    kept = folder / f"python{version}"
    paths = _of_installed(version) or _of_package(kept, version)
    if not paths:
        _fetch_package(kept, version)
        paths = _of_package(kept, version)
    if not paths:
        raise _missing(version, f"Debian {DEBIAN_SUITE} has no such package")
    return paths


def _of_installed(version: str) -> list[Path]:
    python = shutil.which(f"python{version}")
    if python is None:
        return []
    done = subprocess.run([python, "-c", ASK], capture_output=True, text=True, check=False)
    paths = [Path(line) for line in done.stdout.split("\n") if line]
    return paths if any((path / "Python.h").exists() for path in paths) else []


def _of_package(kept: Path, version: str) -> list[Path]:
    include = kept / "usr" / "include"
    # The second folder is what the first one's pyconfig.h looks for.
    return [include / f"python{version}", include] if include.exists() else []


def _fetch_package(kept: Path, version: str) -> None:
    """Unpack Debian's package of the headers, without installing anything."""
    if shutil.which("apt-get") is None:
        raise _missing(version, "this is no Debian that could fetch the headers")
    mirrors = subprocess.run(MIRROR, capture_output=True, text=True, check=False).stdout.split()
    if not mirrors:
        raise _missing(version, "apt knows no mirror of Debian that could have the headers")
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        for name in ("lists/partial", "archives/partial"):
            (folder / name).mkdir(parents=True)
        (folder / "status").touch()
        (folder / "sources.list").write_text(
            "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] "
            f"{mirrors[0]} {DEBIAN_SUITE} main\n"
        )
        (folder / "apt.conf").write_text(APT.format(folder=folder))
        package = f"libpython{version}-dev"
        for command in (["apt-get", "-qq", "update"], ["apt-get", "-qq", "download", package]):
            done = subprocess.run(
                command,
                cwd=folder,
                env={"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "APT_CONFIG": f"{folder}/apt.conf"},
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode:
                raise _missing(version, f"{' '.join(command)} says: {done.stderr.strip()[-200:]}")
        (archive,) = folder.glob("*.deb")
        fresh = kept.with_suffix(".part")
        shutil.rmtree(fresh, ignore_errors=True)
        subprocess.run(["dpkg-deb", "--extract", archive, fresh], check=True)
        shutil.rmtree(kept, ignore_errors=True)
        fresh.replace(kept)


def _missing(version: str, cause: str) -> BuildError:
    return BuildError(
        f"the headers of Python {version} are needed to compile xatlas, which has no wheel for it; "
        f"install Python {version} ({cause})"
    )
