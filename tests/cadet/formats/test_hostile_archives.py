"""Archives and indexes of unknown origin: what no dataset's shard holds is refused in one line that names it."""

from __future__ import annotations

import io
import tarfile
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cadet.errors import CadetError, MissingFileError
from cadet.formats.webdataset import ArchiveError, Shard, ShardDataset, expand_pattern, read_members, tar_reading
from cadet.formats.webdataset.index import index_from_text, text_from_index
from cadet.formats.webdataset.member import Member

GOOD = "000001.calib.txt"


def archive(*infos: tarfile.TarInfo, format: int = tarfile.USTAR_FORMAT) -> bytes:
    """Return an archive of a good member of 700 bytes, and others of as many zeros as they say, up to a kilobyte."""
    file = io.BytesIO()
    with tarfile.open(fileobj=file, mode="w:", format=format) as tar:
        tar.addfile(info(GOOD, size=700), io.BytesIO(b"x" * 700))
        for item in infos:
            tar.addfile(item, io.BytesIO(bytes(item.size)) if item.isreg() and 0 <= item.size <= 1024 else None)
    return file.getvalue()


def info(name: str, kind: bytes = tarfile.REGTYPE, size: int = 0, **fields: object) -> tarfile.TarInfo:
    item = tarfile.TarInfo(name)
    item.type, item.size = kind, size
    for field, value in fields.items():
        setattr(item, field, value)
    return item


def read(data: bytes) -> dict[str, Member]:
    return read_members(io.BytesIO(data), "set/000000.tar")


@pytest.mark.parametrize("format", [tarfile.USTAR_FORMAT, tarfile.GNU_FORMAT, tarfile.PAX_FORMAT])
@pytest.mark.parametrize("name", ["000002.calib.txt", "./000002.calib.txt", "some/" + "folder/" * 16 + "x.txt"])
def test_archives_of_other_programs_are_read(format: int, name: str) -> None:
    data = archive(info("some", tarfile.DIRTYPE), info(name, size=13, mtime=1.5), format=format)
    found = read(data)
    with tarfile.open(fileobj=io.BytesIO(data)) as tar:
        expected = {i.name.removeprefix("./"): (i.offset_data, i.size) for i in tar if i.isreg()}
    assert found == expected
    assert data[found[GOOD].offset :][:700] == b"x" * 700


def test_an_archive_without_members_is_one() -> None:
    assert read(bytes(10240)) == {}


@pytest.mark.parametrize(
    ("item", "said"),
    [
        (info("../000002.calib.txt"), "'../000002.calib.txt' leads out of its folder"),
        (info("a/../../b"), "'a/../../b' leads out of its folder"),
        (info("/etc/passwd"), "'/etc/passwd' has an absolute name"),
        (info("C:/b"), "'C:/b' has an absolute name"),
        (info("\\\\server\\b"), "has an absolute name"),
        (info("a\\..\\b"), "has a name that is not a plain path"),
        (info("a\nb"), "'a\\nb' has a name that is not a plain path"),
        (info("é"), "has a name that is not a plain path"),
        (info("a", tarfile.SYMTYPE, linkname="/etc/passwd"), "'a' is a symbolic link, expected a file"),
        (info("a", tarfile.LNKTYPE, linkname=GOOD), "'a' is a hard link, expected a file"),
        (info("a", tarfile.CHRTYPE), "'a' is a device, expected a file"),
        (info("a", tarfile.BLKTYPE), "'a' is a device, expected a file"),
        (info("a", tarfile.FIFOTYPE), "'a' is a pipe, expected a file"),
        (info("a", b"Z"), "'a' is of the unknown type b'Z', expected a file"),
        (info("a", tarfile.CONTTYPE), "'a' is of the unknown type b'7', expected a file"),
        (info("a", tarfile.GNUTYPE_SPARSE), "'a' is a sparse file, expected a file"),
        (info(GOOD), f"'{GOOD}' appears twice"),
        (info("./" + GOOD), f"'{GOOD}' appears twice"),
        (info("a", size=1 << 32), f"'a' declares {1 << 32} bytes, expected at most {1 << 28}"),
    ],
)
def test_a_hostile_member_is_refused_by_name(item: tarfile.TarInfo, said: str) -> None:
    with pytest.raises(ArchiveError) as refused:
        read(archive(item))
    assert str(refused.value).startswith("set/000000.tar: the member ")
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("format", [tarfile.GNU_FORMAT, tarfile.PAX_FORMAT])
def test_a_header_that_asks_for_much_memory_is_refused(format: int) -> None:
    with pytest.raises(ArchiveError, match=r"the member after '000001.calib.txt': .* a header declares"):
        read(archive(info("x" * 100_000), format=format))


