"""What can be said of a scene without a film: contents and costs, the paths to one point, the stages of an error."""

from __future__ import annotations

import html
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _nephroid
from ._errors import SettingError
from ._nephroid import Progress, Scene
from ._text import checked_scene, settings_as_text, wish

Callback = Callable[[Progress], object]
_Numbers = NDArray[np.float64]


def _numbers(values: Any) -> _Numbers:
    """An array that nobody writes to by mistake. None is NaN."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def _table(caption: str, head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    def line(cells: tuple[str, ...], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    body = "".join(line(row, "td") for row in rows)
    return f"<table><caption>{html.escape(caption)}</caption>{line(head, 'th')}{body}</table>"


@dataclass(frozen=True)
class Inspection:
    """Contents and requirements of a scene, and what methods cost, as ``nephroid inspect --json`` has them."""

    #: All that is known, by name.
    report: dict[str, Any]

    @property
    def requirements(self) -> dict[str, str]:
        """Features that the scene needs, each with the reason."""
        rows = self.report["requirements"]
        return {str(row["feature"]): str(row["reason"]) for row in rows if row["needed"]}

    @property
    def sensors(self) -> list[str]:
        """Ids of all sensors."""
        return [str(sensor["id"]) for sensor in self.report["sensors"]]

    def _sensor(self, sensor: str | None) -> dict[str, Any]:
        found: list[dict[str, Any]] = self.report["sensors"]
        for one in found:
            if sensor is None or one["id"] == sensor:
                return one
        there = ", ".join(self.sensors)
        raise SettingError(f'no sensor is called "{sensor}"; there are {there}')

    def costs(self, sensor: str | None = None) -> dict[str, dict[str, Any]]:
        """The cost of a run at most, of all methods that can fill a sensor, by default the first."""
        return dict(self._sensor(sensor)["costs"])

    def suits(self, sensor: str | None = None) -> tuple[str, str] | None:
        """The method that suits a sensor with default settings, and why; None if no method does."""
        found = self._sensor(sensor)["suits"]
        return None if found is None else (str(found[0]), str(found[1]))

    @property
    def ignored(self) -> list[dict[str, Any]]:
        """What the file has and no measurement heeds."""
        return list(self.report["ignored"])

    @property
    def warnings(self) -> list[Any]:
        """Oddities of the scene."""
        return list(self.report["warnings"])

    @property
    def advice(self) -> dict[str, Any] | None:
        """Cost, memory, and the lines of a pilot, of the method that was asked for."""
        return self.report.get("advice")

    def __repr__(self) -> str:
        return f"<nephroid.Inspection {self.report['scene']}: sensors {', '.join(self.sensors)}>"

    def _repr_html_(self) -> str:
        rows = []
        for sensor in self.sensors:
            suited = (self.suits(sensor) or ("",))[0]
            for method, cost in self.costs(sensor).items():
                rows.append((sensor, method + (" (suits)" if method == suited else ""), f"{cost['bytes'] / 1e6:.0f}"))
        needed = [(feature, reason) for feature, reason in self.requirements.items()]
        return _table(self.report["scene"], ("sensor", "method", "MB at most"), rows) + _table(
            "needs", ("feature", "reason"), needed
        )


def inspect(scene: Scene, method: str | None = None, sensor: str | None = None, **settings: object) -> Inspection:
    """Contents and requirements of a scene, and the cost of each method that can fill a sensor.

    With a method, ``advice`` tells the cost with these ``settings``, and what a pilot of a few photons advises. Its
    ``memory`` counts nothing of Python itself.

    Raises :class:`SettingError` and :class:`RefusedError`.
    """
    if method is None and (sensor is not None or settings):
        raise SettingError("a sensor and settings are of a method: give method")
    return Inspection(_nephroid.inspect(checked_scene(scene), wish(sensor, method, settings)))


@dataclass(frozen=True, eq=False)
class LightPath:
    """One path of light to a point."""

    #: As ``LTTD``: light, two refractions, the receiver.
    signature: str
    #: Pointwise irradiance [W/m²].
    irradiance: _Numbers
    #: The part of light that goes this way.
    throughput: _Numbers
    #: The start, all surfaces on the way, and the point: (n, 3).
    points: _Numbers
    #: Ids of the shapes on the way.
    shapes: list[str]
    #: ``R``, ``T`` or ``passed``, of each shape.
    events: list[str]
    #: Receiver area per light.
    jacobian: float
    #: True if the image is turned over.
    folded: bool
    #: First-order distance to the fold [m]; None without one.
    fold_distance: float | None


@dataclass(frozen=True)
class Probe:
    """All specular paths to one point, as ``nephroid probe --json`` has them."""

    #: All that is known, by name.
    report: dict[str, Any]

    @property
    def irradiance(self) -> _Numbers:
        """Pointwise irradiance [W/m²] by all paths together."""
        return _numbers(self.report["irradiance"])

    @property
    def position(self) -> _Numbers:
        """The point in the world."""
        return _numbers(self.report["position"])

    @property
    def normal(self) -> _Numbers:
        """The surface's normal there."""
        return _numbers(self.report["normal"])

    @property
    def complete(self) -> bool:
        """True if nothing ended the search before it had looked everywhere."""
        return bool(self.report["complete"])

    @property
    def paths(self) -> list[LightPath]:
        """The paths, by signature, then the brightest first."""
        return [self._path(path) for path in self.report["paths"]]

    def _path(self, path: dict[str, Any]) -> LightPath:
        met = path["vertices"]
        return LightPath(
            signature=path["signature"],
            irradiance=_numbers(path["irradiance"]),
            throughput=_numbers(path["throughput"]),
            points=_numbers([path["origin"], *(one["position"] for one in met), self.report["position"]]),
            shapes=[one["shape"] for one in met],
            events=[one["event"] for one in met],
            jacobian=path["jacobian"],
            folded=path["folded"],
            fold_distance=path["fold_distance"],
        )

    def __repr__(self) -> str:
        state = "" if self.complete else ", incomplete"
        return f"<nephroid.Probe {len(self.report['paths'])} paths{state}>"

    def _repr_html_(self) -> str:
        rows = [
            (one.signature, " ".join(f"{channel:.6g}" for channel in one.irradiance), ", ".join(one.shapes))
            for one in self.paths
        ]
        u, v = self.report["uv"]
        return _table(f"u, v = {u}, {v}" + ("" if self.complete else ", incomplete"), ("path", "W/m²", "met"), rows)


