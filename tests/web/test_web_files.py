"""The page's files: texts for everything on the wire, small, self-contained, CSP-safe."""

import json
import re
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

from gazechair import first_drive
from gazechair.base import supervisor
from gazechair.base.health import STATES
from gazechair.base.languages import languages
from gazechair.board import caretaker_settings
from gazechair.first_drive.facts import STEPS
from gazechair.people.profiles import fields
from gazechair.plugins.child import LOST, RAISED, SETTING, STARTING
from gazechair.plugins.found import GROUPS
from gazechair.plugins.service import MISSING
from gazechair.producers import tiles
from gazechair.sensing.mapping import making
from gazechair.sensing.mapping.making import ASKEW, BROKEN, FULL, SILENT
from gazechair.sensing.mapping.stored import places
from gazechair.web.minify import minified
from gazelink import codes

SUPERVISOR = Path(supervisor.__file__)
FIRST_DRIVE = Path(first_drive.__file__).parent
MAP_PARTS = ("maps.js", "map_tools.js", "map_files.js")
MAPPING = Path(making.__file__).parent
WEB = Path(__file__).parents[2] / "web"
LANGUAGES = languages()
HOST_KEYS = ["ok", "board_lost", "board_starting", "board_busy", "wrong_port", "version_differs"]
HOST_KEYS += ["lidar_lost", "lidar_view", "lidar_starting", "camera_lost", "page_silent"]
HOST_KEYS += ["lidar_silent", "lidar_frozen", "lidar_protection", "lidar_power", "lidar_mirror"]
HOST_KEYS += ["lidar_damaged", "lidar_one", "host_slow", "host_hot"]
HOST_KEYS += ["motion_stuck", "motion_uncommanded"]
HOST_KEYS += ["not_owner", "stale_token", "bad_message", "too_fast", "not_allowed", "not_paired"]
HOST_KEYS += ["wrong_code", "too_many_guesses"]
PAGE_KEYS = ["link_lost", "unknown", "ready", "tap", "clicks", "code_missing", "no_answer"]
PAGE_KEYS += ["ready_scan", "part_missing", "mode_unable", "untuned"]
HOST_KEYS += ["profile_unknown", "profile_value", "profile_last", "profile_full"]
HOST_KEYS += ["profile_not_stored"]
MODULES = sorted(WEB.glob("*.js"))
PAGES = sorted(WEB.glob("*.html"))


REFUSED_SETTINGS = ("out_of_range", "while_armed", "not_stored", "by_calibration")


def table(language: str) -> dict:
    """The driver's page's texts."""
    return json.loads((WEB / "strings" / f"{language}.json").read_text("utf-8"))


def care_labels(language: str) -> dict:
    """The labels that only the caretaker's and the pairing page need."""
    return table(f"{language}-care")["labels"]


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_reason_fault_and_host_key_has_words(language):
    keys = {*codes.REASONS, *(fault[1] for fault in codes.FAULTS), *HOST_KEYS, *PAGE_KEYS}
    care = {key for key in keys if key in table(f"{language}-care")["messages"]}
    assert keys - care == set(table(language)["messages"])
    # The driver's page asks for no settings.
    assert care == {f"setting_{why}" for why in REFUSED_SETTINGS}


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_message_is_one_short_plain_sentence_and_what_to_do(language):
    for key, message in table(language)["messages"].items():
        assert set(message) == {"text", "do"}, key
        assert 5 < len(message["text"]) <= 80, key
        assert message["text"].endswith("."), key
        assert len(message["do"]) <= 80, key


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_only_the_caretaker_reads_is_as_short(language):
    care = table(f"{language}-care")["messages"]
    assert not set(care) & set(table(language)["messages"])
    for key, message in care.items():
        assert 5 < len(message["text"]) <= 80, key
        assert message["text"].endswith("."), key
        assert 0 < len(message["do"]) <= 80, key


def test_every_language_has_every_file():
    parts = [path.name[2:] for path in WEB.glob("strings/nl*.json")]
    named = {language + part for language in LANGUAGES for part in parts}
    assert {path.name for path in WEB.glob("strings/*")} == named


