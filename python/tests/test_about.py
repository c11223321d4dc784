"""Questions about a scene have the answers of the program."""

from __future__ import annotations

import importlib.metadata
import json
import os
import signal
import subprocess
import threading
import time

import numpy as np
import pytest

import nephroid as ne
from conftest import SCENES

GLASS = SCENES / "glass-ball.xml"


def _told(program, *arguments):
    done = subprocess.run([program, *map(str, arguments), "--json"], check=True, capture_output=True)
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", ["glass-ball.xml", "cornell-glass.xml", "water.xml"])
def test_inspection_is_the_programs(program, name):
    found = ne.inspect(ne.load_file(SCENES / name, size=16))
    told = _told(program, "inspect", SCENES / name, "-D", "size=16")
    assert found.report == told
    assert found.costs() == told["sensors"][0]["costs"] and found.costs()
    assert list(found.suits()) == told["sensors"][0]["suits"]
    assert len(found.requirements) == sum(one["needed"] for one in told["requirements"]) > 0
    assert next(iter(found.requirements)) in found._repr_html_()


def test_advice_is_the_programs_but_for_its_own_memory(program):
    scene = ne.load_file(GLASS, size=16)
    found = scene.inspect(method="caustics-volume", sensor="floor", slabs=2)
    way = ["--method", "caustics-volume", "--sensor", "floor", "--set", "slabs=2"]
    told = _told(program, "inspect", GLASS, "-D", "size=16", *way)
    ours, theirs = found.advice, told["advice"]
    assert theirs["lines"] and theirs["memory"]["program"] > 0 == ours["memory"]["program"]
    theirs["memory"]["bytes"] -= theirs["memory"].pop("program")
    ours["memory"].pop("program")
    assert found.report == told


def test_inspections_that_cannot_be_are_refused():
    scene = ne.load_file(GLASS, size=8)
    with pytest.raises(ne.SettingError, match="caustic-map"):
        scene.inspect(method="nothing")
    with pytest.raises(ne.SettingError, match="slobs"):
        scene.inspect(method="caustics-volume", slobs=2)
    with pytest.raises(ne.SettingError, match="give method"):
        scene.inspect(sensor="floor")
    with pytest.raises(ne.RefusedError, match="nowhere"):
        scene.inspect(method="beams", sensor="nowhere")
    with pytest.raises(ne.SettingError, match="there are floor"):
        scene.inspect().costs("nowhere")


def test_probed_paths_are_the_programs(program):
    found = ne.probe(ne.load_file(GLASS), at=(0.57, 0.52), max_depth=2)
    told = _told(program, "probe", GLASS, "--at", "0.57,0.52", "--max-depth", "2")
    assert found.report == told
    assert found.complete and [one.signature for one in found.paths].count("LTTD") == 3
    np.testing.assert_allclose(sum(one.irradiance for one in found.paths), found.irradiance, rtol=1e-12)
    refracted = next(one for one in found.paths if one.signature == "LTTD")
    assert refracted.points.shape == (4, 3) and (refracted.points[-1] == found.position).all()
    assert refracted.shapes == ["ball", "ball"] and refracted.events == ["T", "T"]
    assert "LTTD" in found._repr_html_()


def test_probes_that_cannot_be_are_refused():
    scene = ne.load_file(GLASS, size=8)
    with pytest.raises(ne.SettingError, match="not on the receiver"):
        ne.probe(scene, at=(2, 0.5))
    with pytest.raises(ne.SettingError, match="refine"):
        ne.probe(scene, at=(0.5, 0.5), refine=7)
    with pytest.raises(ne.RefusedError, match="nowhere"):
        ne.probe(scene, at=(0.5, 0.5), sensor="nowhere")
    with pytest.raises(ne.RefusedError, match="area"):
        ne.probe(ne.load_file(SCENES / "cornell-glass.xml", size=8), at=(0.5, 0.5))


def test_a_probe_ends_if_its_callback_says_so():
    # The middle of the floor is a focus: this search has far more rays than a test has time.
    scene = ne.load_file(GLASS, size=8)
    start = time.monotonic()
    found = ne.probe(scene, at=(0.5, 0.5), refine=3, rays=1 << 40, time=30, progress=lambda _: False)
    assert time.monotonic() - start < 5
    assert not found.complete and found.report["search"] == "stopped"


ATTRIBUTED = {"settings": {"map": 64, "photons": 64}, "side": 16, "error": 0.05}


@pytest.mark.parametrize("truth", ["beams", "photons"])
def test_attributed_errors_are_the_programs(program, truth):
    scene = ne.load_file(GLASS, size=32)
    found = ne.attribute(scene, method="caustic_map", truth=truth, **ATTRIBUTED)
    way = ["--method", "caustic-map", "--set", "map=64", "--set", "photons=64", "--side", "16", "--error", "5%", "--truth", truth]
    told = _told(program, "attribute", GLASS, "-D", "size=32", *way)
    assert found.report == told and told["size"] == [16, 16]
    assert [one.name for one in found.stages] == [one["name"] for one in told["stages"]]
    assert next(iter(found.figures)) == "l1"
    for shares in found.figures.values():
        assert shares.whole == pytest.approx(shares.shares.sum() + shares.residual, rel=1e-9, abs=1e-12)
        assert len(shares.fixed) == len(shares.spoiled) == len(shares.cumulative) == len(found.stages)
    assert found.resolved and found.stages[0].name in found._repr_html_()


def test_attributions_that_cannot_be_are_refused():
    scene = ne.load_file(GLASS, size=8)
    for wrong in ({"truth": "paths"}, {"error": 0}, {"side": 0}, {"method": "beams"}, {"settings": {"mop": 3}}):
        with pytest.raises(ne.SettingError):
            ne.attribute(scene, **wrong)
    with pytest.raises(ne.RefusedError, match="nowhere"):
        ne.attribute(scene, sensor="nowhere")


def test_an_attribution_ends_if_its_callback_says_so():
    scene = ne.load_file(GLASS, size=128)
    start = time.monotonic()
    assert ne.attribute(scene, error=1e-6, time=30, progress=lambda _: False) is None
    assert time.monotonic() - start < 10


@pytest.mark.parametrize("what", ["probe", "attribute"])
def test_ctrl_c_ends_questions_within_a_second(what):
    scene = ne.load_file(GLASS, size=128)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    sent = []

    def interrupt():
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    threading.Timer(0.5, interrupt).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            if what == "probe":
                ne.probe(scene, at=(0.5, 0.5), refine=6, rays=1 << 40, time=30)
            else:
                ne.attribute(scene, error=1e-6, time=30)
        assert time.monotonic() - sent[0] < 1.0
    finally:
        signal.signal(signal.SIGINT, before)


def test_the_wheel_has_the_licences_of_all_its_parts():
    names = {one.name for one in importlib.metadata.files("nephroid") or [] if "licenses" in one.parts}
    assert names == {"LICENSE-APACHE", "LICENSE-MIT", "LICENSE-SKY"}
