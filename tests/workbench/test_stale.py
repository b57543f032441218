"""What a page shows of an old state can do nothing: the server refuses actions on it, and the page
is inert while another state is computed or no server answers. It sends its token to no other
server, and continues when its own is back.
"""

import http.server
import json
import re
import shlex
import signal
import threading
import time
import urllib.parse

from playwright.sync_api import expect
from recordings_made import two_axes
from visiting import accessible, altered, effects, held_back, ranked, until

ARW = {"coefficient_deg_per_sqrt_h": 1.0}
DROP = """() => {
  const given = new DataTransfer();
  given.items.add(new File(["1,2"], "a.csv"));
  document.dispatchEvent(new DragEvent("drop", { dataTransfer: given, cancelable: true }));
}"""


def inert(page):
    return page.evaluate("document.getElementById('bench').inert")


def test_an_action_says_for_which_state_and_kind_it_is_meant(folder, opened):
    bench = opened(two_axes(folder / "rec.csv"))
    first, second = (one["kind"] for one in bench.ask("candidates")["candidates"][:2])
    for given in ({"place": 0, "kind": second}, {"place": 0, "kind": "nonsense"}):
        assert bench.act("add", **given)[0] == 409, given
    state = bench.ask("step")["state"]
    for given in ({"place": 0}, {"place": 0, "kind": first}, {"place": 0, "state": state}):
        assert bench.request("/api/add", json.dumps(given).encode())[0] == 400, given
    bench.done("add", place=0, kind=first)
    assert bench.act("refit", state=state)[0] == 409
    bench.done("go", number=0)
    assert bench.ask("step")["state"] == state  # as the page was
    bench.done("remove", place=1)
    zero = {"coefficient_deg_per_sqrt_h": 0.0}  # nothing can be compared with a model without noise
    assert bench.act("set", place=0, parameters=zero)[0] == 400
    assert len(bench.ask("all")["steps"]) == 3  # what was refused leaves no step
    bench.done("selection", column="gyro_x_dps")
    for what, more in (  # of the other axis
        ("add", {"place": 0, "kind": first}),
        ("refit", {}),
        ("go", {"number": 0}),
        ("line", {"f_hz": 5.0}),
        ("remove", {"place": 1, "kind": "bias_instability"}),
        ("set", {"place": 0, "kind": "angle_random_walk", "parameters": ARW}),
    ):
        assert bench.act(what, state=state, **more)[0] == 409, what
    assert bench.request(f"/api/save?what=toml&state={state}")[0] == 409
    assert len(bench.ask("all")["steps"]) == 1


def test_add_takes_over_the_preview_of_its_card(folder, opened):
    bench = opened(two_axes(folder / "rec.csv", rows=40000))
    given = {"place": bench.candidate("low_pass"), "kind": "low_pass"}  # takes several fits
    given["state"], seen = bench.ask("step")["state"], []

    def candidate_preview():
        query = urllib.parse.urlencode(given)
        seen.append(json.loads(bench.request(f"/api/candidate_preview?{query}")[1]))

    preview = threading.Thread(target=candidate_preview)
    preview.start()
    time.sleep(0.1)  # it runs, or waits for the worker
    bench.done("add", **given)
    preview.join()
    assert "superseded" not in seen[0]
    assert seen[0]["error"] == bench.ask("step")["error"]


def test_while_another_axis_is_computed_nothing_of_the_old_one_can_be_added(folder, opened, tabs):
    bench = opened(two_axes(folder / "rec.csv"))
    page = tabs.open(bench)
    old = ranked(page)
    assert old.inner_text() == "Add"
    late = held_back(page, re.compile("/api/step"))
    page.select_option("#axis", "gyro_x_dps")
    until(page, lambda: late)  # the answer is under way, the old list is still there
    expect(old).to_be_visible()
    assert inert(page)
    page.keyboard.press("1")
    page.keyboard.press("w")
    box = old.bounding_box()
    page.mouse.click(box["x"] + 20, box["y"] + 10)
    for name in ("undo", "redo", "export"):
        assert page.locator(f"#{name}").is_disabled(), name
    page.wait_for_timeout(300)
    assert len(bench.ask("all")["steps"]) == 1
    for route in late:
        route.continue_()
    page.unroute(re.compile("/api/step"))
    fresh = ranked(page)
    expect(page.locator("#bench")).to_have_js_property("inert", False)
    wanted = fresh.get_attribute("data-kind")
    fresh.click()
    effects(page, 3)
    assert wanted in [card["kind"] for card in bench.ask("step")["cards"]]
    assert bench.ask("all")["column"] == "gyro_x_dps"