@pytest.mark.parametrize("name", sorted(path.stem[2:] for path in WEB.glob("strings/nl*.json")))
def test_all_languages_have_the_same_keys(name):
    def keys(language):
        words = table(language + name)
        words.pop("errors", None)  # in English from the host itself
        return {kind: list(texts) for kind, texts in words.items()}

    for language in LANGUAGES:
        assert keys(language) == keys("en"), language


def test_everything_about_maps_has_words():
    words = table("nl-maps")
    code = "".join((WEB / name).read_text("utf-8") for name in MAP_PARTS)
    built = {f"maps_{icon}" for icon in places.ICONS}
    built |= {f"maps_{tool}{end}" for tool in ("place", "no_go", "home") for end in ("", "_tap")}
    named = set(re.findall(r'"(maps_\w+)"', code)) - {"maps_stored"}
    assert set(words["labels"]) == named | built | {"map_damaged"}
    sources = "".join(path.read_text("utf-8") for path in MAPPING.rglob("*.py"))
    reasons = set(re.findall(r'"(map_\w+)"', sources)) | {"maps_stored"}
    doubts = {f"map_{doubt}" for doubt in (ASKEW, BROKEN, FULL, SILENT)}
    assert not reasons & doubts  # a refusal's text is no advice for who makes a map
    reasons |= doubts
    assert reasons - {"map_starting", "map_unknown", "map_twins", "map_lost"} == set(
        words["messages"]
    )


def test_every_tile_of_a_place_has_a_sign_that_the_page_draws():
    drawn = re.findall(r"^  (\w+): \[", (WEB / "signs.js").read_text("utf-8"), re.M)
    tools = {"home", "no_go"}
    auto = {target.icon for target in tiles.people(True).values()} | set(tiles.TILES)
    assert sorted(drawn) == sorted({*places.ICONS, *tools, *auto})
    chosen = (WEB / "map_tools.js").read_text("utf-8").partition("ICONS = [")[2].partition("];")[0]
    assert tuple(re.findall(r"\"(\w+)\"", chosen)) == places.ICONS


def test_no_text_of_the_page_needs_a_font_of_pictures():
    for path in sorted(WEB.rglob("*.*")):
        if path.suffix in (".js", ".json", ".html", ".css"):
            pictures = [sign for sign in path.read_text("utf-8") if ord(sign) >= 0x1F000]
            assert pictures == [], path.name


def test_every_step_of_the_first_drive_and_why_it_is_refused_has_words():
    words, names = table("nl-first"), ("first_drive", "first_texts", "floor_marks")
    code = "".join((WEB / f"{name}.js").read_text("utf-8") for name in names)
    steps = {f"first_{step}{end}" for step in STEPS for end in ("", "_why")}
    facts = {label for label in words["labels"] if label.startswith("first_fact_")}
    named = {label for label in words["labels"] if f'"{label}"' in code or f".{label}" in code}
    assert steps | facts | named == set(words["labels"])
    sources = "".join(path.read_text("utf-8") for path in FIRST_DRIVE.glob("*.py"))
    assert set(re.findall(r'"(first_\w+)"', sources)) == set(words["messages"])


def test_everything_that_assist_shows_has_words():
    code = (WEB / "assist_sign.js").read_text("utf-8")
    assert set(re.findall(r'"(assist_\w+)"', code)) == set(table("nl-assist")["labels"])


def test_everything_that_can_be_wrong_with_a_plug_in_has_words():
    hows = re.findall(r'_lost\("(\w+)"', SUPERVISOR.read_text("utf-8"))
    reasons = {LOST, RAISED, SETTING, STARTING, MISSING, *(f"plugin_{how}" for how in hows)}
    assert len(reasons) == 9
    wanted = reasons | {f"plugin_{word}" for word in (*GROUPS, *STATES, "trouble")}
    files = ("plugins.js", "plugin_list.js", "plugin_tiles.js", "going.js")
    code = "".join((WEB / file).read_text("utf-8") for file in files)
    wanted |= set(re.findall(r'(?:label\("|labels\.)(plugin_\w+)', code))
    assert wanted == set(table("nl-plugins")["labels"])


def test_a_label_has_one_place_and_the_drivers_page_needs_one_file():
    own, others = set(table("nl")["labels"]), set(care_labels("nl"))
    assert not own & others
    text = "".join(path.read_text("utf-8") for path in files_of("index.html"))
    assert [label for label in others if f'"{label}"' in text] == []


