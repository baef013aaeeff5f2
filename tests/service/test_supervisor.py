"""Jobs in confined processes, whatever ends them or the service."""

import contextlib
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import served_program as program
from served import Served, running

from lumenray.service import folders, jobs, scenes
from lumenray.service.accounts import Quota
from lumenray.service.confinement import LEAST_VERSION, landlock_version

pytestmark = pytest.mark.skipif(
    landlock_version() < LEAST_VERSION, reason="the kernel has no Landlock, or an old one"
)


@pytest.fixture
def served(tmp_path):
    with running(Served(tmp_path, count=2)) as made:
        yield made


def test_an_upload_becomes_a_scene_with_its_content(served):
    scene = served.add_scene(upload=b"BLENDER of Ada")
    served.supervisor.look()
    found = served.wait_until_opened(scene)
    assert (found.state, found.content["objects"]) == (scenes.READY, ["Floor"])
    folder = served.folders.scene(served.user.id, scene.id)
    assert [path.name for path in folder.iterdir()] == ["scene.blend"]


def test_why_an_upload_cannot_be_used_is_told(served):
    scene = served.add_scene(upload=b"BLENDER broken")
    served.supervisor.look()
    found = served.wait_until_opened(scene)
    assert (found.state, found.note) == (scenes.FAILED, "the file is broken")


def test_results_and_what_has_to_be_known_of_them(served):
    scene = served.add_ready_scene()
    fine, short = (served.submit(scene, seed=task) for task in (program.FINE, program.SHORT))
    served.supervisor.look()
    fine, short = served.wait(fine), served.wait(short)
    assert (fine.state, fine.code, fine.note) == (jobs.DONE, 0, "")
    assert (short.state, short.code, short.note) == (jobs.DONE, 3, "goal: time ended at 3 %")
    folder = served.folders.results(served.user.id, fine.id)
    assert (folder / "readings.json").read_text() == "BLENDER 0"
    assert json.loads((folder / "job.json").read_text())["options"] == {"seed": 0}
    assert fine.bytes == sum(path.stat().st_size for path in folder.iterdir())
    work = folder.parent.parent / "work"
    # It is cleared away after the job's end has been told.
    served.supervisor.close()
    assert not list(work.iterdir())
    assert [path.name for path in folder.parent.iterdir() if path.name.startswith(".")] == []


def test_jobs_compute_the_edited_scene(served):
    scene = served.add_ready_scene()
    edits = {"hidden": ["Chair"]}
    scenes.change_edits(served.database, served.user, scene.id, edits, ())
    job = served.submit(scene)
    served.supervisor.look()
    served.wait(job)
    made = served.folders.results(served.user.id, job.id) / "readings.json"
    assert made.read_text() == f"{json.dumps(edits)} 0"


def test_what_fails_says_why_and_leaves_no_results(served):
    scene = served.add_ready_scene()
    refused, crashed = (
        served.submit(scene, seed=task) for task in (program.REFUSED, program.CRASH)
    )
    served.supervisor.look()
    assert served.wait(refused).note == "there are no sensors"
    assert "SIGABRT" in served.wait(crashed).note
    assert not served.folders.results(served.user.id, crashed.id).exists()


def test_a_running_job_is_cancelled(served):
    job = served.submit(served.add_ready_scene(), seed=program.SLEEP)
    served.supervisor.look()
    while served.supervisor.progress(job.id) is None:
        assert jobs.find_job(served.database, served.user, job.id).state != jobs.FAILED
    assert served.supervisor.progress(job.id) == {
        "title": "measure",
        "text": "half",
        "share": 0.5,
        "seconds_left": 2.0,
    }
    served.supervisor.cancel(served.user, job.id)
    assert served.wait(job).state == jobs.CANCELLED


def test_a_job_that_does_not_end_is_ended(tmp_path, monkeypatch):
    monkeypatch.setattr("lumenray.service.processes.PATIENCE", 0.5)
    with running(Served(tmp_path, seconds=2.0)) as served:
        job = served.submit(served.add_ready_scene(), seed=program.STUBBORN)
        served.supervisor.look()
        ended = served.wait(job)
        assert (ended.state, ended.note) == (jobs.FAILED, "it took longer than 2 s")


def test_a_job_takes_no_more_room_than_its_user_has(tmp_path):
    with running(Served(tmp_path, quota=Quota(disk=5 << 20))) as served:
        job = served.submit(served.add_ready_scene(), seed=program.LARGE)
        served.supervisor.look()
        assert "more room than you have left" in served.wait(job).note


def test_a_job_reaches_nothing_that_it_was_not_given(served):
    other = served.add_user("Bo")
    served.add_ready_scene(other)
    job = served.submit(served.add_ready_scene(), seed=program.CURIOUS)
    served.supervisor.look()
    assert served.wait(job).note.startswith("note: []")


def test_links_among_results_are_not_followed(served):
    job = served.submit(served.add_ready_scene(), seed=program.LINKS)
    served.supervisor.look()
    assert served.wait(job).state == jobs.DONE
    results = served.folders.results(served.user.id, job.id)
    assert sorted(path.name for path in results.rglob("*")) == ["job.json", "readings.json"]
    assert json.loads((results / "job.json").read_text())["kind"] == "measure"


