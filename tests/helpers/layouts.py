"""Atlases of meshes, from the search for charts to their pages."""

from lumenray.engine.atlas.arrange import arrange, find_all_charts


def lay_out(meshes, densities, *, cone=1.0, progress=None, cancelled=None, **more):
    """Lay out meshes as a bake does; ``more`` as of `arrange`."""
    charts = find_all_charts(meshes, densities, cone=cone, progress=progress, cancelled=cancelled)
    return arrange(meshes, charts, densities, **more)
