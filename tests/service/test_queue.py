"""The queue in the database: each job is claimed, ended and counted once."""

import threading

import pytest
from served import CONTENT, Served

from lumenray.engine.errors import LumenrayError
from lumenray.service import accounts, jobs, scenes
from lumenray.service.database import Database
from lumenray.service.refusals import RefusalError


@pytest.fixture
def served(tmp_path):
    made = Served(tmp_path)
    yield made
    made.database.close()


def test_tokens_are_kept_as_hashes_and_can_be_revoked(served, tmp_path):
    token = accounts.add_token(served.database, served.user)
    assert accounts.user_of_token(served.database, token) == served.user
    assert accounts.user_of_token(served.database, token[:-1]) is None
    written = b"".join(path.read_bytes() for path in tmp_path.glob("service.sqlite*"))
    assert token.encode() not in written
    assert accounts.revoke_tokens(served.database, served.user) == 1
    assert accounts.user_of_token(served.database, token) is None


@pytest.mark.parametrize("name", ["", "  ", "x" * 81, "a\nb", "Ada"])
def test_names_of_users(served, name):
    with pytest.raises(LumenrayError):
        accounts.add_user(served.database, name)


def test_scenes_are_opened_before_other_jobs(served):
    scene = served.add_ready_scene()
    measured = served.submit(scene)
    served.add_scene()
    assert jobs.claim(served.database).kind == jobs.OPEN
    assert jobs.claim(served.database).id == measured.id
    assert jobs.claim(served.database) is None


def test_who_has_many_jobs_does_not_hold_up_others(served):
    other = served.add_user("Bo")
    mine, theirs = served.add_ready_scene(), served.add_ready_scene(other)
    many = [served.submit(mine) for _ in range(3)]
    one = served.submit(theirs, other)
    order = [jobs.claim(served.database).id for _ in range(4)]
    assert order == [many[0].id, one.id, many[1].id, many[2].id]


def test_a_request_that_is_said_again_is_one_job(served):
    scene = served.add_ready_scene()
    first = served.submit(scene, request="once", samples=64)
    assert served.submit(scene, request="once", samples=64).id == first.id
    assert served.submit(scene, request="twice", samples=64).id != first.id
    with pytest.raises(RefusalError) as caught:
        served.submit(scene, request="once", samples=65)
    assert caught.value.code == 409
    other = served.add_user("Bo")
    theirs = served.submit(served.add_ready_scene(other), other, request="once", samples=64)
    assert theirs.id != first.id


