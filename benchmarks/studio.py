"""Response times of the studio in a real browser: from the input event to the painted pixels.

python benchmarks/studio.py                    (all of it but what follows, some two minutes)
python benchmarks/studio.py --controls         (a drag of every slider of every shipped device and preset, ten minutes)
python benchmarks/studio.py --controls biased-pump base       (of some)
python benchmarks/studio.py --pages 8 --minutes 10     (many pages at once: errors, memory, processes left)

Beside every time stand the processor time that the studio's own processes took and the share of the machine that others
used meanwhile: on a busy machine the first of the three says little.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from browser import Browser, Tab, wait_for

MOVES = 500
PATIENCE = 600
"""Seconds in which a machine that others use, too, shows a device whose programs are compiled."""
AT_ONCE = 5
"""Moves of one call, none of which may take longer than a browser is waited for."""
ALONE = "document.getElementById('grid-share').textContent === ''"
"""No worker computes or follows a branch."""
SHOWN = "studio.looks.a && (studio.looks.a.lines || studio.looks.a.late) && true"
TABS = ("map", "strip", "spectrum", "statics", "time", "portrait")
TICK = os.sysconf("SC_CLK_TCK")
MEASURE = """
async (name, low, high, first, last, wanted) => {
  const slider = document.querySelector(`[data-name="${name}"] input[type=range]`), times = [];
  const painted = () => new Promise((done) => requestAnimationFrame(() => {
    const channel = new MessageChannel(); channel.port1.onmessage = done; channel.port2.postMessage(0); }));
  let wake = () => {}, count = studio.painted;
  const set = (v) => { count = v; wake(); };
  Object.defineProperty(studio, "painted", { configurable: true, get: () => count, set });
  const until = (ready) => new Promise((done) => {
    wake = () => { if (ready()) { wake = () => {}; done(); } };
    wake(); });
  for (let i = first; i < last; i++) {
    const began = performance.now(), before = studio.looks.a.id, row = [];
    slider.value = low + ((i * 0.381966) % 1) * (high - low);
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    for (const stage of wanted) {
      await until(() => studio.looks.a.id > before && (stage === "response" || studio.looks.a.lines));
      await painted();
      row.push(performance.now() - began);
    }
    times.push(row);
  }
  return times;
}"""
COUNT_LOST = """
(() => { const mark = document.getElementById("lost"); studio.lost = 0;
  const observer = new MutationObserver(() => { if (!mark.hidden) studio.lost++; });
  observer.observe(mark, { attributeFilter: ["hidden"] }); })()"""
DRAG = """
async (name, low, high, seconds) => {
  const slider = document.querySelector(`[data-name="${name}"] input[type=range]`), seen = new Set();
  let count = studio.painted;
  const set = (v) => { count = v; seen.add(studio.looks.a.id); };
  Object.defineProperty(studio, "painted", { configurable: true, get: () => count, set });
  const began = performance.now();
  await new Promise((done) => { const step = () => {
    const t = (performance.now() - began) / 1000;
    if (t > seconds) return done();
    slider.value = low + (high - low) * (0.5 + 0.5 * Math.sin(2 * t));
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    requestAnimationFrame(step); }; step(); });
  return seen.size / seconds;
}"""


# --- the machine -----------------------------------------------------------------------------------------------------


def tree(pid: int) -> list[int]:
    """A process and all that it has started."""
    try:
        tasks = Path(f"/proc/{pid}/task").iterdir()
        own = [int(child) for task in tasks for child in (task / "children").read_text().split()]
    except OSError:
        return [pid]
    return [pid, *(p for child in own for p in tree(child))]


def seconds_of(pids: list[int]) -> float:
    """Processor time that these processes have taken."""
    total = 0
    for pid in pids:
        try:
            fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        total += int(fields[11]) + int(fields[12])
    return total / TICK


def busy() -> float:
    """Processor time that the whole machine has spent working."""
    fields = [int(v) for v in Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
    return (sum(fields) - fields[3] - fields[4]) / TICK


def memory_of(pids: list[int]) -> float:
    """Resident memory, MB."""
    pages = 0
    for pid in pids:
        try:
            pages += int(Path(f"/proc/{pid}/statm").read_text().split()[1])
        except OSError:
            continue
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


@contextmanager
def measured(name: str, server: int) -> Iterator[dict[str, str]]:
    """Prints a line: the finding, the server's processor time, the load of others."""
    said: dict[str, str] = {}
    own = tree(os.getpid())
    wall, machine, mine, studio = time.perf_counter(), busy(), seconds_of(own), seconds_of(tree(server))
    yield said
    taken = time.perf_counter() - wall
    used = seconds_of(tree(server)) - studio
    others = max(0.0, (busy() - machine - (seconds_of(tree(os.getpid())) - mine)) / taken)
    per = (
        f", {1e3 * used / int(said['moves']):5.1f} ms of processor a move"
        if "moves" in said
        else f", {used:.2f} s of processor"
    )
    print(f"{name:44s} {said['found']}{per}; others {others:.2f} of {os.cpu_count()} cores", flush=True)


