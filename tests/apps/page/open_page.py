"""Opens pages in headless Chromium and prints what a reader would run into, a line each; nothing if all is well.

/usr/bin/python3 open_page.py FOLDER REPORT.html...; exits with 77 where Chromium, its driver or Selenium are missing.
FOLDER keeps axe-core, which npm fetches there once; without it a note on standard error says that accessibility was not
tested.
"""
import base64
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
except ImportError:
    print("skipped: no python3-selenium")
    sys.exit(77)
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
if not CHROMIUM or not DRIVER:
    print("skipped: no chromium or chromium-driver")
    sys.exit(77)

BLANK = """
const blank = [];
for (const canvas of document.querySelectorAll("canvas")) {
  const pixels = new Uint32Array(canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.buffer);
  const colours = new Set(pixels);
  if (pixels.length < 10000 || colours.size < 8) blank.push(canvas.closest("figure").getAttribute("aria-labelledby"));
}
return blank;
"""
# Drawings without scripts: those with hardly a line in them.
EMPTY = """
return Array.from(document.querySelectorAll("figure svg")).filter(svg => {
  const box = svg.getBoundingClientRect(), paths = Array.from(svg.querySelectorAll("path"));
  return box.width < 100 || paths.filter(path => path.getTotalLength() > 0).length < 6;
}).map(svg => svg.closest("figure").getAttribute("aria-labelledby"));
"""
WIDER = "return document.documentElement.scrollWidth > document.documentElement.clientWidth;"
UNNAMED = """
return Array.from(document.querySelectorAll("[role=img], [role=group], table, nav, button"))
  .filter(one => !(one.getAttribute("aria-label") || one.querySelector("caption") || one.textContent.trim() ||
                   document.getElementById(one.getAttribute("aria-labelledby"))?.textContent)).map(one => one.outerHTML.slice(0, 80));
"""
# The largest button's click must change what the canvas shows, and "all" bring it back.
ZOOM = """
const figure = document.querySelector("figure.chart"), canvas = figure.querySelector("canvas");
const button = name => Array.from(figure.querySelectorAll("button")).find(one => one.textContent === name);
const shot = () => canvas.toDataURL(), wait = () => new Promise(done => setTimeout(done, 150));
const done = arguments[0];
(async () => {
  button("all").click(); await wait(); const whole = shot();
  button("zoom in").click(); await wait(); const part = shot();
  button("all").click(); await wait(); const again = shot();
  figure.querySelector(".u-legend .u-series:last-child th").click(); await wait(); const without = shot();
  figure.querySelector(".u-legend .u-series:last-child th").click(); await wait();
  done(whole !== part && whole === again && whole !== without);
})();
"""


# What is saved of the first chart: its type, and whether there is something in it.
SAVED = """
const figure = document.querySelector("figure.chart"), kept = [], done = arguments[0];
URL.createObjectURL = blob => { kept.push(blob); return "data:,"; };
HTMLAnchorElement.prototype.click = () => {};
for (const name of ["SVG", "PNG", "CSV"])
  Array.from(figure.querySelectorAll("button")).find(one => one.textContent === name).click();
setTimeout(async () => {
  const texts = {};
  for (const blob of kept) texts[blob.type] = await blob.text();
  const drawn = new DOMParser().parseFromString(texts["image/svg+xml"], "image/svg+xml");
  const paths = Array.from(drawn.querySelectorAll("path")).filter(one => one.getAttribute("d").length > 200);
  const faults = [];
  if (drawn.querySelector("parsererror") || paths.length < 1) faults.push("SVG without a curve");
  if (/NaN|undefined/.test(texts["image/svg+xml"])) faults.push("SVG with NaN");
  if (!texts["image/png"] || texts["image/png"].length < 2000) faults.push("empty PNG");
  if ((texts["text/csv"] || "").split("\\n").length < 20) faults.push("empty CSV");
  done(faults);
}, 300);
"""
# The answer of a run's page is seen without scrolling: verdict, equation, and the figure's head.
FIRST = """
const seen = name => { const one = document.querySelector(name); return !one || one.getBoundingClientRect().top < innerHeight - 60; };
return [".badge", ".equations", ".quantities", ".proof .plot"].filter(name => !seen(name));
"""


# Wider than its place on paper, where nothing scrolls.
CUT = """
document.querySelectorAll("section details").forEach(one => { one.open = true; });
return Array.from(document.querySelectorAll(".table, .math, pre, figure")).filter(one => one.scrollWidth > one.clientWidth + 1)
  .map(one => one.textContent.slice(0, 60));
"""
PAPER_PX = 718  # A4 between margins of 10 mm
AXE_VERSION = "4.10.2"
AXE = """
const done = arguments[0];
axe.run(document, {resultTypes: ["violations"]}).then(
  result => done(result.violations
                 .map(one => one.id + ": " + one.help + " (" + one.nodes.length + " times, first " +
                             one.nodes[0].html.slice(0, 120) + ")")),
  error => done(["axe-core failed: " + error]));
"""


