"""What the commands for pigment layers share: compositions by file or name, and the job that solves them."""

import os
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ..cluster_options import add_cluster, open_crew
from ..options import whole
from ..output import complain
from ..progress import Bar


def add_job(parser) -> None:
    """Let a command be told of a composition and how it is solved."""
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="composition, or the name of one that ships"
    )
    parser.add_argument("--draft", action="store_true", help="a coarse grid, few bands and angles")
    parser.add_argument(
        "--realisations",
        type=whole(2),
        metavar="N",
        help="layers with particles of their own (default: as the composition says, or 4)",
    )
    parser.add_argument(
        "--jobs",
        type=whole(),
        default=max((os.cpu_count() or 2) - 1, 1),
        metavar="N",
        help="processes (default: one less than there are processors)",
    )
    parser.add_argument(
        "--cache", type=Path, metavar="FOLDER", help="where what is solved is kept (default: yours)"
    )
    add_cluster(parser)


@contextmanager
def _open_hands(options):
    """Give what solves realisations: processes of this machine, or the workers of a cluster."""
    from ...engine.ink.crew import run_tasks

    with open_crew(options) as crew:
        if crew is None:
            yield run_tasks
        else:
            from ...engine.cluster.ink_tasks import solve_with

            yield solve_with(crew)


def solve(options):
    """Solve the pigment layer that a command was told of; say before what it will take."""
    from ...engine.ink.computed import compute
    from ...engine.ink.plan import make_plan, memory_of, solves_of
    from ...engine.ink.reader import read_ink
    from ...libraries import inks

    known = inks.presets()
    path = options.file
    if not path.exists() and str(path) in known:
        path = known[str(path)]
    ink = read_ink(path)
    plan = make_plan(ink, draft=options.draft, realisations=options.realisations)
    complain(
        f"{ink.name}: {solves_of(ink, plan)} solves of {plan.columns} x {plan.columns} x {plan.layers} cells, "
        f"{memory_of(ink, plan) / 2**20:.0f} MB at most in each of {options.jobs} processes"
    )
    with ExitStack() as stack, Bar(ink.name) as bar:

        def show(progress) -> None:
            left = f"{progress.left:.0f} s left" if progress.left < 1e9 else ""
            bar.share(progress.done / progress.total, left)

        do_tasks = stack.enter_context(_open_hands(options))
        return compute(ink, plan, options.cache, options.jobs, show, do_tasks)
