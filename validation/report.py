"""The report of a run: a summary, a page per case, pictures and plots, and the outcome for machines."""

from pathlib import Path

from .canvas import save_picture
from .case_page import compose_case
from .cells import OUTCOME, PICTURES, groups_of
from .charts import draw_bands, draw_errors, draw_published
from .drawing import draw_setup
from .outcome import compose_outcome, write_outcome
from .published import Published, load_published
from .runner import Run
from .summary import compose_summary, largest_by_clause, share_bands


def write_report(run: Run, folder: Path) -> list[Path]:
    """Write the report of a run.

    Parameters
    ----------
    run : Run
    folder : Path    Made if need be; files of the same names are replaced.

    Returns
    -------
    list of Path    Everything that was written.
    """
    folder = Path(folder)
    (folder / PICTURES).mkdir(parents=True, exist_ok=True)
    published = load_published()
    written = _draw_summary(run, published, folder / PICTURES)
    cases = list(run.cases)
    for i, case in enumerate(cases):
        written += _draw_case(run, case, folder / PICTURES)
        around = (cases[i - 1] if i else None, cases[i + 1] if i + 1 < len(cases) else None)
        page = compose_case(run, case, published, around)
        written.append(_write(folder / f"{case}.md", page))
    written.append(_write(folder / "README.md", compose_summary(run, published)))
    written.append(write_outcome(compose_outcome(run), folder / OUTCOME))
    return written


def _write(path: Path, text: str) -> Path:
    path.write_text(text.rstrip() + "\n", encoding="utf-8")
    return path


def _draw_case(run: Run, case: str, folder: Path) -> list[Path]:
    written = []
    if case in run.setups:
        picture = draw_setup(run.setups[case])
        written.append(save_picture(picture, folder / f"{case}.png"))
    rows = [
        (run.engine.findings[key], run.engine.verdicts[key])
        for key in groups_of(run, case)
        if key in run.engine.findings
    ]
    if rows:
        written.append(save_picture(draw_errors(rows), folder / f"{case}_errors.png", 64))
    return written


def _draw_summary(run: Run, published: Published, folder: Path) -> list[Path]:
    ours = largest_by_clause(run)
    written = [save_picture(draw_bands(share_bands(run, published)), folder / "bands.png")]
    if ours:
        picture = draw_published(ours, published.results)
        written.append(save_picture(picture, folder / "published.png"))
    return written
