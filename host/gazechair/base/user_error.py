"""Errors for the user: English in a terminal; pages show the sentence of their language."""

from __future__ import annotations


class UserError(Exception):
    """The text is one plain line: what is wrong, what to do.

    `key` names the sentence in the pages' tables of languages; "" when no page shows this error.
    `fields` fill the {braces} in both; a field named `reason` is itself a key of the pages'
    messages.
    """

    def __init__(self, text: str, key: str = "", **fields: float | str) -> None:
        super().__init__(text.format(**fields) if key else text)
        self.key = key
        self.fields = fields
