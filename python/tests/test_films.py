"""Films are those of the program, and share their memory with arrays."""

from __future__ import annotations

import gc
import pickle
import subprocess

import numpy as np
import pytest

import nephroid as ne
from conftest import SCENES, SMALL_VIEW, assert_same

METHODS = [
    ("glass-ball.xml", None, {"error": 0.05}),
    ("glass-ball.xml", "photons", {"photons": 65536, "seed": 3}),
    ("glass-ball.xml", "closed-form", {}),
    ("glass-ball.xml", "caustic-map", {"map": 64}),
    ("cornell-glass.xml", None, {"photons": 16384}),
    ("cornell-glass.xml", "path", {"spp": 4}),
    ("cornell-glass.xml", "full", {"spp": 4, "photons": 65536}),
    ("cornell-glass.xml", "photon-map", {"photons": 65536}),
]


@pytest.mark.parametrize(("name", "method", "settings"), METHODS)
def test_films_are_the_files_of_the_program(program, tmp_path, name, method, settings):
    scene = ne.load_file(SCENES / name, size=24)
    film = ne.render(scene, method=method, **settings)
    ours, theirs = tmp_path / "ours.exr", tmp_path / "theirs.exr"
    film.save(ours)
    given = [f"--set={key}={value}" for key, value in settings.items()]
    way = [] if method is None else ["--method", method]
    command = [program, "render", str(SCENES / name), "-D", "size=24", *way, *given, "-o", str(theirs)]
    subprocess.run(command, check=True, capture_output=True)
    compared = ne.compare(ours, theirs)
    assert compared.verdict == "equivalent"
    assert _channels(ours) == _channels(theirs)


def _channels(path):
    """All channels of an EXR: its bytes after the header, which holds the program's timing. Offsets of blocks depend on
    the header's length, so that only what follows their table is compared."""
    data = path.read_bytes()
    at = 8
    while data[at] != 0:
        at = data.index(b"\0", data.index(b"\0", at) + 1) + 1
        at += 4 + int.from_bytes(data[at : at + 4], "little")
    at += 1
    first = int.from_bytes(data[at : at + 8], "little")
    assert at < first < len(data)
    return data[first:]


def test_arrays_are_the_films_memory():
    film = ne.render(ne.load_file(SCENES / "glass-ball.xml", size=16), photons=4096)
    for name in film.layers:
        array = film[name].value
        assert array.__array_interface__["data"][0] == film._address(name)
        assert film[name].value.__array_interface__["data"][0] == film._address(name)
        assert array.dtype == np.float64 and array.shape == film.shape == (16, 16, 3)
    assert film.value.__array_interface__["data"][0] == film._address("E")


def test_arrays_cannot_be_written_to():
    film = ne.render(ne.load_file(SCENES / "glass-ball.xml", size=8), photons=4096)
    for array in (film.value, film.stderr, film.lo, film.hi):
        assert not array.flags.writeable
        with pytest.raises(ValueError):
            array[0, 0, 0] = 1
        with pytest.raises(ValueError):
            array.setflags(write=True)


def test_an_array_outlives_its_film():
    film = ne.render(ne.load_file(SCENES / "glass-ball.xml", size=64), photons=65536)
    array, copy = film["LTTD"].value, film["LTTD"].value.copy()
    del film
    gc.collect()
    other = ne.render(ne.load_file(SCENES / "glass-ball.xml", size=64), photons=65536, seed=1)
    assert np.array_equal(array, copy) and not np.array_equal(array, other["LTTD"].value)


def test_bars_hold_values():
    film = ne.render(ne.load_file(SCENES / "glass-ball.xml", size=16), error=0.05)
    assert film.method == "beams" and film.complete and film.stderr is None
    assert (film.lo <= film.value).all() and (film.value <= film.hi).all()
    total = sum(film[name].value for name in film.layers[1:])
    np.testing.assert_allclose(total, film.value, rtol=1e-12)
    assert film.ledger["rows"]["LTTD"]["received"][0] > 30
    assert film.settings
    assert "LTTD" in film and "nothing" not in film and len(film) == len(list(film))
    with pytest.raises(KeyError, match="there are E"):
        film["nothing"]


def test_no_number_of_threads_changes_a_bit():
    scene = ne.load_file(SCENES / "glass-ball.xml", size=16)
    one, three = (ne.render(scene, photons=16384, threads=threads) for threads in (1, 3))
    assert one.value.tobytes() == three.value.tobytes() and one.stderr.tobytes() == three.stderr.tobytes()


def test_shards_are_the_run_in_one_piece():
    scene = ne.load_file(SCENES / "glass-ball.xml", size=16)
    parts = [ne.shard(scene, i, 3, photons=65536) for i in (1, 2, 3)]
    merged, whole = ne.merge(scene, parts, photons=65536), ne.render(scene, photons=65536)
    for name in whole.layers:
        assert merged[name].value.tobytes() == whole[name].value.tobytes()
        assert merged[name].stderr.tobytes() == whole[name].stderr.tobytes()
    with pytest.raises(ne.Error):
        ne.merge(scene, parts[:2], photons=65536)


