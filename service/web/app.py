"""The routes. Each answers for one user only: whatever is asked for is looked up together with who asks."""

import asyncio
import json
from dataclasses import dataclass
from pathlib import Path

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from ...blender_addon.edited_spectra import library_spectra
from ...blender_addon.scene_edits import library_materials
from ...engine.judgement.reader import known_requirements
from .. import jobs, scenes
from ..accounts import User, new_id
from ..arrivals import Arrivals, no_room
from ..changes import Changes
from ..database import Database
from ..folders import UPLOADS, Folders, list_files, make, remove
from ..jobs import ENDED, Job
from ..orders import WEATHER_FILE
from ..refusals import RefusalError, bad, missing
from ..scenes import Scene
from ..supervisor import Supervisor
from .document import describe_service
from .requests import read_json, save_body, signed_in, tell_http_error, tell_refusal

ROOT = "/api/v1"

LARGEST_UPLOAD = 2 << 30
"""[byte]"""

MAGIC = {
    b"BLENDER": "blend",
    # Compressed: by Zstandard since Blender 3.0, by gzip before.
    b"\x28\xb5\x2f\xfd": "blend",
    b"\x1f\x8b": "blend",
    b"glTF": "gltf",
}
"""First bytes of each kind of upload."""

LARGEST_WEATHER = 16 << 20
"""A year by the hour has 1.6 million bytes, one by the minute of one file of few columns fits as well. [byte]"""

LONGEST_FILE_NAME = 255

HEARTBEAT = 15.0
"""Between words to those who wait for news, so that lines between stay open. [s]"""

FASTEST = 0.25
"""Between two pieces of news. [s]"""

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}
"""Of all answers: nothing of a user's is to stay in a browser."""

POLICY = "default-src 'none'; frame-ancestors 'none'"
"""Of answers to programs: nothing of a user's is to run in a browser."""

PAGE = Path(__file__).parent.parent / "page"
"""The page for people; it asks as any other program does."""

PAGE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; "
    "connect-src 'self' blob:; form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
"""Of the page: it loads nothing from anywhere else."""


@dataclass(frozen=True)
class Service:
    """What answers are made of."""

    database: Database
    folders: Folders
    changes: Changes
    supervisor: Supervisor
    arrivals: Arrivals


def make_app(service: Service) -> Starlette:
    """Return the program that answers requests; ``supervisor`` has to be started by who serves it."""
    app = Starlette(
        routes=[
            *(Route(path, handler, methods=[method]) for method, path, handler, _ in ROUTES),
            Route("/", show_page),
            Mount("/page", StaticFiles(directory=PAGE)),
        ],
        exception_handlers={RefusalError: tell_refusal, HTTPException: tell_http_error},
    )
    app.add_middleware(_Headers)
    app.state.service = service
    return app


class _Headers:
    """Puts `HEADERS` and a policy on every answer."""

    def __init__(self, app):
        self._app = app

    async def __call__(self, scope, receive, send):
        async def send_with_headers(message):
            if message["type"] == "http.response.start":
                is_page = scope["path"] == "/" or scope["path"].startswith("/page/")
                told = HEADERS | {"Content-Security-Policy": PAGE_POLICY if is_page else POLICY}
                own = [(name.lower().encode(), value.encode()) for name, value in told.items()]
                message = {**message, "headers": [*message.get("headers", ()), *own]}
            await send(message)

        await self._app(scope, receive, send_with_headers if scope["type"] == "http" else send)


# ---- the service and the user ----


def show_document(_request: Request) -> Response:
    """What can be asked here, as an OpenAPI document."""
    return JSONResponse(
        describe_service([(method, path, words) for method, path, _, words in ROUTES])
    )


def show_page(_request: Request) -> Response:
    """The page for people."""
    return FileResponse(PAGE / "index.html")


