"""The page's one sentence for every combination of the host's data, judged by its words."""

import itertools
import json

import pytest

import gazesetup
from gazelink import codes

pytestmark = [pytest.mark.browser, pytest.mark.xdist_group("sentence")]

LANGUAGES = ["nl", "en"]
WAIT = {"nl": "Even wachten", "en": "Please wait"}
HELP = {"nl": "Vraag hulp", "en": "Ask for help"}
TABLES = {
    language: json.loads((gazesetup.ROOT / f"web/strings/{language}.json").read_text("utf-8"))
    for language in LANGUAGES
}
MESSAGES = TABLES["nl"]["messages"]
WHO = [("nobody", False), ("driver", True), ("driver", False), ("caretaker", False)]
# All verdicts of the host: its level decides whether it has a message at all.
VERDICTS = [("ok", "ok"), *itertools.product(("warning", "error"), MESSAGES)]
# A request to arm is worth a try: it ends these, or they end by themselves in a moment.
MAY_ASK = ["none", "no_owner", "command_active"]
# A setting's refusal answers who set it; no state reports one.
REASONS = [one for one in codes.REASONS if not one.startswith("setting_")]
FEW = ["none", "no_owner", "neutral_not_proven", "tilt", "obstacle_left", "obstacle_data_old"]


def news(level, message, state, who, arm_reason, override):
    return {
        "level": level,
        "message": message,
        "state": state,
        "owner": who[0],
        "you": who[1],
        "arm_reason": arm_reason,
        "override": override,
    }


def combinations():
    for (level, message), state, who in itertools.product(VERDICTS, codes.STATES, WHO):
        for arm_reason, override in itertools.product(FEW, FEW):
            yield news(level, message, state, who, arm_reason, override)
    for state, who in itertools.product(codes.STATES, WHO):
        for reason in REASONS:
            yield news("ok", "ok", state, who, reason, "none")
            yield news("ok", "ok", state, who, "none", reason)
            yield news("warning", "camera_lost", state, who, reason, reason)


# The page makes the same combinations from their parts, which are 30 MB together. It returns the
# different sentences, and which of them each combination gets.
ASK = """
async ({{verdicts, states, who, few, reasons}}) => {{
  const {{sentence}} = await import("/static/sentence.js");
  const found = [], places = new Map(), chosen = [];
  const ask = ([level, message], state, [owner, you], arm_reason, override) => {{
    const news = {{level, message, state, owner, you, arm_reason, override}};
    for (const [linked, practice] of {modes}) {{
      const one = sentence(news, linked, practice);
      const words = JSON.stringify(one);
      if (!places.has(words)) places.set(words, found.push(one) - 1);
      chosen.push(places.get(words));
    }}
  }};
  for (const verdict of verdicts) for (const state of states) for (const one of who)
    for (const arm of few) for (const override of few) ask(verdict, state, one, arm, override);
  for (const state of states) for (const one of who) for (const reason of reasons) {{
    ask(["ok", "ok"], state, one, reason, "none");
    ask(["ok", "ok"], state, one, "none", reason);
    ask(["warning", "camera_lost"], state, one, reason, reason);
  }}
  return [found, chosen];
}}
"""
MODES = ((True, False), (True, True), (False, False))  # linked, practice


@pytest.fixture(scope="module")
def outcomes(chromium, serve):
    """[(news, linked, practice, sentence)] of every combination."""
    host = serve()
    page = chromium.new_page()
    page.goto(f"{host.url}pair")
    requested = [(one, *mode) for one in combinations() for mode in MODES]
    parts = {
        "verdicts": VERDICTS,
        "states": codes.STATES,
        "who": WHO,
        "few": FEW,
        "reasons": REASONS,
    }
    shown, chosen = page.evaluate(ASK.format(modes=json.dumps(MODES)), parts)
    unknown = page.evaluate(
        "async () => (await import('/static/sentence.js')).sentence(null, false, false)"
    )
    page.close()
    assert unknown["key"] == "link_lost"
    return [(*question, shown[at]) for question, at in zip(requested, chosen, strict=True)]


def advice(key, language):
    """The advice in the words: "help", "wait", "act" or "" for none."""
    do = TABLES[language]["messages"][key]["do"]
    if not do:
        return ""
    if do.startswith(WAIT[language]):
        return "wait"
    return "help" if do.startswith(HELP[language]) else "act"


def keys_shown(shown):
    """Message keys shown on the page at once: in the corner, and in the middle."""
    middle = [shown["words"]] if shown["kind"] in ("hindered", "override") else []
    return {shown["key"], *middle}


def test_at_most_one_message_is_told_at_a_time(outcomes):
    for question in outcomes:
        assert len(keys_shown(question[3])) == 1, question


def test_nothing_is_in_order_while_something_is_not(outcomes):
    for one, linked, practice, shown in outcomes:
        if shown["level"] == "ok":
            assert shown["key"] == "ok", one
            assert linked, one
            assert one["level"] == "ok", one
        else:
            assert shown["key"] != "ok" or one["message"] == "ok", one
        if not practice and (one["level"] == "error" or not linked):
            assert shown["kind"] != "ready", one


def test_without_a_link_only_that_is_said(outcomes):
    for one, linked, _, shown in outcomes:
        if not linked:
            assert (shown["key"], shown["kind"]) == ("link_lost", "none"), one


def test_who_took_over_is_told_whenever_somebody_else_drives(outcomes):
    for one, linked, practice, shown in outcomes:
        others = one["owner"] != "nobody" and not one["you"] and one["state"] != "disarmed"
        taken = linked and not practice and others
        assert (shown["kind"] == "taken") == taken, one
        if taken:
            assert shown["words"] == f"owner_{one['owner']}", one


def test_ready_is_said_only_where_a_look_would_arm(outcomes):
    for one, _, practice, shown in outcomes:
        if shown["kind"] == "ready":
            assert one["state"] == "disarmed", one
            assert practice or one["arm_reason"] in MAY_ASK, one


@pytest.mark.parametrize("language", LANGUAGES)
def test_amber_only_where_something_is_to_be_done(outcomes, language):
    for one, _, _, shown in outcomes:
        if shown["level"] == "warning":
            assert advice(shown["key"], language) != "wait", (one, shown)


@pytest.mark.parametrize("language", LANGUAGES)
def test_who_can_only_wait_is_told_by_a_calm_corner(outcomes, language):
    for one, _, _, shown in outcomes:
        if shown["level"] == "wait":
            assert advice(shown["key"], language) == "wait", (one, shown)


@pytest.mark.parametrize("language", LANGUAGES)
def test_both_languages_advise_the_same(language):
    for key in MESSAGES:
        assert (advice(key, "nl") == "wait") == (advice(key, language) == "wait"), key