def probe(
    scene: Scene,
    at: tuple[float, float],
    sensor: str | None = None,
    *,
    max_depth: int | None = None,
    shading_normals: str | None = None,
    refine: int | None = None,
    rays: int | None = None,
    time: float | str | timedelta | None = None,
    threads: int | None = None,
    progress: Callback | None = None,
) -> Probe:
    """All specular paths to one point, by root finding: ``at`` is (u, v) of the sensor's shape, each in 0..=1.

    Settings are those of ``nephroid probe``. If ``progress`` returns False, the search ends incomplete.

    Raises :class:`SettingError` and :class:`RefusedError`.
    """
    given = {"max_depth": max_depth, "shading_normals": shading_normals, "refine": refine, "rays": rays, "time": time}
    u, v = at
    return Probe(
        _nephroid.probe(checked_scene(scene), (float(u), float(v)), wish(sensor, None, given, threads), progress)
    )


@dataclass(frozen=True)
class Stage:
    """A stage of a technique."""

    name: str
    #: The variant that is set.
    variant: str
    #: Its twin without error.
    exact: str


@dataclass(frozen=True, eq=False)
class Shares:
    """A figure of error, shared out among the stages: ``whole`` is the sum of ``shares`` and ``residual``."""

    figure: str
    #: The figure with all stages as they are set.
    whole: float
    #: The figure with all stages exact.
    residual: float
    #: What each stage adds: Shapley's values.
    shares: _Numbers
    #: Standard errors of the shares; zero if all orders were taken.
    standard_errors: _Numbers
    #: The figure with this stage exact.
    fixed: _Numbers
    #: The figure with all others exact.
    spoiled: _Numbers
    #: The figure with this stage and all before it exact.
    cumulative: _Numbers


