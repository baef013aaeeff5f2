"""Fixtures of all tests; small scenes live in `helpers`."""

import importlib.util
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from lumenray.engine import llvm

# Test folders are no packages, so shared helpers are found by their folder.
sys.path.insert(0, str(Path(__file__).parent / "helpers"))

HAS_BLENDER = importlib.util.find_spec("bpy") is not None

# Before any test imports Mitsuba.
llvm.settle()

# Where every test needs Blender's Python module.
WITH_BLENDER = (
    "benchmarks/test_sync_benchmark.py",
    "blender_addon/*",
    "command_line/asset_library/*",
    "command_line/test_bake_command.py",
    "command_line/test_bake_in_background.py",
    "command_line/test_option_names.py",
    "command_line/test_overwriting.py",
    "command_line/test_scene_commands.py",
    "command_line/test_scene_files.py",
    "libraries/test_scenes.py",
    "operators/*",
    "ui/*",
)

collect_ignore_glob = [] if HAS_BLENDER else list(WITH_BLENDER)


def pytest_report_header():
    """Say what is missing from a run, and why."""
    return None if HAS_BLENDER else f"bpy is not installed, left out: {', '.join(WITH_BLENDER)}"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Leave most combinations of parameters to the slow tests, of tests that are marked so.

    Quick are the first values of all parameters together, and each other value with the first ones of the rest.
    """
    firsts = {}
    for item in items:
        if item.get_closest_marker("one_at_a_time"):
            first = firsts.setdefault(item.function, item)
            if count_departures(item, first) > 1:
                item.add_marker(pytest.mark.slow)


def count_departures(item, first):
    """Count the parameters in which a test differs from the first of its function; those stated together are one."""
    together = {}
    for mark in item.iter_markers("parametrize"):
        names = mark.args[0].split(",") if isinstance(mark.args[0], str) else mark.args[0]
        together |= {name.strip(): names[0] for name in names}
    base = first.callspec.params
    values = item.callspec.params.items()
    return len({together.get(name, name) for name, value in values if value is not base[name]})


@pytest.fixture(params=["mono", "spectral"])
def transport(request):
    """Run with both kinds of transport."""
    return request.param


@pytest.fixture(scope="session")
def registered():
    """Register the extension's property groups once, in a Blender with its factory's preferences."""
    import bpy

    from lumenray.blender_addon import registry

    bpy.ops.wm.read_factory_settings(use_empty=True)
    registry.register()


def read_empty_file():
    """Open an empty file, and leave the preferences: starting Blender's own extensions anew takes five times as long."""
    import bpy

    with engine_kept():
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


@contextmanager
def engine_kept():
    """Let the engine's process outlive a change of the file, without its sessions: its start takes more than a second."""
    from lumenray.blender_addon.foundation import engine_process

    state = engine_process._state
    for session in list(state.worker._sessions.values()) if state.worker else ():
        session.close()
    engine_process._state = engine_process._State()
    try:
        yield
    finally:
        engine_process._state = state


@pytest.fixture
def empty_file(registered):
    """Start from an empty file in Blender, and leave one."""
    read_empty_file()
    yield
    read_empty_file()


@pytest.fixture
def extension(empty_file):
    """Start with the whole extension, its operators and panels too."""
    import lumenray

    lumenray.register()


@pytest.fixture
def write_photometry(tmp_path):
    """Return a function that writes a photometric file and returns its path."""
    from photometric_files import EVEN
    from text_files import written

    return lambda content=EVEN, name="even.ies": str(written(tmp_path, content, name))


@pytest.fixture
def new_luminaire(write_photometry):
    """Return a function that makes a light, or an empty, which shines as a file says."""
    import bpy
    from blender_luminaires import add_luminaire
    from mathutils import Matrix

    from lumenray.blender_addon.luminaires.settings import settings_of

    def make(content, kind="POINT", matrix=None, name="lamp.ies"):
        source = add_luminaire(kind, write_photometry(content, name))
        source.matrix_world = matrix or Matrix()
        bpy.context.view_layer.update()
        return source, settings_of(source)

    return make


@pytest.fixture
def write_scattering(tmp_path):
    """Return a function that writes a scattering file and returns its path."""
    from blender_scattering import matt

    from lumenray.blender_addon.scattering.files import scattering_files
    from lumenray.engine.scattering.data import store
    from lumenray.engine.scattering.data.record import ScatteringFile

    def save(name="paint.lumbsdf", **sides):
        path = tmp_path / name
        sides = sides or {"front_reflection": matt(0.5)}
        store.write_store(path, ScatteringFile(path, "test", sides, name="Paint", source="made"))
        return str(path)

    yield save
    scattering_files.detach()


@pytest.fixture
def fake_engine(monkeypatch):
    """Let a fake engine bake for Blender, and return it."""
    from fake_bakes import FakeSession

    from lumenray.blender_addon.foundation import engine_process

    session = FakeSession()
    monkeypatch.setattr(engine_process, "open_session", lambda *_: session)
    return session
