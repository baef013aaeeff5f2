"""What is answered over HTTP, to whom, and what is refused."""

import asyncio
import contextlib
import json
import socket
import threading
import time

import pytest
from served import CONTENT, Served
from served_web import Client, listening

from lumenray.blender_addon import scene_edits
from lumenray.engine.errors import LumenrayError
from lumenray.service import accounts, jobs
from lumenray.service.web import requests
from lumenray.service.web.app import HEADERS, ROOT, ROUTES
from lumenray.service.web.server import (
    LARGEST_HEAD,
    Address,
    check_address,
    open_folder,
)


@pytest.fixture
def served(tmp_path):
    made = Served(tmp_path)
    yield made
    made.database.close()


@pytest.fixture
def ada(served):
    return Client(served, served.user)


@pytest.fixture
def bo(served):
    return Client(served, served.add_user("Bo"))


def done_job(served, scene, files):
    """A job that has ended with files."""
    job = served.submit(scene)
    assert jobs.claim(served.database).id == job.id
    results = served.folders.results(served.user.id, job.id)
    for name, content in files.items():
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        (results / name).write_bytes(content)
    jobs.end(served.database, job, jobs.DONE, "", 0, 10)
    return job


BODIES = {
    "#/components/schemas/Order": b'{"kind": "measure"}',
    "#/components/schemas/Edits": b'{"hidden": ["Chair"]}',
}


def requests_of(client, scene, job):
    """Method, path and body of all that the document describes, about these; what it names anew needs a name here, too."""
    names = {"scene": scene.id, "job": job.id, "name": "readings.json"}
    for path, each in client.ask("GET", "/openapi.json").json()["paths"].items():
        for method, told in each.items():
            queries = [
                row["name"] for row in told.get("parameters", ()) if row.get("in") == "query"
            ]
            query = "?name=a" if "name" in queries else ""
            content = told.get("requestBody", {}).get("content", {})
            schema = content.get("application/json", {}).get("schema", {})
            body = BODIES[schema["$ref"]] if schema else b"BLENDER" if content else b""
            yield method.upper(), path.format(**names) + query, body


def test_no_route_answers_without_a_token(served, ada):
    scene = served.add_ready_scene()
    job = done_job(served, scene, {"readings.json": b"{}"})
    for headers in (
        {"X-None": "1"},
        {"Authorization": "Bearer"},
        {"Authorization": "Bearer lumenray_guess"},
        {"Authorization": "Basic " + ada.headers["Authorization"].partition(" ")[2]},
    ):
        for method, path, body in requests_of(ada, scene, job):
            answer = ada.ask(method, path, headers=headers, content=body)
            assert answer.status_code == (200 if path == "/openapi.json" else 401), path
    assert jobs.find_job(served.database, served.user, job.id).state == jobs.DONE


def test_no_route_tells_a_user_of_anothers_things(served, ada, bo):
    """What is another's is answered like what is not there at all, and nothing of it is changed."""
    scene = served.add_ready_scene()
    job = done_job(served, scene, {"readings.json": b"{}"})
    met = 0
    for method, path, body in requests_of(bo, scene, job):
        if scene.id not in path and job.id not in path:
            continue
        own = bo.ask(method, path, content=body)
        other = path.replace(scene.id, "0" * 32).replace(job.id, "0" * 32)
        none = bo.ask(method, other, content=body)
        assert (own.status_code, own.content) == (404, none.content), path
        met += 1
    assert met == sum("{" in path for _, path, _, _ in ROUTES)
    assert bo.ask("GET", f"{ROOT}/scenes").json() == {"scenes": []}
    assert bo.ask("GET", f"{ROOT}/jobs").json() == {"jobs": []}
    assert ada.ask("GET", f"{ROOT}/scenes/{scene.id}").json()["edits"] == {}
    assert len(ada.ask("GET", f"{ROOT}/jobs").json()["jobs"]) == 1


@pytest.mark.parametrize(
    "name",
    [
        "../../job.json", "..%2f..%2fservice.sqlite", "%2e%2e/%2e%2e/lock", "/etc/passwd", "%2fetc%2fpasswd",
        "deep/%2e%2e/readings.json", "readings.json%00", "link", "deep", "", "deep/", "%2e", "%2e%2e",
    ],
)  # fmt: skip
def test_only_listed_files_are_sent(served, ada, name, tmp_path):
    job = done_job(served, served.add_ready_scene(), {"readings.json": b"r", "deep/map.exr": b"m"})
    results = served.folders.results(served.user.id, job.id)
    (results / "link").symlink_to("/etc/passwd")
    answer = ada.ask("GET", f"{ROOT}/jobs/{job.id}/files/{name}")
    assert answer.status_code == 404, answer.content