def test_a_key_adds_the_card_that_was_on_the_screen_when_it_was_pressed(opened, tabs):
    """Three candidates of equal evidence, whose cards change places with the errors that arrive."""
    bench, late = opened(), []
    page = tabs.open(bench)

    def alike(route, answer):
        for one in answer["candidates"]:
            place = one["place"]
            one |= {"beyond_chance": place < 3, "doubt": "", "leader": place, "gain": 100.0}
        return answer

    def foreseen(route):
        place = int(
            urllib.parse.parse_qs(urllib.parse.urlsplit(route.request.url).query)["place"][0]
        )
        answer = route.fetch(timeout=0)
        lower = {**answer.json(), "error": (0.003, 0.002, 0.001)[place]}
        if place == 2:
            late.append(lambda: route.fulfill(response=answer, json=lower))
        else:
            route.fulfill(response=answer, json=lower)

    altered(page, re.compile("/api/candidates"), alike)
    page.route(re.compile("/api/candidate_preview"), foreseen)
    page.click("#tutorial")
    first = page.locator("#next .best button.candidate")
    expect(first).to_have_attribute("data-place", "1")
    until(page, lambda: late)
    page.wait_for_timeout(100)
    before = page.evaluate("performance.now()")
    late[0]()
    expect(first).to_have_attribute("data-place", "2")
    press = "async (time) => (await import('/page/parts/next.js')).pressed(0, time)"
    with page.expect_request(re.compile("/api/add")) as sent:
        page.evaluate(press, before)
    assert sent.value.post_data_json["place"] == 1
    effects(page, 3)


def test_a_tab_whose_server_was_killed_says_what_is_kept_and_what_to_type(folder, started, tabs):
    bench = started(two_axes(folder / "my rec.csv"))
    page = tabs.open(bench)
    ranked(page).click()
    effects(page, 3)
    ranked(page)
    assert bench.stop(signal.SIGKILL)[0] == -signal.SIGKILL
    gone = page.locator("#gone")
    expect(gone).to_be_visible()
    expect(gone).to_contain_text("The 2 steps are saved in")
    command = f"tools/davarlab open '{folder}/my rec.csv' --port {bench.port}"
    expect(gone.locator("code")).to_have_text(command)
    page.keyboard.press("1")
    page.wait_for_timeout(1500)  # it has tried to come back meanwhile
    expect(page.locator("#error")).to_be_hidden()
    for words in ("nothing is lost", "Failed to fetch"):
        assert words not in page.inner_text("body")
    assert inert(page)
    accessible(page)
    # what it says is true, also without the recording
    for words in (shlex.split(command)[2:], ["--port", str(bench.port)]):
        again = started(*words)
        assert again.token == bench.token
        expect(gone).to_be_hidden()
        expect(page.locator("#bench")).to_have_js_property("inert", False)
        ranked(page)
        assert [one["number"] for one in again.ask("all")["steps"]] == [0, 1]
        again.stop(signal.SIGKILL)
        expect(gone).to_be_visible()
    tabs.forgive()


def test_a_tab_gives_its_token_to_no_other_server_on_its_port(folder, started, tabs):
    two_axes(folder / "rec.csv")
    bench = started("rec.csv")
    page, sent = tabs.open(bench), []
    ranked(page)
    bench.stop(signal.SIGKILL)
    gone = page.locator("#gone")
    expect(gone).to_be_visible()

    class Thief(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            sent.append(self.path + str(self.headers))
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"00" * 32)

        do_POST = do_GET

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", bench.port), Thief) as thief:
        threading.Thread(target=thief.serve_forever, daemon=True).start()
        expect(gone).to_contain_text("Another server uses this address")
        until(page, lambda: len(sent) > 2)
        page.click("#close")
        page.evaluate(DROP)
        page.wait_for_timeout(300)
        thief.shutdown()
    assert {one.split("?")[0] for one in sent} == {"/proof"}
    assert bench.token not in "".join(sent)
    (kept,) = (started.state / "davarlab").glob(f"{bench.port}.token")
    assert kept.parent.stat().st_mode & 0o777 == 0o700
    kept.write_text("x" * 22)  # of a server with another token
    other = started("--port", str(bench.port))
    assert other.token != bench.token
    expect(gone).to_contain_text("Another server uses this address")
    other.stop()
    kept.write_text(bench.token)
    kept.parent.chmod(0o755)  # others could read it: a new token
    assert started("--port", str(bench.port)).token != bench.token
    tabs.forgive()
