"""Tensor files of measured materials (.bsdf of EPFL's material database, Mitsuba's plug-in ``measured``).

A container of named arrays. Values lie on a grid over the unit square for every angle of incidence; the square is the half
vector's, (sqrt(2 theta / pi), phi / 2 pi), stretched so that the material's visible facets are even on it. What is tabulated
is the BRDF times the cosine of the outgoing direction, over the facets' density where the file says so.

References
----------
Dupuy & Jakob, An adaptive parameterization for efficient material acquisition and rendering, doi:10.1145/3272127.3275059
"""

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...errors import FileFormatError
from ...photometry.units import MAXIMUM_WAVELENGTH, MINIMUM_WAVELENGTH
from ...reading.remarks import Remark
from ...reading.whole_file import write_whole
from ..data.record import ScatteringFile
from ..data.resampling import choose_bands, resample
from .colour import spectra_of_rgb
from .marginal_warp import MarginalWarp, Slices, place_in, read_bilinear

SIGNATURE = b"tensor_file\0"

TYPES = {
    1: "<u1", 2: "<i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<u8", 8: "<i8", 9: "<f2", 10: "<f4", 11: "<f8",
}  # fmt: skip
"""Types of arrays by their number in the file."""

MOST_FIELDS = 64
"""Arrays that a file may have."""

MOST_AXES = 8
"""Axes that an array may have."""

SMALLEST_COSINE = 1e-4
"""Of the outgoing direction, by which values are divided."""

WIDEST_STEP = 10.0
"""Files with finer wavelengths are read at this step, which reflectances do with. [nm]"""

MOST_ROTATIONS = 24
"""Azimuths of incidence that the table of an anisotropic material has at most."""

MOST_VALUES = 1 << 24
"""Values that the table of an anisotropic material may grow to."""

COMPARED = 2000
"""Pairs of directions by which both sides of the plane of incidence are compared, and spectra by which bands are chosen."""

SPECTRAL_PART = 0.15
"""Share of the tolerance that may come of bands left out."""


def is_tensor_file(data: bytes) -> bool:
    """Whether the file begins as tensor files do."""
    return data[: len(SIGNATURE)] == SIGNATURE


def read_tensor_file(data: bytes, path, tolerance: float = 0.02) -> ScatteringFile:
    """Read a tensor file and make a table of it.

    Parameters
    ----------
    data : bytes
    path : str or Path    For messages.
    tolerance : float    Wanted error of the table, as of `resampling.resample`. [-]

    Raises
    ------
    FileFormatError    It is cut short, lacks an array, or has one of another shape or with values that cannot be.
    """
    material = parse_tensor_file(data, path)
    if not material.is_rgb:
        kept = _choose_bands(material, SPECTRAL_PART * tolerance)
        values = np.ascontiguousarray(material.values[..., kept])
        material = replace(material, wavelengths=material.wavelengths[kept], values=values)
    remarks = list(material.remarks)
    rotations, symmetric = [0.0], _is_mirrored(material)
    if not material.is_isotropic:
        rotations, symmetric = _rotations(material), False
    table = resample(
        material.evaluate,
        material.wavelengths,
        rotations=rotations,
        is_symmetric=symmetric,
        tolerance=tolerance,
        **({} if material.is_isotropic else {"most": MOST_VALUES}),
    )
    last = np.degrees(material.incidences[-1])
    if last < 89.0:
        remarks.append(Remark(f"ends at the incidence {last:.4g}°; beyond it the end holds"))
    return ScatteringFile(
        Path(path),
        "tensor file",
        {"front_reflection": table},
        name=Path(path).stem,
        description=material.description,
        incidences=np.clip(material.incidences, 0.0, 0.5 * np.pi),
        remarks=tuple(remarks),
    )


def _choose_bands(material: "TensorMaterial", tolerance: float) -> np.ndarray:
    """Numbers of the bands between which the others lie; what has many takes long to be resampled. (k,)"""
    flat = material.values.reshape(-1, len(material.wavelengths))
    some = flat[np.random.default_rng(6).integers(len(flat), size=COMPARED)].astype(np.float64)
    return choose_bands(material.wavelengths, some, tolerance)


