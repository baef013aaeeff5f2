"""What we compute for each reference value."""

import math
from dataclasses import replace

import numpy as np

from ...engine.paint.composition import Diameters, face_densities, volume_fractions
from ...engine.paint.explicit_flakes import walk_among_discs
from ...engine.paint.first_order import pairs_of
from ...engine.paint.flake_optics import find_shares
from ...engine.paint.fresnel import face_reflectance, face_shares
from ...engine.paint.mie import scatter_spheres
from ...engine.paint.orientation import density
from ...engine.paint.photon_walk import walk
from ...engine.paint.slab import Rates, find_slab
from ...engine.paint.solution import Resolution, solve
from .makers import interference, make_paint, mirrors, one_layer, sample
from .reference import entries
from .slabs import make_slab, shares_of

NORMAL_AND_45 = np.sin(np.radians([0.0, 45.0]))

SAMPLE_ANGLES = [(45, 15), (45, 25), (45, 45), (45, 75), (45, 110), (15, 15), (15, 45)]

STACKS = {
    "viola SiO2 448 / TiO2 12": (448, 1.5, 12),
    "xirallic Al2O3 230 / TiO2 165": (230, 1.77, 165),
    "xirallic silver Al2O3 230 / TiO2 60": (230, 1.77, 60),
    "xirallic silver Al2O3 300 / TiO2 60": (300, 1.77, 60),
}

ALUMINIUM = {
    "wavelengths_nm": [450, 550, 650],
    "n": [0.6332, 1.0152, 1.5580],
    "k": [5.4543, 6.6273, 7.7124],
}

BANDS = (450.0, 550.0, 650.0)

PHOTONS = 200_000
"""Of walks through a continuum."""

DISC_PHOTONS = 24_000
"""Of walks among discs."""


def aspecular(angles):
    """Directions of (incidence, aspecular angle) in degrees: two (n, 3) arrays."""
    first, last = np.radians([(i, i - a) for i, a in angles]).T
    zero = np.zeros_like(first)
    wi = np.stack([np.sin(first), zero, np.cos(first)], axis=1)
    return wi, np.stack([-np.sin(last), zero, np.cos(last)], axis=1)


def find_values(say) -> dict:
    """Our value, or value and standard error, for the ids that we compute."""
    found = {}
    for part in (_slabs, _faces, _piles, _stacks, _amounts, _samples, _media, _discs, _optics):
        say(part.__name__.strip("_"))
        found |= part()
    return found


def _slabs() -> dict:
    found = {}
    for name in entries():
        if name.startswith("A1.H1."):
            albedo = float(name.rpartition(".a")[2])
            directions, reflected, _ = make_slab(albedo, 1e5, count=300)
            root = np.sqrt(directions.weights)
            normal = directions.interpolation([0.0])[0]
            kernel = reflected / np.outer(root, root)
            plane = float(normal @ kernel @ directions.weights)
            found[f"A1.UR1.a{albedo}"] = plane
            found[f"A1.H1.a{albedo}"] = (1.0 - plane) / math.sqrt(1.0 - albedo)
            found[f"A1.URU.a{albedo}"] = float(directions.weights @ kernel @ directions.weights)
            found[f"A1.R11.a{albedo}"] = float(normal @ kernel @ normal)
        elif name.startswith(("A2.slab.", "A2i.slab.")):
            # A2.slab.a0.99.b4.g0.5
            albedo, rest = name.split(".slab.a")[1].split(".b")
            depth, asymmetry = rest.split(".g")
            found[name] = shares_of(float(albedo), float(depth), float(asymmetry), count=128)
        elif name.startswith(("A3.air.", "A3i.air.")):
            albedo, rest = name.split(".air.a")[1].split(".b")
            depth, rest = rest.split(".g")
            asymmetry, index = rest.split(".n")
            # Of 1 / 1.01 the name holds four digits.
            albedo = 1.0 / 1.01 if albedo == "0.9901" else float(albedo)
            found[name] = shares_of(
                albedo, min(float(depth), 1e5), float(asymmetry), float(index), 128
            )
    found["A2.vdH.slab.g0.75"] = found["A2.slab.a0.9.b2.g0.75"][:2]
    found["A2.Giovanelli"] = found["A3.air.a0.9000.binf.g0.n1.5"][0]
    return found


def _faces() -> dict:
    found = {}
    sines = np.sin(np.radians([0, 30, 45, 60, 75, 85]))
    places, weights = np.polynomial.legendre.leggauss(400)
    cosines, weights = 0.5 * (places + 1.0), 0.5 * weights
    for index in (1.45, 1.5, 1.557, 1.558):
        reflected = face_reflectance(np.sqrt(1.0 - cosines**2), 1.0, index)
        outside = float((2.0 * cosines * weights * reflected).sum())
        found[f"A4.F.n{index}"] = face_reflectance(sines, 1.0, index)
        found[f"A4.rext.n{index}"] = outside
        found[f"A4.rint.n{index}"] = 1.0 - (1.0 - outside) / index**2
        solution = solve(
            make_paint([(30, [], [], index)], 0.9), [550.0], resolution=Resolution(400, 1)
        )
        found[f"A4.saunderson.n{index}"] = float(
            (solution.albedo([0.0]) + solution.mirror([0.0]))[0, 0]
        )
    return found


