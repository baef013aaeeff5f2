"""The denoiser pack: of the wheel only what computes on processors, and a record that fits."""

import base64
import hashlib
import zipfile

import pytest
from archive import write_wheel
from denoiser_pack import KEPT, trim_wheel
from extension_zips import DENOISER_FILES
from project import ROOT, BuildError, read_project


def test_only_what_computes_on_processors_is_kept(tmp_path):
    whole = tmp_path / "pyoidn-2.5-py3-none-manylinux2014_x86_64.whl"
    write_wheel(whole, DENOISER_FILES)
    trimmed = trim_wheel(whole, "linux-x64", tmp_path)
    assert trimmed.name == "pyoidn-2.5+cpu-py3-none-manylinux2014_x86_64.whl"
    with zipfile.ZipFile(trimmed) as wheel:
        held = {name: wheel.read(name) for name in wheel.namelist()}
    assert sorted(held) == [
        "pyoidn-2.5+cpu.dist-info/METADATA",
        "pyoidn-2.5+cpu.dist-info/RECORD",
        "pyoidn-2.5+cpu.dist-info/WHEEL",
        "pyoidn/__init__.py",
        "pyoidn/oidn/lib/libOpenImageDenoise.so",
        "pyoidn/oidn/lib/libOpenImageDenoise_core.so.2.5.1",
        "pyoidn/oidn/lib/libOpenImageDenoise_device_cpu.so.2.5.1",
        "pyoidn/oidn/lib/libtbb.so.12",
    ]
    assert b"\nVersion: 2.5+cpu\n" in held["pyoidn-2.5+cpu.dist-info/METADATA"]
    record = held.pop("pyoidn-2.5+cpu.dist-info/RECORD").decode().splitlines()
    for row in record[:-1]:
        name, digest, size = row.split(",")
        content = held.pop(name)
        wanted = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        assert (digest, size) == (f"sha256={wanted}", str(len(content)))
    assert not held
    assert record[-1] == "pyoidn-2.5+cpu.dist-info/RECORD,,"


@pytest.mark.parametrize(
    "name", [name for name in DENOISER_FILES if "core" in name or name.endswith("libtbb.so.12")]
)
def test_a_wheel_without_a_library_is_refused(tmp_path, name):
    whole = tmp_path / "pyoidn-2.5-py3-none-manylinux2014_x86_64.whl"
    write_wheel(
        whole, {other: content for other, content in DENOISER_FILES.items() if other != name}
    )
    with pytest.raises(BuildError, match=r"has no pyoidn/oidn/lib/lib"):
        trim_wheel(whole, "linux-x64", tmp_path)


def test_the_engine_looks_for_a_library_that_the_pack_holds():
    from lumenray.engine.analysis.denoiser import LIBRARIES

    kept = {f"oidn/{name}" for names in KEPT.values() for name in names}
    assert set(LIBRARIES.values()) <= kept


def test_the_pack_has_the_version_of_the_extension():
    manifest = (ROOT / "packaging/denoiser/blender_manifest.toml").read_text()
    assert f'\nversion = "{read_project().version}"\n' in manifest
