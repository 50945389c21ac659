"""Programs in the console's page: from a key to the faults that are shown, and from a step to the line that is lit.

Both are taken by the page's own clock, from the event of the key or the button to the change of what it shows. So they
hold the way to the language server and the debugger and back, over the console's WebSocket, besides their work.
"""

from __future__ import annotations

import statistics

from playwright.sync_api import Page

from benchmarks.processes import kernel
from benchmarks.rapid import LINES, LOOP, motion
from benchmarks.rows import Row, row
from tests.apps.console.browsing import PLAIN, browsers
from tests.apps.console.consoles import consoles

ROUNDS = 20

TAKEN = """() => {
  const root = %s, shown = () => %s;
  const before = shown();
  window.taken = new Promise((done) => {
    let since;
    addEventListener("%s", ({ timeStamp }) => { since = timeStamp; }, { capture: true, once: true });
    const look = new MutationObserver(() => {
      const now = shown();
      if (since === undefined || now === undefined || now === before) return;
      look.disconnect();
      done(performance.now() - since);
    });
    look.observe(root, { subtree: true, childList: true, characterData: true, attributes: true });
  });
}"""
"""Keeps the time (ms) from an event to the next change of what is shown; undefined is shown by nothing."""
FAULTS = TAKEN % ("document.body", 'root.querySelector("#first-fault")?.textContent ?? ""', "keydown")
LIT = TAKEN % (
    'document.querySelector(".code > .text").shadowRoot',
    'root.querySelector(".cm-stands")?.textContent',
    "click",
)


def opened(page: Page, file: str, text: str) -> None:
    """Have a file opened, which moves nothing."""
    page.set_input_files("#open-code", {"name": file, "mimeType": "text/plain", "buffer": text.encode()})
    page.get_by_label("Robot that it moves").select_option("")
    page.get_by_label("Program's text").get_by_text(text.splitlines()[0]).wait_for()


def faults(page: Page) -> list[float]:
    """Return the times (ms) from a semicolon that is taken away, or written, to the faults that are told."""
    opened(page, "motion.mod", motion())
    page.locator("#first-fault").wait_for(state="detached")
    page.get_by_label("Program's text").get_by_text("PERS robtarget").click()
    page.keyboard.press("End")
    taken = []
    for number in range(ROUNDS):
        page.evaluate(FAULTS)
        page.keyboard.press(";" if number % 2 else "Backspace")
        taken.append(page.evaluate("window.taken"))
    return taken


def steps(page: Page) -> list[float]:
    """Return the times (ms) from a step over a statement to the line that is lit."""
    opened(page, "loop.mod", LOOP)
    page.get_by_role("button", name="Step", exact=True).click()
    page.locator(".cm-stands").wait_for()
    taken = []
    for _ in range(ROUNDS):
        page.evaluate(LIT)
        page.get_by_title("Over:").click()
        taken.append(page.evaluate("window.taken"))
    return taken


def run() -> list[Row]:
    """Return the medians; budgets: 2,000 lines in 150 ms, a step in 50 ms."""
    with (
        kernel("--headless") as (address, _),
        consoles(address) as console,
        browsers() as browser,
    ):
        page = browser.new_page(viewport={"width": 1100, "height": 700})
        page.set_default_timeout(30_000.0)
        page.goto(console.url + PLAIN)
        page.get_by_role("tab", name="Code").click()
        page.locator("#open-code").wait_for(state="attached")
        rows = []
        for what, taken, budget in (
            (f"{LINES} lines in the page: from a key to the faults shown", faults(page), 150.0),
            ("a step in the page: from the button to the line lit", steps(page), 50.0),
        ):
            note = f"median of {ROUNDS}; longest {max(taken):.0f} ms"
            rows.append(row(what, statistics.median(taken), budget, f"{budget:g} ms", "ms", 1.0, note))
        return rows


if __name__ == "__main__":
    for result in run():
        print(result)