@signed_in
def show_user(request: Request, user: User) -> Response:
    """Answer who asks, and what is taken of what they may."""
    service, quota = request.app.state.service, user.quota
    return JSONResponse(
        {
            "name": user.name,
            "quota": {"jobs": quota.jobs, "disk": quota.disk, "memory": quota.memory},
            "disk": jobs.disk_of(service.database, user),
            "largest_upload": max(0, min(LARGEST_UPLOAD, service.arrivals.room(user))),
        }
    )


@signed_in
def list_materials(_request: Request, _user: User) -> Response:
    """Answer which materials can be put in place of a scene's."""
    titles = library_materials()
    return JSONResponse(
        {"materials": [{"name": key, "title": title} for key, title in titles.items()]}
    )


@signed_in
def list_spectra(_request: Request, _user: User) -> Response:
    """Answer which illuminants a light can be given."""
    return JSONResponse({"spectra": library_spectra()})


@signed_in
def list_requirements(_request: Request, _user: User) -> Response:
    """Answer by which requirements jobs can be judged."""
    known = known_requirements()
    rows = [
        {"key": key, "title": each.title, "standard": each.standard} for key, each in known.items()
    ]
    return JSONResponse({"requirements": rows})


# ---- scenes ----


@signed_in
def list_scenes(request: Request, user: User) -> Response:
    """Answer all scenes, without what is in them."""
    found = scenes.scenes_of(request.app.state.service.database, user)
    return JSONResponse({"scenes": [_scene_row(each) for each in found]})


@signed_in
async def upload_scene(request: Request, user: User) -> Response:
    """Take in a .blend or .glb file, and have it opened."""
    service = request.app.state.service
    name = scenes.check_name(request.query_params.get("name", ""))
    room = await run_in_threadpool(service.arrivals.room, user)
    if room <= 0:
        raise no_room()
    key = new_id()
    folder = service.folders.scene(user.id, key)
    await run_in_threadpool(make, folder)
    try:
        coming = folder / "coming"
        with service.arrivals.receive(user) as take:
            size = await save_body(request, coming, min(LARGEST_UPLOAD, room), take)
            coming.rename(folder / UPLOADS[_find_kind(coming)])
            scene = await run_in_threadpool(
                scenes.add_scene, service.database, user, key, name, size
            )
    except BaseException:
        await run_in_threadpool(remove, folder)
        raise
    service.supervisor.look()
    return JSONResponse(_scene_row(scene), 201)


def _find_kind(path: Path) -> str:
    """Tell what was uploaded by its first bytes; its name may say anything."""
    with path.open("rb") as stream:
        start = stream.read(max(map(len, MAGIC)))
    for magic, kind in MAGIC.items():
        if start.startswith(magic):
            return kind
    raise RefusalError(415, "expected a .blend file of Blender or a binary glTF file (.glb)")


@signed_in
def show_scene(request: Request, user: User) -> Response:
    """Answer a scene with what is in it and with its edits."""
    scene = scenes.find_scene(
        request.app.state.service.database, user, request.path_params["scene"]
    )
    return JSONResponse(_scene_row(scene) | {"content": scene.content, "edits": scene.edits})


@signed_in
def remove_scene(request: Request, user: User) -> Response:
    """Remove a scene with all results."""
    service = request.app.state.service
    scenes.remove_scene(service.database, service.folders, user, request.path_params["scene"])
    return Response(status_code=204)


@signed_in
async def change_edits(request: Request, user: User) -> Response:
    """Put edits in place of those of before."""
    edits = await read_json(request)
    scene = await run_in_threadpool(
        scenes.change_edits,
        request.app.state.service.database,
        user,
        request.path_params["scene"],
        edits,
        library_materials(),
    )
    return JSONResponse({"edits": scene.edits, "revision": scene.revision})


