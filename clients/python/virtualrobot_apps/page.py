"""Pages of reports: one HTML file of tables, which needs no other file and no script."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 78em; margin: 2em auto; padding: 0 1em; color: #222 }
div { overflow-x: auto } table { border-collapse: collapse; margin: 1em 0 }
th, td { padding: .2em .6em; border-bottom: 1px solid #ddd; white-space: nowrap; text-align: left }
td.number { text-align: right; font-variant-numeric: tabular-nums } th { vertical-align: bottom }
.about td { text-align: left }
h2 { margin-top: 2em; border-top: 2px solid #4477aa } summary { cursor: pointer; color: #4477aa }
pre { background: #f5f5f5; padding: .5em; overflow: auto } rect { fill: #4477aa }
figure { display: inline-block; margin: 1em 1em 1em 0; vertical-align: top } text { font-size: 12px }
"""
_NUMBER = re.compile(r"[-+.\de ]+( to [-+.\de]+)?")


def page_head(title: str) -> str:
    """Return the beginning of a page; its end is `</html>`."""
    name = html.escape(title)
    about = f'<meta charset="utf-8"><title>{name}</title><style>{STYLE}</style>'
    return f'<!doctype html><html lang="en">{about}<h1>{name}</h1>'


def html_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table; what is a number stands on the right."""
    row = "".join(f"<th>{html.escape(one)}</th>" for one in heads)
    body = "".join(f"<tr>{''.join(map(_field, row))}</tr>" for row in rows)
    return f"<div><table><tr>{row}</tr>{body}</table></div>"


def _field(text: str) -> str:
    kind = ' class="number"' if _NUMBER.fullmatch(text) else ""
    return f"<td{kind}>{html.escape(text)}</td>"
