"""Ground truth for caustics: maps of irradiance and radiance with error bars, beside Mitsuba.

>>> import nephroid as ne
>>> scene = ne.load_file("scenes/glass-ball.xml", size=64)
>>> film = ne.render(scene, error=0.01)
>>> film.value.shape, film["LTTD"].hi.max()
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from datetime import timedelta
from typing import Any

from . import _nephroid
from ._about import Attribution, Inspection, LightPath, Probe, Shares, Stage, attribute, inspect, probe
from ._compare import Comparison, compare
from ._dict import load_dict
from ._errors import Error, LoadError, RefusedError, SettingError
from ._nephroid import Film, Layer, Progress, Scene, StudyProgress, __version__
from ._steps import RunInParts, Step
from ._study import Bounded, Gate, Report, Row, validate
from ._text import checked_scene, parameters, wish

__all__ = [
    "Attribution",
    "Bounded",
    "Comparison",
    "Error",
    "Film",
    "Gate",
    "Inspection",
    "Layer",
    "LightPath",
    "LoadError",
    "Probe",
    "Progress",
    "RefusedError",
    "Report",
    "Row",
    "RunInParts",
    "Scene",
    "SettingError",
    "Shares",
    "Stage",
    "Step",
    "StudyProgress",
    "__version__",
    "attribute",
    "compare",
    "inspect",
    "load_dict",
    "load_file",
    "load_string",
    "merge",
    "methods",
    "probe",
    "render",
    "shard",
    "tell",
    "validate",
]

#: Told of a run about every 100 ms. Returning False stops it.
Callback = Callable[[Progress], object]


def load_file(path: str | os.PathLike[str], /, *, lenient: bool = False, **params: object) -> Scene:
    """Reads a Mitsuba 3 scene file. ``params`` are the values of ``$name`` in it.

    ``lenient`` leaves out parameters that a plugin does not know, each with a warning.
    Raises :class:`LoadError` with file, line and column.
    """
    return _nephroid.load(os.fspath(path), parameters(params), [], lenient)


def load_string(source: str, /, *, lenient: bool = False, **params: object) -> Scene:
    """Reads a scene from the text of a scene file. Names of files in it are relative to the working folder."""
    return _nephroid.load("<string>", parameters(params), [("<string>", source.encode())], lenient)


def render(
    scene: Scene,
    sensor: str | None = None,
    method: str | None = None,
    error: float | str | None = None,
    time: float | str | timedelta | None = None,
    photons: int | None = None,
    seed: int | None = None,
    threads: int | None = None,
    progress: Callback | None = None,
    *,
    filter: str | None = None,
    cache: str | os.PathLike[str] | None = None,
    memory: int | None = None,
    **settings: object,
) -> Film:
    """Fills a sensor, and says how far off the answer may be.

    Without a method the scene and the error choose: beams if they can follow all light in some minutes, else photons.
    The run ends at the first of its limits: relative ``error``, ``time`` [s], amount of work (``photons``).
    ``settings`` are those that :func:`methods` lists. Results depend on no number of threads.

    ``progress`` is called about every 100 ms; if it returns False, the run ends with what is known by then. Ctrl-C
    raises KeyboardInterrupt within a second.

    Raises :class:`SettingError` and :class:`RefusedError`.
    """
    limits = {"error": error, "time": time, "photons": photons, "seed": seed}
    asked = wish(sensor, method, {**limits, **settings}, threads, filter, cache, memory)
    return _nephroid.render(checked_scene(scene), asked, progress)


def shard(
    scene: Scene,
    index: int,
    count: int,
    sensor: str | None = None,
    photons: int | None = None,
    seed: int | None = None,
    threads: int | None = None,
    progress: Callback | None = None,
    *,
    method: str | None = None,
    filter: str | None = None,
    **settings: object,
) -> bytes | None:
    """Traces part ``index`` (from 1 on) of ``count`` of a run of photons, or by ``method="photon-map"`` or ``"path"``.
    None if ``progress`` stopped it."""
    given = {"photons": photons, "seed": seed, **settings}
    asked = wish(sensor, method, given, threads, filter, None, None)
    return _nephroid.shard(checked_scene(scene), index, count, asked, progress)


def merge(
    scene: Scene,
    parts: Iterable[bytes],
    sensor: str | None = None,
    photons: int | None = None,
    seed: int | None = None,
    threads: int | None = None,
    *,
    filter: str | None = None,
    **settings: object,
) -> Film:
    """Puts all parts of a run together: the bits of the run in one piece. It needs the same settings; the method is known
    from the parts."""
    given = {"photons": photons, "seed": seed, **settings}
    asked = wish(sensor, None, given, threads, filter, None, None)
    return _nephroid.merge(checked_scene(scene), list(parts), asked)


def methods() -> dict[str, dict[str, Any]]:
    """All methods by name: their meaning, and rows of their settings with defaults, units and what is allowed."""
    return _nephroid.methods()


def tell(bar: Any) -> Callable[[Progress | StudyProgress], object]:
    """A callback for a progress bar with ``total``, ``n`` and ``refresh()``, as those of tqdm: of work done in a run, or
    of runs done in a study.

    >>> ne.render(scene, photons=1 << 24, progress=ne.tell(tqdm(unit="photons", unit_scale=True)))
    """

    def callback(progress: Progress | StudyProgress) -> None:
        bar.total = progress.expected
        bar.n = progress.done
        bar.refresh()

    return callback
