"""Build the denoiser pack: an extension of its own, one zip for each platform, with the wheel of Open Image Denoise.

Of the wheel only what computes on processors is kept. It holds no module of Python's, so that it serves every version.
"""

import argparse
import sys
import zipfile
from fnmatch import fnmatch
from pathlib import Path

from archive import narrow_manifest, write_wheel, write_zip
from built_wheels import built_folder, downloaded_pins
from judge import judge_zip
from project import ROOT, BuildError, Project, read_project
from targets import ANY_PYTHON, PLATFORM_TAGS, Target, current_platform
from wheels import fetch_wheels, read_lock

SOURCE = ROOT / "packaging" / "denoiser"
"""What is ours of the pack."""

LIBRARIES = "pyoidn/oidn/"
"""Folder of the wheel with the libraries, of which only some are kept."""

KEPT = {
    "linux-x64": (
        "lib/libOpenImageDenoise.so", "lib/libOpenImageDenoise_core.so.*", "lib/libOpenImageDenoise_device_cpu.so.*",
        "lib/libtbb.so.12",
    ),
    "windows-x64": (
        "bin/OpenImageDenoise.dll", "bin/OpenImageDenoise_core.dll", "bin/OpenImageDenoise_device_cpu.dll", "bin/tbb12.dll",
    ),
    "macos-arm64": (
        "lib/libOpenImageDenoise.dylib", "lib/libOpenImageDenoise_core.*.dylib",
        "lib/libOpenImageDenoise_device_cpu.*.dylib", "lib/libtbb.12.dylib",
    ),
}  # fmt: skip
"""The library, its weights, its device for processors, and what that asks for, in each once."""

LABEL = "cpu"
"""Added to the version: the wheel is no longer the one of the package index."""


def trim_wheel(wheel: Path, platform: str, folder: Path) -> Path:
    """Write the wheel anew without the devices for graphics cards, programs and doubles; return its path.

    Raises
    ------
    BuildError    The wheel lacks one of the libraries that are to be kept.
    """
    name, version, tags = wheel.name.removesuffix(".whl").split("-", 2)
    info, new_version = f"{name}-{version}.dist-info/", f"{version}+{LABEL}"
    files, missing = {}, list(KEPT[platform])
    with zipfile.ZipFile(wheel) as archive:
        for entry in archive.namelist():
            if entry.startswith(LIBRARIES):
                patterns = [each for each in KEPT[platform] if fnmatch(entry, LIBRARIES + each)]
                if not patterns:
                    continue
                missing = [each for each in missing if each not in patterns]
            content = archive.read(entry)
            if entry == f"{info}METADATA":
                content = content.replace(
                    f"\nVersion: {version}".encode(), f"\nVersion: {new_version}".encode(), 1
                )
            if entry.endswith("/") or entry == f"{info}RECORD":
                continue
            files[entry.replace(info, f"{name}-{new_version}.dist-info/", 1)] = content
    if missing:
        raise BuildError(f"{wheel.name} has no {', '.join(LIBRARIES + each for each in missing)}")
    path = folder / f"{name}-{new_version}-{tags}.whl"
    write_wheel(path, files)
    return path


def build(platform: str, project: Project, folder: Path) -> str:
    """Build and check the pack of one platform; return a line about it."""
    target = Target(platform, ANY_PYTHON)
    (whole,) = fetch_wheels(target, downloaded_pins(project, target), read_lock())
    wheel = trim_wheel(whole, platform, built_folder())
    manifest = narrow_manifest(SOURCE / "blender_manifest.toml", platform, [wheel])
    texts = {"blender_manifest.toml": manifest.encode()}
    for path in (SOURCE / "__init__.py", ROOT / "LICENSE", SOURCE / "LICENSE.Apache-2.0"):
        texts[path.name] = path.read_bytes()
    path = folder / f"lumenray-denoiser-{project.version}-{platform}.zip"
    write_zip(path, texts, [wheel])
    return judge_zip(path, project.version)


def main(arguments=None) -> int:
    """Build the packs that the command line asks for; return the exit status."""
    parser = argparse.ArgumentParser(description="Build the denoiser pack.")
    parser.add_argument("--platform", choices=PLATFORM_TAGS, help="default: this machine's")
    parser.add_argument("--all", action="store_true", help="every platform")
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder of the zips")
    options = parser.parse_args(arguments)
    platforms = list(PLATFORM_TAGS) if options.all else [options.platform or current_platform()]
    if None in platforms:
        parser.error(f"this machine is none of {', '.join(PLATFORM_TAGS)}: use --platform")
    try:
        project = read_project()
        options.output.mkdir(parents=True, exist_ok=True)
        for platform in platforms:
            print(build(platform, project, options.output), flush=True)
    except BuildError as error:
        print(f"denoiser_pack: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
