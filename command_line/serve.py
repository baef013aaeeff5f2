"""The command ``lumenray serve``: scenes and jobs of several users over HTTP."""

from pathlib import Path

from ..engine.errors import LumenrayError
from .options import real, whole
from .output import say, table

GIGABYTE = 1 << 30

EPILOG = """examples:
  lumenray serve work --add-user Ada          prints her token, once
  lumenray serve work                         answers on http://127.0.0.1:8080
  lumenray serve work --host 0.0.0.0 --certificate town.pem --key town.key

What can be asked stands in /openapi.json. It needs Linux 6.2 or newer with Landlock, by which the files of users are opened
and computed in processes that reach nothing else of the machine.
"""


def add_command(commands) -> None:
    """Describe the command to argparse."""
    serve = commands.add_parser(
        "serve", help="scenes and jobs of several users over HTTP", epilog=EPILOG
    )
    serve.add_argument("folder", type=Path, metavar="DIR", help="where all of it is kept")
    serve.add_argument(
        "--host", default="127.0.0.1", help="address of this machine (default: 127.0.0.1)"
    )
    serve.add_argument(
        "--port", type=whole(0, 65535), default=8080, help="0: any that is free (default: 8080)"
    )
    serve.add_argument(
        "--certificate", type=Path, metavar="F.pem", help="speak TLS with this certificate"
    )
    serve.add_argument("--key", type=Path, metavar="F.pem", help="of the certificate")
    serve.add_argument(
        "--behind-proxy",
        action="store_true",
        help="another program before it speaks TLS; it may be reached from other machines without",
    )
    serve.add_argument(
        "--jobs", type=whole(1, 64), default=1, metavar="N", help="that run at once (default: 1)"
    )
    serve.add_argument(
        "--most-time",
        type=real(1.0),
        default=3600.0,
        metavar="S",
        help="seconds after which a job is ended (default: 3600)",
    )
    _add_users(serve.add_argument_group("users (nothing is served then)"))
    serve.set_defaults(run=run)


def _add_users(group) -> None:
    group.add_argument("--add-user", metavar="NAME", help="take in a user and print the token")
    group.add_argument(
        "--new-token",
        metavar="NAME",
        help="make all tokens of a user worthless, and print a new one",
    )
    group.add_argument("--list-users", action="store_true", help="print who may use it")
    group.add_argument(
        "--most-jobs",
        type=whole(),
        default=100,
        metavar="N",
        help="of a new user, at once (default: 100)",
    )
    group.add_argument(
        "--most-disk", type=real(), default=10.0, metavar="GB", help="of a new user (default: 10)"
    )
    group.add_argument(
        "--most-memory",
        type=real(),
        default=8.0,
        metavar="GB",
        help="of a job of a new user (default: 8)",
    )


def run(options) -> int:
    """Serve, or take in users; return the exit code."""
    try:
        from ..service.web import server
    except ImportError as error:
        raise LumenrayError(
            f"the service needs packages that are not here ({error.name}); install them with pip install 'lumenray[service]'"
        ) from None
    if options.add_user or options.new_token or options.list_users:
        with server.open_folder(options.folder) as (_, database):
            _change_users(options, database)
        return 0
    if (options.certificate is None) != (options.key is None):
        raise LumenrayError("--certificate and --key go together")
    for path in filter(None, (options.certificate, options.key)):
        if not path.is_file():
            raise LumenrayError(f"{path}: no such file")
    address = server.Address(
        options.host, options.port, options.certificate, options.key, options.behind_proxy
    )
    server.serve(
        options.folder,
        address,
        options.jobs,
        options.most_time,
        lambda place: say(f"answers on {place}; Ctrl-C ends it"),
    )
    return 0


def _change_users(options, database) -> None:
    from ..service import accounts

    if options.add_user:
        quota = accounts.Quota(
            options.most_jobs,
            int(options.most_disk * GIGABYTE),
            int(options.most_memory * GIGABYTE),
        )
        user = accounts.add_user(database, options.add_user, quota)
        say(accounts.add_token(database, user))
    if options.new_token:
        user = accounts.find_user(database, options.new_token)
        accounts.revoke_tokens(database, user)
        say(accounts.add_token(database, user))
    if options.list_users:
        rows = [("user", "jobs", "disk, GB", "memory, GB")]
        for user in accounts.users(database):
            quota = user.quota
            disk, memory = (f"{each / GIGABYTE:.3g}" for each in (quota.disk, quota.memory))
            rows.append((user.name, str(quota.jobs), disk, memory))
        say(table(rows))
