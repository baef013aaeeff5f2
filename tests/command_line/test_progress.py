"""Progress of commands as other programs hear of it."""

import json
import os

from lumenray.command_line.progress import LISTENER, Bar
from lumenray.engine.accuracy.stopping import Progress


def test_a_program_that_listens_hears_of_every_state(monkeypatch):
    ours, theirs = os.pipe()
    monkeypatch.setenv(LISTENER, str(theirs))
    bar = Bar("bake")
    bar(Progress(0.25, 16, 0.02, 3.0, 9.0))
    bar(Progress(0.0, 0, float("inf"), 0.0, None, "reading"))
    os.close(theirs)
    with os.fdopen(ours) as stream:
        first, second = map(json.loads, stream)
    assert (first["title"], first["share"], first["relative_error"]) == ("bake", 0.25, 0.02)
    assert first["seconds_left"] == 9.0
    assert "16 samples" in first["text"]
    assert (second["relative_error"], second["seconds_left"]) == (None, None)


def test_a_listener_that_has_gone_ends_nothing(monkeypatch):
    ours, theirs = os.pipe()
    os.close(ours)
    monkeypatch.setenv(LISTENER, str(theirs))
    bar = Bar("bake")
    for _ in range(2):
        bar(Progress(0.5, 16, 0.02, 3.0, 3.0))
    os.close(theirs)
