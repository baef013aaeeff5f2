"""Messages between Blender and the engine: what passes, what does not, and what garbage does."""

import json
import mmap
import os
import random
import socket
from collections import namedtuple
from dataclasses import dataclass, fields
from multiprocessing import AuthenticationError
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import pytest
from workers import open_files, room, shared_memory

from lumenray.engine.accuracy.stopping import Progress, StopRule
from lumenray.engine.errors import CodecError, FileFormatError, LumenrayError
from lumenray.engine.scene.camera import Projection
from lumenray.engine.scene.material import Diffuse, Emission, Material, Mix
from lumenray.engine.scene.mesh import Geometry
from lumenray.engine.scene.scene import Attachment, SceneDelta
from lumenray.engine.scene.spectrum import Rgb, Tabulated
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.views import Display, DisplayMode
from lumenray.engine.worker import channel, codec, faults, memory


def block_of(parts, size):
    data = bytearray(size)
    for offset, array in parts:
        data[offset : offset + array.nbytes] = array.tobytes()
    return bytes(data)


def carry(value):
    """Send a value through the codec alone."""
    tree, parts, size = codec.encode(value)
    return codec.decode(codec.from_text(codec.to_text(tree)), block_of(parts, size))


def same(a, b):
    """Whether two values are alike in type and content."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, frozenset):
        return a == b
    return repr(a) == repr(b)


PLAIN = [
    None, True, 0, -(1 << 70), 0.1, -0.0, 1e-320, float("inf"), float("nan"), "", "ä\n\ud800", [], (),
    {}, [1, (2, [3.0]), {"a": (None,)}], {"tuple": ["list"]}, ["list"], ("record", "Mesh"),
    np.float32(0.1), np.bool_(True), np.int64(-5), Projection.PERSPECTIVE, DisplayMode.PICTURE,
    frozenset(), frozenset({"b", "a"}), StopRule(samples=3), Progress(0.5, 3, float("inf"), 1.0, None, "x"), Display(),
]  # fmt: skip


def name(value):
    """Return a test's name for a value, alike in every process: a set's order hangs on its hashes."""
    return f"frozenset({sorted(value)})" if isinstance(value, frozenset) else repr(value)


@pytest.mark.parametrize("value", PLAIN, ids=name)
def test_plain_values_arrive_as_they_were(value):
    assert same(carry(value), value)


@pytest.mark.parametrize("count", [0, 1, 64, 65, 5000])
@pytest.mark.parametrize("kind", ["?", "i1", "u2", "i4", "u8", "f2", "f4", "f8", ">f4"])
def test_arrays_arrive_exactly(count, kind):
    rng = np.random.default_rng(count)
    array = rng.integers(0, 2**16, count).astype(kind)
    got = carry(array)
    assert got.dtype == array.dtype.newbyteorder("<")
    assert np.array_equal(got, array)
    assert not got.flags.writeable


def test_arrays_of_any_layout_arrive():
    base = np.arange(4000.0).reshape(20, 10, 20)
    for array in (base[::-1, ::2], base.T, np.asfortranarray(base), np.array(2.5), base[:0]):
        got = carry(array)
        assert got.shape == array.shape
        assert np.array_equal(got, array)


def test_numbers_that_are_not_ordinary_keep_their_bits():
    odd = np.array([np.nan, -np.inf, -0.0, 5e-324] * 30)
    assert carry(odd).tobytes() == odd.tobytes()


def test_a_whole_delta_arrives():
    texture = ImageTexture(np.random.default_rng(1).random((8, 9, 3), np.float32), name="t")
    table = Tabulated(np.arange(360.0, 830.0), np.ones(470), "measured")
    surface = Mix(Diffuse(texture), Diffuse(Rgb(0.1, 0.2, 0.3)), texture)
    glow = Material("m", "m", surface, Emission(table, 5.0, texture), 3)
    delta = SceneDelta(
        (*room(), glow), ("gone",), (("new", "old"),), (Attachment("lamp", {"radius": 0.1}),)
    )
    got = carry(delta)
    assert same(got, delta)
    pixels = got.changed[-1].surface.first.reflectance.pixels
    assert pixels is got.changed[-1].emission.pattern.pixels


def test_an_array_is_sent_once_per_message():
    array = np.zeros(1000)
    _, parts, size = codec.encode([array, {"again": array}, (array,)])
    assert len(parts) == 1
    assert size == array.nbytes


@dataclass
class Material2:
    id: str = ""


Pair = namedtuple("Pair", "a b")
Impostor = type("Material", (), {"id": "x"})


@pytest.mark.parametrize(
    "value",
    [
        object(), {1: 2}, {1, 2}, frozenset({1}), b"x", 1j, print, Material2(), Impostor(), Path("x"),
        np.array([object()]), np.array(["text"]), np.array([1j]), np.zeros(2, "i4,f4"),
        np.datetime64("2020"), ValueError("x"), Material,
    ],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_what_is_not_known_is_refused_by_the_sender(value):
    with pytest.raises(CodecError, match=r"cannot be sent|no text"):
        codec.encode([value])


def test_endless_nesting_is_refused_on_both_sides():
    value = tree = []
    for _ in range(5000):
        value, tree = [value], ["list", tree]
    with pytest.raises(CodecError):
        codec.encode(value)
    with pytest.raises(CodecError):
        codec.decode(tree)
    with pytest.raises(CodecError):
        codec.from_text(b"[" * 100_000)
    loop = []
    loop.append(loop)
    with pytest.raises(CodecError):
        codec.encode(loop)


BAD = [
    {}, [], [1], ["nothing"], ["list", []], ["tuple", {"a": 1}], ["dict"], ["dict", []],
    ["dict", {}, {}], ["record"], ["record", "Material"], ["record", "Material", {}],
    ["record", "Session", {}], ["record", "Scene", {}], ["record", "__import__", {}],
    ["record", "os.system", {"command": "true"}], ["record", "Rgb", {"red": 1.0, "green": 1.0}],
    ["record", "Rgb", {"red": 1.0, "green": 1.0, "blue": 1.0, "alpha": 1.0}],
    ["record", ["Rgb"], {}], ["enum", "Projection"], ["enum", "Projection", "NONE"],
    ["enum", "Projection", "__class__"], ["enum", "Signals", "SIGKILL"],
    ["array"], ["array", "<f8", [2]], ["array", "<f8", [2], None], ["array", "<f8", [2], True],
    ["array", "<f8", [2], -8], ["array", "<f8", [2], 1000], ["array", "<f8", [126], 0],
    ["array", "<f8", [1 << 61], 0], ["array", "<f8", [1 << 62, 4], 0], ["array", "<f8", [-1], 0],
    ["array", "<f8", [True], 0], ["array", "<f8", [1.0], 0], ["array", "<f8", [1] * 40, 0],
    ["array", "<f8", [0, 1 << 63], 0], ["array", "|O", [2], 0], ["array", "O", [2], 0],
    ["array", "<U4", [2], 0], ["array", "f8", [2], 0], ["array", ">f8", [2], 0],
    ["array", "<f8", [10**30], 0], ["array", "<f8", [2], 10**30],
    ["array", "<f8", [2], "AAAA"], ["array", "<f8", [1], "!"], ["array", "<f8", [1], "ä"],
    ["array", "<f8", [1 << 40], ""], ["array", "|i1", [66], "A" * 88],
    ["number"], ["number", "<f8", [1], "AAAAAAAAAAA="], ["number", "<f8", [], "AAAA"],
    ["number", "<f8", [], 0], ["names", 1], ["names", ["list"]],
]  # fmt: skip


@pytest.mark.parametrize("tree", BAD, ids=lambda tree: json.dumps(tree)[:60])
def test_what_is_no_value_is_refused_by_the_receiver(tree):
    with pytest.raises(CodecError):
        codec.decode(tree, bytes(1000))


def test_a_record_that_makes_no_sense_is_refused_in_its_own_words():
    tree, _, _ = codec.encode(StopRule(samples=3))
    tree[2]["samples"] = None
    with pytest.raises(LumenrayError, match="no stopping rule"):
        codec.decode(tree)
    tree[2]["samples"] = ["list"]
    with pytest.raises(CodecError, match="cannot be"):
        codec.decode(tree)


def test_garbled_messages_are_refused_or_read_but_nothing_else():
    """A few thousand changed, cut and spliced texts."""
    rng = random.Random(7)  # noqa: S311
    geometry = Geometry("g", np.zeros((90, 3)), np.zeros((30, 3), "i4"), np.zeros(30, "i4"))
    delta = SceneDelta((*room(), geometry), ("gone",))
    tree, parts, size = codec.encode((delta, Projection.PERSPECTIVE, np.float32(1.0), {"a": [1]}))
    text, block = codec.to_text(tree), block_of(parts, size)
    refused = 0
    for _ in range(3000):
        bad = bytearray(text)
        for _ in range(rng.randint(1, 4)):
            place = rng.randrange(len(bad))
            match rng.randrange(4):
                case 0:
                    bad[place] = rng.randrange(256)
                case 1:
                    del bad[place : place + rng.randint(1, 40)]
                case 2:
                    bad[place:place] = rng.choice(
                        [b"9", b"-", b"[", b"]", b'"', b"999999999", b"null"]
                    )
                case 3:
                    other = rng.randrange(len(bad))
                    bad[place:place] = bad[other : other + rng.randint(1, 40)]
        try:
            codec.decode(codec.from_text(bytes(bad)), block[: rng.randint(0, len(block))])
        except LumenrayError:
            refused += 1
    assert refused > 2000


def pair():
    ends = [Connection(end.detach()) for end in socket.socketpair()]
    return [channel.Channel(end) for end in ends]


@pytest.fixture
def line():
    ends = pair()
    yield ends
    for end in ends:
        end.close()


def receive(end):
    message = end.receive(10.0)
    assert message is not None
    return message


def mappings():
    return sum("memfd:lumenray" in row for row in Path("/proc/self/maps").read_text().splitlines())


def test_large_arrays_are_mapped_and_live_as_long_as_they_are_used(line):
    array = np.random.default_rng(2).random(1 << 18)
    line[0].send({"kind": "x"}, {"a": array, "b": array[:1000].copy()})
    body = receive(line[1]).body
    a, b = body["a"], body["b"]
    assert np.array_equal(a, array)
    assert isinstance(_owner(a), mmap.mmap)
    assert not a.flags.writeable
    with pytest.raises(ValueError, match="WRITEABLE"):
        a.flags.writeable = True
    del body, a
    assert mappings() == 1
    assert np.array_equal(b, array[:1000])
    del b
    assert mappings() == 0


def _owner(array):
    owner = array
    while isinstance(owner, np.ndarray):
        owner = owner.base
    return owner.obj if isinstance(owner, memoryview) else owner


def test_both_ends_may_send_much_at_the_same_time(line):
    big = np.zeros(1 << 17)
    long = "x" * 200_000
    for number in range(40):
        for end in line:
            end.send({"number": number}, [long, big])
    for end in line:
        assert [receive(end).head["number"] for _ in range(40)] == list(range(40))


def test_nothing_is_left_of_messages_that_nobody_read():
    before, files = shared_memory(), open_files()
    for _ in range(5):
        ends = pair()
        for _ in range(50):
            ends[0].send({}, np.zeros(1 << 15))
        for end in reversed(ends):
            end.close()
        ends[0].send({}, np.zeros(1 << 15))
    assert open_files() == files
    assert shared_memory() == before


def test_many_small_blocks_hold_no_files(line):
    kept = []
    files = open_files()
    for _ in range(200):
        line[0].send({}, np.zeros(1000))
        kept.append(receive(line[1]).body)
    assert open_files() <= files + 1


def test_a_body_that_cannot_be_read_still_has_its_head(line):
    line[0].send({"number": 5}, [1])
    raw = line[1]._connection.recv_bytes()
    line[0]._connection.send_bytes(raw.replace(b'["list",1]', b'["evil",1]'))
    message = receive(line[1])
    assert message.head == {"number": 5}
    assert isinstance(message.fault, CodecError)


@pytest.mark.parametrize("data", [b"", b"\0", bytes(19), bytes(19) + b"{}", bytes(19) + b"[1,2]"])
def test_what_is_no_message_is_refused(line, data):
    line[0]._connection.send_bytes(data)
    with pytest.raises(CodecError):
        line[1].receive(5.0)


def test_a_block_that_claims_too_much_is_not_mapped(line):
    frame = channel._FRAME.pack(channel._WITH_BLOCK, 1 << 30, 1, 0)
    for size, seal in ((4096, True), (1 << 30, False)):
        handle = os.memfd_create("lie", os.MFD_ALLOW_SEALING)
        os.ftruncate(handle, size)
        if seal:
            import fcntl

            fcntl.fcntl(handle, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK)
        line[0]._connection.send_bytes(frame + b'[{"a":1},null]')
        socket.send_fds(line[0]._socket, [b"\0"], [handle])
        os.close(handle)
        message = receive(line[1])
        assert message.head == {"a": 1}
        assert isinstance(message.fault, CodecError)
    for handle in (os.open("/dev/null", os.O_RDONLY), os.open(__file__, os.O_RDONLY)):
        with pytest.raises(ValueError, match="a block"):
            memory.open_handle(handle, 10)


def test_blocks_without_a_sealed_file_work_too():
    """What systems other than Linux use, as far as it runs here."""
    before = shared_memory()
    array = np.arange(1 << 18, dtype=np.float64)
    block = memory.make_unlinked([(64, array)], 64 + array.nbytes)
    assert shared_memory() == before
    mapped = memory._map(block.handle, block.size)
    block.close()
    assert np.array_equal(np.frombuffer(mapped, np.float64, offset=64), array)


def test_both_ends_have_to_know_the_key():
    import threading

    for other, fits in ((b"a" * 32, True), (b"b" * 32, False)):
        ours, theirs = (Connection(end.detach()) for end in socket.socketpair())
        failed = []

        def answer(theirs=theirs, other=other, failed=failed):
            try:
                channel.prove(theirs, other, is_host=False)
            except (AuthenticationError, EOFError) as error:
                failed.append(error)
            finally:
                theirs.close()

        thread = threading.Thread(target=answer)
        thread.start()
        if fits:
            channel.prove(ours, b"a" * 32, is_host=True)
        else:
            with pytest.raises(AuthenticationError):
                channel.prove(ours, b"a" * 32, is_host=True)
        ours.close()
        thread.join(5.0)
        assert bool(failed) is not fits


def test_errors_arrive_with_their_class_and_words():
    error = FileFormatError("a.ies", "no lamp", 3)
    got = faults.rebuild(*faults.describe(error, "render"))
    assert type(got) is FileFormatError
    assert str(got) == str(error)
    assert (got.path, got.line) == ("a.ies", 3)
    got = faults.rebuild("os.system", "text", {"args": [1]})
    assert type(got).__name__ == "EngineFault"
    assert str(got) == "text"
