"""The page in a real browser; skipped where there is none."""

import asyncio
import json
import threading
import time
from itertools import product

import browser
import pytest

import gelcone.studio.page
from gelcone.devices.units import parse
from gelcone.studio import look
from gelcone.studio.server import Studio
from gelcone.studio.setting import Shelf

pytestmark = pytest.mark.skipif(browser.find_browser() is None, reason="no Chromium on this machine (Debian: chromium)")
ANSWERED = "window.studio && studio.looks.a && studio.looks.a.lines && true"


class Served:
    """A studio in a thread, at a port of one's choice, which may end and begin again."""

    def __init__(self, port=0, token=None):
        self.studio = Studio(Shelf()) if token is None else Studio(Shelf(), token=token)
        listening = self.studio.listen(port)
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=lambda: self.loop.run_until_complete(self.studio.serve(listening)))
        self.thread.start()

    def close(self):
        self.loop.call_soon_threadsafe(self.studio.stop)
        self.thread.join(10)
        self.loop.close()


@pytest.fixture(scope="module")
def served():
    served = Served()
    yield served
    served.close()


@pytest.fixture(scope="module")
def chromium():
    with browser.Browser() as chromium:
        yield chromium


@pytest.fixture
def page(served, chromium, tmp_path):
    """It is still, for painting what moves takes most of the time."""
    tab = chromium.page
    tab.log.clear()
    tab.size(1280, 800)
    tab.dark(False, still=True)
    tab.go("about:blank")
    tab.send("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    tab.go(served.studio.address("device=biased-pump"))
    tab.wait(ANSWERED)
    yield tab
    assert tab.log == []


def pick(page, selector, value):
    page.js(
        f"(() => {{ const s = document.querySelector('{selector}'); s.value = '{value}';"
        "s.dispatchEvent(new Event('change', {bubbles: true})); })()"
    )


def type_in(page, name, text):
    page.js(
        f"(() => {{ const s = document.querySelector('[data-name=\"{name}\"] input[type=text]'); s.value = '{text}';"
        "s.dispatchEvent(new Event('change', {bubbles: true})); })()"
    )


def words(page):
    return page.js("document.getElementById('badges').innerText")


def test_what_moves_is_painted_and_said_in_words(page):
    assert "Periodic, period 1" in words(page)
    assert "film taut throughout" in words(page)
    for canvas in ("#cone", "#time canvas", "#portrait canvas"):
        colours = page.js(
            f"(() => {{ const c = document.querySelector('{canvas}');"
            "const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; const s = new Set();"
            "for (let i = 0; i < d.length; i += 4) s.add(d[i] + 256 * d[i + 1] + 65536 * d[i + 2]); return s.size })()"
        )
        assert colours > 5, canvas
    page.dark(False)
    page.js("location.reload()")
    page.wait("window.studio && document.getElementById('scrub').value > 0")


def test_the_portrait_switches_between_the_settled_motion_and_the_run_from_the_start(page):
    pressed = "document.querySelector('#motion [aria-pressed=true]').textContent"
    assert page.js(pressed) == "settled"
    size = "(() => { const c = document.querySelector('#portrait canvas').getContext('2d');"
    size += "const p = c.getImageData(0, 0, c.canvas.width, c.canvas.height).data; let n = 0;"
    size += "for (let i = 0; i < p.length; i += 4) n += p[i] < 60 && p[i + 2] > 120; return n })()"
    settled = page.js(size)
    page.click("#motion [data-motion=start]")
    page.wait("location.hash.includes('motion=start')")
    assert page.js(pressed) == "from the start"
    assert settled > 200 > page.js(size)  # the orbit in full colour is gone
    page.js("history.back()")
    page.wait(pressed + " === 'settled'")


@pytest.mark.slow
def test_every_control_is_answered(page):
    names = page.js("[...document.querySelectorAll('#groups [role=tab]')].map((t) => t.textContent)")
    moved = 0
    for group in names:
        page.js(f"document.getElementById('tab-{group}').click()")
        for name in page.js("[...document.querySelectorAll('.control.number')].map((c) => c.dataset.name)"):
            code = (
                f"(() => {{ const s = document.querySelector('[data-name=\"{name}\"] input[type=range]');"
                "s.value = Number(s.value) + 5; s.dispatchEvent(new Event('input', {bubbles: true}));"
                "return studio.looks.a.id })()"
            )
            before = page.js(code)
            page.wait(f"studio.looks.a.id > {before}")
            page.js(f"document.querySelector('[data-name=\"{name}\"] .reset').click()")
            moved += 1
    assert moved >= 15
    page.wait("document.querySelectorAll('.control.changed').length === 0")


def test_an_error_stands_beside_its_control_and_the_picture_stays(page):
    samples = page.js("studio.looks.a.x.length")
    type_in(page, "disc_radius", "40 mm")
    page.wait("!document.querySelector('[data-name=disc_radius] .error').hidden")
    message = page.js("document.querySelector('[data-name=disc_radius] .error span').textContent")
    assert "must be less than film_radius" in message
    assert page.js("document.querySelector('[data-name=disc_radius] input').getAttribute('aria-invalid')") == "true"
    assert page.js("studio.looks.a.x.length") == samples
    type_in(page, "disc_radius", "7 mm")
    page.wait("document.querySelector('[data-name=disc_radius] .error').hidden")


def test_an_error_of_a_quantity_stands_beside_the_control_that_gives_it(page):
    page.js("document.getElementById('tab-Gel').click()")
    type_in(page, "hoop_prestretch", "0.08")
    page.wait("!document.querySelector('[data-name=hoop_prestretch] .error').hidden")
    assert "pre-stretch" in page.js("document.querySelector('[data-name=hoop_prestretch] .error').textContent")


@pytest.mark.slow
def test_a_motion_that_ends_has_no_spectrum_and_the_panel_says_so(page):
    texts = "window.texts = []; const own = CanvasRenderingContext2D.prototype.fillText;"
    page.js(
        f"(() => {{ {texts} CanvasRenderingContext2D.prototype.fillText = function (t, ...p) {{"
        "texts.push(t); return own.call(this, t, ...p) }; })()"
    )
    page.js("document.querySelector('[data-tab=spectrum]').click()")
    page.wait("texts.some((text) => /^10[\u2070-\u207e\u00b2\u00b3\u00b9]+$/.test(text))")
    type_in(page, "voltage_amplitude", "3 kV")
    page.wait("studio.looks.a.words.ended && studio.looks.a.spectrum && studio.looks.a.lines && true")
    page.wait("texts.includes('A motion that ends has no spectrum.')")


def test_no_name_over_the_map_is_cut_short(page):
    page.size(1024, 700)
    pick(page, "#map select", "dielectric_strength")
    page.js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    cut = page.js(
        "[...document.querySelectorAll('#map .bar select')].filter((own) => {"
        "const { font, letterSpacing } = getComputedStyle(own);"
        "const g = Object.assign(document.createElement('canvas').getContext('2d'), { font, letterSpacing });"
        "return g.measureText(own.selectedOptions[0].textContent).width + 16 > own.clientWidth }).length"
    )
    assert cut == 0


def test_a_lock_keeps_a_value(page):
    page.js("document.querySelector('[data-name=frequency] .lock').click()")
    type_in(page, "frequency", "12 Hz")
    assert "frequency=" not in page.js("location.hash").replace("y=frequency", "")
    assert page.js("document.querySelector('[data-name=frequency] input[type=range]').disabled")
    shared = page.browser.tab(page.js("location.href"))
    shared.wait(ANSWERED)
    assert shared.js("document.querySelector('[data-name=frequency]').classList.contains('locked')")
    shared.js("document.querySelector('[data-name=frequency] .lock').click()")
    shared.wait("!location.hash.includes('locked')")
    assert shared.log == []
    shared.close()


def test_nothing_is_out_of_reach_in_a_small_frame_or_under_zoom(page):
    for width, height in ((360, 740), (640, 400), (800, 450), (1024, 700), (1280, 800)):
        check_reach(page, width, height)


def check_reach(page, width, height):
    page.size(width, height)
    page.js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    out = page.js(
        "[...document.querySelectorAll('button, select, input:not([type=file]), .plot canvas, #cone')]"
        ".filter((own) => {"
        "if (!own.checkVisibility()) return false; own.scrollIntoView({block: 'center'});"
        "const r = own.getBoundingClientRect();"
        "return r.width < 1 || r.left < -1 || r.right > innerWidth + 1 || r.top < -1 || r.bottom > innerHeight + 1 })"
        ".map((own) => own.id || own.className || own.textContent)"
    )
    assert out == [], width
    assert page.js("document.documentElement.scrollWidth") <= width
    small = page.js(
        "[...document.querySelectorAll('button, select, input:not([type=file])')].filter((own) => {"
        "if (!own.checkVisibility()) return false; const r = own.getBoundingClientRect();"
        "return r.width < 24 || r.height < 24 }).map((own) => own.id || own.className || own.textContent)"
    )
    assert small == [], width
    for canvas in ("#cone", "#time canvas", "#portrait canvas", "#map canvas"):
        assert min(page.box(canvas)[2:]) > 90, canvas


def test_the_disc_is_taken_and_let_go_as_a_start_and_the_gauge_moves_the_voltages(page):
    left, top, width, height = page.box("#cone")
    before = page.js("Math.max(...studio.looks.a.x)")
    # the disc is in the middle of the cross-section, above the flat film
    x = left + (width - 46) / 4
    found = page.js(
        "(() => { const c = document.getElementById('cone');"
        f"for (let y = {top}; y < {top + height}; y += 2) {{"
        f"c.dispatchEvent(new PointerEvent('pointermove', {{clientX: {x}, clientY: y, isPrimary: true, button: -1}}));"
        "if (c.style.cursor === 'ns-resize') return y } return null })()"
    )
    assert found is not None
    y = found + 14
    page.mouse("mousePressed", x, y)
    for step in range(1, 6):
        page.send("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y - 8 * step, button="left", buttons=1)
    page.mouse("mouseReleased", x, y - 40)
    page.wait("location.hash.includes('release_height=') && location.hash.includes('motion=start')")
    page.wait("studio.looks.a.words && !location.hash.includes('x=') || studio.looks.a.lines && true")
    page.wait(f"Math.abs(Math.max(...studio.looks.a.x) - {before}) > 0.1")
    started = page.js("studio.looks.a.x[0]")
    control = page.js("parseFloat(new URLSearchParams(location.hash.slice(1)).get('release_height'))")
    assert started == pytest.approx(control, rel=1e-3)
    gauge = left + width / 2
    page.mouse("mousePressed", gauge, top + 0.5 * height)
    page.send("Input.dispatchMouseEvent", type="mouseMoved", x=gauge, y=top + 0.6 * height, button="left", buttons=1)
    page.mouse("mouseReleased", gauge, top + 0.6 * height)
    page.wait("location.hash.includes('voltage_amplitude=') && location.hash.includes('voltage_offset=')")
    pump = gelcone.find_device("biased-pump")
    amplitude, offset = (
        float(parse(name, page.js(f"document.querySelector('[data-name={name}] input').value"), "V"))
        for name in ("voltage_amplitude", "voltage_offset")
    )
    assert amplitude < pump.voltage_amplitude
    assert amplitude / offset == pytest.approx(pump.voltage_amplitude / pump.voltage_offset, rel=0.01)


def test_the_address_holds_the_state_and_the_history_goes_back(page):
    type_in(page, "frequency", "12 Hz")
    page.wait("location.hash.includes('frequency=12+Hz')")
    shared = page.js("location.href")
    page.js("history.back()")
    page.wait("!location.hash.includes('frequency')")
    page.wait("document.querySelector('[data-name=frequency] input').value === '10 Hz'")
    other = page.browser.tab(shared)
    other.wait(ANSWERED)
    assert other.js("document.querySelector('[data-name=frequency] input').value") == "12 Hz"
    assert other.js("document.querySelector('[data-name=frequency]').classList.contains('changed')")
    assert other.log == []
    other.close()


@pytest.mark.slow
def test_a_click_on_the_map_goes_there_and_a_drag_zooms(page):
    page.wait("document.querySelectorAll('#map .legend li').length > 0", 120)
    page.click("#map canvas", 0.7, 0.3)
    page.wait("location.hash.includes('voltage_amplitude=') && location.hash.includes('frequency=')")
    page.drag("#map canvas", (0.3, 0.3), (0.6, 0.6))
    page.wait("location.hash.includes('x=voltage_amplitude')")
    page.wait("document.querySelectorAll('#map .legend li').length > 0", 120)


def test_two_settings_side_by_side(page):
    page.click("#compare")
    page.wait("studio.looks.b && studio.looks.b.lines && true")
    type_in(page, "voltage_amplitude", "400 V")
    page.wait("location.hash.includes('b.voltage_amplitude=400+V')")
    page.wait("document.querySelectorAll('.badge').length === 2")
    page.wait("Math.max(...studio.looks.a.x) - Math.max(...studio.looks.b.x) > 1")
    page.click("#side-a")
    page.wait("document.querySelector('[data-name=voltage_amplitude] input').value === '680 V'")
    page.click("#compare")
    page.wait("document.querySelectorAll('.badge').length === 1")


def test_the_gallery_shows_all_as_moving_cones_and_one_is_chosen(page):
    page.click("#browse")
    tiles = "[...document.querySelectorAll('#gallery .tile')]"
    assert page.js(f"{tiles}.map((t) => t.querySelector('b').textContent).join()").count(",") >= 10
    drawn = (
        f"{tiles}.every((t) => {{ const c = t.querySelector('canvas'), s = new Set(),"
        "d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
        "for (let i = 0; i < d.length; i += 4) s.add(d[i] + 256 * d[i + 1]); return s.size > 20 || "
        "t.getBoundingClientRect().top > document.querySelector('#gallery').getBoundingClientRect().bottom })"
    )
    page.wait(drawn, 60)
    page.js(f"{tiles}.find((t) => t.querySelector('b').textContent === 'soft-film').click()")
    page.wait("location.hash.includes('device=soft-film')")
    page.wait("!document.getElementById('gallery').open")


def test_a_captioned_picture_and_a_film_are_saved(page, tmp_path, monkeypatch):
    from matplotlib.image import imread

    page.click("#save")
    page.js("[...document.querySelectorAll('#saver button')].find((b) => b.textContent === 'Picture').click()")
    browser.wait_for((tmp_path / "gelcone.png").exists)
    time.sleep(0.2)
    picture = imread(tmp_path / "gelcone.png")
    assert picture.shape[0] > 600
    assert picture.shape[1] > 900
    assert picture[..., :3].std() > 0.05
    page.js("[...document.querySelectorAll('#saver button')].find((b) => b.textContent === 'Film').click()")
    page.wait("document.querySelector('#saver [role=status]').textContent === 'gelcone.webm is saved.'", 40)
    browser.wait_for((tmp_path / "gelcone.webm").exists)
    data = (tmp_path / "gelcone.webm").read_bytes()
    assert data[:4] == b"\x1aE\xdf\xa3"
    assert b"webm" in data[:64]
    assert len(data) > 20_000
    page.js("document.getElementById('saver').close()")


@pytest.mark.slow
def test_files_are_saved(page, tmp_path):
    import gelcone

    page.click("#save")
    page.wait("document.querySelector('#saver pre').textContent.startsWith('gelcone simulate biased-pump')")
    for form in ("nc", "png", "svg"):
        page.js(f"document.querySelector('#saver [data-format={form}]').click()")
        browser.wait_for((tmp_path / f"simulate.{form}").exists, 120)
        page.wait("!document.querySelector('#saver [data-format=nc]').disabled")
    result = gelcone.load(tmp_path / "simulate.nc")
    assert result.attrs["device"] == "biased pumping cone"
    type_in(page, "frequency", "9 Hz")
    page.js("document.querySelector('#saver [data-format=toml]').click()")
    browser.wait_for((tmp_path / "device.toml").exists)
    assert gelcone.Device.from_toml(tmp_path / "device.toml").frequency == 9.0
    page.js("document.getElementById('saver').close()")


def test_a_device_file_is_opened(page, tmp_path):
    import gelcone

    text = gelcone.find_device("biased-pump").replace(frequency="9 Hz", name="my own pump").to_toml()
    (tmp_path / "mine.toml").write_text(text)
    node = page.send("DOM.querySelector", nodeId=page.send("DOM.getDocument")["root"]["nodeId"], selector="#file")
    page.send("DOM.setFileInputFiles", files=[str(tmp_path / "mine.toml")], nodeId=node["nodeId"])
    page.wait("document.querySelector('[data-name=frequency] input').value === '9 Hz'")
    page.wait("document.querySelector('#subject').selectedOptions[0].textContent === 'my own pump'")
    assert "file=" in page.js("location.hash")


DROP = """(() => { const data = new DataTransfer();
  for (const [name, text] of %s) data.items.add(new File([text], name));
  dispatchEvent(new DragEvent("drop", { dataTransfer: data, cancelable: true })); return location.hash; })()"""


def test_measured_curves_are_dropped_on_the_page_and_put_away(page):
    band = "voltage (V),stroke (mm),stroke low (mm),stroke high (mm)\n0,0,0,0\n1000,1,0.9,1.1\n"
    bad = "time (ms),stroke\n1,2\n3,4\n"
    page.js(DROP % json.dumps([["run.csv", "time (ms),stroke (mm)\n0,0\n9,1\n"], ["bad.csv", bad], ["band.csv", band]]))
    page.wait("studio.looks.measured?.length === 2 && document.querySelector('#statics.shown') && true")
    notice = page.js("document.querySelector('#notices').textContent")
    assert 'bad.csv: line 1: column "stroke": has no unit; write stroke (m, cm, mm)' in notice
    assert page.js("[...studio.looks.measured[1].high]") == [0, 1.1]
    assert "csv" not in page.js("location.hash")
    page.click("#unmeasure")
    page.wait("!studio.looks.measured.length && document.querySelector('#unmeasure').hidden")


def test_dark_and_light(page):
    light = page.js("getComputedStyle(document.body).backgroundColor")
    page.dark(True)
    page.wait("document.documentElement.dataset.theme === 'dark'")
    assert page.js("getComputedStyle(document.body).backgroundColor") != light
    page.click("#theme")
    page.wait("document.documentElement.dataset.theme === 'light'")
    page.js("localStorage.clear()")


def test_it_fits_the_window(page):
    for size, group in product([(1024, 700), (1280, 800), (1920, 1080)], ("Body", "Gel", "Start")):
        page.size(*size)
        page.js(f"document.getElementById('tab-{group}').click()")
        page.js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        too_large = page.js(
            "[...document.querySelectorAll('html, body, aside, main, .panel, #group, header')].filter((e) =>"
            "e.scrollWidth > e.clientWidth + 1 || e.scrollHeight > e.clientHeight + 1 && (e.id !== 'group' ||"
            "innerHeight > 750 || getComputedStyle(e).overflowY !== 'auto'))"  # in a low window it may be scrolled
            ".map((e) => e.id || e.className || e.tagName)"
        )
        assert too_large == [], (size, group)


@pytest.mark.parametrize(
    "size",
    [(1024, 700), *(pytest.param(size, marks=pytest.mark.slow) for size in [(1280, 800), (1600, 900), (1920, 1080)])],
)
def test_the_plots_keep_their_size_while_the_hand_moves(page, size):
    page.size(*size)
    page.js("window.sizes = new Set()")
    page.js(
        "for (const one of document.querySelectorAll('#cone, #time .plot, #portrait .plot')) new ResizeObserver(() =>"
        "sizes.add(`${one.parentNode.id} ${one.clientHeight}`)).observe(one)"
    )
    shown = page.js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(sizes.size))))")
    assert shown == 3
    for volts in (300, 801, 1150, 500):  # periodic, also with a long first impression; pulled in
        before = page.js("studio.looks.a.id")
        type_in(page, "voltage_amplitude", f"{volts} V")
        page.wait(f"studio.looks.a.id > {before} && {ANSWERED}")
    page.js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert page.js("sizes.size") == shown, page.js("[...sizes]")


