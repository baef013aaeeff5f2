"""Program of a process of its own that holds Blender's Python module and answers requests with Cycles.

It imports nothing of ours but, by their paths, two modules: the program of the validation suite that builds scenes, and that
which has ``answer(request, builder)``. The key of the connection and both paths come on standard input, a line each. What
goes back is the answer, or the text of an error.
"""

import importlib.util
import sys
from pathlib import Path


def load(path: str):
    """Return a file as a module."""
    spec = importlib.util.spec_from_file_location(Path(path).stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


if __name__ == "__main__":
    word, *paths = (sys.stdin.readline().rstrip("\n") for _ in range(3))
    builder, task = map(load, paths)
    builder.serve(bytes.fromhex(word), lambda request: task.answer(request, builder))