@signed_in
async def upload_weather(request: Request, user: User) -> Response:
    """Take in a weather file of a scene, in place of the one of before."""
    service, key = request.app.state.service, request.path_params["scene"]
    name = request.query_params.get("name", "")
    if not name.strip() or len(name) > LONGEST_FILE_NAME or not name.isprintable():
        raise bad("the weather file needs a name: ?name=town.epw")
    await run_in_threadpool(scenes.find_ready, service.database, user, key)
    folder = service.folders.scene(user.id, key)
    coming, place = folder / f"{new_id()}.coming", folder / WEATHER_FILE
    with service.arrivals.receive(user) as take:
        size = await save_body(request, coming, LARGEST_WEATHER, take)
        before = place.stat().st_size if place.exists() else 0
        coming.replace(place)
        await run_in_threadpool(
            scenes.change_weather, service.database, user, key, name, size - before
        )
    return Response(status_code=204)


# ---- jobs ----


@signed_in
async def submit_job(request: Request, user: User) -> Response:
    """Order a job of a scene."""
    service = request.app.state.service
    order = await read_json(request)
    if not isinstance(order, dict) or not set(order) <= {"kind", "options"}:
        raise bad("expected an object with 'kind' and 'options'")
    scene = await run_in_threadpool(
        scenes.find_ready, service.database, user, request.path_params["scene"]
    )
    job = await run_in_threadpool(
        jobs.submit,
        service.database,
        user,
        scene,
        order.get("kind"),
        order.get("options", {}),
        request.headers.get("idempotency-key"),
    )
    service.supervisor.look()
    return JSONResponse(_job_row(service, job), 201)


@signed_in
def list_jobs(request: Request, user: User) -> Response:
    """Answer the newest jobs; ``?before=NUMBER`` those before."""
    service, before = request.app.state.service, request.query_params.get("before")
    if before is not None and not (before.isascii() and before.isdigit() and len(before) < 19):
        raise bad("'before' is expected to be the number of a job")
    found = jobs.jobs_of(service.database, user, None if before is None else int(before))
    return JSONResponse({"jobs": [_job_row(service, each) for each in found]})


@signed_in
def show_job(request: Request, user: User) -> Response:
    """Answer a job with its progress."""
    service = request.app.state.service
    job = jobs.find_job(service.database, user, request.path_params["job"])
    return JSONResponse(_job_row(service, job) | {"options": job.options, "edits": job.edits})


@signed_in
def cancel_job(request: Request, user: User) -> Response:
    """Cancel a job that waits or runs."""
    service = request.app.state.service
    job = service.supervisor.cancel(user, request.path_params["job"])
    return JSONResponse(_job_row(service, job), 202)


@signed_in
def remove_job(request: Request, user: User) -> Response:
    """Remove an ended job with its results."""
    service = request.app.state.service
    jobs.remove_job(service.database, service.folders, user, request.path_params["job"])
    return Response(status_code=204)


@signed_in
async def follow_job(request: Request, user: User) -> Response:
    """Tell of a job's progress as server-sent events until it has ended."""
    service, key = request.app.state.service, request.path_params["job"]
    await run_in_threadpool(jobs.find_job, service.database, user, key)

    async def tell():
        said = None
        with service.changes.listen(user.id) as news:
            while True:
                news.clear()
                try:
                    job = await run_in_threadpool(jobs.find_job, service.database, user, key)
                except RefusalError:
                    # It was removed meanwhile.
                    return
                row = _job_row(service, job)
                if row != said:
                    said = row
                    yield f"event: job\ndata: {json.dumps(row)}\n\n"
                if job.state in ENDED:
                    return
                await asyncio.sleep(FASTEST)
                try:
                    await asyncio.wait_for(news.wait(), HEARTBEAT)
                except TimeoutError:
                    yield ": waiting\n\n"

    return StreamingResponse(tell(), media_type="text/event-stream")


