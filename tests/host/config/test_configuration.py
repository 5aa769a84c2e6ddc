"""The configuration file: defaults, annotated file, and one line for every error in it."""

import re
import sys
from pathlib import Path

import pytest

from gazechair.config import configuration, settings
from gazechair.config.configuration import ConfigError
from gazechair.config.settings import Config

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def test_defaults_work_on_a_bare_machine() -> None:
    bare = configuration.load(None)
    assert (bare.lidar[0].kind, bare.camera.kind) == ("off", "off")
    assert bare.board.port == "auto"
    assert (bare.web.host, bare.web.insecure_http) == ("127.0.0.1", False)
    assert bare.driver.backward is False


def test_the_footprint_of_an_installation() -> None:
    corners = "[[0.6, 0.3],\n [-0.4, 0.3],\n [-0.4, -0.3],\n [0.6, -0.3]]"
    read = configuration.parse(
        f"[footprint]\ncorners_m = {corners}\nside_margin_m = 0.1\n"
    ).footprint
    assert read.corners_m == ((0.6, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.6, -0.3))
    assert (read.front_margin_m, read.side_margin_m) == (0.05, 0.1)


def test_annotated_default_file_is_the_default_whichever_of_its_lines_are_set() -> None:
    text = configuration.annotated_default()
    live = re.sub(r"^#(?=\w+ = )", "", text, flags=re.MULTILINE)
    assert live.count("\n") > 60
    assert configuration.parse(live) == configuration.parse(text) == Config()


def test_annotated_default_file_sets_nothing_that_an_older_version_would_refuse() -> None:
    tables = tomllib.loads(configuration.annotated_default())
    assert set(tables) == set(settings.SECTIONS)
    assert not any(tables.values())
    assert configuration.parse("[newer]\n") == Config()


def test_values_are_taken_over(tmp_path: Path) -> None:
    file = tmp_path / "chair.toml"
    file.write_text(
        '[lidar]\nkind = "s2"\nport = "/dev/lidar"\nmask = [[150, -150]]\n'
        "[footprint]\nside_margin_m = 0\n"
    )
    read = configuration.load(file)
    assert [(one.kind, one.port) for one in read.lidar] == [("s2", "/dev/lidar")]
    assert read.lidar[0].mask == ((150.0, -150.0),)
    assert read.footprint.side_margin_m == 0.0


TWO = """[[lidar]]
kind = "s2"
name = "front"
port = "{}"
[[lidar]]
kind = "s2"
name = "rear"
port = "{}"
"""


def test_several_lidars_have_a_table_each() -> None:
    more = "heading_deg = 180\nmask = [[170, -170]]"
    read = configuration.parse(TWO.format("usb:A1", "usb:B2") + more)
    assert [(one.name, one.port, one.heading_deg) for one in read.lidar] == [
        ("front", "usb:A1", 0.0),
        ("rear", "usb:B2", 180.0),
    ]
    assert [one.mask for one in read.lidar] == [(), ((170.0, -170.0),)]


ROUTE = '[[alerts.route]]\nname = "zus"\nurl = "json://localhost/hush"\n'

