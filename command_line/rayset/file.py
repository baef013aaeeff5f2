"""Ray files as the commands open them, and their light."""


def add_assumptions(parser) -> None:
    """Let a command say what texts do not tell."""
    parser.add_argument(
        "--unit",
        choices=("m", "cm", "mm", "inch", "foot", "um"),
        default="mm",
        help="length unit of texts that do not tell theirs (default: mm)",
    )
    parser.add_argument(
        "--lumens", action="store_true", help="texts that do not tell have rays in lumens"
    )


def assumed_of(options):
    """What is assumed of texts that do not tell."""
    from ...engine.raysets.record import LUMINOUS, RADIANT
    from ...engine.raysets.text import Assumed

    return Assumed(options.unit, LUMINOUS if options.lumens else RADIANT)


def open_rayset(options, path):
    """Read the head of a ray file."""
    from ...engine.raysets.reader import read_rayset

    return read_rayset(path, assumed_of(options))


def survey_light(file, bar):
    """Survey of a file, and its light."""
    from ...engine.raysets.light import light_of
    from ...engine.raysets.survey import survey_rays

    survey = survey_rays(file, lambda share: bar.share(0.2 * share))
    return survey, light_of(file, survey, progress=lambda share: bar.share(0.2 + 0.8 * share))


PLANES = 24
"""C-planes of sources that are not the same all around."""


def reduce_pieces(pieces: list, step: float | None = None, planes: int | None = None):
    """Reduce rays on a grid that suits them where none is given."""
    from ...engine.raysets.reduction import choose_step, is_rotational, reduce_rays

    step = choose_step(pieces) if step is None else step
    reduced = reduce_rays(pieces, step, PLANES if planes is None else planes)
    if planes is None and is_rotational(reduced):
        return reduce_rays(pieces, step, 1)
    return reduced
