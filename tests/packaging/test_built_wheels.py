"""Wheels of our own: what is missing to make one is told in a sentence."""

import tarfile
import zipfile

import pytest
import xatlas_wheel
from checks import check_zip
from project import BuildError
from python_headers import find_headers
from targets import Target

TARGET, PIN = Target("linux-x64", "cp314"), ("xatlas", "0.0.11")


def test_without_a_compiler_the_target_is_refused(monkeypatch, tmp_path):
    monkeypatch.setenv("CXX", "no-such-compiler -O3")
    with pytest.raises(
        BuildError, match=r"a C\+\+ compiler is needed to compile xatlas for linux-x64-cp314"
    ):
        xatlas_wheel.make(TARGET, PIN, tmp_path / "xatlas-0.0.11.tar.gz", tmp_path)


def test_without_the_headers_of_a_python_the_target_is_refused(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(
        BuildError, match=r"headers of Python 3\.14 are needed .* install Python 3\.14"
    ):
        find_headers("3.14", tmp_path)


def test_what_the_compiler_refuses_is_told(monkeypatch, tmp_path):
    monkeypatch.setattr(xatlas_wheel, "find_headers", lambda version, folder: [])
    source = tmp_path / "xatlas-0.0.11"
    source.mkdir()
    archive = tmp_path / "xatlas-0.0.11.tar.gz"
    with tarfile.open(archive, "w:gz") as tar:
        tar.add(source, source.name)
    monkeypatch.setenv("CXX", "false")
    with pytest.raises(BuildError, match="xatlas cannot be compiled for linux-x64-cp314"):
        xatlas_wheel.make(TARGET, PIN, archive, tmp_path)


def test_a_zip_with_another_name_is_refused(tmp_path):
    path = tmp_path / "lumenray.zip"
    with zipfile.ZipFile(path, "w"):
        pass
    with pytest.raises(BuildError, match="is not named as lumenray-VERSION-PLATFORM-PYTHON"):
        check_zip(path, "1.2.3")
