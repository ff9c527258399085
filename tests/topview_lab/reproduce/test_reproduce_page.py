"""The report's pages: nothing lost between the sections and what a reader sees."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from topview.records import InputError
from topview_lab.metrics import Statistic
from topview_lab.reproduce.catalogue import EXPERIMENTS, chosen
from topview_lab.reproduce.page import Report, as_html, as_markdown
from topview_lab.reproduce.printed import Printed
from topview_lab.reproduce.section import (
    Picture,
    Row,
    Section,
    Table,
    Verdict,
    compared,
    conclusion,
    statistic_cells,
)

FOLDER = Path("somewhere")
SECTION = Section(
    name="table-0.1",
    title="Table 0.1: less & more",
    text=("What was <done>.",),
    tables=(
        Table(
            ("method", "μE, cm"),
            (Row(("thesis: A", "1.00"), "printed"), Row(("ours", "12.50")), Row(("B", ""), "open")),
            "a caption",
            "a foot",
        ),
    ),
    pictures=(Picture(FOLDER / "pictures" / "x.png", "a picture"),),
    verdicts=(
        conclusion("a claim", True, "because"),
        Verdict("behind", "a comparison", "1 > 0"),
        conclusion("an open one", True, "nobody knows", [float("nan")]),
    ),
)
REPORT = Report("A report", ("Before.",), (SECTION,), ("something failed",))


def test_markdown_tables_line_up():
    lines = [line for line in as_markdown(REPORT, FOLDER).splitlines() if line.startswith("|")]
    assert len(lines) == 5
    assert len({len(line) for line in lines}) == 1
    assert re.fullmatch(r"\|-+\|-+:\|", lines[1])


@pytest.mark.parametrize("render", [as_markdown, as_html])
def test_a_page_tells_everything(render):
    page = render(REPORT, FOLDER)
    for told in (
        *("A report", "Before.", "something failed", "12.50", "a caption", "a foot", "a picture"),
        *("pictures/x.png", "a claim", "because", "confirmed", "behind", "open"),
    ):
        assert told in page


def test_html_escapes_what_is_text():
    page = as_html(REPORT, FOLDER)
    assert "<done>" not in page
    assert "less &amp; more" in page


def test_html_refers_to_nothing_outside_of_the_folder():
    page = as_html(REPORT, FOLDER)
    assert "http" not in page
    assert re.findall(r'src="([^"]+)"', page) == ["pictures/x.png"]


@pytest.mark.parametrize(
    ("mean", "within", "word"),
    [
        (4.0, 0.92, "ahead"),
        (4.43, 0.905, "ahead"),
        (4.0, 0.8, "mixed"),
        (5.0, 0.95, "mixed"),
        (5.0, 0.8, "behind"),
        (float("nan"), float("nan"), "open"),
    ],
)
def test_a_comparison_says_who_is_ahead(mean, within, word):
    ours = Statistic(9, mean, 1.0, within)
    assert compared("x", ours, Printed(4.43, 2.97, 0.905), " cm").word == word


def test_the_mean_alone_is_compared_where_no_share_was_printed():
    assert compared("x", Statistic(9, 5.0, 1.0, 0.1), Printed(7.4, 3.7), "°").word == "ahead"


def test_a_conclusion_is_confirmed_or_not():
    assert conclusion("x", True, "", [1.0]).word == "confirmed"
    assert conclusion("x", False, "", [1.0]).word == "not confirmed"
    assert conclusion("x", False, "", [1.0, float("nan")]).word == "open"


def test_numbers_that_are_not_there_are_dashes():
    assert statistic_cells(Statistic(0, *[float("nan")] * 3)) == ("–", "–", "–")
    assert statistic_cells(Printed(7.4, 3.7)) == ("7.40", "3.70", "–")


def test_experiments_are_chosen_by_name_in_the_thesiss_order():
    assert list(chosen(["table-6.1", "figure-3.2"])) == ["figure-3.2", "table-6.1"]
    assert list(chosen([])) == list(chosen(["all"])) == list(EXPERIMENTS)


def test_an_unknown_experiment_is_named_with_those_that_there_are():
    with pytest.raises(InputError, match=r"table-9\.9 is not known.*table-6\.1"):
        chosen(["table-6.1", "table-9.9"])
