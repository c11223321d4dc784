"""Studies in Python are those of the program."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import signal
import subprocess
import threading
import time

import numpy as np
import pytest

import nephroid as ne
from conftest import ROOT, SCENES

GLASS = SCENES / "glass-ball.xml"

STUDY = f"""
scene = "{GLASS}"
define = {{ size = 24 }}
[truth]
method = "beams"
error = "1%"
[[method]]
method = "photons"
photons = [4096, 65536]
"""

#: More photons than any test waits for.
ENDLESS = 1 << 36


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path


def _validated(program, folder, *arguments):
    done = subprocess.run([program, "validate", *map(str, arguments), "-o", str(folder)], capture_output=True, text=True)
    return done.returncode, done.stderr


def test_a_report_is_the_programs_to_the_byte(program, tmp_path, study):
    report = ne.validate(study, tmp_path / "ours")
    code, said = _validated(program, tmp_path / "theirs", study)
    assert code == 0, said
    theirs = (tmp_path / "theirs/report.json").read_bytes()
    assert (tmp_path / "ours/report.json").read_bytes() == theirs
    assert report.report == json.loads(theirs) and report.complete and report.kept and not report.poses
    assert report.path == tmp_path / "ours/index.html" and report.path.read_text().startswith("<!")
    assert [row.label for row in report.rows] == ["photons=4096", "photons=65536"]


def test_films_that_the_program_made_are_found_again(program, tmp_path, study):
    _validated(program, tmp_path / "r", study)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "r/runs").iterdir()}
    report = ne.validate(study, tmp_path / "r")
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "r/runs").iterdir()} == before
    code, said = _validated(program, tmp_path / "r", study)
    assert code == 0 and said.count("kept from before") == 3, said
    assert len(report.rows) == 2


def test_rows_have_the_reports_numbers(tmp_path, study):
    report = ne.validate(study, tmp_path / "r")
    for row, told in zip(report.rows, report.report["sensors"][0]["rows"], strict=True):
        light = next(one for one in told["comparison"]["layers"] if one["layer"] == row.layer)["fidelity"]
        assert isinstance(row.error, float) and row.error == told["error"] == row.l1.value == light["l1"]["value"]
        assert (row.energy.value, row.energy.low, row.energy.high) == tuple(light["energy"].values())
        assert float(row.displaced) == light["displaced"]["texels"]["value"]
        assert float(row.resolution) == light["resolution"]["texels"]["value"]
        assert float(row.misplaced) == light["misplaced"]["value"] and row.l1.low < row.error < row.l1.high
        assert (row.flip, row.ssim) == (told["picture"]["flip"], told["picture"]["ssim"])
        assert row.truth_error == told["truth_error"] and row.resolved == told["resolved"]
        assert row.counters["photons"] == int(row.settings["photons"]) and row.seconds > 0
        # The figures are those of the film beside the report.
        truth = tmp_path / "r" / report.report["sensors"][0]["truth"]["file"]
        assert ne.compare(truth, row.film).layers[0]["fidelity"] == told["comparison"]["layers"][0]["fidelity"]
        assert row.pose is None and row.checks == [] and row.sensor == "floor" and row.name == row.method == "photons"
    assert report.rows[1].error < report.rows[0].error
    assert report.answers["photons"][0].startswith("At best (photons=65536)")
    page = report._repr_html_()
    assert "photons=4096" in page and report.answers["photons"][0].split(",")[0] in page
    assert "2 rows" in repr(report)


def test_films_arrays_and_files_are_candidates_with_limits(tmp_path, study):
    scene = ne.load_file(GLASS, size=24)
    film = ne.render(scene, photons=65536, seed=5)
    film.save(tmp_path / "file.exr")
    report = ne.validate(
        study,
        tmp_path / "r",
        candidates={"film": film, "array@floor": 0.5 * film.value, "file": tmp_path / "file.exr"},
        max_error={"film": "5%", "array": 0.05, "array:energy": "60%", "photons:displaced": "2texels"},
    )
    rows = {row.name: row for row in report.rows if row.method is None}
    assert rows["film"].error == rows["file"].error < 0.05
    assert rows["array"].energy.value == pytest.approx(rows["film"].energy.value / 2, rel=1e-6)
    assert rows["array"].error == pytest.approx(0.5, abs=0.05) and math.isnan(rows["array"].seconds)
    assert rows["film"].counters == {} and rows["array"].checks != [] == rows["film"].checks
    verdicts = {(gate.name, gate.figure): gate.verdict for gate in report.gates}
    assert verdicts == {
        ("film", "l1"): "kept",
        ("array", "l1"): "exceeded",
        ("array", "energy"): "kept",
        ("photons", "displaced"): "kept",
    }
    assert report.complete and not report.kept and "exceeded" in report._repr_html_()
    assert "not all limits kept" in repr(report)
    gate = next(one for one in report.gates if one.unit == "texels")
    assert gate.most == 2.0 and gate.error.value < 2.0


SHORT = {
    "margin": 0.02,
    "truth": {"method": "beams", "error": "1%"},
    "method": [{"method": "photons", "photons": [4096, 1 << 16]}],
}


def test_a_dict_is_a_study_of_a_file_or_of_a_scene_that_is_read_already(program, monkeypatch, tmp_path, study):
    monkeypatch.chdir(tmp_path)
    study.write_text("margin = 0.02\n" + STUDY)
    told = ne.validate(study, "told")
    for scene in (GLASS, str(GLASS), ne.load_file(GLASS, size=24)):
        params = {} if isinstance(scene, ne.Scene) else {"size": 24}
        report = ne.validate({"scene": scene, **SHORT}, threads=1, **params)
        assert report.folder == (tmp_path / "out/glass-ball.report").relative_to(tmp_path)
        assert report.report == told.report and report.report["study"]["margin"] == 0.02
        assert report.report["study"]["define"] == [["size", "24"]]
    # All three are one scene, whose films were made once.
    assert len(list((tmp_path / "out/glass-ball.report/runs").glob("*.exr"))) == 3
    # A text has other contents than the file, but the same light.
    scene = ne.load_string(GLASS.read_text(), size=24)
    with pytest.raises(ne.SettingError, match="give folder"):
        ne.validate({"scene": scene, **SHORT})
    report = ne.validate({"scene": scene, **SHORT}, "text")
    assert [row.l1 for row in report.rows] == [row.l1 for row in told.rows]


def test_paths_of_a_dict_are_relative_to_the_working_folder(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(SCENES, tmp_path / "scenes")
    film = ne.render(ne.load_file(GLASS, size=8), photons=4096)
    film.save("mine.exr")
    study = {"scene": "scenes/glass-ball.xml", **SHORT, "candidate": [{"name": "mine", "file": "mine.exr", "seconds": 2.5}]}
    row = ne.validate(study, "r", size=8).rows[-1]
    assert (row.name, row.method, row.seconds) == ("mine", None, 2.5)


def test_dicts_that_are_no_study_say_where(tmp_path):
    scene = ne.load_file(GLASS, size=8)
    for one in (scene, GLASS):
        with pytest.raises(ne.LoadError, match="sede") as found:
            ne.validate({"scene": one, "sede": 3}, tmp_path)
        assert (found.value.file, found.value.line) == ("<study>", 2)
    with pytest.raises(ne.SettingError, match='"scene" is a Scene'):
        ne.validate({"truth": {"method": "beams"}}, tmp_path)
    with pytest.raises(ne.SettingError, match="poses is of a scene's file"):
        ne.validate({"scene": scene, "poses": [{"size": 8}]}, tmp_path)
    with pytest.raises(ne.SettingError, match="truth.error is None"):
        ne.validate({"scene": scene, "truth": {"method": "beams", "error": None}}, tmp_path)


def test_a_study_of_poses_has_their_reports(program, tmp_path, study):
    text = STUDY.replace("[truth]", "poses = [{ size = [8, 16] }]\n[truth]")
    study.write_text(text)
    report = ne.validate(study, tmp_path / "r", max_error={"photons": "90%"})
    assert [row.pose for row in report.rows] == [1, 1, 2, 2] and len(report.poses) == 2
    assert report.path.name == "poses.md" and report.path.exists()
    assert [one.report["study"]["define"] for one in report.poses] == [[["size", "8"]], [["size", "16"]]]
    assert report.rows[2] == next(iter(ne.validate(study, tmp_path / "r").poses[1]._rows(2)))
    assert report.kept and len(report.gates) == 2
    code, said = _validated(program, tmp_path / "p", study)
    assert code == 0, said
    assert report.report == json.loads((tmp_path / "p/poses.json").read_text())
    with pytest.raises(ne.SettingError, match="one pose"):
        ne.validate(study, tmp_path / "r", candidates={"mine": np.ones((8, 8, 3))})


def test_a_pose_whose_time_was_over_is_not_complete(tmp_path, study):
    text = STUDY.replace("[truth]", 'time = "0.001s"\nposes = [{ size = [8, 16] }]\n[truth]')
    study.write_text(text)
    report = ne.validate(study, tmp_path / "r")
    # The first truth is made in any case, and nothing after it.
    assert len(report.poses) == 1 and not report.complete and not report.poses[0].complete


def test_several_sensors_are_filled(tmp_path):
    scene = ne.load_file(SCENES / "coffee-cup.xml", size=8)
    assert len(scene.sensors) == 2
    study = {"scene": scene, "truth": {"method": "photons", "photons": 8192}, "method": [{"method": "photons", "photons": 1024}]}
    report = ne.validate(study, tmp_path / "r", sensors=scene.sensors)
    assert list(dict.fromkeys(row.sensor for row in report.rows)) == scene.sensors
    assert any(name.startswith(f"{scene.sensors[1]}/") for name in report.answers)
    one = ne.validate(study, tmp_path / "r1", sensors=scene.sensors[1])
    assert {row.sensor for row in one.rows} == {scene.sensors[1]}


def test_a_callback_hears_of_the_runs_stops_them_and_they_go_on_later(tmp_path, study):
    study.write_text(STUDY.replace("65536", str(ENDLESS)))
    heard = []

    def callback(progress):
        heard.append((progress.done, progress.expected, progress.unit, progress.name, progress.run.done))
        return progress.run.expected != ENDLESS or progress.run.done == 0

    assert ne.validate(study, tmp_path / "r", progress=callback) is None
    assert heard[-1][:4] == (2, 3, "runs", f"photons={ENDLESS}")
    assert not (tmp_path / "r/report.json").exists()
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "r/runs").iterdir()}
    study.write_text(STUDY)
    bar = type("Bar", (), {"total": None, "n": 0, "refresh": lambda self: None})()
    report = ne.validate(study, tmp_path / "r", progress=ne.tell(bar))
    assert (bar.n, bar.total) == (3, 3) and len(report.rows) == 2
    assert {path: path.stat().st_mtime_ns for path in before} == before


def test_a_study_can_be_stopped_while_it_is_judged(tmp_path, study):
    study.write_text(STUDY.replace("size = 24", "size = 256").replace("[4096, 65536]", "[1024, 2048, 4096, 8192]"))
    names = []

    def callback(progress):
        names.append(progress.name)
        return not progress.name.startswith("judging")

    assert ne.validate(study, tmp_path / "r", progress=callback) is None
    assert names[-1].startswith("judging"), names
    assert not (tmp_path / "r/report.json").exists()


def test_an_exception_of_a_callback_arrives_as_it_is(tmp_path, study):
    class Mine(Exception):
        pass

    def callback(progress):
        raise Mine

    study.write_text(STUDY.replace("65536", str(ENDLESS)))
    with pytest.raises(Mine):
        ne.validate(study, tmp_path / "r", progress=callback)


def test_ctrl_c_ends_a_study_within_a_second(tmp_path, study):
    study.write_text(STUDY.replace("65536", str(ENDLESS)))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    sent = []

    def interrupt():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(2.0, interrupt)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            ne.validate(study, tmp_path / "r")
        assert time.monotonic() - sent[0] < 1.0
    finally:
        timer.cancel()
        signal.signal(signal.SIGINT, before)
    assert not (tmp_path / "r/report.json").exists()


def test_a_study_whose_time_is_over_is_not_complete(tmp_path, study):
    study.write_text('time = "0.001s"\n' + STUDY)
    report = ne.validate(study, tmp_path / "r")
    assert not report.complete and report.rows == [] and "2 runs were not made" in report.warnings[-1]


def test_studies_that_cannot_be_made_are_refused(monkeypatch, tmp_path, study):
    monkeypatch.chdir(tmp_path)

    def refused(error, says, subject=study, **given):
        with pytest.raises(error, match=says):
            ne.validate(subject, tmp_path / "r", **given)
        assert not (tmp_path / "r/index.html").exists()

    refused(ne.LoadError, "nowhere.toml", "nowhere.toml")
    refused(ne.LoadError, "nowhere.xml", "nowhere.xml")
    (tmp_path / "wrong.toml").write_text('scene = "x.xml"\nsede = 3\n')
    with pytest.raises(ne.LoadError) as found:
        ne.validate(tmp_path / "wrong.toml")
    assert (found.value.line, found.value.column) == (2, 1) and found.value.file.endswith("wrong.toml")
    assert "sede" in found.value.message
    refused(ne.RefusedError, "nowhere", sensors="nowhere")
    refused(ne.SettingError, "did you mean \"photons\"", max_error={"fotons": "5%"})
    refused(ne.SettingError, "allowed are NAME", max_error={"photons": "five"})
    refused(ne.SettingError, "allowed are NAME", candidates={"@floor": "a.exr"})
    refused(ne.SettingError, "margin", margin=0.0)
    refused(ne.SettingError, "repeats", repeats=0)
    refused(ne.SettingError, "threads", threads=0)
    refused(ne.SettingError, "parameters already", ne.load_file(GLASS, size=8), size=9)
    refused(ne.Error, "nowhere.exr", candidates={"mine": "nowhere.exr"})
    refused(ne.Error, "24 x 24", candidates={"mine": np.ones((8, 24, 3))})
    refused(TypeError, "pass the dict|load_dict", {"type": "scene"})
    study.write_text(STUDY.replace('"beams"', '"path"').replace('error = "1%"', "spp = 4"))
    refused(ne.RefusedError, "starts at cameras")


def test_the_documents_examples_run(monkeypatch, tmp_path):
    """All of docs/python.md, one block after the other, as a reader would paste them."""
    shutil.copytree(SCENES, tmp_path / "scenes")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/python.md").read_text(), re.S)
    assert len(blocks) >= 2
    # One of them is for a file of its own, which other processes read again.
    names: dict[str, object] = {"__name__": "__main__"}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
