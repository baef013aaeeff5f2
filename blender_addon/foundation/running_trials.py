"""The trials of devices that run in the background of this Blender."""

import bpy

from ...imports import loaded_when_used
from .background_work import BackgroundWork

with loaded_when_used():
    from . import device_trials

INTERVAL = 0.25
"""How often the window looks whether the answers are there. [s]"""


class RunningTrials(BackgroundWork):
    """Trials on a thread of their own."""

    def __init__(self):
        self.trials: list[device_trials.Trial] = []
        self._is_wanted = True
        super().__init__(_running, "trials", INTERVAL, has_bar=False)

    def begin_signals(self, context) -> None:
        """Have the window wake up from time to time."""
        self.wake(context.window_manager, context.window)

    def show(self, context) -> None:
        """Show how far they are in the status bar."""
        told = f"Lumenray tries devices, {len(self.trials)} done; Esc stops"
        context.workspace.status_text_set(told)

    def ask_to_end(self) -> None:
        """Ask them to end with what there is."""
        self._is_wanted = False

    def end(self, context) -> None:
        """Stop, wait for the end and leave nothing behind; a second time nothing is left to do."""
        if self.leave(context.window_manager) and context.workspace is not None:
            context.workspace.status_text_set(None)

    def _work(self) -> None:
        for trial in device_trials.run_trials(lambda: self._is_wanted):
            self.trials.append(trial)


_running: list[RunningTrials] = []


def start() -> RunningTrials:
    """Begin to try all devices."""
    return RunningTrials().start()


def are_running() -> bool:
    """Whether trials were begun that have not ended yet."""
    return bool(_running)


def detach():
    """End them with the extension: Blender tells no operator of it."""
    for trials in list(_running):
        trials.end(bpy.context)
