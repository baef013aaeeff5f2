"""Results of independent chunks, merged in the order of their numbers: the same chunks give the same bits.

With chunks x_k of w_k samples, W their sum, the mean is sum w_k x_k / W. Of the standard error e_k a part f_k is what more
samples do not lower (what cells may be off by, light that a witness misses); the rest falls as independent errors do, and
that part stays: the square of the whole is sum w_k^2 (e_k^2 - f_k^2) / W^2 + sum w_k f_k^2 / W.
"""

import math
import re
from dataclasses import dataclass, field, fields, replace

import numpy as np

from ..accuracy.estimate import Estimate, relative_error
from ..accuracy.stopping import StopRule
from ..daylight.coefficients import DaylightCoefficients
from ..light_mix import GroupLight
from ..measurements import Measurement, SensorSpectra
from ..photometry.units import LUMINOUS_EFFICACY
from ..scene.provenance import Provenance
from ..views import Picture

NUMBER = re.compile(r"[-+]?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?")


@dataclass
class WeighedSums:
    """Sums over chunks of values and errors, by name, in double precision."""

    weight: float = 0.0
    means: dict[str, np.ndarray] = field(default_factory=dict)
    squares: dict[str, np.ndarray] = field(default_factory=dict)
    floors: dict[str, np.ndarray] = field(default_factory=dict)

    def add(self, weight: float, means: dict, errors: dict, floors: dict) -> None:
        """Add a chunk: values by name, errors by the same or others, and floors of errors that have some."""
        self.weight += weight
        for name, value in means.items():
            new = weight * np.asarray(value, dtype=np.float64)
            self.means[name] = self.means[name] + new if name in self.means else new
        for name, error in errors.items():
            square = np.asarray(error, dtype=np.float64) ** 2
            floor = floors.get(name)
            if floor is not None:
                lowest = np.broadcast_to(np.asarray(floor, dtype=np.float64) ** 2, square.shape)
                self.floors[name] = self.floors.get(name, 0.0) + weight * lowest
                square = np.maximum(square - lowest, 0.0)
            self.squares[name] = self.squares.get(name, 0.0) + weight**2 * square

    def mean(self, name: str) -> np.ndarray:
        """Mean of all chunks."""
        return self.means[name] / self.weight

    def floor(self, name: str) -> np.ndarray | None:
        """What of the error more samples do not lower; None where nothing is."""
        return np.sqrt(self.floors[name] / self.weight) if name in self.floors else None

    def scatter(self, name: str) -> np.ndarray:
        """Standard error of the mean as far as more samples lower it."""
        return np.sqrt(self.squares[name]) / self.weight

    def error(self, name: str) -> np.ndarray:
        """Standard error of the mean."""
        floor = self.floor(name)
        return self.scatter(name) if floor is None else np.hypot(self.scatter(name), floor)


@dataclass
class Origins:
    """Where the chunks come from, and what was said of them."""

    first: Provenance | None = None
    samples: int = 0
    _told: dict[str, dict[str, list]] = field(default_factory=dict)
    _count: int = 0

    def add(self, origin: Provenance) -> None:
        """Add a chunk's."""
        self.first = self.first or origin
        self.samples += origin.samples
        self._count += 1
        for kind in ("decisions", "notes"):
            table = self._told.setdefault(kind, {})
            for words in getattr(origin, kind):
                # The same sentence with other numbers is the same sentence.
                entry = table.setdefault(NUMBER.sub("#", words), [words, 0, True])
                entry[1] += 1
                entry[2] = entry[2] and entry[0] == words

    def tell(self, kind: str) -> tuple[str, ...]:
        """Sentences of a kind, each once; where chunks differ in its numbers, those of the first that said it."""
        told = []
        for words, count, is_same in self._told.get(kind, {}).values():
            if self._count == 1 or (is_same and count == self._count):
                told.append(words)
            else:
                what = "" if is_same else ", with numbers of the first"
                told.append(f"{words} (said of {count} of {self._count} chunks{what})")
        return tuple(told)

    def merged(self, seed: int, seconds: float) -> Provenance:
        """Where the whole comes from."""
        chunks = "1 chunk" if self._count == 1 else f"{self._count} chunks"
        own = f"computed by a cluster in {chunks}; nothing is left out for an asked error"
        return replace(
            self.first,
            seed=seed,
            samples=self.samples,
            seconds=seconds,
            decisions=(own, *self.tell("decisions")),
            notes=self.tell("notes"),
        )


