"""The shelf of files behind lights and materials: read once, in the background or at once, kept, stopped, found again."""

import threading
import time
from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from lumenray.blender_addon.file_assets import shelf as shelves
from lumenray.blender_addon.file_assets.kind import FileKind, NoFileError, NotReadyError
from lumenray.blender_addon.file_assets.pictures import side_of
from lumenray.blender_addon.file_assets.places import write_copy
from lumenray.blender_addon.raysets.files import RayFiles, ray_files
from lumenray.blender_addon.scattering.files import scattering_files
from lumenray.engine.errors import LumenrayError


@dataclass(eq=False)
class Text:
    """A file of words as it was read."""

    words: list[str]


class Words(FileKind):
    """Files of words, which are read when they are allowed to."""

    noun = "word file"
    under_way = "its words are being read ({share:.0f} %)"
    is_stopped_unwanted = True

    def __init__(self, kept=100, thread=""):
        super().__init__(kept, thread)
        self.allowed, self.begun = threading.Event(), threading.Event()
        self.count = 0

    def read(self, job, data, path, terms, origin=""):
        self.count += 1
        job.size = len(data)
        job.tell(0.25)
        self.begun.set()
        assert self.allowed.wait(30.0)
        if b"?" in data:
            raise LumenrayError(f"{path}: is no word file")
        return self._shelf.shared(data, lambda: Text(data.decode().split()))


