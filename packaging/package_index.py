"""Downloads from the package index that pip is set up with."""

import subprocess
import sys
from pathlib import Path

from project import BuildError

NO_ANSWER = "after connection broken by"
"""In what pip says when the index does not answer."""


class UnreachableIndexError(BuildError):
    """The package index does not answer, so nothing can be had that is not in the cache."""


def download(options, folder: Path, what: str) -> None:
    """Let pip put files into a folder.

    Parameters
    ----------
    options : list of str    Options for ``pip download``, and what is wanted of the index.
    what : str    How an error calls that.

    Raises
    ------
    BuildError    pip could not; the sentence has its first cause.
    """
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    command += ["--no-input", "--progress-bar", "off", "--no-deps", "--dest", str(folder), *options]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False
    )
    if done.returncode == 0:
        return
    if NO_ANSWER in done.stderr:
        raise UnreachableIndexError(
            f"the package index cannot be reached, from which pip was to download {what}"
        )
    lines = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
    cause = next((line for line in lines if line.startswith("ERROR: ")), lines[-1])
    raise BuildError(f"pip could not download {what}: {cause.removeprefix('ERROR: ')}")
