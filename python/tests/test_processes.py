"""Signals, threads, processes and callbacks."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import nephroid as ne
from conftest import SCENES, SMALL_VIEW, assert_same

GLASS = SCENES / "glass-ball.xml"
#: More photons than any test waits for.
ENDLESS = 1 << 36


@pytest.fixture
def interruptible():
    """Python's own handler: a shell may have started this process with the signal ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize(
    ("method", "settings"),
    [("photons", {"photons": ENDLESS}), ("beams", {"error": 1e-6}), ("photon-map", {"photons": ENDLESS})],
)
def test_ctrl_c_is_a_keyboard_interrupt_within_a_second(method, settings):
    name = "cornell-glass.xml" if method == "photon-map" else "glass-ball.xml"
    scene = ne.load_file(SCENES / name, size=64)
    before = signal.getsignal(signal.SIGINT)
    sent = []

    def interrupt():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(1.0, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        # A run that hears nothing ends all the same.
        ne.render(scene, method=method, time=30, **settings)
    assert time.monotonic() - sent[0] < 1.0
    assert signal.getsignal(signal.SIGINT) is before


_ADDING = """
import threading
import nephroid as ne
from nephroid import _nephroid
from nephroid._text import wish

scene = ne.load_file({scene!r}, size=256)
asked = wish(None, "photons", {{"photons": 4096}})
gathering = _nephroid.Gathering(scene, asked)
round, *_ = gathering.next(None)
count = 16
parts = [_nephroid.part(scene, round, index, count, asked, None) for index in range(1, count + 1)]
together = threading.Barrier(4)

def add(first):
    together.wait()
    for index in range(first, count, 4):
        gathering.add(parts[index], index + 1, count)

threads = [threading.Thread(target=add, args=(first,)) for first in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
whole = ne.render(scene, method="photons", photons=4096)
assert (gathering.next(None).value == whole.value).all()
"""


def test_threads_add_parts_of_a_round_at_a_time():
    # In a process of its own: threads that wait for each other never end.
    subprocess.run([sys.executable, "-c", _ADDING.format(scene=str(GLASS))], check=True, timeout=60)


def test_other_threads_go_on_meanwhile():
    scene = ne.load_file(GLASS, size=16)
    counted, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    ne.render(scene, method="photons", time=1.0, threads=1)
    stop.set()
    thread.join()
    # A second has a thousand milliseconds; a busy machine may take most of them.
    assert counted[0] > 100


def _mean(scene):
    return float(ne.render(scene, photons=16384).value.mean())


@pytest.mark.parametrize("way", ["fork", "spawn"])
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_processes_render_after_a_run_of_their_parent(way):
    if way not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system has no {way}")
    scene = ne.load_file(GLASS, size=16)
    mean = _mean(scene)
    with multiprocessing.get_context(way).Pool(2) as pool:
        assert pool.map_async(_mean, [scene] * 3).get(timeout=60) == [mean] * 3


def test_a_callback_hears_of_the_run_and_stops_it():
    heard = []

    def callback(progress):
        heard.append(progress)
        # On a busy machine photons wait for the threads to start.
        return heard[0].seconds + 30 > progress.seconds and (len(heard) < 3 or heard[-2].done == 0)

    film = ne.render(ne.load_file(GLASS, size=16), photons=ENDLESS, progress=callback)
    assert not film.complete
    assert heard[-2].unit == "photons" and heard[-2].done > 0 and heard[-2].expected == ENDLESS


def test_an_exception_of_a_callback_arrives_as_it_is():
    class Mine(Exception):
        pass

    def callback(progress):
        raise Mine(progress.unit)

    start = time.monotonic()
    with pytest.raises(Mine):
        ne.render(ne.load_file(GLASS, size=16), photons=ENDLESS, progress=callback)
    assert time.monotonic() - start < 2


def test_a_bar_of_tqdm_is_told():
    class Bar:
        total = n = refreshed = 0

        def refresh(self):
            self.refreshed += 1

    bar = Bar()
    ne.render(ne.load_file(GLASS, size=16), photons=65536, progress=ne.tell(bar))
    assert bar.n == bar.total == 65536 and bar.refreshed >= 1


def test_two_threads_render_at_once():
    scene = ne.load_file(GLASS, size=16)
    films = [None, None]

    def work(i):
        films[i] = ne.render(scene, photons=65536, seed=i, threads=2)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert np.array_equal(films[0].value, ne.render(scene, photons=65536, seed=0).value)
    assert not np.array_equal(films[0].value, films[1].value)


#: Reads a scene, a step and numbers of parts, and writes the parts.
_MAKE = """
import pickle, sys
scene, step, numbers, count = pickle.load(sys.stdin.buffer)
sys.stdout.buffer.write(pickle.dumps([step.part(scene, i, count) for i in numbers]))
"""


#: Hides fused multiply-add and wide vectors from glibc.
_PLAIN = {**os.environ, "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-AVX512F,-FMA,-FMA4"}


def _values_of_functions(env):
    code = "import math; print([f(0.003 + 1e-3 * i) for f in (math.sin, math.exp, math.log, math.tan) for i in range(9999)])"
    return subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, check=True).stdout


@pytest.mark.parametrize("count", [1, 3, 7])
@pytest.mark.parametrize(
    "settings",
    [
        {"method": "photons", "error": "2%", "replicates": 8},
        {"method": "beams", "error": "1%"},
        {"method": "path", "sensor": "eye", "spp": 4, "replicates": 2},
        {"method": "photon-map", "sensor": "eye", "seen": "anyhow", "photons": 7 * 1024, "map_photons": 512, "replicates": 7},
    ],
)
def test_parts_from_an_older_processors_c_library_fit_those_from_here_to_the_bit(settings, count):
    """Every second part is made where the C library takes its plain functions."""
    if _values_of_functions(_PLAIN) == _values_of_functions(None):
        pytest.skip("the C library computes the same with and without its wide functions here")
    scene = ne.load_string(SMALL_VIEW) if "sensor" in settings else ne.load_file(GLASS, size=16)
    run = ne.RunInParts(scene, **settings)
    while not isinstance(step := run.next(), ne.Film):
        parts = min(count, step.most_parts)
        for numbers, env in ((range(1, parts + 1, 2), _PLAIN), (range(2, parts + 1, 2), None)):
            if not numbers:
                continue
            asked = pickle.dumps((scene, step, list(numbers), parts))
            done = subprocess.run([sys.executable, "-c", _MAKE], input=asked, env=env, capture_output=True, check=True)
            for number, part in zip(numbers, pickle.loads(done.stdout), strict=True):
                run.add(part, number, parts)
    whole = ne.render(scene, **settings)
    assert max(step[name].value.max() for name in step.layers) > 0
    assert_same(step, whole)