def test_a_negative_size_is_no_endless_loop() -> None:
    with pytest.raises(ArchiveError, match="'a' declares -512 bytes"):
        read(archive(info("a", size=-512), format=tarfile.GNU_FORMAT))


def test_a_sparse_file_of_newer_kind_is_refused() -> None:
    sparse = {"GNU.sparse.major": "0", "GNU.sparse.minor": "1", "GNU.sparse.map": "0,1", "GNU.sparse.size": "99999999"}
    with pytest.raises(ArchiveError, match="'a' is a sparse file"):
        read(archive(info("a", size=5, pax_headers=sparse), format=tarfile.PAX_FORMAT))


def test_there_is_a_limit_to_the_number_of_members(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tar_reading, "MAX_MEMBERS", 3)
    assert len(read(archive(info("a"), info("b")))) == 3
    with pytest.raises(ArchiveError, match="'c' is one more than 3"):
        read(archive(info("a"), info("b"), info("c")))


def test_an_archive_that_is_cut_anywhere_is_refused() -> None:
    data = archive(info("000002.calib.txt", size=700))
    end = len(data.rstrip(b"\0"))
    whole = read(data)
    # The second member's data are zeros, like the end: the archive's is known from the header alone.
    end_of_files = max(member.offset + 1024 for member in whole.values())
    assert end < end_of_files
    for length in range(0, end_of_files + 1024, 100):
        with pytest.raises(ArchiveError, match=r"set/000000\.tar: "):
            read(data[:length])
    assert read(data[: end_of_files + 1024]) == whole


def test_damage_between_members_is_not_taken_for_the_end() -> None:
    data = bytearray(archive(info("000002.calib.txt", size=700)))
    data[512 + 1024 + 3] ^= 0xFF  # in the second header
    with pytest.raises(ArchiveError, match="no member and no end of the archive at byte 1536"):
        read(bytes(data))


@pytest.mark.parametrize("compression", ["gz", "bz2", "xz"])
def test_a_compressed_archive_is_refused(compression: str) -> None:
    file = io.BytesIO()
    with tarfile.open(fileobj=file, mode=f"w:{compression}") as tar:  # type: ignore[call-overload]
        tar.addfile(info("a"))
    with pytest.raises(ArchiveError, match="the first member: invalid tar header"):
        read(file.getvalue())


@settings(max_examples=300, deadline=None)
@given(data=st.binary(max_size=60), at=st.integers(0, 4000), kept=st.integers(0, 6000))
def test_any_damage_is_read_or_refused(data: bytes, at: int, kept: int) -> None:
    whole = archive(info("000002.calib.txt", size=9), info("a" * 120), format=tarfile.PAX_FORMAT)
    damaged = (whole[:at] + data + whole[at + len(data) :])[:kept]
    members: dict[str, Member] = {}
    try:
        members = read(damaged)
    except CadetError as error:
        said = str(error)
    else:
        said = "set/000000.tar: read"
    assert said.startswith("set/000000.tar: ")
    assert "\n" not in said
    assert all(0 < member.offset <= member.offset + member.size <= len(damaged) for member in members.values())


MEMBERS = {
    "000001.calib.txt": Member(512, 700),
    "000001.image_2.png": Member(2048, 3),
    "000002.calib.txt": Member(3072, 0),
}
INDEX = """v1.2 2
calib.txt 512 700 000001.calib.txt image_2.png 2048 3 000001.image_2.png
calib.txt 3072 0 000002.calib.txt
"""


