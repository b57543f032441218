"""Everything stays on this machine: a script of the page has no way out, and the page names no
other address. In the other browser tests, a request to another origin or a popup is a fault (Tabs).
Reports fetch nothing: tests/lab/test_report.py.
"""

import re
import socketserver
import threading

from davarlab.workbench import server
from playwright.sync_api import expect
from visiting import until

# Every way out of a page that a script has, short of leaving the page.
WAYS_OUT = """async (there) => {
  const link = Object.assign(document.createElement("a"), { href: there, target: "_blank" });
  const form = Object.assign(document.createElement("form"),
    { action: there, method: "post", target: "_blank" });
  const frame = Object.assign(document.createElement("iframe"), { src: there });
  const picture = Object.assign(document.createElement("img"), { src: there });
  const script = Object.assign(document.createElement("script"), { src: there });
  document.body.append(link, form, frame, picture, script);
  link.click();
  form.submit();
  navigator.sendBeacon(there, "data");
  try { new WebSocket(there.replace("http", "ws")); } catch { /* refused */ }
  const fetched = await fetch(there).then(() => true, () => false);
  return [window.open(there) !== null, fetched];
}"""


def test_the_policy_leaves_a_script_no_way_out(chromium, opened, tabs):
    came = []

    def take(request, client, server):
        sent = request.recv(100)
        if sent:  # a browser may connect ahead of a request that it then refuses to send
            came.append(sent)

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), take) as elsewhere:
        elsewhere.daemon_threads = True
        threading.Thread(target=elsewhere.serve_forever, daemon=True).start()
        there = f"http://127.0.0.1:{elsewhere.server_address[1]}/"
        bare = chromium.new_page()
        bare.evaluate(WAYS_OUT, there + "bare")
        until(bare, lambda: len(came) >= 4)  # a page without the policy gets out
        bare.context.close()
        page = tabs.open(opened())
        expect(page.locator("#tutorial")).to_be_visible()
        assert page.evaluate(WAYS_OUT, there + "page") == [False, False]
        page.wait_for_timeout(500)
        elsewhere.shutdown()
    # the last ones of the page without it may come late
    assert [sent for sent in came if b" /bare" not in sent] == []
    tabs.foreign.clear()  # requests that the browser has refused
    tabs.forgive()


def test_the_page_names_no_other_address():
    sources = [path for path in server.PAGE.rglob("*") if path.suffix in (".html", ".js", ".css")]
    assert len(sources) > 20
    found = {one for path in sources for one in re.findall(r"https?://[\w.]+", path.read_text())}
    assert found <= {"http://www.w3.org"}  # of SVG
