"""Benchmarks in parts, which can be measured alone and gone on with."""

from collections.abc import Callable, Iterable

from ...engine.errors import LumenrayError


def choose_parts(
    parts: Iterable[str] | None, names: tuple[str, ...], kept: Iterable[str]
) -> list[str]:
    """Return those that are asked for; without any, all that are not kept from an earlier run.

    Raises
    ------
    LumenrayError    There is no such part.
    """
    unknown = [name for name in parts or () if name not in names]
    if unknown:
        raise LumenrayError(
            f"there is no part {', '.join(unknown)}; choose from {', '.join(names)}"
        )
    return list(parts or (name for name in names if name not in kept))


def measure_parts(
    measures: dict[str, Callable], parts: Iterable[str] | None, earlier: dict | None, say: Callable
) -> dict:
    """Measure parts, and return their results with those that are kept of an earlier run, by their names.

    Raises
    ------
    LumenrayError    There is no such part.
    """
    kept = {} if earlier is None else earlier["parts"]
    wanted = choose_parts(parts, tuple(measures), kept)
    return {**kept, **{name: measures[name](say) for name in measures if name in wanted}}