@pytest.mark.slow
def test_the_keyboard_is_enough(page):
    page.js("document.querySelector('[data-name=frequency] input[type=range]').focus()")
    page.key("ArrowRight", 39)
    page.wait("location.hash.includes('frequency=')")
    page.js("document.querySelector('[data-tab=time]').focus()")
    page.key("ArrowRight", 39)
    page.wait("document.activeElement.dataset.tab === 'spectrum' && location.hash.includes('top=spectrum')")
    page.wait("document.querySelectorAll('#map .legend li').length > 0", 120)
    page.js("document.querySelector('#map canvas').focus()")
    page.key("ArrowUp", 38)
    page.wait("location.hash.includes('voltage_amplitude=')")


def test_everything_has_a_name(page):
    nameless = page.js(
        "[...document.querySelectorAll('button, select, input, canvas[tabindex], [role=img]')]"
        ".filter((e) => !e.hidden && !e.getAttribute('aria-label') && !e.textContent.trim() && !e.title"
        "&& !(e.labels && e.labels.length)).map((e) => e.outerHTML)"
    )
    assert nameless == []


def test_a_lost_connection_is_said_and_comes_back(chromium):
    first = Served()
    port, token = first.studio.port, first.studio.token
    tab = chromium.tab(first.studio.address("device=biased-pump"))
    tab.wait(ANSWERED)
    first.close()
    tab.wait("!document.getElementById('lost').hidden")
    before = tab.js("studio.looks.a.id")
    second = Served(port, token)
    try:
        tab.wait("document.getElementById('lost').hidden")
        tab.wait(f"studio.looks.a.id !== {before}")
    finally:
        tab.close()
        second.close()


