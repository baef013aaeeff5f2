"""The command ``lumenray goniometer``: the photometric file of a luminaire that was modelled in Blender."""

import argparse

import numpy as np

from ..blender_addon import assumptions
from ..engine.errors import LumenrayError
from ..engine.goniometry import SIDE, find_extent, measure_intensities, take_luminaire
from .blend_file import open_blend
from .modelling import overrule
from .options import add_scene, real, seed_of, transport_of, whole
from .output import add_output, check_free, percent, say
from .progress import Bar

SAMPLES = 4
"""Of every pixel of the pictures that tell what reflectors and lenses send to a detector."""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    parser = commands.add_parser(
        "goniometer",
        help="the photometric file of a luminaire that was modelled",
        description="All that the file holds is the luminaire: lamps, glowing materials, reflectors, lenses and housing. It "
        "hangs as it is used, its axes are those of the scene; the world and Sun lights are left out.",
        epilog=assumptions.CODES,
    )
    add_scene(parser)
    add_output(
        parser, "OUT.ldt", "photometric file; the end of its name says the format: .ies, .ldt"
    )
    parser.add_argument(
        "--centre",
        type=_point,
        metavar="X,Y,Z",
        help="photometric centre in metres (default: the middle of the lights)",
    )
    parser.add_argument(
        "--distance",
        type=real(),
        metavar="M",
        help="of the detectors in metres (default: 1000 times the size of the luminaire)",
    )
    parser.add_argument(
        "--plane-step",
        type=real(1.0, 90.0),
        default=15.0,
        metavar="DEG",
        help="angle between C planes, of which a turn holds a whole number (default: 15)",
    )
    parser.add_argument(
        "--step",
        type=real(0.1, 45.0),
        default=5.0,
        metavar="DEG",
        help="angle gamma between detectors, of which 180 holds a whole number (default: 5)",
    )
    parser.add_argument("--watts", type=real(), metavar="W", help="electrical power for the file")
    parser.add_argument(
        "--samples",
        type=whole(),
        default=SAMPLES,
        metavar="N",
        help=f"of each of the {SIDE}x{SIDE} pixels of two pictures from every direction, which tell what reflectors and "
        f"lenses add (default: {SAMPLES})",
    )
    assumptions.add_option(parser)
    parser.set_defaults(run=run)


def _point(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected X,Y,Z in metres such as 0,0,2.5, found '{text}'"
        ) from None
    return x, y, z


def run(options) -> int:
    """Measure a luminaire and write its file; return the exit code."""
    from ..blender_addon.sync.scene import convert_scene
    from ..engine.luminaires.distribution import flux
    from ..engine.luminaires.formats.reader import write_luminaire
    from ..engine.luminaires.goniometer import FAR, even_angles, place_detectors, to_luminaire
    from ..engine.scene.scene import Scene
    from ..engine.session import Session

    check_free(options, options.output)
    azimuth = even_angles(np.deg2rad(options.plane_step), 2.0 * np.pi)[:-1]
    polar = even_angles(np.deg2rad(options.step), np.pi)
    depsgraph = open_blend(options.file)
    overrule(depsgraph.scene, options)
    converted = convert_scene(depsgraph)
    assumptions.refuse_missing(converted.report, options.accept_missing)
    assumptions.refuse_media(converted.report)
    scene = Scene()
    scene.apply(converted.delta)
    part = take_luminaire(scene)
    extent = find_extent(part.scene)
    frame = np.eye(4)
    frame[:3, 3] = extent.middle if options.centre is None else options.centre
    size = max(extent.size, 0.1)
    reach = max(np.linalg.norm(frame[:3, 3] - each) for each in (extent.low, extent.high))
    distance = FAR * size if options.distance is None else options.distance
    if distance <= reach:
        raise LumenrayError(
            f"--distance: {distance:g} m lies within the luminaire, which reaches {reach:.3g} m from its centre"
        )
    detectors = place_detectors(frame, azimuth, polar, distance)
    settings = depsgraph.scene.lumenray
    with Bar("measure") as bar:
        found = measure_intensities(
            Session(),
            part.scene,
            detectors,
            0.5 * (extent.low + extent.high),
            0.5 * size,
            options.samples,
            seed_of(options, settings),
            transport_of(options, settings),
            bar,
        )
    measured = found.measured
    table = measured.distribution.intensity
    if not table.max() > 0.0:
        raise LumenrayError(f"{options.file}: no light leaves what the file holds")
    # The extent of what shines is not told apart from that of the housing.
    file = to_luminaire(
        measured, extent.high - extent.low, {"LUMINAIRE": options.file.stem}, options.watts
    )
    remarks = write_luminaire(file, options.output)
    error = float(np.sqrt((measured.standard_error**2).mean()) / table.max())
    notes = [*found.notes, *(str(remark) for remark in remarks)]
    if part.has_surroundings:
        notes.append("the world and Sun lights are no part of the luminaire and were left out")
    assumptions.tell(converted.report, notes)
    say(
        f"{flux(measured.distribution):.5g} lm, peak {table.max():.4g} cd, error of intensities "
        f"{percent(error, '.2g')} of the peak, measured at {distance:.4g} m"
    )
    say(f"written to {options.output}")
    return assumptions.exit_code(converted.report, options.accept_missing)
