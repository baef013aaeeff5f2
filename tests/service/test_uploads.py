"""Uploads over a line, at once, without an end and too slowly: what they take of the machine, and what is answered."""

import asyncio
import contextlib
import select
import socket
import threading
import time

import psutil
import pytest
from served import Served
from served_web import Client, listening

from lumenray.service import accounts
from lumenray.service.web import app, requests
from lumenray.service.web.app import LARGEST_UPLOAD, PAGE, ROOT

PATH = f"{ROOT}/scenes?name=Room"


@pytest.fixture
def served(tmp_path):
    made = Served(tmp_path)
    yield made
    made.database.close()


@pytest.fixture
def ada(served):
    return Client(served, served.user)


def kept(served):
    folder = served.folders.user(served.user.id) / "scenes"
    return [path for path in folder.rglob("*") if path.is_file()] if folder.exists() else []


def send(address, head, parts):
    """Send a head and parts until something is answered; return the answer and how much was sent."""
    with socket.create_connection(address, timeout=60) as line:
        line.sendall(f"POST {PATH} HTTP/1.1\r\nHost: a\r\n{head}\r\n\r\n".encode())
        sent = 0
        for part in parts:
            if select.select([line], [], [], 0)[0]:
                break
            line.sendall(part)
            sent += len(part)
        answer = b""
        while b"}" not in answer and (more := line.recv(4096)):
            answer += more
    return answer, sent


def endless(size):
    """Chunks of a body that has no end and begins like a scene."""
    yield b"7\r\nBLENDER\r\n"
    part = b"%x\r\n%b\r\n" % (size, bytes(size))
    while True:
        yield part


@contextlib.contextmanager
def watching(served):
    """The most that was in the folder and in this process' memory meanwhile, beyond what was there before. [byte]"""
    process, end = psutil.Process(), threading.Event()
    before = process.memory_info().rss
    most = {"disk": 0, "memory": 0}

    def watch():
        while not end.wait(0.02):
            with contextlib.suppress(FileNotFoundError):
                most["disk"] = max(most["disk"], sum(each.stat().st_size for each in kept(served)))
            most["memory"] = max(most["memory"], process.memory_info().rss - before)

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        yield most
    finally:
        end.set()
        watcher.join()


def is_refused_at(limit, served, ada, size):
    """An endless upload is refused once it is larger than it may be, with an answer that its sender reads."""
    authorised = f"Authorization: {ada.headers['Authorization']}\r\n"
    with listening(ada.app) as address, watching(served) as most:
        answer, sent = send(address, f"{authorised}Transfer-Encoding: chunked", endless(size))
    assert answer.startswith(b"HTTP/1.1 413 ")
    assert f"larger than the {limit} bytes".encode() in answer
    assert sent > limit
    assert most["disk"] <= limit
    assert most["memory"] < 128 << 20
    assert kept(served) == []


def test_an_endless_upload_is_refused_at_its_limit(served, ada, monkeypatch):
    monkeypatch.setattr(app, "LARGEST_UPLOAD", 3 << 20)
    is_refused_at(3 << 20, served, ada, 1 << 16)


@pytest.mark.slow
def test_an_upload_of_more_than_two_gigabytes_is_refused_at_its_limit(served, ada):
    assert LARGEST_UPLOAD == 2 << 30
    is_refused_at(LARGEST_UPLOAD, served, ada, 1 << 20)


def test_an_upload_that_says_how_large_it_is_is_refused_before_it_comes(served, ada):
    head = f"Authorization: {ada.headers['Authorization']}\r\nContent-Length: {LARGEST_UPLOAD + 1}"
    with listening(ada.app) as address:
        answer, sent = send(address, head, [])
    assert answer.startswith(b"HTTP/1.1 413 ")
    assert (sent, kept(served)) == (0, [])


