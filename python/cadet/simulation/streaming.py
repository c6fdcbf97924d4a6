"""Endless frames straight from the simulator, in a set order whatever the number of processes."""

from __future__ import annotations

import os
import queue
import signal
import threading
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Final

from cadet._util.checks import as_seed, check_number, shown
from cadet._util.interrupts import interrupts_held
from cadet._util.operating_system import num_processors
from cadet._util.worker_processes import WorkerContext, WorkerProcess, may_start_workers
from cadet.errors import CadetError, CadetWarning, WorkerError
from cadet.formats.kitti import Frame
from cadet.sensors.rig import Rig
from cadet.simulation.environment import Environment
from cadet.worlds.assets import Assets
from cadet.worlds.config import SceneConfig
from cadet.worlds.policy import ResetPolicy
from cadet.worlds.road_map import RoadMap
from cadet.worlds.weather import Weather

_MOST_EPISODES: Final = 10**9


@dataclass(frozen=True)
class _Share:
    """The episodes that one process makes: every `step`-th from `first_episode` on."""

    environment: Environment
    seed: int
    first_episode: int
    step: int
    skipped: int
    """Samples of the first of them that are made and thrown away."""

    def frames(self) -> Iterator[Frame]:
        skipped = self.skipped
        for episode in range(self.first_episode, _MOST_EPISODES, self.step):
            self.environment.reset(seed=self.seed, episode=episode)
            for sample in range(self.environment.policy.samples_per_episode):
                frame = self.environment.step()
                if sample >= skipped:
                    yield replace(frame, sample=None)
            skipped = 0


