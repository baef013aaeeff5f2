"""The cluster pack: all that Dask asks for, in the versions of the development environment."""

import re
from importlib import metadata

import pytest
from built_wheels import METADATA, cluster_pins
from project import CLUSTER, ROOT, read_project
from targets import all_targets
from wheels import normalised, read_lock

PROJECT = read_project()


def needs_of(name):
    """Packages that an installed one needs here, without extras."""
    for line in metadata.requires(name) or ():
        if "extra ==" not in line and "platform_system" not in line:
            yield normalised(re.match(r"[\w.-]+", line)[0])


def test_it_has_all_that_dask_needs():
    held = {normalised(name) for name in CLUSTER}
    for name in CLUSTER:
        if name.lower() != "lazy-importer":
            assert set(needs_of(name)) <= held, name


def test_the_environment_has_the_same_versions():
    for name, version in PROJECT.cluster:
        assert metadata.version(name) == version


@pytest.mark.parametrize("target", all_targets(), ids=str)
def test_every_wheel_is_recorded(target):
    recorded = read_lock()
    for pin in cluster_pins(PROJECT, target):
        assert any(each.fits(*pin, target) for each in recorded), pin
    names = {name for name, _ in cluster_pins(PROJECT, target)}
    assert (set(METADATA) <= names) == (target.python == "cp311")


def test_the_pack_has_the_version_of_the_extension():
    manifest = (ROOT / "packaging/cluster/blender_manifest.toml").read_text()
    assert f'\nversion = "{PROJECT.version}"\n' in manifest
