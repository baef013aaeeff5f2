"""What the commands that make Blender asset libraries share: options, the choice of pictures, what is told."""

from ...engine.errors import LumenrayError
from ...libraries.luminaires import Problem
from ..options import words
from ..output import complain, say


def add_picture_options(parser) -> None:
    """Let a command say which pictures may be rendered."""
    parser.add_argument(
        "--pictures",
        choices=("missing", "all", "none"),
        default="missing",
        help="which pictures to render first (default: those that are not there)",
    )
    parser.add_argument(
        "--only",
        type=words,
        default=(),
        metavar="A,B",
        help="render pictures of these by name only",
    )


def render(models, options, write_picture, place) -> list[Problem]:
    """Render the pictures of models that the options ask for; one whose file is refused has none.

    Parameters
    ----------
    models : iterable    As of `chosen`.
    options : argparse.Namespace
    write_picture : callable    From a model to the path of its picture.
    place : callable    From a model to the path that a refusal names.
    """
    problems = []
    for model in chosen(models, options):
        try:
            say(str(write_picture(model)))
        except LumenrayError as error:
            problems.append(Problem(place(model), str(error)))
    return problems


def tell(built, problems: list[Problem]) -> int:
    """Tell what was written, and what was left out; 1 if something was."""
    say(f"{built.path}: {len(built.names)} assets, {built.path.stat().st_size / 1e6:.1f} MB")
    # A refused file has no picture either, and is told once.
    told = {problem.path for problem in built.problems}
    left_out = [*built.problems, *(problem for problem in problems if problem.path not in told)]
    for problem in left_out:
        complain(problem)
    return int(bool(left_out))


def chosen(models, options) -> list:
    """Models whose pictures the options ask for; anything with a ``name`` and the path of a ``thumbnail``."""
    if options.pictures == "none":
        return []
    return [
        model
        for model in models
        if not (options.pictures == "missing" and model.thumbnail.is_file())
        and (not options.only or model.name in options.only)
    ]
