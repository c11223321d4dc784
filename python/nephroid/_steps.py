"""Runs step by step, each in parts: for engines of whatever kind that share work out. Dask's has a module of its own."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from . import _nephroid
from ._nephroid import Film, Progress, Scene
from ._text import checked_scene, checked_threads, wish


@dataclass(frozen=True)
class Step:
    """A round of photons or paths, or a pass of beams. It can be pickled, and sent to other processes."""

    #: The same for steps that are made from the same, whatever run they are of. With a part's ``index`` and ``count`` it
    #: names what is kept.
    key: str
    #: Its work: photons, paths (of photon maps, those of photons and of cameras together), or rays of beams, as forecast.
    work: int
    #: The most parts that it can be made in.
    most_parts: int
    #: The most work that may follow it.
    left: int
    _step: str = field(repr=False)
    _asked: Any = field(repr=False, hash=False)

    def part(
        self,
        scene: Scene,
        index: int,
        count: int,
        threads: int | None = None,
        progress: Callable[[Progress], object] | None = None,
    ) -> bytes | None:
        """Makes part ``index`` (from 1 on) of ``count``: its sums. It takes all cores, or so many ``threads``. None if
        ``progress`` stopped it."""
        asked: Any = {**self._asked, "threads": checked_threads(threads)}
        return _nephroid.part(checked_scene(scene), self._step, index, count, asked, progress)

    def _doubled(self) -> Step:
        """The round after a round, if it has twice as much work: spelt as the run spells it. Its key and what is left
        after it are not known."""
        now = json.loads(self._step)["round"]
        each, before = now["each"], now["before"]
        doubled = {**now, "number": now["number"] + 1, "each": 2 * each, "before": before + each}
        return replace(self, work=2 * self.work, _step=json.dumps({"round": doubled}, separators=(",", ":")))


def next_step(
    gathering: _nephroid.Gathering, asked: Any, progress: Callable[[Progress], object] | None
) -> Step | Film | None:
    """The step that a run needs next; the film, if none is needed. None if ``progress`` stopped it."""
    found = gathering.next(progress)
    if found is None or isinstance(found, Film):
        return found
    step, key, work, most, left = found
    return Step(key, work, most, left, step, asked)


class RunInParts:
    """A run whose steps are made in parts, anywhere and in any order. Its film has the bits of :func:`render` with the
    same sensor, method and settings.

    >>> run = ne.RunInParts(scene, method="beams", error=0.001)
    >>> while not isinstance(step := run.next(), ne.Film):
    ...     for i in range(1, 5):                      # by processes, jobs, or whatever shares work out
    ...         run.add(step.part(scene, i, 4), i, 4)
    >>> film = step

    Methods are ``photons``, which is the default, ``photon-map``, ``path`` and ``beams``. A run ends at a relative ``error``,
    or after its work; a ``time`` is refused. What steps find decides which come next. ``threads`` are those of what is
    done here: parts have their own.
    """

    def __init__(
        self,
        scene: Scene,
        sensor: str | None = None,
        method: str | None = None,
        error: float | str | None = None,
        photons: int | None = None,
        seed: int | None = None,
        threads: int | None = None,
        *,
        filter: str | None = None,
        **settings: object,
    ) -> None:
        given = {"error": error, "photons": photons, "seed": seed, **settings}
        self._asked = wish(sensor, method, given, threads, filter)
        self._gathering = _nephroid.Gathering(checked_scene(scene), self._asked)

    def next(self, progress: Callable[[Progress], object] | None = None) -> Step | Film | None:
        """The step that is needed next: the same one until all of its parts are there. The film, if none is needed.
        None if ``progress`` stopped what is done here, and from then on: a run that was stopped is over."""
        return next_step(self._gathering, self._asked, progress)

    def add(self, part: bytes, index: int, count: int) -> None:
        """Adds part ``index`` of ``count`` of the step that :meth:`next` told. Parts of another step, of another run or
        of another ``count`` are refused."""
        self._gathering.add(part, index, count)

    @property
    def relative_error(self) -> float | None:
        """The error of the steps that are whole; None while it is not known."""
        return self._gathering.relative_error
