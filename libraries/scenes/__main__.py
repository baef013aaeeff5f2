"""Command ``python -m lumenray.libraries.scenes [-o DIR] [NAMES]``: make the bundled scenes."""

import argparse
import logging
import sys
from pathlib import Path

from ...blender_addon import registry
from . import FOLDER, NAMES
from .build import save_scenes

log = logging.getLogger(__name__)


def main(arguments=None) -> int:
    """Build the named scenes, all by default."""
    parser = argparse.ArgumentParser(prog="lumenray.libraries.scenes", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=FOLDER, help="folder for the files")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(NAMES)}")
    options = parser.parse_args(arguments)
    unknown = sorted(set(options.names) - set(NAMES))
    if unknown:
        parser.error(f"no such scene: {', '.join(unknown)}")
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    registry.register()
    for path in save_scenes(tuple(options.names) or NAMES, options.output):
        log.info("%s  %.1f MB", path, path.stat().st_size / 1e6)
    return 0


if __name__ == "__main__":
    sys.exit(main())
