"""A headless Chromium driven through its DevTools, as far as tests, pictures and measurements of the studio need it."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any

from websockets.sync.client import connect

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--remote-debugging-port=0",
    "--remote-allow-origins=*",
)
SECONDS = 30.0


def find_browser() -> str | None:
    """The path of the browser; None without one."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


class Browser:
    """One browser with one page, as a context manager."""

    def __init__(self, width: int = 1280, height: int = 800) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="browser-"))
        program = find_browser()
        assert program is not None, "no Chromium found"
        # the command line keeps the browser from asking its own services, which are not there
        self.process = subprocess.Popen(
            [program, *FLAGS, f"--user-data-dir={self.folder}", f"--window-size={width},{height}", "about:blank"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "HOME": str(self.folder)},
        )
        self.port = self._port()
        self.tabs = ExitStack()
        try:
            self.page = Tab(self, self._targets()[0]["webSocketDebuggerUrl"])
            self.page.size(width, height)
        except BaseException:
            self.close()
            raise

    def _port(self) -> int:
        told = self.folder / "DevToolsActivePort"
        return int(wait_for(lambda: told.exists() and told.read_text().splitlines()[:1])[0])

    def _targets(self) -> list[dict[str, Any]]:
        from urllib.request import urlopen

        def pages() -> list[dict[str, Any]]:
            with urlopen(f"http://127.0.0.1:{self.port}/json") as answer:
                return [target for target in json.load(answer) if target["type"] == "page"]

        found: list[dict[str, Any]] = wait_for(pages)
        return found

    def tab(self, address: str = "about:blank", width: int = 1280, height: int = 800) -> Tab:
        """Opens a further page."""
        made = self.page.send("Target.createTarget", url="about:blank")["targetId"]
        tab = Tab(self, f"ws://127.0.0.1:{self.port}/devtools/page/{made}")
        tab.size(width, height)
        tab.go(address)
        return tab

    def close(self) -> None:
        self.tabs.close()
        self.process.kill()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class Tab:
    """One page of a browser."""

    def __init__(self, browser: Browser, address: str) -> None:
        self.browser = browser
        self.socket = browser.tabs.enter_context(connect(address, max_size=None))
        self.number = 0
        self.log: list[str] = []
        for domain in ("Page", "Runtime", "Log"):
            self.send(f"{domain}.enable")

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The result of a DevTools command."""
        self.number += 1
        own = self.number
        self.socket.send(json.dumps({"id": own, "method": method, "params": parameters}))
        while True:
            answer = json.loads(self.socket.recv(timeout=SECONDS))
            if answer.get("id") == own:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                result: dict[str, Any] = answer["result"]
                return result
            self._hear(answer)

    def _hear(self, event: dict[str, Any]) -> None:
        """Keeps what the page complains of."""
        content = event.get("params", {})
        if event.get("method") == "Runtime.exceptionThrown":
            details = content["exceptionDetails"]
            self.log.append(str(details.get("exception", {}).get("description", details["text"])))
        elif event.get("method") == "Runtime.consoleAPICalled" and content["type"] in ("error", "warning", "assert"):
            self.log.append(" ".join(str(a.get("value", a.get("description"))) for a in content["args"]))
        elif event.get("method") == "Log.entryAdded" and content["entry"]["level"] == "error":
            self.log.append(content["entry"]["text"])

    def close(self) -> None:
        self.send("Page.close")

    def size(self, width: int, height: int) -> None:
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def dark(self, on: bool, still: bool = False) -> None:
        """Has the user prefer dark or light pages and, if ``still``, such without motion."""
        wanted = {"color-scheme": "dark" if on else "light", "reduced-motion": "reduce" if still else ""}
        features = [{"name": f"prefers-{name}", "value": value} for name, value in wanted.items()]
        self.send("Emulation.setEmulatedMedia", features=features)

    def go(self, address: str) -> None:
        self.send("Page.navigate", url=address)

    def js(self, code: str) -> Any:
        """The value of an expression in the page; promises are awaited."""
        answer = self.send("Runtime.evaluate", expression=code, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise RuntimeError(details.get("exception", {}).get("description", details["text"]))
        return answer["result"].get("value")

    def wait(self, code: str, seconds: float = SECONDS) -> Any:
        """The value of an expression once it is true."""
        return wait_for(lambda: self.js(code), seconds, code)

    def box(self, selector: str) -> tuple[float, float, float, float]:
        """Left, top, width and height of an element."""
        code = f"(() => {{const r = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
        left, top, width, height = self.js(code + "return [r.left, r.top, r.width, r.height]})()")
        return left, top, width, height

    def mouse(self, kind: str, x: float, y: float, clicks: int = 1) -> None:
        buttons = 0 if kind == "mouseReleased" else 1
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=buttons, clickCount=clicks)

    def click(self, selector: str, across: float = 0.5, down: float = 0.5) -> None:
        """A click with the mouse at a place of an element, shares of its width and height."""
        left, top, width, height = self.box(selector)
        x, y = left + across * width, top + down * height
        self.send("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def drag(self, selector: str, start: tuple[float, float], end: tuple[float, float], steps: int = 8) -> None:
        """A drag from one place of an element to another."""
        left, top, width, height = self.box(selector)
        for step in range(steps + 1):
            share = step / steps
            x = left + width * (start[0] + (end[0] - start[0]) * share)
            y = top + height * (start[1] + (end[1] - start[1]) * share)
            if step == 0:
                self.mouse("mousePressed", x, y)
            else:
                self.send("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, button="left", buttons=1)
        self.mouse("mouseReleased", x, y)

    def key(self, name: str, code: int = 0, text: str = "") -> None:
        for kind in ("keyDown", "keyUp"):
            more = {"text": text} if text and kind == "keyDown" else {}
            self.send("Input.dispatchKeyEvent", type=kind, key=name, code=name, windowsVirtualKeyCode=code, **more)

    def picture(self, path: Path | str | None = None) -> bytes:
        """A screenshot as PNG."""
        data = base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])
        if path is not None:
            Path(path).write_bytes(data)
        return data


def wait_for(found: Callable[[], Any], seconds: float = SECONDS, what: str = "") -> Any:
    """The result of ``found`` once it is true."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = found()
        if value:
            return value
        time.sleep(0.02)
    raise TimeoutError(f"not within {seconds:g} s: {what or found}")
