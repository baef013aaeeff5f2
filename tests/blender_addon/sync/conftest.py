"""Fixtures of the tests of conversion."""

import pytest


@pytest.fixture
def world():
    """Return a world with a sky of the CIE."""
    from blender_skies import new_sky

    return new_sky()


@pytest.fixture(scope="module")
def session():
    """Return a session of the engine."""
    from lumenray.engine.session import Session

    return Session(witness=False)


@pytest.fixture
def convert():
    """Return a function that converts a material and gives the result and the rows as text."""
    from material_trees import EFFICACY

    from lumenray.blender_addon.foundation.report import ConversionReport
    from lumenray.blender_addon.sync.materials.materials import convert_material

    def run(material):
        report = ConversionReport()
        return convert_material(material, "key", report, EFFICACY), report.to_dicts()

    return run


@pytest.fixture
def override():
    """Return a new material with its physical override on, and its settings."""
    import bpy

    material = bpy.data.materials.new("Measured")
    material.lumenray.use_override = True
    return material, material.lumenray
