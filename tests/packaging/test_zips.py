"""Zips of the extension, checked by reading: what Blender or the system would refuse is refused before."""

import stat
import struct
import zipfile

import native_libraries
import pytest
from binaries import read_library
from checks import check_zip
from extension_zips import NAMES, make_zip
from project import BuildError, read_project


def refusal(path):
    """Return the sentence with which a zip is refused."""
    with pytest.raises(BuildError) as caught:
        check_zip(path, "1.2.3")
    return str(caught.value)


def test_a_sound_zip_tells_what_it_asks_for(tmp_path):
    found = check_zip(make_zip(tmp_path, native_libraries.elf()), "1.2.3")
    assert str(found.target) == "linux-x64-cp311"
    # The manifest, __init__.py and the wheel, and of it the library, WHEEL, LICENSE and RECORD.
    assert (found.files, len(found.libraries)) == (7, 1)
    assert (2, 2) < found.needs["GLIBC"] <= (2, 28)
    assert found.newer == ()


def test_a_library_without_a_table_of_sections_is_read_all_the_same():
    whole = native_libraries.elf()
    known = read_library("core.so", whole)
    bare = bytearray(whole)
    # Where the table lies, the size of its rows, their number and the row of the names.
    bare[0x28:0x30] = bytes(8)
    bare[0x3A:0x40] = bytes(6)
    assert read_library("core.so", bytes(bare)) == known
    assert {"libc.so.6", "libstdc++.so.6"} <= set(known.imports)


@pytest.mark.parametrize(
    "wheel",
    [
        "light-1.0-cp313-cp313-manylinux_2_28_x86_64.whl",
        "light-1.0-cp311-cp311-win_amd64.whl",
        "light-1.0-cp311-cp311-manylinux_2_28_aarch64.whl",
        "light-1.0-cp312-abi3-manylinux_2_28_x86_64.whl",
        "light-1.0-cp3x-abi3-manylinux_2_28_x86_64.whl",
        "light-1.0-cp311-cp311-musllinux_1_2_x86_64.whl",
    ],
)
def test_a_wheel_for_something_else_is_refused(tmp_path, wheel):
    assert f"the wheel {wheel} is not for linux-x64-cp311" in refusal(
        make_zip(tmp_path, wheel=wheel)
    )


@pytest.mark.parametrize(
    "wheel",
    [
        "light-1.0-py3-none-any.whl",
        "light-1.0-cp39-abi3-manylinux2014_x86_64.whl",
        "light-1.0-cp311-cp311-manylinux_2_27_x86_64.manylinux_2_28_x86_64.whl",
    ],
)
def test_a_wheel_that_fits_is_taken(tmp_path, wheel):
    check_zip(make_zip(tmp_path, wheel=wheel), "1.2.3")


def test_a_wheel_without_tags_is_refused(tmp_path):
    assert "light-1.0.whl is no name of a wheel" in refusal(
        make_zip(tmp_path, wheel="light-1.0.whl")
    )


def test_a_library_that_asks_for_what_nobody_has_is_refused(tmp_path):
    linux = native_libraries.elf().replace(b"libstdc++.so.6\0", b"libnowhere.so\0\0")
    assert "light/core.so asks for libnowhere.so, which neither" in refusal(
        make_zip(tmp_path, linux)
    )
    windows = native_libraries.pe().replace(b"KERNEL32.dll\0", b"NOWHERES.dll\0")
    path = make_zip(tmp_path, windows, "windows-x64")
    assert "asks for NOWHERES.dll" in refusal(path)
    macos = native_libraries.mach_o(["@rpath/libnowhere.dylib"])
    path = make_zip(tmp_path, macos, "macos-arm64")
    assert "asks for @rpath/libnowhere.dylib" in refusal(path)


@pytest.mark.parametrize(
    ("platform", "library", "kind"),
    [
        ("linux-x64", native_libraries.elf(), "ELF"),
        ("windows-x64", native_libraries.pe(), "PE"),
        ("macos-arm64", native_libraries.mach_o(["/usr/lib/libSystem.B.dylib"]), "Mach-O"),
    ],
)
def test_a_library_that_is_cut_off_is_refused(tmp_path, platform, library, kind):
    path = make_zip(tmp_path, library[:60], platform)
    assert f"light/core.so begins like {kind} and cannot be read" in refusal(path)


def test_a_library_with_an_endless_table_is_read_to_an_end():
    """The table of the versions that it asks for, whose rows tell where the next one lies: here none, without end."""
    library = bytearray(native_libraries.elf())
    number = library.index(struct.pack("<Q", 0x6FFFFFFF)) + 8
    library[number : number + 8] = struct.pack("<Q", 1 << 62)
    assert read_library("core.so", bytes(library)).needs["GLIBC"] > (2, 2)


