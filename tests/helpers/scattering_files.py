"""Scattering files made from a function of two directions, by the formulas of each format's description."""

import struct
import zlib

import numpy as np
from scattering_models import towards


def handed(wi, wo):
    """A BRDF with a lobe about the mirror direction that tells the left from the right. (n, 3), (n, 3) -> (n,)"""
    mirror = wi * np.array([-1.0, -1.0, 1.0])
    across = wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0]
    away = np.arccos(np.clip((mirror * wo).sum(axis=1), -1.0, 1.0))
    return 0.1 + 0.05 * across + 0.2 * np.exp(-((away / 0.6) ** 2))


def alike(wi, wo):
    """The same without a difference of sides."""
    return 0.5 * (handed(wi, wo) + handed(wi * [1.0, -1.0, 1.0], wo * [1.0, -1.0, 1.0]))


def reflectance(brdf, incidence):
    """Hemispherical reflectance at an angle of incidence [degree], by the midpoint rule."""
    theta, phi = np.arange(0.25, 90.0, 0.5), np.arange(1.0, 360.0, 2.0)
    wo = towards(theta[:, None], phi).reshape(-1, 3)
    wi = np.broadcast_to(towards(incidence, 0.0), wo.shape)
    weight = np.repeat(np.sin(2.0 * np.radians(theta)), len(phi))
    return float(np.pi * (brdf(wi, wo) * weight).sum() / weight.sum())


