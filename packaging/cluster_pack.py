"""Build the cluster pack: an extension of its own, one zip for each platform and Python version, with the wheels of Dask.

They come unmodified from the package index that pip is set up with (`wheels`).
"""

import sys

from archive import narrow_manifest, write_zip
from build_extension import run_targets
from built_wheels import cluster_pins
from judge import judge_zip
from project import ROOT
from wheels import fetch_wheels, read_lock

SOURCE = ROOT / "packaging" / "cluster"
"""What is ours of the pack."""


def build(target, project, folder) -> str:
    """Build and check the pack of one target; return a line about it."""
    wheels = fetch_wheels(target, cluster_pins(project, target), read_lock())
    manifest = narrow_manifest(SOURCE / "blender_manifest.toml", target.platform, wheels)
    texts = {"blender_manifest.toml": manifest.encode()}
    for path in (SOURCE / "__init__.py", ROOT / "LICENSE"):
        texts[path.name] = path.read_bytes()
    path = folder / f"lumenray-cluster-{project.version}-{target}.zip"
    write_zip(path, texts, wheels)
    return judge_zip(path, project.version)


if __name__ == "__main__":
    sys.exit(run_targets("Build the cluster pack.", build))
