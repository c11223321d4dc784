"""Runs and studies on many machines, by Dask: ``pip install "./python[dask]"`` in a checkout.

>>> from dask.distributed import Client
>>> import nephroid as ne, nephroid.dask
>>> film = nephroid.dask.render(ne.load_file("scenes/glass-ball.xml"), error=0.01, client=Client("head:8786"))

Dask sends tasks to workers, and sends them again if a worker is lost. This module cuts work into tasks, names what is kept
of them by a hash of its contents, and puts results together: to the bits of the same work in one piece.
"""

from __future__ import annotations

import contextlib
import hashlib
import heapq
import importlib.util
import itertools
import math
import os
import queue
import tempfile
import threading
import time
import uuid
import warnings
import weakref
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

try:
    import dask.config
    import distributed
    from distributed.core import Status
except ImportError as _missing:
    raise ImportError('nephroid.dask needs dask.distributed: pip install "distributed>=2024.8"') from _missing

from . import _nephroid
from ._errors import Error, SettingError
from ._nephroid import Film, Scene, StudyProgress
from ._steps import Step, next_step
from ._study import Report, _asked, _read
from ._text import checked_scene, wish

__all__ = ["Progress", "render", "validate"]

#: Photons, paths or rays of beams that a task is worth: some seconds, of which setting it up is a small part.
_TASK_WORK = 1 << 22

#: Seconds between two calls of a callback.
_PERIOD = 0.1

#: Seconds between two looks for workers that came or went.
_LOOK = 1.0

#: Looks after which a task without a worker is sent again.
_MOST_LOOKS = 5

#: Seconds without any worker before a warning says so.
_PATIENCE = 30.0

#: Tasks that a worker has at a time: one that it makes, and one that waits. What a lost worker had counts against a task,
#: so no more wait there.
_AHEAD = 2

#: Priority of scenes and files: larger than that of any task.
_FIRST = 1 << 40

#: How much more than is missing to an error its last round has, as the schedule of rounds takes it.
_CAUTION = 1.2


@dataclass(frozen=True)
class Progress:
    """How far a run or a study is. Work counts once its task is done."""

    #: Work done, in ``unit``; what was kept from before is done.
    done: int
    #: What ``done`` is expected to come to; of a run to an error, by the end of its round or pass.
    expected: int
    #: ``photons``, ``paths`` (of photon maps, those of photons and of cameras together), ``rays`` of beams, as forecast,
    #: or ``runs`` of a study, where a part of an attribution counts as one.
    unit: str
    #: The relative error of the rounds that are done; None while unknown.
    relative_error: float | None
    #: Seconds since its start.
    seconds: float


Callback = Callable[[Progress], object]


class _Stopped(Exception):
    """The callback wants no more."""


@dataclass(frozen=True)
class _Files:
    """Files that many tasks need."""

    name: str
    paths: tuple[Path, ...]

    def read(self) -> dict[str, bytes]:
        """What there is of them: a task makes what is missing."""
        found = {}
        for path in self.paths:
            # Another call with the same folder may be done with them.
            with contextlib.suppress(FileNotFoundError):
                found[path.name] = path.read_bytes()
        return found


@dataclass(frozen=True)
class _Task:
    #: Its own among those of a call, which makes it the key that Dask knows it by.
    name: str
    #: What is called with a scene and further arguments.
    function: Callable[..., Any]
    scene: Scene
    arguments: tuple[Any, ...]
    #: Larger ones begin first.
    priority: int = 0
    #: Further arguments, each files by their names. They are read as the task is sent.
    files: tuple[_Files, ...] = ()
    #: Names of tasks that come before it.
    needs: tuple[str, ...] = ()


