"""The command ``lumenray probe``: what the engine computes on here, and whether it computes rightly."""

from dataclasses import asdict

from ..blender_addon.foundation import device_trials
from ..blender_addon.foundation.probe import Probe
from .output import say, say_json


def add_command(commands) -> None:
    """Describe the command to argparse."""
    probe = commands.add_parser(
        "probe",
        help="what the engine computes on here, tried by jobs with known answers",
        description="Without options: the device that the engine takes, tried by a small job. LUMENRAY_DEVICE chooses.",
    )
    probe.add_argument(
        "--all",
        action="store_true",
        help="sensors, a lux map and a picture with known answers on every device that there is",
    )
    probe.add_argument("--json", action="store_true", help="JSON instead of text")
    probe.set_defaults(run=run)


def run(options) -> int:
    """Try devices; return 0 where all that are here computed rightly."""
    return _try_all(options) if options.all else _ask(options)


def _ask(options) -> int:
    status = Probe().wait()
    if options.json:
        say_json(asdict(status))
    else:
        say("\n".join([status.cause, *(f"  {line}" for line in status.found)]))
        if status.remedy:
            say(f"  {status.remedy}")
    return int(not status.usable)


def _try_all(options) -> int:
    trials = []
    for trial in device_trials.run_trials():
        trials.append(trial)
        if not options.json:
            say("\n".join(device_trials.to_lines(trial)))
    if options.json:
        say_json(device_trials.to_record(trials))
    here = [trial for trial in trials if not trial.is_absent]
    return int(not here or not all(trial.passed for trial in here))
