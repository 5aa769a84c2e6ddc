"""Pairing a device: a code typed or from the address, what goes wrong in words, by keyboard."""

import pytest

from fakehost import FakeHost
from patience import wait_until

pytestmark = pytest.mark.browser

WRONG = {"reason": "wrong_code", "detail": "for the log"}


class Newcomer:
    """A person with a device that is not paired yet."""

    def __init__(self, page, host: FakeHost) -> None:
        self.page = page
        self.host = host
        host.replies["GET /me"] = 401, {"reason": "not_paired", "detail": ""}

    def open(self, rest=""):
        self.page.goto(f"{self.host.url}pair{rest}")
        focus = "document.activeElement?.id"
        wait_until(lambda: self.page.evaluate(focus) == "code", "the page to be ready")

    def answer(self, kind):
        self.page.wait_for_selector(f"#answer[data-kind={kind}]")
        return self.page.locator("#answer").inner_text()


@pytest.fixture
def newcomer(page, host):
    page.set_viewport_size({"width": 390, "height": 844})
    return Newcomer(page, host)


def test_a_typed_code_pairs_by_keyboard_alone(newcomer, page, host, artefact):
    host.replies["POST /pair"] = 200, {"role": "driver"}
    newcomer.open()
    artefact("pair-empty")
    page.keyboard.type("k7qm-2xwd")
    page.keyboard.press("Tab")
    page.keyboard.type("tablet van Jan")
    page.keyboard.press("Enter")
    page.wait_for_url(host.url)
    assert host.posted == [("/pair", {"code": "k7qm-2xwd", "name": "tablet van Jan"})]


def test_the_code_in_the_address_is_used_at_once_and_leaves_it(newcomer, page, host):
    host.replies["POST /pair"] = 403, WRONG
    newcomer.open("?lang=en#K7QM-2XWD")
    assert "already used" in newcomer.answer("error")
    assert host.posted == [("/pair", {"code": "K7QM-2XWD"})]
    assert page.url == f"{host.url}pair?lang=en"
    assert page.evaluate("document.documentElement.lang") == "en"


def test_a_wrong_code_says_so_and_can_be_typed_again(newcomer, page, host, artefact):
    host.replies["POST /pair"] = 403, WRONG
    newcomer.open("#AAAA-AAAA")
    assert "klopt niet" in newcomer.answer("error")
    artefact("pair-wrong")
    host.replies["POST /pair"] = 200, {"role": "caretaker"}
    page.keyboard.type("BBBB-BBBB")  # the wrong one is selected: typing replaces it
    page.keyboard.press("Enter")
    page.wait_for_url(host.url)
    assert host.posted[-1] == ("/pair", {"code": "BBBB-BBBB"})


def test_enter_that_is_held_is_one_guess(newcomer, page, host):
    host.replies["POST /pair"] = 403, WRONG
    newcomer.open()
    page.keyboard.type("AAAA-AAAA")
    page.keyboard.down("Enter")
    newcomer.answer("error")
    page.keyboard.down("Enter")  # its repetition
    page.keyboard.up("Enter")
    page.keyboard.type("BBBB-BBBB")
    page.keyboard.press("Enter")
    wait_until(lambda: ("/pair", {"code": "BBBB-BBBB"}) in host.posted, "the second code")
    assert [words["code"] for _, words in host.posted] == ["AAAA-AAAA", "BBBB-BBBB"]


def test_after_too_many_guesses_the_code_is_sent_when_the_wait_is_over(
    newcomer, page, host, artefact
):
    host.replies["POST /pair"] = 429, {"reason": "too_many_guesses", "detail": "", "wait_s": 12}
    newcomer.open("#AAAA-AAAA")
    assert "12 s" in newcomer.answer("error")
    artefact("pair-wait")
    assert page.locator("#go").is_disabled()
    page.evaluate("spied.run(5000)")
    assert "7 s" in newcomer.answer("error")
    assert len(host.posted) == 1
    host.replies["POST /pair"] = 403, WRONG
    page.evaluate("spied.run(7500)")
    wait_until(lambda: page.locator("#go").is_enabled(), "the second answer")
    assert "klopt niet" in newcomer.answer("error")
    assert host.posted == [("/pair", {"code": "AAAA-AAAA"})] * 2


def test_a_code_deleted_during_the_wait_can_be_typed_again(newcomer, page, host):
    host.replies["POST /pair"] = 429, {"reason": "too_many_guesses", "detail": "", "wait_s": 3}
    newcomer.open("#AAAA-AAAA")
    assert "3 s" in newcomer.answer("error")
    page.locator("#code").fill("")
    page.evaluate("spied.run(4500)")
    assert "nog geen code" in newcomer.answer("error")
    assert page.locator("#go").is_enabled()
    assert len(host.posted) == 1


def test_no_code_and_no_host_are_said_in_words(newcomer, page, host):
    newcomer.open()
    page.keyboard.press("Enter")
    assert "nog geen code" in newcomer.answer("error")
    page.route("**/pair", lambda route: route.abort())
    page.keyboard.type("K7QM2XWD")
    page.keyboard.press("Enter")
    wait_until(lambda: "antwoordt niet" in newcomer.answer("error"), "the reason")
    assert host.posted == []


@pytest.mark.parametrize("size", [(320, 568), (390, 844), (1920, 1080)], ids=lambda s: f"{s[0]}")
def test_everything_fits_on_any_screen(newcomer, page, size, artefact):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    newcomer.open()
    artefact(f"pair-{size[0]}")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert all(
        page.locator(name).bounding_box()["height"] >= 44 for name in ("#code", "#name", "#go")
    )
