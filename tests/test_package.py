"""The package as a whole: where it lies, what it is made of, and what it must not import."""

import ast
import subprocess
import sys
import tomllib
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest
from folders import ROOT

import lumenray

ROOMS = (
    "benchmarks", "blender_addon", "command_line", "engine", "libraries", "operators", "service", "tools", "ui",
    "validation",
)  # fmt: skip

IMPORT_WITHOUT_BLENDER = """
import importlib, sys

BLENDER = {"bpy", "bmesh", "mathutils", "gpu", "gpu_extras", "bl_math"}

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in BLENDER:
            raise ImportError(f"the engine asked for {name}")

sys.meta_path.insert(0, Blocker())
for name in sys.argv[1:]:
    importlib.import_module(name)
loaded = {"mitsuba", "drjit", "colour", "scipy"} & set(sys.modules)
print(" ".join(sorted(loaded)))
"""


def packages_on_disk():
    """Return the dotted names of all folders with an ``__init__.py``."""
    folders = [path.parent for room in ROOMS for path in (ROOT / room).rglob("__init__.py")]
    names = [".".join(("lumenray", *folder.relative_to(ROOT).parts)) for folder in folders]
    return {"lumenray", *names}


def modules_of(room):
    """Return the dotted names of all modules of a room."""
    paths = [path.relative_to(ROOT).with_suffix("") for path in (ROOT / room).rglob("*.py")]
    parts = [path.parts[:-1] if path.name == "__init__" else path.parts for path in paths]
    return sorted(".".join(("lumenray", *names)) for names in parts)


def read_setuptools():
    """Return the setuptools section of ``pyproject.toml``."""
    with (ROOT / "pyproject.toml").open("rb") as stream:
        return tomllib.load(stream)["tool"]["setuptools"]


def test_the_repository_root_is_the_package():
    assert Path(lumenray.__file__) == ROOT / "__init__.py"


def test_every_package_on_disk_is_listed_in_pyproject():
    listed = read_setuptools()["packages"]
    missing = "\n".join(f'    "{name}",' for name in sorted(packages_on_disk() - set(listed)))
    assert not missing, f"add to [tool.setuptools] packages in pyproject.toml:\n{missing}"
    gone = sorted(set(listed) - packages_on_disk())
    assert not gone, f"listed in pyproject.toml, but without an __init__.py: {gone}"
    assert listed == sorted(listed)


@pytest.mark.parametrize("room", ["libraries", "tools"])
def test_every_data_file_is_part_of_the_wheel(room):
    patterns = read_setuptools()["package-data"][f"lumenray.{room}"]
    folder = ROOT / room
    packed = {path for pattern in patterns for path in folder.glob(pattern)}
    files = {path for path in folder.rglob("*") if path.is_file() and path.suffix != ".pyc"}
    data = {path for path in files if path.suffix not in {".py", ".blend1"}}
    left = sorted(str(path.relative_to(ROOT)) for path in data - packed)
    assert not left, f"package-data in pyproject.toml has no pattern for {left}"


def test_every_package_says_what_it_is_for():
    said = {
        str(path.relative_to(ROOT)): ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
        for room in ROOMS
        for path in (ROOT / room).rglob("__init__.py")
    }
    assert [path for path, text in said.items() if not text] == []


def test_every_folder_with_python_files_is_a_package():
    """A folder without ``__init__.py`` would be left out of a wheel and of the import contracts."""
    files = {path for room in ROOMS for path in (ROOT / room).rglob("*.py")}
    # Presets are scripts that Blender runs: all that lie in their folder, so that a package would be one.
    folders = {path.parent for path in files} - {ROOT / "libraries" / "presets" / "lumenray"}
    bare = sorted(
        str(path.relative_to(ROOT)) for path in folders if not (path / "__init__.py").exists()
    )
    assert not bare


def test_tests_lie_in_folders_named_as_the_rooms_that_they_test():
    folders = {
        path.parent.relative_to(ROOT / "tests") for path in (ROOT / "tests").rglob("test_*.py")
    }
    beside = {"fuzz", "stability", "viewer"}
    rooms = {folder for folder in folders if folder.parts and folder.parts[0] not in beside}
    assert [str(room) for room in sorted(rooms) if not (ROOT / room).is_dir()] == []


def test_the_engine_imports_without_blender():
    """Nor does importing it load Mitsuba: that is left to the first use."""
    done = subprocess.run(
        [sys.executable, "-c", IMPORT_WITHOUT_BLENDER, "lumenray", *modules_of("engine")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_no_file_imports_itself_through_others():
    """Imports inside functions count too."""
    graph = grimp.build_graph("lumenray", cache_dir=None)
    assert len(graph.modules) > 500
    # Raises CycleError, which names the files.
    TopologicalSorter(
        {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    ).prepare()


def test_no_module_exists_twice():
    """Pytest must not import the package a second time under the name of the checkout's folder."""
    files = [getattr(module, "__file__", None) for module in list(sys.modules.values())]
    ours = [path for path in files if path and ROOT in Path(path).parents and ".venv" not in path]
    assert [path for path, count in Counter(ours).items() if count > 1] == []


def test_versions_agree():
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    from lumenray.engine import VERSION

    assert manifest["version"] == project["version"] == VERSION
