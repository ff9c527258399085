"""The report as Markdown and as one HTML page, with the same content."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from topview_lab.reproduce.section import Section, Table, Verdict


@dataclass(frozen=True, slots=True)
class Report:
    """Sections, what goes before them, and what comes after them all."""

    title: str
    preface: tuple[str, ...]
    sections: tuple[Section, ...]
    problems: tuple[str, ...] = ()
    appendix: tuple[Section, ...] = ()

    @property
    def verdicts(self) -> list[Verdict]:
        return [verdict for section in self.sections for verdict in section.verdicts]


def as_markdown(report: Report, folder: Path) -> str:
    """The report's text; pictures are linked relative to `folder`."""
    lines = [f"# {report.title}", "", *_paragraphs(report.preface)]
    for heading, verdicts in _summary(report.verdicts):
        lines += [f"## {heading}", ""]
        lines += [f"- **{v.word}**: {v.claim}: {v.evidence}" for v in verdicts]
        lines.append("")
    if report.problems:
        lines += ["## Problems", "", *(f"- {problem}" for problem in report.problems), ""]
    for section in (*report.sections, *report.appendix):
        lines += [f"## {section.title}", "", *_paragraphs(section.text)]
        for table in section.tables:
            lines += [*_markdown_table(table), ""]
        for picture in section.pictures:
            lines += [f"![{picture.caption}]({_relative(picture.path, folder)})", ""]
            lines += [f"*{picture.caption}*", ""]
    return "\n".join(lines)


def _paragraphs(text: Iterable[str]) -> list[str]:
    return [line for paragraph in text for line in (paragraph, "")]


def _summary(verdicts: Sequence[Verdict]) -> list[tuple[str, list[Verdict]]]:
    groups = {
        "Beside the thesis's numbers": [v for v in verdicts if not v.is_conclusion],
        "The thesis's conclusions, checked": [v for v in verdicts if v.is_conclusion],
    }
    return [(heading, group) for heading, group in groups.items() if group]


def _relative(path: Path, folder: Path) -> str:
    return path.relative_to(folder).as_posix()


def _markdown_table(table: Table) -> list[str]:
    rows = [table.header, *(row.cells for row in table.rows)]
    widths = [max(len(row[c]) for row in rows) for c in range(len(table.header))]

    def line(cells: Sequence[str]) -> str:
        first, *others = (c.ljust(w) if i == 0 else c.rjust(w)
                          for i, (c, w) in enumerate(zip(cells, widths, strict=True)))  # fmt: skip
        return "| " + " | ".join([first, *others]) + " |"

    rule = "|" + "|".join(
        "-" * (w + 2) if i == 0 else "-" * (w + 1) + ":" for i, w in enumerate(widths)
    )
    caption = [f"{table.caption}:", ""] if table.caption else []
    foot = ["", f"*{table.foot}*"] if table.foot else []
    return [*caption, line(rows[0]), f"{rule}|", *(line(row) for row in rows[1:]), *foot]


PAGE_STYLE: Final = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1d2330; max-width: 62rem; margin: 2rem auto;
       padding: 0 1.2rem; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.25rem; margin-top: 2.4rem; }
nav a { margin-right: 1rem; white-space: nowrap; }
a { color: #1f6fb2; }
.scroll { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .93rem; }
caption { text-align: left; font-weight: 600; padding: .3rem 0; }
th, td { padding: .22rem .8rem .22rem 0; text-align: right; }
th { border-bottom: 1.5px solid #1d2330; font-weight: 600; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; padding-right: 1.6rem; }
tr.printed td, tr.open td { color: #6b7280; }
tr.ours td:first-child { font-weight: 600; }
tr.open td:first-child { font-style: italic; }
figure { margin: 1.2rem 0; } figure img { max-width: 100%; }
figcaption, p.foot { color: #6b7280; font-size: .9rem; }
ul.verdicts { list-style: none; padding: 0; }
ul.verdicts li { display: grid; grid-template-columns: 7.5rem 1fr; margin: .3rem 0; }
.word { font-weight: 600; }
.ahead, .confirmed { color: #16794c; } .behind, .not-confirmed { color: #b3261e; }
.mixed { color: #8a6d00; } .open { color: #6b7280; }
@media (prefers-color-scheme: dark) {
  body { background: #14171d; color: #e4e7ec; } th { border-color: #e4e7ec; }
  a { color: #6db3f2; } figure img { background: #fff; }
  .ahead, .confirmed { color: #58c795; }
  .behind, .not-confirmed { color: #ff8a80; } .mixed { color: #e0c15a; }
}
"""


def as_html(report: Report, folder: Path) -> str:
    """The report as one page; pictures are linked relative to `folder`."""
    title = html.escape(report.title)
    links = "".join(
        f'<a href="#{section.name}">{html.escape(section.title.split(":")[0])}</a>'
        for section in (*report.sections, *report.appendix)
    )
    body = [f"<h1>{title}</h1>", *_html_paragraphs(report.preface), f"<nav>{links}</nav>"]
    for heading, verdicts in _summary(report.verdicts):
        body += [f"<h2>{html.escape(heading)}</h2>", '<ul class="verdicts">']
        body += [_html_verdict(verdict) for verdict in verdicts]
        body.append("</ul>")
    if report.problems:
        items = "".join(f"<li>{html.escape(problem)}</li>" for problem in report.problems)
        body.append(f"<h2>Problems</h2><ul>{items}</ul>")
    for section in (*report.sections, *report.appendix):
        body.append(f'<h2 id="{section.name}">{html.escape(section.title)}</h2>')
        body += _html_paragraphs(section.text)
        body += [_html_table(table) for table in section.tables]
        body += [
            f'<figure><img src="{_relative(p.path, folder)}" alt="{html.escape(p.caption)}">'
            f"<figcaption>{html.escape(p.caption)}</figcaption></figure>"
            for p in section.pictures
        ]
    return (
        '<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{PAGE_STYLE}</style></head>\n<body>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )


def _html_paragraphs(text: Iterable[str]) -> list[str]:
    return [f"<p>{html.escape(paragraph)}</p>" for paragraph in text]


def _html_verdict(verdict: Verdict) -> str:
    kind = verdict.word.replace(" ", "-")
    return (
        f'<li><span class="word {kind}">{verdict.word}</span>'
        f"<span>{html.escape(verdict.claim)}: {html.escape(verdict.evidence)}</span></li>"
    )


def _html_table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in table.header)
    rows = "\n".join(
        f'<tr class="{row.kind}">'
        + "".join(f"<td>{html.escape(cell)}</td>" for cell in row.cells)
        + "</tr>"
        for row in table.rows
    )
    caption = f"<caption>{html.escape(table.caption)}</caption>" if table.caption else ""
    foot = f'<p class="foot">{html.escape(table.foot)}</p>' if table.foot else ""
    return (
        f'<div class="scroll"><table>{caption}<thead><tr>{head}</tr></thead>\n'
        f"<tbody>{rows}</tbody></table>{foot}</div>"
    )
