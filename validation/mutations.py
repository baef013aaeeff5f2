"""Mutation check: faults of physics are put into the engine one at a time, and the quick subset has to find each.

A fault is stated as a change of the engine's own text, so that the engine needs no hooks for it, and a statement that no
longer fits the engine says so instead of changing nothing. Every fault has a process of its own: what the engine keeps
(kernels, registered plug-ins, integrals) would carry it on.

Run it with ``python -m lumenray.validation.mutations``; exit code 1 says that a fault was not found.
"""

import argparse
import importlib
import inspect
import multiprocessing
import pkgutil
import sys
import textwrap
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from unittest.mock import patch

from lumenray import engine as engine_package
from lumenray.engine import VERSION

from .bench import Bench, Engine
from .cases import all_cases
from .reference import load_groups
from .runner import run_case
from .verdict import judge

FOLDER = Path("docs/validation")
"""Where the table belongs."""

FILE = "mutations.md"

PROGRAM = "python -m lumenray.validation.mutations"


# ---- faults ----


@dataclass(frozen=True)
class Rewrite:
    """A line of a function or method, changed.

    Parameters
    ----------
    target : str    Such as ``transport.paths:trace`` or ``transport.textures:TextureMaker.spectrum``, in the engine.
    old, new : str    Text of the target, which holds it exactly once, and what stands there instead.
    """

    target: str
    old: str
    new: str

    @property
    def text(self) -> tuple[str, str]:
        """Before and after, for people."""
        return self.old, self.new

    def make(self, owner, original):
        """Return the changed function; it works in the original's module."""
        function = inspect.unwrap(original)
        source = textwrap.dedent(inspect.getsource(function))
        if (count := source.count(self.old)) != 1:
            raise ValueError(
                f"{self.target} holds '{self.old}' {count} times, expected once: state the fault anew"
            )
        made: dict[str, object] = {}
        code = compile(source.replace(self.old, self.new), f"<fault in {self.target}>", "exec")
        exec(code, function.__globals__, made)  # noqa: S102 - the text stands below
        return made[function.__name__]


@dataclass(frozen=True)
class Replace:
    """A constant of a module, replaced.

    Parameters
    ----------
    target : str    As of `Rewrite`.
    new : str    Expression in the names of its module.
    """

    target: str
    new: str

    @property
    def text(self) -> tuple[str, str]:
        """Before and after, for people."""
        return self.target.rpartition(":")[2], self.new

    def make(self, owner, original):
        """Return the new value."""
        return eval(self.new, vars(owner))  # noqa: S307 - the text stands below


@dataclass(frozen=True)
class Mutation:
    """A fault of physics.

    Parameters
    ----------
    name : str
    what : str    Half a sentence for people.
    changes : tuple of Rewrite or Replace
    likely : tuple of str    Groups of the quick subset that are asked first.
    """

    name: str
    what: str
    changes: tuple[Rewrite | Replace, ...]
    likely: tuple[str, ...]

    @contextmanager
    def injected(self) -> Iterator[None]:
        """Have the fault in this process; nothing may have been computed in it before, nor be computed afterwards.

        Raises
        ------
        ValueError    The engine's text is another than the fault says.
        """
        modules = _engine_modules()
        with ExitStack() as stack:
            for change in self.changes:
                owner, name, original = locate(change.target)
                made = change.make(owner, original)
                # Other modules may have imported it by its name.
                others = [m for m in modules if m is not owner and vars(m).get(name) is original]
                for place in [owner, *others]:
                    stack.enter_context(patch.object(place, name, made))
            yield


def locate(target: str) -> tuple[object, str, object]:
    """Return the module or class that has a target, the target's name there, and what it is now."""
    module, _, path = target.partition(":")
    owner = importlib.import_module(f"{engine_package.__name__}.{module}")
    *outer, name = path.split(".")
    for part in outer:
        owner = getattr(owner, part)
    return owner, name, getattr(owner, name)


def _engine_modules() -> list:
    """Import the whole engine, and return every module of the program: none is to come later with the fault in it."""
    for found in pkgutil.walk_packages(engine_package.__path__, f"{engine_package.__name__}."):
        importlib.import_module(found.name)
    root = engine_package.__name__.rpartition(".")[0]
    return [module for key, module in sys.modules.items() if key.startswith(f"{root}.")]


