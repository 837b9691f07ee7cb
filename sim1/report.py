"""Pages for people: one self-contained HTML file with text, tables and pictures, readable on light and dark screens."""

import base64
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A PNG, JPEG or GIF file to be embedded."""

    path: Path
    caption: str = ""


@dataclass(frozen=True, kw_only=True)
class Section:
    """One part of a page. Text is escaped; a `markupsafe.Markup` paragraph is taken as HTML."""

    heading: str
    paragraphs: Sequence[str] = ()
    table: Sequence[
        Mapping[str, Any]
    ] = ()  # rows; columns in order of first appearance, keys are the headings; neighbours
    # `cost | here` and `cost | paper` stand under one heading `cost`
    pictures: Sequence[Picture | Path] = ()


def write_report(path: Path, title: str, lead: str, sections: Sequence[Section]) -> None:
    """Write a page that needs no other file and no network. Same input, same bytes.

    Raises:
        FileNotFoundError: a picture is missing.
        ValueError: a picture is neither PNG, JPEG nor GIF.
    """
    page = _PAGE.render(title=title, lead=lead, sections=[_prepare(section) for section in sections])
    path.write_text(page, encoding="utf-8")


def format_value(value: Any) -> str:
    """A table cell: four significant digits, yes/no, items of a list, a dash for what is not known or an empty list."""
    if isinstance(value, list):
        return ", ".join(map(format_value, value)) or "–"
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    return str(value)


def _prepare(section: Section) -> dict[str, Any]:
    columns = list(dict.fromkeys(key for row in section.table for key in row))
    numeric = {key: all(isinstance(row.get(key), int | float | None) for row in section.table) for key in columns}
    pictures = [item if isinstance(item, Picture) else Picture(path=item) for item in section.pictures]
    return {
        "heading": section.heading,
        "paragraphs": section.paragraphs,
        "headings": _headings(columns, numeric),
        "rows": [[(format_value(row.get(key)), numeric[key]) for key in columns] for row in section.table],
        "pictures": [(_data_uri(item.path), item.caption) for item in pictures],
    }


def _headings(columns: Sequence[str], numeric: Mapping[str, bool]) -> list[list[dict[str, Any]]]:
    """One line of table heads, or two where columns share a heading: name, columns and lines that it spans, whether of numbers."""
    parts = [[word.replace("_", " ") for word in key.split(" | ", 1)] for key in columns]
    if all(len(part) == 1 for part in parts):
        return [
            [{"name": part[0], "across": 1, "down": 1, "number": numeric[key]} for part, key in zip(parts, columns)]
        ]
    upper: list[dict[str, Any]] = []
    for (name, shared), group in itertools.groupby(parts, key=lambda part: (part[0], len(part) == 2)):
        across = len(list(group))
        upper.append({"name": name, "across": across, "down": 1 if shared else 2, "number": False})
    lower = [
        {"name": part[1], "across": 1, "down": 1, "number": numeric[key]}
        for part, key in zip(parts, columns)
        if len(part) == 2
    ]
    return [upper, lower]


def _data_uri(path: Path) -> str:
    kinds = {".png": "png", ".jpg": "jpeg", ".jpeg": "jpeg", ".gif": "gif"}
    kind = kinds.get(path.suffix.lower())
    if kind is None:
        raise ValueError(f"{path}: a report embeds {', '.join(sorted(kinds))} files")
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode()}"


_PAGE = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True).from_string("""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ title }}</title>
<style>
:root { color-scheme: light dark; --ink: #1c2024; --soft: #5b6470; --paper: #ffffff; --line: #d9dee4; --band: #f4f6f8; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8eaed; --soft: #a3adb8; --paper: #15181c; --line: #363d45; --band: #1e2329; }
}
body { margin: 0 auto; max-width: 80rem; padding: 2rem 1.25rem 4rem; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, sans-serif; }
h1 { font-size: 1.8rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.2rem; margin: 2.25rem 0 .5rem; padding-top: .75rem; border-top: 1px solid var(--line); }
p { max-width: 46rem; margin: .5rem 0; }
.lead { font-size: 1.1rem; color: var(--soft); }
.scroll { overflow-x: auto; margin: .75rem 0; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .55rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
th { background: var(--band); font-weight: 600; }
.number { text-align: right; }
th[colspan] { text-align: center; }
figure { margin: 1rem 0; }
img { max-width: 100%; height: auto; background: #ffffff; border-radius: 4px; }
figcaption { color: var(--soft); font-size: .9rem; }
</style>
</head>
<body>
<h1>{{ title }}</h1>
<p class="lead">{{ lead }}</p>
{% for section in sections %}
<section>
<h2>{{ section.heading }}</h2>
{% for paragraph in section.paragraphs %}
<p>{{ paragraph }}</p>
{% endfor %}
{% if section.rows %}
<div class="scroll"><table>
<thead>{% for line in section.headings %}<tr>{% for head in line %}<th{% if head.number %} class="number"{% endif %}\
{% if head.across > 1 %} colspan="{{ head.across }}"{% endif %}{% if head.down > 1 %} rowspan="{{ head.down }}"{% endif %}>\
{{ head.name }}</th>{% endfor %}</tr>{% endfor %}</thead>
<tbody>
{% for row in section.rows %}
<tr>{% for cell, number in row %}<td{% if number %} class="number"{% endif %}>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}
</tbody>
</table></div>
{% endif %}
{% for uri, caption in section.pictures %}
<figure><img src="{{ uri }}" alt="{{ caption or section.heading }}">
{% if caption %}
<figcaption>{{ caption }}</figcaption>
{% endif %}
</figure>
{% endfor %}
</section>
{% endfor %}
</body>
</html>
""")
