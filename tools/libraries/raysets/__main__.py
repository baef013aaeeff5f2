"""Command ``python -m lumenray.tools.libraries.raysets``: trace the models anew and write their rays."""

import sys

import numpy as np

from ....engine.raysets.record import LUMINOUS, Rays
from ....engine.raysets.writers import write_tm25
from ....libraries.raysets import FOLDER
from .models import MODELS

COUNT, SEED = 10_000, 20261122
"""Rays of a file; they are always the same."""


def main() -> int:
    """Write all files."""
    FOLDER.mkdir(exist_ok=True)
    for model in MODELS:
        position, direction, flux = model.make(COUNT, np.random.default_rng(SEED))
        rays = Rays(
            position.astype(np.float32),
            direction.astype(np.float32),
            (flux * (model.entry.luminous_flux / flux.sum())).astype(np.float32),
        )
        path = FOLDER / f"{model.entry.name}.tm25ray"
        texts = {"SOURCE": model.entry.title, "INFORMATION": model.entry.description}
        write_tm25(path, [rays], LUMINOUS, metadata=texts)
        sys.stdout.write(f"{path}: {len(rays)} rays\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