def median(times: list[float], share: float = 0.5) -> float:
    return sorted(times)[int(share * (len(times) - 1))]


def told(times: list[float]) -> str:
    return f"median {median(times):5.1f} ms, 90 % {median(times, 0.9):5.1f} ms"


def both_told(times: list[list[float]]) -> str:
    return "; ".join(told([row[stage] for row in times]) for stage in range(len(times[0])))


# --- one page --------------------------------------------------------------------------------------------------------


class Started:
    """``gelcone studio`` as a user starts it."""

    def __init__(self) -> None:
        self.began = time.perf_counter()
        command = [sys.executable, "-m", "gelcone", "studio", "--no-browser", "biased-pump"]
        # an installed package has its byte code
        own = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=own)
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().partition(": ")[2].strip().partition("#")[0]

    def __enter__(self) -> Started:
        return self

    def __exit__(self, *error: object) -> None:
        began, workers = time.perf_counter(), tree(self.process.pid)[1:]
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(30)
        taken = time.perf_counter() - began
        time.sleep(0.5)
        left = [pid for pid in workers if Path(f"/proc/{pid}").exists()]
        print(f"{'Ctrl-C':44s} exit code {code} after {taken:.2f} s, {len(left)} of {len(workers)} workers left")


def show(tab: Tab, state: str, ready: str = SHOWN) -> None:
    """Shows a state and waits until it is there, with its evidence or why there is none."""
    tab.js(f"(() => {{ delete studio.looks.a; location.hash = {state!r} }})()")
    tab.wait(ready, PATIENCE)
    time.sleep(1.0)


def measure(tab: Tab, name: str, ends: tuple[int, int], moves: int, wanted: list[str]) -> list[list[float]]:
    """Milliseconds of each move until each of the answers ``wanted`` was painted."""
    times: list[list[float]] = []
    for first in range(0, moves, AT_ONCE):
        arguments = f"{name!r}, {ends[0]}, {ends[1]}, {first}, {min(first + AT_ONCE, moves)}, {wanted!r}"
        times += tab.js(f"({MEASURE})({arguments})")
    return times