@pytest.mark.parametrize("values", ["&".join(f"a{number}=1" for number in range(200)), "a" * 9000])
def test_a_link_with_too_much_in_it_is_shown_without(served, chromium, values):
    tab = chromium.tab(served.studio.address(f"device=biased-pump&{values}"))
    try:
        tab.wait(ANSWERED)
        assert "left out" in tab.js("document.getElementById('notices').textContent")
        assert tab.log == []
    finally:
        tab.close()


def test_a_page_takes_the_address_of_a_studio_that_was_started_anew_and_keeps_its_state(chromium):
    first = Served()
    port = first.studio.port
    tab = chromium.tab(first.studio.address("device=biased-pump&frequency=9+Hz"))
    tab.wait(ANSWERED)
    first.close()
    second = Served(port)  # with a token of its own
    try:
        tab.wait("!document.getElementById('anew').hidden", 60)
        assert "paste the address" in tab.js("document.getElementById('lost').innerText")
        before = tab.js("studio.looks.a.id")
        tab.js(
            f"(() => {{ const own = document.getElementById('address'); own.value = {second.studio.address()!r};"
            "own.dispatchEvent(new Event('change')) })()"
        )
        tab.wait("document.getElementById('lost').hidden", 60)
        tab.wait(f"studio.looks.a.id > {before} && {ANSWERED}", 60)
        assert tab.js("document.querySelector('[data-name=frequency] input').value") == "9 Hz"
    finally:
        tab.close()
        second.close()