def test_an_index_is_written_and_read_as_it_was() -> None:
    assert text_from_index(MEMBERS) == INDEX
    assert index_from_text(INDEX, "000000.idx") == MEMBERS
    assert index_from_text(text_from_index({}), "000000.idx") == {}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ":1: expected 'v1.2' and a number of samples, got ''"),
        (INDEX.replace("v1.2", "v1.1"), ":1: expected 'v1.2'"),
        (INDEX.replace("2\n", "3\n", 1), ": 2 samples, and its first line says 3"),
        (INDEX[:-1], ":3: the last line has no end: the file is cut"),
        (INDEX.replace(" 700 ", " "), ":2: expected four fields for each file, got 7 in all"),
        (INDEX.replace(" 700 ", " -7 "), ":2: the member '000001.calib.txt': expected an offset and at most"),
        (INDEX.replace(" 700 ", f" {1 << 40} "), ":2: the member '000001.calib.txt': expected an offset and at most"),
        (INDEX.replace("000002.calib", "000001.calib"), ":3: the member '000001.calib.txt' appears twice"),
        (INDEX.replace("000002.calib", "../02.calib"), ": the member '../02.calib.txt' leads out of its folder"),
    ],
)
def test_a_malformed_index_is_refused_with_its_line(text: str, said: str) -> None:
    with pytest.raises(ArchiveError) as refused:
        index_from_text(text, "000000.idx")
    assert str(refused.value).startswith(f"000000.idx{said}")


@pytest.mark.parametrize(
    "changed",
    [
        lambda text: text.replace(" 512 ", " 513 "),
        lambda text: text.replace(" 512 ", " 0 "),
        lambda text: text.replace(" 512 ", f" {1 << 40} "),
        lambda text: text.replace(" 700 ", " 699 "),
        lambda text: text.replace("000001.calib.txt", "000009.calib.txt"),
        lambda text: text.replace(" 512 700 ", " 1536 0 "),  # a link's header
    ],
)
def test_an_index_is_not_believed(tmp_path: Path, changed: Callable[[str], str]) -> None:
    path = tmp_path / "000000.tar"
    path.write_bytes(archive(info(GOOD, tarfile.SYMTYPE, linkname="/etc/passwd")))
    text = f"v1.2 1\ncalib.txt 512 700 {GOOD}\n"
    path.with_suffix(".idx").write_text(text)
    assert Shard.open(path).read(GOOD) == b"x" * 700
    path.with_suffix(".idx").write_text(changed(text))
    shard = Shard.open(path)
    with pytest.raises(ArchiveError, match=rf"{path}: there is no member '00000\d.calib.txt' of \d+ bytes at byte \d+"):
        shard.read(next(iter(shard.members)))


def test_a_shard_that_is_cut_after_it_was_opened_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "000000.tar"
    path.write_bytes(archive())
    shard = Shard.open(path)
    path.write_bytes(archive()[:1000])
    with pytest.raises(ArchiveError, match=f"the member '{GOOD}' is cut: 488 of 700 bytes"):
        shard.read(GOOD)


def test_a_member_that_is_no_frames_file_is_refused(tmp_path: Path) -> None:
    for name in ("000002.caption.txt", ".calib.txt", "train/000002.calib.txt"):
        (tmp_path / "a.tar").write_bytes(archive(info(name)))
        with pytest.raises(ArchiveError, match=f"{tmp_path}/a.tar: the member '{name}' is not a frame's file"):
            ShardDataset([tmp_path / "a.tar"])


def test_a_frame_in_two_shards_is_refused(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.tar").write_bytes(archive())
    with pytest.raises(ArchiveError, match=f"b.tar: the member '{GOOD}': {tmp_path}/a.tar holds the frame 000001"):
        ShardDataset(expand_pattern(f"{tmp_path}/*.tar"))


def test_patterns_name_shards(tmp_path: Path) -> None:
    for number in range(8, 12):
        (tmp_path / f"s-{number:03d}.tar").touch()
    paths = [tmp_path / f"s-{number:03d}.tar" for number in range(8, 12)]
    assert list(expand_pattern(f"{tmp_path}/s-{{008..011}}.tar")) == paths
    assert list(expand_pattern(f"{tmp_path}/s-0{{08..09}}.tar")) == paths[:2]
    assert list(expand_pattern(f"{tmp_path}/s-0{{0..1}}{{8..8}}.tar".replace("{0..1}", "{0..0}"))) == paths[:1]
    assert list(expand_pattern(f"{tmp_path}/*.tar")) == paths
    with pytest.raises(MissingFileError, match=r"s-012\.tar: no such shard, of .*\{008\.\.012\}"):
        expand_pattern(f"{tmp_path}/s-{{008..012}}.tar")
    with pytest.raises(MissingFileError, match="no shard has such a name"):
        expand_pattern(f"{tmp_path}/t*.tar")
    with pytest.raises(CadetError, match="expected a range that rises"):
        expand_pattern(f"{tmp_path}/s-{{5..1}}.tar")
    with pytest.raises(CadetError, match="expected a range that rises"):
        expand_pattern(f"{tmp_path}/s-{{0..99999}}{{0..99999}}.tar")
