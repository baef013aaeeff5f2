"""Stands for the command in the jobs of `served`: what it does is told by the seed."""

import json
import os
import sys
import time
from pathlib import Path

FINE, SHORT, REFUSED, CRASH, SLEEP, STUBBORN, LARGE, CURIOUS, LINKS, HIDING = range(10)


def main(arguments):
    options = dict(each.partition("=")[::2] for each in arguments if each.startswith("--"))
    target = Path(options["--output"])
    if arguments[:2] == ["scene", "take"]:
        return take(Path(arguments[2]), target, Path(options["--content"]))
    if arguments[:2] == ["scene", "edit"]:
        target.write_bytes(Path(options["--edits"]).read_bytes())
        return 0
    return compute(int(options.get("--seed", FINE)), Path(arguments[1]), target)


def take(upload, target, content):
    if upload.read_bytes().startswith(b"BLENDER broken"):
        sys.stderr.write("lumenray: the file is broken\n")
        return 1
    target.write_bytes(upload.read_bytes())
    content.write_text(json.dumps({"lights": [], "objects": ["Floor"], "materials": []}))
    return 0


def compute(task, scene, target):
    tell({"title": "measure", "text": "half", "share": 0.5, "seconds_left": 2.0, "junk": [1]})
    if task == REFUSED:
        sys.stderr.write("lumenray: there are no sensors\n")
        return 1
    if task == CRASH:
        os.abort()
    if task in {SLEEP, STUBBORN}:
        if task == STUBBORN:
            import signal

            signal.signal(signal.SIGINT, signal.SIG_IGN)
        time.sleep(600)
    if task == LINKS:
        plant_links(scene, target.parent)
    if task == HIDING:
        hide(target)
    if task == LARGE:
        for number in range(100):
            (target.parent / f"{number}.bin").write_bytes(bytes(1 << 20))
            time.sleep(0.05)
    if task == CURIOUS:
        look_round(scene.parents[3])
    target.write_text(f"{scene.read_bytes().decode()} {task}")
    if task in {SHORT, CURIOUS}:
        sys.stderr.write("goal: time ended at 3 %\n")
        return 3
    return 0


def plant_links(scene, folder):
    """Results that are another folder, and a file among them that is another file."""
    (folder / "secret").symlink_to(scene)
    (folder / "deep").symlink_to(scene.parent)
    (folder / "job.json").symlink_to("/etc/passwd")


def hide(target):
    """Start a process in a session of its own."""
    if os.fork():
        return
    os.setsid()
    if os.fork() == 0:
        os.close(1)
        os.close(2)
        words = f"import time; time.sleep(600) # {target}"
        os.execv(sys.executable, [sys.executable, "-c", words])  # noqa: S606 - ourselves
    os._exit(0)


def look_round(users):
    """Tell what can be read of what was not given."""
    seen = []
    for path in (users, users.parent / "service.sqlite", Path("/etc/passwd"), Path("/root")):
        try:
            list(path.iterdir()) if path.is_dir() else path.read_bytes()
            seen.append(str(path))
        except OSError:
            continue
    sys.stderr.write(f"note: {seen}\n")


def tell(state):
    os.write(int(os.environ["LUMENRAY_PROGRESS"]), json.dumps(state).encode() + b"\nno json\n")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
