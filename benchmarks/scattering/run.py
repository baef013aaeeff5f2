"""Measured materials: storage over error, sampling, speed against others, pictures, and a back-light, in one run."""

from pathlib import Path

from ..common.machine import OtherLoad, describe_machine
from ..common.output import write_numbers
from .backlight import measure_backlight
from .pictures import measure_pictures
from .sampling import measure_sampling
from .speed import measure_speed
from .storage import measure_storage


def run(say=None) -> dict:
    """Measure everything. ``say``: told in one line what was done. The result is plain data for JSON."""
    told = say or (lambda line: None)
    parts = {
        "storage": lambda: measure_storage(told),
        "sampling": lambda: measure_sampling(told),
        "speed": lambda: measure_speed(told),
        "pictures": lambda: measure_pictures(told),
        "backlight": lambda: measure_backlight(told),
    }
    result: dict = {"machine": describe_machine(), "other_load": {}}
    for name, measure in parts.items():
        load = OtherLoad()
        result[name] = measure()
        result["other_load"][name] = load.share()
    return result


def write_results(result: dict, folder: Path, json_path: Path | None) -> None:
    """Write the document and its picture, and all numbers as JSON if wanted."""
    from .chart import draw_pictures, draw_storage
    from .document import write_document

    folder.mkdir(parents=True, exist_ok=True)
    draw_storage(result["storage"]).save(folder / "scattering_storage.png")
    draw_pictures(result["pictures"]).save(folder / "scattering_pictures.png")
    write_document(result, folder / "scattering.md")
    plain = [{k: v for k, v in row.items() if k != "pictures"} for row in result["pictures"]]
    write_numbers(result | {"pictures": plain}, json_path)