def one_page(moves: int) -> None:
    with Browser(1600, 900) as browser, Started() as started:
        tab, server = browser.page, started.process.pid
        with measured("first paint, from the command", server) as said:
            tab.go(started.address + "#device=biased-pump&right=strip")
            tab.wait("window.studio && studio.painted > 0", PATIENCE)
            said["found"] = f"{time.perf_counter() - started.began:.2f} s"
        tab.wait("studio.looks.a.lines && true", PATIENCE)
        tab.wait(ALONE, 300)
        both = ["response", "kind"]
        measure(tab, "voltage_amplitude", (200, 600), 40, both)
        with measured("pump: response, portrait; with section, badge", server) as said:
            times = measure(tab, "voltage_amplitude", (200, 600), moves, both)
            said |= {"moves": str(moves), "found": both_told(times)}
        with measured("pump: drag of 60 moves a second", server) as said:
            said["found"] = f"{tab.js(f'({DRAG})(%r, 200, 600, 5)' % 'voltage_amplitude'):.0f} pictures a second"
        with measured("map of the pump, 65 x 49", server) as said:
            said["found"] = map_times(tab)
        show(tab, "device=biased-pump&right=map&damping_coefficient=10.5+mN+s/m")
        with measured("pump: the same while a map is computed", server) as said:
            times = measure(tab, "voltage_amplitude", (200, 600), moves // 5, both)
            still = tab.js("document.getElementById('grid-share').textContent")
            said |= {
                "moves": str(moves // 5),
                "found": f"{told([a for a, _ in times])}; {told([b for _, b in times])} (map at {still or 'its end'})",
            }
        show(tab, "preset=base&voltage=1.7&right=strip")
        tab.wait(ALONE, 300)
        with measured("base set in chaos: first picture; evidence", server) as said:
            times = measure(tab, "voltage", (820, 920), moves // 10, both)
            said |= {
                "moves": str(moves // 10),
                "found": f"{told([a for a, _ in times])}; {told([b for _, b in times])}",
            }
        assert tab.log == [], tab.log


def map_times(tab: Tab) -> str:
    """Times of the first coarse picture and of the last cell of a map."""
    tab.js(
        "(() => { delete studio.looks.a; studio.map = [performance.now()];"
        "const share = document.getElementById('grid-share');"
        "new MutationObserver(() => { const legend = document.querySelector('#map .legend li');"
        "if (legend && studio.map.length === 1) studio.map.push(performance.now());"
        "if (/^(following.*)?$/.test(share.textContent) && studio.map.length === 2) studio.map.push(performance.now());"
        "})"
        ".observe(document.body, {subtree: true, childList: true, characterData: true});"
        "location.hash = 'device=biased-pump&right=map' })()"
    )
    began, first, last = wait_for(lambda: tab.js("studio.map.length === 3 && studio.map"), 300)
    return f"first picture {(first - began) / 1e3:.2f} s, all cells {(last - began) / 1e3:.2f} s"


# --- every slider ----------------------------------------------------------------------------------------------------

SLIDERS = """
(() => { const found = [];
  for (const tab of [null, ...document.querySelectorAll('#groups [role=tab]')]) {
    tab?.click();
    const own = document.querySelectorAll(`${tab ? "#group" : "#drive"} .control.number`);
    for (const one of own) found.push([tab?.id ?? null, one.dataset.name]);
  }
  return found; })()"""
AROUND = 30
"""Steps of a slider, of 1000, that a drag goes to either side."""
SECONDS = 1.5


def every_slider(subjects: list[str]) -> None:
    """Pictures per second in a drag of every slider, and processor time of the server per picture."""
    with Browser(1600, 900) as browser, Started() as started:
        tab, server, worst = browser.page, started.process.pid, []
        tab.go(started.address + "#device=biased-pump&right=strip")
        tab.wait("window.studio && studio.looks.a && studio.looks.a.lines && true", PATIENCE)
        hello = tab.js("[...document.querySelectorAll('#subject option')].map((o) => o.value)")
        for name in [one for one in hello if not subjects or one.partition(":")[2] in subjects]:
            show(tab, f"right=strip&{name.replace(':', '=')}")
            for group, control in tab.js(SLIDERS):
                if group:
                    tab.js(f"document.getElementById({group!r}).click()")
                place = f"document.querySelector('[data-name=\"{control}\"] input[type=range]').value"
                at = min(max(float(tab.js(place)), AROUND), 1000 - AROUND)
                began = seconds_of([server])  # without its workers, which a move stops
                pictures = tab.js(f"({DRAG})({control!r}, {at - AROUND}, {at + AROUND}, {SECONDS})")
                cost = 1e3 * (seconds_of([server]) - began) / max(pictures * SECONDS, 1.0)
                worst.append((cost, pictures, f"{name} {control}"))
                tab.js(f"document.querySelector('[data-name=\"{control}\"] .reset').click()")
                time.sleep(0.8)
                print(f"{name} {control:32s} {pictures:5.0f} pictures a second, {cost:5.1f} ms each", flush=True)
        print(f"{len(worst)} sliders; most processor time {max(worst)[0]:.1f} ms a picture ({max(worst)[2]}); ", end="")
        slow = min(worst, key=lambda row: row[1])
        print(f"fewest pictures {slow[1]:.0f} a second ({slow[2]})")
        assert tab.log == [], tab.log


# --- many pages ------------------------------------------------------------------------------------------------------


def many_pages(count: int, minutes: float) -> None:
    """Moves sliders at random on many pages at once."""
    draw = random.Random(1)
    with Browser(1280, 800) as browser, Started() as started:
        tabs = [browser.tab(started.address + "#device=biased-pump") for _ in range(count)]
        for tab in tabs:
            tab.wait("window.studio && studio.looks.a && true", 120)
            tab.js(COUNT_LOST)
        end, moves, memory = time.monotonic() + 60.0 * minutes, 0, []
        while time.monotonic() < end:
            tab = draw.choice(tabs)
            tab.js(
                f"(() => {{ const s = [...document.querySelectorAll('aside input[type=range]')];"
                f"const one = s[Math.floor({draw.random()} * s.length)]; one.value = 1000 * {draw.random()};"
                "one.dispatchEvent(new Event('input', {bubbles: true})); })()"
            )
            if draw.random() < 0.01:
                tab.js(f"document.querySelector('[data-tab={draw.choice(TABS)}]').click()")
            moves += 1
            if moves % 500 == 0:
                memory.append(memory_of(tree(started.process.pid)))
                print(f"{moves} moves, {memory[-1]:.0f} MB in {len(tree(started.process.pid))} processes", flush=True)
        errors = [line for tab in tabs for line in tab.log]
        alive = [tab.js("document.getElementById('lost').hidden") for tab in tabs]
        lost, painted = (sum(tab.js(f"studio.{name}") for tab in tabs) for name in ("lost", "painted"))
        quarters = ", ".join(f"{memory[(len(memory) - 1) * k // 4]:.0f}" for k in range(5))
        print(
            f"{count} pages, {minutes:g} min, {moves} moves, {painted} pictures: {len(errors)} errors, connections "
            f"lost {lost} times, {alive.count(True)} connected at the end, memory in quarters {quarters} MB"
        )
        print("\n".join(errors[:10]))


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--moves", type=int, default=MOVES, help="slider moves of the largest case")
    options.add_argument("--pages", type=int, default=1, help="pages at once; more than one: random moves")
    options.add_argument("--minutes", type=float, default=1.0, help="length of the random moves")
    options.add_argument("--controls", nargs="*", metavar="SUBJECT", help="a drag of every slider, of these or of all")
    given = options.parse_args()
    if given.controls is not None:
        every_slider(given.controls)
    elif given.pages > 1:
        many_pages(given.pages, given.minutes)
    else:
        one_page(given.moves)


if __name__ == "__main__":
    main()
