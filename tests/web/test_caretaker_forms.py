"""The caretaker's settings, the people who drive, and the pairing of devices."""

import pytest

from patience import wait_until
from webperson import CARETAKER, SETTINGS, Driver

pytestmark = pytest.mark.browser


@pytest.fixture
def caretaker(page, host):
    page.set_viewport_size({"width": 390, "height": 844})
    host.welcome["role"] = "caretaker"
    host.replies.update(CARETAKER)
    host.state.update(you=False, owner="nobody", state="disarmed")
    person = Driver(page, host)
    person.open("caretaker")
    return person


def tab(caretaker, name, waits_for):
    caretaker.page.locator(f"#tab-{name}").click()
    wait_until(lambda: caretaker.page.locator(waits_for).count(), waits_for)


def change(caretaker, name, value):
    caretaker.page.locator(f"[name={name}]").fill(value)
    caretaker.page.locator(f"[name={name}]").blur()


def test_a_setting_of_the_chair_is_shown_in_plain_units_and_saved(caretaker, host, artefact):
    tab(caretaker, "settings", "#chair .row")
    artefact("caretaker-settings")
    assert caretaker.page.locator("[name=step_forward_ms]").input_value() == "2"
    change(caretaker, "step_forward_ms", "1.5")
    wait_until(lambda: host.posted, "the setting")
    assert host.posted == [("/settings", {"set": {"step_forward_ms": 1500}})]


def test_a_refused_setting_says_why_and_shows_what_is_in_force(caretaker, host):
    tab(caretaker, "settings", "#chair .row")
    host.replies["POST /settings"] = 409, {"reason": "setting_while_armed", "detail": ""}
    change(caretaker, "step_forward_ms", "1.5")
    wait_until(lambda: "rijden aan staat" in caretaker.text("#banner"), "the reason")
    shown = caretaker.page.locator("[name=step_forward_ms]")
    wait_until(lambda: shown.input_value() == "2", "what is in force")
    # Set, but not stored.
    row = {**SETTINGS["step_forward_ms"], "value": 1200}
    host.replies["GET /settings"] = 200, {"settings": {**SETTINGS, "step_forward_ms": row}}
    host.replies["POST /settings"] = 507, {"reason": "setting_not_stored", "detail": ""}
    change(caretaker, "step_forward_ms", "1.2")
    wait_until(lambda: "niet bewaard" in caretaker.text("#banner"), "the reason")
    wait_until(lambda: shown.input_value() == "1.2", "what is in force")


def test_a_number_that_is_emptied_is_not_0(caretaker, host):
    tab(caretaker, "settings", "#chair .row")
    for name in ("leave_grace_ms", "step_forward_ms"):
        field = caretaker.page.locator(f"[name={name}]")
        shown = field.input_value()
        change(caretaker, name, "")
        assert field.input_value() == shown
    caretaker.page.evaluate("fetch('/me').then((answer) => answer.text())")
    assert host.posted == []
    assert host.profiles.chosen()["leave_grace_ms"] == 200
    change(caretaker, "leave_grace_ms", "0")
    wait_until(lambda: host.profiles.chosen()["leave_grace_ms"] == 0, "a real 0")


def test_what_is_typed_stays_when_the_host_answers(caretaker, host):
    tab(caretaker, "settings", "#profiles .row")
    caretaker.page.locator("[name=dwell_ms]").press_sequentially("7")
    typed = caretaker.page.locator("[name=dwell_ms]").input_value()
    host.profiles.change({"save": {"id": "1", "name": "Piet"}}, True)
    caretaker.state()
    wait_until(lambda: caretaker.page.locator("[name=name]").input_value() == "Piet", "it")
    assert caretaker.page.locator("[name=dwell_ms]").input_value() == typed
    assert caretaker.page.evaluate("document.activeElement.name") == "dwell_ms"