def _rotations(material: "TensorMaterial") -> np.ndarray:
    """Azimuths of incidence all around, those of the file and what symmetry makes of them."""
    phi = material.azimuths
    made = {1: [phi], 4: [phi, -phi, np.pi + phi, np.pi - phi]}.get(
        material.reduction, [phi, np.pi + phi]
    )
    around = np.sort(np.concatenate(made) % (2.0 * np.pi))
    # Those that rounding sets apart, 0 and a whole turn among them, are one.
    around = around[np.append(True, np.diff(around) > 1e-4)]
    if around[-1] > 2.0 * np.pi - 1e-4:
        around = np.unique(np.append(0.0, around[:-1]))
    if len(around) <= MOST_ROTATIONS:
        return around
    return np.linspace(0.0, 2.0 * np.pi, MOST_ROTATIONS, endpoint=False)


def _is_mirrored(material: "TensorMaterial") -> bool:
    """Whether both sides of the plane of incidence are alike, but for noise of the measurement."""
    draw = np.random.default_rng(5).random((3, COMPARED))
    polar = draw[0] * material.incidences[-1]
    wi = np.stack([np.sin(polar), np.zeros(COMPARED), np.cos(polar)], axis=1)
    sine, turn = np.sqrt(0.97 * draw[1]), 2.0 * np.pi * draw[2]
    wo = np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1.0 - sine**2)], axis=1)
    here = material.evaluate(wi, wo).mean(axis=1)
    there = material.evaluate(wi, wo * np.array([1.0, -1.0, 1.0])).mean(axis=1)
    difference = np.abs(here - there) / np.maximum(here + there, 1e-12)
    return bool(np.median(difference) < 0.05)


