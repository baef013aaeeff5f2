"""Job types for Flamenco: what tasks they are compiled to, without Flamenco."""

from itertools import chain

import pytest
from flamenco import BAKE, RENDER, command_line, compile_job, frames_of

KINDS = {"string", "int32", "float", "bool", "python_expr"}


def words_of(task):
    args = task["commands"][0]["parameters"]["args"]
    return args[args.index("--") + 1 :]


def value(task, option):
    args = task["commands"][0]["parameters"]["args"]
    return args[args.index(option) + 1]


@pytest.mark.parametrize("kind", ["render", "bake"])
def test_settings_are_such_as_flamenco_knows(kind):
    told = compile_job(kind, None)["type"]
    keys = [setting["key"] for setting in told["settings"]]
    assert len(keys) == len(set(keys))
    assert {setting["type"] for setting in told["settings"]} <= KINDS
    allowed = {
        "key", "type", "subtype", "choices", "propargs", "description", "label", "default", "eval", "evalInfo", "visible",
        "required", "editable",
    }  # fmt: skip
    assert set().union(*told["settings"]) <= allowed
    # Whoever compiles a job finds all that the script reads.
    assert set(RENDER if kind == "render" else BAKE) <= set(keys)


@pytest.mark.parametrize(
    ("frames", "size"), [("1-30", 7), ("3, 5-10, 47-60", 4), ("47", 5), ("1-3,9", 1)]
)
def test_frames_are_rendered_exactly_once(frames, size):
    made = compile_job("render", RENDER | {"frames": frames, "chunk_size": size})
    *renders, table = made["tasks"]
    wanted = frames_of(frames.replace(" ", "").replace("-", ".."))
    rendered = [frames_of(value(task, "--render-frame")) for task in renders]
    assert sorted(chain.from_iterable(rendered)) == wanted
    assert max(map(len, rendered)) <= size
    assert frames_of(words_of(table)[1].partition("=")[2]) == wanted
    # What is checked is what is rendered.
    for task in renders:
        assert f"frames={value(task, '--render-frame')}" in words_of(task)


def test_the_table_waits_for_all_frames_and_the_video_for_the_table():
    tasks = compile_job("render", RENDER | {"video": True})["tasks"]
    assert [task["type"] for task in tasks] == ["blender", "blender", "blender", "ffmpeg"]
    assert [task["dependencies"] for task in tasks] == [[], [], [0, 1], [2]]
    video = tasks[3]["commands"][0]
    assert video["name"] == "frames-to-video"
    assert video["parameters"]["inputGlob"].endswith("/*.png")
    assert video["parameters"]["outputFile"].endswith("/office.mp4")


def test_output_is_where_the_web_page_says():
    made = compile_job("render", RENDER)
    folder = "/farm/out/2026-01-02_030405"
    assert made["settings"]["render_output_path"] == f"{folder}/######"
    assert value(made["tasks"][0], "--render-output") == f"{folder}/######"
    assert words_of(made["tasks"][0])[0] == folder


@pytest.mark.parametrize(
    ("stop", "word"),
    [("error", "error=0.02"), ("samples", "samples=4"), ("time", "time=60")],
)
def test_frames_end_as_the_job_says(stop, word):
    words = words_of(compile_job("render", RENDER | {"stop": stop})["tasks"][0])
    assert words[2:] == [word]
    plain = compile_job("render", RENDER | {"stop": "as the scene says", "accept_errors": True})
    assert words_of(plain["tasks"][0])[2:] == ["accept=errors"]


def test_frames_are_prepared_before_and_checked_behind():
    args = compile_job("render", RENDER)["tasks"][0]["commands"][0]["parameters"]["args"]
    calls = [args[k + 1].rpartition(".")[2] for k, arg in enumerate(args) if arg == "--python-expr"]
    assert calls == ["prepare()", "check()"]
    first, last = (k for k, arg in enumerate(args) if arg == "--python-expr")
    assert args.index("--render-output") < first < args.index("--render-frame") < last


def test_odd_names_come_through_as_they_are():
    odd = """/farm/a b'c"d$(touch x);e&f/ö {timestamp}"""
    made = compile_job(
        "bake",
        BAKE | {"bake_output_path": odd, "collections": "Ground 'floor'; a/b, ..", "scene": '"S"'},
    )
    first, second, table = made["tasks"]
    folder = odd.replace("{timestamp}", "2026-01-02_030405")
    assert words_of(first)[0] == f"{folder}/1_Ground 'floor'; a_b"
    assert "collection=Ground 'floor'; a/b" in words_of(first)
    # No name leads out of the folder.
    assert words_of(second)[0] == f"{folder}/2__"
    assert words_of(table)[1:] == ["part=1_Ground 'floor'; a_b", "part=2__"]
    line = command_line(first["commands"][0])
    assert line[:6] == ["blender", "-b", "-y", "--python-exit-code", "1", "/farm/office.blend"]
    assert line[6:8] == ["--scene", '"S"']
    # Names are in words of their own alone, never in what is run.
    assert all("floor" not in word for word in line if "import" in word)


def test_a_bake_without_collections_is_one_task():
    bake, table = compile_job("bake", BAKE | {"stop": "error in lx", "density": 12.5})["tasks"]
    folder, *words = words_of(bake)
    assert folder == "/farm/out/2026-01-02_030405/all"
    assert words == ["error_lx=5", "density=12.5"]
    assert table["dependencies"] == [0]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"format": "FFMPEG"}, "frames are pictures, and not FFMPEG"),
        ({"format": "OPEN_EXR", "video": True}, "and not of OPEN_EXR"),
    ],
)
def test_what_cannot_be_is_refused(changes, fault):
    made = compile_job("render", RENDER | changes)
    assert fault in made["fault"]
    assert made["tasks"] == []
