"""LLVM is found where it lies: the user's own first, then the one that is shipped, then the system's."""

import os
import subprocess
import sys
import types

import pytest

from lumenray.engine import llvm

SYSTEM = [
    "/usr/lib/x86_64-linux-gnu/libLLVM-15.so.1",
    "/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1",
    "/usr/lib/llvm-18/lib/libLLVM.so",
]


@pytest.fixture(autouse=True)
def _bare(monkeypatch):
    """Neither a choice, nor a bundle, nor a system's library."""
    monkeypatch.delenv("DRJIT_LIBLLVM_PATH", raising=False)
    monkeypatch.setattr(llvm, "BUNDLE", "lumenray_llvm_of_nobody")
    monkeypatch.setattr(llvm, "_system_libraries", list)


@pytest.fixture
def bundle(monkeypatch, tmp_path):
    """Install a bundle whose library is a file of the given bytes; return its path."""

    def install(content):
        path = tmp_path / "libLLVM.so.23.1"
        path.write_bytes(content)
        module = types.ModuleType("lumenray_llvm_of_tests")
        module.LIBRARY = path
        module.__spec__ = types.SimpleNamespace(name=module.__name__)
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setattr(llvm, "BUNDLE", module.__name__)
        return str(path)

    return install


def test_nothing_is_found_where_nothing_is():
    assert llvm.find_library() is None
    assert llvm.describe_absence() == "LLVM was not found"


def test_the_newest_of_the_systems_is_taken_and_old_ones_count_as_missing(monkeypatch):
    monkeypatch.setattr(llvm, "_system_libraries", lambda: SYSTEM)
    assert llvm.find_library() == SYSTEM[1]
    monkeypatch.setattr(llvm, "_system_libraries", lambda: SYSTEM[:1])
    assert llvm.find_library() is None
    assert "15" in llvm.describe_absence()


def test_the_one_that_is_shipped_goes_before_the_systems(monkeypatch, bundle):
    monkeypatch.setattr(llvm, "_system_libraries", lambda: SYSTEM)
    monkeypatch.setattr(llvm, "_loads", lambda path: True)
    path = bundle(b"")
    assert llvm.find_library() == path


def test_one_that_does_not_load_here_is_passed_over_and_told(monkeypatch, bundle):
    path = bundle(b"\x7fELF of another machine")
    assert llvm.find_library() is None
    assert path in llvm.describe_absence()
    monkeypatch.setattr(llvm, "_system_libraries", lambda: SYSTEM[:1])
    assert path in llvm.describe_absence()
    monkeypatch.setattr(llvm, "_system_libraries", lambda: SYSTEM)
    assert llvm.find_library() == SYSTEM[1]


def test_the_users_own_goes_first_and_is_never_replaced_silently(monkeypatch, bundle, tmp_path):
    bundle(b"")
    monkeypatch.setattr(llvm, "_loads", lambda path: True)
    own = tmp_path / "own.so"
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", str(own))
    assert llvm.find_library() is None
    assert str(own) in llvm.describe_absence()
    own.write_bytes(b"")
    assert llvm.find_library() == str(own)


BAKE_FIRST = """
import os
from lumenray.engine import llvm
found = llvm.find_library()
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import LumenrayError
from lumenray.engine.session import Session

try:
    Session().bake_objects(BakeOrder((), StopRule(samples=1)))
except LumenrayError:
    print(os.environ.get("DRJIT_LIBLLVM_PATH") == found)
"""


def test_a_bake_that_is_the_first_job_of_a_process_uses_the_library_that_is_found():
    kept = {name: value for name, value in os.environ.items() if name != "DRJIT_LIBLLVM_PATH"}
    made = subprocess.run(
        [sys.executable, "-c", BAKE_FIRST], env=kept, capture_output=True, text=True, check=True
    )
    assert made.stdout.strip() == "True"
