"""Downloads for the zips: what keeps pip from them is told in one sentence."""

import build_extension
import package_index
import pytest
from project import BuildError


@pytest.fixture(autouse=True)
def settings(monkeypatch, tmp_path):
    """Let pip have no place for packages but the index, and the builder an empty cache."""
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.setenv("PIP_FIND_LINKS", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def test_without_the_package_index_the_build_ends_in_one_sentence(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("PIP_INDEX_URL", "http://127.0.0.1:9/simple")
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    monkeypatch.setenv("PIP_RETRIES", "1")
    assert build_extension.main(["--all", "--output", str(tmp_path / "dist")]) == 1
    (sentence,) = capsys.readouterr().err.splitlines()
    assert "the package index cannot be reached, from which pip was to download" in sentence
    assert sentence.endswith(" for linux-x64-cp311")


def test_what_pip_says_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    with pytest.raises(BuildError, match=r"pip could not download light: Could not find a version"):
        package_index.download(["no-such-package==1"], tmp_path, "light")
