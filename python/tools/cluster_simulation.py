"""How films and studies of nephroid.dask would do on 1 to 10,000 workers: measured times, replayed.

    python cluster_simulation.py              # the tables, as docs/clusters.md has them
    python cluster_simulation.py --measure    # measures anew, into cluster_times.json (six minutes of CPU)

A worker is one core here. The client is serial, as nephroid.dask's is: it submits tasks, adds parts as they come, and
judges a round when all of its parts are there.

All times are seconds of one core (CPU time, so that other programs do not count), errors are relative, sizes are bytes.
"""

from __future__ import annotations

import argparse
import heapq
import importlib
import itertools
import json
import math
import os
import statistics
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

TIMES = Path(__file__).with_name("cluster_times.json")
WORKERS = (1, 10, 100, 1000, 10_000)

#: Photons of each replicate in the first round, as src/reference/photons/run.rs has them.
FIRST = 1 << 12

#: More of what is missing to an error than by its estimate, as src/reference/rounds.rs has it.
CAUTION = 1.2

#: Photons of one task of the measured film, and its sensor's side [texels]; the side of the one that tells how errors fall.
TASK = 1 << 22
SIDE = 512
SMALL_SIDE = 32

#: A study is shown a second time, as if each of its runs took so many times as long.
LONGER = 100

GLASS = Path(__file__).resolve().parents[2] / "scenes/glass-ball.xml"


# Workers, and what the client knows of them.


class Cluster:
    """Workers that make their tasks in the order in which they get them, and a client that does one thing at a time.

    ``workers`` is how many; each is ready after ``start`` seconds. The client needs ``submit`` seconds for a task, and as
    much again for a worker's first, which sends the scene; and for each ``look`` seconds a worker, and ``pair`` seconds
    for each pair of a worker and a task under way. A task or a result travels for ``latency`` seconds. A worker has
    ``ahead`` tasks at most: those that wait there, too."""

    def __init__(
        self,
        workers: int,
        start: float = 0.0,
        submit: float = 0.0,
        look: float = 0.0,
        pair: float = 0.0,
        latency: float = 0.0,
        ahead: int = 2,
    ) -> None:
        self.workers, self.start, self.submit, self.look, self.pair = workers, start, submit, look, pair
        self.latency, self.ahead = latency, ahead
        #: The client's time [s].
        self.now = 0.0
        #: Work of all workers, and what of it was for tasks that were cancelled [s].
        self.busy = self.wasted = 0.0
        #: Tasks that the client waits for.
        self.under_way = 0
        self._free_at = [start] * workers
        self._has = [0] * workers
        self._is_new = [True] * workers
        self._least = [(0, worker) for worker in range(workers)]
        self._numbers = itertools.count()
        self._inbox: list[tuple[float, int]] = []
        #: Of each task under way: its worker, its begin and its end.
        self._held: dict[int, tuple[int, float, float]] = {}

    def give(self, seconds: float, most: int | None = None) -> int | None:
        """Submits a task to the worker that has least. Returns its number; None if each worker has ``most`` or more."""
        while self._least[0][0] != self._has[self._least[0][1]]:
            heapq.heappop(self._least)
        count, worker = self._least[0]
        if count >= (self.ahead if most is None else most):
            return None
        self.now = max(self.now, self.start) + self.submit * (1 + self._is_new[worker])
        self.now += self.workers * (self.look + self.pair * self.under_way)
        self._is_new[worker] = False
        begin = max(self._free_at[worker], self.now + self.latency)
        end = self._free_at[worker] = begin + seconds
        self.busy += seconds
        number = next(self._numbers)
        self._held[number] = (worker, begin, end)
        self._count(worker, 1)
        heapq.heappush(self._inbox, (end + self.latency, number))
        return number

    def wait(self) -> int:
        """Waits for the next result, and returns its number."""
        while True:
            when, number = heapq.heappop(self._inbox)
            if number in self._held:
                worker, *_ = self._held.pop(number)
                self._count(worker, -1)
                self.now = max(self.now, when)
                return number

    def cancel(self, numbers: Iterable[int]) -> None:
        """Ends tasks that nobody wants any more. They are the last that their workers have."""
        told = self.now + self.latency
        for number in numbers:
            worker, begin, end = self._held.pop(number)
            used = min(max(told - begin, 0.0), end - begin)
            self.busy -= end - begin - used
            self.wasted += used
            self._free_at[worker] = begin + used
            self._count(worker, -1)

    def _count(self, worker: int, change: int) -> None:
        self.under_way += change
        self._has[worker] += change
        heapq.heappush(self._least, (self._has[worker], worker))


