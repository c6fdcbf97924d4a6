"""Datasets in object stores: fsspec's own in memory, and S3 as moto serves it on this machine's loopback."""

from __future__ import annotations

import errno
import json
import sys
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest

from cadet import CadetError, ResetPolicy
from cadet._util.sink import LocalSink, Sink, read_each
from cadet.cli import run_cadet_gen
from cadet.generate import Settings
from cadet.generate.folder import open_folder
from cadet.generate.object_sink import ObjectSink, is_url, open_sink
from gen_process import FAILED, FINE, SIZE, run, tree
from small_runs import small_policy


@pytest.fixture(scope="module")
def endpoint() -> Iterator[str]:
    """Serve S3 on a free port of loopback, with credentials and endpoint where S3's libraries look for them."""
    for module in ("moto", "s3fs", "boto3"):
        pytest.importorskip(module, reason=f"needs {module}")
    from moto.server import ThreadedMotoServer

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
        for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
            patch.setenv(name, "testing")
        patch.setenv("AWS_DEFAULT_REGION", "us-east-1")
        yield f"http://{host}:{port}"
    server.stop()


@pytest.fixture
def bucket(endpoint: str) -> str:
    import boto3

    name = f"bucket-{uuid.uuid4().hex}"
    boto3.client("s3", endpoint_url=endpoint).create_bucket(Bucket=name)
    return name


def objects(endpoint: str, bucket: str) -> dict[str, bytes]:
    """Read a bucket by Amazon's own library."""
    import boto3

    client = boto3.client("s3", endpoint_url=endpoint)
    pages = client.get_paginator("list_objects_v2").paginate(Bucket=bucket)
    keys = [entry["Key"] for page in pages for entry in page.get("Contents", [])]
    return {key: client.get_object(Bucket=bucket, Key=key)["Body"].read() for key in keys}


@pytest.fixture(params=["memory", "s3", "folder"])
def sink(request: pytest.FixtureRequest, tmp_path: Path) -> Sink:
    if request.param == "folder":
        return LocalSink(tmp_path / "set")
    if request.param == "memory":
        pytest.importorskip("fsspec", reason="needs fsspec")
        return ObjectSink(f"memory://{uuid.uuid4().hex}/set")
    return ObjectSink(f"s3://{request.getfixturevalue('bucket')}/set")


def test_every_sink_behaves_alike(sink: Sink) -> None:
    with sink.held():
        assert sink.names("") == []
        sink.put("a/b.txt", b"one")
        sink.put("a/b.txt", (chunk for chunk in (b"t", b"wo")))
        sink.put_all({"a/c.txt": b"", "d.bin": b"\0" * 100_000})
        sink.put_new("e", b"first")
        with pytest.raises(FileExistsError):
            sink.put_new("e", b"second")
        assert sink.read("e") == b"first"
        assert sink.read_all(["d.bin", "a/b.txt", "a/c.txt"]) == [b"\0" * 100_000, b"two", b""]
        assert sink.read_all([]) == []
        assert sink.names("") == ["a", "d.bin", "e"]
        assert sink.names("a") == ["b.txt", "c.txt"]
        assert sink.names("nothing") == []
        for names in (["a/x.txt"], ["e", "a/x.txt"]):
            with pytest.raises(FileNotFoundError) as missing:
                sink.read_all(names)
            assert missing.value.filename == f"{sink.location}/a/x.txt"
        many = [f"many/{number}" for number in range(300)]
        sink.put_all({name: name.encode() for name in many})
        assert list(read_each(sink, many)) == [name.encode() for name in many]
        sink.make_folder("testing")
        sink.remove_partial()


def test_chunks_that_end_in_an_error_leave_the_old_object(sink: Sink) -> None:
    sink.put("a/b.txt", b"old")

    def chunks() -> Iterator[bytes]:
        yield b"new"
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OSError, match="No space left on device"):
        sink.put("a/b.txt", chunks())
    assert sink.read("a/b.txt") == b"old"
    assert sink.names("a") == ["b.txt"]