class MeasurementSum:
    """Measurements at the same sensors. Attributes: ``samples`` of each sensor."""

    def __init__(self):
        self._sums, self._origins = WeighedSums(), Origins()
        self._first: Measurement | None = None
        self._has_common, self._methods = False, {}

    @property
    def samples(self) -> int:
        """Of each sensor, so far."""
        return self._origins.samples

    def add(self, made: Measurement) -> None:
        """Add the next chunk."""
        self._first = self._first or made
        means = {"illuminance": made.illuminance}
        errors = {"illuminance": made.standard_error}
        floors = {} if made.floors is None else {"illuminance": made.floors}
        if made.tristimulus is not None:
            means["tristimulus"], errors["tristimulus"] = made.tristimulus, made.tristimulus_error
        if made.spectra is not None:
            for name in SPECTRAL:
                means[name] = getattr(made.spectra, name)
                errors[name] = getattr(made.spectra, f"{name}_error")
        if made.floors is not None:
            lux = made.floors[:, None]
            floors |= {"tristimulus": lux, "equivalent_daylight": lux}
            floors["bands"] = lux / LUMINOUS_EFFICACY
        self._sums.add(made.provenance.samples, means, errors, floors)
        self._origins.add(made.provenance)
        self._has_common |= made.has_common_errors
        self._methods[NUMBER.sub("#", made.method)] = made.method

    def estimate(self) -> Estimate:
        """Illuminance so far, with errors as far as more samples lower them. (n,) [lx]"""
        sums = self._sums
        return Estimate(sums.mean("illuminance"), sums.scatter("illuminance"), self.samples)

    def rule_for_samples(self, rule: StopRule) -> StopRule:
        """What is asked of samples, beside errors that more do not lower: a job that waited for these would not end."""
        floor = self._sums.floor("illuminance")
        if floor is None:
            return rule
        found = self.estimate()
        shares = np.divide(floor, found.mean, out=np.zeros_like(floor), where=found.mean > 0.0)
        return rule.beside_shares(shares, found)

    def merged(self, seed: int, seconds: float) -> Measurement:
        """The measurement that all chunks make together."""
        sums, spectra = self._sums, self._first.spectra
        has_colour = self._first.tristimulus is not None
        if spectra is not None:
            values = {name: sums.mean(name) for name in SPECTRAL}
            values |= {f"{name}_error": sums.error(name) for name in SPECTRAL}
            spectra = SensorSpectra(edges=spectra.edges, **values)
        return Measurement(
            sums.mean("illuminance"),
            sums.error("illuminance"),
            self._origins.merged(seed, seconds),
            sums.mean("tristimulus") if has_colour else None,
            sums.error("tristimulus") if has_colour else None,
            None,
            "; ".join(self._methods.values()),
            spectra,
            self._has_common,
            sums.floor("illuminance"),
        )


SPECTRAL = ("bands", "equivalent_daylight")
"""Fields of `SensorSpectra` that are means."""


class CoefficientSum:
    """Daylight coefficients of the same sensors, suns and sky.

    Independent groups stay apart: the first groups of all chunks make the first group of the whole, and so on.
    """

    def __init__(self):
        self._sums, self._origins = WeighedSums(), Origins()
        self._first: DaylightCoefficients | None = None
        self._lost = 0

    @property
    def samples(self) -> int:
        """Paths of each sensor, so far."""
        return self._origins.samples

    def add(self, made: DaylightCoefficients) -> None:
        """Add the next chunk."""
        self._first = self._first or made
        means = {name: getattr(made, name) for name in ("sky", "reflected", "doubts", "direct")}
        # What reading cells may change is no chance.
        means["reading"] = made.reading.astype(np.float64) ** 2
        self._sums.add(made.samples, means, {"direct": made.direct_error}, {})
        self._origins.add(made.provenance)
        self._lost += made.lost

    def error(self) -> float:
        """Of the light of an even world, as of `DaylightCoefficients.error_of_even_world`. [-]"""
        light = self._sums.mean("sky").sum(axis=2)
        return Estimate.from_groups(light, self.samples).relative_error()

    def merged(self, seed: int, seconds: float) -> DaylightCoefficients:
        """The coefficients that all chunks make together."""
        sums = self._sums
        names = ("sky", "reflected", "doubts", "direct")
        values = {name: sums.mean(name).astype(np.float32) for name in names}
        return replace(
            self._first,
            **values,
            reading=np.sqrt(sums.mean("reading")).astype(np.float32),
            direct_error=sums.error("direct").astype(np.float32),
            samples=self.samples,
            lost=self._lost,
            provenance=self._origins.merged(seed, seconds),
        )


