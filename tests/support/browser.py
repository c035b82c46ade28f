# SPDX-License-Identifier: GPL-3.0-or-later
"""What reaches beyond a page in a browser window of some width, told by a Chromium without a screen."""
import json
import os
import re
import shutil
import subprocess
import tempfile
from html import escape, unescape
from pathlib import Path

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# The page stands in a frame of the wanted width: browsers do not make windows as narrow as a phone.
PAGE = """<!doctype html><body style="margin:0"><iframe id=f width={width} height=4000 style="border:0" srcdoc="{page}"></iframe>
<pre id=out></pre><script>
document.getElementById("f").onload = event => {{
  const page = event.target.contentDocument, root = page.documentElement, found = [];
  for (const one of page.body.querySelectorAll("*")) {{
    const box = one.getBoundingClientRect();
    if (box.width && (box.right > {width} + 0.5 || box.left < -0.5 || one.scrollWidth > one.clientWidth + 1 && one.clientWidth
        && getComputedStyle(one).display != "inline"))
      found.push(one.tagName + " " + (one.id || one.className) + " " + (one.textContent || "").slice(0, 40));
  }}
  document.getElementById("out").textContent = JSON.stringify({{width: root.scrollWidth, found: found, text: root.innerText.length}});
}};
</script></body>"""


def find_browser():
    """The program, or None; FLUSI_BROWSER names another one."""
    return os.environ.get("FLUSI_BROWSER") or next((path for path in map(shutil.which, NAMES) if path), None)


def look_at(browser, html, width):
    """{"width": of the content, "found": [what reaches beyond the window or is cut], "text": characters} at `width` pixels."""
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "page.html"
        page.write_text(PAGE.format(width=width, page=escape(html)), encoding="utf-8")
        done = subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/profile",
                               "--virtual-time-budget=5000", f"--window-size={max(width, 800)},1200", "--dump-dom", page.as_uri()],
                              capture_output=True, text=True, timeout=120)
    told = re.search(r"<pre id=\"out\">(.*?)</pre>", done.stdout, re.S)
    if not told or not told[1]:
        raise RuntimeError(f"{browser} says nothing of the page: {done.stderr[-500:]}")
    return json.loads(unescape(told[1]))