def settings(path, owner=1):
    """Return settings that name a file."""
    thing = SimpleNamespace(library=None, session_uid=owner)
    thing.original = thing
    return SimpleNamespace(filepath=str(path), text=None, id_data=thing)


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a file and returns settings that name it."""

    def save(content, name="words.txt", owner=1):
        (tmp_path / name).write_text(content)
        return settings(tmp_path / name, owner)

    return save


@pytest.fixture
def words():
    """Files that are read at once."""
    kind = Words()
    kind.allowed.set()
    return kind


@pytest.fixture
def slow_words():
    """Files that are read on a thread, when they are allowed to."""
    kind = Words(thread="words")
    yield kind
    kind.allowed.set()
    kind.detach()


def test_a_file_is_read_once_until_it_changes_or_is_forgotten(write, words):
    file = write("one two")
    reading = words.obtain(file)
    assert words.obtain(write("one two", "other.txt")) is reading
    count = words.count
    assert words.obtain(file) is reading
    assert words.count == count
    assert words.obtain(write("one two three")).words[2] == "three"
    words.forget(file)
    words.obtain(file)
    assert words.count == count + 2


def test_no_more_is_kept_than_may_be(write):
    words = Words(kept=15)
    words.allowed.set()
    files = [write("ten letter", f"{number}.txt") for number in range(3)]
    for file in files:
        words.obtain(file)
    words.obtain(files[2])
    assert words.count == 3
    words.obtain(files[0])
    assert words.count == 4


def test_a_refused_file_is_refused_in_the_same_words_without_its_path_in_panels(write, words):
    file = write("what?")
    for _ in range(2):
        with pytest.raises(LumenrayError, match=r"words\.txt: is no word file"):
            words.obtain(file)
    assert words.count == 1
    state = words.state_of(file)
    assert (state.name, state.problem) == ("words.txt", "is no word file")
    with pytest.raises(NoFileError, match="no word file is chosen"):
        words.obtain(settings(""))
    assert words.state_of(settings("")).name == ""


def test_a_mistake_of_ours_is_told_as_a_problem_of_the_file(write, words, tmp_path):
    write("")
    (tmp_path / "words.txt").write_bytes(b"\xff")
    problem = words.state_of(settings(tmp_path / "words.txt")).problem
    assert problem.startswith("it cannot be read (UnicodeDecodeError")


def test_panels_go_on_and_are_drawn_anew_when_what_they_show_has_changed(
    write, slow_words, monkeypatch
):
    file, drawn, told = write("one"), [], []
    monkeypatch.setattr(shelves, "redraw", lambda *kinds: drawn.append(kinds))
    with pytest.raises(NotReadyError):
        slow_words.obtain(file, is_patient=False)
    assert slow_words.begun.wait(30.0)
    state = slow_words.state_of(file)
    assert (state.reading, state.share, state.problem) == (None, 0.25, "")
    slow_words.call_when_ready(lambda: told.append(1) or True)
    timer = slow_words._shelf.timer
    for _ in range(3):
        assert timer() is not None
    assert len(drawn) == 1
    assert told == []
    slow_words.allowed.set()
    reading = slow_words.obtain(file)
    assert timer() is None
    assert (len(drawn), told) == (2, [1])
    assert slow_words.state_of(file).reading is reading


def test_what_nobody_asks_for_any_more_is_stopped(write, slow_words):
    files = [write("one", f"{number}.txt") for number in range(4)]
    other = write("two", "other.txt", owner=2)
    for file in (*files, other):
        slow_words.state_of(file)
    left = [key[0] for key in slow_words._shelf._jobs]
    assert left == [files[3].filepath, other.filepath]


def test_who_waits_when_the_add_on_is_taken_off_is_told(write, slow_words):
    first, second = write("one", "1.txt", owner=1), write("two", "2.txt", owner=2)
    slow_words.state_of(first)
    assert slow_words.begun.wait(30.0)
    told = []

    def wait():
        try:
            slow_words.obtain(second)
        except NotReadyError as error:
            told.append(str(error))

    waiting = threading.Thread(target=wait)
    waiting.start()
    until = time.monotonic() + 120.0
    while len(slow_words._shelf._jobs) < 2:
        assert time.monotonic() < until
        time.sleep(0.01)
    threading.Timer(0.1, slow_words.allowed.set).start()
    slow_words.detach()
    waiting.join(30.0)
    assert told == ["its file was not read: stopped"]


def test_renders_leave_blenders_timers_to_its_main_thread(write, slow_words, monkeypatch):
    registered = []
    timers = SimpleNamespace(
        is_registered=registered.__contains__,
        register=lambda function, **_: registered.append(function),
    )
    window = SimpleNamespace(app=SimpleNamespace(background=False, timers=timers))
    file = write("one")
    with monkeypatch.context() as changed:
        changed.setattr(shelves, "bpy", window)
        render = threading.Thread(target=slow_words.state_of, args=(file,))
        render.start()
        render.join(30.0)
        assert registered == []
        slow_words.state_of(file)
        assert registered == [slow_words._shelf.timer]


def test_rays_that_are_to_be_prepared_anew_are_so_whoever_asks_first(write, monkeypatch):
    kind, file, seen = RayFiles(1), write("one"), []
    monkeypatch.setattr(kind._shelf, "forget", lambda path: seen.append(path in kind._fresh))
    kind.forget(file)
    assert seen == [True]


def test_what_was_forgotten_while_it_is_read_holds_nobody_up_when_the_add_on_is_taken_off(write):
    class Endless(Words):
        def read(self, job, data, path, terms, origin=""):
            self.begun.set()
            self.is_stopped = job.stop.wait(5.0)

    kind = Endless(thread="words")
    file = write("one")
    kind.state_of(file)
    assert kind.begun.wait(30.0)
    kind.forget(file)
    kind.detach()
    assert kind.is_stopped


@pytest.mark.parametrize("kind", [ray_files, scattering_files])
@pytest.mark.parametrize("name", ["../../elsewhere", "/elsewhere", "elsewhere"])
def test_names_of_a_library_do_not_lead_out_of_it(kind, name):
    prefix, folder, ending = kind.library
    named = settings(f"{prefix}{name}")
    assert kind.absolute_path(named) == str(folder / f"elsewhere{ending}")
    assert kind.place_of(named) == "From Lumenray's library"
    assert kind.name_of(named) == "elsewhere"


def test_copies_take_nobodys_place(tmp_path):
    paths = [write_copy(data, str(tmp_path / "new"), "paint.txt") for data in (b"1", b"2", b"1")]
    assert [path.name for path in paths] == ["paint.txt", "paint_2.txt", "paint.txt"]
    assert [path.read_bytes() for path in paths] == [b"1", b"2", b"1"]
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(LumenrayError, match="cannot be written"):
        write_copy(b"1", str(tmp_path / "file"), "a.txt")


def test_pictures_have_few_sizes_that_fit():
    widths = [side_of(room) for room in (10.0, 255.9, 256.0, 270.0, 5000.0)]
    assert widths == [160, 224, 256, 256, 480]
