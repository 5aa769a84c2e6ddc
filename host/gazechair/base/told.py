"""Errors that are told to a person: English in a terminal, by their key in other languages."""

from __future__ import annotations


class ToldError(Exception):
    """The text is one plain line: what is wrong, what to do.

    `key` names its sentence in the pages' tables of other languages, "" for one that no page shows;
    `fields` fill {braces} in both; one named `reason` is itself a key of the pages' messages.
    """

    def __init__(self, text: str, key: str = "", **fields: float | str) -> None:
        super().__init__(text.format(**fields) if key else text)
        self.key = key
        self.fields = fields
