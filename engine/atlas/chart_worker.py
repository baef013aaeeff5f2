"""A process of its own that asks xatlas for charts: it may crash or be killed, for xatlas can do one and not be stopped.

Run by path, it knows nothing of the package. Standard input brings one line with the order, then requests; standard output
takes the answers. Both are numpy archives after eight bytes that say how long they are. The end of the input ends it.
"""

import io
import json
import os
import struct
import sys

LENGTH = struct.Struct("<Q")


def main() -> None:
    """Answer requests until the input ends."""
    order = json.loads(sys.stdin.buffer.readline())
    sys.path[:] = order["search_path"]
    # Whatever the library prints must not get between the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    while True:
        head = sys.stdin.buffer.read(LENGTH.size)
        if len(head) < LENGTH.size:
            return
        limit_time(order["seconds"])
        blob = answer(sys.stdin.buffer.read(LENGTH.unpack(head)[0]))
        answers.write(LENGTH.pack(len(blob)))
        answers.write(blob)
        answers.flush()


def limit_time(seconds: float) -> None:
    """Let the system end this process should it outlive its parent in the midst of a search. [s]"""
    if sys.platform == "win32":
        return
    import resource

    usage = resource.getrusage(resource.RUSAGE_SELF)
    spent = usage.ru_utime + usage.ru_stime
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    most = int(spent + seconds * (os.cpu_count() or 1)) + 2
    if hard != resource.RLIM_INFINITY:
        most = min(most, hard)
    resource.setrlimit(resource.RLIMIT_CPU, (most, hard))


def answer(request: bytes) -> bytes:
    """Find charts. The request holds ``points``, ``triangles`` and how many ``faces`` of them are of each group.

    The answer holds ``uv`` (f, 3, 2) in the points' unit and ``chart`` (f,), -1 where xatlas gave none.
    """
    import numpy as np
    import xatlas

    with np.load(io.BytesIO(request), allow_pickle=False) as held:
        points, triangles, faces = held["points"], held["triangles"], held["faces"]
    atlas = xatlas.Atlas()
    ends = np.cumsum(faces)
    for start, end in zip(ends - faces, ends, strict=True):
        part = triangles[start:end]
        low = int(part.min())
        atlas.add_mesh(
            np.ascontiguousarray(points[low : int(part.max()) + 1]),
            np.ascontiguousarray(part - low),
        )
    # The places of the charts on xatlas's own page do not matter: a coarse one is found soonest.
    packing = xatlas.PackOptions()
    packing.texels_per_unit = 1.0
    packing.padding = 0
    packing.rotate_charts = False
    packing.rotate_charts_to_axis = False
    atlas.generate(xatlas.ChartOptions(), packing)
    size = np.array([max(atlas.width, 1), max(atlas.height, 1)], dtype=np.float64)
    uv, chart = [], []
    for number in range(len(faces)):
        _, indices, places = atlas[number]
        owners = atlas.get_mesh_vertex_assignment(number)[1].astype(np.int64)
        owners[owners >= 0xFFFFFFFF] = -1
        uv.append((places * size)[indices])
        chart.append(owners[indices].min(axis=1))
    made = io.BytesIO()
    np.savez(made, uv=np.concatenate(uv), chart=np.concatenate(chart))
    return made.getvalue()


if __name__ == "__main__":
    main()