def render(
    scene: Scene,
    sensor: str | None = None,
    method: str | None = None,
    error: float | str | None = None,
    photons: int | None = None,
    seed: int | None = None,
    progress: Callback | None = None,
    *,
    client: Any = None,
    folder: str | os.PathLike[str] | None = None,
    tasks: int | None = None,
    filter: str | None = None,
    overlap: bool = True,
    **settings: object,
) -> Film | None:
    """Fills a sensor by photons on the workers of a Dask cluster, or by ``method="photon-map"``, ``"path"`` or ``"beams"``.

    The film has the bits of :func:`nephroid.render` with the same method and settings, on any number of workers. It ends at a
    relative ``error`` or after so much work (``photons``, or ``spp`` of paths). Rounds of a run to an error are one task
    each until they have 2**23 photons or paths, and passes of beams until they have as many rays. Beams end at an
    ``error`` alone. What they leave to photons is made here, on all cores.

    ``client`` is a ``distributed.Client``, by default the current one. Workers need nephroid, and no files: the scene's
    come along. One task at a time uses all threads of a worker.

    ``folder`` keeps the sums of each task, so that the same call goes on from there after whatever ended it. ``tasks``
    is how many a round or a pass has at most, by default one for each 2**22 photons, paths or rays. A task has one
    replicate at least, and of paths 16 rows of the image.

    ``progress`` is called about every 100 ms; if it returns False, tasks are stopped and the result is None. Ctrl-C stops
    them, too.

    ``overlap=False`` leaves workers idle that have nothing more to do in a round of a run to an error. Else they begin the
    next round, if the error so far forecasts that it is needed in full. If it is not, their work is thrown away.

    Raises what :func:`nephroid.render` raises, and ``distributed.KilledWorker`` if a task has lost several workers.
    """
    if tasks is not None and tasks < 1:
        raise SettingError(f'tasks is "{tasks}"; allowed are whole numbers > 0')
    given = {"error": error, "photons": photons, "seed": seed, **settings}
    asked = wish(sensor, method, given, None, filter)
    gathering = _nephroid.Gathering(checked_scene(scene), asked)
    kept = None if folder is None else Path(folder)
    if kept is not None:
        kept.mkdir(parents=True, exist_ok=True)
    start = time.monotonic()
    done = expected = 0
    unit = {None: "photons", "photons": "photons", "beams": "rays"}.get(method, "paths")

    def tell() -> bool:
        now = Progress(done, expected, unit, gathering.relative_error, time.monotonic() - start)
        return progress is None or progress(now) is not False

    def cut(step: Step) -> list[_Task]:
        count = min(step.most_parts, tasks or max(1, step.work // _TASK_WORK))
        # Of a round begun early, too, which has the same if it is wanted.
        name = f"nephroid-part-{hashlib.sha256(step._step.encode()).hexdigest()[:32]}"
        return [_Task(f"{name}-{i}-of-{count}", _part, scene, (step, i, count)) for i in range(1, count + 1)]

    goal = _goal(error) if overlap else None
    with _Call(client, tell) as call:
        while not isinstance(step := next_step(gathering, asked, lambda _: tell()), Film):
            if step is None:
                return None
            before, expected = done, done + step.work
            todo = []
            for task in cut(step):
                _, i, count = task.arguments
                if kept is not None and _is_added(gathering, kept / _kept_name(step.key, i, count), i, count):
                    done += _share(step.work, i, count)
                else:
                    todo.append(task)
            # A run that goes on from a folder finds parts of later rounds there: none are made before their time.
            is_new = done == before
            is_doubled = is_new and _is_doubled(gathering.relative_error, goal, before, step.work, step.left)
            later = cut(step._doubled()) if is_doubled else []
            try:
                for task, part in call.results(todo, later):
                    _, i, count = task.arguments
                    gathering.add(part, i, count)
                    done += _share(step.work, i, count)
                    if kept is not None:
                        _write(kept / _kept_name(step.key, i, count), part)
            except _Stopped:
                return None
    tell()
    return step


def validate(
    study: str | os.PathLike[str] | Scene | Mapping[str, object],
    folder: str | os.PathLike[str] | None = None,
    sensors: str | Sequence[str] | None = None,
    candidates: Mapping[str, Any] | None = None,
    max_error: Mapping[str, float | str] | None = None,
    margin: float | None = None,
    repeats: int | None = None,
    progress: Callback | None = None,
    *,
    client: Any = None,
    **params: object,
) -> Report | None:
    """Makes the runs of a study on the workers of a Dask cluster, and its report here.

    It does what :func:`nephroid.validate` does, with the same figures. Each run is a task, and so is each truth. An
    attribution is a task for its first run, and then one for every four others. They get the truth's film from here, and
    go before runs that wait. Files go into ``folder`` as they come, and are not made again. Workers need nephroid, and no
    files. Seconds of runs on several machines have no order; counters do.

    ``client`` and ``progress`` are as in :func:`render`. A study with a ``time`` is refused.
    """
    start = time.monotonic()
    with _asked(study, folder, sensors, candidates, max_error, margin, repeats, None, None, params) as asked:
        subject, place, given = asked
        text, poses = _nephroid.units(subject, os.fspath(place), given)
        expected = sum(len(units) for *_, units in poses)
        done = sum(is_kept for *_, units in poses for *_, is_kept in units)

        def name(key: str) -> str:
            return f"nephroid-run-{key[:32]}"

        def tell(_: StudyProgress | None = None) -> bool:
            now = Progress(done, expected, "runs", None, time.monotonic() - start)
            return progress is None or progress(now) is not False

        todo: dict[str, _Task] = {}
        # The same run may be asked for twice, and a pose may be.
        folders: dict[str, list[Path]] = {}
        for _, runs, scene, units in poses:
            of = {}
            for number, (key, needs, files, urgency, is_kept) in enumerate(units):
                of[key] = _Files(f"nephroid-files-{key[:32]}", tuple(Path(runs, file) for file in files))
                if not is_kept:
                    # Of a sweep, the last runs take longest.
                    priority = number + expected * urgency
                    arguments = (key, {**given, "study": text})
                    # Units come after what they need: that is among the tasks, or kept.
                    before = tuple(one for one in map(name, needs) if one in todo)
                    needed = tuple(of[one] for one in needs)
                    todo[name(key)] = _Task(name(key), _unit, scene, arguments, priority, needed, before)
                    folders.setdefault(name(key), []).append(Path(runs))
        try:
            with _Call(client, tell) as call:
                for task, files in call.results(todo.values()):
                    for place_of_runs in dict.fromkeys(folders[task.name]):
                        _keep(place_of_runs, files)
                    done += len(folders[task.name])
        except _Stopped:
            return None
        found = _nephroid.validate(subject, os.fspath(place), given, tell)
    return None if found is None else _read(place, found)


class _Call:
    """What one call has on a cluster: scenes and tasks. Whatever ends the call, nothing of it stays there.

    Each worker has scenes and files of its own, and tasks go where theirs are: else Dask would send all to the worker that
    has the scene, and others would take few from a worker with many threads."""

    def __init__(self, client: Any, tell: Callable[[], bool]) -> None:
        self._client = client
        self._tell = tell
        # Another call may have the same tasks: neither gets the other's errors, or ends what the other waits for.
        self._suffix = uuid.uuid4().hex[:8]
        #: Of each scene, and of files that tasks need, by name: what was sent, and its copies on workers.
        self._sent: dict[str, Any] = {}
        self._copies: dict[tuple[str, str], Any] = {}
        self._numbers = itertools.count()
        #: Of files, by name: how many tasks that are not done need them.
        self._needed: Counter[str] = Counter()
        #: By task, the worker that it was meant for.
        self._places: dict[str, str] = {}
        self._futures: dict[str, Any] = {}
        #: How often a task was seen without a worker; how often it was sent again.
        self._looks: Counter[str] = Counter()
        self._sent_again: Counter[str] = Counter()
        self._workers: list[str] = []
        self._looked = -_LOOK
        #: When a worker was seen last, as far as nobody was told yet.
        self._met = time.monotonic()

    def __enter__(self) -> _Call:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        left = [*self._futures.values(), *self._copies.values(), *self._sent.values()]
        if left and self._client.status == "running":
            self._client.cancel(left)

    def results(self, tasks: Iterable[_Task], later: Iterable[_Task] = ()) -> Iterator[tuple[_Task, Any]]:
        """Results of tasks as they come. A task that needs others is sent once their results are dealt with. Workers without
        a task begin those that may be wanted ``later``: by the next call, which ends what it does not want of them."""
        asked = {self._key(task): task for task in sorted(tasks, key=lambda task: -task.priority)}
        self._drop([key for key in self._futures if key not in asked])
        for task in asked.values():
            self._needed.update(files.name for files in task.files)
        waiting = deque(task for key, task in asked.items() if key not in self._futures and not task.needs)
        held = [task for key, task in asked.items() if key not in self._futures and task.needs]
        done: set[str] = set()
        later = deque(later)
        if waiting:
            self._client = _checked(self._client)
        told: queue.SimpleQueue[Any] = queue.SimpleQueue()
        under_way: dict[str, _Task] = {}

        def wait_for(task: _Task, future: Any) -> None:
            under_way[future.key] = task
            future.add_done_callback(lambda future: told.put(future.key))

        for key, future in self._futures.items():
            wait_for(asked[key], future)
        while waiting or under_way:
            if not self._tell():
                raise _Stopped
            if self._look():
                # What a lost worker had needs a place elsewhere, at once. What is done has its place.
                later.clear()
                self._drop([key for key in self._places if key not in under_way])
                for key in self._stranded():
                    task = under_way.pop(key)
                    self._drop([key])
                    # Under another name: Dask would remember the one that it gives to nobody.
                    self._sent_again[task.name] += 1
                    waiting.appendleft(task)
            while waiting and (worker := self._free(_AHEAD)) is not None:
                task = waiting.popleft()
                wait_for(task, self._submit(task, worker))
            if waiting and not self._workers:
                # A cluster that grows by itself asks for workers if Dask has what none can make.
                self._scene(waiting[0].scene, None)
            while later and not waiting and (worker := self._free(1)) is not None:
                future = self._submit(later.popleft(), worker, is_later=True)
                future.add_done_callback(lambda future: told.put(future.key))
            try:
                key = told.get(timeout=_PERIOD)
            except queue.Empty:
                continue
            self._places.pop(key, None)
            if key not in under_way:
                # Its result stays where it is until it is wanted.
                continue
            # If its worker is lost by now, it is made again meanwhile. One that failed is cancelled with the others.
            result = self._futures[key].result()
            del self._futures[key]
            task = under_way.pop(key)
            yield task, result
            done.add(task.name)
            self._spare(task)
            ready = [one for one in held if done.issuperset(one.needs)]
            held = [one for one in held if not done.issuperset(one.needs)]
            # Both are in order; what was sent again stays in front of what waits.
            waiting = deque(heapq.merge(ready, waiting, key=lambda task: -task.priority))
        assert not held, "a task needs one that is not among them"

    def _drop(self, keys: Sequence[str]) -> None:
        """Ends tasks that nobody wants any more."""
        if keys:
            self._client.cancel([self._futures.pop(key) for key in keys])
        for key in keys:
            self._places.pop(key, None)

    def _look(self) -> bool:
        """Looks for workers that came or went. True if one that had a task is gone."""
        if time.monotonic() - self._looked <= _LOOK:
            return False
        workers = list(self._client.nthreads())
        _refuse_without_nephroid(self._client, set(workers) - set(self._workers))
        self._workers = workers
        self._looked = now = time.monotonic()
        if workers:
            self._met = now
        elif now - self._met > _PATIENCE:
            warnings.warn("no worker is on the Dask cluster: tasks wait until one comes", RuntimeWarning, stacklevel=4)
            self._met = math.inf
        return not set(self._places.values()) <= set(self._workers)

    def _stranded(self) -> list[str]:
        """Tasks of lost workers that Dask gives to nobody. One that has lost its worker while the others were paused is not
        looked at again: once it was seen so for some looks, it is to be sent again."""
        lost = [key for key, worker in self._places.items() if worker not in self._workers]
        if lost:
            elsewhere = {key: worker for worker, keys in self._client.processing().items() for key in keys}
            for key in lost:
                if key in elsewhere:
                    self._places[key] = elsewhere[key]
                else:
                    self._looks[key] += 1
        return [key for key in lost if self._looks[key] > _MOST_LOOKS and not self._futures[key].done()]

    def _free(self, most: int) -> str | None:
        """The worker that has least to do, if it has fewer than so many tasks."""
        # Counted once: workers times tasks are millions on a large cluster.
        busy = Counter(self._places.values())
        worker = min(self._workers, key=busy.__getitem__, default=None)
        return None if worker is None or busy[worker] >= most else worker

    def _key(self, task: _Task) -> str:
        again = self._sent_again[task.name]
        return f"{task.name}-{self._suffix}" + (f"-again-{again}" if again else "")

    def _submit(self, task: _Task, worker: str, is_later: bool = False) -> Any:
        key = self._key(task)
        self._futures[key] = self._client.submit(
            task.function,
            _nephroid.source_hash,
            self._scene(task.scene, worker),
            *task.arguments,
            *(self._files(files, worker) for files in task.files),
            key=key,
            priority=-1 if is_later else task.priority,
            **_there(worker),
        )
        self._places[key] = worker
        return self._futures[key]

    def _scene(self, scene: Scene, worker: str | None) -> Any:
        hashed = scene.content_hash
        name = f"nephroid-scene-{hashed[:32]}"
        return self._on(worker, name, _load, lambda: (_nephroid.source_hash, hashed, scene._packed()))

    def _files(self, files: _Files, worker: str) -> Any:
        return self._on(worker, files.name, _copy, lambda: (files.read(),))

    def _on(
        self, worker: str | None, name: str, function: Callable[..., Any], arguments: Callable[[], tuple[Any, ...]]
    ) -> Any:
        """A value on a worker: sent once from here, and from there to others. Without a worker, as it was sent."""
        key = f"{name}-{self._suffix}"
        # They would wait behind tasks that do not need them, without a priority.
        if name not in self._sent:
            # It may be large, and Dask warns of what is. It is bound to no worker: were that lost with all others, Dask
            # would give it to nobody.
            with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1TB"}):
                self._sent[name] = self._client.submit(function, *arguments(), key=key, priority=_FIRST)
        if worker is None:
            return self._sent[name]
        if (name, worker) not in self._copies:
            copy = f"{key}-{next(self._numbers)}"
            sent = self._sent[name]
            self._copies[name, worker] = self._client.submit(_copy, sent, key=copy, priority=_FIRST, **_there(worker))
        return self._copies[name, worker]

    def _spare(self, task: _Task) -> None:
        """Ends what no task needs any more of the files that a task which is done has had: they may be large."""
        for files in task.files:
            self._needed[files.name] -= 1
            if not self._needed[files.name] and files.name in self._sent:
                copies = [place for place in self._copies if place[0] == files.name]
                self._client.cancel([self._sent.pop(files.name), *map(self._copies.pop, copies)])


def _there(worker: str) -> dict[str, Any]:
    """Where a task is made: by a worker, or by another once that is lost."""
    return {"workers": [worker], "allow_other_workers": True}


def _checked(client: Any) -> Any:
    """The client that is meant, if it is one of use here."""
    if client is None:
        current: Callable[[], Any] = distributed.Client.current
        try:
            client = current()
        except ValueError:
            raise SettingError("there is no Dask cluster: give client=distributed.Client(...)") from None
    if not isinstance(client, distributed.Client) or client.asynchronous:
        raise TypeError(f"client is a {type(client).__name__}; a distributed.Client that is not asynchronous is needed")
    return client


def _refuse_without_nephroid(client: Any, workers: Iterable[str]) -> None:
    """Sees that workers have nephroid: tasks that a worker cannot read would wait for ever."""
    if not (asked := list(workers)):
        return
    # By value, as lambdas are. Those that are lost meanwhile do not answer.
    found = client.run(lambda: importlib.util.find_spec("nephroid") is not None, workers=asked, on_error="ignore")
    if without := [address for address, is_there in found.items() if not is_there]:
        raise Error(f"no nephroid is on {', '.join(without)}: install the same wheel everywhere")


def _share(work: int, index: int, count: int) -> int:
    """The work of a part; that of all parts is that of the round."""
    return work * index // count - work * (index - 1) // count


def _kept_name(key: str, index: int, count: int) -> str:
    """A part's file, by the hash of what a round's parts are made from."""
    return f"nephroid-part-{key[:32]}-{index}-of-{count}.shard"


def _goal(error: float | str | None) -> float | None:
    """An error as a number; None if it is none, or not one that this reads."""
    try:
        return float(error[:-1]) / 100.0 if isinstance(error, str) and error.endswith("%") else float(error or 0.0) or None
    except ValueError:
        return None


def _is_doubled(error: float | None, goal: float | None, done: int, count: int, left: int) -> bool:
    """True if a round of so much work, after ``done``, is likely to be followed by one of twice as much, which may not be
    more than is ``left``.

    Errors of photons and paths fall as one over the square root of work, or faster; those of photon maps more slowly, so
    that fewer rounds are begun early. Whatever this says, the film has the same bits."""
    if error is None or not goal or 2 * count > left:
        return False
    return _CAUTION * done * (error / goal) ** 2 - (done + count) > count


def _keep(folder: Path, files: Mapping[str, bytes]) -> None:
    """Writes the files of a run; the one that stands for all of them last."""
    for name in sorted(files, key=lambda name: (name.endswith(".json"), not name.endswith(".time.json"))):
        _write(folder / name, files[name])


def _is_added(gathering: _nephroid.Gathering, path: Path, index: int, count: int) -> bool:
    """Adds a part that is kept. One that is missing or damaged is made again."""
    try:
        gathering.add(path.read_bytes(), index, count)
    except (Error, FileNotFoundError):
        return False
    return True


def _write(path: Path, contents: bytes) -> None:
    """Writes a file whole or not at all. Its errors name it."""
    # Others may write the same file, on other machines, too.
    partial = path.with_name(f".{path.name}-{uuid.uuid4().hex}.partial")
    try:
        with partial.open("wb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        raise OSError(error.errno, error.strerror, os.fspath(path)) from error
    finally:
        partial.unlink(missing_ok=True)


# Below is what workers do.


def _check(source: str) -> None:
    """Refuses to work for another nephroid: its numbers may differ in their last bits."""
    if source != _nephroid.source_hash:
        name = distributed.get_worker().address
        raise Error(
            f"worker {name} has nephroid {_nephroid.__version__} of source {_nephroid.source_hash[:8]}, and the client one of "
            f"source {source[:8]}: install the same wheel everywhere, for one kind of processor"
        )


def _load(source: str, content_hash: str, packed: tuple[Any, ...]) -> Scene:
    _check(source)
    scene = _nephroid.load(*packed)
    if scene.content_hash != content_hash:
        raise Error(f"the files of {scene.path} have changed since the scene was read: read it again")
    return scene


def _copy(value: Any) -> Any:
    return value


_CLOSING = (Status.closing, Status.closed, Status.failed)

#: Of each worker of this process, what its task of the moment holds: there is one at a time, on all of its threads.
#:
#: Dask's resources would do the same, but a worker gets them after it has joined. Tasks that waited for a worker when it
#: came are not looked at again, and wait for ever.
_held: weakref.WeakKeyDictionary[Any, threading.Lock] = weakref.WeakKeyDictionary()


@contextlib.contextmanager
def _unsampled(worker: Any) -> Iterator[None]:
    """Stops the worker's profiler meanwhile: a hundred times a second it looks where Python is, which is always here, and
    takes a tenth of a core or more."""

    def set_sampling(is_on: bool) -> None:
        # Its clock belongs to the worker's loop. A worker that closes has none.
        if sampler := worker.periodic_callbacks.get("profile"):
            if is_on and worker.status not in _CLOSING:
                sampler.start()
            else:
                sampler.stop()

    worker.loop.add_callback(set_sampling, False)
    try:
        yield
    finally:
        worker.loop.add_callback(set_sampling, True)


def _work(function: Callable[[Any, Callable[[object], bool]], Any], given: Any) -> Any:
    """Does a task on all threads of the worker until it has a result, which is neither None nor False. It ends without
    one if nobody waits for it any more; or if the worker closes: then another takes it."""
    worker = distributed.get_worker()
    key = worker.get_current_task()

    def goes_on(_: object = None) -> bool:
        task = worker.state.tasks.get(key)
        return task is not None and task.state != "cancelled" and worker.status not in _CLOSING

    # In one step, whatever thread comes first.
    held = _held.setdefault(worker, threading.Lock())
    while not held.acquire(timeout=_PERIOD):
        if not goes_on():
            raise distributed.Reschedule
    try:
        with _unsampled(worker):
            result = function({**given, "threads": worker.state.nthreads}, goes_on)
    finally:
        held.release()
    if result is None or result is False:
        raise distributed.Reschedule
    return result


def _part(source: str, scene: Scene, step: Step, index: int, count: int) -> bytes:
    """The sums of a part of a step of a run."""
    _check(source)
    part: bytes = _work(lambda given, told: step.part(scene, index, count, given["threads"], told), {})
    return part


def _unit(source: str, scene: Scene, key: str, asked: Any, *needed: Mapping[str, bytes]) -> dict[str, bytes]:
    """The files of a unit of a study, made from those of others that it needs."""
    _check(source)
    local = distributed.get_worker().local_directory
    with _folder(local, *needed) as (folder, made):
        _work(lambda given, told: _nephroid.unit(scene, key, folder, given, told), asked)
        return made()


@contextlib.contextmanager
def _folder(local: str | None, *needed: Mapping[str, bytes]) -> Iterator[tuple[str, Callable[[], dict[str, bytes]]]]:
    """A folder for a study with some files, and what is there that they are not."""
    with tempfile.TemporaryDirectory(prefix="nephroid-", dir=local) as folder:
        runs = Path(folder, "runs")
        runs.mkdir()
        given = {name: contents for files in needed for name, contents in files.items()}
        for name, contents in given.items():
            (runs / name).write_bytes(contents)

        def new() -> dict[str, bytes]:
            found = {path.name: path.read_bytes() for path in runs.iterdir()}
            return {name: contents for name, contents in found.items() if given.get(name) != contents}

        yield folder, new