def test_results_that_became_a_link_are_no_results(served, monkeypatch):
    scene = served.add_ready_scene()
    taken = folders.take_folder

    def swap(source, target):
        shutil.rmtree(source)
        source.symlink_to(served.folders.scene(served.user.id, scene.id))
        taken(source, target)

    monkeypatch.setattr("lumenray.service.supervisor.take_folder", swap)
    job = served.submit(scene)
    served.supervisor.look()
    assert served.wait(job).state == jobs.FAILED
    assert not served.folders.results(served.user.id, job.id).exists()


def can_plant_trees():
    """Whether this system lets processes be a tree of their own."""
    words = "from lumenray.service.confinement import leave_others; raise SystemExit(not leave_others())"
    return subprocess.run([sys.executable, "-c", words], check=False).returncode == 0


def test_what_a_job_has_started_ends_with_it(served):
    if not can_plant_trees():
        pytest.skip("this system has no namespaces for all users")
    job = served.submit(served.add_ready_scene(), seed=program.HIDING)
    served.supervisor.look()
    assert served.wait(job).state == jobs.DONE
    end = time.monotonic() + 10.0
    while any(job.id in line for line in command_lines()):
        assert time.monotonic() < end
        time.sleep(0.1)


def command_lines():
    """Of all processes of this machine."""
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            yield path.read_bytes().decode("utf-8", "replace")


def test_jobs_of_a_service_that_ended_suddenly_are_begun_anew_or_found_done(tmp_path):
    """What was renamed but not yet said to be done is taken as it is; all else begins again, with one result each."""
    served = Served(tmp_path)
    scene = served.add_ready_scene()
    begun, made = served.submit(scene, seed=0), served.submit(scene, seed=0)
    for _ in range(2):
        jobs.claim(served.database)
    half = served.folders.work(served.user.id, begun.id) / "results"
    half.mkdir(parents=True)
    (half / "readings.json").write_text("half")
    results = served.folders.results(served.user.id, made.id)
    results.mkdir(parents=True)
    (results / "readings.json").write_text("of before")
    (results / "job.json").write_text(json.dumps({"code": 0, "log": []}))
    stray = served.folders.results(served.user.id, "0" * 32)
    stray.mkdir()
    served.database.close()
    with running(Served(tmp_path)) as again:
        first, second = again.wait(begun), again.wait(made)
        assert (first.state, first.attempts) == (jobs.DONE, 2)
        assert (second.state, second.attempts) == (jobs.DONE, 1)
        assert (results / "readings.json").read_text() == "of before"
        own = again.folders.results(again.user.id, begun.id) / "readings.json"
        assert own.read_text() == "BLENDER 0"
        assert not stray.exists()


@pytest.mark.parametrize("is_kept", [False, True])
def test_an_upload_is_not_lost_whenever_its_opening_is_cut_off(tmp_path, is_kept):
    """Also where the scene was written already, and only what was told of it was not kept."""
    served = Served(tmp_path)
    scene = served.add_scene(upload=b"BLENDER of Ada")
    jobs.claim(served.database)
    folder = served.folders.scene(served.user.id, scene.id)
    if is_kept:
        (folder / "scene.blend").write_bytes(b"half")
    served.database.close()
    with running(Served(tmp_path)) as again:
        assert again.wait_until_opened(scene).state == scenes.READY
    assert (folder / "scene.blend").read_bytes() == b"BLENDER of Ada"
    with running(Served(tmp_path)):
        assert [path.name for path in folder.iterdir()] == ["scene.blend"]


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_an_upload_stays_until_it_is_said_that_its_scene_is_there(served, monkeypatch):
    """An end of the service at the last moment leaves what the next one needs."""
    ended = threading.Event()

    def fail(*_):
        ended.set()
        raise SystemExit

    monkeypatch.setattr(scenes, "end_opening", fail)
    scene = served.add_scene(upload=b"BLENDER of Ada")
    served.supervisor.look()
    assert ended.wait(60.0)
    folder = served.folders.scene(served.user.id, scene.id)
    assert (folder / "upload.blend").read_bytes() == b"BLENDER of Ada"


def test_a_job_that_ends_the_service_each_time_is_given_up(tmp_path):
    served = Served(tmp_path)
    job = served.submit(served.add_ready_scene())
    for _ in range(jobs.MOST_ATTEMPTS):
        claimed = jobs.claim(served.database)
        jobs.requeue(served.database, claimed)
    jobs.claim(served.database)
    served.database.close()
    with running(Served(tmp_path)) as again:
        found = again.wait(job)
        assert found.state == jobs.FAILED
        assert "the service has ended each time" in found.note


def test_what_runs_when_the_service_is_closed_waits_for_the_next_start(tmp_path):
    with running(Served(tmp_path)) as served:
        job = served.submit(served.add_ready_scene(), seed=program.SLEEP)
        served.supervisor.look()
        while served.supervisor.progress(job.id) is None:
            assert jobs.find_job(served.database, served.user, job.id).state != jobs.FAILED
    row = sqlite3.connect(tmp_path / "service.sqlite").execute("select state from jobs")
    assert row.fetchone() == (jobs.QUEUED,)


def test_a_full_disk_fails_the_job_and_nothing_else(served, monkeypatch):
    scene = served.add_ready_scene()
    job = served.submit(scene)

    def refuse(*_):
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr("lumenray.service.supervisor.Confined", refuse)
    served.supervisor.look()
    assert "No space left" in served.wait(job).note
    monkeypatch.undo()
    again = served.submit(scene)
    served.supervisor.look()
    assert served.wait(again).state == jobs.DONE