_PANE = "materials.plugins:pane_optics"
_TRACE = "transport.paths.path_loop:trace"
_SURFACE = "luminaires.emitters.plugins:_surface_class"

MUTATIONS = (
    Mutation(
        "pi in luminous surfaces",
        "luminous surfaces are brighter by a factor of pi, as if their luminance were an exitance",
        (
            Rewrite(
                _SURFACE,
                "value = self.radiance.eval(si, active)",
                "value = self.radiance.eval(si, active) * dr.pi",
            ),
        ),
        ("C05.cie53", "C05.axis"),
    ),
    Mutation(
        "receiver's cosine",
        "the cosine of the angle of incidence is dropped",
        (
            Rewrite(
                "transport.paths.gather:_response",
                "dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0), 0.0",
                "mi.Float(1.0), 0.0",
            ),
        ),
        ("C01.iso", "C21.point"),
    ),
    Mutation(
        "half a sphere",
        "the mean spherical illuminance is taken over half of the sphere's surface",
        (Rewrite("transport.paths.gather:_response", "mi.Float(0.25)", "mi.Float(0.5)"),),
        ("C01.spatial",),
    ),
    Mutation(
        "C0 plane",
        "distributions of type C are turned by 90 degrees",
        (
            Rewrite(
                "luminaires.formats.lm63.reader:_distribution_c",
                "np.radians(content.vertical), intensity)",
                "np.radians(content.vertical), intensity, np.eye(3)[[1, 0, 2]] * [[-1], [1], [1]])",
            ),
        ),
        ("C02.level", "C03.quad"),
    ),
    Mutation(
        "quadrants",
        "planes stored from 0 to 90 degrees are repeated by turning instead of mirroring",
        (
            Replace(
                "luminaires.formats.symmetry:_IMAGES",
                '_IMAGES | {"quadrant": tuple((1.0, 90.0 * k) for k in range(4))}',
            ),
        ),
        ("C03.quad",),
    ),
    Mutation(
        "types A and B",
        "the polar axes of types A and B are exchanged",
        (
            Replace(
                "luminaires.coordinates:FRAMES",
                '{"C": FRAMES["C"], "A": FRAMES["B"], "B": FRAMES["A"]}',
            ),
        ),
        ("C04.B", "C04.A"),
    ),
    Mutation(
        "luminaire's turn",
        "a luminaire's rotation is not applied to its distribution",
        (
            Rewrite(
                "transport.compiled.lamps:_row_of",
                "rotation @ light.distribution.frame",
                "light.distribution.frame",
            ),
        ),
        ("C02.tilted", "C04.B"),
    ),
    Mutation(
        "V by x-bar",
        "the luminous efficiency is the colour-matching function x-bar",
        (
            Rewrite(
                "photometry.spectra:luminous_efficiency", "observer()[:, 1]", "observer()[:, 0]"
            ),
        ),
        ("C32.lines", "C32.sodium"),
    ),
    Mutation(
        "K_m of 673",
        "the maximum luminous efficacy is 673 lm/W instead of 683",
        (Replace("photometry.units:LUMINOUS_EFFICACY", "673.0"),),
        ("C32.lines", "C32.sodium"),
    ),
    Mutation(
        "lines on full nanometres",
        "emission lines are moved to the nearest full nanometre",
        (
            Rewrite(
                "photometry.spectra:emission_lines",
                "np.abs(wavelengths[..., None] - centres)",
                "np.abs(wavelengths[..., None] - np.round(centres))",
            ),
        ),
        ("C32.lines", "C32.sodium", "C32.xy"),
    ),
    Mutation(
        "Jacobian",
        "the density of hits of emitters is that per area, without distance squared over cosine",
        (
            Rewrite(
                "transport.paths.path_loop:emitter_density",
                "emitter.pdf_direction(reference, ds, active)",
                "emitter.pdf_direction(reference, ds, active)"
                " * dr.abs(dr.dot(ds.d, ds.n)) / dr.maximum(dr.square(ds.dist), 1e-20)",
            ),
        ),
        ("C24.edge", "C05.horizon"),
    ),
    Mutation(
        "light counted twice",
        "light found by both strategies counts in full for each",
        (
            Rewrite(
                "transport.paths.path_loop:power_heuristic",
                "dr.rcp(1.0 + dr.square(other / pdf))",
                "mi.Float(1.0)",
            ),
        ),
        ("C20.diffuse", "C19.env"),
    ),
    Mutation(
        "one-sided emitters",
        "one-sided emitters shine from both sides",
        (
            Rewrite(
                _SURFACE, 'props.get("two_sided", False)', 'props.get("two_sided", False) or True'
            ),
        ),
        ("C24.coplanar", "C24.edge"),
    ),
    Mutation(
        "shadows",
        "solid things cast none",
        (
            Rewrite(
                "transport.paths.path_loop:transmittance",
                "active & ~scene.solid.ray_test(ray, active)",
                "mi.Bool(active)",
            ),
        ),
        ("C30.half", "C29.leak", "C09.form"),
    ),
    Mutation(
        "albedo squared",
        "reflectances of matt surfaces are squared",
        (
            Rewrite(
                "transport.compiled.surfaces:_row_spectrum",
                "make.spectrum(colour, PALETTE_STEPS)",
                "make.spectrum(colour, PALETTE_STEPS) ** 2",
            ),
        ),
        ("C20.diffuse", "C10.cube0.95"),
    ),
    Mutation(
        "three bounces",
        "paths end at their third surface",
        (Replace("transport.paths.path_loop:MAXIMUM_STEPS", "3"),),
        ("C10.cube0.95", "C20.diffuse"),
    ),
    Mutation(
        "roulette",
        "what survives Russian roulette is not divided by its chance",
        (Rewrite(_TRACE, "throughput / dr.maximum(survival, 1e-20)", "throughput"),),
        ("C10.cube0.95", "C20.diffuse"),
    ),
    Mutation(
        "polarisation",
        "both polarisations are averaged before the reflections inside a pane",
        (Rewrite(_PANE, "for r in (r_s, r_p):", "for r in (0.5 * (r_s + r_p),) * 2:"),),
        ("C07.slab88", "C07.beam"),
    ),
    Mutation(
        "angle of incidence",
        "panes transmit at every angle what they do at normal incidence",
        (Rewrite(_PANE, "dr.clip(cos_theta, 1e-4, 1.0)", "dr.clip(cos_theta, 1.0, 1.0)"),),
        ("C07.slab88", "C07.beam", "C13.1x1.sky5"),
    ),
    Mutation(
        "mirror",
        "the reflectance of mirrors counts twice for light on its way from a lamp",
        (
            Rewrite(
                "transport.compiled.mirrors:walk",
                "return at, ray.d, polar, value, going",
                "return at, ray.d, polar, value * value, going",
            ),
        ),
        ("C18.mirror_pt", "C18.mirror_total"),
    ),
    Mutation(
        "panes as mirrors",
        "panes are no mirrors to light on its way from a lamp",
        (
            Rewrite(
                "transport.compiled.known_mirrors:KnownMirrors.choose",
                "if with_panes or not p.is_pane",
                "if not p.is_pane",
            ),
        ),
        ("C38.two", "C39.one"),
    ),
    Mutation(
        "polarisation between panes",
        "light is unpolarised before every pane",
        (
            Rewrite(
                "transport.compiled.polarisation:Polarisation.meet",
                "factor = 1.0 + uneven * q",
                "factor = 1.0 + 0.0 * q",
            ),
        ),
        ("C38.two",),
    ),
    Mutation(
        "sun's azimuth",
        "the sky's sun stands in the north instead of the south",
        (
            Rewrite(
                "sky.plugin:_sky_class",
                "mi.Vector3f(*map(float, sun))",
                "mi.Vector3f(*map(float, sun * [1.0, -1.0, 1.0]))",
            ),
        ),
        ("C11.lum12", "C11.vertS"),
    ),
    Mutation(
        "gradation",
        "skies are as bright at the horizon as at the zenith",
        (
            Replace(
                "sky.cie:COEFFICIENTS", "{k: (0.0, -1.0, *v[2:]) for k, v in COEFFICIENTS.items()}"
            ),
        ),
        ("C12.1x1.sky1", "C11.lum12", "C11.Eh60"),
    ),
    Mutation(
        "ground",
        "no light comes from the ground before a window",
        (Rewrite("sky.cie:ground_luminance", "sky.ground_reflectance", "0.0"),),
        ("C14.2x1.ceiling",),
    ),
    Mutation(
        "rows for nodes",
        "the first and last row of pixels of a picture of the surroundings lie at the poles",
        (
            Rewrite(
                "sky.picture_plugin:_picture_class",
                "from_pole = dr.atan2(plan, dr.abs(d.z)) * dr.inv_pi * height",
                "from_pole = dr.atan2(plan, dr.abs(d.z)) * dr.inv_pi * (height - 1.0) + 0.5",
            ),
        ),
        ("C37.cap16", "C37.ramp"),
    ),
    Mutation(
        "sun's disk",
        "the sun is twice as wide at the same luminance",
        (
            Rewrite(
                "transport.compiled.surroundings:make_surroundings",
                "2.0 * np.sin(0.5 * half) ** 2",
                "2.0 * np.sin(half) ** 2",
            ),
        ),
        ("C25.disk", "C21.beam"),
    ),
    Mutation(
        "one cone of an aim",
        "rays to lamps in glass are weighed by the last of the cones that might have given them, not by all",
        (
            Rewrite(
                "transport.light_tracing.bent_lights:BentLights._density",
                "pdf += dr.select(inside,",
                "pdf = dr.select(inside,",
            ),
        ),
        ("C40.sensors10",),
    ),
    Mutation(
        "lamps in glass twice",
        "of luminous surfaces in glass both what is traced and what scattered rays meet counts",
        (
            Rewrite(
                "transport.light_tracing.light_paths:left_out_of",
                "if not starts & {SUN, SURFACE}:",
                "if not starts & {SUN}:",
            ),
        ),
        ("C40.map10", "C40.sensors10"),
    ),
    Mutation(
        "flux in glass",
        "flux that leaves glass is divided by the square of its index, as radiance is",
        (
            Rewrite(
                "transport.light_tracing.deposits:_bend",
                "return bs, weight * dr.square(bs.eta)",
                "return bs, weight",
            ),
        ),
        ("C40.map10",),
    ),
    Mutation(
        "cosine of traced surfaces",
        "light that is traced from luminous surfaces is as strong along them as away from them",
        (
            Rewrite(
                "transport.light_tracing.emission_rays:EmissionRays._amount",
                "value *= dr.abs(dr.dot(surface.n, direction)) / dr.maximum(surface.pdf, 1e-30)",
                "value *= 1.0 / dr.maximum(surface.pdf, 1e-30)",
            ),
        ),
        ("C40.map10",),
    ),
    Mutation(
        "straight light twice",
        "light of suns and lamps on small spots is traced and found from there too",
        (
            Rewrite(
                "transport.light_tracing.straight_lights:StraightLights.__init__",
                "self._leave_out()",
                "pass",
            ),
        ),
        ("C41.hole",),
    ),
    Mutation(
        "guided rays as even ones",
        "rays that are guided to where light lands count as if they were spread evenly",
        (
            Rewrite(
                "transport.light_tracing.straight_lights:StraightLights._launch",
                "flux = flux / density",
                "flux = flux * 1.0",
            ),
        ),
        ("C42.point",),
    ),
    Mutation(
        "guide behind mirrors",
        "what rays read behind a mirror is weighed against a guide that could not have led there",
        (
            Rewrite(
                "transport.paths.cached_gather:_follow",
                "anew = mi.Bool(turned)",
                "anew = turned",
            ),
        ),
        ("C44.half",),
    ),
    Mutation(
        "Guth's index",
        "the glare rating takes the position index once instead of squared",
        (
            Rewrite(
                "analysis.glare:unified_glare_rating",
                "solid_angles / positions**2",
                "solid_angles / positions",
            ),
        ),
        ("C36.ugr",),
    ),
)
"""Each must be found by the quick subset."""