@pytest.mark.timeout(300)
def test_a_set_in_s3_has_the_bytes_of_a_local_one_and_is_resumed(
    endpoint: str,
    bucket: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    import boto3

    command = ("-n", 7, "--seed", 3, *SIZE, "--workers", 2)
    assert run(tmp_path / "local", *command).returncode == FINE
    wanted = {name: (tmp_path / "local" / name).read_bytes() for name in tree(tmp_path / "local")}
    url = f"s3://{bucket}/deep/set"
    done = run(url, *command)
    assert (done.returncode, done.stdout) == (FINE, ""), done.stderr
    assert f"7 frames in {url} at " in done.stderr
    found = {key.removeprefix("deep/set/"): data for key, data in objects(endpoint, bucket).items()}
    assert found == wanted

    # Refused before a worker starts, so this process may ask.
    for arguments, message in {
        ("-n", "7"): f"{url} is not empty: name a new folder, or go on with --resume\n",
        ("-n", "7", "--resume"): f"{url} was begun with other settings: seed was 3, now 0; give the same",
        ("-n", "6", "--seed", "3", "--resume"): f"{url} has frames up to 000006 already: give at least -n 7\n",
    }.items():
        monkeypatch.setattr(ResetPolicy, "kitti", small_policy)
        monkeypatch.setattr(sys, "argv", ["cadet-gen", url, *SIZE, *arguments])
        with pytest.raises(SystemExit) as ended:
            run_cadet_gen()
        assert ended.value.code == FAILED
        assert capsys.readouterr().err.startswith(f"cadet-gen: {message}")

    client = boto3.client("s3", endpoint_url=endpoint)
    client.delete_object(Bucket=bucket, Key="deep/set/training/velodyne/000002.bin")
    client.put_object(Bucket=bucket, Key="deep/set/training/image_2/000005.png", Body=b"damaged")
    done = run(url, *command, "--resume")
    assert "7 frames (5 were there)" in done.stderr
    assert {key.removeprefix("deep/set/"): data for key, data in objects(endpoint, bucket).items()} == wanted


def test_of_two_runs_that_begin_at_once_one_is_refused(bucket: str, monkeypatch: pytest.MonkeyPatch) -> None:
    url = f"s3://{bucket}/set"
    settings = Settings(num_frames=1, policy=ResetPolicy.kitti())
    names = ObjectSink.names

    def names_late(self: ObjectSink, folder: str) -> list[str]:
        found = names(self, folder)
        # Another one begins after ours has found nothing there.
        ObjectSink(url).put("run.json", json.dumps({"seed": 1}).encode())
        return found

    monkeypatch.setattr(ObjectSink, "names", names_late)
    with (
        pytest.raises(CadetError, match=f"^another cadet-gen has just begun in {url}: let it end first$"),
        open_folder(url, settings, resume=False),
    ):
        pass
    assert ObjectSink(url).read("run.json") == b'{"seed": 1}'


def test_a_bucket_that_is_not_there_costs_one_line(endpoint: str) -> None:
    done = run("s3://no-such-bucket/set", "-n", 1, *SIZE)
    assert done.returncode == FAILED
    assert done.stderr.startswith("cadet-gen: s3://no-such-bucket/set/run.json: ")
    assert "bucket does not exist" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_file_url_is_a_folder(tmp_path: Path) -> None:
    done = run(f"file://{tmp_path}/out", "-n", 2, *SIZE)
    assert done.returncode == FINE, done.stderr
    assert run(tmp_path / "plain", "-n", 2, *SIZE).returncode == FINE
    assert tree(tmp_path / "out") == tree(tmp_path / "plain")


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("sftp://host/set", "a write that is cut short could leave part of a file at sftp://; expected a folder"),
        ("memory://set", "a write that is cut short"),
        ("s3://", "expected a bucket and a name in it, such as s3://bucket/set"),
        ("file://set", "expected file:///FOLDER"),
    ],
)
def test_urls_that_are_no_places_are_refused(url: str, message: str) -> None:
    with pytest.raises(CadetError, match=message):
        open_sink(url)


def test_what_is_no_url_is_a_folder(tmp_path: Path) -> None:
    for root in (tmp_path, str(tmp_path), "C:/x", "a:b", "out"):
        assert not is_url(root)
        assert isinstance(open_sink(root), LocalSink)


def test_without_its_library_a_store_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fsspec", None)
    with pytest.raises(CadetError, match=r"^s3://b/set needs fsspec: pip install 'cadet-sim\[remote\]'$"):
        open_sink("s3://b/set")