def test_uploads_at_once_have_no_more_room_together_than_their_user(tmp_path):
    served = Served(tmp_path, quota=accounts.Quota(disk=1000))
    ada = Client(served, served.user)

    async def upload_two():
        begun, half, refused = asyncio.Event(), asyncio.Event(), asyncio.Event()

        async def first():
            await begun.wait()
            yield b"BLENDER" + bytes(593)
            half.set()
            await refused.wait()
            yield bytes(100)

        async def second():
            yield b"BLENDER"
            begun.set()
            await half.wait()
            yield bytes(394)

        one = asyncio.create_task(ada.ask_soon("POST", PATH, content=first()))
        other = await ada.ask_soon("POST", PATH, content=second())
        told = (await ada.ask_soon("GET", f"{ROOT}/me")).json()["largest_upload"]
        refused.set()
        return await one, other, told

    one, other, told = asyncio.run(upload_two())
    assert other.status_code == 413
    assert "take all the room" in other.json()["error"]
    assert told == 400
    assert one.status_code == 201
    assert [path.stat().st_size for path in kept(served)] == [700]
    # What is done with counts once.
    assert ada.ask("GET", f"{ROOT}/me").json()["largest_upload"] == 300
    served.database.close()


def test_uploads_leave_room_on_the_disk(served, ada, monkeypatch):
    monkeypatch.setattr("lumenray.service.arrivals.LEAST_FREE", 1 << 60)
    answer = ada.ask("POST", PATH, content=b"BLENDER")
    assert answer.status_code == 507
    assert kept(served) == []


def test_a_body_that_drips_is_given_up(served, ada, monkeypatch):
    monkeypatch.setattr(requests, "CHUNK_PATIENCE", 0.3)

    def dripping():
        yield b"BLENDER"
        for _ in range(200):
            time.sleep(0.05)
            yield b"x"

    head = f"Authorization: {ada.headers['Authorization']}\r\nContent-Length: 1000"
    with listening(ada.app) as address:
        answer, sent = send(address, head, dripping())
    assert answer.startswith(b"HTTP/1.1 408 ")
    assert sent < 100
    assert kept(served) == []


def test_a_body_of_who_is_not_known_keeps_no_line_open(served, ada, monkeypatch):
    """It is answered at once, and the rest is not listened to for ever, however it comes."""
    monkeypatch.setattr("lumenray.service.web.server.HEAD_PATIENCE", 0.5)
    with listening(ada.app) as address, socket.create_connection(address, timeout=10) as line:
        line.sendall(f"POST {PATH} HTTP/1.1\r\nHost: a\r\nContent-Length: 1000000\r\n\r\n".encode())
        assert line.recv(4096).startswith(b"HTTP/1.1 401 ")
        begin = time.monotonic()
        with pytest.raises(ConnectionError):
            while time.monotonic() < begin + 8.0:
                line.sendall(b"x")
                time.sleep(0.02)
        assert time.monotonic() - begin < 5.0


@pytest.mark.parametrize(("patience", "is_whole"), [(0.3, False), (60.0, True)])
def test_who_does_not_read_an_answer_is_not_waited_for(ada, monkeypatch, patience, is_whole):
    """Who comes to read at last finds all of the answers, or the line closed before their end."""
    monkeypatch.setattr("lumenray.service.web.server.READ_PATIENCE", patience)
    # More than all buffers on the way hold.
    count = 12
    size = (PAGE / "three" / "three.core.js").stat().st_size
    with listening(ada.app) as address, socket.socket() as line:
        line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        line.settimeout(10)
        line.connect(address)
        line.sendall(count * b"GET /page/three/three.core.js HTTP/1.1\r\nHost: a\r\n\r\n")
        time.sleep(1.5)
        read = 0
        with contextlib.suppress(ConnectionError):
            while part := line.recv(1 << 20):
                read += len(part)
                if read > count * size:
                    break
    assert (read > count * size) == is_whole


def test_who_reads_slowly_but_steadily_is_waited_for(served, ada, monkeypatch):
    monkeypatch.setattr("lumenray.service.web.server.READ_PATIENCE", 1.0)
    with listening(ada.app) as address, socket.create_connection(address, timeout=10) as line:
        line.sendall(
            b"GET /page/three/three.core.js HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n"
        )
        answer = b""
        while part := line.recv(1 << 15):
            answer += part
            time.sleep(0.03)
    head, _, body = answer.partition(b"\r\n\r\n")
    (stated,) = [
        each for each in head.lower().split(b"\r\n") if each.startswith(b"content-length:")
    ]
    assert len(body) == int(stated.split(b":")[1])
