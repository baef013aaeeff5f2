"""Pinned versions are looked up among records as OSV publishes them (cut short: references and severities left out)."""

import json
import zipfile
from datetime import UTC, datetime, timedelta

import known_weaknesses
import pytest
from known_weaknesses import NPM, PYPI, Pin, find_weaknesses
from project import BuildError

STARLETTE = {
    "id": "GHSA-f96h-pmfr-66vw",
    "modified": "2025-01-21T18:27:11.000Z",
    "published": "2024-10-15T18:12:28Z",
    "aliases": ["CVE-2024-47874"],
    "summary": "Starlette Denial of service (DoS) via multipart/form-data",
    "affected": [
        {
            "package": {"name": "starlette", "ecosystem": "PyPI", "purl": "pkg:pypi/starlette"},
            "ranges": [{"type": "ECOSYSTEM", "events": [{"introduced": "0"}, {"fixed": "0.40.0"}]}],
            "versions": ["0.1.0", "0.39.2"],
        }
    ],
}

REQUESTS = {
    "id": "PYSEC-2023-74",
    "modified": "2023-06-05T01:13:00Z",
    "aliases": ["CVE-2023-32681", "GHSA-j8r2-6x86-q33q"],
    "details": "Requests is a HTTP library.\n\nSince Requests 2.3.0 ...",
    "affected": [
        {
            "package": {"name": "Requests", "ecosystem": "PyPI"},
            "ranges": [
                {
                    "type": "GIT",
                    "repo": "https://github.com/psf/requests",
                    "events": [{"introduced": "0"}, {"fixed": "74ea7cf7a6a27a4eeb2ae24e162bcc942a6706d5"}],
                },
                {"type": "ECOSYSTEM", "events": [{"introduced": "2.3.0"}, {"fixed": "2.31.0"}]},
            ],
        }
    ],
}  # fmt: skip

THREE = {
    "id": "GHSA-fq6p-x6j3-cmmq",
    "modified": "2023-11-08T04:01:41Z",
    "aliases": ["CVE-2020-28496"],
    "summary": "Denial of service in three",
    "affected": [
        {
            "package": {"ecosystem": "npm", "name": "three"},
            "ranges": [{"type": "SEMVER", "events": [{"introduced": "0"}, {"fixed": "0.125.0"}]}],
        }
    ],
}


def found(record, name, version, ecosystem=PYPI):
    return find_weaknesses({Pin(ecosystem, name, version)}, [("a.json", record)]).weaknesses


def ranged(*events, **more):
    affected = {
        "package": {"name": "thing", "ecosystem": "PyPI"},
        "ranges": [{"type": "ECOSYSTEM", "events": list(events)}],
    }
    return {"id": "PYSEC-1", "modified": "2026-01-01T00:00:00Z", "affected": [affected | more]}


@pytest.mark.parametrize(
    ("record", "name", "version", "ecosystem", "is_weak"),
    [
        (STARLETTE, "starlette", "0.39.2", PYPI, True),
        (STARLETTE, "starlette", "0.40.0", PYPI, False),
        (STARLETTE, "starlette", "1.10.0", PYPI, False),
        # Not as texts, of which "0.4.0" comes after "0.39".
        (STARLETTE, "starlette", "0.4.0", PYPI, True),
        (STARLETTE, "starlette", "0.40.0rc1", PYPI, True),
        (REQUESTS, "requests", "2.2.1", PYPI, False),
        (REQUESTS, "requests", "2.3", PYPI, True),
        (REQUESTS, "requests", "2.30.0.post1", PYPI, True),
        (REQUESTS, "requests", "2.31.0", PYPI, False),
        (THREE, "three", "0.124.0", NPM, True),
        (THREE, "three", "0.187.0", NPM, False),
        # A package of that name elsewhere is another package.
        (THREE, "three", "0.124.0", PYPI, False),
    ],
)
def test_a_version_is_weak_within_the_ranges_of_a_record(record, name, version, ecosystem, is_weak):
    assert bool(found(record, name, version, ecosystem)) == is_weak