REFUSED = [
    ('[web]\nport = "x"', 2, "web.port must be a whole number 0..65535"),
    ("[web]\nport = 65536", 2, "not 65536"),
    ("[web]\nport = true", 2, "must be a whole number"),
    ("[web]\n\ninsecure_http = 1", 3, "must be true or false"),
    ("[web]\ntls = true\ninsecure_http = true", 3, "contradicts tls = true"),
    ('[web]\nname = "a b"', 2, "must be a host name or an address"),
    ("[wob]\nx = 1", 1, "wob is no section"),
    ("x = 1", 1, "x is no section"),
    ("\nweb = 1", 2, "write it as [web]"),
    ("[driver]\ndwell = 1", 2, "[driver] has mode, dwell_ms"),
    ("driver.mode = 1", 1, 'driver.mode must be "step" or "continuous"'),
    ("[driver]\nleave_grace_ms = -1", 2, "0..500"),
    ("# comment\n[driver\n", 2, "is not TOML"),
    ("[web]\nport = 1\nport = 2", 3, "is not TOML"),
    ("[footprint]\ncorners_m = [[1, 1], [-1, -1], [1, -1], [-1, 1]]", 2, "must not cross"),
    ("[footprint]\ncorners_m = [[1, 1], [2, 1], [2, 2]]", 2, "must enclose the drive axle"),
    ("[footprint]\ncorners_m = [[1, 1], [-1, 1]]", 2, "must have 3..24 corners"),
    ("[footprint]\ncorners_m = [[1, nan], [-1, 1], [0, -1]]", 2, "a list of corners"),
    ("[footprint]\ncorners_m = [1, 2, 3]", 2, "a list of corners"),
    ("[footprint]\nside_margin_m = -0.1", 2, "0.0..0.3"),
    ("[sectors]\nfront_deg = [-30, 30]", 1, "is no section"),
    ("[footprint]\nfront_margin_m = nan", 2, "0.0..0.5"),
    ('[camera]\nkind = "http"', 2, "camera.kind must be the address"),
    ('[camera]\nkind = "http"\nurl = "ftp://x/"', 3, "camera.url must be the address"),
    ('[camera]\nkind = "http"\nurl = "http://a:b@x/"', 3, "without user:password@"),
    ('[camera]\nkind = "http"\nurl = "http://a:b/c@x/"', 3, "camera.url must be the address"),
    ('[camera]\nkind = "http"\nurl = "http://x/?pwd=my secret"', 3, "without spaces"),
    ('[web]\nname = "fe80::1%eth0"', 2, "must be a host name or an address"),
    ('[web]\nhost = "fe80::1%eth0"', 2, "web.host must be an address"),
    ('[lidar]\nkind = "replay"', 2, "lidar.kind must be the file"),
    ('[lidar]\nname = "a b"', 2, "letters, digits"),
    ("[lidar]\nmask = [[0, 1], [5]]", 2, "a list of arcs"),
    ("[lidar]\nmask = [[5, 5]]", 2, "a list of arcs"),
    ("[lidar]\nmask = [[]]", 2, "a list of arcs"),
    ("[lidar]\nmask = [[nan, 5]]", 2, "a list of arcs"),
    ("[lidar]\nmask = [[30, 181]]", 2, "a list of arcs"),
    ("[lidar]\nmask = [[-150, 151]]", 2, "300 degrees in all"),
    ("[lidar]\nx_m = 3", 2, "-2.0..2.0"),
    ('[[lidar]]\nname = "a"\n[[lidar]]\nname = "a"', 4, "the name of another lidar"),
    ('[[lidar]]\nkind = "s2"\nport = "/x"\n[[lidar]]\nname = "b"\nkind = "s2"', 4, '"auto"'),
    (TWO.format("/x", "/x"), 4, "the port of another lidar"),
    (TWO.format("/x", "/y") + "mode = 1", 9, 'must be "dense" or'),
    ("lidar = 5", 1, "write it as [lidar]"),
    ("lidar = []", 1, "write it as [lidar]"),
    ("lidar = [5]", 1, "write it as [lidar]"),
    ("[[board]]\n", 1, "write it as [board]"),
    ('[board]\nport = "a\\nb"', 2, "must be a text"),
    ("[alerts]\nstuck_s = 9", 2, "10..3600"),
    ('[alerts]\nmqtt = "http://x"', 2, "alerts.mqtt must be an address as mqtt://user:password@h"),
    ('[web]\nhost = "192.168..5"', 2, "web.host must be an address as 192.168.1.5, or a host name"),
    ('[web]\nhost = "192.168.5"', 2, "web.host must be an address"),
    ('[web]\nhost = ""', 2, "web.host must be an address"),
    (f'[web]\nhost = "{"a" * 64}.local"', 2, "web.host must be an address"),
    ('[web]\nname = "chair..local"', 2, "must be a host name or an address"),
    (ROUTE + "[alerts]\nstuck_s = 9", 5, "10..3600"),
    ('[[alerts.route]]\nname = "zus"', 1, "alerts.route.url must be an address of Apprise"),
    (ROUTE + ROUTE, 5, "the name of another route"),
    (ROUTE + "kinds = []", 4, "a list of help, stuck, failure, system"),
    (ROUTE + 'kinds = ["test"]', 4, "a list of help, stuck, failure, system"),
    (ROUTE + "after_s = -1", 4, "0..3600"),
    ("[alerts]\nroute = 3", 1, "write it as [[alerts.route]]"),
    ("[[alerts]]\n", 1, "write it as [alerts]"),
    ("[input.gone]\n\nsince = 2026-09-21", 3, "input.gone.since must have no date or time"),
    ("[mode.gone]\nat = [1, {b = [07:32:00]}]", 2, "mode.gone.at must have no date or time"),
    ("[mode.follow-person]\n", 1, "give the plug-in another name"),
    ("[mode.places]\n", 1, "give the plug-in another name"),
    ("[mode.go-look-12]\n", 1, "give the plug-in another name"),
    ("[mode.place-1a2b3c4d-1]\n", 1, "give the plug-in another name"),
]


@pytest.mark.parametrize(("content", "line", "words"), REFUSED)
def test_refusal_is_one_line_with_file_line_and_reason(content: str, line: int, words: str) -> None:
    with pytest.raises(ConfigError) as refusal:
        configuration.parse(content, "chair.toml")
    text = str(refusal.value)
    assert text.startswith(f"chair.toml:{line}: ")
    assert words in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (f"[footprint]\ncorners_m = [[{'9' * 309}, 1], [-1, 1], [0, -1]]", "a list of corners"),
        (f"[lidar]\nmask = [[{'9' * 309}, 5]]", "a list of arcs"),
        (f"[web]\nport = {'9' * 5000}", "is not TOML"),
        (f"[web]\nport = {'[' * 5000}", "is not TOML: nested too deeply"),
    ],
    ids=["corner", "arc", "number", "nesting"],
)
def test_what_has_no_end_is_refused_in_one_line(content: str, words: str) -> None:
    test_refusal_is_one_line_with_file_line_and_reason(content, 2, words)


