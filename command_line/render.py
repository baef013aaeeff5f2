"""The command ``lumenray render``: a picture of a scene, for looking at and for numbers."""

import argparse
import math
from dataclasses import replace
from pathlib import Path

from ..blender_addon import assumptions
from ..engine.analysis.tone_operators import OPERATORS
from ..engine.errors import FileFormatError, LumenrayError
from .blend_file import open_blend
from .cluster_options import add_cluster, open_engine
from .modelling import overrule
from .options import (
    add_rule,
    add_scene,
    level,
    real,
    rule_of,
    seed_of,
    size,
    transport_of,
    whole,
)
from .output import add_output, check_free, percent, say
from .progress import Bar


def add_command(commands) -> None:
    """Describe the command to argparse."""
    render = commands.add_parser(
        "render", help="render the scene's camera to an OpenEXR file", epilog=assumptions.CODES
    )
    add_scene(render)
    words = "linear picture; a .png for looking and a .json report are written beside it"
    add_output(render, "OUT.exr", words)
    render.add_argument(
        "--size",
        # What Blender takes.
        type=size(4, 65536),
        metavar="WxH",
        help="picture size in pixels (default: the scene's)",
    )
    render.add_argument(
        "--spectral-exr",
        type=whole(2, 400),
        metavar="BANDS",
        help="also write a spectral OpenEXR with this many bands from 380 to 780 nm (default: as the scene says)",
    )
    render.add_argument(
        "--method",
        choices=("auto", "cells", "paths"),
        help="what stands for the radiance beyond the first bounce (default: as the scene says)",
    )
    render.add_argument(
        "--unbiased",
        action=argparse.BooleanOptionalAction,
        help="let the expected picture be that of full paths: cells are corrected by some (default: as the scene says)",
    )
    render.add_argument(
        "--illuminance",
        action="store_true",
        help="also compute the illuminance of the visible surfaces [lx]",
    )
    render.add_argument(
        "--false-colour",
        action="store_true",
        help="also draw the luminance in false colours with lines of equal luminance, OUT_luminance.png and .svg; with "
        "--illuminance that as well, OUT_illuminance.png and .svg",
    )
    render.add_argument(
        "--isolux-lines",
        action=argparse.BooleanOptionalAction,
        help="draw lines of equal luminance with their values, and with --illuminance isolux lines: over the false colours "
        "(default), or without --false-colour over the picture as it is looked at, into the same files",
    )
    render.add_argument(
        "--values",
        action="store_true",
        help="write values at a grid of points of these pictures; as for lines, means over as many pixels as noise asks for",
    )
    render.add_argument(
        "--tone",
        choices=OPERATORS,
        action="append",
        default=[],
        help="also draw the picture by a tone operator for looking, with legend and statement, OUT_photographic.png and "
        ".svg or OUT_visual.png and .svg: photographic (Reinhard 2002), visual (an adapted eye with its veil and night "
        "vision, Ward Larson 1997); may be repeated. Nothing measured is changed",
    )
    render.add_argument(
        "--scale-to",
        type=real(),
        metavar="TOP",
        help="upper end of the scale of false colours in cd/m2 or lx, so that pictures can be compared (default: a round "
        "number from the picture)",
    )
    render.add_argument(
        "--log-scale",
        action="store_true",
        help="let the scale of false colours be logarithmic, over three powers of ten",
    )
    render.add_argument(
        "--denoise",
        action=argparse.BooleanOptionalAction,
        help="let Open Image Denoise filter the .png; the .exr is never filtered (default: where it is installed)",
    )
    render.add_argument(
        "--light-groups",
        choices=("none", "groups", "each"),
        help="also write the light of each light group, or of each luminaire, as layers Combined_NAME and Luminance_NAME; "
        "they share the samples (default: as the scene says)",
    )
    render.add_argument(
        "--mix",
        type=level,
        action="append",
        default=[],
        metavar="NAME=FACTOR",
        help="factor on the flux of a light group, such as Ceiling=0.5, Ceiling=50%% or Ceiling=off; the group of all other "
        "lights is called rest; may be repeated (default: as the scene says)",
    )
    add_rule(render, "pixel")
    assumptions.add_option(render)
    add_cluster(render)
    render.set_defaults(run=run)


def run(options) -> int:
    """Render a file; return the exit code."""
    check_files(options)
    if options.denoise:
        from ..engine.analysis.denoiser import require_denoiser

        require_denoiser()
    depsgraph = open_blend(options.file)
    overrule(depsgraph.scene, options)
    return render_open(options, depsgraph)


