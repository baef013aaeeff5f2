"""From estimates per lumel to finished maps."""

import numpy as np


def assemble(target, lumels, estimate, margin: int) -> dict:
    """Lay estimates out as a map, dilate the seams, summarise. Returns the fields of `session.LuxMap`."""
    charts = target.charts
    shape = (charts.height, charts.width)

    def lay_out(values):
        flat = np.zeros(shape[0] * shape[1], dtype=np.float32)
        flat[lumels.index] = values
        return flat.reshape(shape)

    covered = lay_out(np.ones(len(lumels.index))) > 0.0
    weights = lumels.area
    total = weights.sum()
    mean = float((estimate.mean * weights).sum() / total)
    return {
        "name": target.mesh.name,
        "illuminance": dilate(lay_out(estimate.mean), covered, margin),
        "standard_error": dilate(lay_out(estimate.standard_error), covered, margin),
        "covered": covered,
        "area": lay_out(lumels.area),
        "mean": mean,
        "minimum": float(estimate.mean.min()),
        "maximum": float(estimate.mean.max()),
        "relative_standard_error": estimate.relative_error(weights),
        "mean_standard_error": float(
            np.sqrt(((estimate.standard_error * weights) ** 2).sum()) / total
        ),
        "samples": estimate.samples,
        "density": charts.density,
    }


def dilate(values: np.ndarray, covered: np.ndarray, margin: int) -> np.ndarray:
    """Extend covered pixels outwards by ``margin`` rings, each pixel the mean of its covered neighbours."""
    values, known = values.astype(np.float32), covered.copy()
    for _ in range(margin):
        padded = np.pad(np.where(known, values, 0.0), 1)
        counted = np.pad(known.astype(np.float32), 1)
        total = np.zeros_like(values)
        count = np.zeros_like(values)
        height, width = values.shape
        for dy in (0, 1, 2):
            for dx in (0, 1, 2):
                total += padded[dy : dy + height, dx : dx + width]
                count += counted[dy : dy + height, dx : dx + width]
        fresh = ~known & (count > 0.0)
        if not fresh.any():
            break
        values = np.where(fresh, total / np.maximum(count, 1.0), values)
        known |= fresh
    return values