@dataclass(frozen=True, eq=False)
class TensorMaterial:
    """What a tensor file holds, ready to be evaluated.

    Parameters
    ----------
    azimuths : (p,) float64 array    Of incidence, ascending; one or two: the material is isotropic. [rad]
    incidences : (t,) float64 array    Ascending. [rad]
    wavelengths : (w,) float64 array    Of what `evaluate` returns. [nm]
    facets, visible_area : (r, c) float64 arrays or None    Density of facets and their visible area, where they are factors.
    warp : MarginalWarp    Of the facets that are visible.
    values : (p * t, m, m, b) float32 array    At wavelengths, or red, green and blue.
    is_rgb : bool    Whether the bands are colours.
    reduction : int    So many parts of the turn are alike: 1, 2 (half turns) or 4 (mirrored at two planes).
    description : str
    remarks : tuple of Remark
    """

    azimuths: np.ndarray
    incidences: np.ndarray
    wavelengths: np.ndarray
    facets: np.ndarray | None
    visible_area: np.ndarray | None
    warp: MarginalWarp
    values: np.ndarray
    is_rgb: bool = False
    reduction: int = 1
    description: str = ""
    remarks: tuple[Remark, ...] = ()

    @property
    def is_isotropic(self) -> bool:
        """Whether a turn of the sample about its normal changes nothing."""
        return len(self.azimuths) <= 2

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF of pairs of directions. (n, 3), (n, 3) -> (n, w) float64 [1/sr]"""
        wi, wo = np.asarray(wi, dtype=np.float64), np.asarray(wo, dtype=np.float64)
        above = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
        wi, wo = self._fold(wi, wo)
        half = wi + wo
        incidence, azimuth = _polar(wi)
        polar, turn = _polar(half)
        u = np.sqrt(2.0 * polar / np.pi)
        v = _turn_to_unit(turn - azimuth if self.is_isotropic else turn)
        v -= np.floor(v)
        corners = self.warp.slices.corners((azimuth, incidence))
        found = self._read(*self.warp.make_even(u, v, corners), corners)
        factor = np.where(above, 1.0 / np.maximum(wo[:, 2], SMALLEST_COSINE), 0.0)
        if self.facets is not None:
            area = read_bilinear(
                self.visible_area, np.sqrt(2.0 * incidence / np.pi), _turn_to_unit(azimuth)
            )
            factor *= read_bilinear(self.facets, u, v) / (4.0 * np.maximum(area, 1e-12))
        found *= factor[:, None]
        return spectra_of_rgb(found)[1] if self.is_rgb else found

    def _fold(self, wi, wo):
        """Both directions brought to the part of the turn that is stored."""
        if self.reduction < 2 or self.is_isotropic:
            return wi, wo
        y = np.where(np.signbit(wi[:, 1]), 1.0, -1.0)
        x = np.where(np.signbit(wi[:, 0]), 1.0, -1.0) if self.reduction == 4 else y
        sign = np.stack([x, y, np.ones(len(wi))], axis=1)
        return wi * sign, wo * sign

    def _read(self, x, y, corners) -> np.ndarray:
        """Tabulated values, linear between all grid points. (n, b)"""
        count, bands = self.values.shape[2:]
        (row, down), (column, along) = place_in(count, y), place_in(count, x)
        flat = self.values.reshape(-1, bands)
        found = np.zeros((len(x), bands))
        for number, weight in corners:
            first = (number * count + row) * count + column
            for step, share in (
                (0, (1.0 - down) * (1.0 - along)),
                (1, (1.0 - down) * along),
                (count, down * (1.0 - along)),
                (count + 1, down * along),
            ):
                found += (weight * share)[:, None] * flat.take(first + step, axis=0)
        return found


def _polar(direction) -> tuple[np.ndarray, np.ndarray]:
    """Angle to the normal and azimuth in -pi to pi of directions of any length. (n, 3) -> (n,), (n,) [rad]"""
    x, y, z = direction.T
    return np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)


def _turn_to_unit(azimuth):
    return (azimuth + np.pi) / (2.0 * np.pi)


# ---- reading ----


def parse_tensor_file(data: bytes, path) -> TensorMaterial:
    """Read the arrays of a tensor file and check that they fit together.

    Raises
    ------
    FileFormatError    As `read_tensor_file`.
    """
    fields = _Fields(data, path)
    azimuths = fields.axis("phi_i", -7.0, 7.0)
    incidences = fields.axis("theta_i", 0.0, 0.5 * np.pi)
    count = len(azimuths), len(incidences)
    density = fields.numbers("vndf", 4, count)
    if density.min() < 0.0 or not density.sum(axis=(2, 3)).all():
        fields.fail("has a field 'vndf' with negative values, or with nothing but zeros")
    is_rgb = "spectra" not in fields.arrays and "rgb" in fields.arrays
    remarks = []
    if is_rgb:
        spectra = fields.numbers("rgb", 5, (*count, 3))
        wavelengths = spectra_of_rgb(np.zeros((1, 3)))[0]
        remarks.append(Remark("holds colours, of which smooth spectra are made"))
    else:
        wavelengths = fields.axis("wavelengths", 100.0, 1e5)
        spectra = fields.numbers("spectra", 5, (*count, len(wavelengths)))
        wavelengths, spectra, remark = _thin(wavelengths, spectra)
        remarks += [remark] if remark else []
    if spectra.shape[3] != spectra.shape[4]:
        fields.fail(f"has values of {spectra.shape[3]} x {spectra.shape[4]}, expected a square")
    # All bands of a direction beside each other; a copy, which may be written to.
    values = np.array(np.moveaxis(spectra, 2, 4), dtype=np.float32, order="C")
    low = np.count_nonzero(values < 0.0)
    if low:
        remarks.append(Remark(f"has {low} negative values, taken as 0"))
        np.maximum(values, 0.0, out=values)
    has_facets = fields.flag("jacobian")
    span = float(azimuths[-1] - azimuths[0])
    return TensorMaterial(
        azimuths,
        incidences,
        wavelengths,
        fields.numbers("ndf", 2).astype(np.float64) if has_facets else None,
        fields.numbers("sigma", 2).astype(np.float64) if has_facets else None,
        MarginalWarp(density, Slices((azimuths, incidences))),
        values.reshape(-1, *values.shape[2:]),
        is_rgb,
        max(round(2.0 * math.pi / span), 1) if len(azimuths) > 2 else 1,
        fields.text("description"),
        tuple(remarks),
    )


def _thin(wavelengths, spectra):
    """Spectra at coarser wavelengths, where the file's are finer than light has need of."""
    low, high = max(wavelengths[0], MINIMUM_WAVELENGTH), min(wavelengths[-1], MAXIMUM_WAVELENGTH)
    count = math.floor((high - low) / WIDEST_STEP) + 1
    if high <= low or len(wavelengths) <= 1.5 * count:
        return wavelengths, spectra, None
    chosen = np.linspace(low, high, count)
    below = np.clip(np.searchsorted(wavelengths, chosen) - 1, 0, len(wavelengths) - 2)
    step = wavelengths[below + 1] - wavelengths[below]
    share = ((chosen - wavelengths[below]) / step).astype(np.float32)[:, None, None]
    made = spectra[:, :, below] * (1.0 - share) + spectra[:, :, below + 1] * share
    remark = Remark(
        f"has {len(wavelengths)} wavelengths, read at {count} from {low:.0f} to {high:.0f} nm"
    )
    return chosen, made, remark


