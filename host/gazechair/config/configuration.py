"""The configuration's TOML file: found, read and checked; refused with file, line and reason."""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path
from typing import Any, NoReturn

from gazechair.base.user_error import UserError
from gazechair.config import combinations, plugin_tables, rules, tables
from gazechair.config.plugin_tables import PluginConfig
from gazechair.config.settings import SECTIONS, SEVERAL, Config, RouteConfig
from gazechair.config.tables import BadSetting

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


class ConfigError(UserError):
    """Raised for a file that is refused. Its text is one line: file, line, reason, what to do."""


_ROUTE = "alerts.route"
_VARIABLE = "GAZECHAIR_CONFIG"  # set by the Debian package's command


def file_in_use(path: Path | None) -> Path | None:
    """`path`, or when it is None the file that $GAZECHAIR_CONFIG names; None: the defaults."""
    named = os.environ.get(_VARIABLE)
    return Path(named) if path is None and named else path


def add_option(parser: argparse.ArgumentParser) -> None:
    """Add `--config FILE`; options.config is what load() takes."""
    text = "configuration file (default: the one that $GAZECHAIR_CONFIG names, or none)"
    parser.add_argument("--config", type=Path, metavar="FILE", help=text)


def load(path: Path | None) -> Config:
    """The configuration in the `file_in_use`.

    Raises ConfigError, one line long: a missing file, broken TOML, an unknown key, a bad value.
    """
    file = file_in_use(path)
    if file is None:
        return Config()
    try:
        content = file.read_text(encoding="utf-8-sig")  # Windows editors
    except OSError as error:
        named = f"${_VARIABLE} names it; " if path is None else ""
        raise ConfigError(
            f"{file}: cannot be read ({error.strerror}); {named}give an existing file with --config"
        ) from None
    except UnicodeDecodeError:
        raise ConfigError(f"{file}: is not UTF-8 text; save it as UTF-8") from None
    return parse(content, str(file))


def parse(content: str, name: str = "configuration") -> Config:
    """The configuration in TOML text `content`, called `name` in errors. Raises ConfigError."""
    try:
        document = tomllib.loads(content)
    except (ValueError, RecursionError) as error:  # also of endless numbers
        why = "nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise ConfigError(_broken_toml(content, name, why)) from None
    known = ", ".join((*SECTIONS, *plugin_tables.KINDS))
    sections: dict[str, Any] = {}
    plugins: list[PluginConfig] = []
    routes: list[dict[str, Any]] = []
    for section, values in document.items():
        if section in plugin_tables.KINDS:
            try:
                plugins += plugin_tables.parse(section, values, content, name)
            except BadSetting as refused:
                if refused.key:
                    raise ConfigError(refused.reason) from None
                _refuse(content, name, section, None, refused.reason)
            continue
        if section not in SECTIONS:
            if values == {}:  # of a newer version, whose defaults all hold
                continue
            _refuse(content, name, section, None, f"is no section; there are {known}")
        if section == "alerts" and isinstance(values, dict):
            routes = values.pop("route", [])
            if not isinstance(routes, list) or not all(isinstance(one, dict) for one in routes):
                _refuse(content, name, _ROUTE, None, f"is one of several: write it as [[{_ROUTE}]]")
        tables = values if section in SEVERAL and isinstance(values, list) else [values]
        if not tables or not all(isinstance(table, dict) for table in tables):
            _refuse(content, name, section, None, f"is a section: write it as [{section}]")
        read = [_section(content, name, section, at, table) for at, table in enumerate(tables)]
        sections[section] = tuple(read) if section in SEVERAL else read[0]
    if routes:
        read = [_section(content, name, _ROUTE, at, table) for at, table in enumerate(routes)]
        sections["routes"] = tuple(read)
    config = Config(**sections, plugins=tuple(plugins))
    for rule in combinations.broken(config):
        _refuse(content, name, rule.section, rule.key, rule.reason, rule.at)
    return config


def _section(content: str, name: str, section: str, at: int, values: dict[str, Any]) -> object:
    try:
        table = RouteConfig if section == _ROUTE else SECTIONS[section]
        return tables.read(table, values, f"[{section}]")
    except BadSetting as refused:
        _refuse(content, name, section, refused.key, refused.reason, at)


def annotated_default() -> str:
    """A configuration file without a setting; comments have each one's default and meaning.

    What is not set is not refused by a version that does not have it yet.
    """
    lines = ["# Configuration of gazechair. To change a default, remove the # before its name."]
    for section, table in SECTIONS.items():
        lines += ["", *tables.described(table, section)]
    lines += ["", *(f"# {line}".rstrip() for line in tables.described(RouteConfig, f"[{_ROUTE}]"))]
    lines += ["", "# Inputs and modes: [input.NAME], [mode.NAME]; `gazechair plugin list`."]
    return re.sub(r"^(?=\w+ = )", "#", "\n".join(lines), flags=re.MULTILINE) + "\n"


def _refuse(
    content: str, name: str, section: str, key: str | None, reason: str, at: int = 0
) -> NoReturn:
    # `at`: in which of several tables of that section.
    what = section if key is None else f"{section}.{key}"
    raise ConfigError(f"{name}:{rules.line_of(content, section, key, at)}: {what} {reason}")


def _broken_toml(content: str, name: str, message: str) -> str:
    found = re.search(r"at line (\d+)", message)
    line = int(found.group(1)) if found else content.count("\n") + 1
    return f"{name}:{line}: is not TOML: {message}; compare with `gazechair config`"
