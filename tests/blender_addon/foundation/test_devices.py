"""What the engine computes on: asked, chosen and tried from Blender, whatever a driver does."""

import json
import signal
import sys
import time
import types
from dataclasses import astuple

import bpy
import pytest

from lumenray import operators
from lumenray.blender_addon import feedback, preferences, registry
from lumenray.blender_addon.foundation import (
    device_trials,
    engine_process,
    probe,
    running_trials,
)
from lumenray.command_line import main as command_line
from lumenray.engine import device_trial
from lumenray.engine.transport.backend import BackendStatus
from lumenray.engine.transport.devices import CHOICE
from lumenray.engine.worker import client
from lumenray.operators import try_devices

JOBS = ["measure", "bake", "render"]

READY = BackendStatus(True, "ready", "", "cpu", ("A processor: 20 million rays a second",))

SAYS = "import dataclasses, os; from lumenray.engine.transport.backend import BackendStatus\n"

ENDS_ON_CARD = (
    SAYS
    + f"""
if os.environ.get("{CHOICE}") != "cpu":
    os.kill(os.getpid(), {int(signal.SIGKILL)})
made = BackendStatus(True, "ready", "", "cpu", ("A processor",))
print("status=" + json.dumps(dataclasses.asdict(made)))
"""
)


@pytest.fixture(autouse=True)
def _no_choice(monkeypatch):
    monkeypatch.delenv(CHOICE, raising=False)
    # A process of a test before has its device already.
    engine_process.close()
    monkeypatch.setattr(engine_process, "_state", engine_process._State())


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_a_driver_that_ends_the_probe_is_told_and_the_processor_is_taken(monkeypatch):
    monkeypatch.setattr(probe, "STATUS", ENDS_ON_CARD)
    status = probe.Probe().wait()
    assert status.usable
    assert "ended the process" in status.found[0]
    assert status.found[1] == "A processor"


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_a_chosen_card_that_ends_the_probe_is_not_replaced(monkeypatch):
    monkeypatch.setattr(probe, "STATUS", ENDS_ON_CARD)
    status = probe.Probe("cuda").wait()
    assert not status.usable
    assert "preferences" in status.remedy


def test_the_engine_starts_on_what_the_probe_found_unless_another_is_chosen(monkeypatch):
    started = []
    worker = client.Worker(engine_process.ROOT)
    monkeypatch.setattr(worker, "start", lambda: started.append(worker.device))
    monkeypatch.setattr(
        worker, "session", lambda name: types.SimpleNamespace(join=lambda place: None)
    )
    monkeypatch.setattr(engine_process._state, "worker", worker)
    feedback.note_status(bpy.context.window_manager, READY)
    engine_process.open_session("a")
    monkeypatch.setattr(engine_process, "device", lambda: "cuda")
    engine_process.open_session("a")
    assert started == ["cpu", "cuda"]


def test_the_engines_process_knows_its_device():
    code = "import os; made = os.environ['LUMENRAY_DEVICE']"
    process = probe.start_python(code + "\nprint(made)", "metal")
    assert process.communicate()[0].strip() == "metal"


def test_a_trial_tells_what_is_absent():
    absent = device_trials.run_trial("metal", "mono")
    assert absent.is_absent
    assert device_trials.to_lines(absent) == [absent.fault]


@pytest.mark.parametrize("kind", ["stated", pytest.param("computed", marks=pytest.mark.slow)])
def test_a_trial_tells_answers(kind, monkeypatch):
    """The jobs themselves compile dozens of kernels; what their process says of them needs none."""
    if kind == "stated":
        rows = [astuple(device_trial.Answer(job, 1.0, 1.0, 0.01, "lx", 2.0)) for job in JOBS]
        stated = f"(device_trial.Answer(*row) for row in {rows})"
        script = device_trials.SCRIPT.replace("device_trial.try_jobs({kind!r})", stated)
        monkeypatch.setattr(device_trials, "SCRIPT", script)
    tried = device_trials.run_trial("cpu", "mono")
    assert tried.passed
    assert [one["job"] for one in tried.answers] == JOBS
    record = device_trials.to_record([tried])
    assert json.loads(json.dumps(record))["trials"][0]["passed"]


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_a_device_that_ends_its_process_in_the_middle_fails(monkeypatch):
    ending = f"import os; os.kill(os.getpid(), {int(signal.SIGKILL)})"
    script = device_trials.SCRIPT.replace("if status.usable:", f"{ending}\nif status.usable:")
    monkeypatch.setattr(device_trials, "SCRIPT", script)
    tried = device_trials.run_trial("cpu", "mono")
    assert not tried.passed
    assert "was ended" in tried.fault
    assert "FAILED" in device_trials.to_lines(tried)[0]


