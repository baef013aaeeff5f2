"""What Blender itself does with our zips and wheels, by the scripts of its Python module."""

import subprocess
import sys

import pytest
from archive import write_wheel
from denoiser_pack import trim_wheel
from extension_zips import DENOISER_FILES, make_zip
from judge import ask_blender
from project import BuildError

FIND = "from lumenray.engine.analysis.denoiser import find_denoiser; print(find_denoiser())"


def test_blender_takes_a_sound_zip_and_refuses_a_broken_one(monkeypatch, tmp_path):
    monkeypatch.delenv("LUMENRAY_JUDGE", raising=False)
    assert ask_blender(make_zip(tmp_path)) == "the scripts of Blender's Python module"
    with pytest.raises(BuildError, match=r"Blender refuses lumenray-1\.2\.3-linux-x64-cp311\.zip"):
        ask_blender(make_zip(tmp_path, changes={"id": '"9 lives"'}))


@pytest.mark.blender
@pytest.mark.skipif(sys.platform != "linux", reason="the wheel of the test is for Linux")
def test_the_pack_is_found_where_blender_puts_its_wheel_and_goes_with_it(tmp_path):
    import bpy  # noqa: F401 - brings the path to Blender's scripts
    from _bpy_internal.extensions.wheel_manager import apply_action

    whole = tmp_path / "pyoidn-2.5-py3-none-manylinux2014_x86_64.whl"
    write_wheel(whole, DENOISER_FILES)
    wheel = trim_wheel(whole, "linux-x64", tmp_path)
    local = tmp_path / "extensions" / ".local"
    site = local / "lib" / "python3.11" / "site-packages"
    site.mkdir(parents=True)
    faults = []

    def install(*wheels):
        apply_action(
            local_dir=str(local),
            local_dir_site_packages=str(site),
            wheel_list=[("lumenray_denoiser", [str(each) for each in wheels])],
            error_fn=faults.append,
            remove_error_fn=lambda path, error: faults.append(error),
            debug=False,
        )

    def found():
        script = f"import sys; sys.path.insert(0, {str(site)!r}); {FIND}"
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True
        )
        return done.stdout.strip()

    install(wheel)
    assert found() == str(site / "pyoidn/oidn/lib/libOpenImageDenoise.so")
    install()
    assert not any(site.iterdir())
    assert faults == []
