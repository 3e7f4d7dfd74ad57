"""The page of the viewer in a real browser, and whom it speaks to.

It needs Chromium and its driver (Debian: `apt-get install chromium-driver`) and Selenium.
"""

import json
import shutil
import signal
import subprocess
import sys
import time
from urllib.parse import urlsplit

import pytest

from conftest import ROOT

webdriver = pytest.importorskip("selenium.webdriver")

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
SCENE = ROOT / "examples" / "settling-sphere" / "short.toml"
# A picture of a page that shows nothing but Rerun's frame compresses to less than half of it [bytes].
DRAWN = 60_000


@pytest.fixture
def address(tmp_path):
    """Address at which a run is shown; the run and its viewer end with the test."""
    command = [sys.executable, "-m", "tremie", "run", SCENE, "--view", "web", "--out", tmp_path / "out"]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        told = next((line for line in running.stderr if "the run is shown at" in line), None)
        assert told, "the run ended before it was shown"
        # What it says later is read by nobody, and must not fill the pipe.
        subprocess.Popen(["cat"], stdin=running.stderr, stdout=subprocess.DEVNULL)
        yield told.split("the run is shown at ")[1].split()[0]
        running.send_signal(signal.SIGINT)
        running.wait(60)
    finally:
        running.kill()


def browser(log, profile):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for option in (
        "headless=new",
        "no-sandbox",
        "no-first-run",
        "disable-quic",
        "disable-background-networking",
        "disable-component-update",
        # Else the browser asks its makers about every field in which a user can type.
        "disable-features=AutofillServerCommunication",
        "use-angle=swiftshader",
        "enable-unsafe-swiftshader",
        "window-size=1400,900",
        f"user-data-dir={profile}",
        f"log-net-log={log}",
    ):
        options.add_argument("--" + option)
    return webdriver.Chrome(options, webdriver.ChromeService(DRIVER))


def hosts_of_page(log, page):
    """Hosts that the page asked something of, or that were looked up for it, from the browser's log."""
    hosts = set()
    for event in json.loads(log.read_text())["events"]:
        told = event.get("params", {})
        # The browser's own requests, as for its updates, are nobody's.
        if told.get("initiator") == page:
            hosts.add(urlsplit(told.get("url", "")).hostname)
        # A host may be looked up, or connected to, before anything is asked of it.
        if str(told.get("network_anonymization_key")).startswith("http://127.0.0.1"):
            hosts.add(urlsplit(told.get("host", "")).hostname)
    return hosts - {None}


@pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="needs Chromium and its driver")
def test_the_page_opens_and_speaks_to_this_machine_alone(address, tmp_path):
    log = tmp_path / "net.json"
    chromium = browser(log, tmp_path / "profile")
    try:
        chromium.get(address)
        end, picture = time.monotonic() + 120, b""
        while len(picture) < DRAWN and time.monotonic() < end:
            time.sleep(1)
            picture = chromium.get_screenshot_as_png()
    finally:
        # The log is whole once the browser has ended.
        chromium.quit()
    (tmp_path / "page.png").write_bytes(picture)
    assert len(picture) >= DRAWN, f"{tmp_path / 'page.png'} shows no run"
    page = "http://" + urlsplit(address).netloc
    assert hosts_of_page(log, page) == {"127.0.0.1"}
