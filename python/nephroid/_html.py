"""A film in a notebook."""

from __future__ import annotations

import base64
import html
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._nephroid import Film


def film(film: Film) -> str:
    """A picture of all light beside a table of the layers."""
    picture = base64.b64encode(film.png()).decode()
    rows = []
    for name in film.layers:
        found = film.range(name)
        assert found is not None  # The name is one of the film's.
        low, mean, high, error = found
        bar = "" if error is None else f"{100 * error:.3g} %"
        cells = [html.escape(name), f"{low:.4g}", f"{mean:.4g}", f"{high:.4g}", bar]
        rows.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    warnings = "".join(f"<p>{html.escape(one)}</p>" for one in film.warnings)
    head = "<tr>" + "".join(f"<th>{one}</th>" for one in ("layer", "min", "mean", "max", "rel. error")) + "</tr>"
    caption = html.escape(f"{film.quantity} [{film.unit}] by {film.method}" + ("" if film.complete else ", incomplete"))
    return (
        f'<div><img src="data:image/png;base64,{picture}" alt="{caption}">'
        f"<table><caption>{caption}</caption>{head}{''.join(rows)}</table>{warnings}</div>"
    )