@signed_in
def list_results(request: Request, user: User) -> Response:
    """Answer names and sizes of a done job's files."""
    service = request.app.state.service
    job = _find_done(service, user, request.path_params["job"])
    files = list_files(service.folders.results(user.id, job.id))
    return JSONResponse({"files": [{"name": name, "bytes": size} for name, size in files]})


@signed_in
def send_result(request: Request, user: User) -> Response:
    """Answer a file of a done job."""
    service = request.app.state.service
    job = _find_done(service, user, request.path_params["job"])
    folder, name = service.folders.results(user.id, job.id), request.path_params["name"]
    # Only what is listed: a path of the user's is compared, never followed.
    if name not in dict(list_files(folder)):
        raise missing("file")
    return FileResponse(folder / name, filename=name.rpartition("/")[2])


def _find_done(service: Service, user: User, key: str) -> Job:
    job = jobs.find_job(service.database, user, key)
    if job.state != jobs.DONE:
        raise missing("result: the job is not done")
    return job


# ---- rows ----


def _scene_row(scene: Scene) -> dict:
    return {
        "id": scene.id,
        "name": scene.name,
        "state": scene.state,
        "note": scene.note,
        "revision": scene.revision,
        "weather": scene.weather,
        "bytes": scene.bytes,
        "created": scene.created,
    }


def _job_row(service: Service, job: Job) -> dict:
    return {
        "id": job.id,
        "number": job.number,
        "scene": job.scene,
        "kind": job.kind,
        "state": job.state,
        "note": job.note,
        "code": job.code,
        "attempts": job.attempts,
        "bytes": job.bytes,
        "created": job.created,
        "started": job.started,
        "ended": job.ended,
        "progress": service.supervisor.progress(job.id) if job.state == jobs.RUNNING else None,
    }


ROUTES = (
    ("GET", "/openapi.json", show_document, "This document"),
    ("GET", f"{ROOT}/me", show_user, "Who asks, and what is taken of what they may"),
    ("GET", f"{ROOT}/materials", list_materials, "Materials that can be put in place of a scene's"),
    ("GET", f"{ROOT}/spectra", list_spectra, "Illuminants that lights can be given"),
    ("GET", f"{ROOT}/requirements", list_requirements, "Requirements by which jobs can be judged"),
    ("GET", f"{ROOT}/scenes", list_scenes, "All scenes"),
    ("POST", f"{ROOT}/scenes", upload_scene, "Upload a .blend or .glb file as ?name=NAME"),
    ("GET", f"{ROOT}/scenes/{{scene}}", show_scene, "A scene, what is in it, and its edits"),
    ("DELETE", f"{ROOT}/scenes/{{scene}}", remove_scene, "Remove a scene with all results"),
    (
        "PUT",
        f"{ROOT}/scenes/{{scene}}/edits",
        change_edits,
        "Put edits in place of those of before",
    ),
    (
        "PUT",
        f"{ROOT}/scenes/{{scene}}/weather",
        upload_weather,
        "Upload a weather file as ?name=NAME",
    ),
    ("POST", f"{ROOT}/scenes/{{scene}}/jobs", submit_job, "Order a job"),
    ("GET", f"{ROOT}/jobs", list_jobs, "The newest jobs, or those before ?before=NUMBER"),
    ("GET", f"{ROOT}/jobs/{{job}}", show_job, "A job with its progress"),
    ("DELETE", f"{ROOT}/jobs/{{job}}", remove_job, "Remove an ended job with its results"),
    ("POST", f"{ROOT}/jobs/{{job}}/cancel", cancel_job, "Cancel a job"),
    ("GET", f"{ROOT}/jobs/{{job}}/events", follow_job, "Progress of a job as server-sent events"),
    ("GET", f"{ROOT}/jobs/{{job}}/files", list_results, "Files of a done job"),
    ("GET", f"{ROOT}/jobs/{{job}}/files/{{name:path}}", send_result, "A file of a done job"),
)
"""Method, path, handler and what it is for, of every route."""