def trial(device, passed):
    answer = {"job": "measure", "value": 1.0, "expected": 1.0 if passed else 2.0, "error": 0.0,
              "unit": "lx", "seconds": 1.0, "is_right": passed}  # fmt: skip
    return device_trials.Trial(device, "mono", "A thing", (answer,), "")


@pytest.fixture
def _operators(registered):
    registry.register(operators.CLASSES)
    yield
    registry.unregister(operators.CLASSES)


@pytest.mark.usefixtures("_operators")
def test_the_button_leaves_a_text_that_can_be_sent(monkeypatch):
    monkeypatch.setattr(device_trials, "run_trials", lambda *_: iter([trial("cpu", True)]))
    assert bpy.ops.lumenray.try_devices() == {"FINISHED"}
    text = bpy.data.texts["Lumenray Devices"].as_string()
    assert text.startswith("CPU (LLVM), mono: passed")
    assert json.loads(text[text.index("{") :])["trials"][0]["passed"]
    monkeypatch.setattr(device_trials, "run_trials", lambda: iter([trial("cpu", False)]))
    bpy.ops.lumenray.try_devices()
    assert "FAILED" in bpy.data.texts["Lumenray Devices"].as_string()
    assert len(bpy.data.texts) == 1


class Window:
    """What trials touch of Blender's context: a window that can be woken up, with a status bar."""

    def __init__(self):
        self.timers, self.told = [], []
        self.window_manager = self.workspace = self
        self.window, self.status_text_set = None, self.told.append

    def event_timer_add(self, interval, window):
        self.timers.append("timer")
        return "timer"

    def event_timer_remove(self, timer):
        self.timers.remove(timer)


@pytest.fixture
def endless(monkeypatch):
    """Trials on a device that never answers; gives their processes."""
    started = []

    def start(*options):
        started.append(probe.start_python(*options))
        return started[-1]

    monkeypatch.setattr(device_trials, "start_python", start)
    monkeypatch.setattr(device_trials, "SCRIPT", "import time; time.sleep(600.0)")
    return started


def press(running, window, kind, value="PRESS"):
    operator = types.SimpleNamespace(_running=running, _tell=lambda trials: {"FINISHED"})
    event = types.SimpleNamespace(type=kind, value=value)
    return try_devices.LUMENRAY_OT_try_devices.modal(operator, window, event)


def test_escape_ends_trials_and_the_device_that_is_being_tried(endless):
    window, running = Window(), running_trials.start()
    running.begin_signals(window)
    assert not try_devices.LUMENRAY_OT_try_devices.poll(None)
    assert press(running, window, "TIMER", "NOTHING") == {"PASS_THROUGH"}
    assert "0 done" in window.told[-1]
    press(running, window, "ESC")
    end = time.monotonic() + 30.0
    while press(running, window, "TIMER", "NOTHING") == {"PASS_THROUGH"}:
        assert time.monotonic() < end
        time.sleep(0.1)
    assert all(process.poll() is not None for process in endless)
    assert (window.timers, window.told[-1], running.trials) == ([], None, [])
    assert try_devices.LUMENRAY_OT_try_devices.poll(None)


def test_trials_end_with_their_window_and_with_the_extension(endless, monkeypatch):
    window, running = Window(), running_trials.start()
    running.begin_signals(window)
    operator = types.SimpleNamespace(_running=running)
    try_devices.LUMENRAY_OT_try_devices.cancel(operator, window)
    assert window.timers == []
    running_trials.start()
    running_trials.detach()
    assert not running_trials.are_running()
    assert all(process.poll() is not None for process in endless)
    # Blender may call a second time.
    try_devices.LUMENRAY_OT_try_devices.cancel(operator, window)


def test_a_python_that_cannot_be_started_is_told(monkeypatch):
    monkeypatch.setattr(probe.sys, "executable", "/nowhere/python")
    made = device_trials.run_trial("cpu", "mono")
    assert made.is_absent
    assert "cannot be started" in made.fault


def test_the_command_tells_the_device_and_fails_where_an_answer_is_wrong(monkeypatch, capsys):
    assert command_line.main(["probe"]) == 0
    assert "million rays a second" in capsys.readouterr().out
    monkeypatch.setattr(
        device_trials, "run_trials", lambda: iter([trial("cuda", True), trial("cpu", False)])
    )
    assert command_line.main(["probe", "--all"]) == 1
    assert "WRONG" in capsys.readouterr().out
    assert command_line.main(["probe", "--all", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["trials"][0]["device"] == "cuda"


def test_the_choice_offers_what_the_engine_knows():
    from lumenray.engine.transport.devices import DEVICES

    assert [item[0].lower() for item in preferences.DEVICES] == ["auto", *DEVICES]