class FrameStream:
    """An endless iterator of frames; `close` it, use it in `with`, or let it go to end its processes.

    The n-th frame is the n-th frame of `cadet-gen --seed s` with the same policy, or of its share of the episodes.
    """

    def __init__(self, environment: Environment, seed: int, workers: int, first: int, shard: tuple[int, int]) -> None:
        self._position = first
        self._samples = environment.policy.samples_per_episode
        number, skipped = divmod(first, self._samples)
        index, count = shard
        # Each process takes every n-th episode of this shard; what is skipped lies in the first one's.
        self._shares = [
            _Share(environment, seed, index + count * (number + k), count * max(workers, 1), skipped if k == 0 else 0)
            for k in range(max(workers, 1))
        ]
        self._first_number = number
        self._own = self._shares[0].frames() if workers == 0 else None
        self._processes: list[tuple[Connection, WorkerProcess]] = []
        if workers > 0:
            self._start(max(1, num_processors() // workers))

    def _start(self, num_threads: int) -> None:
        context = WorkerContext()
        with interrupts_held():
            for share in self._shares:
                ours, theirs = context.Pipe(duplex=False)
                process = context.Process(target=_serve, args=(theirs, share, num_threads), daemon=True)
                process.start()
                theirs.close()
                self._processes.append((ours, process))

    @property
    def position(self) -> int:
        """How many frames of the stream lie before the next one: `first` of a stream that goes on here."""
        return self._position

    def __iter__(self) -> Iterator[Frame]:
        return self

    def __next__(self) -> Frame:
        frame = self._receive() if self._own is None else next(self._own)
        self._position += 1
        return frame

    def _receive(self) -> Frame:
        if not self._processes:
            raise CadetError("stream: it was closed")
        turn = (self._position // self._samples - self._first_number) % len(self._processes)
        connection, process = self._processes[turn]
        try:
            message = connection.recv()
        except (EOFError, ConnectionError):
            process.join(timeout=5.0)
            self.close()
            raise WorkerError(f"stream: a worker died with exit code {process.exitcode}") from None
        if isinstance(message, Frame):
            return message
        self.close()
        raise CadetError(str(message))

    def close(self) -> None:
        """End the processes; the stream yields no more."""
        processes, self._processes = self._processes, []
        if self._own is not None:
            self._own = iter(())
        for connection, process in processes:
            connection.close()
            process.terminate()
        for _, process in processes:
            process.join(timeout=5.0)
            if process.is_alive():
                process.kill()
                process.join()

    def __enter__(self) -> FrameStream:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        # An object whose construction failed has none.
        if getattr(self, "_processes", None):
            self.close()


def stream(
    policy: ResetPolicy | str | None = None,
    *,
    seed: int = 0,
    workers: int | None = None,
    first: int = 0,
    shard: tuple[int, int] = (0, 1),
    rig: Rig | None = None,
    map: RoadMap | str | Path | None = None,
    weather: Weather | str | None = None,
    config: SceneConfig | None = None,
    assets: Assets | str | Path | None = None,
    sensors: Iterable[str] | None = None,
) -> FrameStream:
    """Yield an endless stream of frames, without a dataset on disk: the same ones in the same order for any `workers`.

    Args:
        policy: how worlds are drawn, or the name of a preset; `ResetPolicy.kitti()` if None.
        seed: names every random draw.
        workers: processes that make them, each an episode ahead of what is read at most (20 frames of KITTI's rig take
            some 70 MB); 0 for none but this one. If None, one for each processor, or 0 in a process that can start
            none, such as a data loader's worker.
        first: frames to leave out at the start, as `FrameStream.position` counts them: a run goes on where it stopped.
        shard: (i, n): of every n episodes the i-th alone, for several readers that share a stream without overlap.
        rig: as for `Environment`, like all that follow.
        map: an OpenDRIVE file, or one that was read.
        weather: a preset of `weather_names()`, or numbers.
        config: how full every scene is, and what gets a label; what it was not given is drawn.
        assets: the user's own meshes, or their folder.
        sensors: names of sensors besides the first camera and LIDAR.

    Raises:
        CadetError: as `Environment`; a number out of range, or an invalid shard. While it runs: no world of an
            episode showed a labeled object, or a worker died (`WorkerError`).
    """
    environment = Environment(
        policy=policy, rig=rig, map=map, weather=weather, config=config, assets=assets, sensors=sensors
    )
    if workers is None:
        workers = num_processors() if may_start_workers() else 0
    check_number("stream", "workers", workers, 0, 1024, whole=True)
    check_number("stream", "first", first, 0, 10**12, whole=True)
    is_pair = isinstance(shard, tuple) and len(shard) == 2
    if not is_pair or not all(isinstance(n, int) and not isinstance(n, bool) for n in shard):
        raise CadetError(f"stream.shard: expected (number, count), got {shown(shard)}")
    if not 0 <= shard[0] < shard[1] <= 10**6:
        raise CadetError(f"stream.shard: expected a number below its count, got {shown(shard)}")
    return FrameStream(environment, as_seed(seed), int(workers), int(first), shard)


def _serve(connection: Connection, share: _Share, num_threads: int) -> None:
    """Make the frames of a share, an episode ahead of what is read, until nobody listens."""
    # Ctrl-C reaches the whole process group; the parent decides what happens then.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.setdefault("RAYON_NUM_THREADS", str(num_threads))
    warnings.simplefilter("ignore", CadetWarning)
    # While the others' episodes are read, there must be room for one of its own: else they would work by turns.
    made: queue.Queue[Frame | str] = queue.Queue(share.environment.policy.samples_per_episode)
    threading.Thread(target=_send_all, args=(connection, made), daemon=True).start()
    try:
        for frame in share.frames():
            made.put(frame)
    except CadetError as error:
        made.put(str(error))
    except BaseException as error:  # noqa: BLE001 - a panic of the core is none of Exception's kind
        made.put(f"{type(error).__name__}: {' '.join(str(error).split()) or 'no message'}")
    threading.Event().wait()


def _send_all(connection: Connection, made: queue.Queue[Frame | str]) -> None:
    try:
        while True:
            connection.send(made.get())
    except (OSError, ValueError):
        # Nobody reads any more: the maker may be in the middle of a frame or wait for room.
        os._exit(0)