@dataclass(frozen=True)
class Attribution:
    """Which stage of a technique makes its error, as ``nephroid attribute --json`` has it."""

    #: All that is known, by name.
    report: dict[str, Any]

    @property
    def stages(self) -> list[Stage]:
        """In the order of the pipeline."""
        return [Stage(**one) for one in self.report["stages"]]

    @property
    def figures(self) -> dict[str, Shares]:
        """All figures that are defined for all runs, the headline first."""
        return {one["figure"]: self._shares(one) for one in self.report["figures"]}

    def _shares(self, found: dict[str, Any]) -> Shares:
        def column(name: str) -> _Numbers:
            return _numbers([one[name] for one in found["stages"]])

        return Shares(
            figure=found["figure"],
            whole=found["whole"],
            residual=found["residual"],
            shares=column("value"),
            standard_errors=column("standard_error"),
            fixed=column("fixed"),
            spoiled=column("spoiled"),
            cumulative=column("cumulative"),
        )

    @property
    def light(self) -> str:
        """The light that the technique models, by which it is judged."""
        return str(self.report["light"])

    @property
    def not_modelled(self) -> float:
        """The part of the light from mirrors and glass that is not modelled; NaN if it is not known."""
        found = self.report["not_modelled"]
        return float("nan") if found is None else float(found)

    @property
    def truth_error(self) -> float | None:
        """The truth's own likely error, relative."""
        found = self.report["truth_error"]
        return None if found is None else float(found)

    @property
    def resolved(self) -> bool:
        """True if the truth is as good as was asked for. If not, figures below its error say nothing."""
        return bool(self.report["is_resolved"])

    def __repr__(self) -> str:
        state = "" if self.resolved else ", unresolved"
        return f"<nephroid.Attribution {self.report['approximation']} of {self.light}{state}>"

    def _repr_html_(self) -> str:
        stages, parts = self.stages, []
        for shares in self.figures.values():
            rows = [
                (stage.name, stage.variant, f"{share:+.4g}", f"{fixed:.4g}", f"{spoiled:.4g}")
                for stage, share, fixed, spoiled in zip(stages, shares.shares, shares.fixed, shares.spoiled, strict=True)
            ]
            rows.append(("all exact", "", f"{shares.residual:+.4g}", "", ""))
            caption = f"{shares.figure} {shares.whole:.4g}" + ("" if self.resolved else ", unresolved")
            parts.append(_table(caption, ("stage", "variant", "adds", "if it is exact", "if alone"), rows))
        return "".join(parts)


def attribute(
    scene: Scene,
    method: str | None = None,
    settings: Mapping[str, object] | None = None,
    sensor: str | None = None,
    truth: str | None = None,
    error: float | str | None = None,
    time: float | str | timedelta | None = None,
    side: int | None = None,
    threads: int | None = None,
    progress: Callback | None = None,
    *,
    cache: str | os.PathLike[str] | None = None,
    memory: int | None = None,
) -> Attribution | None:
    """Shares out the error of a technique among its stages. ``settings`` are the technique's.

    The ``truth`` is made by beams, or by photons, to a likely relative ``error`` (by default 0.3 %), for ``time`` [s] at
    most. Runs are made on a sensor whose longer side has ``side`` texels at least.

    ``progress`` is called about every 100 ms with the run under way; if it returns False, the result is None.

    Raises :class:`SettingError` and :class:`RefusedError`.
    """
    limits = settings_as_text({"truth": truth, "error": error, "time": time, "side": side})
    asked = wish(sensor, method, settings or {}, threads, None, cache, memory)
    found = _nephroid.attribute(checked_scene(scene), asked, limits, progress)
    return None if found is None else Attribution(found)