def render_open(options, depsgraph) -> int:
    """Render the open file and write picture, preview and report; return the exit code."""
    from ..blender_addon.rendering.shutter import shutter_of
    from ..engine.analysis.false_colour import write_display
    from ..engine.formats.report import write_json
    from ..engine.requirements.budget import tell_parts

    scene = depsgraph.scene
    if options.size:
        scene.render.resolution_x, scene.render.resolution_y = options.size
        scene.render.resolution_percentage = 100
    shutter = shutter_of(scene, depsgraph.view_layer)
    with open_engine(options) as session:
        feed, camera, conversion = _convert(depsgraph, shutter, session)
        if camera is None:
            raise LumenrayError(
                f"{options.file}: the scene has no camera; add one and make it active"
            )
        assumptions.refuse_missing(conversion, options.accept_missing)
        if options.light_groups:
            scene.lumenray.light_mix.groups = options.light_groups.upper()
        view = _view(options, scene, feed.sync.luminous)
        levels = _levels(options, scene, view, feed.sync.luminous)
        with Bar("render") as bar:
            whole_picture = _take(depsgraph, feed, camera, view, shutter, bar)
    picture = whole_picture.mixed(levels)
    white, linear = _expose(picture, scene.lumenray)
    _write_exr(options.output, picture, white, linear, camera)
    shown = _preview(options, picture, camera, linear)
    write_display(options.output.with_suffix(".png"), shown.colour, shown.words)
    _draw_quantities(options, picture, shown)
    _draw_tones(options, shown, white, camera)
    shortfall = view.rule.shortfall(whole_picture.relative_error)
    report = _report(options, scene.camera.name, picture, conversion, shortfall, shown.words)
    write_json(options.output.with_suffix(".json"), report)
    assumptions.tell(conversion, picture.provenance.notes, shortfall)
    mean = float(picture.tristimulus[..., 1].mean())
    error = percent(picture.relative_error, ".2f")
    if parts := tell_parts(picture.relative_error, picture.provenance.simplified):
        error += f" ({parts})"
    say(
        f"{options.output}: {picture.provenance.samples} samples a pixel in {picture.provenance.seconds:.1f} s, "
        f"mean luminance {mean:.4g} cd/m2, picture error {error}, "
        f"white = {white:.4g} cd/m2" + (f"; light mix: {levels.text()}" if levels.text() else "")
    )
    return assumptions.exit_code(conversion, options.accept_missing, shortfall)


def _convert(depsgraph, shutter, session):
    """Return a feed that has given the scene to an engine, the camera, and what was not taken over as it is."""
    from ..blender_addon.foundation.report import ConversionReport
    from ..blender_addon.rendering.feed import SceneFeed

    feed, report = SceneFeed(session, final=True), ConversionReport()
    feed.sync.is_blurred = shutter is not None
    if shutter is not None:
        _go_to(depsgraph, shutter.middle)
    feed.update(depsgraph)
    report.include(feed.report)
    camera = feed.sync.camera(depsgraph, report)
    if shutter is not None:
        _go_to(depsgraph, shutter.frame)
    return feed, camera, report


def _go_to(depsgraph, time: float):
    """Bring the scene to a time and return its dependency graph. [frame]"""
    from ..blender_addon.rendering.shutter import split_time

    frame, subframe = split_time(time)
    depsgraph.scene.frame_set(frame, subframe=subframe)
    return depsgraph


def _take(depsgraph, feed, camera, view, shutter, progress):
    """Render what the camera sees, or the mean over its open shutter."""
    from ..blender_addon.rendering.shutter import render_open_shutter

    if shutter is None:
        return feed.session.render(camera, view, progress)

    def go_to(time):
        return _go_to(depsgraph, time)

    picture = render_open_shutter(shutter, view, feed, go_to, feed.session.render, progress)
    _go_to(depsgraph, shutter.frame)
    return picture


def check_files(options) -> None:
    """Refuse to write over any of the files of a picture, see `check_free`."""
    check_free(options, options.output)
    if options.output.suffix.lower() != ".exr":
        raise FileFormatError(options.output, "expected a name that ends in .exr")
    beside = (options.output.with_suffix(end) for end in (".png", ".json"))
    check_free(options, *beside, _spectral_path(options))
    for name in options.tone:
        check_free(options, *_drawn_paths(options, name))
    if _draws_quantities(options):
        check_free(options, *_drawn_paths(options, "luminance"))
        check_free(options, *(_drawn_paths(options, "illuminance") if options.illuminance else ()))


