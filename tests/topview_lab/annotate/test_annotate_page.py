"""The page in a real browser, used as a user would."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from browser import Browser
from conftest import Marked
from topview_lab.annotate.automatic import FindOptions
from topview_lab.annotate.joints import JointBasis
from topview_lab.annotate.landmarks import NAMES
from topview_lab.annotate.server import AnnotationServer
from topview_lab.annotate.session import Session
from topview_lab.datasets import read_groundtruth

KNEE, HEAD, ELBOW = (NAMES.index(name) for name in ("knee_l", "head", "elbow_l"))


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Browser]:
    browser = Browser(tmp_path / "chromium")
    yield browser
    browser.close()


def on_page(browser: Browser, view: str, pixel: tuple[float, float]) -> tuple[float, float]:
    """Where a pixel of a video is on the page."""
    x, y = browser.js(
        f"(() => {{ const p = new DOMPoint({pixel[0]}, {pixel[1]})"
        f".matrixTransform($('svg-{view}').getScreenCTM()); return [p.x, p.y]; }})()"
    )
    return x, y


def marker(browser: Browser, view: str, joint: int, side: int = 0) -> tuple[float, float]:
    """Where a marker's dot is on the page."""
    return browser.middle(f"#svg-{view} .marker[data-j='{joint}'][data-s='{side}']")


def test_a_user_annotates_a_recording(
    marked: Marked,
    browser: Browser,
    serve: Callable[[Session], AnnotationServer],
    tmp_path: Path,
) -> None:
    out = tmp_path / "out"
    session = Session(marked.front, marked.rear, out, FindOptions())
    server = serve(session)
    browser.open(server.url)
    browser.until("state && $('hint').textContent.includes('Click the middle')")

    # click a wall by mistake, then a marker; then find all
    browser.click(*on_page(browser, "front", (250, 90)))
    browser.until("$('toast').textContent.includes('nearly grey')")
    browser.click(*on_page(browser, "front", marked.pixel("torso")))
    browser.until("state.looks.length === 1 && document.querySelectorAll('.spot').length > 12")
    browser.press("#next-step")
    browser.until("state.found && tracks && !state.job.running")
    assert browser.js("state.job.error") == ""
    assert browser.js("document.querySelectorAll('#svg-front .marker').length") >= 12

    # drag a marker, delete another, interpolate a third one's joint
    before = browser.js(f"pixelAt('front', 0, 0, {KNEE}, 0)")
    x, y = marker(browser, "front", KNEE)
    browser.drag((x, y), (x + 18, y))
    browser.until("state.changes.length === 1")
    after = browser.js(f"pixelAt('front', 0, 0, {KNEE}, 0)")
    assert after[0] > before[0] + 10
    assert after[1] == pytest.approx(before[1], abs=3)

    browser.click(*marker(browser, "front", HEAD))
    browser.key("Delete")
    browser.until(f"state.changes.length === 2 && !known(pixelAt('front', 0, 0, {HEAD}, 0))")
    assert browser.js(f"seenAt(0, 0, {HEAD})") == JointBasis.ONE_SIDE

    lane = browser.js("(() => { const b = $('lane-canvas').getBoundingClientRect();"
                      "return [b.x, b.y, b.width / state.frames]; })()")  # fmt: skip
    height = lane[1] + 13 * ELBOW + 6
    browser.drag((lane[0] + 10.5 * lane[2], height), (lane[0] + 14.5 * lane[2], height))
    browser.until("$('interpolate') && $('interpolate').textContent === 'Interpolate 5 frames'")
    browser.press("#interpolate")
    browser.until("state.changes.length === 3")
    kinds = browser.js(f"[9, 10, 14, 15].map(f => seenAt(f, 0, {ELBOW}))")
    assert kinds[1:3] == [JointBasis.INTERPOLATED] * 2
    assert JointBasis.INTERPOLATED not in (kinds[0], kinds[3])

    # one change too many, taken back
    browser.click(*marker(browser, "rear", KNEE, 1))
    browser.key("Delete")
    browser.until("state.changes.length === 4")
    browser.press("#undo")
    browser.until("state.changes.length === 3")
    browser.screenshot(tmp_path / "annotated.png")
    assert (tmp_path / "annotated.png").stat().st_size > 50_000

    # everything is there after a reload
    saved = browser.js("JSON.stringify([state.changes, tracks])")
    browser.js("window.isOld = true; location.reload()")
    browser.until("!window.isOld && typeof state !== 'undefined' && state && tracks")
    assert browser.js("JSON.stringify([state.changes, tracks])") == saved

    browser.press("#next-step")
    browser.until("state.accepted")
    assert browser.errors == []
    truth = read_groundtruth(out / "groundtruth.npz")
    assert truth.present.all()

    # and in a process that starts anew
    session.close()
    again = Session(marked.front, marked.rear, out, FindOptions())
    assert again.project.accepted
    assert len(again.project.changes) == 3
    assert again.joints is not None
    own = np.load(out / "groundtruth.npz")["joints"]
    np.testing.assert_allclose(again.joints.places_front, own, atol=1e-5)


def test_nothing_is_cut_off_in_a_narrow_window(
    session: Session, browser: Browser, serve: Callable[[Session], AnnotationServer]
) -> None:
    browser.open(serve(session).url)
    browser.until("typeof state !== 'undefined' && state && tracks")
    for width, height in ((1280, 800), (800, 900), (560, 900)):
        browser.resize(width, height)
        browser.js("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        assert browser.js("document.documentElement.scrollWidth <= innerWidth"), width
        assert browser.js("$('svg-front').getBoundingClientRect().height") >= 150
    assert browser.errors == []
