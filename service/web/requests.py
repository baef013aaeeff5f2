"""What all requests have in common: who asks, bodies with bounds, and answers to what went wrong."""

import asyncio
import json
import time
from collections.abc import Callable
from functools import wraps
from pathlib import Path

from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse

from ..accounts import User, user_of_token
from ..refusals import RefusalError, bad

LARGEST_JSON = 1 << 20
"""Of the body of a request. [byte]"""

CHUNK_PATIENCE = 30.0
"""How long a body may rest. [s]"""

LEAST_RATE = 10_000.0
"""Bytes a second that a body has to come with, once it has taken longer than it may rest."""


def signed_in(handler):
    """Let a handler ``handler(request, user)`` answer only to users."""

    @wraps(handler)
    async def answer(request: Request):
        user = await run_in_threadpool(_find_user, request)
        if asyncio.iscoroutinefunction(handler):
            return await handler(request, user)
        return await run_in_threadpool(handler, request, user)

    return answer


def _find_user(request: Request) -> User:
    scheme, _, token = request.headers.get("authorization", "").partition(" ")
    user = None
    if scheme.lower() == "bearer" and token.strip():
        user = user_of_token(request.app.state.service.database, token.strip())
    if user is None:
        raise RefusalError(401, "expected a token: Authorization: Bearer TOKEN")
    return user


async def read_json(request: Request):
    """Return the body as data of JSON; refuse what is none, or too large."""
    parts, size = [], 0
    async for part in chunks(request, LARGEST_JSON):
        parts.append(part)
        size += len(part)
    try:
        return json.loads(b"".join(parts))
    except (ValueError, RecursionError):
        raise bad("the body is no JSON") from None


async def save_body(request: Request, path: Path, most: int, take: Callable[[int], None]) -> int:
    """Write the body to a new file, and return how large it is; leave no file if it is refused. [byte]

    Parameters
    ----------
    most : int    Larger ones are refused. [byte]
    take : callable    Told how many bytes are to be written next, which it may refuse; see `arrivals.Arrivals`.
    """

    def write(part: bytes) -> None:
        take(len(part))
        stream.write(part)

    size = 0
    try:
        with path.open("xb") as stream:
            async for part in chunks(request, most):
                await run_in_threadpool(write, part)
                size += len(part)
    except BaseException:
        path.unlink(missing_ok=True)
        raise
    return size


async def chunks(request: Request, most: int):
    """Give the body piece by piece; refuse more than ``most`` bytes, and a client that is too slow."""
    stated = request.headers.get("content-length", "")
    if stated.isascii() and stated.isdigit() and int(stated) > most:
        raise _too_large(most)
    begin, size = time.monotonic(), 0
    stream = request.stream().__aiter__()
    while True:
        try:
            async with asyncio.timeout(CHUNK_PATIENCE):
                part = await anext(stream)
        except StopAsyncIteration:
            return
        except TimeoutError:
            raise RefusalError(408, f"nothing came for {CHUNK_PATIENCE:g} s") from None
        except ClientDisconnect:
            raise RefusalError(400, "the body has no end") from None
        size += len(part)
        if size > most:
            raise _too_large(most)
        spent = time.monotonic() - begin
        if spent > CHUNK_PATIENCE and size < LEAST_RATE * spent:
            raise RefusalError(408, f"the body comes with less than {LEAST_RATE:g} bytes a second")
        yield part


def _too_large(most: int) -> RefusalError:
    return RefusalError(413, f"the body is larger than the {most} bytes that may come here")


async def tell_refusal(_request: Request, error: RefusalError) -> JSONResponse:
    """Answer with what was refused."""
    headers = {"WWW-Authenticate": "Bearer"} if error.code == 401 else {}
    # Of a body that is too large the rest is read over for a while, or its sender would not come to read the answer.
    if error.code == 408:
        headers["Connection"] = "close"
    return JSONResponse({"error": str(error)}, error.code, headers)


async def tell_http_error(_request: Request, error) -> JSONResponse:
    """Answer to what no handler is for."""
    words = {404: "there is nothing here", 405: "this cannot be done here"}
    text = words.get(error.status_code, str(error.detail))
    return JSONResponse({"error": text}, error.status_code, error.headers)
