"""A real browser without a screen, driven by the Chrome DevTools Protocol."""

from __future__ import annotations

import base64
import itertools
import json
import re
import shutil
import subprocess
import tempfile
import time
import urllib.request

NAMES = ("chromium", "chromium-browser", "google-chrome")
OPTIONS = (
    "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars", "--mute-audio",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
    "--remote-debugging-port=0", "--no-first-run", "--disable-background-networking",
)  # fmt: skip


def found():
    """Return the path of a browser, or None."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Browser:
    """One page of a headless browser; a `with` block ends it."""

    def __init__(self, url, size=(1100, 750)):
        from websockets.sync.client import connect

        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        place = (f"--user-data-dir={self._folder.name}", f"--window-size={size[0]},{size[1]}")
        self._log = open(f"{self._folder.name}/log", "w+b")  # noqa: SIM115
        self._process = subprocess.Popen([found(), *OPTIONS, *place, url], stderr=self._log, stdout=subprocess.DEVNULL)
        port = self._waited(lambda: re.search(rb"DevTools listening on ws://[^:]+:(\d+)", self._so_far()))
        address = f"http://127.0.0.1:{int(port[1])}/json"
        pages = self._waited(
            lambda: [
                page for page in json.load(urllib.request.urlopen(address, timeout=30.0)) if page["type"] == "page"
            ]
        )
        self._socket = connect(pages[0]["webSocketDebuggerUrl"], max_size=None, compression=None)
        self._numbers = itertools.count()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._socket.close()
        self._process.terminate()
        self._process.wait(20)
        self._log.close()
        self._folder.cleanup()

    def _so_far(self):
        with open(self._log.name, "rb") as file:
            return file.read()

    @staticmethod
    def _waited(what, seconds=60.0):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            answer = what()
            if answer:
                return answer
            time.sleep(0.1)
        raise TimeoutError("the browser does not answer")

    def call(self, method, **values):
        """Return the answer to a message of the protocol."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": values}))
        while True:
            answer = json.loads(self._socket.recv(timeout=60.0))
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(answer["error"])
                return answer["result"]

    def evaluate(self, script):
        """Return the value of JavaScript; a promise is awaited."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        return answer["result"].get("value")

    def wait_for(self, script, seconds=60.0):
        """Wait until JavaScript is true."""
        return self._waited(lambda: self.evaluate(script), seconds)

    def screenshot(self):
        """Return a PNG file of the page as it is."""
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def mouse(self, kind, x, y, **more):
        """Press, move or release the mouse."""
        self.call("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, button="left", clickCount=1, **more)
