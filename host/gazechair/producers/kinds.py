"""The kinds of producers, and where the class of each is."""

from __future__ import annotations

import importlib

from gazechair.producers.contract import Producer, Setup

KINDS = {
    "place": "gazechair.producers.place:PlaceProducer",
    "line": "gazechair.producers.line:LineProducer",
    "look": "gazechair.producers.look:LookProducer",
    "person": "gazechair.producers.person:PersonProducer",
}


def build(kind: str, setup: Setup) -> Producer:
    """Import and create the kind's class; only here, so that other kinds do not load it."""
    module, _, name = KINDS[kind].partition(":")
    made: Producer = getattr(importlib.import_module(module), name)(setup)
    return made
