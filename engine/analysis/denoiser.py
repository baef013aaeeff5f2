"""Open Image Denoise, where it is installed: a network that guesses what a noisy picture would look like.

It comes with the extension's denoiser pack, or from the package ``pyoidn``. Like every filter for looking it gives a biased
copy; whoever shows it has to say so.
"""

import importlib.util
import io
import json
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np

from ..errors import LumenrayError
from ..photometry.colour import MIDDLE_GREY, REC709_LUMINANCE

NAME = "Open Image Denoise"

LIBRARIES = {
    "linux": "oidn/lib/libOpenImageDenoise.so",
    "darwin": "oidn/lib/libOpenImageDenoise.dylib",
    "win32": "oidn/bin/OpenImageDenoise.dll",
}
"""Where the library lies in the package, by `sys.platform`."""

SECONDS = 600.0
"""How long a picture may take. [s]"""


class DenoiserError(LumenrayError):
    """Open Image Denoise is not there or cannot do it."""


def find_denoiser() -> Path | None:
    """Return the path of the library, None where it is not installed. Cheap: nothing is loaded."""
    found = importlib.util.find_spec("pyoidn")
    folders = [] if found is None else found.submodule_search_locations or []
    paths = (Path(folder, LIBRARIES.get(sys.platform, "-")) for folder in folders)
    return next((path for path in paths if path.is_file()), None)


def require_denoiser() -> Path:
    """Return the path of the library.

    Raises
    ------
    DenoiserError    It is not installed.
    """
    library = find_denoiser()
    if library is None:
        raise DenoiserError(
            f"{NAME} is not installed: install the zip lumenray-denoiser for this platform, or the package pyoidn"
        )
    return library


def denoise(colour, normal, albedo, has_noisy_guides: bool = False) -> np.ndarray:
    """Return a denoised copy of a picture.

    Parameters
    ----------
    colour : (h, w, 3) array    Linear Rec. 709, in any unit: it is scaled into the range of pictures and back.
    normal, albedo : (h, w, 3) array    Of what is seen, means over the pixels.
    has_noisy_guides : bool    Whether these have noise, which is then filtered first.

    Returns
    -------
    (h, w, 3) float32 array    Colours outside the gamut have become colours inside.

    Raises
    ------
    DenoiserError    It is not installed, or it could not do it.
    """
    return Denoising(colour, normal, albedo, has_noisy_guides).result()


def denoise_map(colour) -> np.ndarray:
    """Return a denoised copy of a map of light on surfaces; parameters and result as of `denoise`."""
    return Denoising(colour).result()


class Denoising:
    """A picture that is being denoised, in a process of its own; parameters as of `denoise`.

    Parameters
    ----------
    normal, albedo : array or None    None: the picture is a map of light on surfaces.
    is_modest : bool
        Whether others go first: a smaller network, which takes guides of few samples, and what processors others leave.
    """

    def __init__(self, colour, normal=None, albedo=None, has_noisy_guides=False, is_modest=False):
        order = {
            "search_path": sys.path,
            "library": str(require_denoiser()),
            "filter": "RTLightmap" if normal is None else "RT",
            "has_noisy_guides": has_noisy_guides,
            "is_modest": is_modest,
        }
        colour = np.maximum(np.nan_to_num(np.asarray(colour, dtype=np.float32), posinf=0.0), 0.0)
        seen = colour @ REC709_LUMINANCE
        seen = seen[seen > 0.0]
        self._scale = MIDDLE_GREY / np.exp(np.log(seen).mean()) if seen.size else 1.0
        images = {"color": colour * self._scale}
        if normal is not None:
            images |= {"albedo": np.clip(albedo, 0.0, 1.0), "normal": normal}
        archive = io.BytesIO()
        np.savez(archive, **{name: np.asarray(i, dtype=np.float32) for name, i in images.items()})
        self._request = json.dumps(order).encode() + b"\n" + archive.getvalue()
        self._process = _start()
        self._answer, self._said = b"", b""
        self._thread = threading.Thread(target=self._talk, name="lumenray-denoise", daemon=True)
        self._thread.start()

    def wait(self, seconds: float) -> bool:
        """Wait for the end, but not for long; tell whether it has come."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def cancel(self) -> None:
        """End it; there will be no result."""
        self._process.kill()
        self._thread.join()

    def result(self) -> np.ndarray:
        """Return the copy when it is made. (h, w, 3) float32

        Raises
        ------
        DenoiserError    It could not be made.
        """
        if not self.wait(SECONDS):
            self.cancel()
            raise DenoiserError(f"{NAME} took longer than {SECONDS:.0f} s")
        if self._process.returncode:
            lines = self._said.decode(errors="replace").strip().splitlines() or ["without a word"]
            raise DenoiserError(f"{NAME} ended with {self._process.returncode}: {lines[-1]}")
        with np.load(io.BytesIO(self._answer), allow_pickle=False) as held:
            return (held["result"] / self._scale).astype(np.float32)

    def _talk(self) -> None:
        self._answer, self._said = self._process.communicate(self._request)


def _start() -> subprocess.Popen:
    program = str(Path(__file__).with_name("denoiser_process.py"))
    try:
        return subprocess.Popen(  # noqa: S603 - this very Python and our own module
            [sys.executable, "-I", "-X", "utf8", program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
    except OSError as error:
        raise DenoiserError(f"{NAME} cannot be started: {error}") from error
