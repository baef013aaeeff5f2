"""The command ``lumenray rayset convert``: the rays of a file, or others made from them, in another format."""

from ...engine.errors import FileFormatError
from ..options import whole
from ..output import add_conversion, check_free, say
from ..progress import Bar
from .file import add_assumptions, open_rayset


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    convert = tasks.add_parser("convert", help="write the rays in another format")
    add_conversion(
        convert, "ray file", "the end of its name says the format: .tm25ray, .dat (Zemax binary)"
    )
    convert.add_argument(
        "--generate",
        type=whole(1, 2**31 - 1),
        metavar="N",
        help="write N rays generated from those of the file instead of them",
    )
    add_assumptions(convert)
    convert.set_defaults(run=run)


def run(options) -> int:
    """Write a file in another format; return the exit code."""
    from ...engine.raysets.reader import read_rays
    from ...engine.raysets.survey import survey_rays
    from ...engine.raysets.writers import write_tm25, write_zemax

    check_free(options, options.output)
    ending = options.output.suffix.lower()
    if ending not in {".tm25ray", ".dat"}:
        raise FileFormatError(
            options.output, f"'{ending}' is no format that is written, expected .tm25ray or .dat"
        )
    file = open_rayset(options, options.file)
    with Bar(str(options.file)) as bar:
        survey = survey_rays(file, lambda share: bar.share(0.5 * share))
        if options.generate is None:
            pieces = read_rays(file, progress=lambda share: bar.share(0.5 + 0.5 * share))
            factor = survey.factor
        else:
            pieces, factor = _generate(options, file, survey, bar), 1.0
        if ending == ".dat":
            text = f"from {options.file.name}"
            count = write_zemax(options.output, pieces, file.quantity, text, factor)
        else:
            spectrum = None if survey.wavelengths is not None else survey.spectrum
            spectrum = spectrum if spectrum is not None and len(spectrum[0]) > 1 else None
            count = write_tm25(
                options.output, pieces, file.quantity, spectrum, file.metadata, factor
            )
    for remark in survey.remarks:
        say(f"{options.file}: {remark}")
    if len(file.spectra) > 1 or (ending == ".dat" and file.spectra):
        kept = "their mean is kept" if ending != ".dat" else "none is kept"
        say(f"{options.output}: has no place for the spectra of {options.file}; {kept}")
    say(f"written to {options.output} ({count} rays)")
    return 0


def _generate(options, file, survey, bar):
    """Yield generated rays in the file's own quantity."""
    import numpy as np

    from ...engine.raysets.cloud import hold_rays, make_cloud
    from ...engine.raysets.record import Rays

    cloud = make_cloud(
        hold_rays(file),
        survey.weight * survey.factor,
        progress=lambda share: bar.share(0.5 + 0.3 * share),
    )
    rng = np.random.default_rng(0)
    left = options.generate
    while left:
        count = min(left, 1 << 18)
        drawn = cloud.draw(count, rng)
        colour = {}
        if drawn.colour is not None and survey.wavelengths is not None:
            colour = {"wavelength": drawn.colour}
        yield Rays(
            drawn.position.astype(np.float32),
            drawn.direction.astype(np.float32),
            (drawn.flux * (count / options.generate)).astype(np.float32),
            **colour,
        )
        left -= count
        bar.share(0.8 + 0.2 * (1.0 - left / options.generate))
