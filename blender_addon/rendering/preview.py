"""Previews of materials, worlds and lights: small scenes of Blender's own, in its panels and as icons.

Blender makes them one after the other, on a thread of its own where it has a window, and gives one up as soon as
something is edited. They have a session of their own, whose objects stay from one to the next.
"""

from ...engine.errors import Cancelled
from ...imports import loaded_when_used
from ..foundation import engine_process, identity
from ..foundation.report import ConversionReport
from ..luminaires.settings import is_luminaire
from ..raysets.settings import is_rayset
from .feed import SceneFeed

with loaded_when_used():
    import numpy as np

    from ...engine import views
    from ...engine.accuracy import stopping
    from ...engine.analysis import denoiser, looking
    from ...engine.photometry import colour
    from ..sync import camera as sync_camera

SAMPLES, UNFILTERED_SAMPLES = 16, 64
"""Paths per pixel where noise is filtered, and where Open Image Denoise is not installed."""

TEXELS = 1 << 19
"""Of pictures that are made for objects: a preview has fewer pixels than a quarter of them."""

INTERVAL = 0.3
"""Shortest time between two pictures on the way. [s]"""

PATIENCE = 600.0
"""How long the engine may take to obey when a preview is given up: it compiles kernels then, and a bake that rests
beside it must not be lost. [s]"""

MOVING = {"OBJECT", "SCENE", "WORLD"}
"""Types of the data-blocks that differ between previews beside the copies of what they show."""

_feed: SceneFeed | None = None


def render_preview(engine, depsgraph) -> None:
    """Render the scene of a preview into the result of a render engine.

    Parameters
    ----------
    engine : bpy.types.RenderEngine    With ``is_preview``.
    depsgraph : bpy.types.Depsgraph    Of a scene that is not among the file's.

    Raises
    ------
    Cancelled    Blender wants it no longer.
    LumenrayError    It cannot be rendered; the text says why.
    """
    scene = depsgraph.scene
    with identity.apart():
        feed = _current_feed()
        # Blender calls everything new every time, but what is previewed is, and the rest as it was.
        feed.sync.tag(each for each in depsgraph.updates if each.id.id_type in MOVING)
        feed.update(depsgraph)
        camera = feed.sync.camera(depsgraph, ConversionReport())
    if camera is None:
        return
    white = None if states_amounts(depsgraph) else scene.lumenray.efficacy
    result = engine.begin_result(0, 0, *sync_camera.region(scene.render)[2:])
    target = result.layers[0].passes["Combined"]
    finished = False

    def idle():
        if engine.test_break():
            raise Cancelled("cancelled")

    def follow(progress, so_far):
        engine.update_progress(progress.done)
        if so_far is not None and not scene.render.film_transparent:
            _fill(target, so_far(), white)
            engine.update_result(result)

    try:
        picture = feed.session.render(
            camera, settings_of(scene), follow, INTERVAL, idle=idle, patience=PATIENCE
        )
        shown = picture.tristimulus
        if picture.backdrop is not None:
            shown = np.maximum(shown - picture.backdrop, 0.0)
        _fill(target, shown, white, picture)
        finished = True
    finally:
        engine.end_result(result, cancel=not finished)


def settings_of(scene) -> "views.ViewSettings":
    """What is asked of the picture of a preview."""
    is_filtered = denoiser.find_denoiser() is not None
    return views.ViewSettings(
        rule=stopping.StopRule(samples=SAMPLES if is_filtered else UNFILTERED_SAMPLES),
        transparent=scene.render.film_transparent,
        method="paths",
        guides=is_filtered,
    )


def states_amounts(depsgraph) -> bool:
    """Tell whether a light or a world of a preview has its amount in a unit that is not Blender's.

    Such a preview is exposed by itself, else its white is what it is in Cycles: radiance 1.
    """
    world = depsgraph.scene.world
    if world is not None and (world.lumenray.source == "CIE" or world.lumenray.unit != "BLENDER"):
        return True
    sources = (instance.object for instance in depsgraph.object_instances)
    return any(
        source.type == "LIGHT"
        and (source.data.lumenray.use_physical or is_luminaire(source) or is_rayset(source))
        for source in sources
    )


def close() -> None:
    """Let the engine forget the scene of previews."""
    global _feed
    feed, _feed = _feed, None
    if feed is not None:
        feed.session.close()


def _current_feed() -> SceneFeed:
    global _feed  # noqa: PLW0603 - one preview is made at a time
    if _feed is None or _feed.session.is_lost:
        _feed = SceneFeed(engine_process.open_session("preview"), True, TEXELS)
    return _feed


def _fill(target, tristimulus, white: float | None, picture=None) -> None:
    """Put light into a pass. (h, w, 3) [cd/m2]; ``picture``: the finished one that it is of, whose noise is filtered."""
    white = white or colour.automatic_white(tristimulus[..., 1])
    pixels = np.ones((*tristimulus.shape[:2], 4), dtype=np.float32)
    pixels[..., :3] = colour.scene_linear(tristimulus, white)
    if picture is not None and picture.denoising_albedo is not None:
        pixels[..., :3] = looking.filter_noise(pixels[..., :3], picture).colour
    if picture is not None and picture.coverage is not None:
        pixels[..., 3] = picture.coverage
    target.rect.foreach_set(pixels.reshape(-1))
