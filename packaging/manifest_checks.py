"""The manifest of an extension: what Blender, or we ourselves, would refuse."""

import re
from collections.abc import Iterator
from itertools import chain

from project import BuildError
from targets import PLATFORM_TAGS

KEYS = {
    "schema_version": str, "id": str, "name": str, "version": str, "tagline": str, "maintainer": str, "type": str,
    "license": list, "blender_version_min": str, "platforms": list, "wheels": list,
}  # fmt: skip
"""Keys that must be there, and the kinds of their values."""

OPTIONAL_KEYS = {
    "tags": list,
    "copyright": list,
    "permissions": dict,
    "website": str,
    "blender_version_max": str,
}
"""Keys that may be there."""

PATTERNS = {
    "schema_version": (r"1\.0\.0", "1.0.0"),
    "id": (r"[a-z][a-z0-9]*(_[a-z0-9]+)*", "a Python name in lower case"),
    "version": (r"\d+\.\d+\.\d+([-+][0-9A-Za-z.-]+)?", "a version such as 1.2.3"),
    "type": (r"add-on", "add-on"),
    "blender_version_min": (r"\d+\.\d+\.\d+", "a version such as 4.2.0"),
}
"""What some of the texts must look like."""

LONGEST_LINE = 64
"""Characters of a tagline or of the reason for a permission, at most."""


def check_manifest(zip_name: str, manifest: dict) -> None:
    """Check a manifest as far as that goes without Blender.

    Raises
    ------
    BuildError    It has a fault; one sentence tells the key, what was found and what is expected.
    """
    fault = next(chain(_faults_of_keys(manifest), _faults_of_texts(manifest)), None)
    if fault:
        raise BuildError(f"{zip_name}: in blender_manifest.toml {fault}")


def _faults_of_keys(manifest: dict) -> Iterator[str]:
    missing = [key for key in KEYS if key not in manifest]
    if missing:
        yield f"{', '.join(missing)} must be stated"
    for key, value in manifest.items():
        kind = {**KEYS, **OPTIONAL_KEYS}.get(key)
        if kind is None:
            yield f"{key} is no key that we use"
        elif not isinstance(value, kind):
            yield f"{key} is {type(value).__name__}, expected {kind.__name__}"
        elif kind is list and not (value and all(isinstance(each, str) for each in value)):
            yield f"{key} must be a list of at least one text"
        elif kind is dict and not all(isinstance(each, str) for each in value.values()):
            yield f"{key} must give a text for each"


def _faults_of_texts(manifest: dict) -> Iterator[str]:
    """Tell faults of a manifest whose keys are all there and of the right kinds."""
    for key, (pattern, expected) in PATTERNS.items():
        if not re.fullmatch(pattern, manifest[key]):
            yield f"{key} is '{manifest[key]}', expected {expected}"
    for platform in manifest["platforms"]:
        if platform not in PLATFORM_TAGS:
            yield f"the platform '{platform}' is none of {', '.join(PLATFORM_TAGS)}"
    for text in manifest["license"]:
        if not text.startswith("SPDX:"):
            yield f"the license '{text}' does not begin with SPDX:"
    for what, text in (("tagline", manifest["tagline"]), *manifest.get("permissions", {}).items()):
        if not 0 < len(text) <= LONGEST_LINE or not (text[-1].isalnum() or text[-1] in ")]}"):
            yield f"{what} must have at most {LONGEST_LINE} characters and no full stop: '{text}'"
