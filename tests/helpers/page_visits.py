"""Visits of the service's page by a Chromium without a window, as scripts of `tests/viewer` make them."""

import json
import re
import shutil
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "viewer"

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)

CAN_VISIT = bool(CHROMIUM and shutil.which("node") and (FOLDER / "node_modules").is_dir())

HOW = "needs Chromium, Node and Playwright: run tests/viewer/setup.sh"

LIMIT = 500
"""Longest time for a visit. [s]"""


@contextmanager
def serving(folder):
    """A service in a process of its own: its address and a token."""
    command = [sys.executable, "-m", "lumenray.command_line.main", "serve", str(folder)]
    added = subprocess.run(
        [*command, "--add-user", "Ada"], check=True, capture_output=True, text=True
    )
    server = subprocess.Popen([*command, "--port", "0"], stdout=subprocess.PIPE, text=True)
    try:
        yield re.search(r"http://\S+?(?=;)", server.stdout.readline())[0], added.stdout.strip()
    finally:
        server.terminate()
        server.wait()
        server.stdout.close()


def visit(script, folder, request):
    """Let a script visit a new service in a folder; return what it prints."""
    with serving(folder / "service") as (address, token):
        whole = {"chromium": CHROMIUM, "page": address, "token": token, **request}
        (folder / "request.json").write_text(json.dumps(whole))
        done = subprocess.run(
            ["node", script, str(folder / "request.json")],
            cwd=FOLDER, capture_output=True, text=True, timeout=LIMIT, check=False,
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout
