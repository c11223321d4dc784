"""Runs and studies on workers of Dask: real processes on this machine."""

from __future__ import annotations

import contextlib
import errno
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import nephroid as ne
from conftest import ROOT, SCENES, SMALL_VIEW, assert_same

distributed = pytest.importorskip("distributed", reason='no distributed: pip install "distributed>=2024.8"')

import dask.config  # noqa: E402
from dask.utils import parse_timedelta  # noqa: E402
from distributed.diagnostics.plugin import WorkerPlugin  # noqa: E402

import nephroid.dask  # noqa: E402

GLASS = SCENES / "glass-ball.xml"
#: What threads do is read where Linux tells it.
on_linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="there is no /proc")
#: More photons than any test waits for.
ENDLESS = 1 << 36


@contextlib.contextmanager
def cluster_of(workers, threads=1):
    """A client of so many workers, each a process with so many threads."""
    with (
        distributed.LocalCluster(n_workers=workers, threads_per_worker=threads, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.fixture(scope="module")
def client():
    """Two workers that tests share."""
    with cluster_of(2) as client:
        yield client


@pytest.fixture
def mortal():
    """Two workers of a test's own, which may be killed: Dask starts others, but not at once, and not always."""
    with cluster_of(2) as client:
        yield client


@pytest.fixture
def interruptible():
    """Python's own handler: a shell may have started this process with the signal ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def _is_working(dask_worker):
    """True if a task of nephroid has a thread of its own, whatever Dask thinks of it."""
    names = pathlib.Path("/proc/self/task").glob("*/comm")
    return any(name.read_text().strip() == "nephroid" for name in names)


def busy_workers(client):
    """Those that have tasks."""
    return [worker for worker, tasks in client.processing().items() if tasks]


def kill(client, worker):
    """Kills a worker, and tells the number of its process."""
    pid = client.run(os.getpid, workers=[worker])[worker]
    os.kill(pid, signal.SIGKILL)
    return pid


def wait_for(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.mark.parametrize(
    ("scene", "settings"),
    [
        ("glass-ball.xml", {"photons": 300_001, "seed": 7, "tasks": 5}),
        # Many rounds, the later ones in several tasks.
        ("glass-ball.xml", {"error": 0.02, "tasks": 3}),
        ("cornell-glass.xml", {"error": 0.1, "replicates": 5, "tasks": 2}),
        # Light that is never found ends without an error.
        ("prism.xml", {"error": "20%", "photons": 1 << 19, "max_depth": 1}),
        ("prism.xml", {"photons": 1 << 17, "tasks": 64}),
    ],
)
def test_films_have_the_bits_of_a_run_in_one_piece(client, scene, settings):
    scene = ne.load_file(SCENES / scene, size=32)
    whole = {key: value for key, value in settings.items() if key != "tasks"}
    assert_same(ne.dask.render(scene, client=client, **settings), ne.render(scene, method="photons", **whole))


@pytest.mark.parametrize(
    "settings",
    [
        {"method": "path", "spp": 16, "tasks": 3},
        {"method": "path", "error": "20%", "tasks": 2},
        # The limit on samples comes first, after a round that is cut short.
        {"method": "path", "error": "0.01%", "spp": 37, "replicates": 3},
        {"method": "photon-map", "sensor": "eye", "seen": "anyhow", "error": "30%", "map_photons": 4096, "tasks": 4},
        {"method": "photon-map", "sensor": "eye", "photons": 5 * 2 * 4096, "map_photons": 4096, "replicates": 2},
        {"method": "beams", "sensor": "eye", "filter": "box", "error": "0.3%", "tasks": 3},
        # In as many tasks as its forecast asks for; and with an error of one layer.
        {"method": "beams", "sensor": "eye", "filter": "box", "error": "0.03%"},
        {"method": "beams", "sensor": "eye", "filter": "box", "error": "3%", "layer_error": "LTTD=0.2%", "tasks": 2},
    ],
)
def test_other_methods_have_the_bits_of_a_run_in_one_piece(client, settings):
    scene = ne.load_string(SMALL_VIEW)
    whole = {key: value for key, value in settings.items() if key != "tasks"}
    told = []
    film = ne.dask.render(scene, client=client, progress=told.append, **settings)
    assert_same(film, ne.render(scene, **whole))
    unit = "rays" if settings["method"] == "beams" else "paths"
    assert told[-1].unit == unit and told[-1].done == told[-1].expected > 0


def test_scenes_come_with_their_files(client, tmp_path, monkeypatch):
    for name in ("water.xml", "water.ply"):
        shutil.copy(SCENES / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    # Workers have another working folder.
    scene = ne.load_file("water.xml", size=16)
    film = ne.dask.render(scene, photons=4096, client=client)
    assert_same(film, ne.render(scene, method="photons", photons=4096))
    with open("water.xml", "a") as file:
        file.write("<!-- another scene -->")
    with pytest.raises(ne.Error, match="have changed since"):
        ne.dask.render(scene, photons=2048, client=client)


def test_a_killed_worker_loses_nothing(mortal):
    client = mortal
    scene = ne.load_file(GLASS, size=32)
    settings = {"photons": 1 << 23, "seed": 1}
    killed = []

    def progress(now):
        # Both workers have more to do, and one task is done.
        if not killed and now.done > 0:
            busy = busy_workers(client)
            if busy:
                killed.append(kill(client, busy[0]))

    film = ne.dask.render(scene, client=client, tasks=8, progress=progress, **settings)
    assert killed and killed[0] not in client.run(os.getpid).values()
    assert_same(film, ne.render(scene, method="photons", **settings))


def test_all_workers_may_be_lost_at_once(mortal):
    """Tasks wait for those that come."""
    client = mortal
    scene = ne.load_file(GLASS, size=32)
    settings = {"photons": 1 << 23, "seed": 2}
    killed = []

    def progress(now):
        if not killed and now.done > 0:
            killed.extend(client.run(os.getpid).values())
            for pid in killed:
                os.kill(pid, signal.SIGKILL)

    film = ne.dask.render(scene, client=client, tasks=8, progress=progress, **settings)
    assert len(killed) == 2 and not set(killed) & set(client.run(os.getpid).values())
    assert_same(film, ne.render(scene, method="photons", **settings))


def test_a_task_that_lost_its_worker_while_others_were_paused_is_made(mortal):
    """Dask gives it to nobody, also once they go on."""
    client = mortal
    scene = ne.load_file(GLASS, size=32)
    settings = {"photons": 1 << 22, "seed": 3}
    killed = []

    def progress(now):
        busy = busy_workers(client)
        if not killed and len(busy) == 2:
            client.run(_set_status, distributed.core.Status.paused, workers=busy[1:])
            killed.append(kill(client, busy[0]))
            time.sleep(2.0)
            client.run(_set_status, distributed.core.Status.running, workers=busy[1:])

    film = ne.dask.render(scene, client=client, tasks=4, progress=progress, **settings)
    assert killed
    assert_same(film, ne.render(scene, method="photons", **settings))


def _set_status(status, dask_worker):
    dask_worker.status = status


def test_lost_workers_do_not_count_against_tasks_that_never_ran(mortal):
    """Each worker has one task that waits, and all others wait here."""
    client = mortal
    scene = ne.load_file(GLASS, size=32)
    client.run_on_scheduler(_allow_failures, 1)
    killed = []

    def progress(now):
        # Those of the first lost worker are done by the second time.
        if len(killed) < 2 and now.done >= (1 << 19) * (1, 9)[len(killed)]:
            busy = busy_workers(client)
            if busy:
                killed.append(kill(client, busy[0]))

    film = ne.dask.render(scene, photons=16 << 19, tasks=16, client=client, progress=progress)
    assert len(killed) == 2 and film.complete


def _allow_failures(number, dask_scheduler):
    dask_scheduler.allowed_failures = number


def test_a_run_goes_on_from_what_a_folder_keeps(client, tmp_path):
    scene = ne.load_file(GLASS, size=32)
    settings = {"error": 0.02, "tasks": 4, "folder": tmp_path, "client": client}
    heard = []

    def stop(now):
        heard.append(now.done)
        return len(set(heard)) < 6

    assert ne.dask.render(scene, progress=stop, **settings) is None
    kept = sorted(tmp_path.iterdir())
    assert len(kept) >= 5
    # One digit of the header's sums, which fit as well as the right one.
    damaged = bytearray(kept[0].read_bytes())
    at = re.search(rb'"ledger":\["', damaged).end() + 1
    damaged[at] ^= 1
    assert chr(damaged[at]).isdigit()
    kept[0].write_bytes(damaged)
    # A part under the name of another is none.
    first = [path for path in kept if path.stem.endswith("-1-of-4")][-1]
    second = first.with_name(first.name.replace("-1-of-4", "-2-of-4"))
    second.write_bytes(first.read_bytes())
    kept = sorted({*kept, second})
    before = {path: path.stat().st_mtime_ns for path in kept}
    seen = []
    film = ne.dask.render(scene, progress=lambda now: seen.append(now), **settings)
    assert_same(film, ne.render(scene, method="photons", error=0.02))
    # Only the wrong ones were made again.
    again = {path for path in kept if path.stat().st_mtime_ns != before[path]}
    assert again == {kept[0], second}
    # Until the first round is known, nothing is expected.
    assert next(now.done for now in seen if now.expected) > 0 and seen[-1].done == seen[-1].expected
    assert [now.done for now in seen] == sorted(now.done for now in seen)
    assert seen[-1].unit == "photons" and 0 < seen[-1].relative_error <= 0.02
    # Another run takes none of them.
    other = ne.dask.render(scene, seed=1, **settings)
    assert_same(other, ne.render(scene, method="photons", error=0.02, seed=1))


@pytest.fixture
def begun_early(monkeypatch):
    """The tasks that are begun before their round is wanted, and those of them that are ended."""
    early, dropped = [], []
    submit, drop = ne.dask._Call._submit, ne.dask._Call._drop

    def submitted(call, task, worker, is_later=False):
        if is_later:
            early.append(task.name)
        return submit(call, task, worker, is_later)

    def drops(call, keys):
        dropped.extend(keys)
        drop(call, keys)

    monkeypatch.setattr(ne.dask._Call, "_submit", submitted)
    monkeypatch.setattr(ne.dask._Call, "_drop", drops)
    return early, dropped


def test_rounds_that_overlap_have_the_bits_of_rounds_that_do_not(client, tmp_path, begun_early):
    scene = ne.load_file(GLASS, size=32)
    # One task a round: the other worker has nothing to do.
    run = {"error": 0.004, "tasks": 1, "client": client}
    film = ne.dask.render(scene, folder=tmp_path / "overlap", **run)
    early, dropped = begun_early
    # The first rounds tell no forecast, and the last is not twice the one before.
    assert 2 <= len(early) < len(list((tmp_path / "overlap").iterdir()))
    assert len(dropped) <= 1
    assert_same(film, ne.render(scene, method="photons", error=0.004))
    early.clear()
    assert_same(ne.dask.render(scene, folder=tmp_path / "apart", overlap=False, **run), film)
    assert not early
    names = [sorted(path.name for path in (tmp_path / of).iterdir()) for of in ("overlap", "apart")]
    assert names[0] == names[1]
    for name in names[0]:
        assert (tmp_path / "overlap" / name).read_bytes() == (tmp_path / "apart" / name).read_bytes()


@on_linux
def test_a_round_that_was_begun_in_vain_leaves_nothing(client, monkeypatch, begun_early):
    scene = ne.load_file(GLASS, size=32)
    monkeypatch.setattr(ne.dask, "_is_doubled", lambda *_: True)
    for error, tasks in ((0.02, 1), (0.03, 3), ("2%", 2)):
        film = ne.dask.render(scene, error=error, tasks=tasks, client=client)
        assert_same(film, ne.render(scene, method="photons", error=error))
    # Also one that is no round of the run, as its last is smaller.
    assert begun_early[0] and begun_early[1]
    wait_for(lambda: not client.run_on_scheduler(_nephroid_keys), 5.0)
    wait_for(lambda: not any(client.run(_is_working).values()), 3.0)


@pytest.mark.parametrize("is_early", [False, True])
def test_a_worker_that_is_killed_while_rounds_overlap_loses_nothing(mortal, monkeypatch, begun_early, is_early):
    client = mortal
    scene = ne.load_file(GLASS, size=32)
    settings = {"error": 1e-9, "photons": 1 << 22, "seed": 5}
    monkeypatch.setattr(ne.dask, "_is_doubled", lambda error, goal, done, round, left: 2 * round <= left)
    killed = []

    def progress(now):
        if killed or now.done < 1 << 18 or not begun_early[0]:
            return
        pids = client.run(os.getpid)
        name = begun_early[0][-1]
        for worker, keys in client.processing().items():
            has_early = any(str(key).startswith(name) for key in keys)
            if keys and has_early == is_early:
                killed.append(pids[worker])
                os.kill(killed[0], signal.SIGKILL)
                return

    film = ne.dask.render(scene, client=client, tasks=1, progress=progress, **settings)
    assert killed
    assert_same(film, ne.render(scene, method="photons", **settings))
    wait_for(lambda: not client.run_on_scheduler(_nephroid_keys), 5.0)


def test_a_round_is_begun_early_if_the_error_so_far_says_so():
    goal, is_doubled = ne.dask._goal, ne.dask._is_doubled
    assert [goal(one) for one in (0.01, "1%", "0.01", None, "little")] == [0.01, 0.01, 0.01, None, None]
    # 100 photons with 4 times the error, and 100 more: 1.2 * 16 * 100 in all are needed.
    assert is_doubled(0.04, 0.01, 100, 100, 1000)
    # With 2.5 times the square, 300 are needed: then 100 are missing after this round, which is no more than it has.
    assert not is_doubled(0.01 * 2.49**0.5, 0.01, 100, 100, 1000)
    assert is_doubled(0.01 * 2.51**0.5, 0.01, 100, 100, 1000)
    assert not is_doubled(None, 0.01, 100, 100, 1000)
    assert not is_doubled(0.04, None, 100, 100, 1000)
    assert is_doubled(0.04, 0.01, 100, 100, 200) and not is_doubled(0.04, 0.01, 100, 100, 199)


@on_linux
def test_a_disk_that_is_full_ends_the_run_and_leaves_no_half_file(client, tmp_path):
    resource = pytest.importorskip("resource")
    scene = ne.load_file(GLASS, size=32)
    settings = {"photons": 1 << 22, "tasks": 4, "folder": tmp_path, "client": client}
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    # Of this process alone: workers were started before.
    resource.setrlimit(resource.RLIMIT_FSIZE, (8192, limit[1]))
    try:
        with pytest.raises(OSError, match="nephroid-part") as caught:
            ne.dask.render(scene, **settings)
        assert caught.value.errno == errno.EFBIG and tmp_path == pathlib.Path(caught.value.filename).parent
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    assert list(tmp_path.iterdir()) == []
    wait_for(lambda: not any(client.run(_is_working).values()), 3.0)
    assert_same(ne.dask.render(scene, **settings), ne.render(scene, method="photons", photons=1 << 22))


@on_linux
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("way", ["ctrl-c", "callback", "exception"])
def test_whoever_stops_a_run_stops_its_tasks(client, way):
    scene = ne.load_file(GLASS, size=16)

    class Mine(Exception):
        pass

    begun = []
    end = time.monotonic() + 60.0

    def progress(_):
        assert time.monotonic() < end
        if not begun and all(client.run(_is_working).values()):
            begun.append(True)
            if way == "exception":
                raise Mine
            if way == "ctrl-c":
                threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        return not (begun and way == "callback")

    run = {"photons": ENDLESS, "client": client, "progress": progress}
    if way == "callback":
        assert ne.dask.render(scene, **run) is None
    else:
        with pytest.raises(KeyboardInterrupt if way == "ctrl-c" else Mine) as caught:
            ne.dask.render(scene, **run)
    wait_for(lambda: not any(client.run(_is_working).values()), 3.0)
    # The same tasks can be asked for again, though their traceback is still there.
    begun.clear()
    way = "callback"
    assert ne.dask.render(scene, **run) is None
    wait_for(lambda: not any(client.run(_is_working).values()), 3.0)


def test_a_run_can_be_stopped_while_the_client_works(client):
    """Beams leave most of this light to photons, which the client traces."""
    scene = ne.load_file(SCENES / "turntable-bumpy.xml", size=32)
    began = []

    def progress(now):
        # All that workers do is done.
        began.extend([time.monotonic()] if not began and now.done == now.expected > 0 else [])
        return not began or time.monotonic() < began[0] + 0.3

    assert ne.dask.render(scene, method="beams", error="0.5%", client=client, progress=progress) is None
    assert began and time.monotonic() < began[0] + 5.0


def test_a_task_that_failed_can_be_asked_for_again(client):
    scene = ne.load_file(GLASS, size=16)
    settings = {"photons": 1 << 16, "tasks": 4, "client": client}
    client.run(_set_source, "0" * 64)
    try:
        with pytest.raises(ne.Error, match="install the same wheel everywhere") as caught:
            ne.dask.render(scene, **settings)
    finally:
        client.run(_set_source, ne._nephroid.source_hash)
    # The exception holds frames, and these hold what was asked for.
    assert caught.value.__traceback__ is not None
    assert_same(ne.dask.render(scene, **settings), ne.render(scene, method="photons", photons=1 << 16))
    wait_for(lambda: not client.run_on_scheduler(_nephroid_keys), 5.0)


def _set_source(source):
    ne._nephroid.source_hash = source


def _nephroid_keys(dask_scheduler):
    return [key for key in dask_scheduler.tasks if str(key).startswith("nephroid-")]


def test_a_call_that_ends_does_not_end_another_of_the_same(client):
    scene = ne.load_file(GLASS, size=16)
    run = {"photons": 1 << 20, "tasks": 8, "client": client}
    is_under_way, is_over = threading.Event(), threading.Event()
    films = []

    def wait(now):
        if now.done:
            is_under_way.set()
            assert is_over.wait(30.0)

    first = threading.Thread(target=lambda: films.append(ne.dask.render(scene, progress=wait, **run)))
    first.start()
    assert is_under_way.wait(30.0)
    heard = []
    assert ne.dask.render(scene, progress=lambda now: heard.append(now) or len(heard) < 2, **run) is None
    is_over.set()
    first.join(60.0)
    assert_same(films[0], ne.render(scene, method="photons", photons=1 << 20))


@on_linux
def test_a_client_that_dies_leaves_no_task_behind(client):
    code = (
        "import sys, distributed, nephroid as ne, nephroid.dask\n"
        f"scene = ne.load_file({str(GLASS)!r}, size=16)\n"
        "with distributed.Client(sys.argv[1]) as client:\n"
        f"    ne.dask.render(scene, photons={ENDLESS}, seed=3, client=client)\n"
    )
    other = subprocess.Popen([sys.executable, "-c", code, client.scheduler.address])
    try:
        wait_for(lambda: all(client.run(_is_working).values()))
    finally:
        other.kill()
        other.wait()
    wait_for(lambda: not any(client.run(_is_working).values()), 10.0)


@on_linux
def test_a_task_has_all_threads_of_a_worker_to_itself():
    scene = ne.load_file(GLASS, size=16)
    seen = []
    with cluster_of(1, threads=3) as client:
        # A worker that comes later has as much room.
        client.cluster.scale(2)
        client.wait_for_workers(2)

        end = time.monotonic() + 60.0

        def progress(_):
            now = client.run(lambda dask_worker: (len(dask_worker.state.executing), _threads()))
            seen.extend(now.values())
            # Both work, though one of them has threads for both tasks.
            are_both = all(tasks == 2 and threads == 4 for tasks, threads in now.values())
            return not are_both and time.monotonic() < end

        # Each has one to make, and one that waits.
        assert ne.dask.render(scene, photons=ENDLESS, tasks=4, client=client, progress=progress) is None
        assert time.monotonic() < end, seen
        # One that waits, and three that work.
        assert max(threads for _, threads in seen) == 4


def test_dasks_profiler_rests_while_a_task_works(client):
    """It would take a tenth of a core."""
    scene = ne.load_file(GLASS, size=16)
    seen = []
    end = time.monotonic() + 60.0

    def progress(_):
        if all(client.run(_is_working).values()):
            seen.append(client.run(_is_sampled))
        return len(seen) < 3 and time.monotonic() < end

    wait_for(lambda: all(client.run(_is_sampled).values()))
    assert ne.dask.render(scene, photons=ENDLESS, tasks=2, client=client, progress=progress) is None
    assert not any(seen[-1].values())
    wait_for(lambda: all(client.run(_is_sampled).values()))


def _is_sampled(dask_worker):
    return dask_worker.periodic_callbacks["profile"].is_running()


def _threads():
    names = pathlib.Path("/proc/self/task").glob("*/comm")
    return sum(name.read_text().strip() == "nephroid" for name in names)


def test_a_worker_without_nephroid_is_named(client):
    scene = ne.load_file(GLASS, size=16)
    client.run(_hide_nephroid, True)
    try:
        with pytest.raises(ne.Error, match=r"no nephroid is on tcp://.*, tcp://.*: install the same wheel"):
            ne.dask.render(scene, photons=64, client=client)
    finally:
        client.run(_hide_nephroid, False)
    assert ne.dask.render(scene, photons=64, client=client).complete


def test_a_worker_without_nephroid_is_named_if_it_comes_later():
    scene = ne.load_file(GLASS, size=16)

    class HidesNephroid(WorkerPlugin):
        def setup(self, worker):
            if worker.name != 0:
                sys.modules["nephroid"] = None

    with cluster_of(1) as client:
        client.register_plugin(HidesNephroid())
        end = time.monotonic() + 60.0

        def progress(_):
            client.cluster.scale(2)
            return time.monotonic() < end

        with pytest.raises(ne.Error, match=r"no nephroid is on tcp://[^,]*: install the same wheel"):
            ne.dask.render(scene, photons=ENDLESS, client=client, progress=progress)


def test_whoever_has_no_worker_is_told(monkeypatch):
    scene = ne.load_file(GLASS, size=16)
    monkeypatch.setattr(ne.dask, "_PATIENCE", 0.2)
    with cluster_of(0) as client, pytest.warns(RuntimeWarning, match="no worker") as warned:
        end = time.monotonic() + 60.0

        def progress(_):
            if warned:
                client.cluster.scale(1)
            return time.monotonic() < end

        assert ne.dask.render(scene, photons=64, client=client, progress=progress).complete
    assert len([one for one in warned if "no worker" in str(one.message)]) == 1


def _hide_nephroid(is_hidden):
    sys.modules["nephroid"] = None if is_hidden else ne


def _render(method, **settings):
    return ne.render(ne.load_file(GLASS, size=8), method=method, **settings)


def test_four_workers_have_the_bits_of_four_threads():
    scene = ne.load_file(GLASS, size=16)
    with cluster_of(4) as client:
        film = ne.dask.render(scene, photons=1 << 18, tasks=7, client=client)
    assert_same(film, ne.render(scene, method="photons", photons=1 << 18, threads=4))


def test_a_cluster_that_grows_if_it_is_asked_grows_from_nothing():
    scene = ne.load_file(GLASS, size=16)
    with (
        distributed.LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        cluster.adapt(minimum=0, maximum=2, interval="100ms", wait_count=2)
        # Once more after all workers have been sent away, since nothing was to be done.
        for _ in range(2):
            end = time.monotonic() + 60
            film = ne.dask.render(scene, photons=1 << 16, tasks=3, client=client, progress=lambda _: time.monotonic() < end)
            assert_same(film, ne.render(scene, method="photons", photons=1 << 16))
            wait_for(lambda: not client.nthreads())


def test_errors_are_typed(client, monkeypatch):
    scene = ne.load_file(GLASS, size=16)
    with pytest.raises(ne.LoadError) as caught:
        client.submit(ne.load_string, "<scene version='3.0.0'>\n <shape type='sphare'/></scene>").result()
    assert (caught.value.line, caught.value.file) == (2, "<string>") and "sphere" in str(caught.value)
    with pytest.raises(ne.SettingError, match="photonz"):
        client.submit(_render, "photons", photonz=1).result()
    with pytest.raises(ne.RefusedError, match="nowhere"):
        client.submit(_render, "photons", sensor="nowhere").result()
    with pytest.raises(ne.RefusedError, match="in one piece"):
        ne.dask.render(scene, method="closed-form", client=client)
    with pytest.raises(ne.RefusedError, match="neither --time nor --rays"):
        ne.dask.render(scene, method="beams", rays=1000, client=client)
    with pytest.raises(ne.RefusedError, match="no shard knows its part"):
        ne.shard(scene, 1, 2, method="beams")
    with pytest.raises(ne.RefusedError, match="not time"):
        ne.dask.render(scene, time=1, client=client)
    with pytest.raises(ne.SettingError, match="photons"):
        ne.dask.render(scene, photonz=1, client=client)
    with pytest.raises(ne.SettingError, match="whole numbers > 0"):
        ne.dask.render(scene, tasks=0, client=client)
    with pytest.raises(TypeError, match="distributed.Client"):
        ne.dask.render(scene, photons=64, client="tcp://head:8786")
    monkeypatch.setattr(ne._nephroid, "source_hash", "0" * 64)
    with pytest.raises(ne.Error, match="install the same wheel everywhere"):
        ne.dask.render(scene, photons=64, client=client)


STUDY = {
    "truth": {"method": "beams", "error": "3%"},
    "method": [
        {"method": "photons", "photons": [1024, 4096, 16384]},
        {"method": "caustic-map", "photons": 64, "map": 64},
    ],
}


def test_a_study_has_the_report_of_a_study_in_one_piece(client, tmp_path, monkeypatch):
    scene = ne.load_file(GLASS, size=16)
    mine = ne.render(scene, photons=512).value
    study = {"scene": scene, **STUDY}
    asked = {"candidates": {"mine": mine}, "max_error": {"mine": 0.9}}
    whole = ne.validate(study, tmp_path / "whole", **asked)
    seen, kept = [], []
    keep = ne.dask._keep

    def keeps(folder, files):
        kept.extend(files)
        keep(folder, files)

    monkeypatch.setattr(ne.dask, "_keep", keeps)
    stopped = ne.dask.validate(study, tmp_path / "parts", client=client, progress=lambda now: now.done < 2, **asked)
    assert stopped is None
    parts = ne.dask.validate(study, tmp_path / "parts", client=client, progress=seen.append, **asked)
    assert (tmp_path / "parts/report.json").read_bytes() == (tmp_path / "whole/report.json").read_bytes()
    assert parts.report["sensors"][0]["stages"] and len(parts.rows) == len(whole.rows) == 5
    # The truth and four runs; of the attribution's runs the first, and the others four by four.
    others = whole.report["sensors"][0]["stages"][0]["runs"] - 1
    assert others > 8
    assert seen[0].done >= 2 and seen[-1].done == seen[-1].expected == 6 + math.ceil(others / 4) and seen[-1].unit == "runs"
    # Nothing is made twice, as a task would do that lacks what it needs.
    assert len(set(kept)) == len(kept) and sum("-stages-" in name for name in kept) == 1 + math.ceil(others / 4)
    # All is there: no worker is asked.
    made = {path.name for path in (tmp_path / "parts/runs").iterdir()}
    assert made == {path.name for path in (tmp_path / "whole/runs").iterdir()}
    again = ne.dask.validate(study, tmp_path / "parts", client="nobody", **asked)
    assert again.report == whole.report


def _sleeps(source, scene, seconds, *files):
    time.sleep(seconds)
    return [sum(map(len, one.values())) for one in files]


@pytest.mark.filterwarnings("error:Sending large graph")
def test_files_do_not_wait_behind_tasks_that_do_not_need_them_and_do_not_stay(tmp_path):
    """With 20 workers and more, Dask may give a task to any of them."""
    scene = ne.load_file(GLASS, size=8)
    path = tmp_path / "film"
    path.write_bytes(bytes(20 << 20))
    files = ne.dask._Files("nephroid-files-film", (path, tmp_path / "missing"))
    truth = ne.dask._Task("truth", _sleeps, scene, (0.5,), 1001)
    first = ne.dask._Task("first", _sleeps, scene, (0.1,), 1000, (files,), ("truth",))
    runs = [ne.dask._Task(f"run-{i}", _sleeps, scene, (0.2,), i) for i in range(300)]
    order, left = [], None
    with (
        distributed.LocalCluster(n_workers=24, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
        ne.dask._Call(client, lambda: True) as call,
    ):
        for task, result in call.results([first, truth, *runs]):
            order.append(task.name)
            if task.name == "first":
                assert result == [20 << 20]
            if order[-2:-1] == ["first"]:
                left = [name for name in [*call._sent, *(name for name, _ in call._copies)] if name == files.name]
    assert len(order) == 302 and left == []
    # A run is under way on each worker, and one waits there.
    assert order.index("truth") < order.index("first") < 302 - 2 * 24


def test_a_killed_worker_loses_no_run_of_a_study(mortal, tmp_path):
    client = mortal
    scene = ne.load_file(GLASS, size=16)
    # The truth takes seconds, the other two none.
    runs = [{"method": "photons", "photons": [1024, 4096]}]
    study = {"scene": scene, "truth": {"method": "photons", "photons": 1 << 23}, "method": runs}
    killed = []

    def progress(now):
        if not killed and now.done == 2:
            busy = busy_workers(client)
            assert len(busy) == 1 and client.run(_is_working, workers=busy)[busy[0]]
            killed.append(kill(client, busy[0]))

    ne.dask.validate(study, tmp_path / "parts", client=client, progress=progress)
    assert killed
    ne.validate(study, tmp_path / "whole")
    assert (tmp_path / "parts/report.json").read_bytes() == (tmp_path / "whole/report.json").read_bytes()


def test_a_study_may_have_the_same_pose_and_the_same_run_twice(client, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(GLASS, tmp_path)
    run = '[[method]]\nmethod = "photons"\nphotons = [1024, 1024]\n'
    (tmp_path / "s.toml").write_text(
        'scene = "glass-ball.xml"\nposes = [{ size = [8, 8] }]\n[truth]\nmethod = "beams"\nerror = "5%"\n' + run
    )
    ne.validate("s.toml", "whole")
    seen = []
    ne.dask.validate("s.toml", "parts", client=client, progress=seen.append)
    assert (tmp_path / "parts/poses.json").read_bytes() == (tmp_path / "whole/poses.json").read_bytes()
    assert seen[-1].done == seen[-1].expected == 6
    for pose in ("pose-001", "pose-002"):
        made, whole = ({path.name for path in (tmp_path / of / pose / "runs").iterdir()} for of in ("parts", "whole"))
        assert made == whole


def test_a_study_of_a_file_with_poses(client, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(GLASS, tmp_path)
    (tmp_path / "s.toml").write_text(
        'scene = "glass-ball.xml"\nposes = [{ size = [8, 12] }]\n[truth]\nmethod = "beams"\nerror = "5%"\n'
        '[[method]]\nmethod = "photons"\nphotons = 1024\n'
    )
    ne.validate("s.toml", "whole")
    parts = ne.dask.validate("s.toml", "parts", client=client)
    assert (tmp_path / "parts/poses.json").read_bytes() == (tmp_path / "whole/poses.json").read_bytes()
    assert len(parts.poses) == 2 and len(parts.rows) == 2
    with pytest.raises(ne.SettingError, match="one machine"):
        ne.dask.validate({"scene": GLASS, "time": "1m"}, "timed", client=client)
    with pytest.raises(ne.LoadError, match="s.toml"):
        (tmp_path / "s.toml").write_text("scene = 1 2")
        ne.dask.validate("s.toml", "parts", client=client)
    (tmp_path / "s.toml").write_bytes(b"scene = '\xff'")
    for study in ("s.toml", "nowhere.toml"):
        said = []
        for validate in (ne.validate, ne.dask.validate):
            with pytest.raises(ne.LoadError) as caught:
                validate(study, "parts")
            said.append(str(caught.value))
        assert said[0] == said[1]


PAGE = (ROOT / "docs/clusters.md").read_text()


@pytest.mark.parametrize(("number", "made"), enumerate(["out/ball.exr", "out/ball.report/index.html", "local.exr"]))
def test_the_examples_of_the_page(tmp_path, number, made):
    """As a reader would run them; the fourth is of Slurm, which tests/slurm/run tries."""
    block = re.findall(r"```python\n(.*?)```", PAGE, re.S)[number]
    (tmp_path / "example.py").write_text(block)
    (tmp_path / "scenes").symlink_to(SCENES)
    done = subprocess.run([sys.executable, "example.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / made).exists()


def test_the_clocks_of_the_page_are_dasks():
    """Dask takes any key: one that it does not know changes nothing."""
    clocks = re.findall(r'"(distributed\.[a-z.-]+)": "(\w+)",\s+# (?:by default )?(\w+) ms', PAGE)
    assert len(clocks) == 3
    for key, ours, milliseconds in clocks:
        theirs = parse_timedelta(dask.config.get(key))
        assert theirs == pytest.approx(int(milliseconds) / 1000.0)
        assert parse_timedelta(ours) > theirs


def test_nephroid_alone_does_not_import_dask():
    code = "import sys, nephroid; print({'dask', 'distributed'} & {name.split('.')[0] for name in sys.modules})"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "set()"
    code = "import sys; sys.modules['distributed'] = None; import nephroid.dask"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert said.returncode == 1 and 'pip install "distributed>=2024.8"' in said.stderr, said.stderr
