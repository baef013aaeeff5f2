"""Pass rules: what a finding has to fulfil, and sentences on what it does not."""

from dataclasses import dataclass

import numpy as np

from .bench import MARGIN, Finding
from .reference import Group

BANDS = (1, 3, 5, 10)
"""Relative errors below which values are counted. [%]"""

CLASS_TOLERANCES = {"X": 1e-4, "A": 5e-3, "B": 1e-2, "C": 2e-2, "D": 3e-2, "Z": 0.0}
"""Relative tolerance of each class. [-]"""

BIAS_COUNT = 5
"""Values other than nought that a group must have for the rule on its mean error."""

BIAS_SHARE = 0.5
"""Part of the class's relative tolerance that the mean signed error must stay below."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """Judgement of a group.

    Parameters
    ----------
    group : Group
    relative : (n,) array    Signed relative errors; NaN where the reference is nought, that is 0 or, by rounding or
        because it is meant to vanish, not above its own tolerance. [-]
    inside : (n,) bool    Values that are inside their own tolerance.
    largest, mean, rms : float    Relative errors: of largest size, mean signed, root mean square; 0 where all
        references are nought. [-]
    mean_error : float    Standard error of ``mean``, the values being independent. [-]
    used : float    Largest part of its tolerance that a value's error takes. [-]
    faults : tuple of str    A sentence for every rule that is broken; none: the group passes.
    """

    group: Group
    relative: np.ndarray
    inside: np.ndarray
    largest: float
    mean: float
    rms: float
    mean_error: float
    used: float
    faults: tuple[str, ...]

    @property
    def is_scored(self) -> bool:
        """Whether the group counts."""
        return not self.group.is_informative

    @property
    def passes(self) -> bool:
        """Whether all rules are kept."""
        return not self.faults

    @property
    def sentence(self) -> str:
        """What failed and where, in one paragraph."""
        return " ".join(self.faults) if self.faults else f"{self.group.id} passes."

    def within(self, percent: float) -> np.ndarray:
        """Tell which values differ by less than so much of the reference.

        Nought has no relative error: what is inside its absolute tolerance counts as within everything.

        Returns
        -------
        (n,) bool
        """
        return np.where(is_nought(self.group), self.inside, np.abs(self.relative) < percent / 100.0)

    def within_or_inside(self, percent: float) -> np.ndarray:
        """Tell which values differ by less than that, or are inside their own tolerance where it is wider.

        Returns
        -------
        (n,) bool
        """
        wide = self.group.allowed >= percent / 100.0 * np.abs(self.group.values)
        return self.within(percent) | (wide & self.inside)


def is_nought(group: Group) -> np.ndarray:
    """Tell which references cannot be told from 0 by their own tolerance.

    Returns
    -------
    (n,) bool
    """
    return np.abs(group.values) <= group.allowed


def judge(finding: Finding) -> Verdict:
    """Apply the pass rules to a finding."""
    group = finding.group
    values = np.asarray(finding.values, dtype=np.float64)
    errors = np.asarray(finding.errors, dtype=np.float64)
    differences = values - group.values
    has_size = ~is_nought(group)
    relative = np.full(values.shape, np.nan)
    relative[has_size] = differences[has_size] / group.values[has_size]
    # Comparisons with NaN are false, so values and errors that are no numbers fail.
    inside = np.abs(differences) <= group.allowed
    sized = relative[has_size]
    mean = float(sized.mean()) if sized.size else 0.0
    spread = errors[has_size] / np.abs(group.values[has_size])
    faults = [
        _value_fault(group, values, inside),
        _noise_fault(group, errors),
        _bias_fault(group, mean, sized.size),
    ]
    return Verdict(
        group=group,
        relative=relative,
        inside=inside,
        largest=float(np.abs(sized).max(initial=0.0)),
        mean=mean,
        rms=float(np.sqrt((sized**2).mean())) if sized.size else 0.0,
        mean_error=float(np.sqrt((spread**2).sum()) / spread.size) if sized.size else 0.0,
        used=float(_part(np.abs(differences), group.allowed).max(initial=0.0)),
        faults=tuple(fault for fault in faults if fault),
    )


def _part(size: np.ndarray, allowed: np.ndarray) -> np.ndarray:
    """Sizes in units of what is allowed; 0 where nothing is allowed and nothing is there."""
    part = np.full(size.shape, np.inf)
    part[size == 0.0] = 0.0
    part[np.isnan(size)] = np.nan
    return np.divide(size, allowed, out=part, where=allowed > 0.0)


def _worst(size: np.ndarray, allowed: np.ndarray, among: np.ndarray) -> int:
    """Index of the value, among some, that takes most of its tolerance; one that is no number before all."""
    part = np.nan_to_num(_part(size, allowed), nan=np.inf, posinf=np.inf)
    return int(np.argmax(np.where(among, part, -1.0)))


def _value_fault(group: Group, values: np.ndarray, inside: np.ndarray) -> str:
    if inside.all():
        return ""
    difference = np.abs(values - group.values)
    i = _worst(difference, group.allowed, ~inside)
    told = f"{values[i]:.6g} instead of {group.values[i]:.6g} {group.unit}"
    if not is_nought(group)[i]:
        told += f", off by {_percent(values[i] / group.values[i] - 1.0, signed=True)}"
    return (
        f"{group.id}: {np.sum(~inside)} of {inside.size} values are outside their tolerance, "
        f"most of all {group.labels[i]} with {told}; {_allowed(group, i)} is allowed."
    )


def _noise_fault(group: Group, errors: np.ndarray) -> str:
    limits = group.allowed / MARGIN
    # Division and multiplication by three need not cancel to the last digit.
    noisy = ~(errors <= limits * (1.0 + 1e-9))
    if not noisy.any():
        return ""
    i = _worst(errors, limits, noisy)
    return (
        f"{group.id}: {noisy.sum()} of {noisy.size} standard errors are above a third of the tolerance, "
        f"most of all {group.labels[i]} with {errors[i]:.3g} {group.unit}; {limits[i]:.3g} is allowed."
    )


def _bias_fault(group: Group, mean: float, count: int) -> str:
    limit = BIAS_SHARE * CLASS_TOLERANCES[group.tolerance_class]
    if count < BIAS_COUNT or limit == 0.0 or abs(mean) < limit:
        return ""
    return (
        f"{group.id}: on average its values are off by {_percent(mean, signed=True)}, which is a bias; "
        f"less than {_percent(limit)} is allowed."
    )


def _allowed(group: Group, i: int) -> str:
    told = f"{group.allowed[i]:.3g} {group.unit}"
    if not is_nought(group)[i]:
        told += f" ({_percent(group.allowed[i] / abs(group.values[i]))})"
    return told


def _percent(share: float, signed: bool = False) -> str:
    return f"{100.0 * share:{'+' if signed else ''}.3g} %"
