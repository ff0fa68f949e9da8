"""Zip archives of strangers: a member that unpacks to more than its bound is refused before it is unpacked."""

import io
import resource
import zipfile
from pathlib import Path

import numpy as np
import pytest

from atari.base.archives import read_member
from atari.lab.causal.files import load
from atari.learning import load_policy

ZEROS = bytes(100 << 20)


def archive_with(method: int = zipfile.ZIP_DEFLATED, **members: bytes) -> io.BytesIO:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return file


def test_members() -> None:
    with zipfile.ZipFile(archive_with(a=b"12345")) as archive:
        assert read_member(archive, "a", 5) == b"12345"
        with pytest.raises(ValueError, match="'a' unpacks to 5 bytes, and 4 are allowed"):
            read_member(archive, "a", 4)
        with pytest.raises(ValueError, match="it has no 'b'"):
            read_member(archive, "b", 5)
    bz2 = zipfile.ZipFile(archive_with(zipfile.ZIP_BZIP2, a=b"1"))
    with bz2 as archive, pytest.raises(ValueError, match="'a' is not packed by Deflate"):
        read_member(archive, "a", 5)


def test_a_size_that_is_a_lie_unpacks_no_more() -> None:
    data = bytearray(archive_with(a=bytes(1 << 20)).getvalue())
    at = data.rindex(b"PK\1\2") + 24
    data[at : at + 4] = (16).to_bytes(4, "little")
    with zipfile.ZipFile(io.BytesIO(data)) as archive, pytest.raises(ValueError, match="'a' is damaged"):
        read_member(archive, "a", 16)


@pytest.mark.parametrize("members", [("_stable_baselines3_version", "data"), ("a/code/__torch__.py", "a/data.pkl")])
def test_policies_that_are_bombs(members: tuple[str, str], tmp_path: Path) -> None:
    file = tmp_path / "policy.zip"
    file.write_bytes(archive_with(**{members[0]: b"2", members[1]: ZEROS}).getvalue())
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(
        ValueError, match=r"is damaged: '.*' unpacks to 104,857,600 bytes, and 70,\d{3},\d{3} are allowed"
    ):
        load_policy(file)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50 << 10


def test_causal_maps_that_are_bombs(tmp_path: Path) -> None:
    file = tmp_path / "map.npz"
    file.write_bytes(archive_with(**{"facts.npy": ZEROS}).getvalue())
    with pytest.raises(ValueError, match=r"'facts\.npy' unpacks to 104,857,600 bytes, and 1,048,576 are allowed"):
        load(file)
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"shape": (2**40,), "fortran_order": False, "descr": "|u1"})
    file.write_bytes(archive_with(**{"facts.npy": header.getvalue()}).getvalue())
    with pytest.raises(ValueError, match="is not a causal map of this version: cannot reshape"):
        load(file)