def _spectral_path(options) -> Path:
    return options.output.with_name(options.output.stem + "_spectral.exr")


def _drawn_paths(options, quantity: str) -> list[Path]:
    stem = f"{options.output.stem}_{quantity}"
    return [options.output.with_name(f"{stem}.{end}") for end in ("png", "svg")]


def _draws_quantities(options) -> bool:
    return bool(options.false_colour or options.isolux_lines or options.values)


def _draw_quantities(options, picture, shown) -> None:
    """Draw luminance, and illuminance where it was asked for, with lines of equal value and values.

    ``shown``: the `looking.Filtered` picture, over which they are drawn unless false colours were asked for.
    """
    if not _draws_quantities(options):
        return
    from ..engine.analysis.false_colour import encode_display
    from ..engine.analysis.value_plan import draw_map, even_scale

    drawn = [("luminance", picture.tristimulus[..., 1], picture.luminance_error, "cd/m2")]
    if options.illuminance:
        drawn.append(("illuminance", picture.illuminance, picture.illuminance_error, "lx"))
    look = None if options.false_colour else encode_display(shown.colour)
    with_lines = options.false_colour if options.isolux_lines is None else options.isolux_lines
    for quantity, values, error, unit in drawn:
        # Where nothing is seen there is no illuminance, and lines would follow its edge.
        seen = picture.depth < NOTHING if quantity == "illuminance" else None
        scale = even_scale(values, unit, options.scale_to, options.log_scale)
        caption = f"mean {float(values.mean()):.4g} {unit}"
        title = quantity.capitalize() if look is None else f"{quantity.capitalize()} [{unit}]"
        sheet = draw_map(
            title,
            values,
            seen,
            caption,
            scale,
            unit=unit,
            smoothing=LINE_SMOOTHING,
            error=error,
            with_lines=with_lines,
            with_values=options.values,
            look=look,
        )
        for path in _drawn_paths(options, quantity):
            say(f"written to {sheet.save(path)}")


def _draw_tones(options, shown, white: float, camera) -> None:
    """Draw the picture that is looked at by tone operators; ``white``: luminance of its 1. [cd/m2]"""
    from ..engine.analysis.tone_operators import apply_operator
    from ..engine.analysis.tone_sheet import draw_toned
    from ..engine.formats.luminance_picture import view_of_camera
    from ..engine.photometry.colour import tristimulus_of

    for name in dict.fromkeys(options.tone):
        toned = apply_operator(name, tristimulus_of(shown.colour, white), view_of_camera(camera))
        sheet = draw_toned(toned, shown.words)
        for path in _drawn_paths(options, name):
            say(f"written to {sheet.save(path)}")


NOTHING = 1e10
"""Depth where nothing is seen. [m]"""

LINE_SMOOTHING = 2
"""How often neighbouring pixels are averaged at least before lines are drawn, so that noise does not fray them."""


def _view(options, scene, luminous):
    """Return the scene's `ViewSettings` with what was asked for."""
    from ..blender_addon.rendering.render_engine import view_settings

    view, settings = view_settings(scene, str(_spectral_path(options)), luminous), scene.lumenray
    return replace(
        view,
        rule=rule_of(options, lambda: view.rule),
        seed=seed_of(options, settings),
        transport=transport_of(options, settings),
        illuminance=options.illuminance or view.illuminance,
        bands=options.spectral_exr or view.bands,
        method=options.method or view.method,
        unbiased=view.unbiased if options.unbiased is None else options.unbiased,
        guides=_denoises(options),
    )


def _levels(options, scene, view, luminous):
    """Return the `LightMix` that was asked for, on top of the scene's."""
    from ..blender_addon.rendering import light_mix
    from ..engine.light_mix import Level, LightMix

    kept = {each.name: each for each in light_mix.levels_of(scene).levels}
    known = light_mix.names_of(view.groups, luminous)
    for name, factor in options.mix:
        if name not in known:
            there = ", ".join(f"'{each}'" for each in known)
            remedy = f"those of the scene are {there}" if known else NO_GROUPS
            raise LumenrayError(f"--mix: no light group is called '{name}'; {remedy}")
        kept[name] = replace(kept.get(name, Level(name)), factor=factor, is_on=factor > 0.0)
    return LightMix(tuple(kept.values()) if view.groups else ())


NO_GROUPS = "none are kept apart: say --light-groups groups, and name groups in the scene"