@pytest.mark.parametrize(
    "method, settings",
    [
        ("path", {"spp": 4, "replicates": 2}),
        ("photon-map", {"photons": 8192, "replicates": 2, "map_photons": 1024, "seen": "anyhow", "sensor": "eye"}),
    ],
)
def test_shards_of_paths_and_photon_maps_are_the_run_in_one_piece(method, settings):
    scene = ne.load_string(SMALL_VIEW)
    parts = [ne.shard(scene, i, 3, method=method, **settings) for i in (3, 1, 2)]
    merged, whole = ne.merge(scene, parts, **settings), ne.render(scene, method=method, **settings)
    assert merged.method == whole.method == method
    assert_same(merged, whole)
    with pytest.raises(ne.Error, match="needs each of them once"):
        ne.merge(scene, parts[:2], **settings)


def test_a_method_that_is_made_in_one_piece_says_so():
    with pytest.raises(ne.RefusedError, match="path, photon-map: a run of closed-form is made in one piece"):
        ne.shard(ne.load_file(SCENES / "glass-ball.xml", size=8), 1, 2, method="closed-form")


def test_a_scene_goes_through_pickle():
    scene = ne.load_string((SCENES / "glass-ball.xml").read_text(), size=8)
    again = pickle.loads(pickle.dumps(scene))
    assert again.content_hash == scene.content_hash and again.sensors == scene.sensors


def test_notebooks_see_a_picture_and_a_table():
    film = ne.render(ne.load_file(SCENES / "glass-ball.xml", size=8), photons=4096)
    assert film._repr_png_().startswith(b"\x89PNG")
    assert "LTTD" in film._repr_html_() and "data:image/png" in film._repr_html_()


def test_comparisons_take_films_arrays_and_files(tmp_path):
    scene = ne.load_file(SCENES / "glass-ball.xml", size=16)
    film = ne.render(scene, photons=65536)
    film.save(tmp_path / "film.exr")
    assert ne.compare(film, tmp_path / "film.exr").verdict == "equivalent"
    assert ne.compare(film.value * 2, film, margin=0.01).verdict == "different"


def test_methods_have_their_settings():
    methods = ne.methods()
    assert {"beams", "photons", "path", "full"} <= set(methods)
    assert "max_depth" in [row["name"] for row in methods["beams"]["settings"]]


def test_errors_have_types():
    scene = ne.load_file(SCENES / "glass-ball.xml", size=8)
    with pytest.raises(ne.SettingError, match="fotons") as caught:
        ne.render(scene, fotons=3)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, ne.Error)
    with pytest.raises(ne.RefusedError, match="floor"):
        ne.render(scene, sensor="nowhere")
    with pytest.raises(ne.SettingError, match="1..=1024"):
        ne.render(scene, threads=0)
    with pytest.raises(ne.LoadError) as caught:
        ne.load_file(SCENES / "glass-ball.xml", size="x")
    assert caught.value.file.endswith("glass-ball.xml") and caught.value.line > 1 and caught.value.column > 0
    assert caught.value.path is None
    with pytest.raises(ne.LoadError) as caught:
        ne.load_file("nowhere.xml")
    assert (caught.value.line, caught.value.file) == (0, "nowhere.xml")
    assert "nowhere.xml" in str(pickle.loads(pickle.dumps(caught.value)))
    with pytest.raises(TypeError, match="load_dict"):
        ne.render({"type": "scene"})


@pytest.mark.parametrize(
    "settings",
    [
        {"error": "0.5%"},
        {"method": "beams", "error": "0.1%"},
        {"method": "path", "sensor": "eye", "filter": "box", "error": "20%"},
    ],
)
def test_a_run_step_by_step_in_parts_of_any_order_has_the_bits_of_one(settings):
    scene = ne.load_string(SMALL_VIEW) if "sensor" in settings else ne.load_file(SCENES / "glass-ball.xml", size=16)
    run, steps, counts = ne.RunInParts(scene, **settings), set(), set()
    while not isinstance(step := run.next(), ne.Film):
        assert run.next() == step
        step = pickle.loads(pickle.dumps(step))
        count = min(3, step.most_parts)
        counts.add(count)
        for i in range(count, 0, -1):
            part = step.part(scene, i, count)
            with pytest.raises(ne.Error):
                run.add(part, 1, count + 1)
            run.add(part, i, count)
        steps.add(step)
    whole = ne.render(scene, **{"method": "photons", **settings})
    assert len(steps) > 1 or "method" in settings
    assert max(counts) > 1
    assert_same(step, whole)