def test_a_zip_that_is_cut_off_or_encrypted_is_refused(tmp_path):
    path = make_zip(tmp_path)
    whole = path.read_bytes()
    path.write_bytes(whole[:200])
    assert f"{path.name} cannot be read as a zip" in refusal(path)
    path.write_bytes(whole.replace(b"PK\1\2\x14\3\x14\0\0\0", b"PK\1\2\x14\3\x14\0\1\0"))
    assert f"{path.name} cannot be read as a zip" in refusal(path)


def test_a_wheel_without_its_licence_is_refused(tmp_path):
    path = make_zip(tmp_path, licence="README")
    assert f"{NAMES['linux-x64'][1]} has no text of its licence" in refusal(path)


def test_libraries_of_windows_and_macos_find_the_system(tmp_path):
    check_zip(make_zip(tmp_path, native_libraries.pe(), "windows-x64"), "1.2.3")
    macos = native_libraries.mach_o(["/usr/lib/libSystem.B.dylib"], oldest=(13, 3))
    found = check_zip(make_zip(tmp_path, macos, "macos-arm64"), "1.2.3")
    assert found.newer == ("macOS 13.3 is needed, with Blender 4.2 it may be 11.0: core.so",)


def test_a_library_for_another_system_is_refused(tmp_path):
    path = make_zip(tmp_path, native_libraries.elf(), "macos-arm64")
    assert "light/core.so is ELF for x86_64, expected Mach-O for arm64" in refusal(path)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"maintainer": None}, "maintainer must be stated"),
        (
            {"platforms": '["linux"]'},
            "the platform 'linux' is none of linux-x64, windows-x64, macos-arm64",
        ),
        ({"platforms": '"linux-x64"'}, "platforms is str, expected list"),
        ({"platforms": '["windows-x64"]'}, "the manifest is for windows-x64"),
        ({"tagline": '"It ends with a full stop."'}, "no full stop: 'It ends with a full stop.'"),
        ({"permissions": "{files = 3}"}, "permissions must give a text for each"),
        ({"permissions": '{files = "Read and write."}'}, "files must have at most 64 characters"),
        ({"version": '"1.2"'}, "version is '1.2', expected a version such as 1.2.3"),
        ({"version": '"1.2.4"'}, "the manifest is version 1.2.4, pyproject.toml 1.2.3"),
        ({"license": '["MIT"]'}, "the license 'MIT' does not begin with SPDX:"),
        ({"id": '"Lumen ray"'}, "id is 'Lumen ray', expected a Python name in lower case"),
        ({"colour": '"red"'}, "colour is no key that we use"),
        (
            {"wheels": '["./wheels/other.whl"]'},
            "the manifest lists other wheels than the zip holds",
        ),
        ({"name": "Lumenray"}, "blender_manifest.toml cannot be read: Invalid value"),
    ],
)
def test_a_broken_manifest_is_refused(tmp_path, changes, sentence):
    assert sentence in refusal(make_zip(tmp_path, changes=changes))


@pytest.mark.parametrize(
    "name", ["../outside.py", "/etc/outside", "a/../../outside", "C:outside", "a\\..\\b"]
)
def test_a_name_that_leads_outside_is_refused(tmp_path, name):
    assert "leads outside; such a zip is refused" in refusal(make_zip(tmp_path, extra=[(name, "")]))


def test_a_link_and_a_name_that_comes_twice_are_refused(tmp_path):
    link = zipfile.ZipInfo("link")
    link.external_attr = (stat.S_IFLNK | 0o777) << 16
    assert "'link' is a link" in refusal(make_zip(tmp_path, extra=[(link, "/etc/passwd")]))
    twice = [("a.py", "1"), ("A.py", "2")]
    assert "'A.py' is there twice" in refusal(make_zip(tmp_path, extra=twice))


def test_the_manifest_of_the_repository_is_sound():
    """As it is in a zip: narrowed to one platform, with the wheels that are beside it."""
    import tomllib
    from pathlib import Path

    from archive import drop_building, narrow_manifest
    from manifest_checks import check_manifest
    from project import ROOT

    source = ROOT / "blender_manifest.toml"
    text = drop_building(source, narrow_manifest(source, "macos-arm64", [Path("a.whl")]))
    check_manifest("the zip", tomllib.loads(text))
    assert tomllib.loads(text)["wheels"] == ["./wheels/a.whl"]


def test_every_target_has_every_wheel_recorded():
    """Else a zip could not be built where the index cannot be asked what there is."""
    from built_wheels import BUILT, LEFT_OUT, downloaded_pins
    from targets import all_targets
    from wheels import read_lock

    project, recorded = read_project(), read_lock()
    for target in all_targets():
        pins = downloaded_pins(project, target)
        for pin in pins:
            assert sum(each.fits(*pin, target) for each in recorded) == 1, (pin, target)
        made = {each.name for each in BUILT if target in each.targets}
        without = {name for other, name in LEFT_OUT if other == target}
        assert {name for name, _ in project.pins} <= {name for name, _ in pins} | made | without