def test_the_same_key_of_another_section_is_not_blamed() -> None:
    content = '[lidar]\nport = "auto"\n[web]\nlanguage = "nl"\nport = -1\n'
    with pytest.raises(ConfigError, match=r"^f:5: web\.port"):
        configuration.parse(content, "f")


def test_missing_file_says_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="--config"):
        configuration.load(tmp_path / "none.toml")


def test_without_a_file_the_variable_names_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the installed command sets it; a file that is given comes first."""
    installed, given = tmp_path / "installed.toml", tmp_path / "given.toml"
    installed.write_text("[web]\nport = 1234\n")
    given.write_text("[web]\nport = 5678\n")
    monkeypatch.setenv("GAZECHAIR_CONFIG", str(installed))
    assert configuration.load(None).web.port == 1234
    assert configuration.load(given).web.port == 5678
    monkeypatch.setenv("GAZECHAIR_CONFIG", "")
    assert configuration.load(None) == Config()


def test_a_variable_that_names_no_file_is_refused_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = tmp_path / "gone.toml"
    monkeypatch.setenv("GAZECHAIR_CONFIG", str(gone))
    with pytest.raises(ConfigError, match=r"^[^\n]*gone\.toml.*\$GAZECHAIR_CONFIG names it"):
        configuration.load(None)
    with pytest.raises(ConfigError) as refusal:
        configuration.load(gone)
    assert "GAZECHAIR_CONFIG" not in str(refusal.value)


def test_binary_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "chair.toml"
    file.write_bytes(b"\xff\xfe[web]")
    with pytest.raises(ConfigError, match="UTF-8"):
        configuration.load(file)


@pytest.mark.parametrize(
    ("lines", "encrypted"),
    [
        ("", False),
        ("tls = true", True),
        ('host = "0.0.0.0"', True),
        ('host = "chair.local"', True),
        ('host = "0.0.0.0"\ninsecure_http = true', False),
    ],
)
def test_other_machines_come_in_encrypted_or_by_saying_so(lines: str, encrypted: bool) -> None:
    assert settings.uses_tls(configuration.parse(f"[web]\n{lines}\n").web) == encrypted


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "127.1.2.3", "::1"])
def test_loopback_needs_no_permission(host: str) -> None:
    assert configuration.parse(f'[web]\nhost = "{host}"').web.host == host


ENCODE = r"percent-encoded \(# is %23\)"


@pytest.mark.parametrize(
    ("rest", "says"),
    [
        ("chair:hu[shh@host", ENCODE),
        ("chair:hu]shh@host", ENCODE),
        ("chair:hu/shh@host", ENCODE),
        ("chair:hu#shh@host", ENCODE),
        ("chair:hu?shh@host", ENCODE),
        ("chair:hu shh@host", ENCODE),
        ("chair:hush\uff0fhush@host", ENCODE),  # becomes a / when Python splits it
        ("chair:hush", "an address as mqtt"),
        ("hush:x@host:0", r"port 1\.\.65535"),
        ("hush:x@host:65536", r"port 1\.\.65535"),
        ("hush:x@host:", r"port 1\.\.65535"),
        ("hush:x@", "must name a host"),
        ("hush:x@192.168..5", "must name a host"),
        ("hush:x@[host]", "must"),
    ],
)
def test_a_broker_that_cannot_be_reached_is_refused_without_its_password(
    rest: str, says: str
) -> None:
    with pytest.raises(
        ConfigError, match=rf"^f:2: alerts\.mqtt .*{says}.* not repeated"
    ) as refusal:
        configuration.parse(f'[alerts]\nmqtt = "mqtt://{rest}"\n', "f")
    assert "hu" not in str(refusal.value).replace("must", "")


@pytest.mark.parametrize(
    "rest",
    ["host", "mqtt_broker:1883/", "chair:hu%23sh@h.local", "a:b@c:d@[fe80::1]:1", "chair@10.0.0.2"],
)
def test_an_address_of_a_broker(rest: str) -> None:
    for scheme in ("mqtt", "mqtts"):
        read = configuration.parse(f'[alerts]\nmqtt = "{scheme}://{rest}"\n')
        assert read.alerts.mqtt == f"{scheme}://{rest}"
        assert f"//{rest}" not in repr(read)
    assert configuration.parse('[alerts]\nmqtt = ""\n').alerts.mqtt == ""


def test_routes_of_alerts_have_a_table_each_and_their_address_is_secret() -> None:
    second = '[[alerts.route]]\nname = "sms"\nurl = "x://y"\nafter_s = 120\nkinds = ["help"]\n'
    read = configuration.parse(ROUTE + second + "[alerts]\nstuck_s = 30")
    assert read.alerts.stuck_s == 30
    assert [(one.name, one.url, one.after_s) for one in read.routes] == [
        ("zus", "json://localhost/hush", 0),
        ("sms", "x://y", 120),
    ]
    assert read.routes[1].kinds == ("help",)
    assert "hush" not in repr(read)
    with pytest.raises(ConfigError) as refusal:
        configuration.parse(ROUTE.replace("json://localhost", "no address of"))
    assert "hush" not in str(refusal.value)