@pytest.mark.parametrize("meanwhile", [False, True])
def test_what_is_put_back_is_no_edit(caretaker, host, meanwhile):
    tab(caretaker, "settings", "#profiles .row")
    field = caretaker.page.locator("[name=dwell_ms]")
    name = caretaker.page.locator("[name=name]")
    field.press("End")
    field.press_sequentially("7")

    def changes():
        host.profiles.change({"save": {"id": "1", "dwell_ms": 900, "name": "Piet"}}, True)
        caretaker.state()
        wait_until(lambda: name.input_value() == "Piet", "the name")

    if meanwhile:
        changes()
    field.press("Backspace")
    field.press("Tab")
    if not meanwhile:
        changes()
    wait_until(lambda: field.input_value() == "0.9", "what is in force")
    assert host.posted == []


def test_people_are_made_chosen_tuned_and_deleted(caretaker, host):
    tab(caretaker, "settings", "#profiles .row")
    caretaker.page.locator("#profiles button").first.click()
    wait_until(lambda: len(host.profiles.as_json()["profiles"]) == 2, "the new one")
    caretaker.state()
    wait_until(lambda: caretaker.page.locator("[name=person] option").count() == 2, "its name")
    caretaker.page.locator("[name=person]").select_option("2")
    wait_until(lambda: host.profiles.as_json()["chosen"] == "2", "the choice")
    wait_until(lambda: caretaker.page.locator("[name=name]").input_value() == "Nieuw", "it")
    change(caretaker, "name", "Jan")
    wait_until(lambda: host.profiles.chosen()["name"] == "Jan", "the name")
    change(caretaker, "dwell_ms", "0.9")
    wait_until(lambda: host.profiles.chosen()["dwell_ms"] == 900, "the time")
    change(caretaker, "dwell_ms", "99")
    wait_until(lambda: "Deze waarde kan niet" in caretaker.text("#banner"), "the reason")
    delete = caretaker.page.locator("#profiles .sure")
    delete.dblclick()
    assert delete.inner_text() == "Zeker weten?"
    caretaker.run_for(6000)
    assert delete.inner_text() == "Verwijderen"
    delete.click()
    assert len(host.profiles.as_json()["profiles"]) == 2
    caretaker.run_for(600)
    delete.click()
    wait_until(lambda: len(host.profiles.as_json()["profiles"]) == 1, "it to be gone")


def test_a_new_code_has_a_qr_picture_and_ends(caretaker, host, artefact):
    tab(caretaker, "pairing", "#devices li")
    caretaker.page.locator("#invite button").first.click()
    wait_until(lambda: caretaker.page.locator(".qr").count(), "the QR code")
    assert host.posted == [("/pairing/code", {"role": "driver"})]
    assert caretaker.text(".code-sheet .code") == "K7QM-2XWD"
    assert "5:00" in caretaker.text(".code-sheet")
    artefact("caretaker-pairing")
    caretaker.run_for(61_000)
    assert "3:59" in caretaker.text(".code-sheet")
    caretaker.run_for(240_000)
    assert caretaker.page.locator(".qr").count() == 0


def test_a_device_is_revoked_by_a_second_press(caretaker, host):
    tab(caretaker, "pairing", "#devices li")
    assert "tablet" in caretaker.text("#devices")
    button = caretaker.page.locator("#devices button").first
    button.click()
    assert button.inner_text() == "Zeker weten?"
    button.click()  # a double tap
    assert host.posted == []
    caretaker.run_for(600)
    button.click()
    wait_until(lambda: host.posted, "the wish")
    assert host.posted == [("/pairing/revoke", {"id": "3fa2b1"})]
    wait_until(lambda: caretaker.page.locator("#devices li.gone").count() == 1, "it to be gone")
    assert button.is_disabled()


def test_a_revoked_phone_goes_to_the_pairing_page(caretaker, page, host):
    host.close(4001)
    page.wait_for_url("**/pair")
