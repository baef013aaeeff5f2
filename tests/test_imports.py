"""Modules that are loaded when they are used: what stands for them, and that what is asked of them is there."""

import ast
import builtins
import importlib
import importlib.util
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from folders import ROOT

from lumenray.imports import loaded_when_used

BLOCK = "loaded_when_used"

ENABLE = """
import sys, bpy
before = set(sys.modules)
import lumenray
lumenray.register()
loaded = sorted(set(sys.modules) - before)
print("\\n".join(loaded))
# Blender's Python module has loaded numpy itself; a real Blender leaves that to extensions.
numpy = sys.modules["numpy"]
print("\\n".join(f"numpy in {name}" for name in loaded if vars(sys.modules[name]).get("np") is numpy))
"""

MOST_MODULES = 240
"""That enabling may load of ours, a fifth more than it does: panels, operators, properties and what they are made of."""

FEW_OF_THE_ENGINE = 30
"""Modules of the engine that are words and limits of settings, and the packages that they lie in."""


def blocks():
    """Give every module that imports in such a block, as path, syntax tree and the imports of its blocks."""
    for room in ("blender_addon", "command_line", "engine", "libraries", "operators", "ui"):
        for path in sorted((ROOT / room).rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            if BLOCK not in text:
                continue
            tree = ast.parse(text)
            held = [
                each
                for statement in tree.body
                if isinstance(statement, ast.With) and BLOCK in ast.unparse(statement.items[0])
                for each in statement.body
            ]
            yield path, tree, held


def module_of(path, statement, name: str) -> str:
    """Return the full name of the module that a statement in a block of a file imports."""
    if isinstance(statement, ast.Import) or not statement.level:
        return ".".join(filter(None, (getattr(statement, "module", None), name)))
    package = ".".join(("lumenray", *path.relative_to(ROOT).parent.parts))
    return (
        importlib.util.resolve_name(f"{'.' * statement.level}{statement.module or ''}", package)
        + f".{name}"
    )


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of this test with a module that says so when it is loaded."""
    folder = tmp_path / "waiting_package"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "part.py").write_text("COUNT = 7\nimport colorsys\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield folder.name
    for name in [each for each in sys.modules if each.startswith(folder.name)]:
        del sys.modules[name]


def test_a_module_is_loaded_by_the_first_use(package):
    with loaded_when_used():
        from waiting_package import part
    assert "waiting_package.part" in repr(part)
    assert package not in sys.modules
    assert part.COUNT == 7
    assert part.colorsys is sys.modules["colorsys"]
    assert part.COUNT is sys.modules["waiting_package.part"].COUNT


def test_a_module_of_no_package_waits_too(package):
    with loaded_when_used():
        import waiting_package as waiting
    assert package not in sys.modules
    assert waiting.__path__
    assert package in sys.modules


def test_what_is_set_is_set_in_the_module(package, monkeypatch):
    """So that tests can put something in place of what others use."""
    with loaded_when_used():
        from waiting_package import part
    monkeypatch.setattr(part, "COUNT", 8)
    assert sys.modules["waiting_package.part"].COUNT == 8


def test_a_module_that_is_missing_is_told_when_it_is_used():
    with loaded_when_used():
        import lumenray_is_without_this as missing
    with pytest.raises(ModuleNotFoundError, match="lumenray_is_without_this"):
        missing.anything  # noqa: B018


def test_imports_are_as_ever_after_the_block_and_after_an_error_in_it():
    usual = builtins.__import__
    with pytest.raises(ZeroDivisionError), loaded_when_used():
        1 / 0  # noqa: B018
    assert builtins.__import__ is usual


def test_threads_that_use_a_module_at_once_all_get_the_whole_of_it(tmp_path, monkeypatch):
    """A panel is drawn while a job in the background needs the same."""
    (tmp_path / "slow_to_load.py").write_text("import time\ntime.sleep(0.05)\nLAST = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    with loaded_when_used():
        import slow_to_load
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda _: slow_to_load.LAST, range(4))) == [1, 1, 1, 1]
    del sys.modules["slow_to_load"]


def test_a_module_that_is_loaded_takes_the_place_of_what_stood_for_it(tmp_path, monkeypatch):
    """So that no later use takes longer than that of other imports."""
    (tmp_path / "waited_for.py").write_text("COUNT = 7\n")
    (tmp_path / "waits.py").write_text(
        "from lumenray.imports import loaded_when_used\n\n"
        "with loaded_when_used():\n    import waited_for as other\n\n\n"
        "def count():\n    return other.COUNT\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    import waits

    assert "waited_for" not in sys.modules
    assert waits.count() == 7
    assert waits.other is sys.modules["waited_for"]
    for name in ("waits", "waited_for"):
        del sys.modules[name]


@pytest.mark.blender
def test_only_modules_are_imported_so_and_all_that_is_asked_of_them_is_there():
    """What linters find out of other imports: names that do not exist."""
    wrong = []
    for path, tree, held in blocks():
        assert held, path
        bound = {}
        for statement in held:
            for alias in statement.names:
                name = module_of(path, statement, alias.name)
                bound[alias.asname or alias.name] = name
                if importlib.util.find_spec(name) is None:
                    wrong.append(f"{path}: {name} is no module")
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                name = bound.get(node.value.id)
                if name and not hasattr(importlib.import_module(name), node.attr):
                    wrong.append(f"{path}:{node.lineno}: {name} has no {node.attr}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.blender
def test_enabling_the_extension_loads_what_blender_has_to_know_of_it():
    """Else every start of Blender waits for it, in files too that are rendered by another engine."""
    done = subprocess.run(
        [sys.executable, "-c", ENABLE], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    loaded = done.stdout.splitlines()
    assert "lumenray.operators.bake_illuminance" in loaded
    ours = [name for name in loaded if name.startswith("lumenray")]
    assert len(ours) < MOST_MODULES
    engine = [name for name in ours if name.startswith("lumenray.engine")]
    assert len(engine) < FEW_OF_THE_ENGINE, engine
    heavy = {
        "lumenray.engine.session",
        "lumenray.engine.scene.scene",
        "lumenray.engine.worker.client",
        "lumenray.blender_addon.sync.scene",
        "PIL",
        "contourpy",
        "multiprocessing",
        "reportlab",
        "xml.etree.ElementTree",
    }
    assert not heavy & set(loaded)
    assert not [line for line in loaded if line.startswith("numpy in lumenray")]
