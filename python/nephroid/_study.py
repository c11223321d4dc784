"""What does less error cost? Methods swept over their settings, judged by a truth."""

from __future__ import annotations

import html
import json
import math
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np

from . import _nephroid
from ._about import _table
from ._compare import _side
from ._errors import SettingError
from ._nephroid import Film, Scene, StudyProgress
from ._text import checked_scene, is_of_mitsuba, parameters, text

StudyCallback = Callable[[StudyProgress], object]


def _json(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def _number(value: Any) -> float:
    """A number; NaN if it is not known."""
    return float("nan") if value is None else float(value)


@dataclass(frozen=True)
class Bounded:
    """A figure, and what the truth's own bars allow."""

    value: float
    low: float
    high: float

    @staticmethod
    def _of(found: dict[str, Any] | None) -> Bounded | None:
        return None if found is None else Bounded(*(_number(found[key]) for key in ("value", "low", "high")))

    def __float__(self) -> float:
        return self.value


@dataclass(frozen=True)
class Row:
    """A run or a candidate, judged by the truth. A number that is not known is NaN."""

    #: The sensor's id.
    sensor: str
    #: The name of its curve, or of the candidate.
    name: str
    #: The name with the settings that are not defaults.
    label: str
    #: The method; None of a candidate.
    method: str | None
    #: Settings that are not defaults, as text.
    settings: dict[str, str]
    #: The layer of light by which it is judged.
    layer: str
    #: L1: the sum of absolute differences over the truth's sum.
    error: float
    #: The truth's own error in the same terms.
    truth_error: float
    #: True if the truth is good enough to know ``error`` by.
    resolved: bool
    #: Flux over the truth's.
    energy: Bounded | None
    #: ``error``, with what the truth's bars allow.
    l1: Bounded | None
    #: The part of the light in a wrong texel, at equal flux.
    misplaced: Bounded | None
    #: How far light is from its place, on average [texels].
    displaced: Bounded | None
    #: The smallest square over which means are right to 10 % [texels].
    resolution: Bounded | None
    #: Mean HDR-FLIP of the picture with all light.
    flip: float
    #: SSIM of that picture.
    ssim: float
    #: Median time of the run [s].
    seconds: float
    #: The film.
    film: Path
    #: Signs of a mistake rather than an approximation, in sentences.
    checks: list[str]
    #: The pose, from 1; None of a study without poses.
    pose: int | None
    #: All that is known, as report.json has it.
    report: dict[str, Any] = field(repr=False)

    @property
    def counters(self) -> dict[str, int]:
        """Counted work by name, the same on every machine; empty of a candidate."""
        facts = self.report["facts"] or {"counters": []}
        return {str(one["name"]): int(one["count"]) for one in facts["counters"]}


@dataclass(frozen=True)
class Gate:
    """A limit on a figure."""

    #: The sensor's id.
    sensor: str
    #: The curve or candidate.
    name: str
    #: The figure, as ``l1``.
    figure: str
    #: The largest that it may be, in ``unit``.
    most: float
    #: ``fraction``, ``texels`` or ``metres``.
    unit: str
    #: The figure.
    error: Bounded | None
    #: ``kept``, ``undecided`` or ``exceeded``.
    verdict: str


@dataclass(frozen=True)
class Report:
    """A study's figures, read from the files of its folder."""

    #: The folder of the report and its films.
    folder: Path
    #: False if the study's time was over before its end.
    complete: bool
    #: All figures, as report.json has them; of a study with poses those over all poses, as poses.json has them.
    report: dict[str, Any] = field(repr=False)
    #: All that is never the same twice, as timings.json has it; empty of a study with poses.
    timings: dict[str, Any] = field(repr=False)
    #: The reports of the poses, each in a folder of its own.
    poses: list[Report] = field(repr=False)

    @staticmethod
    def _read(folder: Path) -> Report:
        found = _json(folder / "report.json")
        return Report(folder, found["left_out"] == 0, found, _json(folder / "timings.json"), [])

    @staticmethod
    def _read_poses(folder: Path, complete: bool) -> Report:
        found = _json(folder / "poses.json")
        poses = [Report._read(folder / one["folder"]) for one in found["poses"]]
        return Report(folder, complete, found, {}, poses)

    @property
    def path(self) -> Path:
        """The report to look at: a page, or a text of a study with poses."""
        return self.folder / ("poses.md" if self.poses else "index.html")

    @property
    def rows(self) -> list[Row]:
        """All runs and candidates, sensor by sensor."""
        if self.poses:
            return [row for pose, one in enumerate(self.poses, 1) for row in one._rows(pose)]
        return self._rows(None)

    def _rows(self, pose: int | None) -> list[Row]:
        sensors = zip(self.report["sensors"], self.timings["sensors"], strict=True)
        return [
            self._row(sensor["sensor"], row, time, pose)
            for sensor, timed in sensors
            for row, time in zip(sensor["rows"], timed["rows"], strict=True)
        ]

    def _row(self, sensor: str, row: dict[str, Any], time: dict[str, Any], pose: int | None) -> Row:
        layers: list[dict[str, Any]] = row["comparison"]["layers"]
        light: dict[str, Any] = next((one["fidelity"] for one in layers if one["layer"] == row["layer"]), {})
        picture = row["picture"] or {}
        lengths = {key: (light.get(key) or {}).get("texels") for key in ("displaced", "resolution")}
        return Row(
            sensor=sensor,
            name=row["name"],
            label=row["label"],
            method=row["method"],
            settings=dict(row["settings"]),
            layer=row["layer"],
            error=_number(row["error"]),
            truth_error=_number(row["truth_error"]),
            resolved=bool(row["resolved"]),
            energy=Bounded._of(light.get("energy")),
            l1=Bounded._of(light.get("l1")),
            misplaced=Bounded._of(light.get("misplaced")),
            displaced=Bounded._of(lengths["displaced"]),
            resolution=Bounded._of(lengths["resolution"]),
            flip=_number(picture.get("flip")),
            ssim=_number(picture.get("ssim")),
            seconds=_number(time["median"]),
            film=self.folder / row["file"],
            checks=[str(one["message"]) for one in row["checks"]],
            pose=pose,
            report=row,
        )

    @property
    def gates(self) -> list[Gate]:
        """Limits, and whether they are kept."""
        if self.poses:
            return [gate for one in self.poses for gate in one.gates]
        return [
            Gate(
                sensor=sensor["sensor"],
                name=gate["name"],
                figure=gate["limit"]["figure"],
                most=float(gate["limit"]["most"]),
                unit=gate["limit"]["unit"],
                error=Bounded._of(gate["error"]),
                verdict=gate["verdict"],
            )
            for sensor in self.report["sensors"]
            for gate in sensor["gates"]
        ]

    @property
    def kept(self) -> bool:
        """True if all limits are kept, whatever the truth's bars allow."""
        return all(gate.verdict == "kept" for gate in self.gates)

    @property
    def answers(self) -> dict[str, list[str]]:
        """How wrong each curve is at its best, where, why, and what less error costs, in sentences. Curves of a study of
        several sensors are called ``SENSOR/NAME``; a study with poses has none of its own."""
        if self.poses:
            return {}
        sensors: list[dict[str, Any]] = self.report["sensors"]
        name = "{sensor}/{name}" if len(sensors) > 1 else "{name}"
        return {
            name.format(sensor=sensor["sensor"], name=one["name"]): list(one["sentences"])
            for sensor in sensors
            for one in sensor["answers"]
        }

    @property
    def warnings(self) -> list[str]:
        """Oddities of the scene and the study."""
        if self.poses:
            return list(dict.fromkeys(warning for one in self.poses for warning in one.warnings))
        return list(self.report["warnings"])

    def __repr__(self) -> str:
        state = ("" if self.complete else ", incomplete") + ("" if self.kept else ", not all limits kept")
        return f"<nephroid.Report {self.path}: {len(self.rows)} rows{state}>"

    def _repr_html_(self) -> str:
        def percent(value: float) -> str:
            return "" if math.isnan(value) else f"{100 * value:.3g} %"

        def of(figure: Bounded | None, shown: Callable[[float], str]) -> str:
            return "" if figure is None else shown(figure.value)

        rows = [
            (
                row.sensor if row.pose is None else f"{row.pose}: {row.sensor}",
                row.label,
                of(row.energy, percent),
                percent(row.error) + ("" if row.resolved else " (not resolved)"),
                of(row.displaced, "{:.3g}".format),
                "" if math.isnan(row.seconds) else f"{row.seconds:.3g}",
            )
            for row in self.rows
        ]
        head = ("sensor", "run", "energy", "L1", "displaced [texels]", "seconds")
        limits = [(gate.sensor, gate.name, gate.figure, f"{gate.most:g} {gate.unit}", gate.verdict) for gate in self.gates]
        parts = [_table(str(self.path), head, rows)]
        if limits:
            parts.append(_table("limits", ("sensor", "name", "figure", "limit", "verdict"), limits))
        for name, sentences in self.answers.items():
            parts.append(f"<p><b>{html.escape(name)}</b>: {html.escape(' '.join(sentences))}</p>")
        parts += [f"<p>{html.escape(one)}</p>" for one in self.warnings]
        return "".join(parts)


def _toml(value: object, key: str) -> str:
    """A value of a study as its file has it. Whatever is neither a list nor a table is a text there."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_quoted(str(name))} = {_toml(one, f'{key}.{name}')}" for name, one in value.items()) + " }"
    if isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str):
        return "[" + ", ".join(_toml(one, key) for one in value) + "]"
    if isinstance(value, timedelta):
        return _quoted(f"{value.total_seconds()!r}s")
    # Numbers as text have all of their digits, and are read as text anyway.
    return _quoted(text(os.fspath(value) if isinstance(value, os.PathLike) else value, key))


def _quoted(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _study(given: Mapping[str, object]) -> tuple[str | os.PathLike[str] | Scene, str]:
    """The scene of a study, and the text of its file."""
    scene = given.get("scene")
    if not isinstance(scene, (Scene, str, os.PathLike)):
        raise SettingError('a study is a dict with the keys of a study.toml: "scene" is a Scene or the path of one')
    if isinstance(scene, Scene):
        wrong = [key for key in ("define", "poses") if key in given]
        if wrong:
            raise SettingError(f"a Scene has its parameters already; {wrong[0]} is of a scene's file")
    path = scene.path if isinstance(scene, Scene) else os.path.abspath(scene)
    lines = [f"{_quoted(key)} = {_toml(value, key)}" for key, value in {**given, "scene": path}.items()]
    return scene, "\n".join(lines)


def _file(name: str, image: Any, folder: Path) -> str:
    """The file of a candidate; films and arrays get one."""
    if isinstance(image, (str, os.PathLike)):
        return os.fspath(image)
    path = folder / f"{len(list(folder.iterdir()))}.exr"
    if isinstance(image, Film):
        image.save(path)
    else:
        path.write_bytes(_nephroid.exr(_side(image, name)))
    return os.fspath(path)


def validate(
    study: str | os.PathLike[str] | Scene | Mapping[str, object],
    folder: str | os.PathLike[str] | None = None,
    sensors: str | Sequence[str] | None = None,
    candidates: Mapping[str, Any] | None = None,
    max_error: Mapping[str, float | str] | None = None,
    margin: float | None = None,
    repeats: int | None = None,
    threads: int | None = None,
    progress: StudyCallback | None = None,
    *,
    cache: str | os.PathLike[str] | None = None,
    **params: object,
) -> Report | None:
    """Fills sensors by a truth and by methods over their settings, judges each film, and writes a report.

    ``study`` is a ``study.toml``; or a dict with its keys, in which ``scene`` may be a Scene; or a scene (its file, or a
    Scene), which has a default study. The report goes into ``folder``, by default ``out/NAME.report``. Runs whose films are there already are not made again, whether they were
    made by Python or by ``nephroid validate``.

    ``candidates`` are images to be judged, too: an EXR, a Film or an array by name, or by ``"NAME@SENSOR"`` if there are
    several sensors. ``max_error`` limits figures of methods and candidates, as
    ``{"mine": 0.05, "mine:displaced": "2texels"}``; ``kept`` of the report says whether they are kept. ``params`` are the
    values of ``$name`` in the scene file.

    ``progress`` is called about every 100 ms with a :class:`StudyProgress`; if it returns False, the result is None, and
    the same call goes on from there. Ctrl-C raises KeyboardInterrupt within a second.

    Raises :class:`LoadError`, :class:`SettingError` and :class:`RefusedError`.
    """
    with _asked(study, folder, sensors, candidates, max_error, margin, repeats, threads, cache, params) as asked:
        subject, place, given = asked
        found = _nephroid.validate(subject, os.fspath(place), given, progress)
    return None if found is None else _read(place, found)


def _read(folder: Path, found: tuple[bool, bool]) -> Report:
    """The report that was written into a folder."""
    complete, is_of_poses = found
    return Report._read_poses(folder, complete) if is_of_poses else Report._read(folder)


@contextmanager
def _asked(
    study: str | os.PathLike[str] | Scene | Mapping[str, object],
    folder: str | os.PathLike[str] | None,
    sensors: str | Sequence[str] | None,
    candidates: Mapping[str, Any] | None,
    max_error: Mapping[str, float | str] | None,
    margin: float | None,
    repeats: int | None,
    threads: int | None,
    cache: str | os.PathLike[str] | None,
    params: Mapping[str, object],
) -> Iterator[tuple[str | os.PathLike[str] | Scene, Path, _nephroid._StudyWish]]:
    """The subject of a study, its folder, and the wish for it as the compiled half takes it. Candidates without a file have
    one meanwhile."""
    if is_of_mitsuba(study, "Scene") or (isinstance(study, dict) and "type" in study):
        checked_scene(study)
    source = None
    if isinstance(study, Mapping):
        study, source = _study(study)
    if threads is not None and not 1 <= threads <= 1024:
        raise SettingError(f'threads is "{threads}"; allowed are whole numbers 1..=1024')
    if repeats is not None and not 1 <= repeats <= 1000:
        raise SettingError(f'repeats is "{repeats}"; allowed are whole numbers 1..=1000')
    if margin is not None and not 0 < margin < math.inf:
        raise SettingError(f'margin is "{margin}"; allowed are numbers > 0')
    if isinstance(study, Scene) and params:
        raise SettingError(f"a Scene has its parameters already; give {', '.join(params)} to load_file or load_string")
    if folder is None:
        path = study.path if isinstance(study, Scene) else os.fspath(study)
        if path.startswith("<"):
            raise SettingError("a scene without a file has no name for its report: give folder")
        folder = _nephroid.default_folder(path)
    if isinstance(sensors, str):
        sensors = [sensors]
    with tempfile.TemporaryDirectory() as images:
        wish: _nephroid._StudyWish = {
            "define": parameters(params),
            "sensors": list(sensors or ()),
            "candidates": [(name, _file(name, one, Path(images))) for name, one in (candidates or {}).items()],
            "max_error": [(name, text(most, f"max_error of {name}")) for name, most in (max_error or {}).items()],
            "margin": margin,
            "repeats": repeats,
            "threads": threads,
            "cache": None if cache is None else os.fspath(cache),
            "study": source,
        }
        yield study, Path(folder), wish