def _expose(picture, settings):
    """Return the luminance that becomes white [cd/m2], and the picture in the scene's linear colours. (h, w, 3)"""
    from ..blender_addon.foundation.exposure import white_luminance
    from ..blender_addon.rendering.render_engine import shown_light
    from ..engine.photometry.colour import automatic_white, scene_linear

    white = white_luminance(settings) or automatic_white(picture.tristimulus[..., 1])
    return white, scene_linear(shown_light(picture), white)


def _write_exr(path: Path, picture, white: float, linear, camera) -> None:
    from ..blender_addon.rendering.render_engine import shown_light
    from ..engine.formats import exr
    from ..engine.formats.luminance_picture import VIEW, describe_view, view_of_camera
    from ..engine.photometry.colour import scene_linear

    channels = {name: linear[..., i] for i, name in enumerate("RGB")}
    if picture.coverage is not None:
        channels["A"] = picture.coverage
    channels |= {
        "Luminance.Y": picture.tristimulus[..., 1],
        "Luminance.error": picture.luminance_error,
        "Depth.Z": picture.depth,
        **{f"Normal.{name}": picture.normal[..., i] for i, name in enumerate("XYZ")},
        "IndexOB.X": picture.object_index,
        "IndexMA.X": picture.material_index,
    }
    if picture.illuminance is not None:
        channels |= {
            "Illuminance.X": picture.illuminance,
            "Illuminance.error": picture.illuminance_error,
        }
    for group in picture.groups:
        seen = scene_linear(shown_light(group), white)
        channels |= {f"Combined_{group.name}.{name}": seen[..., i] for i, name in enumerate("RGB")}
        channels[f"Luminance_{group.name}.Y"] = group.tristimulus[..., 1]
        channels[f"Luminance_{group.name}.error"] = group.luminance_error
        if group.illuminance is not None:
            channels[f"Illuminance_{group.name}.X"] = group.illuminance
            channels[f"Illuminance_{group.name}.error"] = group.illuminance_error
    # whiteLuminance is OpenEXR's standard attribute: the luminance of (1, 1, 1).
    attributes = {"whiteLuminance": white, "sceneHash": picture.provenance.scene_hash}
    view = view_of_camera(camera)
    if view is not None:
        attributes[VIEW] = describe_view(view)
    exr.write_channels(path, channels, attributes)


def _report(options, camera: str, picture, conversion, shortfall: str, preview: str) -> dict:
    from ..engine.formats.report import compose

    luminance = picture.tristimulus[..., 1]
    row = {
        "name": camera,
        "quantity": "luminance",
        "unit": "cd/m2",
        "mean": float(luminance.mean()),
        "minimum": float(luminance.min()),
        "maximum": float(luminance.max()),
        "relative_standard_error": picture.relative_error,
        "samples": picture.provenance.samples,
    }
    simplified = picture.provenance.simplified
    rows = [row, *(_group_row(group, picture.groups, simplified) for group in picture.groups)]
    content = compose(
        options.file.name,
        picture.provenance,
        picture.provenance.seconds,
        rows,
        conversion.to_dicts(),
        shortfall,
    )
    content["preview"] = preview
    return content


def _group_row(group, groups, simplified: float) -> dict:
    """What a light group gives to the picture, at the flux of the scene; ``simplified``: as of a `Provenance`. [-]"""
    from ..engine.accuracy.estimate import relative_error

    luminance = group.tristimulus[..., 1]
    total = sum(each.tristimulus[..., 1] for each in groups)
    return {
        "name": f"light group {group.name}",
        "quantity": "luminance",
        "unit": "cd/m2",
        "mean": float(luminance.mean()),
        "minimum": float(luminance.min()),
        "maximum": float(luminance.max()),
        "relative_standard_error": math.hypot(
            relative_error(luminance, group.luminance_error), simplified
        ),
        "share": float(luminance.mean() / max(total.mean(), 1e-30)),
        "samples": group.samples,
    }


def _denoises(options) -> bool:
    """Whether the preview is to be denoised."""
    from ..engine.analysis.denoiser import find_denoiser

    return find_denoiser() is not None if options.denoise is None else options.denoise


def _preview(options, picture, camera, linear):
    """Return the picture as it is looked at, `looking.Filtered`; the numbers stay as they are."""
    from ..engine.analysis.looking import Filtered, filter_noise

    if not _denoises(options):
        return Filtered(linear, "as computed")
    made = filter_noise(linear, picture, camera.aperture_radius > 0.0)
    if made.problem:
        say(f"note: {made.problem}")
        return replace(made, words="as computed")
    return replace(made, words=f"{made.words}; all numbers are of the data as computed")