def test_every_state_motion_owner_and_decision_has_a_label():
    wanted = {*codes.STATES, *codes.DECISIONS, "ok", "warning", "error"}
    wanted |= {f"motion_{name}" for name in codes.MOTIONS}
    wanted |= {f"owner_{name}" for name in codes.OWNERS}
    assert wanted <= set(table("nl")["labels"])


def test_every_label_named_in_the_page_exists_and_none_is_unused():
    labels = {*table("nl")["labels"], *care_labels("nl")}
    text = "".join(path.read_text("utf-8") for path in [*PAGES, *MODULES])
    named = set(re.findall(r'data-label="(\w+)"', text))
    assert named <= labels
    built = {*codes.STATES, *codes.DECISIONS, "ok", "warning", "error"}
    built |= {
        name for name in labels if name.startswith(("motion_", "owner_", "menu_", "look_", "stop_"))
    }
    built |= {label for label in labels if label.startswith(("role_", "alert_"))}
    table_of_fields = fields(["nl"], {})
    built |= {*table_of_fields, *caretaker_settings.ALLOWED}
    built |= {f"{name}_{word}" for name, field in table_of_fields.items() for word in field.choices}
    in_code = {label for label in labels if f'"{label}"' in text}
    assert labels - named - built - in_code == set()


def files_of(page: str) -> set[Path]:
    """The page and everything it loads, except texts and pictures."""
    found, open_ones = set(), [WEB / page]
    while open_ones:
        path = open_ones.pop()
        if path in found:
            continue
        found.add(path)
        text = path.read_text("utf-8")
        names = re.findall(r'(?:(?:src|href)=|Worker\()"/static/([\w.]+)"', text)
        names += re.findall(r'from "\./([\w.]+)"', text)
        open_ones += [WEB / name for name in names]
    return found


def test_the_drivers_page_weighs_less_than_80_kb():
    def weight(path: Path) -> int:
        return len(minified(path.read_text("utf-8"), path.suffix).encode())

    heaviest = max(weight(WEB / "strings" / f"{language}.json") for language in LANGUAGES)
    assert sum(map(weight, files_of("index.html"))) + heaviest < 80_000


@pytest.mark.parametrize("path", [*PAGES, *MODULES, *WEB.glob("*.css")], ids=lambda p: p.name)
def test_comments_and_indentation_can_be_left_out(path):
    """The rules that gazechair.web.minify relies on: only comments go, line numbers stay."""
    text = path.read_text("utf-8")
    slim = minified(text, path.suffix)
    assert path.suffix != ".js" or slim.count("\n") == text.count("\n")
    comments = r"/\*.*?\*/|<!--.*?-->|^\s*//.*?$"
    plain = re.sub(comments, "", text, flags=re.S | re.M)
    assert slim.split() == plain.split()
    assert all(line.count("`") % 2 == 0 for line in plain.splitlines()), "text over a line's end"


def test_nothing_is_fetched_from_elsewhere():
    for path in [*PAGES, *MODULES, *WEB.glob("*.css")]:
        assert re.findall(r"(?:https?:)?//[\w.-]+\.\w+", path.read_text("utf-8")) == [], path.name


def test_a_page_has_no_inline_script_style_or_handler():
    for path in PAGES:
        html = path.read_text("utf-8")
        assert not re.search(r"<style|\sstyle=|\son\w+=|javascript:", html), path.name
        assert re.findall(r"<script(?![^>]*\ssrc=)", html) == [], path.name
    for path in MODULES:
        code = path.read_text("utf-8")
        assert not re.search(r"\beval\(|new Function|innerHTML|insertAdjacentHTML", code), path.name


@pytest.mark.parametrize("path", [*PAGES, *MODULES, *WEB.glob("*.css")], ids=lambda p: p.name)
def test_a_file_says_its_purpose_first_and_stays_small(path):
    lines = path.read_text("utf-8").splitlines()
    first = lines[1] if lines[0].startswith("<!DOCTYPE") else lines[0]
    assert re.match(r"//|/\*|<!--", first)
    assert max((len(line) for line in lines if "<" not in line), default=0) <= 100
    assert len(lines) < 300


def test_python_finds_the_files_as_a_package():
    spec = spec_from_file_location("gazeweb", WEB / "__init__.py")
    assert spec is not None
    assert spec.loader is not None
    spec.loader.exec_module(module_from_spec(spec))