def test_results_are_sent_as_files_that_no_browser_runs(served, ada):
    files = {"readings.json": b"{}", "deep/map.html": b"<script>"}
    job = done_job(served, served.add_ready_scene(), files)
    listed = ada.ask("GET", f"{ROOT}/jobs/{job.id}/files").json()["files"]
    assert {each["name"]: each["bytes"] for each in listed} == {
        "readings.json": 2,
        "deep/map.html": 8,
    }
    answer = ada.ask("GET", f"{ROOT}/jobs/{job.id}/files/deep/map.html")
    assert answer.content == b"<script>"
    assert answer.headers["content-disposition"].startswith("attachment")
    for name, value in HEADERS.items():
        assert answer.headers[name] == value


def test_uploads_are_known_by_their_first_bytes(served, ada, tmp_path):
    path = f"{ROOT}/scenes?name=Room"
    for content in (b"BLENDER-v300", b"\x28\xb5\x2f\xfd....", b"\x1f\x8b....", b"glTF\x02\0\0\0"):
        answer = ada.ask("POST", path, content=content)
        assert (answer.status_code, answer.json()["state"]) == (201, "opening")
    for content in (b"", b"BLEND", b"PK\x03\x04zip", b"<html>", b"{}"):
        assert ada.ask("POST", path, content=content).status_code == 415
    kept = list((served.folders.user(served.user.id) / "scenes").iterdir())
    assert len(kept) == 4


@pytest.mark.parametrize("name", ["", "%20", "x" * 121, "a%0ab", "%00"])
def test_scenes_need_a_name_of_printable_characters(ada, name):
    assert ada.ask("POST", f"{ROOT}/scenes?name={name}", content=b"BLENDER").status_code == 400


def test_an_upload_has_no_more_room_than_its_user(tmp_path):
    served = Served(tmp_path, quota=accounts.Quota(disk=1000))
    ada = Client(served, served.user)
    path = f"{ROOT}/scenes?name=Room"

    async def endless():
        while True:
            yield b"BLENDER" * 10

    for content in (b"BLENDER" + bytes(1000), endless()):
        assert ada.ask("POST", path, content=content).status_code == 413
    folder = served.folders.user(served.user.id) / "scenes"
    assert not list(folder.iterdir())
    assert ada.ask("POST", path, content=b"BLENDER" + bytes(993)).status_code == 201
    assert ada.ask("POST", path, content=b"BLENDER").status_code == 413
    served.database.close()


def test_a_body_that_stops_coming_is_given_up(served, ada, monkeypatch):
    monkeypatch.setattr(requests, "CHUNK_PATIENCE", 0.1)

    async def stopping():
        yield b"BLENDER"
        await asyncio.sleep(30)
        yield b"more"

    answer = ada.ask("POST", f"{ROOT}/scenes?name=Room", content=stopping())
    assert answer.status_code == 408
    assert answer.headers["connection"] == "close"


def test_a_body_that_comes_too_slowly_is_given_up(ada, monkeypatch):
    monkeypatch.setattr(requests, "CHUNK_PATIENCE", 0.2)

    async def dripping():
        for _ in range(100):
            yield b"B"
            await asyncio.sleep(0.05)

    assert ada.ask("POST", f"{ROOT}/scenes?name=Room", content=dripping()).status_code == 408


@pytest.mark.parametrize(
    ("order", "told"),
    [
        ([], "'kind' and 'options'"),
        ({"kind": "measure", "more": 1}, "'kind' and 'options'"),
        ({}, "'kind'"),
        ({"kind": "probe"}, "'kind'"),
        ({"kind": ["measure"]}, "'kind'"),
        ({"kind": "measure", "options": []}, "'options'"),
        ({"kind": "measure", "options": {"output": "x"}}, "no option 'output'"),
        ({"kind": "measure", "options": {"samples": 0}}, "a whole number from 1"),
        ({"kind": "measure", "options": {"samples": True}}, "a whole number"),
        ({"kind": "measure", "options": {"samples": 1.5}}, "a whole number"),
        ({"kind": "measure", "options": {"error": float("nan")}}, "a number from"),
        ({"kind": "bake", "options": {"objects": ["a,--save=/x"]}}, "without commas"),
        ({"kind": "bake", "options": {"objects": []}}, "a list of 1"),
        ({"kind": "bake", "options": {"objects": ["a\nb"]}}, "a list of 1"),
        ({"kind": "bake", "options": {"layers": "all"}}, "one of none, groups, each"),
        ({"kind": "render", "options": {"size": "640x400 --denoise"}}, "WIDTHxHEIGHT"),
        ({"kind": "render", "options": {"size": "99999x99999"}}, "WIDTHxHEIGHT"),
        ({"kind": "daylight", "options": {}}, "needs the option 'floor'"),
        ({"kind": "bake", "options": {"require": "office.writing --save=x"}}, "a requirement such as"),
        ({"kind": "measure", "options": {"require": "../office.writing"}}, "a requirement such as"),
    ],
)  # fmt: skip
def test_orders_that_are_not_understood(served, ada, order, told):
    path = f"{ROOT}/scenes/{served.add_ready_scene().id}/jobs"
    answer = ada.ask("POST", path, content=json.dumps(order).encode())
    assert answer.status_code == 400
    assert told in answer.json()["error"]