def test_a_page_that_waits_paints_at_once_and_says_for_what(chromium, monkeypatch):
    monkeypatch.setattr(look, "response", lambda *given: time.sleep(30.0))
    served = Served()
    tab = chromium.tab(served.studio.address("device=soft-film"))
    try:
        tab.wait("window.studio && document.getElementById('doing').textContent.startsWith('Computing the run')")
        assert tab.js("document.querySelector('#subject').selectedOptions[0].textContent") == "soft-film"
        assert tab.js("document.querySelectorAll('.control').length") > 3  # the controls are there before the run
        pixel = "(() => [...document.getElementById('cone').getContext('2d').getImageData(5, 5, 1, 1).data])()"
        assert tab.js(pixel)[:3] == [255, 255, 255]
        assert tab.js("document.body.classList.contains('old')")
    finally:
        tab.close()
        served.close()


def test_a_run_that_takes_too_long_is_given_up_with_a_sentence(chromium, monkeypatch):
    monkeypatch.setattr(gelcone.studio.page, "EVIDENCE_SECONDS", 0.2)
    served = Served()
    tab = chromium.tab(served.studio.address("device=biased-pump&frequency=1e-6 Hz"))
    try:
        tab.wait("window.studio && /evidence takes more than 0.2 s/.test(document.getElementById('badges').innerText)")
        assert tab.js("studio.looks.a.words.cut")
        monkeypatch.undo()
        type_in(tab, "frequency", "10 Hz")
        tab.wait("document.getElementById('badges').innerText.includes('Periodic, period 1')")
        assert tab.log == []
    finally:
        tab.close()
        served.close()