def zemax(brdf=handed, incidences=(0, 30, 60), azimuths=tuple(range(0, 361, 15)), radials=tuple(range(0, 181, 6)),
          symmetry="Asymmetrical", kind="BRDF", content="Monochrome", totals=None, rotations=(0,)):  # fmt: skip
    """A table of Zemax; its directions are those of the format's own formula."""
    lists = {
        "SampleRotation": rotations,
        "AngleOfIncidence": incidences,
        "ScatterAzimuth": azimuths,
        "ScatterRadial": radials,
    }
    lines = ["#made by hand", "Source Measured", f"Symmetry {symmetry}"]
    lines += [f"SpectralContent {content}", f"ScatterType {kind}"]
    for name, angles in lists.items():
        lines += [f"{name} {len(angles)}", "\t".join(map(str, angles))]
    names = (
        ("TristimulusX", "TristimulusY", "TristimulusZ") if content == "XYZ" else ("Monochrome",)
    )
    for name in names:
        lines += ["", name, "DataBegin"]
        for _ in rotations:
            for k, theta in enumerate(np.radians(incidences)):
                s = np.array([np.sin(theta), 0.0, np.cos(theta)])
                t = np.array([-np.cos(theta), 0.0, np.sin(theta)])
                total = reflectance(brdf, np.degrees(theta)) if totals is None else totals[k]
                lines.append(f"TIS {total:.6f}")
                r, a = np.radians(radials)[:, None], np.radians(azimuths)[:, None, None]
                wo = np.cos(r) * s + np.sin(r) * (np.cos(a) * t + np.sin(a) * np.cross(s, t))
                # The mirror direction is s, so light comes from the other side.
                wi = np.broadcast_to([-s[0], 0.0, s[2]], (wo.size // 3, 3))
                values = np.where(
                    wo[..., 2] < 0.0, 0.0, brdf(wi, wo.reshape(-1, 3)).reshape(wo.shape[:2])
                )
                factor = 1.0 if name in {"Monochrome", "TristimulusY"} else 0.5
                lines += ["\t".join(f"{factor * v:.5e}" for v in row) for row in values]
        lines.append("DataEnd")
    return "\n".join(lines).encode()


def lighttools(brdf=handed, incidences=(0, 30, 60), azimuths=tuple(range(0, 361, 15)), radials=tuple(range(0, 91, 6)),
               light=90.0, planes=(0,), side="Front", kind="BRDF", bands=(), totals=None):  # fmt: skip
    """A table of LightTools, light coming from an azimuth beyond the plane of incidence."""
    lines = [
        "#made by hand",
        "Source Measured",
        "Symmetry Asymmetrical",
        "SpectralContent Monochrome",
    ]
    lines += [f"ScatterAzimuth {len(azimuths)}", " ".join(map(str, azimuths))]
    lines += [f"ScatterRadial {len(radials)}", " ".join(map(str, radials))]
    for plane in planes:
        for k, incidence in enumerate(incidences):
            for band in bands or (None,):
                lines += [f"AOI {incidence}", f"POI {plane}", f"Side {side}"]
                lines += [f"Wavelength {band}"] if band else []
                factor = band / 500.0 if band else 1.0
                total = factor * reflectance(brdf, incidence) if totals is None else totals[k]
                lines += [f"ScatterType {kind}", f"TIS {total:.6f}"]
                wo = towards(np.array(radials), np.array(azimuths)[:, None])
                wi = np.broadcast_to(towards(incidence, light + plane), (wo.size // 3, 3))
                values = factor * brdf(wi, wo.reshape(-1, 3)).reshape(wo.shape[:2])
                lines += [" ".join(f"{v:.5e}" for v in row) for row in values]
    return "\n".join(lines).encode()


def _speos_table(brdf, incidence, thetas, phis, mirror, is_intensity=False):
    """Rows of one table of SPEOS, the mirror direction at an azimuth."""
    wo = towards(np.array(thetas)[:, None], np.array(phis) - mirror)
    wi = np.broadcast_to(towards(incidence, 180.0), (wo.size // 3, 3))
    values = brdf(wi, wo.reshape(-1, 3)).reshape(wo.shape[:2])
    return values * wo[..., 2] if is_intensity else values


def _rows(thetas, phis, values):
    lines = [f"{len(thetas)} {len(phis)}", "\t" + "\t".join(map(str, phis))]
    return lines + [
        f"{t}\t" + "\t".join(f"{v:.6g}" for v in row) for t, row in zip(thetas, values, strict=True)
    ]


THETAS, PHIS = tuple(range(0, 91, 6)), tuple(range(0, 361, 15))


def anisotropic(brdf=handed, incidences=(0, 30, 60), thetas=THETAS, phis=PHIS, mirror=0.0, turns=(0,),
                is_intensity=False, spectrum=((400, 50.0), (700, 25.0)), factors=None, at=30):  # fmt: skip
    """A SPEOS table as text; ``factors`` makes it differ by the angle of the sample."""
    lines = ["OPTIS - Anisotropic BSDF surface file v8.0", "0", "my surface", "11", "description"]
    lines += [
        "1\t0\t0",
        "1\t0",
        str(int(not is_intensity)),
        str(len(turns)),
        " ".join(map(str, turns)),
    ]
    for _ in turns:
        lines += [str(len(incidences)), "\t".join(map(str, incidences))]
    lines += [f"{at}\t{turns[0]}", "", str(len(spectrum))]
    lines += [f"{w}\t{p}" for w, p in spectrum]
    for k in range(len(turns)):
        for incidence in incidences:
            values = _speos_table(brdf, incidence, thetas, phis, mirror, is_intensity)
            lines += _rows(thetas, phis, values * (factors[k] if factors else 1.0))
    return "\n".join([*lines, "End of file", ""]).encode()


def lz4_block(numbers) -> bytes:
    """An array as a binary SPEOS file holds it, packed as one run of plain bytes."""
    data = np.asarray(numbers, dtype="<f8").tobytes()
    packed = bytes([min(len(data), 15) << 4])
    if len(data) >= 15:
        packed += b"\xff" * ((len(data) - 15) // 255) + bytes([(len(data) - 15) % 255])
    packed += data
    return struct.pack("<QII", len(data), len(data), len(packed)) + packed


def anisotropic_binary(brdf=handed, incidences=(0, 30, 60), thetas=THETAS, phis=PHIS):
    """The same in binary, as intensities, with one spectrum of 50 per cent at 30 degrees."""
    data = b"OPTIS - Anisotropic BSDF surface file v9.0\n1"
    data += bytes.fromhex("03000000 01000000 00000000 00000000 00")
    data += struct.pack("<3d2B2d2B", 1, 0, 0, 1, 0, 1, 1, 0, 0)
    data += struct.pack("<I", 1) + lz4_block([0.0])
    data += struct.pack("<I", len(incidences)) + lz4_block(incidences)
    data += struct.pack("<2dII4d", 30.0, 0.0, 0, 2, 400.0, 700.0, 50.0, 50.0)
    for incidence in incidences:
        values = _speos_table(brdf, incidence, thetas, phis, 0.0, is_intensity=True)
        data += struct.pack("<II", len(thetas), len(phis))
        data += lz4_block(thetas) + lz4_block(phis) + lz4_block(values.ravel())
    return data + struct.pack("<2d", 1.0, 1.0)


def brdf_text(brdf=handed, incidences=(0, 30, 60), bands=(450, 650), has_back=True, totals=None):
    """A SPEOS table for each angle of incidence and wavelength, in twice the light at the second."""
    lines = [
        "OPTIS - brdf surface file v8.0",
        "0",
        "comment",
        "4",
        "text",
        f"1 {int(has_back)}",
        "1",
    ]
    lines += [
        f"{len(incidences)} {len(bands)}",
        " ".join(map(str, incidences)),
        " ".join(map(str, bands)),
    ]
    for is_back in (False, True)[: 1 + has_back]:
        for k, incidence in enumerate(incidences):
            for band in range(len(bands)):
                part = 0.5 * (1 + band) * (0.25 if is_back else 1.0)
                total = 100.0 * part * (totals[k] if totals else reflectance(brdf, incidence))
                thetas = 180 - np.array(THETAS)[::-1] if is_back else np.array(THETAS)
                values = _speos_table(brdf, incidence, THETAS, PHIS, 0.0)
                values = part * (values[::-1] if is_back else values)
                lines += [f"{total:.5f}", *_rows(thetas, PHIS, values)]
    return "\n".join([*lines, "End of file"]).encode()


def scattering(rows=((0, 4, 20, 30, 10, 0), (60, 10, 20, 30, 10, 0)), bands=(400, 700)):
    """Shares of a mixture: angle, direct, Lambertian, Gaussian, and two widths; transmission has a tenth of each."""
    lines = ["OPTIS - Scattering surface file v1.0", "paint", f"{len(rows)} {len(bands)}"]
    lines.append("\t".join(map(str, bands)))
    for angle, *shares in rows:
        for k, share in enumerate(shares):
            passed = 0.1 * share if k < 3 else share
            pairs = "\t".join([f"{share}\t{passed:g}"] * len(bands))
            lines.append((f"{angle}" if k == 0 else "") + "\t" + pairs)
    return "\n".join(lines).encode()


def simple(numbers="20 30 60 20", mode="Reflection"):
    """Shares of a mixture at all angles."""
    return f"OPTIS - Simple scattering surface file v2.0\nLeather\n{mode}\n{numbers}\n".encode()


ANGLES, BANDS = (0.0, 45.0, 90.0), (400.0, 700.0)

SHARES = np.array(
    [
        [[[4, 95], [5, 94]], [[4, 95], [5, 94]]],
        [[[2, 97], [3, 96]], [[10, 89], [11, 88]]],
        [[[100, 0], [100, 0]], [[100, 0], [100, 0]]],
    ],
    dtype=float,
)
"""Per cent by angle, polarisation, wavelength, and reflected or transmitted."""


def coated():
    """A coated surface as text."""
    lines = ["OPTIS - Coated surface file v1.0", "glass", "3 2", "400 700"]
    for angle, rows in zip(ANGLES, SHARES, strict=True):
        lines.append(f"{angle}\t" + "\t".join(map(str, rows[0].ravel())))
        lines.append("\t" + "\t".join(map(str, rows[1].ravel())))
    return "\n".join(lines).encode()


def packed(data: bytes, size=None) -> bytes:
    """A zlib block after its sizes."""
    held = zlib.compress(data)
    return struct.pack("<II", len(data) if size is None else size, len(held)) + held


def bsdf180():
    """Coated surfaces of both sides, that of the back with half of the light."""
    data = b"OPTIS - BSDF180 file v1\n" + struct.pack("<I", 4) + packed(b"both")
    data += struct.pack("<II", 1, 1)
    for factor in (1.0, 0.5):
        data += b"OPTIS - Coated surface file v2\n" + struct.pack("<II", 3, 5) + packed(b"glass")
        data += struct.pack("<II", 3, 2) + packed(np.array(BANDS).tobytes())
        data += packed(np.array(ANGLES).tobytes())
        for kind in (0, 1):
            for polarisation in (0, 1):
                data += packed((factor * SHARES[:, polarisation, :, kind]).tobytes())
    return data


def mdl_block(values) -> bytes:
    """Values by angle of incidence, of scattering, and azimuth, and by colour if they have one more axis."""
    values = np.asarray(values, dtype="<f4")
    return struct.pack("<3I", values.ndim - 3, values.shape[0], values.shape[2]) + values.tobytes()


def mdl(brdf=alike, polars=15, azimuths=24, colour=None, marks=("_REFLECTION",)):
    """A file of MDL."""
    theta = (np.arange(polars) + 0.5) * 90.0 / polars
    phi = (np.arange(azimuths) + 0.5) * 180.0 / azimuths
    wo = np.broadcast_to(towards(theta[:, None], phi), (polars, polars, azimuths, 3)).reshape(-1, 3)
    wi = np.broadcast_to(towards(theta, 0.0)[:, None, None], (polars, polars, azimuths, 3)).reshape(
        -1, 3
    )
    values = brdf(wi, wo).reshape(polars, polars, azimuths)
    if colour is not None:
        values = values[..., None] * np.asarray(colour)
    data = b"NVIDIA ARC MBSDF V1\n"
    for mark in marks:
        data += f"MBSDF_DATA{mark}=\n".encode() + mdl_block(values)
    return data
