"""What panels say of the engine: whether it is there, why not, and what an edit cost."""

import types

import bpy
from panels import context, draw

from lumenray.blender_addon import feedback, readout
from lumenray.engine.transport.backend import BackendStatus
from lumenray.operators import check_engine
from lumenray.ui import sidebar


def test_designers_are_not_shown_what_an_edit_cost_the_engine():
    status = types.SimpleNamespace(
        changed="Cube moved", sent=1, action="moved", walk=0.01, transfer=0.01, commit=0.01,
        first_sample=0.01, error=0.012, samples=64, is_error=False, message="",
    )  # fmt: skip
    told = " ".join(f"{label} {value}" for label, value in readout.describe_edit(status))
    assert "Picture error 1.2 %" in told
    assert "ms" not in told
    assert any("ms" in value for _, value in readout.describe_timing(status))


def test_engine_panel_names_cause_and_remedy(monkeypatch):
    monkeypatch.setattr(sidebar.first_steps, "are_shown", lambda _: False)
    manager = bpy.context.window_manager
    feedback.note_status(manager, BackendStatus(False, "LLVM was not found", "install it"))
    said = " ".join(draw("LUMENRAY_PT_engine", context()))
    assert "LLVM was not found" in said
    assert "install it" in said
    assert "lumenray.check_engine" in said
    feedback.note_status(manager, BackendStatus(True, "all there"))
    monkeypatch.setattr(sidebar.engine_process, "why_lost", lambda: None)
    assert draw("LUMENRAY_PT_engine", context()) == ["Engine ready"]
    monkeypatch.setattr(sidebar.engine_process, "why_lost", lambda: "out of memory")
    assert draw("LUMENRAY_PT_engine", context()) == ["Engine ended; the next action starts it"]


def test_engine_panel_offers_our_engine_where_another_is_chosen(monkeypatch):
    monkeypatch.setattr(sidebar.first_steps, "are_shown", lambda _: False)
    assert "engine=LUMENRAY" in draw("LUMENRAY_PT_engine", context(engine="CYCLES"))


def test_operator_asks_for_the_engine(monkeypatch):
    class Answer:
        def __init__(self, device):
            pass

        def wait(self):
            return BackendStatus(False, "LLVM was not found", "install it")

    monkeypatch.setattr(feedback, "Probe", Answer)
    assert bpy.ops.lumenray.check_engine() == {"FINISHED"}
    engine = bpy.context.window_manager.lumenray.engine
    assert engine.checked
    assert not engine.usable
    assert engine.remedy == "install it"


class Question:
    """A probe that answers when it is told to, with the device that it was asked of."""

    def __init__(self, device):
        self.device, self.is_answered, self.is_closed = device, False, False

    def poll(self):
        return BackendStatus(True, f"{self.device} is ready") if self.is_answered else None

    def close(self):
        self.is_closed = True


def test_a_window_looks_in_the_background_and_takes_no_answer_of_an_older_choice(monkeypatch):
    waiting, asked, chosen = [], [], "cuda"
    timers = types.SimpleNamespace(
        register=lambda function, first_interval: waiting.append(function),
        unregister=waiting.remove,
        is_registered=waiting.__contains__,
    )
    app = types.SimpleNamespace(background=False, timers=timers)
    window = types.SimpleNamespace(app=app, data=bpy.data)
    monkeypatch.setattr(feedback, "bpy", window)
    monkeypatch.setattr(check_engine, "bpy", window)
    monkeypatch.setattr(feedback, "device", lambda: chosen)
    monkeypatch.setattr(feedback, "Probe", lambda name: asked.append(Question(name)) or asked[-1])
    press = check_engine.LUMENRAY_OT_check_engine.invoke
    assert press(None, context(), None) == {"FINISHED"}
    assert waiting[0]() == feedback.CHECK_INTERVAL
    assert draw("LUMENRAY_PT_start", context())[0] == "Looking for the engine…"
    chosen = "cpu"
    feedback.check_again()
    assert len(waiting) == 1
    assert asked[0].is_closed
    waiting[0]()
    asked[0].is_answered = asked[1].is_answered = True
    assert waiting[0]() is None
    assert bpy.context.window_manager.lumenray.engine.cause == "cpu is ready"