@pytest.mark.parametrize("state", ["device=nope&periods=abc", "preset=nope", "file=nonsense", "frequency=-1 Hz&evil=x"])
def test_an_address_that_cannot_be_shown_falls_back_with_a_sentence(served, chromium, state):
    tab = chromium.tab(served.studio.address(state))
    try:
        tab.wait("window.studio && studio.looks.a && studio.looks.a.t && true")
        assert tab.js("document.getElementById('notices').children.length") >= 1
        tab.wait("!/nope|abc|nonsense|-1|evil/.test(location.hash)")
        assert not tab.js("document.body.classList.contains('old')")
        assert tab.log == []
    finally:
        tab.close()


def test_a_wrong_entry_is_no_step_of_the_history_and_not_in_the_link(page):
    page.send("Page.resetNavigationHistory")  # a browser keeps 50 steps
    steps = page.js("history.length")
    type_in(page, "frequency", "-3 Hz")
    page.wait("!document.querySelector('[data-name=frequency] .error').hidden")
    assert page.js("document.body.classList.contains('old')")
    assert page.js("document.querySelector('[data-name=frequency] input').value") == "\N{MINUS SIGN}3 Hz"
    type_in(page, "voltage_amplitude", "700 V")
    page.wait("location.hash.includes('voltage_amplitude=700')")
    assert "&frequency=" not in page.js("location.hash")
    assert page.js("history.length") == steps + 1
    page.wait("document.querySelector('[data-name=frequency] input').value === '10 Hz'")
    assert not page.js("document.body.classList.contains('old')")


def test_a_file_that_is_no_device_does_not_trap(page, tmp_path):
    (tmp_path / "bad.toml").write_text('film_radius = "3 apples"\n')
    node = page.send("DOM.querySelector", nodeId=page.send("DOM.getDocument")["root"]["nodeId"], selector="#file")
    page.send("DOM.setFileInputFiles", files=[str(tmp_path / "bad.toml")], nodeId=node["nodeId"])
    page.wait("document.getElementById('notices').children.length === 1")
    assert page.js("document.querySelector('#subject').value") == "device:biased-pump"
    assert "file=" not in page.js("location.hash")
    type_in(page, "frequency", "12 Hz")
    page.wait("location.hash.includes('frequency=12')")