# ---- runs ----


PATIENCE = 120.0
"""Longest time for one group: a fault may leave so much noise that no number of samples is enough. [s]"""


class BrokenOffError(Exception):
    """Groups could not be run to their end; the text says why."""


@dataclass(frozen=True)
class Trial:
    """What one group said.

    Parameters
    ----------
    group : str    Its id.
    passes : bool
    used : float    Largest part of its tolerance that a value's error takes. [-]
    seconds : float
    """

    group: str
    passes: bool
    used: float
    seconds: float


@dataclass
class Outcome:
    """What became of a mutation.

    Parameters
    ----------
    mutation : Mutation
    found_by : list of Trial    Groups that pass without the fault and fail with it.
    asked : int    Groups that were run.
    seconds : float
    fault : str    Why it could not be tried; empty: it could.
    """

    mutation: Mutation
    found_by: list[Trial] = field(default_factory=list)
    asked: int = 0
    seconds: float = 0.0
    fault: str = ""

    @property
    def is_caught(self) -> bool:
        """Whether a group has found it."""
        return bool(self.found_by)

    @property
    def worst(self) -> float:
        """Largest error in multiples of the tolerance; 0 if nothing was found."""
        return max((trial.used for trial in self.found_by), default=0.0)


def quick_groups() -> tuple[str, ...]:
    """Ids of the scored groups of the quick subset."""
    groups = load_groups()
    return tuple(
        key for case in all_cases().values() for key in case.quick if not groups[key].is_informative
    )


