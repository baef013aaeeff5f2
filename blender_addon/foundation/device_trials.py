"""Jobs with known answers on every device, each in a process of its own: what users of a device send to us."""

import json
import platform
import subprocess
import time
from dataclasses import dataclass

from ...engine import VERSION
from ...engine.transport.devices import DEVICES
from .probe import PATIENCE, last_line, start_python, was_ended

KINDS = ("mono", "spectral")
"""Kinds of transport, photometric and spectral."""

PATIENCE_WITH_JOBS = 5.0 * PATIENCE
"""How long the jobs of one device and kind may take, kernels included. [s]"""

STEP = 0.25
"""How often it is asked whether a trial is still wanted. [s]"""

SCRIPT = """
from lumenray.engine import device_trial
from lumenray.engine.transport import backend
status = backend.status()
print("status=" + json.dumps(dataclasses.asdict(status)), flush=True)
if status.usable:
    for answer in device_trial.try_jobs({kind!r}):
        made = dataclasses.asdict(answer)
        print("answer=" + json.dumps({{**made, "is_right": answer.is_right}}), flush=True)
"""


@dataclass(frozen=True)
class Trial:
    """What a device did in a kind of transport.

    ``found`` names it in words and is empty where there is none, ``answers`` are those of `device_trial.Answer` with
    ``is_right``, and ``fault`` is empty where all went well.
    """

    device: str
    kind: str
    found: str
    answers: tuple[dict, ...]
    fault: str

    @property
    def is_absent(self) -> bool:
        """Whether there is no such device here."""
        return not self.found

    @property
    def passed(self) -> bool:
        """Whether all answers came and are right."""
        return (
            bool(self.answers) and not self.fault and all(one["is_right"] for one in self.answers)
        )


def run_trials(is_wanted=lambda: True):
    """Yield a `Trial` for every device and kind of transport, as long as ``is_wanted()``."""
    for device in DEVICES:
        for kind in KINDS:
            trial = run_trial(device, kind, is_wanted)
            if trial is None:
                return
            yield trial
            if trial.is_absent:
                break


def run_trial(device: str, kind: str, is_wanted=lambda: True) -> Trial | None:
    """Try a device in a process of its own, which it may end; None, and no process left, once it is not wanted."""
    try:
        process = start_python(SCRIPT.format(kind=kind), device)
    except OSError as error:
        return Trial(device, kind, "", (), f"Blender's Python cannot be started: {error}")
    end, is_late = time.monotonic() + PATIENCE_WITH_JOBS, False
    while True:
        try:
            said, complaint = process.communicate(timeout=STEP)
            break
        except subprocess.TimeoutExpired:
            is_late = time.monotonic() > end
            if is_late or not is_wanted():
                process.kill()
    if not is_wanted():
        return None
    fault = last_line(complaint) if process.returncode else ""
    if is_late:
        fault = f"no answer within {PATIENCE_WITH_JOBS:.0f} s"
    elif was_ended(process.returncode):
        fault = f"the process was ended ({process.returncode}): {fault}"
    status, answers = {}, []
    for line in said.splitlines():
        kind_of_line, _, text = line.partition("=")
        if kind_of_line == "status":
            status = json.loads(text)
        elif kind_of_line == "answer":
            answers.append(json.loads(text))
    found = "; ".join(status.get("found", ()))
    return Trial(device, kind, found, tuple(answers), fault or _trouble(status))


def _trouble(status: dict) -> str:
    return "" if status.get("usable") else status.get("cause", "it said nothing")


def to_record(trials) -> dict:
    """Return trials as plain data for a file, with what else one has to know of the machine."""
    return {
        "version": VERSION,
        "system": platform.platform(),
        "python": platform.python_version(),
        "trials": [
            {
                "device": trial.device,
                "transport": trial.kind,
                "found": trial.found,
                "passed": trial.passed,
                "fault": trial.fault,
                "answers": list(trial.answers),
            }
            for trial in trials
        ],
    }


def to_lines(trial: Trial) -> list[str]:
    """Tell of a trial in lines of text."""
    label = DEVICES[trial.device].label
    if trial.is_absent:
        return [trial.fault]
    verdict = "passed" if trial.passed else "FAILED"
    lines = [f"{label}, {trial.kind}: {verdict}", f"  {trial.found}"]
    if trial.fault:
        lines.append(f"  {trial.fault}")
    for one in trial.answers:
        mark = "" if one["is_right"] else "  WRONG"
        lines.append(
            f"  {one['job']:<8}{one['value']:10.3f} +- {one['error']:.3f} {one['unit']}, "
            f"should be {one['expected']:.3f}, {one['seconds']:.1f} s{mark}"
        )
    return lines
