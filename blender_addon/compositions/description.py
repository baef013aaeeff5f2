"""Descriptions in JSON and the settings that edit parts of them; what panels do not edit goes through unchanged."""

import hashlib
import json
import math

SAME = 1e-6
"""Relative difference up to which a number is the one that was stated: settings hold single precision."""


def to_text(content: dict) -> str:
    """Return a description as JSON text, the same for the same content."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def digest_of(content: dict, *terms: str) -> str:
    """Return SHA-256 of a description and of what else its table depends on, in hexadecimal."""
    return hashlib.sha256(" ".join((*terms, to_text(content))).encode()).hexdigest()


def is_same(stated, value) -> bool:
    """Tell whether a setting holds what a description states."""
    if isinstance(value, str) or stated is None:
        return stated == value
    return math.isclose(stated, value, rel_tol=SAME, abs_tol=1e-12)


def rounded(value):
    """Return a number of single precision as people would write it."""
    return value if isinstance(value, str) else float(f"{value:.7g}")


def scaled(spectrum, factor: float):
    """Return a spectrum of a description, a number or a table, times a factor."""
    if isinstance(spectrum, dict):
        return spectrum | {"values": [rounded(factor * each) for each in spectrum["values"]]}
    return rounded(factor * spectrum)


def read(content, path: tuple):
    """Return what stands in a description under names and numbers of places; None where nothing does."""
    for name in path:
        if isinstance(content, dict):
            content = content.get(name)
        elif isinstance(content, list) and name in range(len(content)):
            content = content[name]
        else:
            return None
    return content


def write(content: dict, path: tuple, value) -> None:
    """Put a value where `read` finds it; what lies about it is made anew and not changed in place."""
    name, *rest = path
    if rest:
        # Lists have been there, as nothing adds to them.
        inner = content[name].copy() if name in content or isinstance(content, list) else {}
        write(inner, rest, value)
        value = inner
    content[name] = value