@pytest.mark.parametrize(
    ("record", "weak", "sound"),
    [
        (ranged({"introduced": "1"}, {"last_affected": "1.5"}), ["1", "1.5"], ["0.9", "1.5.1"]),
        # Two ranges in one list, in no order.
        (
            ranged({"fixed": "3.1"}, {"introduced": "3"}, {"fixed": "1.2"}, {"introduced": "0"}),
            ["0.1", "1.1", "3.0"],
            ["1.2", "2.9", "3.1"],
        ),
        (ranged({"introduced": "0"}, {"limit": "2"}), ["1.9"], ["2", "2.1"]),
        (ranged(versions=["1.0+local"]), ["1.0+local"], ["1.0"]),
        (ranged({"introduced": "1"}, {"fixed": "1"}), [], ["1", "2"]),
        (ranged({"introduced": "0"}) | {"withdrawn": "2026-02-01T00:00:00Z"}, [], ["1"]),
    ],
)
def test_ranges_of_all_kinds(record, weak, sound):
    assert [each for each in weak if not found(record, "thing", each)] == []
    assert [each for each in sound if found(record, "thing", each)] == []


def test_what_cannot_be_decided_is_told_and_not_left_out():
    (told,) = found(ranged({"introduced": "0"}, {"fixed": "2007-final"}), "thing", "1.0")
    assert "cannot be decided: Invalid version: '2007-final'" in str(told)


def test_what_a_weakness_is_called_and_what_helps():
    (told,) = found(REQUESTS, "requests", "2.30.0")
    assert str(told) == (
        "requests 2.30.0: PYSEC-2023-74, CVE-2023-32681, GHSA-j8r2-6x86-q33q: Requests is a HTTP library.; fixed in 2.31.0"
    )


def test_the_pins_of_the_project():
    pins = known_weaknesses.read_pins()
    named = {(each.ecosystem, each.name) for each in pins}
    assert {(PYPI, "starlette"), (PYPI, "uvicorn"), (PYPI, "openexr"), (NPM, "three")} <= named


def written(folder, *records):
    for record in records:
        (folder / f"{record['id']}.json").write_text(json.dumps(record))
    return str(folder)


def test_the_command_tells_weaknesses_and_the_age_of_the_data(tmp_path, monkeypatch, capsys):
    pins = {Pin(PYPI, "starlette", "0.39.2"), Pin(PYPI, "requests", "2.34.2")}
    monkeypatch.setattr(known_weaknesses, "read_pins", lambda: pins)
    changed = (datetime.now(UTC) - timedelta(days=3)).isoformat()
    folder = written(tmp_path, STARLETTE, REQUESTS | {"modified": changed})
    assert known_weaknesses.main([folder]) == 1
    weakness, summary = capsys.readouterr().out.splitlines()
    assert weakness.startswith("starlette 0.39.2: GHSA-f96h-pmfr-66vw, CVE-2024-47874: ")
    assert summary.startswith("2 pinned versions, 2 records: 1 known weaknesses; ")
    assert summary.endswith(f"{changed[:10]}, 3 days ago")
    assert known_weaknesses.main([folder, "--accept", "CVE-2024-47874"]) == 0
    assert "0 known weaknesses, 1 accepted" in capsys.readouterr().out


def test_a_zip_serves_as_well_and_old_data_are_told_to_be_so(tmp_path, capsys):
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as archive:
        archive.writestr("PYSEC-2023-74.json", json.dumps(REQUESTS))
    assert known_weaknesses.main([str(tmp_path / "all.zip")]) == 0
    assert "they are old" in capsys.readouterr().out


def test_without_data_it_is_said_that_nothing_was_checked(capsys):
    assert known_weaknesses.main([]) == 0
    assert capsys.readouterr().out.startswith("NOT CHECKED")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"{", "is no JSON"),
        (b"[]", "is no record"),
        (b'{"id": "A"}', "is no record"),
        (b'{"id": "A", "modified": "soon"}', "has no date"),
        (None, "there is no record"),
    ],
)
def test_data_that_cannot_be_read_are_no_all_clear(tmp_path, capsys, content, told):
    if content is not None:
        (tmp_path / "A.json").write_bytes(content)
    assert known_weaknesses.main([str(tmp_path)]) == 2
    assert told in capsys.readouterr().err


def test_what_is_neither_a_folder_nor_a_zip(tmp_path):
    (tmp_path / "all.zip").write_bytes(b"no zip")
    for name in ("all.zip", "nowhere"):
        with pytest.raises(BuildError, match="neither a folder nor a zip"):
            list(known_weaknesses.read_records(tmp_path / name))
