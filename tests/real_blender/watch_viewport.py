"""Run the parts of `viewport.py` in Blender's window, inside the real Blender's system, and look from outside.

``watch_viewport.py FOLDER [PART...]``: after every Blender, however it ended, nothing may be left of the engine: no
process and no shared memory.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent

WIDTH, HEIGHT = 800, 560
"""Of the screen and the window. [pixel]"""

LARGE = 1400, 860
"""Likewise, where the view itself must have a certain size. [pixel]"""

ENGINE = b"lumenray.engine.worker"
"""What the command line of the engine's process holds."""

END_PATIENCE = 5.0
"""How long the engine may outlive its Blender. [s]"""

failures = []


def note(condition, text):
    """Print whether something holds, and remember if it does not."""
    print(f"  {'ok    ' if condition else 'FAILED'} {text}", flush=True)
    if not condition:
        failures.append(text)


def engines():
    """Return the numbers of the engine's processes."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            is_engine = entry.name.isdigit() and ENGINE in (entry / "cmdline").read_bytes()
            state = (entry / "stat").read_text().rpartition(")")[2].split()[0] if is_engine else "Z"
        except OSError:
            continue
        if state != "Z":
            found.append(int(entry.name))
    return found


def shared_memory():
    """Return the names in shared memory."""
    return {entry.name for entry in Path("/dev/shm").iterdir()}  # noqa: S108 - it is looked at only


class Window:
    """A Blender in the foreground, with a part of a script or other arguments."""

    def __init__(self, folder, name, *arguments, part="viewport.py", size=(WIDTH, HEIGHT)):
        self.folder, self.name = folder, name
        self.memory_before = shared_memory()
        self.record = folder / f"{name}.json"
        self.record.unlink(missing_ok=True)
        script = ["--python", str(HERE / part), "--", name, str(folder), *arguments]
        size = ["--window-geometry", "0", "0", *map(str, size)]
        self.start = time.monotonic()
        self.log = folder / f"{name}.log"
        with self.log.open("wb") as output:
            order = ["blender", *(size + script if part else arguments)]
            self.process = subprocess.Popen(order, stdout=output, stderr=subprocess.STDOUT)

    def content(self):
        """Return what the part has written so far."""
        try:
            return json.loads(self.record.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {"complete": False, "checks": [], "numbers": {}}

    def wait(self, seconds):
        """Wait for Blender's end, by force after so many seconds, and note whether it ended well. [s]"""
        try:
            code = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait()
            note(False, f"{self.name}: not done after {seconds:.0f} s")
        note(code == 0, f"{self.name}: Blender ended with {code}")

    def report(self):
        """Note what the part has found."""
        content = self.content()
        for name, value in content["numbers"].items():
            print(f"         {name}: {value}")
        for entry in content["checks"]:
            note(entry["holds"], entry["text"])
        note(content["complete"], f"{self.name}: done in {time.monotonic() - self.start:.0f} s")

    def end(self, number):
        """End Blender by a signal."""
        self.process.send_signal(number)
        self.process.wait()

    def check_traces(self, text):
        """Note whether nothing is left a short while after Blender's end."""
        begin = time.monotonic()
        while (left := engines()) and time.monotonic() - begin < END_PATIENCE:
            time.sleep(0.02)
        seconds = time.monotonic() - begin
        note(not left, f"{text}: no engine is left after {seconds:.1f} s {left or ''}")
        new = shared_memory() - self.memory_before
        note(not new, f"{text}: no shared memory is left {new or ''}")
        for pid in left:
            os.kill(pid, signal.SIGKILL)


def use(folder, name, seconds, *arguments, **more):
    """Run a part to its end."""
    print(f"\n{name}", flush=True)
    window = Window(folder, name, *arguments, **more)
    window.wait(seconds)
    window.report()
    window.check_traces(name)
    if failures:
        print(window.log.read_text(errors="replace")[-3000:])


def wait_until(condition, seconds):
    """Wait until something holds; tell whether it came to."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.1)
    return True


def screen_answers():
    """Tell whether the X server is up."""
    order = ["xdotool", "getdisplaygeometry"]
    return subprocess.run(order, check=False, capture_output=True).returncode == 0


def close(folder):
    """Close Blender in the middle of its work, in several ways."""
    use(folder, "save", 60)
    use(folder, "quit", 60)
    for name in ("render", "rendered_view"):
        print(f"\n{name}, killed", flush=True)
        window = Window(folder, name)
        ready = wait_until(lambda window=window: window.content()["complete"], 90)
        note(ready, f"{name}: under way")
        window.report()
        note(len(engines()) == 1, "the engine runs")
        window.end(signal.SIGKILL)
        window.check_traces(f"{name}, killed")
    for number in (signal.SIGKILL, signal.SIGTERM):
        print(f"\nrender from the command line, {number.name}", flush=True)
        order = ("-b", str(folder / "long.blend"), "-o", str(folder / "long_"), "-f", "1")
        window = Window(folder, "line", *order, part="")
        note(wait_until(engines, 60), "the engine runs")
        time.sleep(3.0)
        window.end(number)
        window.check_traces(f"command line, {number.name}")


PARTS = {
    "look": lambda folder: use(folder, "look", 400),
    "faults": lambda folder: use(folder, "faults", 400),
    "memory": lambda folder: use(folder, "memory", 600),
    "some_memory": lambda folder: use(folder, "memory", 200, "0.1"),
    "close": close,
    "previews": lambda folder: use(folder, "previews", 900, part="previews.py", size=LARGE),
    "office": lambda folder: use(folder, "office", 1800, part="office_view.py", size=LARGE),
}


def main():
    """Run the parts; return the exit status."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    parts = sys.argv[2:] or ("look", "faults", "memory", "close")
    width, height = LARGE if {"office", "previews"} & set(parts) else (WIDTH, HEIGHT)
    screen = subprocess.Popen(
        ["Xvfb", ":77", "-screen", "0", f"{width}x{height}x24"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.environ["DISPLAY"] = ":77"
    wait_until(screen_answers, 20)
    try:
        for part in parts:
            PARTS[part](folder)
    finally:
        screen.kill()
    print(f"\n{len(failures)} failed", *failures, sep="\n  ")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