def _level(paint):
    """A paint with flakes that lie as level as none that is made: tilted ones reach out of their layer."""
    layers = (
        replace(layer, flakes=tuple(replace(each, slope=1e-6) for each in layer.flakes))
        for layer in paint.layers
    )
    return replace(paint, layers=tuple(layers))


def _piles() -> dict:
    found = {}

    def continuum(r, t, depth):
        rates = Rates(np.array([[1.0 - t + r]]), np.array([[1.0 - t - r]]))
        return float(find_slab(rates, depth)[0][0, 0])

    for r, t, depth in ((1.0, 0.0, 2.0), (0.5, 0.5, 2.0), (0.9, 0.0, 2.0), (0.9, 0.0, math.inf)):
        found[f"A5.parallel.r{r}.t{t}.aH{depth}"] = continuum(r, t, min(depth, 1e6))
    for r, depth in ((1.0, 2.0), (0.9, 2.0), (0.9, math.inf)):
        thickness, area = 100.0, min(depth, 12.0) / 100.0
        paint = one_layer(
            [mirrors(r, 0.5, area, diameter={"median_um": 2000})], thickness=thickness, index=1.0001
        )
        made = walk_among_discs(_level(paint), 550.0, 0.0, DISC_PHOTONS, 5)
        found[f"A5.parallel_big.r{r}.aH{depth}"] = made.albedo, made.error
    for r, depth in ((0.22, 3.459), (0.5, 2.0), (0.57, 0.744)):
        flakes = mirrors(r, 0.5, depth / 100.0, transmittance=1.0 - r, diameter={"median_um": 2000})
        paint = one_layer([flakes], thickness=100, index=1.0001)
        made = walk_among_discs(_level(paint), 550.0, 0.0, DISC_PHOTONS, 5)
        # Below all flakes lies black, so what is counted came back through the surface.
        found[f"A5.pile.r{r}.aH{depth}"] = (
            [made.albedo, continuum(r, 1.0 - r, depth)],
            [made.error, 1e-6],
        )
    return found


def _stacks() -> dict:
    found = {}
    angles = np.radians([0, 15, 30, 45, 60, 75])
    metal = {
        "mirror": {"index": ALUMINIUM, "thickness_nm": 100},
        "amount": {"volume_fraction": 0.01},
    }
    flakes = {name: interference(*stack, 0.01) for name, stack in STACKS.items()}
    for name, flake in (flakes | {"aluminium 100 nm": metal}).items():
        optics = one_layer([flake]).layers[0].flakes[0].optics
        across, within, *_ = find_shares(optics, np.full(3, 1.45), np.array(BANDS), np.cos(angles))
        for k, band in enumerate(BANDS):
            found[f"A6.stack.{name}.{band:.0f}"] = 0.5 * (across + within)[k]
        found[f"A6.stack_sp.{name}.550.45"] = [across[1, 3], within[1, 3]]
        if name in ("viola SiO2 448 / TiO2 12", "xirallic Al2O3 230 / TiO2 165"):
            for angle in (45, 60, 75):
                found[f"A15.pol.{name}.{angle}"] = _overestimate(optics, angle)
    return found


def _overestimate(optics, angle: float) -> np.ndarray:
    """By how much products of means are larger than means of products where a mirror would reflect (A15)."""
    sine = math.sin(math.radians(angle))
    faces = [1.0 - float(each) for each in face_shares(sine, 1.0, 1.45)]
    inside = math.sqrt(1.0 - (sine / 1.45) ** 2)
    across, within, *_ = (
        each[:, 0] for each in find_shares(optics, np.full(3, 1.45), np.array(BANDS), [inside])
    )
    means = 0.5 * (across + within) * (0.5 * (faces[0] + faces[1])) ** 2
    return means / (0.5 * (across * faces[0] ** 2 + within * faces[1] ** 2))


def _amounts() -> dict:
    found = {}
    for number in (1, 2):
        layer = sample(number).layers[0]
        area = face_densities(layer)[0]
        found[f"A7.sample{number}"] = [volume_fractions(layer)[0], area, area * 20.0]
    layer = sample(3).layers[0]
    found["A7.sample3"] = [sum(volume_fractions(layer)), *face_densities(layer)]
    sizes = Diameters.of_mass(7.9, 17.8, 35.8)
    # By area of faces, the median of the area is that of the mass.
    weighted = 0.25 * math.pi * sizes.moment_um(4.0) / sizes.moment_um(2.0)
    found["A13.size"] = [sizes.log_spread, sizes.median_um, weighted, sizes.face_um2]
    flakes = sample(2).layers[0].flakes[0]
    number = face_densities(sample(2).layers[0])[0] * 20.0 / Diameters(17.0).face_um2 * 1e6
    upright = float(density(1.0, flakes.slope))
    tolerance = math.pi * math.radians(0.25 + 0.17) ** 2 / (4.0 * 1.45**2)
    found["A13.sparkle"] = [number, upright, tolerance, number * upright * tolerance]
    return found


