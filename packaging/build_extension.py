"""Build the Blender extension: one zip for each platform and Python version.

Wheels come unmodified from the package index that pip is set up with (`wheels`), or are made here
(`built_wheels`). Every zip is read again and checked before it is done (`checks`).
"""

import argparse
import sys
from pathlib import Path

from archive import drop_building, narrow_manifest, source_files, write_zip
from built_wheels import BUILT, cluster_pins, downloaded_pins, make_wheels
from judge import judge_zip
from package_index import UnreachableIndexError
from project import ROOT, BuildError, Project, read_project
from targets import PLATFORM_TAGS, PYTHONS, Target, all_targets, current_platform, pack_targets
from wheels import LOCK, fetch_wheels, read_lock, update_lock


def update(targets, project: Project) -> str:
    """Record the wheels of targets and of their packs, and all sources, anew; return a line about it.

    Wheels of other targets stay recorded as long as their version is still the pinned one.
    """
    systems = {target.platform for target in targets}
    targets = [*targets, *(target for target in pack_targets() if target.platform in systems)]

    def pins_of(target: Target) -> list:
        own = downloaded_pins(project, target)
        return own if target in pack_targets() else own + cluster_pins(project, target)

    def still_wanted(file) -> bool:
        return any(
            file.fits(*pin, other)
            for other in (*all_targets(), *pack_targets())
            if other not in targets
            for pin in pins_of(other)
        )

    sources = {name for each in BUILT for name in each.sources}
    update_lock(
        [(pins_of(target), target) for target in targets],
        [pin for pin in project.pins if pin[0] in sources],
        still_wanted,
    )
    return f"recorded {len(read_lock())} files in {LOCK}"


def build(target: Target, project: Project, folder: Path) -> str:
    """Build and check the zip of one target; return a line about it."""
    recorded = read_lock()
    wheels = fetch_wheels(target, downloaded_pins(project, target), recorded)
    wheels += make_wheels(project, target, recorded)
    path = folder / f"lumenray-{project.version}-{target}.zip"
    source = ROOT / "blender_manifest.toml"
    manifest = drop_building(source, narrow_manifest(source, target.platform, wheels))
    files = {name.as_posix(): (ROOT / name).read_bytes() for name in source_files(project.rooms)}
    write_zip(path, {"blender_manifest.toml": manifest.encode(), **files}, wheels)
    return judge_zip(path, project.version)


def select_targets(options) -> list[Target]:
    """Return the targets that the command line asks for."""
    if options.all:
        return all_targets()
    system = options.platform or current_platform()
    if system is None:
        raise BuildError(f"this machine is none of {', '.join(PLATFORM_TAGS)}: use --platform")
    return [Target(system, tag) for tag in PYTHONS if options.python in (None, tag)]


def parse_arguments(description: str, can_update: bool, arguments):
    """Return the parsed command line."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--platform", choices=PLATFORM_TAGS, help="default: this machine's")
    parser.add_argument("--python", choices=PYTHONS, help="Python tag; default: all")
    parser.add_argument("--all", action="store_true", help="every platform and Python tag")
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="folder of the zips")
    if can_update:
        parser.add_argument("--update", action="store_true", help="record the wheels' sums anew")
    return parser.parse_args(arguments)


def run_targets(description: str, build, update=None, arguments=None) -> int:
    """Build what the command line asks for, each target even if another cannot be; return the exit status.

    Where the package index cannot be reached, all ends at the first target that needs it.

    Parameters
    ----------
    description : str    Of the command.
    build : callable    ``build(target, project, folder)`` returns a line about what it has made, or raises `BuildError`.
    update : callable or None    ``update(targets, project)`` records sums in place of that, where the command can.
    """
    name = Path(sys.argv[0]).stem
    options = parse_arguments(description, update is not None, arguments)
    status = 0
    try:
        targets = select_targets(options)
        project = read_project()
        if update is not None and options.update:
            print(update(targets, project))
            return 0
        options.output.mkdir(parents=True, exist_ok=True)
        for target in targets:
            try:
                print(build(target, project, options.output), flush=True)
            except UnreachableIndexError:
                raise
            except BuildError as error:
                print(f"{name}: {target}: {error}", file=sys.stderr)
                status = 1
    except BuildError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    return status


def main(arguments=None) -> int:
    """Build the extension, or record sums; return the exit status."""
    return run_targets("Build the Blender extension.", build, update, arguments)


if __name__ == "__main__":
    sys.exit(main())
