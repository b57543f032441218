"""The workbench's server answers only the page that has its token, from its own origin, on this
machine. In this process."""

import json

import pytest
from lab_asgi import HOST, TOKEN, Page

FOREIGN = "http://example.invalid"
PLACES = {
    "no token": (None, f"http://{HOST}", HOST),
    "another token": ("u" * 22, f"http://{HOST}", HOST),
    "the beginning of the token": (TOKEN[:-1], f"http://{HOST}", HOST),
    "an empty token": ("", f"http://{HOST}", HOST),
    "another origin": (TOKEN, FOREIGN, HOST),
    "another port of this machine": (TOKEN, "http://127.0.0.1:8001", HOST),
    "another host": (TOKEN, None, "example.invalid"),
}


@pytest.fixture
def page(tmp_path):
    made = Page(tmp_path)
    yield made
    made.close()


@pytest.mark.parametrize("name", PLACES)
def test_a_websocket_without_token_origin_or_host_is_refused(page, name):
    token, origin, host = PLACES[name]
    query = "" if token is None else f"?token={token}"
    with page.tab(f"/events{query}", x_davar_token=None, origin=origin, host=host) as (got, _):
        first = got(1)
    assert first["type"] != "websocket.accept"
    assert first.get("code") == 4403 or first.get("status") == 400, first
    assert page.server.tabs == set()


@pytest.mark.parametrize("origin", [None, f"http://{HOST}"])
def test_a_websocket_with_the_token_is_accepted_and_gets_every_event(page, origin):
    with page.tab(f"/events?token={TOKEN}", x_davar_token=None, origin=origin) as (got, send):
        assert got(1)["type"] == "websocket.accept"
        send(type="websocket.receive", bytes=b"\0\1")
        send(type="websocket.receive", text="text")
        page.server.tell(changed=3)
        assert json.loads(got(2)["text"]) == {"changed": 3}
    assert page.server.tabs == set()


@pytest.mark.parametrize("name", PLACES)
def test_no_request_is_answered_without_them(page, name):
    token, origin, host = PLACES[name]
    given = {"x_davar_token": token, "origin": origin, "host": host}
    for path, data in (("/", None), ("/api/all", None), ("/api/go", b"{}"), ("/api/drop", b"x")):
        assert page.request(path, data, **given)[0] in (400, 403), path


def test_the_token_in_a_header_or_in_the_address_opens_the_page(page):
    assert page.request("/api/all")[0] == 200
    assert page.request(f"/api/all?token={TOKEN}", x_davar_token=None)[0] == 200
    status, body = page.request(f"/?token={TOKEN}", x_davar_token=None)
    assert (status, b"<title>" in body) == (200, True)


def test_code_runs_only_for_a_person_at_this_machine(page, tmp_path):
    """Not through a proxy, not without an origin, and not on a server that nobody at a terminal
    has started."""
    for headers in (
        {"origin": None},
        *({name: "10.0.0.1"} for name in ("forwarded", "x_forwarded_for", "x_real_ip", "via")),
    ):
        assert page.request("/api/check_own", b"{}", **headers)[0] == 403, headers
    assert page.request("/api/check_own", b"{}")[0] == 400  # it lacks its fields
    unattended = Page(tmp_path, code=False)
    assert unattended.request("/api/check_own", b"{}")[0] == 403
    unattended.close()


def test_a_kind_of_request_has_its_method(page):
    assert page.request("/api/go")[0] == 404
    assert page.request("/api/all", b"{}")[0] == 404
    assert page.request("/api/nothing", b"{}")[0] == 404


def test_a_tab_that_comes_back_can_test_the_server_first(page):
    import hashlib
    import hmac

    nonce = "n" * 16
    expected = hmac.new(TOKEN.encode(), nonce.encode(), hashlib.sha256).hexdigest()
    got = page.request(f"/proof?nonce={nonce}", x_davar_token=None)
    assert got == (200, expected.encode())
    for wrong in ("n" * 15, "n" * 65, ""):
        assert page.request(f"/proof?nonce={wrong}", x_davar_token=None)[0] == 400
