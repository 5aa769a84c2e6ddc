"""Plug-ins, inputs or modes: the authors' interface; the child processes that run them."""

from gazechair.config.rules import choice, flag, integer, number, text, word
from gazechair.config.tables import setting
from gazechair.plugins.contract import (
    NOTHING,
    STOP,
    Input,
    Intent,
    Mode,
    Unusable,
    World,
    choose,
    drive,
    hold,
    step,
)

__all__ = [
    "NOTHING",
    "STOP",
    "Input",
    "Intent",
    "Mode",
    "Unusable",
    "World",
    "choice",
    "choose",
    "drive",
    "flag",
    "hold",
    "integer",
    "number",
    "setting",
    "step",
    "text",
    "word",
]