class _Fields:
    """The arrays of a file by their names; they are views of its bytes, so what a head claims takes no memory."""

    def __init__(self, data: bytes, path):
        self.data, self.path = data, path
        self.place = len(SIGNATURE)
        major, _, count = self.take("BBI")
        if major != 1:
            self.fail(f"is of version {major}, expected 1")
        if count > MOST_FIELDS:
            self.fail(f"states {count} fields, expected at most {MOST_FIELDS}")
        self.arrays = dict(self.field() for _ in range(count))

    def fail(self, message: str):
        raise FileFormatError(self.path, message)

    def take(self, kinds: str) -> tuple:
        """The next numbers, of kinds as of `struct`."""
        size = struct.calcsize("<" + kinds)
        if self.place + size > len(self.data):
            self.fail(f"ends at byte {len(self.data)}, within its list of fields: it is cut short")
        found = struct.unpack_from("<" + kinds, self.data, self.place)
        self.place += size
        return found

    def field(self) -> tuple[str, np.ndarray]:
        """The next array and its name."""
        (length,) = self.take("H")
        raw = b"".join(self.take(f"{length}s"))
        name = raw.decode("utf-8", "replace")[:40]
        axes, kind, offset = self.take("HBQ")
        if axes > MOST_AXES or kind not in TYPES:
            self.fail(f"has a field {name!r} of {axes} axes and type {kind}, which is unknown")
        shape = self.take(f"{axes}Q")
        kind = np.dtype(TYPES[kind])
        size = math.prod(shape) * kind.itemsize
        if offset + size > len(self.data):
            self.fail(
                f"is cut short: the field {name!r} ends at byte {offset + size} of {len(self.data)}"
            )
        if size == 0:
            return name, np.zeros(tuple(min(count, 1) for count in shape), kind)[:0]
        return name, np.frombuffer(self.data, kind, math.prod(shape), offset).reshape(shape)

    def get(self, name: str) -> np.ndarray:
        """A field that must be there."""
        if name not in self.arrays:
            self.fail(f"lacks the field '{name}'; it is no measured material")
        return self.arrays[name]

    def numbers(self, name: str, axes: int, first: tuple[int, ...] = ()) -> np.ndarray:
        """A field of finite numbers with two points at least along its last two axes, and given lengths of the first."""
        found = self.get(name)
        if found.dtype.kind != "f" or found.ndim != axes or found.shape[: len(first)] != first:
            wanted = " x ".join([*map(str, first), *"n" * (axes - len(first))])
            self.fail(
                f"has a field '{name}' of {found.dtype} {' x '.join(map(str, found.shape))}, "
                f"expected float32 {wanted}"
            )
        if axes > 1 and min(found.shape[-2:]) < 2:
            self.fail(f"has a field '{name}' with fewer than two rows or columns")
        # Larger ones are no quantity that the file could tell, and their sums would be infinite.
        if not found.size or not np.isfinite(found).all() or np.abs(found).max() > 1e30:
            self.fail(f"has a field '{name}' that is empty or has values that are no numbers")
        return found

    def axis(self, name: str, low: float, high: float) -> np.ndarray:
        """A field of ascending numbers within bounds."""
        found = self.numbers(name, 1).astype(np.float64)
        if np.any(np.diff(found) <= 0.0) or found[0] < low or found[-1] > high * (1.0 + 1e-6):
            self.fail(f"has a field '{name}' that does not ascend from {low:g} to {high:.5g}")
        return found

    def flag(self, name: str) -> bool:
        """A field of one number, as whether it is set."""
        found = self.get(name)
        if found.size != 1:
            self.fail(f"has a field '{name}' of {found.size} values, expected one")
        return bool(found.ravel()[0])

    def text(self, name: str) -> str:
        """A field of letters, empty where there is none."""
        raw = self.arrays.get(name, np.zeros(0, np.uint8))
        return raw.tobytes()[:4096].decode("utf-8", "replace").strip("\0 \r\n")


