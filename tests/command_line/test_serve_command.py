"""The command `lumenray serve` as far as it ends by itself: users, and what it refuses."""

import pytest
from commands import run_command

from lumenray.service import accounts
from lumenray.service.web.server import open_folder


def test_users_are_taken_in_listed_and_given_new_tokens(tmp_path, capsys):
    code, first, _ = run_command("serve", capsys, tmp_path, "--add-user", "Ada", "--most-disk", "2")
    assert code == 0
    _, second, _ = run_command("serve", capsys, tmp_path, "--new-token", "Ada")
    with open_folder(tmp_path) as (_, database):
        assert accounts.user_of_token(database, first.strip()) is None
        user = accounts.user_of_token(database, second.strip())
    assert (user.name, user.quota.disk) == ("Ada", 2 << 30)
    _, listed, _ = run_command("serve", capsys, tmp_path, "--list-users")
    assert "Ada" in listed


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--host", "192.0.2.1"], "--certificate"),
        (["--host", "everywhere"], "expected an address"),
        (["--certificate", "a.pem"], "go together"),
        (["--certificate", "a.pem", "--key", "b.pem"], "no such file"),
        (["--new-token", "Nobody"], "no user 'Nobody'"),
    ],
)  # fmt: skip
def test_what_is_refused(tmp_path, capsys, arguments, told):
    code, _, error = run_command("serve", capsys, tmp_path, *arguments)
    assert code == 1
    assert told in error