def make_all(cluster: Cluster, tasks: Iterable[float], add: float = 0.0) -> float:
    """Makes independent tasks in their order; the client needs ``add`` seconds for each result. Returns when it is done."""
    waiting = deque(tasks)
    while waiting or cluster.under_way:
        while waiting and cluster.give(waiting[0]) is not None:
            waiting.popleft()
        cluster.wait()
        cluster.now += add
    return cluster.now


@dataclass(frozen=True)
class Outcome:
    """What a run came to: its seconds; those of the same in one piece on one core; and what workers worked in vain."""

    workers: int
    seconds: float
    alone: float
    busy: float
    wasted: float = 0.0

    @property
    def speed_up(self) -> float:
        return self.alone / self.seconds


# Films.


@dataclass(frozen=True)
class Network:
    """Times of a cluster, as :class:`Cluster` takes them; and bytes a second of the client's network."""

    start: float
    submit: float
    look: float
    latency: float
    bytes_per_second: float
    pair: float = 0.0

    def cluster(self, workers: int, ahead: int) -> Cluster:
        return Cluster(workers, self.start, self.submit, self.look, self.pair, self.latency, ahead)


@dataclass(frozen=True)
class Film:
    """Times of a film."""

    #: Setting a task up, and each photon.
    setup: float
    photon: float
    #: Times of like tasks by their mean.
    spread: Sequence[float]
    #: Reading a part, adding it to others, and its bytes.
    read: float
    merge: float
    part_bytes: float
    #: Telling which round is next, and more for each round that is there.
    judge: float
    judge_round: float
    #: Direct light, and the film.
    finish: float
    #: Photons, and the relative error after them; the power of photons by which it falls outside of these.
    errors: Sequence[tuple[float, float]]
    power: float

    def error(self, photons: float) -> float:
        """The relative error after so many photons: between measured ones a power law, too."""
        for (x0, y0), (x1, y1) in itertools.pairwise(self.errors):
            if x0 <= photons < x1:
                return float(y0 * (y1 / y0) ** (math.log(photons / x0) / math.log(x1 / x0)))
        at, error = self.errors[0] if photons < self.errors[0][0] else self.errors[-1]
        return float(error * (photons / at) ** -self.power)


@dataclass(frozen=True)
class Plan:
    """How a film is made of tasks. The default is what nephroid.dask does."""

    replicates: int = 32
    #: Photons that a task is worth.
    task: int = TASK
    #: Tasks of a round at most; None: one for each replicate. More cut replicates, which nephroid cannot do.
    pieces: int | None = None
    #: When workers that have nothing to do begin the next round, twice as large, before this one is judged: "never",
    #: "always", or by a "forecast" that it is needed in full.
    overlap: str = "forecast"
    #: Parts that the client reads at once.
    readers: int = 1
    #: True if workers add parts up, two at a time, and the client gets one of each round.
    tree: bool = False
    #: Photons of each replicate in the first round.
    first: int = FIRST
    #: Tasks that a worker has at most.
    ahead: int = 2
    #: False if it were known from the start what all rounds are.
    barrier: bool = True


def following(before: Sequence[int], first: int, times: float) -> int:
    """Photons of each replicate in the next round, after an error so many times too large."""
    missing = max(int(sum(before) * (CAUTION * times * times - 1.0)), first)
    return min(2 * before[-1], 1 << (missing - 1).bit_length())