def axe_source(folder):
    """The script of axe-core, fetched by npm where it is not in the folder; None, with a note, where it cannot be."""
    file = os.path.join(folder, "axe-core-%s.tgz" % AXE_VERSION)
    if not os.path.exists(file):
        if not shutil.which("npm"):
            print("accessibility not tested: no npm", file=sys.stderr)
            return None
        os.makedirs(folder, exist_ok=True)
        try:
            subprocess.run(["npm", "pack", "--silent", "axe-core@" + AXE_VERSION], cwd=folder, timeout=90, check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        except (subprocess.SubprocessError, OSError):
            print("accessibility not tested: npm could not fetch axe-core", file=sys.stderr)
            return None
    with tarfile.open(file) as archive:
        return archive.extractfile("package/axe.min.js").read().decode("utf-8")


def browser():
    options = Options()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.binary_location = CHROMIUM
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(service=Service(DRIVER), options=options)


def requests(driver, page):
    import json
    found = []
    for entry in driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            url = message["params"]["request"]["url"]
            if url != page and not url.startswith("data:"):
                found.append(url)
    return found


def wait_until_drawn(driver):
    for _ in range(600):
        if driver.execute_script("return document.documentElement.dataset.drawn") == "all":
            time.sleep(0.2)
            return True
        time.sleep(0.05)
    return False


def look_at(driver, page, width, dark, axe):
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": width, "height": 844 if width < 500 else 800, "deviceScaleFactor": 1, "mobile": width < 500})
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                           {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
    driver.get_log("performance")  # of the page before
    driver.get(page)
    if not wait_until_drawn(driver):
        return ["not drawn within 30 s"]
    beyond = driver.execute_script(FIRST) if width > 500 else []
    driver.execute_script("document.querySelectorAll('details').forEach(one => { one.open = true; });")
    time.sleep(0.1)
    if not wait_until_drawn(driver):
        return ["what was unfolded was not drawn within 30 s"]
    faults = ["not on the first screen: " + name for name in beyond]
    faults += ["console: " + entry["message"] for entry in driver.get_log("browser")]
    faults += ["request: " + url for url in requests(driver, page)]
    faults += ["blank: " + str(name) for name in driver.execute_script(BLANK)]
    faults += ["without a name: " + one for one in driver.execute_script(UNNAMED)]
    if driver.execute_script(WIDER):
        faults.append("wider than %d px" % width)
    faults += ["empty: " + str(name) for name in driver.execute_script(EMPTY)]
    charts = driver.execute_script("return document.querySelectorAll('figure.chart').length")
    if driver.execute_script("return document.querySelectorAll('figure').length") == 0:
        faults.append("no figure")
    elif charts > 0 and not dark and width > 500 and not driver.execute_async_script(ZOOM):
        faults.append("zoom or legend do not work")
    if charts > 0 and not dark and width > 500:
        faults += driver.execute_async_script(SAVED)
    if axe:
        driver.execute_script(axe)
        faults += ["axe-core: " + one for one in driver.execute_async_script(AXE)]
    return faults


def print_it(driver, page):
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": PAPER_PX, "height": 1000, "deviceScaleFactor": 1, "mobile": False})
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    driver.get(page)
    wait_until_drawn(driver)
    faults = ["cut on paper: " + one for one in driver.execute_script(CUT)]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    driver.get(page)
    wait_until_drawn(driver)
    pdf = driver.execute_cdp_cmd("Page.printToPDF", {"paperWidth": 8.27, "paperHeight": 11.69, "transferMode":
                                                     "ReturnAsBase64"})
    document = base64.b64decode(pdf["data"])
    if not document.startswith(b"%PDF") or len(document) < 20000:
        faults.append("no PDF")
    pages = len(re.findall(rb"/Type\s*/Page\b", document))
    if pages > 12:
        faults.append("%d pages on paper" % pages)
    return faults


def main():
    driver = browser()
    driver.set_script_timeout(120)
    axe = axe_source(sys.argv[1])
    try:
        for path in sys.argv[2:]:
            for width, dark in ((1280, False), (390, False), (1280, True)):
                for fault in look_at(driver, "file://" + path, width, dark, axe):
                    print("%s, %d px%s: %s" % (path, width, ", dark" if dark else "", fault))
            for fault in print_it(driver, "file://" + path):
                print("%s: %s" % (path, fault))
    finally:
        driver.quit()


if __name__ == "__main__":
    main()
