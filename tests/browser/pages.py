"""Reports in a real browser: they load without a word, sort, filter, answer, and bar nobody.

Usage: python tests/browser/pages.py PROGRAM [FOLDER]

Needs Chromium and the packages of .ci/browser.txt; says so and ends well where one is missing. Pictures of the pages
are left in FOLDER.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

CHROMIUM = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]
ROOT = Path(__file__).resolve().parents[2]


def main() -> int:
    try:
        from axe_playwright_python.sync_playwright import Axe
        from playwright.sync_api import sync_playwright
    except ImportError as missing:
        print(f"browser: {missing.name} is not installed; pages are not tested")
        return 0
    if CHROMIUM is None:
        print("browser: there is no Chromium; pages are not tested")
        return 0
    program, pictures = Path(sys.argv[1]).resolve(), Path(sys.argv[2]) if len(sys.argv) > 2 else None
    with tempfile.TemporaryDirectory() as home, sync_playwright() as playwright:
        pages = made(program, Path(home))
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        for name, path in pages.items():
            for width in (1280, 390):
                for scheme in ("light", "dark"):
                    page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
                    said: list[str] = []
                    page.on("console", lambda message: said.append(message.text))
                    page.on("pageerror", lambda error: said.append(str(error)))
                    page.on("request", lambda request: said.append(request.url) if request.url[:5] not in ("file:", "data:") else None)
                    page.goto(path.as_uri())
                    found = Axe().run(page).response["violations"]
                    bad = [f["id"] for f in found if f["impact"] in ("serious", "critical")]
                    wide = page.evaluate("document.documentElement.scrollWidth")
                    assert not said, f"{name}: {said}"
                    assert not bad, f"{name}, {width} px, {scheme}: axe says {bad}"
                    assert wide <= width, f"{name}: {wide} px wide at {width} px"
                    if pictures:
                        pictures.mkdir(exist_ok=True)
                        page.screenshot(path=pictures / f"{name}-{width}-{scheme}.png", full_page=True)
                    page.close()
        answers(browser.new_page(viewport={"width": 1280, "height": 900}), pages["sweep"], program, Path(home))
        speaks(browser.new_page(viewport={"width": 1280, "height": 900}), pages["replay"])
        silent(browser.new_context(java_script_enabled=False).new_page(), pages["sweep"])
        browser.close()
    print(f"browser: {len(pages)} pages at two widths, light and dark")
    return 0


def made(program: Path, home: Path) -> dict[str, Path]:
    """Folders of reports, each with a page."""
    traces = home / "traces"
    traces.mkdir()
    shutil.copy(ROOT / "traces" / "demo.bin", traces)
    run = lambda *words: subprocess.run([program, *words, "--quiet"], cwd=home, check=True)
    run("sweep", "gscore-units", "--traces", "traces/demo.bin", "--out", "sweep", "--confirm", "0")
    run("replay", "traces/demo.bin", "--out", "replay")
    run("compare", "gscore", "neo", "traces/demo.bin", "--across-nodes", "--out", "compare")
    run("sensitivity", "gscore", "traces/demo.bin", "--assumptions", "--only", "A26", "--out", "sensitivity")
    pages = {"sweep": "sweep/analysis", "replay": "replay", "compare": "compare", "sensitivity": "sensitivity"}
    return {name: home / folder / "report.html" for name, folder in pages.items()}


def answers(page, path: Path, program: Path, home: Path) -> None:
    """What the page of a sweep does."""
    page.goto(path.as_uri())
    count = lambda: page.locator(".explorer output").inner_text()
    dots = page.locator(".scatter circle")
    everything = dots.count()
    assert everything > 100, everything
    dot = page.locator(".scatter circle.front").last
    dot.hover()
    tip = page.locator(".tip").inner_text()
    assert tip.startswith("#") and "vru.cores: " in tip, tip
    dot.click()
    # The command of a design is one that runs, and its machine file is one.
    command, machine = (page.locator(".card pre").nth(i).inner_text() for i in range(2))
    words = command.replace("'", "").replace(" demo.bin", " traces/demo.bin").split(" --set ")
    words = [*words[0].split(), *(w for setting in words[1:] for w in ("--set", setting))]
    subprocess.run([program, *words[1:], "--quiet", "--out", home / "design"], cwd=home, check=True)
    (home / "design.toml").write_text(machine)
    subprocess.run([program, "arch", "check", home / "design.toml"], check=True, stdout=subprocess.DEVNULL)
    lines = (home / "design" / "results.csv").read_text().splitlines()
    frame = lines[0].split(",").index("frame_time_ms.mean") if "frame_time_ms.mean" in lines[0].split(",") else None
    assert len(lines) > 1 and (frame is None or float(lines[-1].split(",")[frame]) > 0)
    for text, is_less in [("vru.cores >= 4", True), ("frame_time_ms.p99 <= 500 us && area_mm2.core < 6", True),
                          ("sorters == 'lean' || !(sorters == 'lean')", False), ("buffers.feature.capacity <= 64 KiB", True)]:
        page.fill("#where", text)
        assert (dots.count() < everything) == is_less and dots.count() > 0, f"{text}: {count()}"
    for text, wanted in [("vru.cores >=", "missing"), ("cors > 1", "no column"), ("fps.mean > 3 parsec", "no unit"), ("(1", "missing")]:
        page.fill("#where", text)
        assert wanted in count(), f"{text}: {count()}"
    page.fill("#where", "")
    assert dots.count() == everything
    brush = page.locator(".parallel .brush").first
    brush.scroll_into_view_if_needed()
    box = brush.bounding_box()
    page.mouse.move(box["x"] + 8, box["y"] + box["height"] * 0.6)
    page.mouse.down()
    page.mouse.move(box["x"] + 8, box["y"] + box["height"] * 0.95)
    page.mouse.up()
    assert 0 < dots.count() < everything, count()
    heads = page.locator("table").first.locator("th .sort")
    for _ in range(2):
        before = page.locator("table tbody").first.inner_text()
        heads.nth(1).click()
    assert page.locator("table tbody").first.inner_text() != before, "a second click turns the order"


def speaks(page, path: Path) -> None:
    """Marks of charts say what they are where the pointer is, bars by name, series and value."""
    page.goto(path.as_uri())
    marks = page.locator("figure .wide rect:has(title)")
    assert marks.count() > 50, marks.count()
    heard = []
    for mark in marks.all()[::10]:
        mark.scroll_into_view_if_needed()
        heard.append(mark.evaluate("""mark => {
            const box = mark.getBoundingClientRect();
            const hit = document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2);
            return hit.querySelector("title")?.textContent ?? "";
        }"""))
    assert all(heard) and any("dram · " in words for words in heard), heard


def silent(page, path: Path) -> None:
    """Without scripts tables and charts are there, and a line says what is not."""
    page.goto(path.as_uri())
    assert page.locator("figure").count() > 2 and page.locator("table").count() > 1
    assert "need scripts" in page.locator("noscript").first.text_content()
    assert not page.locator(".explorer").is_visible()


if __name__ == "__main__":
    sys.exit(main())