def rounds(film: Film, plan: Plan, goal: float) -> list[int]:
    """Photons of each replicate in each round of a run to a relative error, by the schedule of src/reference/rounds.rs."""
    found = [plan.first]
    while (error := film.error(plan.replicates * sum(found))) > goal:
        found.append(following(found, plan.first, error / goal))
    return found


def parts(plan: Plan, each: int) -> list[float]:
    """Photons of each task of a round."""
    total = plan.replicates * each
    count = min(plan.pieces or plan.replicates, max(1, total // plan.task))
    if count > plan.replicates:
        return [total / count] * count
    return [each * len(range(i, plan.replicates, count)) for i in range(count)]


def simulate_film(film: Film, network: Network, plan: Plan, goal: float, workers: int) -> Outcome:
    """A run to a relative error."""
    sizes = rounds(film, plan, goal)
    cluster = network.cluster(workers, plan.ahead)
    spread = itertools.cycle(film.spread)
    move = film.part_bytes / network.bytes_per_second

    def cut(each: int) -> deque[float]:
        return deque(film.setup + photons * film.photon * next(spread) for photons in parts(plan, each))

    def add(count: int) -> None:
        # One part is read for each core meanwhile; the network and the sum are one.
        if not plan.tree:
            cluster.now += count * max(move + film.merge, (move + film.merge + film.read) / plan.readers)

    def add_up(count: int) -> None:
        """Workers add their own parts, and then those of two workers at a time."""
        own, others = -(-count // workers) - 1, math.ceil(math.log2(min(count, workers)))
        one = film.read + film.merge
        cluster.now += own * one + others * (one + move + network.latency) + move + film.read

    cluster.now += film.judge
    number, end = 0, len(sizes)
    todo = cut(sizes[0]) if plan.barrier else deque(itertools.chain.from_iterable(map(cut, sizes)))
    while True:
        guessed: deque[float] | None = None
        flying: dict[int, float] = {}
        early: list[float] = []
        left = len(todo) + cluster.under_way
        before = plan.replicates * sum(sizes[:number])
        times = film.error(before) / goal if before else 0.0
        # As nephroid.dask forecasts it: the error falls as one over the square root of photons.
        is_forecast = CAUTION * before * times**2 - before > 2 * plan.replicates * sizes[number]
        is_guessed = plan.overlap == "always" or (plan.overlap == "forecast" and is_forecast)
        while left:
            while todo and cluster.give(todo[0]) is not None:
                todo.popleft()
            if is_guessed and not todo:
                guessed = cut(2 * sizes[number]) if guessed is None else guessed
                while guessed and (task := cluster.give(guessed[0], 1)) is not None:
                    flying[task] = guessed.popleft()
            task = cluster.wait()
            if task in flying:
                early.append(flying.pop(task))
            else:
                add(1)
                left -= 1
        if plan.tree:
            add_up(len(parts(plan, sizes[number])))
        number = number + 1 if plan.barrier else end
        cluster.now += film.judge + film.judge_round * number
        if number < end and guessed is not None and sizes[number] == 2 * sizes[number - 1]:
            # What is under way is wanted now.
            add(len(early))
            todo = guessed
            continue
        cluster.cancel(list(flying))
        cluster.wasted += sum(early)
        if number == end:
            break
        todo = cut(sizes[number])
    cluster.now += film.finish
    alone = film.judge + plan.replicates * sum(sizes) * film.photon + film.finish
    return Outcome(workers, cluster.now, alone, cluster.busy, cluster.wasted)


# Studies.


@dataclass(frozen=True)
class Study:
    """Times of a study."""

    #: Each run but the truth, in the order of the study.
    runs: Sequence[float]
    truth: float
    #: Of each attribution, which needs the truth's film: its first run, and then its parts, which need that, too.
    attributions: Sequence[Sequence[float]]
    #: Writing the files of a run, and the report of all.
    keep: float
    report: float

    def longer(self, times: float) -> Study:
        """The same with more work in each run; the client's part stays."""
        runs = [times * one for one in self.runs]
        attributions = [[times * part for part in parts] for parts in self.attributions]
        return replace(self, runs=runs, truth=times * self.truth, attributions=attributions)


@dataclass(frozen=True)
class StudyPlan:
    """How a study is made of tasks. The default is what nephroid.dask does."""

    ahead: int = 2
    #: True if the longest begin first, as if times were known.
    is_sorted: bool = False
    #: How attributions are made: in "parts"; each in "one" task, once the truth's film is there; or with the "truth".
    attributions: str = "parts"
    #: True if each run's task compares it with the truth's film, which it waits for, instead of the client's report.
    is_judged: bool = False
    #: Cores that share the client's report evenly.
    cores: int = 1
    #: Tasks that a truth is cut into.
    truths: int = 1


@dataclass(frozen=True)
class _Job:
    """A task, and those that it makes ready."""

    seconds: float
    then: Sequence[_Job] = ()


def simulate_study(study: Study, network: Network, plan: StudyPlan, workers: int) -> Outcome:
    """A study to its report."""
    cluster = network.cluster(workers, plan.ahead)
    truth, later = study.truth, []
    for first, *parts in study.attributions:
        if plan.attributions == "parts":
            later.append(_Job(first, [_Job(part) for part in parts]))
        elif plan.attributions == "one":
            later.append(_Job(first + sum(parts)))
        else:
            truth += first + sum(parts)
    # Truths first, then the last of a sweep.
    runs = [_Job(one) for one in reversed(sorted(study.runs) if plan.is_sorted else study.runs)]
    if plan.is_judged:
        later += [_Job(one.seconds + study.report / len(runs)) for one in runs]
        runs = []
    truths = [_Job(truth / plan.truths) for _ in range(plan.truths)]
    todo, left = deque([*truths, *runs]), len(truths)
    under_way: dict[int, _Job] = {}
    while todo or under_way:
        while todo and (number := cluster.give(todo[0].seconds)) is not None:
            under_way[number] = todo.popleft()
        number = cluster.wait()
        ready = under_way.pop(number).then
        if number < plan.truths:
            left -= 1
            ready = later if not left else ()
        todo.extendleft(reversed(ready))
        cluster.now += study.keep
    if not plan.is_judged:
        cluster.now += study.report / plan.cores
    alone = study.truth + sum(map(sum, study.attributions)) + sum(study.runs) + study.report
    return Outcome(workers, cluster.now, alone, cluster.busy)


# What limits, and the tables.

#: Where nothing would.
NOTHING = "nothing"


def limit(found: Outcome, others: dict[str, Callable[[], Outcome]]) -> str:
    """What would save most if it took no time, with the share of the time that it would save; from 5 % on."""
    saved = {name: 1.0 - other().seconds / found.seconds for name, other in others.items()}
    name = max(saved, key=lambda name: saved[name])
    return f"{name} ({100 * saved[name]:.0f} %)" if saved[name] >= 0.05 else NOTHING


def limit_of_film(film: Film, network: Network, plan: Plan, goal: float, workers: int) -> str:
    def other(film: Film = film, network: Network = network, plan: Plan = plan) -> Callable[[], Outcome]:
        return lambda: simulate_film(film, network, plan, goal, workers)

    others = {
        "start-up": other(network=replace(network, start=0.0)),
        "submitting": other(network=replace(network, submit=0.0, look=0.0, pair=0.0, latency=0.0)),
        "adding": other(replace(film, read=0.0, merge=0.0, part_bytes=0.0)),
        "judging": other(replace(film, judge=0.0, judge_round=0.0)),
        "set-up": other(replace(film, setup=0.0)),
        "direct light": other(replace(film, finish=0.0)),
        "barrier": other(plan=replace(plan, barrier=False, overlap="never")),
    }
    if plan.pieces is None:
        # As many parts are added as before.
        pieces = max(plan.replicates, 4 * workers)
        share = plan.replicates / pieces
        cheap = replace(film, read=film.read * share, merge=film.merge * share, part_bytes=film.part_bytes * share)
        others["replicates"] = other(cheap, replace(network, submit=0.0, look=0.0, pair=0.0), replace(plan, pieces=pieces))
    return limit(simulate_film(film, network, plan, goal, workers), others)


def limit_of_study(study: Study, network: Network, plan: StudyPlan, workers: int) -> str:
    def other(study: Study = study, network: Network = network, plan: StudyPlan = plan) -> Callable[[], Outcome]:
        return lambda: simulate_study(study, network, plan, workers)

    # The same work, in a part for each worker that does not wait for the first run.
    even = [[0.0, *[sum(parts) / workers] * workers] for parts in study.attributions]
    others = {
        "start-up": other(network=replace(network, start=0.0)),
        "submitting": other(network=replace(network, submit=0.0, look=0.0, pair=0.0, latency=0.0)),
        "files and the report": other(replace(study, keep=0.0, report=0.0)),
        "the truth": other(plan=replace(plan, truths=workers)),
        "parts of attributions": other(replace(study, attributions=even)),
    }
    return limit(simulate_study(study, network, plan, workers), others)


def duration(seconds: float) -> str:
    """Seconds, minutes, hours or days, by two or three figures."""
    for unit, size in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{_short(seconds / size)} {unit}"
    return f"{_short(seconds)} s"


def _short(number: float) -> str:
    return f"{number:.1f}" if number < 9.95 else f"{number:,.0f}"


def film_plans(workers: int) -> dict[str, Plan]:
    """What is compared. Pieces are four for each worker."""
    pieces = max(255, 4 * workers)
    return {
        "as it is": Plan(),
        "tasks of 2^20": Plan(task=1 << 20),
        "tasks of 2^24": Plan(task=1 << 24),
        "early rounds skipped": Plan(first=1 << 20),
        "no rounds overlap": Plan(overlap="never"),
        "all rounds overlap": Plan(overlap="always"),
        "4 parts read at once": Plan(readers=4),
        "parts added by workers": Plan(tree=True),
        "255 replicates": Plan(replicates=255),
        "255, no rounds overlap": Plan(replicates=255, overlap="never"),
        "255, added by workers": Plan(replicates=255, tree=True),
        "replicates in pieces": Plan(pieces=pieces),
        "pieces, added by workers": Plan(pieces=pieces, tree=True),
    }


STUDY_PLANS = {
    "as it is": StudyPlan(),
    "no task waits at a worker": StudyPlan(ahead=1),
    "the longest first": StudyPlan(is_sorted=True),
    "attributions in the truth's task": StudyPlan(attributions="truth"),
    "an attribution in one task": StudyPlan(attributions="one"),
    "a client of 4 cores": StudyPlan(cores=4),
    "a client of 16 cores": StudyPlan(cores=16),
    "rows judged by workers": StudyPlan(is_judged=True),
}


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _head(*titles: str) -> list[str]:
    return [_row(titles), _row(["---"] * len(titles))]


def _limits(outcomes: Iterable[tuple[Outcome, str]]) -> list[str]:
    lines = _head("workers", "time", "speed-up", "efficiency", "what limits, and would save")
    for one, limits in outcomes:
        share = f"{100 * one.speed_up / one.workers:.3g} %"
        lines.append(_row([f"{one.workers:,}", duration(one.seconds), _short(one.speed_up), share, limits]))
    return lines


def _speed_ups(rows: dict[str, list[Outcome]], has_waste: bool = False) -> list[str]:
    """Speed-ups; and the largest share of work that was thrown away."""
    lines = _head("speed-up on", *(f"{workers:,}" for workers in WORKERS), *["thrown away"] * has_waste)
    for name, found in rows.items():
        waste = max(one.wasted / one.busy for one in found)
        lines.append(_row([name, *(_short(one.speed_up) for one in found), *[f"{100 * waste:.0f} %"] * has_waste]))
    return lines


def tables(times: dict[str, Any]) -> str:
    """All tables, as Markdown."""
    film, study, network = read(times)
    blocks = []
    for title, goal in (("0.01 %", 1e-4), ("1 %", 1e-2)):
        work = simulate_film(film, network, Plan(), goal, 1).alone
        blocks.append([f"A film of {SIDE}² to {title}, {duration(work)} of one core, as it is cut:"])
        plan = Plan()
        found = [(simulate_film(film, network, plan, goal, w), limit_of_film(film, network, plan, goal, w)) for w in WORKERS]
        blocks.append(_limits(found))
        blocks.append([f"The same film to {title}, cut in other ways:"])
        names = film_plans(1)
        rows = {n: [simulate_film(film, network, film_plans(w)[n], goal, w) for w in WORKERS] for n in names}
        blocks.append(_speed_ups(rows, True))
    for times_longer in (1, LONGER):
        longer = study.longer(times_longer)
        work = simulate_study(longer, network, StudyPlan(), 1).alone
        what = "as measured" if times_longer == 1 else f"each run as if {LONGER} times as long"
        blocks.append([f"A study of {len(study.runs)} runs and a truth, {what}, {duration(work)} of one core:"])
        study_plan = StudyPlan()
        limits = {w: limit_of_study(longer, network, study_plan, w) for w in WORKERS}
        blocks.append(_limits((simulate_study(longer, network, study_plan, w), limits[w]) for w in WORKERS))
        blocks.append(["The same study, in other ways:"])
        plans = STUDY_PLANS.items()
        rows = {n: [simulate_study(longer, network, p, w) for w in WORKERS] for n, p in plans}
        before = replace(network, **times["before"])
        rows["tasks counted for each worker"] = [simulate_study(longer, before, StudyPlan(), w) for w in WORKERS]
        blocks.append(_speed_ups(rows))
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def read(times: dict[str, Any]) -> tuple[Film, Study, Network]:
    """What ``cluster_times.json`` says."""
    film = {**times["film"], "errors": [tuple(one) for one in times["film"]["errors"]]}
    return Film(**film), Study(**times["study"]), Network(**times["network"], **times["assumed"])


# Measuring.


def _timed(function: Callable[..., Any], *given: Any) -> tuple[float, Any]:
    """CPU seconds of this process, and the result."""
    start = time.process_time()
    result = function(*given)
    return time.process_time() - start, result


def _goes_on(*_: object) -> bool:
    return True


def measure() -> dict[str, Any]:
    """All times anew, on this machine."""
    film, film_ways = _measured_film()
    network, pair, network_ways = _measured_network()
    study, study_ways = _measured_study()
    return {
        "how": {**film_ways, **network_ways, **study_ways},
        "film": film,
        "study": study,
        "network": network,
        "before": {"pair": pair},
        # Nothing was measured of another machine's network: 10 Gbit/s.
        "assumed": {"bytes_per_second": 1.25e9},
    }


def _measured_film() -> tuple[dict[str, Any], dict[str, Any]]:
    import nephroid as ne
    from nephroid import _nephroid
    from nephroid._text import wish

    def asked(**given: object) -> Any:
        return {**wish(None, None, given, None, None), "threads": 1}

    scene = ne.load_file(GLASS, size=SIDE)
    # A round in which each replicate has the photons of a task.
    run = asked(photons=32 * TASK)
    _, step = _begun(scene, run)
    made = [_timed(_nephroid.part, scene, step, i, 32, run, _goes_on) for i in range(1, 6)]
    first = [_timed(_begun(scene, run)[0].add, made[0][1], 1, 32)[0] for _ in range(3)]
    gathering, _ = _begun(scene, run)
    added = [_timed(gathering.add, part, i, 32)[0] for i, (_, part) in enumerate(made, 1)][1:]
    # A photon for each replicate: setting a task up, and direct light.
    run = asked(photons=32)
    gathering, step = _begun(scene, run)
    setups = [_timed(_nephroid.part, scene, step, 1, 32, run, _goes_on)[0] for _ in range(3)]
    part: Any = _nephroid.part(scene, step, 1, 1, run, _goes_on)
    gathering.add(part, 1, 1)
    finish, _ = _timed(gathering.next, _goes_on)
    large, judged = _errors(scene, asked(error=1e-9), 1 << 22)
    small, _ = _errors(ne.load_file(GLASS, size=SMALL_SIDE), asked(error=1e-9), 1 << 24)
    setup, each = statistics.median(setups), statistics.fmean(seconds for seconds, _ in made)
    (x0, y0), (x1, y1) = small[-5], small[-1]
    slope = statistics.linear_regression(range(len(judged)), judged)
    times = {
        "setup": setup,
        "photon": (each - setup) / TASK,
        "spread": [seconds / each for seconds, _ in made],
        "read": statistics.median(first),
        "merge": max(statistics.median(added) - statistics.median(first), 0.0),
        "part_bytes": statistics.fmean(len(part) for _, part in made),
        "judge": slope.intercept,
        "judge_round": slope.slope,
        "finish": finish,
        "errors": large,
        "power": -math.log(y1 / y0) / math.log(x1 / x0),
    }
    ways = {
        "film": f"scenes/glass-ball.xml, size={SIDE}, one thread: five tasks of one replicate of {TASK} photons",
        "power": f"size={SMALL_SIDE}: from {x0} to {x1} photons the error fell from {y0:.4g} to {y1:.4g}",
        "nephroid": _nephroid.source_hash[:16],
    }
    return times, ways


def _errors(scene: Any, run: Any, most: int) -> tuple[list[tuple[int, float]], list[float]]:
    """Photons of a run's first rounds, and its error after each; and seconds for telling each round."""
    from nephroid import _nephroid

    gathering = _nephroid.Gathering(scene, run)
    done, errors, judged = 0, [], []
    while True:
        seconds, (step, _, work, *_) = _timed(gathering.next, _goes_on)
        judged.append(seconds)
        if gathering.relative_error is not None:
            errors.append((done, gathering.relative_error))
        if done >= most:
            return errors, judged
        part: Any = _nephroid.part(scene, step, 1, 1, run, _goes_on)
        gathering.add(part, 1, 1)
        done += work


def _begun(scene: Any, run: Any) -> tuple[Any, str]:
    """A run before its first round, and that round."""
    from nephroid import _nephroid

    gathering = _nephroid.Gathering(scene, run)
    found: Any = gathering.next(_goes_on)
    return gathering, found[0]


def _nothing(*_: object) -> None:
    pass


def _measured_network() -> tuple[dict[str, float], float, dict[str, Any]]:
    import nephroid.dask

    # It has no types.
    distributed: Any = importlib.import_module("distributed")
    count = 200
    with (
        distributed.LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=":0") as cluster,
        distributed.Client(cluster) as client,
    ):
        start = time.monotonic()
        cluster.scale(1)
        client.wait_for_workers(1)
        client.submit(_import, pure=False).result()
        start = time.monotonic() - start
        scene = client.scatter(1)
        trips = []
        for i in range(50):
            begin = time.monotonic()
            client.submit(_nothing, scene, i, key=f"trip-{i}").result()
            trips.append(time.monotonic() - begin)
        submit, futures = _timed(lambda: [client.submit(_nothing, scene, i, key=f"task-{i}") for i in range(count)])
        distributed.wait(futures)
    # The client's choice of a worker; and as it was when each worker's tasks were counted by themselves.
    call = nephroid.dask._Call(None, _goes_on)
    call._workers = [f"tcp://10.0.{i // 250}.{i % 250}:40000" for i in range(10_000)]
    call._places = {f"nephroid-part-{i}": call._workers[i] for i in range(300)}
    look, _ = _timed(lambda: [call._free(2) for _ in range(20)])
    busy = list(call._places.values())
    pair, _ = _timed(lambda: [min(call._workers, key=busy.count) for _ in range(5)])
    times = {
        "start": start,
        "submit": submit / count,
        "look": look / 20 / 10_000,
        "latency": statistics.median(trips) / 2,
    }
    ways = {
        "network": f"a Dask scheduler and a worker on this machine: {count} tasks submitted, 50 there and back; wall time of "
        "these and of a worker's start, with the import of nephroid",
        "look": "choosing one of 10,000 workers, which have 300 tasks",
        "pair": "the same, with the tasks counted again for each worker, as they were before this was measured",
    }
    return times, pair / 5 / (10_000 * 300), ways


def _import() -> None:
    import nephroid.dask  # noqa: F401


#: 300 runs of the glass ball on a meter of 128² texels.
STUDY: dict[str, Any] = {
    "truth": {"method": "beams", "error": "0.1%"},
    "method": [
        {
            "method": "photons",
            "photons": {"from": 1024, "to": 524288, "times": 2},
            "samples": ["sobol", "random"],
            "replicates": [16, 32, 64],
        },
        {
            "method": "caustic-map",
            "photons": [64, 128, 256, 512],
            "map": [64, 128, 256, 512, 1024],
            "bisections": [0, 8],
            "steps": [16, 32, 64],
            "splat": ["thin-lens", "fixed"],
        },
    ],
}


def _measured_study() -> tuple[dict[str, Any], dict[str, Any]]:
    import nephroid as ne
    import nephroid.dask
    from nephroid import _nephroid
    from nephroid._study import _asked

    scene = ne.load_file(GLASS, size=128)
    runs, keep, attributions = [], [], []
    truth = 0.0
    with (
        tempfile.TemporaryDirectory() as folder,
        _asked({"scene": scene, **STUDY}, f"{folder}/report", None, None, None, None, None, 1, None, {}) as asked,
    ):
        subject, place, given = asked
        text, [(_, kept, scene, units)] = _nephroid.units(subject, os.fspath(place), given)
        Path(kept).mkdir(parents=True, exist_ok=True)
        files_of = {key: files for key, _, files, *_ in units}
        for key, needs, _, is_early, _ in units:
            needed = {name: Path(kept, name).read_bytes() for one in needs for name in files_of[one]}
            with nephroid.dask._folder(None, needed) as (made, new):
                seconds, _ = _timed(_nephroid.unit, scene, key, made, {**given, "study": text}, _goes_on)
                files = new()
            if not is_early:
                runs.append(seconds)
            elif not needs:
                truth += seconds
            elif len(needs) == 1:
                attributions.append([seconds])
            else:
                attributions[-1].append(seconds)
            begin = time.monotonic()
            nephroid.dask._keep(Path(kept), files)
            keep.append(time.monotonic() - begin)
        report, _ = _timed(_nephroid.validate, subject, os.fspath(place), given, _goes_on)
    times = {
        "runs": runs,
        "truth": truth,
        "attributions": attributions,
        "keep": statistics.median(keep),
        "report": report,
    }
    sizes = f"{len(runs)} runs and the truth by beams to 0.1 %, scenes/glass-ball.xml, size=128, one thread"
    return times, {"study": f"{sizes}; attributions as their first runs and parts of four"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--measure", action="store_true", help="measure anew")
    if parser.parse_args().measure:
        TIMES.write_text(json.dumps(_rounded(measure()), indent=1) + "\n")
    print(tables(json.loads(TIMES.read_text())), end="")


def _rounded(times: Any) -> Any:
    """Numbers to four figures."""
    if isinstance(times, dict):
        return {name: _rounded(one) for name, one in times.items()}
    if isinstance(times, list | tuple):
        return [_rounded(one) for one in times]
    return float(f"{times:.4g}") if isinstance(times, float) else times


if __name__ == "__main__":
    main()