def test_equal_requests_at_once_are_one_job(served):
    scene, made = served.add_ready_scene(), []
    together = threading.Barrier(8)

    def submit():
        together.wait()
        made.append(served.submit(scene, request="once").id)

    threads = [threading.Thread(target=submit) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 8
    assert len(set(made)) == 1


def test_each_job_is_claimed_by_one_thread(served):
    scene = served.add_ready_scene()
    wanted = {served.submit(scene).id for _ in range(40)}
    claimed = []

    def claim_all():
        while (job := jobs.claim(served.database)) is not None:
            claimed.append(job.id)

    threads = [threading.Thread(target=claim_all) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(claimed) == sorted(wanted)


def test_a_job_ends_once(served):
    served.submit(served.add_ready_scene())
    job = jobs.claim(served.database)
    assert jobs.end(served.database, job, jobs.DONE, "", 0, 10)
    assert not jobs.end(served.database, job, jobs.FAILED, "late")
    assert jobs.find_job(served.database, served.user, job.id).state == jobs.DONE


def test_what_waits_is_cancelled_at_once_and_never_claimed(served):
    job = served.submit(served.add_ready_scene())
    assert jobs.cancel(served.database, served.user, job.id).state == jobs.CANCELLED
    assert jobs.claim(served.database) is None
    assert jobs.cancel(served.database, served.user, job.id).state == jobs.CANCELLED


def test_quotas_of_jobs_and_disk(tmp_path):
    served = Served(tmp_path, quota=accounts.Quota(jobs=2, disk=1000))
    scene = served.add_ready_scene()
    first = served.submit(scene)
    served.submit(scene)
    with pytest.raises(RefusalError) as caught:
        served.submit(scene)
    assert caught.value.code == 429
    assert jobs.claim(served.database).id == first.id
    jobs.end(served.database, first, jobs.DONE, "", 0, 993)
    assert jobs.disk_of(served.database, served.user) == 1000
    with pytest.raises(RefusalError) as caught:
        served.submit(scene)
    assert caught.value.code == 413
    served.database.close()


def test_others_have_no_way_to_a_users_things(served):
    other = served.add_user("Bo")
    scene = served.add_ready_scene()
    job = served.submit(scene)
    for ask in (
        lambda: scenes.find_scene(served.database, other, scene.id),
        lambda: scenes.change_edits(served.database, other, scene.id, {}, ()),
        lambda: scenes.remove_scene(served.database, served.folders, other, scene.id),
        lambda: served.submit(scene, other),
        lambda: jobs.find_job(served.database, other, job.id),
        lambda: jobs.cancel(served.database, other, job.id),
        lambda: jobs.remove_job(served.database, served.folders, other, job.id),
    ):
        with pytest.raises(RefusalError) as caught:
            ask()
        assert caught.value.code == 404
    assert scenes.scenes_of(served.database, other) == []
    assert jobs.jobs_of(served.database, other) == []
    assert jobs.find_job(served.database, served.user, job.id).state == jobs.QUEUED


def test_edits_are_kept_with_the_job_that_they_were_ordered_for(served):
    scene = served.add_ready_scene()
    edits = {"lights": {"Lamp": {"flux": 900}}, "hidden": ["Chair", "Chair"], "materials": {}}
    changed = scenes.change_edits(served.database, served.user, scene.id, edits, ())
    assert changed.edits == {"lights": {"Lamp": {"flux": 900}}, "hidden": ["Chair"]}
    assert changed.revision == scene.revision + 1
    job = served.submit(scene)
    scenes.change_edits(served.database, served.user, scene.id, {}, ())
    assert jobs.find_job(served.database, served.user, job.id).edits == changed.edits
    assert served.submit(scene).edits == {}


def test_edits_of_what_is_not_there_are_refused(served):
    scene = served.add_ready_scene()
    with pytest.raises(RefusalError, match="no light 'Moon'") as caught:
        scenes.change_edits(served.database, served.user, scene.id, {"lights": {"Moon": {}}}, ())
    assert caught.value.code == 400


def test_a_scene_with_a_running_job_stays(served):
    scene = served.add_ready_scene()
    served.submit(scene)
    job = jobs.claim(served.database)
    with pytest.raises(RefusalError) as caught:
        scenes.remove_scene(served.database, served.folders, served.user, scene.id)
    assert caught.value.code == 409
    jobs.end(served.database, job, jobs.DONE, "", 0, 1)
    results = served.folders.results(served.user.id, job.id)
    results.mkdir(parents=True)
    scenes.remove_scene(served.database, served.folders, served.user, scene.id)
    assert not results.exists()
    assert not served.folders.scene(served.user.id, scene.id).exists()
    assert jobs.jobs_of(served.database, served.user) == []


def test_a_database_of_another_version_is_refused(served, tmp_path):
    with served.database.change() as connection:
        connection.execute("pragma user_version = 7")
    with pytest.raises(LumenrayError, match="version 7, expected 1"):
        Database(tmp_path / "service.sqlite")


def test_what_is_no_database_is_refused(tmp_path):
    (tmp_path / "service.sqlite").write_bytes(b"something else" * 100)
    with pytest.raises(LumenrayError, match="is no database"):
        Database(tmp_path / "service.sqlite")


def test_a_change_that_fails_changes_nothing(served):
    scene = served.add_ready_scene()
    with pytest.raises(ZeroDivisionError), served.database.change() as connection:
        connection.execute("delete from scenes")
        raise ZeroDivisionError
    assert scenes.find_scene(served.database, served.user, scene.id).content == CONTENT