def _samples() -> dict:
    found = {}
    for number in (1, 2, 3):
        solution = solve(sample(number), list(BANDS), is_polarised=False)
        values, albedo = (
            solution.evaluate(*aspecular(SAMPLE_ANGLES)),
            solution.albedo(NORMAL_AND_45),
        )
        for k, band in enumerate(BANDS):
            found[f"A8.sample{number}.{band:.0f}.f"] = values[:, k]
            found[f"A8.sample{number}.{band:.0f}.albedo"] = albedo[:, k]
    return found


def _media() -> dict:
    fine = Resolution(40, 40)
    found = {}
    for name, paint in (
        ("opaque r.9 s5 aH2 black", one_layer([mirrors(0.9, 5)])),
        ("lossless r.5 t.5 s5 aH2 rho.5", one_layer([mirrors(0.5, 5, transmittance=0.5)], 0.5)),
    ):
        found[f"A9.AD.{name}"] = solve(paint, [550.0], resolution=fine).albedo(NORMAL_AND_45)[:, 0]
        walked = [walk(paint, 550.0, angle, PHOTONS, 11) for angle in (0.0, math.pi / 4)]
        found[f"A9.MC.{name}"] = [each.albedo for each in walked], [each.error for each in walked]
    white = solve(one_layer([interference(448, 1.5, 40, 0.1, 5)], 1.0), [550.0], resolution=fine)
    found["A9.furnace"] = (white.albedo(NORMAL_AND_45) + white.mirror(NORMAL_AND_45))[:, 0]
    kernels = white.kernels
    found["A9.reciprocity"] = float(
        np.abs(kernels - np.swapaxes(kernels, -1, -2)).max() / kernels.max()
    )
    # Mirrors at random reflect into all directions alike: half of their area is what light meets.
    directions, reflected, passed = make_slab(0.9, 1.0, count=96)
    root, normal = np.sqrt(directions.weights), directions.interpolation([0.0])[0]
    found["A14.random_flakes"] = [
        float(normal @ (each @ root / root)) for each in (reflected, passed)
    ]
    return found


def _discs() -> dict:
    found = {}
    for diameter in ("0.5", "6.0", "17.0", "50.0"):
        paint = one_layer([mirrors(0.9, 5, diameter={"median_um": float(diameter)})])
        for angle in (0, 45):
            # Small ones are many.
            photons = DISC_PHOTONS // (8 if diameter == "0.5" else 1)
            made = walk_among_discs(paint, 550.0, math.radians(angle), photons, 7 + angle)
            found[f"A10.explicit.D{diameter}.{angle}"] = made.albedo, made.error
    return found


def _optics() -> dict:
    found = {}
    solution = solve(one_layer([mirrors(0.9, 3)]), [550.0], is_polarised=False)
    found["A11.first_order"] = solution.first_order(
        pairs_of(*aspecular([(45, 15), (45, 0), (45, -15)]))
    )[:, 0]
    for name, index, size in (
        ("m(1.55+0j).x5.21282", 1.55, 5.21282),
        ("m(1.5-1j).x1.0", 1.5 + 1j, 1.0),
        ("m(1.5+0j).x10.0", 1.5, 10.0),
        ("m(1.33-1e-05j).x100.0", 1.33 + 1e-5j, 100.0),
    ):
        made = scatter_spheres(
            np.array([index + 0j]), Diameters(size / math.pi), np.ones(1), [1000.0]
        )
        scale = size / math.pi / 1.5
        found[f"A12.mie.{name}"] = [
            made.extinction[0] * scale,
            made.scattering[0] * scale,
            made.asymmetry[0],
        ]
    for name, index, diameter, around in (
        ("rutile TiO2 pigment in binder", 2.7, 0.25, 1.45),
        ("carbon black in binder", 1.75 + 0.44j, 0.03, 1.45),
        ("organic pigment in binder", 1.6 + 0.2j, 0.15, 1.45),
        ("TiO2 delustrant in fibre", 2.7, 0.25, 1.557),
        ("air void in cotton", 1.0, 0.5, 1.557),
        ("wax inclusion in cotton", 1.44, 1.0, 1.557),
    ):
        made = scatter_spheres(
            np.array([index + 0j]), Diameters(diameter), np.array([around]), [550.0]
        )
        scale = diameter / 1.5
        found[f"A12.mie.{name}"] = [
            math.pi * diameter * around / 0.55,
            made.extinction[0] * scale,
            made.scattering[0] * scale,
            made.asymmetry[0],
            made.extinction[0] * 0.01,
        ]
    return found
