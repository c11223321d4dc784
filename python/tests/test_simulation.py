"""The simulation of large clusters, against what is known in closed form."""

from __future__ import annotations

import importlib.util
import json
import math
import random
import sys
from dataclasses import replace

import pytest

from conftest import ROOT

_SPEC = importlib.util.spec_from_file_location("cluster_simulation", ROOT / "python/tools/cluster_simulation.py")
simulation = importlib.util.module_from_spec(_SPEC)
sys.modules["cluster_simulation"] = simulation
_SPEC.loader.exec_module(simulation)

TIMES = json.loads(simulation.TIMES.read_text())
FILM, STUDY, NETWORK = simulation.read(TIMES)
#: A cluster and a client that cost nothing.
FREE = simulation.Network(start=0.0, submit=0.0, look=0.0, latency=0.0, bytes_per_second=math.inf)
#: A film whose photons alone take time: 1 s for each 2^20; the error of 2^20 of them is 10 %.
EVEN = simulation.Film(
    setup=0.0,
    photon=2.0**-20,
    spread=[1.0],
    read=0.0,
    merge=0.0,
    part_bytes=0.0,
    judge=0.0,
    judge_round=0.0,
    finish=0.0,
    errors=[(1 << 20, 0.1)],
    power=0.5,
)
#: Rounds that are never one task, of 32 replicates, one after the other.
FINE = simulation.Plan(task=1, overlap="never")


def made(workers, tasks, ahead=2, **costs):
    return simulation.make_all(simulation.Cluster(workers, ahead=ahead, **costs), tasks)


@pytest.mark.parametrize("ahead", [1, 2])
@pytest.mark.parametrize(("tasks", "workers"), [(1, 1), (12, 1), (12, 5), (32, 10), (33, 32), (300, 1000)])
def test_equal_tasks_take_as_many_turns_as_there_are(tasks, workers, ahead):
    assert made(workers, [3.0] * tasks, ahead) == 3.0 * math.ceil(tasks / workers)


def random_tasks(seed):
    rng = random.Random(seed)
    return [rng.expovariate(1.0) for _ in range(rng.randint(1, 200))], rng.randint(1, 40)


@pytest.mark.parametrize("seed", range(50))
def test_random_tasks_keep_brents_bound(seed):
    tasks, workers = random_tasks(seed)
    total, longest = sum(tasks), max(tasks)
    least = max(total / workers, longest)
    assert least - 1e-9 <= made(workers, tasks, ahead=1) <= total / workers + longest + 1e-9
    # One that waits at a worker may wait for the longest, while another has nothing to do.
    assert least - 1e-9 <= made(workers, tasks, ahead=2) <= total / workers + 2 * longest + 1e-9
    assert made(1, tasks) == pytest.approx(total)
    assert made(len(tasks), tasks) == pytest.approx(longest)


def test_a_task_that_waits_at_a_worker_is_not_taken_by_another():
    # The second worker gets the second task and then, as both have one, the first worker the third.
    assert made(2, [9.0, 1.0, 1.0, 1.0], ahead=2) == 10.0
    assert made(2, [9.0, 1.0, 1.0, 1.0], ahead=1) == 9.0


def test_costs_of_the_client_and_of_the_way():
    # Up after 5 s; the first task of a worker is submitted with the scene; there and back.
    assert made(1, [10.0], start=5.0, submit=1.0, latency=0.5) == 5.0 + 2.0 + 0.5 + 10.0 + 0.5
    # A client that needs longer than the workers is what limits.
    cluster = simulation.Cluster(100)
    assert simulation.make_all(cluster, [1.0] * 100, add=1.0) == 1.0 + 100 * 1.0
    # Each submission looks at all workers, or at pairs of them and what is under way.
    assert made(4, [0.0] * 4, look=1.0) == 4 * 4.0
    assert made(4, [0.0] * 4, pair=1.0) == 4 * (0 + 1 + 2 + 3)


def test_tasks_that_are_ended_give_back_their_time():
    cluster = simulation.Cluster(2)
    wanted, unwanted = cluster.give(2.0), cluster.give(10.0)
    assert cluster.wait() == wanted and cluster.now == 2.0
    cluster.cancel([unwanted])
    assert (cluster.busy, cluster.wasted, cluster.under_way) == (4.0, 2.0, 0)
    cluster.give(1.0), cluster.give(1.0)
    assert [cluster.wait(), cluster.wait()] and cluster.now == 3.0


def test_rounds_are_those_of_the_schedule():
    # As src/reference/rounds.rs tests them: the error is 1 / √photons.
    film = replace(EVEN, errors=[(1, 1.0)])
    plan = simulation.Plan(replicates=1, first=4)
    assert simulation.rounds(film, plan, 0.13) == [4, 8, 16, 32]
    assert simulation.rounds(film, plan, 0.129) == [4, 8, 16, 32, 16]


