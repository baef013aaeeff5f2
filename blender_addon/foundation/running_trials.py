"""The trials of devices that run in the background of this Blender: their thread, and how it ends.

There is one such round at a time. It belongs to the extension and not to the operator that started it, so that it ends with
the extension too.
"""

import threading

import bpy

from . import device_trials

INTERVAL = 0.25
"""How often the window looks whether the answers are there. [s]"""


class RunningTrials:
    """Trials on a thread of their own; all methods are for Blender's main thread."""

    def __init__(self):
        self.trials: list[device_trials.Trial] = []
        self._is_wanted, self._timer = True, None
        self._thread = threading.Thread(target=self._work, name="lumenray trials", daemon=True)
        self._thread.start()

    @property
    def is_alive(self) -> bool:
        """Whether devices are still being tried."""
        return self._thread.is_alive()

    def begin_signals(self, context) -> None:
        """Have the window wake up from time to time."""
        self._timer = context.window_manager.event_timer_add(INTERVAL, window=context.window)

    def show(self, context) -> None:
        """Show how far they are in the status bar."""
        told = f"Lumenray tries devices, {len(self.trials)} done; Esc stops"
        context.workspace.status_text_set(told)

    def stop(self) -> None:
        """Ask them to end with what there is."""
        self._is_wanted = False

    def end(self, context) -> None:
        """Stop, wait for the end and leave nothing behind; a second time nothing is left to do."""
        if self not in _running:
            return
        _running.remove(self)
        self.stop()
        self._thread.join()
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def _work(self) -> None:
        for trial in device_trials.run_trials(lambda: self._is_wanted):
            self.trials.append(trial)


_running: list[RunningTrials] = []


def start() -> RunningTrials:
    """Begin to try all devices."""
    made = RunningTrials()
    _running.append(made)
    return made


def are_running() -> bool:
    """Whether trials were begun that have not ended yet."""
    return bool(_running)


def detach():
    """End them with the extension: Blender tells no operator of it."""
    for trials in list(_running):
        trials.end(bpy.context)