def test_files_of_spectra_are_read_before_they_are_kept(served, ada):
    scene = served.add_ready_scene()
    path = f"{ROOT}/scenes/{scene.id}/edits"
    spectrum = {"file": "lamp.csv", "text": "nm,W\n400,1\n500,2\n"}
    kept = {"lights": {"Lamp": {"spectrum": spectrum}}}
    assert ada.ask("PUT", path, json=kept).json()["edits"] == kept
    broken = {"lights": {"Lamp": {"spectrum": spectrum | {"text": "400 1\n500 dark"}}}}
    answer = ada.ask("PUT", path, json=broken)
    assert answer.status_code == 400
    assert "lamp.csv, line 2" in answer.json()["error"]
    # Every job keeps the edits that it was ordered with, which take room.
    before = jobs.disk_of(served.database, served.user)
    served.submit(scene)
    assert jobs.disk_of(served.database, served.user) > before + len(spectrum["text"])


@pytest.mark.parametrize("body", [b"", b"{", b"\xff", b"[" * 100_000])
def test_bodies_that_are_no_json(served, ada, body):
    path = f"{ROOT}/scenes/{served.add_ready_scene().id}/jobs"
    assert ada.ask("POST", path, content=body).status_code == 400
    assert ada.ask("POST", path, content=bytes(2 << 20)).status_code == 413


def test_a_request_that_is_said_again_is_one_job(served, ada):
    path = f"{ROOT}/scenes/{served.add_ready_scene().id}/jobs"
    headers = ada.headers | {"Idempotency-Key": "7"}
    order = {"kind": "measure", "options": {"error": 0.01}}
    first, second = (ada.ask("POST", path, headers=headers, json=order).json() for _ in range(2))
    assert first["id"] == second["id"]
    told = ada.ask("GET", f"{ROOT}/jobs/{first['id']}").json()
    assert (told["state"], told["options"]) == ("queued", {"error": 0.01})
    assert ada.ask("POST", f"{ROOT}/jobs/{first['id']}/cancel").json()["state"] == "cancelled"
    assert ada.ask("DELETE", f"{ROOT}/jobs/{first['id']}").status_code == 204
    assert ada.ask("GET", f"{ROOT}/jobs/{first['id']}").status_code == 404


def test_edits_are_answered_as_they_are_kept(served, ada):
    path = f"{ROOT}/scenes/{served.add_ready_scene().id}"
    edits = {"lights": {"Lamp": {"dimming": 0.5}}, "materials": {"Wall": "wall_white_matt"}}
    assert ada.ask("PUT", f"{path}/edits", json=edits).json() == {"edits": edits, "revision": 1}
    told = ada.ask("GET", path).json()
    assert (told["edits"], told["content"]) == (edits, CONTENT)
    names = {each["name"] for each in ada.ask("GET", f"{ROOT}/materials").json()["materials"]}
    assert "wall_white_matt" in names
    spectra = {each["name"]: each for each in ada.ask("GET", f"{ROOT}/spectra").json()["spectra"]}
    # CIE 15:2018, table 12.
    assert spectra["LED-B3"]["temperature"] == pytest.approx(4103, abs=1)
    assert spectra["LED-B3"]["rendering"] == pytest.approx(85, abs=1)
    keys = {each["key"] for each in ada.ask("GET", f"{ROOT}/requirements").json()["requirements"]}
    assert "office.writing" in keys


def test_weather_files_take_the_place_of_those_before(served, ada):
    scene = served.add_ready_scene()
    path, before = f"{ROOT}/scenes/{scene.id}", scene.bytes
    for size in (5, 3):
        answer = ada.ask("PUT", f"{path}/weather?name=town.epw", content=bytes(size))
        assert answer.status_code == 204
    told = ada.ask("GET", path).json()
    assert (told["weather"], told["bytes"]) == ("town.epw", before + 3)
    assert ada.ask("PUT", f"{path}/weather", content=b"x").status_code == 400


