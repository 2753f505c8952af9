"""A headless Chromium over the DevTools protocol's pipe: standard library only, nothing listens on a port."""

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--disable-default-apps", "--hide-scrollbars",
         "--mute-audio", "--remote-debugging-pipe"]

READY = 'document.documentElement?.dataset.ready === "yes"'  # of a report with its scripts
DRIVER = "GL Driver Message (OpenGL, Performance"  # of WebGL without a GPU, which says that it is slow
TILES_DRAWN = '!document.querySelector(".leaflet-tile:not(.leaflet-tile-loaded)")'


class Browser:
    """One window with one page. What the page says on the console and asks of the network is kept."""

    def __init__(self, program, width, height, dark=False):
        self.profile = tempfile.mkdtemp(prefix="sightline_chromium_")
        to_browser, self.pipe_out = os.pipe()
        self.pipe_in, from_browser = os.pipe()

        def give_pipes():
            # By way of high numbers, because either end may be 3 or 4 already.
            ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (to_browser, from_browser)]
            os.dup2(ends[0], 3, inheritable=True)
            os.dup2(ends[1], 4, inheritable=True)

        self.process = subprocess.Popen(
            [program, *FLAGS, f"--user-data-dir={self.profile}", f"--window-size={width},{height}", "about:blank"],
            preexec_fn=give_pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.buffer = b""
        self.next_id = 0
        self.session = self.target = None
        self.new_window(width, height, dark)

    def new_window(self, width, height, dark=False):
        """In the place of the one before; nothing that was said or asked for is kept."""
        self.session, before = None, self.target
        self.complaints = []  # errors and warnings of the console, exceptions
        self.requests = []  # addresses that the page asked for
        self.events = []
        self.target = self.call("Target.createTarget", url="about:blank", newWindow=True, width=width,
                                height=height)["targetId"]
        if before:
            self.call("Target.closeTarget", targetId=before)
        self.session = self.call("Target.attachToTarget", targetId=self.target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def close(self):
        self.process.terminate()
        self.process.wait(10)
        shutil.rmtree(self.profile, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def read_message(self, until):
        while b"\0" not in self.buffer:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.pipe_in], [], [], left)[0]:
                raise TimeoutError("the browser did not answer")
            part = os.read(self.pipe_in, 1 << 20)
            if not part:
                raise EOFError("the browser ended")
            self.buffer += part
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def note(self, message):
        if message.get("sessionId") != self.session:
            return  # of the window before
        method, params = message.get("method"), message.get("params", {})
        self.events.append(method)
        if method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.complaints.append(params["exceptionDetails"].get("exception", {}).get("description", "exception"))
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.complaints.append(" ".join(str(each.get("value", each.get("description"))) for each in params["args"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning") and DRIVER not in params["entry"]["text"]:
            self.complaints.append(params["entry"]["text"])

    def call(self, method, timeout_s=90, **params):
        self.next_id += 1
        message = {"id": self.next_id, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.pipe_out, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + timeout_s
        while True:
            answer = self.read_message(until)
            if answer.get("id") == self.next_id:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.note(answer)

    def value_of(self, expression):
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait_for(self, expression, timeout_s=60):
        until = time.monotonic() + timeout_s
        while not self.value_of(expression):
            if time.monotonic() > until:
                raise TimeoutError(f"never came true: {expression}; console: {self.complaints}")
            time.sleep(0.05)

    def open(self, address, ready):
        """Opens a page; seconds until `ready` came true."""
        begin = time.monotonic()
        self.call("Page.navigate", url=address)
        self.wait_for(ready)
        return time.monotonic() - begin

    def resize(self, width, height):
        """The window as the page sees it, which may be narrower than a browser's can be."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)

    def click(self, x, y):
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def press(self, key, code):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code)

    def screenshot(self, path, selector=None):
        """The window, or all of one element however far it reaches beyond the window."""
        options = {}
        if selector:
            options = {"captureBeyondViewport": True, "clip": {**self.box_of(selector), "scale": 1}}
        picture = self.call("Page.captureScreenshot", format="png", **options)["data"]
        with open(path, "wb") as file:
            file.write(base64.b64decode(picture))

    def box_of(self, selector):
        return self.value_of(
            f"(() => {{ const box = document.querySelector({json.dumps(selector)}).getBoundingClientRect();"
            " return {x: box.x + scrollX, y: box.y + scrollY, width: box.width, height: box.height}; })()")