def examine(mutation: Mutation | None, groups: Iterable[str]) -> Iterator[Trial]:
    """Run groups in their order, in this process, with a fault or without any."""
    with ExitStack() as stack:
        if mutation is not None:
            stack.enter_context(mutation.injected())
        engine = Engine()
        for key in groups:
            case = all_cases()[load_groups()[key].case]
            for found in run_case(case, Bench(engine, frozenset({key}))):
                verdict = judge(found)
                yield Trial(key, verdict.passes, verdict.used, found.seconds)


def examine_apart(
    mutation: Mutation | None, groups: Sequence[str], stops: bool = False
) -> list[Trial]:
    """As `examine`, in a process of its own.

    Parameters
    ----------
    stops : bool    Whether to end at the first group that fails.

    Raises
    ------
    BrokenOffError    The process ended early, or a group took longer than `PATIENCE`.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(
        target=_send_trials, args=(theirs, mutation, tuple(groups)), daemon=True
    )
    process.start()
    theirs.close()
    trials: list[Trial] = []
    try:
        while len(trials) < len(groups):
            if not ours.poll(PATIENCE):
                raise BrokenOffError(f"{groups[len(trials)]} takes longer than {PATIENCE:.0f} s")
            message = ours.recv()
            if isinstance(message, str):
                raise BrokenOffError(f"{groups[len(trials)]}: {message}")
            trials.append(message)
            if stops and not message.passes:
                break
    except EOFError:
        raise BrokenOffError(f"the process ended in {groups[len(trials)]}") from None
    finally:
        process.kill()
        process.join()
        ours.close()
    return trials


def _send_trials(connection, mutation: Mutation | None, groups: Sequence[str]) -> None:
    """Send trials, and what broke them off."""
    try:
        for trial in examine(mutation, groups):
            connection.send(trial)
    except Exception as error:
        connection.send(f"{type(error).__name__}: {error}")


class Baseline:
    """Which groups pass without a fault; each is run once, when it is asked for."""

    def __init__(self):
        self._passes: dict[str, bool] = {}

    def failing(self, groups: Iterable[str]) -> list[str]:
        """Those of the groups that fail although nothing is wrong."""
        groups = tuple(dict.fromkeys(groups))
        if new := [key for key in groups if key not in self._passes]:
            self._passes |= {t.group: t.passes for t in examine_apart(None, new)}
        return [key for key in groups if not self._passes[key]]


def run(
    mutations: Sequence[Mutation], everything: bool, say: Callable[[str], None]
) -> list[Outcome]:
    """Try mutations one by one.

    Parameters
    ----------
    everything : bool    Whether all groups of the quick subset are run for each, not only until one fails.
    say : callable    Told in one line what was done.

    Raises
    ------
    BrokenOffError    A group that a mutation is likely to be found by fails without it, or could not be run.
    ValueError    It is not in the quick subset.
    """
    quick = quick_groups()
    likely = dict.fromkeys(key for mutation in mutations for key in mutation.likely)
    if strange := [key for key in likely if key not in quick]:
        raise ValueError(f"not in the quick subset: {', '.join(strange)}")
    baseline = Baseline()
    if failing := baseline.failing(quick if everything else likely):
        raise BrokenOffError(f"without a fault these fail already: {', '.join(failing)}")
    say(f"without a fault {len(quick if everything else likely)} groups pass")
    outcomes = []
    for mutation in mutations:
        outcomes.append(_try(mutation, quick, everything, baseline))
        say(_progress(outcomes[-1]))
    return outcomes


def _try(mutation: Mutation, quick: Sequence[str], everything: bool, baseline: Baseline) -> Outcome:
    start = time.perf_counter()
    made = Outcome(mutation)
    left = list(dict.fromkeys([*mutation.likely, *quick]))
    try:
        while left and (everything or not made.is_caught):
            trials = examine_apart(mutation, left, not everything)
            del left[: len(trials)]
            made.asked += len(trials)
            failed = [trial for trial in trials if not trial.passes]
            wrong = baseline.failing(trial.group for trial in failed)
            made.found_by += [trial for trial in failed if trial.group not in wrong]
    except BrokenOffError as error:
        # A fault that breaks the program off is none of physics; it is told, and the others are tried.
        made.fault = str(error)
    made.seconds = time.perf_counter() - start
    return made


def _progress(outcome: Outcome) -> str:
    head = f"{outcome.mutation.name:<26} {outcome.seconds:6.1f} s  "
    if outcome.fault:
        return f"{head}BROKE OFF: {outcome.fault}"
    if not outcome.is_caught:
        return f"{head}SURVIVES {outcome.asked} groups"
    found = ", ".join(trial.group for trial in outcome.found_by)
    return f"{head}caught by {found}: {_multiple(outcome.worst)} of tolerance"


# ---- table ----


def compose_table(outcomes: Sequence[Outcome], everything: bool) -> str:
    """Table of what was found, as Markdown."""
    caught = sum(outcome.is_caught for outcome in outcomes)
    asked = "All its groups were run" if everything else "It was run until a group failed"
    lines = [
        "# Mutation check",
        "",
        "Would the validation suite notice if the engine were wrong? Faults of physics were put into the engine of version",
        f"{VERSION} one at a time, each in a process of its own, and the quick subset of the suite was run against each.",
        f"{asked}; every group named here passes without the fault.",
        "",
        f"**{caught} of {len(outcomes)} faults are caught.** The error is the largest of a value, in multiples of what its",
        f"group allows. The table is made by `make mutations`; `{PROGRAM} --all` runs",
        "the whole quick subset against every fault.",
        "",
        "| fault | what is wrong | caught | by | error / tolerance |",
        "| --- | --- | --- | --- | ---: |",
    ]
    for outcome in outcomes:
        found = ", ".join(trial.group for trial in outcome.found_by)
        word = "yes" if outcome.is_caught else "**no**"
        if outcome.fault:
            found = f"broke off: {outcome.fault}"
        cells = (outcome.mutation.name, outcome.mutation.what, word, found)
        lines.append(f"| {' | '.join(map(_cell, cells))} | {_multiple(outcome.worst)} |")
    lines += ["", "## How each was put in", ""]
    for outcome in outcomes:
        lines.append(f"**{outcome.mutation.name}**")
        for change in outcome.mutation.changes:
            old, new = change.text
            lines += [
                "",
                f"`engine/{change.target.replace('.', '/', 1).replace(':', '.py`, `')}`:",
            ]
            lines += ["", "```diff", f"- {old}", f"+ {new}", "```"]
        lines.append("")
    return "\n".join(lines)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _multiple(used: float) -> str:
    """Multiple of a tolerance with three digits."""
    return f"{used:.3g}" if used < 1000.0 else f"{used:.0f}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the check as a command."""
    names = [mutation.name for mutation in MUTATIONS]
    parser = argparse.ArgumentParser(prog=PROGRAM, description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--only", action="append", default=[], metavar="NAME", choices=names, help=", ".join(names)
    )
    parser.add_argument(
        "--all", action="store_true", help="run all groups, not only until one fails"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help=f"folder for the table (default: {FOLDER}, with --only none)",
    )
    options = parser.parse_args(arguments)
    chosen = [m for m in MUTATIONS if not options.only or m.name in options.only]
    try:
        outcomes = run(chosen, options.all, _say)
    except BrokenOffError as error:
        _say(f"mutations: {error}")
        return 1
    folder = options.output or (None if options.only else FOLDER)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / FILE
        path.write_text(compose_table(outcomes, options.all), encoding="utf-8")
        _say(f"written to {path}")
    survivors = [outcome.mutation.name for outcome in outcomes if not outcome.is_caught]
    _say(f"{len(outcomes) - len(survivors)} of {len(outcomes)} faults are caught")
    return int(bool(survivors))


def _say(line: str) -> None:
    sys.stderr.write(line + "\n")
    sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(main())