def test_progress_is_told_until_the_end(served, ada):
    job = served.submit(served.add_ready_scene())

    def work():
        claimed = jobs.claim(served.database)
        served.changes.tell(served.user.id)
        time.sleep(0.6)
        jobs.end(served.database, claimed, jobs.DONE, "", 0, 1)
        served.changes.tell(served.user.id)

    worker = threading.Timer(0.3, work)
    worker.start()
    text = ada.ask("GET", f"{ROOT}/jobs/{job.id}/events").text
    worker.join()
    told = [json.loads(line.removeprefix("data: ")) for line in text.splitlines() if "data" in line]
    states = [each["state"] for each in told]
    # News that follow each other sooner than a listener is told of them are one.
    assert states in (["queued", "running", "done"], ["queued", "done"])


def test_the_document_describes_every_route(ada):
    document = ada.ask("GET", "/openapi.json").json()
    described = {
        (method.upper(), path) for path, each in document["paths"].items() for method in each
    }
    assert described == {(method, path.replace(":path", "")) for method, path, _, _ in ROUTES}
    for method, path in described:
        told = document["paths"][path][method.lower()]
        assert ("security" in told) == (path != "/openapi.json")
        named = {each["name"] for each in told.get("parameters", ()) if each["in"] == "path"}
        assert named == {part[1:-1] for part in path.split("/") if part.startswith("{")}
    kinds = document["components"]["schemas"]["Order"]["oneOf"]
    assert [each["properties"]["kind"]["const"] for each in kinds] == [
        "render",
        "bake",
        "measure",
        "daylight",
    ]


def test_the_document_has_the_words_by_which_edits_are_checked(ada):
    document = ada.ask("GET", "/openapi.json").json()
    edits = document["components"]["schemas"]["Edits"]["properties"]
    assert set(edits) == set(scene_edits.PARTS)
    light = edits["lights"]["additionalProperties"]["properties"]
    assert set(light) == set(scene_edits.LIGHT)
    named, file = light["spectrum"]["oneOf"]
    listed = ada.ask("GET", f"{ROOT}/spectra").json()["spectra"]
    assert named["enum"] == [each["name"] for each in listed]
    assert set(file["required"]) == {"file", "text"}


# ---- the door ----


@pytest.mark.parametrize("host", ["0.0.0.0", "192.0.2.1", "::"])  # noqa: S104 - refused
def test_other_machines_are_answered_with_tls_alone(host, tmp_path):
    with pytest.raises(LumenrayError, match="--certificate"):
        check_address(Address(host))
    check_address(Address(host, certificate=tmp_path))
    check_address(Address(host, is_behind_proxy=True))
    check_address(Address("127.0.0.1"))


def test_a_folder_has_one_service(tmp_path):
    with (
        open_folder(tmp_path),
        pytest.raises(LumenrayError, match="another service"),
        open_folder(tmp_path),
    ):
        pass


@pytest.fixture
def line(served, ada, monkeypatch):
    """Address of a server with little patience."""
    monkeypatch.setattr("lumenray.service.web.server.HEAD_PATIENCE", 0.5)
    with listening(ada.app) as address:
        yield address


def test_a_head_that_does_not_come_is_not_waited_for(line):
    with socket.create_connection(line) as silent, socket.create_connection(line) as slow:
        begin = time.monotonic()
        for connection in (silent, slow):
            connection.settimeout(10)
        slow.sendall(b"GET /openapi.json HTTP/1.1\r\nHost: a\r\n")
        assert silent.recv(10) == b""
        # A connection that is broken off may be told by a reset.
        with contextlib.suppress(ConnectionResetError):
            assert slow.recv(10) == b""
        assert time.monotonic() - begin < 5.0


def test_a_second_head_on_a_line_is_not_waited_for_either(line):
    with socket.create_connection(line) as connection:
        connection.settimeout(10)
        connection.sendall(b"GET /api/v1/me HTTP/1.1\r\nHost: a\r\n\r\n")
        first = b""
        while not first.endswith(b"}"):
            first += connection.recv(4096)
        assert b"401" in first
        connection.sendall(b"GET /api")
        begin = time.monotonic()
        with contextlib.suppress(ConnectionResetError):
            assert connection.recv(10) == b""
        assert time.monotonic() - begin < 5.0


@pytest.mark.parametrize(
    "head",
    [
        b"GET / HTTP/1.1\r\nHost: a\r\nX: " + b"y" * (2 * LARGEST_HEAD) + b"\r\n",
        b"GET /" + b"y" * (2 * LARGEST_HEAD),
        b"GET / HTTP/1.1\r\nHost: a\r\n" + b"X: y\r\n" * LARGEST_HEAD,
    ],
    ids=["header", "path", "headers"],
)
def test_large_heads_are_refused(line, head):
    with socket.create_connection(line) as connection:
        connection.settimeout(10)
        connection.sendall(head)
        with contextlib.suppress(ConnectionResetError):
            assert b"400" in connection.recv(4096)
