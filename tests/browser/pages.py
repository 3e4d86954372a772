"""Reports in a real browser: they load without a word, sort, filter, answer, and bar nobody.

Usage: python tests/browser/pages.py PROGRAM [FOLDER]

Needs Chromium and the packages of .ci/browser.txt; says so and ends well where one is missing. Pictures of the pages
are left in FOLDER.
"""

import base64
import csv
import json
import shlex
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
        scales(browser, pages["replay"])
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
    # The command of a design gives the numbers of its row, and so does its machine file.
    command, machine = (page.locator(".card pre").nth(i).inner_text() for i in range(2))
    (home / "design.toml").write_text(machine)
    of_file = machine.splitlines()[0].removeprefix("# ").replace(" FILE", " design.toml")
    point = page.locator(".card h3").inner_text().split(" ")[0].removeprefix("#")
    with open(home / "sweep" / "results.csv", encoding="utf-8") as file:
        row = next(r for r in csv.DictReader(file) if (r["point"], r["scope"]) == (point, "mean"))
    for line in (command, of_file):
        words = [str(program), *shlex.split(line)[1:], "--what-if", "0", "--json", "--quiet", "--out", "design", "--force"]
        said = json.loads(subprocess.run(words, cwd=home, check=True, capture_output=True).stdout)
        seen = (said["aggregate"]["frame_time_ms"]["mean"], said["aggregate"]["power_w"]["total"]["mean"])
        assert seen == (float(row["frame_time_ms.mean"]), float(row["power_w.mean"])), f"{line}: {seen}"
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


def scales(browser, path: Path) -> None:
    """A heat map has the colours of its scale, the same in the light and in the dark, and text can be read in both."""
    seen = {}
    for scheme in ("light", "dark"):
        page = browser.new_page(viewport={"width": 1280, "height": 900}, color_scheme=scheme)
        page.goto(path.as_uri())
        chart = page.locator("figure .wide svg:has(image)").last
        chart.scroll_into_view_if_needed()
        places, contrast = chart.evaluate("""svg => {
            const home = svg.getBoundingClientRect();
            const middle = e => { const b = e.getBoundingClientRect(); return [b.x + b.width / 2 - home.x, b.y + b.height / 2 - home.y]; };
            const bands = [...svg.querySelectorAll('rect[width="22"]')].map(middle);
            const map = [...svg.querySelectorAll("image")].pop().getBoundingClientRect(), tiles = [];
            for (let i = 0; i < 12; i++) for (let j = 0; j < 12; j++)
                tiles.push([map.x - home.x + map.width * (i + .5) / 12, map.y - home.y + map.height * (j + .5) / 12]);
            const light = text => {
                const linear = text.match(/\\d+/g).slice(0, 3).map(v => v / 255).map(v => v <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4);
                return .2126 * linear[0] + .7152 * linear[1] + .0722 * linear[2];
            };
            const paper = light(getComputedStyle(svg.querySelector("rect")).fill);
            const contrasts = [...svg.querySelectorAll('text[fill^="var("]')].map(e => {
                const [a, b] = [light(getComputedStyle(e).fill), paper].sort((a, b) => b - a);
                return (a + .05) / (b + .05);
            });
            return [{bands, tiles}, Math.min(...contrasts)];
        }""")
        assert len(places["bands"]) == 50, f"{scheme}: {len(places['bands'])} bands"
        assert contrast >= 4.5, f"{scheme}: text has a contrast of {contrast:.1f}"
        shot = base64.b64encode(chart.screenshot()).decode()
        blank = browser.new_page()
        seen[scheme] = blank.evaluate("""async ([shot, places]) => {
            const image = new Image();
            image.src = "data:image/png;base64," + shot;
            await image.decode();
            const canvas = document.createElement("canvas");
            [canvas.width, canvas.height] = [image.width, image.height];
            const context = canvas.getContext("2d");
            context.drawImage(image, 0, 0);
            const colour = ([x, y]) => [...context.getImageData(Math.round(x), Math.round(y), 1, 1).data].slice(0, 3);
            return Object.fromEntries(Object.entries(places).map(([name, all]) => [name, all.map(colour)]));
        }""", [shot, places])
        blank.close()
        page.close()
    apart = lambda a, b: max(abs(x - y) for x, y in zip(a, b))
    for name in ("bands", "tiles"):
        worst = max(apart(a, b) for a, b in zip(seen["light"][name], seen["dark"][name]))
        assert worst <= 2, f"{name} are other colours in the dark: {worst}"
    for scheme, colours in seen.items():
        # Neighbouring bands differ by up to 30; what is between them is of the scale.
        lost = [tile for tile in colours["tiles"] if min(apart(tile, band) for band in colours["bands"]) > 20]
        assert not lost, f"{scheme}: {lost[0]} is not on the scale"


def silent(page, path: Path) -> None:
    """Without scripts tables and charts are there, and a line says what is not."""
    page.goto(path.as_uri())
    assert page.locator("figure").count() > 2 and page.locator("table").count() > 1
    assert "need scripts" in page.locator("noscript").first.text_content()
    assert not page.locator(".explorer").is_visible()


if __name__ == "__main__":
    sys.exit(main())
