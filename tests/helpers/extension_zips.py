"""Small zips and wheels in the shape of those that the extension is shipped in; for tests in `packaging`."""

import zipfile

from archive import write_wheel

MANIFEST = {
    "schema_version": '"1.0.0"',
    "id": '"lumenray"',
    "name": '"Lumenray"',
    "version": '"1.2.3"',
    "tagline": '"Light in real units"',
    "maintainer": '"Us"',
    "type": '"add-on"',
    "license": '["SPDX:MIT"]',
    "blender_version_min": '"4.2.0"',
    "platforms": '["linux-x64"]',
}

NAMES = {
    "linux-x64": (
        "lumenray-1.2.3-linux-x64-cp311.zip",
        "light-1.0-cp311-cp311-manylinux_2_28_x86_64.whl",
    ),
    "windows-x64": ("lumenray-1.2.3-windows-x64-cp311.zip", "light-1.0-cp311-cp311-win_amd64.whl"),
    "macos-arm64": (
        "lumenray-1.2.3-macos-arm64-cp311.zip",
        "light-1.0-cp311-cp311-macosx_11_0_arm64.whl",
    ),
}


def make_zip(
    folder, library=b"", platform="linux-x64", wheel=None, changes=None, extra=(), licence="LICENSE"
):
    """Write a zip that holds one wheel with one library, and return its path."""
    name, usual = NAMES[platform]
    wheel = wheel or usual
    write_wheel(
        folder / wheel,
        {
            "light/core.so": library,
            "light-1.0.dist-info/WHEEL": b"Wheel-Version: 1.0\n",
            f"light-1.0.dist-info/licenses/{licence}": b"Do as you like.\n",
        },
    )
    keys = {
        **MANIFEST,
        "platforms": f'["{platform}"]',
        "wheels": f'["./wheels/{wheel}"]',
        **(changes or {}),
    }
    text = "".join(f"{key} = {value}\n" for key, value in keys.items() if value is not None)
    with zipfile.ZipFile(folder / name, "w") as archive:
        archive.writestr("blender_manifest.toml", text)
        archive.writestr("__init__.py", "")
        archive.write(folder / wheel, f"wheels/{wheel}")
        for info, content in extra:
            archive.writestr(info, content)
    return folder / name


DENOISER_FILES = {
    "pyoidn/__init__.py": b"code",
    "pyoidn/oidn/bin/oidnTest": b"a program",
    "pyoidn/oidn/lib/libOpenImageDenoise.so": b"library",
    "pyoidn/oidn/lib/libOpenImageDenoise.so.2": b"library",
    "pyoidn/oidn/lib/libOpenImageDenoise_core.so.2.5.1": b"weights",
    "pyoidn/oidn/lib/libOpenImageDenoise_device_cpu.so.2.5.1": b"cpu",
    "pyoidn/oidn/lib/libOpenImageDenoise_device_cuda.so.2.5.1": b"cuda",
    "pyoidn/oidn/lib/libtbb.so.12": b"threads",
    "pyoidn/oidn/lib/libtbb.so.12.19": b"threads",
    "pyoidn-2.5.dist-info/METADATA": b"Metadata-Version: 2.4\nName: pyoidn\nVersion: 2.5\n",
    "pyoidn-2.5.dist-info/WHEEL": b"Wheel-Version: 1.0\nTag: py3-none-manylinux2014_x86_64\n",
}
"""The wheel of Open Image Denoise, without its weight."""
