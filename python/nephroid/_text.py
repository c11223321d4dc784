"""Values as text, as scene files and settings have them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from datetime import timedelta
from typing import TYPE_CHECKING, Any

from ._errors import SettingError
from ._nephroid import Scene

if TYPE_CHECKING:
    from ._nephroid import _Wish


def text(value: object, key: str) -> str:
    """A value as text. Numbers keep all of their digits."""
    if isinstance(value, str):
        return value
    if isinstance(value, timedelta):
        return repr(value.total_seconds())
    # Scalars of NumPy and of drjit.
    if not isinstance(value, (bool, int, float)) and hasattr(value, "item"):
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    raise SettingError(f'{key} is {value!r}; allowed are texts, numbers, booleans and times')


def parameters(params: Mapping[str, object]) -> list[tuple[str, str]]:
    """The parameters of a scene file, as text."""
    return [(key, text(value, key)) for key, value in params.items()]


def settings_as_text(given: Mapping[str, object]) -> list[tuple[str, str]]:
    """Settings as text, those that are None left out. Their names have ``_`` for ``-``."""
    return [(key.replace("_", "-"), text(value, key)) for key, value in given.items() if value is not None]


def wish(
    sensor: str | None,
    method: str | None,
    given: Mapping[str, object],
    threads: int | None = None,
    filter: str | None = None,
    cache: str | os.PathLike[str] | None = None,
    memory: int | None = None,
) -> _Wish:
    """A wish for a run, as the compiled half takes it."""
    if filter not in (None, "box"):
        raise SettingError(f'filter is "{filter}"; allowed are box and None, which is the scene\'s')
    return {
        "sensor": sensor,
        "method": None if method is None else method.replace("_", "-"),
        "settings": settings_as_text(given),
        "is_box": filter == "box",
        "threads": checked_threads(threads),
        "cache": None if cache is None else os.fspath(cache),
        "memory": memory,
    }


def checked_threads(threads: int | None) -> int | None:
    """A number of threads that can be."""
    if threads is not None and not 1 <= threads <= 1024:
        raise SettingError(f'threads is "{threads}"; allowed are whole numbers 1..=1024')
    return threads


def is_of_mitsuba(value: object, *names: str) -> bool:
    """True of an object of one of Mitsuba's classes, of whatever variant: it is asked for by name, not imported."""
    classes = type(value).__mro__
    return any(one.__module__.split(".")[0] == "mitsuba" and one.__name__ in names for one in classes)


def checked_scene(scene: Any) -> Scene:
    """A scene of nephroid; everything else is refused with the way to one."""
    if isinstance(scene, Scene):
        return scene
    if is_of_mitsuba(scene, "Scene"):
        raise TypeError(
            "this is a scene that Mitsuba has loaded, which does not tell what it was made from: pass the dict to "
            "nephroid.load_dict, or the file to nephroid.load_file"
        )
    if isinstance(scene, dict):
        raise TypeError("this is a dict: nephroid.load_dict makes a scene of it")
    raise TypeError(f"a nephroid.Scene is needed, not {type(scene).__name__}: load_file and load_dict make one")