# ---- writing ----


def write_tensor_file(
    path,
    evaluate: Callable[[np.ndarray, np.ndarray], np.ndarray],
    theta_i,
    wavelengths,
    n: int = 64,
    description: str = "",
) -> bytes:
    """Write the reflection of an isotropic material so that Mitsuba and others read it.

    Values lie evenly on the half vector's square, without a density of facets; narrow lobes need a large ``n``.

    Parameters
    ----------
    path : path or None    None: nothing is written.
    evaluate : callable    BRDF of pairs wi, wo: (n, 3), (n, 3) -> (n, w). [1/sr]
    theta_i : (t,) array    Angles of incidence, strictly ascending. [rad]
    wavelengths : (w,) array    Strictly ascending. [nm]
    n : int    Points along each side of the square.
    description : str

    Returns
    -------
    bytes    The content of the file.
    """
    theta_i, wavelengths = (np.asarray(axis, dtype=np.float64) for axis in (theta_i, wavelengths))
    u, v = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, n))
    polar, turn = 0.5 * np.pi * u.ravel() ** 2, (2.0 * v.ravel() - 1.0) * np.pi
    sine = np.sin(polar)
    half = np.stack([sine * np.cos(turn), sine * np.sin(turn), np.cos(polar)], axis=1)
    spectra = np.zeros((1, len(theta_i), len(wavelengths), n, n), dtype="<f4")
    luminance = np.zeros((1, len(theta_i), n, n), dtype="<f4")
    for k, theta in enumerate(theta_i):
        wi = np.array([np.sin(theta), 0.0, np.cos(theta)])
        across = half @ wi
        wo = 2.0 * across[:, None] * half - wi
        seen = (across > 0.0) & (wo[:, 2] > 0.0)
        towards = np.broadcast_to(wi, wo.shape)[seen]
        values = np.zeros((n * n, len(wavelengths)))
        values[seen] = np.maximum(evaluate(towards, wo[seen]) * wo[seen, 2:], 0.0)
        spectra[0, k] = values.T.reshape(-1, n, n)
        # By this readers choose directions: the light that goes there, over how densely the square is spread there.
        stretch = np.maximum(2.0 * np.pi**2 * u.ravel() * sine, 1e-6) * 4.0
        chosen = values.mean(axis=1) * stretch * np.maximum(across, 0.0) + 1e-6
        luminance[0, k] = chosen.reshape(n, n)
    even = np.ones((2, 2), dtype="<f4")
    data = pack_fields(
        {
            "description": np.frombuffer(description.encode() or b" ", np.uint8),
            "jacobian": np.zeros(1, np.uint8),
            "phi_i": np.zeros(1, "<f4"),
            "theta_i": theta_i.astype("<f4"),
            "wavelengths": wavelengths.astype("<f4"),
            "ndf": even,
            "sigma": even,
            "vndf": np.ones((1, len(theta_i), 2, 2), "<f4"),
            "luminance": luminance,
            "spectra": spectra,
        }
    )
    if path is not None:
        with write_whole(path) as file:
            file.write(data)
    return data


def pack_fields(arrays: dict[str, np.ndarray]) -> bytes:
    """Write arrays of uint8 and float32 into the container, by their names."""
    names = {name: name.encode() for name in arrays}
    place = len(SIGNATURE) + 6
    place += sum(13 + len(names[name]) + 8 * array.ndim for name, array in arrays.items())
    head = [SIGNATURE, struct.pack("<BBI", 1, 0, len(arrays))]
    body = []
    for name, array in arrays.items():
        kind = 1 if array.dtype == np.uint8 else 10
        raw = np.ascontiguousarray(array, dtype=TYPES[kind]).tobytes()
        # Arrays begin at multiples of eight bytes.
        gap = -place % 8
        body += [bytes(gap), raw]
        head.append(struct.pack("<H", len(names[name])) + names[name])
        head.append(struct.pack("<HBQ", array.ndim, kind, place + gap))
        head.append(struct.pack(f"<{array.ndim}Q", *array.shape))
        place += gap + len(raw)
    return b"".join(head + body)