PIXELS = (
    "tristimulus", "illuminance", "bands", "backdrop", "coverage", "denoising_albedo", "denoising_normal", "denoising_depth",
)  # fmt: skip
"""Fields of a picture that are means over samples."""

ERRORS = ("luminance_error", "illuminance_error")

LIGHT = ("tristimulus", "illuminance", "backdrop", "shared_error")
"""Fields of a light group that are means; errors that are shared have signs, so they add up like values."""


class PictureSum:
    """Pictures of the same view; what is seen at the pixels' centres is the same in all."""

    def __init__(self):
        self._sums, self._origins = WeighedSums(), Origins()
        self._first: Picture | None = None
        self._groups: list[WeighedSums] = []
        self._group_samples: list[int] = []

    @property
    def samples(self) -> int:
        """Of a pixel, so far."""
        return self._origins.samples

    def add(self, made: Picture) -> None:
        """Add the next chunk."""
        self._first = self._first or made
        floors = {
            "luminance_error": made.luminance_floor,
            "illuminance_error": made.illuminance_floor,
        }
        self._sums.add(made.provenance.samples, _named(made, PIXELS), _named(made, ERRORS), floors)
        self._origins.add(made.provenance)
        if not self._groups:
            self._groups = [WeighedSums() for _ in made.groups]
            self._group_samples = [0] * len(made.groups)
        for number, light in enumerate(made.groups):
            own = self._groups[number]
            own.add(light.samples, _named(light, LIGHT), _named(light, ERRORS), {})
            self._group_samples[number] += light.samples

    def error(self) -> float:
        """Of the picture, as of `Picture.relative_error`. [-]"""
        return relative_error(self.tristimulus()[..., 1], self._sums.error("luminance_error"))

    def scatter(self) -> float:
        """The same as far as more samples lower it. [-]"""
        return relative_error(self.tristimulus()[..., 1], self._sums.scatter("luminance_error"))

    def rule_for_samples(self, rule: StopRule) -> StopRule:
        """As of `MeasurementSum.rule_for_samples`."""
        floor = self._sums.floor("luminance_error")
        bound = 0.0 if floor is None else relative_error(self.tristimulus()[..., 1], floor)
        return rule.beside(bound) if math.isfinite(bound) else rule

    def tristimulus(self) -> np.ndarray:
        """The picture so far. (h, w, 3) [cd/m2]"""
        return self._sums.mean("tristimulus")

    def merged(self, seed: int, seconds: float) -> Picture:
        """The picture that all chunks make together."""
        groups = tuple(
            GroupLight(light.name, samples, **_merged(own))
            for light, samples, own in zip(
                self._first.groups, self._group_samples, self._groups, strict=True
            )
        )
        floors = {
            f"{kind}_floor": _single(self._sums.floor(f"{kind}_error"))
            for kind in ("luminance", "illuminance")
        }
        return replace(
            self._first,
            **_merged(self._sums),
            **floors,
            relative_error=self.error(),
            groups=groups,
            provenance=self._origins.merged(seed, seconds),
        )


def _named(made, names) -> dict:
    known = {entry.name for entry in fields(made)}
    values = {name: getattr(made, name) for name in names if name in known}
    return {name: value for name, value in values.items() if value is not None}


def _merged(sums: WeighedSums) -> dict:
    means = {name: _single(sums.mean(name)) for name in sums.means}
    return means | {name: _single(sums.error(name)) for name in sums.squares}


def _single(array: np.ndarray | None) -> np.ndarray | None:
    return None if array is None else array.astype(np.float32)