def test_parts_of_a_round_are_those_of_the_client():
    dask = pytest.importorskip("nephroid.dask")
    for each in (1 << 12, 1 << 17, 1 << 18, 3 << 18, 1 << 24):
        for replicates in (5, 32, 255):
            count = min(replicates, max(1, replicates * each // dask._TASK_WORK))
            # A part has every count-th replicate, from its own on.
            photons = [each * len(range(i, replicates + 1, count)) for i in range(1, count + 1)]
            assert simulation.parts(simulation.Plan(replicates=replicates), each) == photons
            assert sum(dask._share(replicates * each, i, count) for i in range(1, count + 1)) == sum(photons)
    assert simulation.Plan().ahead == simulation.StudyPlan().ahead == dask._AHEAD
    assert (simulation.TASK, simulation.CAUTION) == (dask._TASK_WORK, dask._CAUTION)


def test_films_take_their_critical_path_on_enough_workers():
    goal = 0.001
    sizes = simulation.rounds(EVEN, FINE, goal)
    each = [size * EVEN.photon for size in sizes]
    found = {workers: simulation.simulate_film(EVEN, FREE, FINE, goal, workers).seconds for workers in (1, 10, 32, 5000)}
    assert found[1] == pytest.approx(32 * sum(each))
    # 32 replicates on ten workers are four turns.
    assert found[10] == pytest.approx(4 * sum(each))
    assert found[32] == found[5000] == pytest.approx(sum(each))
    # All rounds at once: the longest of them.
    free = simulation.simulate_film(EVEN, FREE, replace(FINE, barrier=False), goal, 32 * len(sizes))
    assert free.seconds == pytest.approx(max(each))
    # Replicates in pieces.
    many = simulation.simulate_film(EVEN, FREE, replace(FINE, pieces=320), goal, 320)
    assert many.seconds == pytest.approx(sum(each) / 10)


def test_rounds_that_overlap_two_at_a_time():
    # Each round but the last is twice the one before, and begins with it: what is left of it then takes as long again.
    goal = 0.001
    sizes = simulation.rounds(EVEN, FINE, goal)
    each = [size * EVEN.photon for size in sizes]
    always = simulation.simulate_film(EVEN, FREE, replace(FINE, overlap="always"), goal, 64)
    end = begun = 0.0
    for number, seconds in enumerate(each):
        is_guess_right = number > 0 and sizes[number] == 2 * sizes[number - 1]
        begin = begun if is_guess_right else end
        # The next begins once the one before this is judged.
        begun, end = end, begin + seconds
    assert always.seconds == pytest.approx(end)
    # What is thrown away is what was begun after the last rounds.
    assert 0 < always.wasted < always.busy / 2
    never = simulation.simulate_film(EVEN, FREE, FINE, goal, 64)
    forecast = simulation.simulate_film(EVEN, FREE, replace(FINE, overlap="forecast"), goal, 64)
    assert always.seconds <= forecast.seconds < never.seconds and never.wasted == 0
    assert forecast.wasted < always.wasted
    assert always.busy - always.wasted == pytest.approx(never.busy)
    assert forecast.busy - forecast.wasted == pytest.approx(never.busy)


def test_studies_take_their_critical_path_on_enough_workers():
    attributions = [[2.0, 1.5, 1.5], [3.0, 1.0, 2.0]]
    study = simulation.Study(runs=[1.0, 2.0, 3.0], truth=4.0, attributions=attributions, keep=0.0, report=1.0)
    parts = simulation.StudyPlan()
    one, together = replace(parts, attributions="one"), replace(parts, attributions="truth")

    def seconds(plan, workers):
        return simulation.simulate_study(study, FREE, plan, workers).seconds

    assert seconds(together, 1) == seconds(one, 1) == seconds(parts, 1) == 22.0
    assert seconds(together, 9) == 4.0 + 11.0 + 1.0
    assert seconds(one, 9) == 4.0 + 6.0 + 1.0
    # The longest first run, and the longest of its parts.
    assert seconds(parts, 9) == 4.0 + 3.0 + 2.0 + 1.0
    assert seconds(replace(one, truths=4), 9) == 1.0 + 6.0 + 1.0
    assert seconds(replace(parts, cores=4), 9) == 4.0 + 3.0 + 2.0 + 0.25
    # Runs that are judged wait for the truth, and have a third of the report each.
    assert seconds(replace(parts, is_judged=True), 20) == pytest.approx(4.0 + 3.0 + 2.0)


def test_the_same_times_give_the_same_figures():
    plan = simulation.Plan(overlap="forecast")
    found = [simulation.simulate_film(FILM, NETWORK, plan, 0.01, 100) for _ in range(2)]
    assert found[0] == found[1] and found[0].seconds > found[0].alone / 100
    assert len(STUDY.runs) == 300 and min(STUDY.runs) > 0


def test_the_page_has_the_tables():
    page = (ROOT / "docs/clusters.md").read_text()
    begin, end = "<!-- python python/tools/cluster_simulation.py -->\n\n", "\n<!-- end -->"
    assert page.split(begin)[1].split(end)[0] == simulation.tables(TIMES)
