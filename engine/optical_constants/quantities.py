"""Spectra and refractive indices as descriptions in JSON state them."""

import math

import numpy as np

from .curves import Cauchy, Curve, Index, Spectrum


class Quantities:
    """Makes spectra and indices of what a checked description says of them.

    Parameters
    ----------
    indices : dict of str to dict    Entries with an ``index``, which a description may name.
    path : str or Path    Of the description.
    """

    def __init__(self, indices: dict, path=""):
        self.indices, self.path = indices, path

    def spectrum(self, content, place: str, most: float = math.inf) -> Spectrum:
        """Make a spectrum. Raises ValueError where it breaks what it has to keep, as `index`."""
        if isinstance(content, dict):
            curve = Curve(
                *read_pairs(content["wavelengths_nm"], content["values"], f"{place}.values")
            )
        else:
            curve = Curve(np.array([550.0]), np.array([float(content)]))
        if curve.values.max() > most:
            raise ValueError(
                f"{place} is {curve.values.max():g} somewhere, expected {most:g} at most"
            )
        return curve

    def index(self, content, place: str) -> Index:
        """Make a refractive index."""
        names = set()
        while isinstance(content, str):
            if content in names:
                raise ValueError(f"{place} names '{content}', which names itself")
            names.add(content)
            content = find_named(self.indices, "indices", content, place)["index"]
        if not isinstance(content, dict):
            return Curve(np.array([550.0]), np.array([float(content)]))
        if "cauchy_um" in content:
            index = Cauchy(tuple(float(term) for term in content["cauchy_um"]))
            if index.at([300.0, 1200.0]).min() < 1.0:
                raise ValueError(f"{place} falls below 1 between 300 and 1200 nm")
            return index
        wavelengths, values = read_pairs(content["wavelengths_nm"], content["n"], f"{place}.n")
        if "k" in content:
            values = (
                values + 1j * read_pairs(content["wavelengths_nm"], content["k"], f"{place}.k")[1]
            )
        if not np.abs(values).min() > 0.0:
            raise ValueError(f"{place} is 0 somewhere")
        return Curve(wavelengths, values)


def find_named(known: dict, kind: str, name: str, place: str) -> dict:
    """Return an entry by its name, without its source.

    Parameters
    ----------
    kind, place : str    What entries are, and where it is named, for the error.

    Raises
    ------
    ValueError    There is none of that name.
    """
    if name not in known:
        names = ", ".join(known) or "none"
        raise ValueError(
            f"{place} names '{name}', which is not among the {kind} of the library: {names}"
        )
    return {key: value for key, value in known[name].items() if key != "source"}


def read_pairs(places: list, values: list, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Return what ascends, such as wavelengths, and the values there. Raises ValueError where it does not."""
    if len(places) != len(values):
        raise ValueError(f"{where} has {len(values)} entries, expected {len(places)}")
    places = np.array(places, np.float64)
    if np.any(np.diff(places) <= 0.0):
        raise ValueError(f"{where}: the numbers that it goes by do not ascend")
    return places, np.array(values, np.float64)
