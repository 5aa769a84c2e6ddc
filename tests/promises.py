# What the tests of the safety promises measured, in milliseconds of the board's own ticks. Runs on
# MicroPython too; there nothing is noted, only asserted. tools/safety-table makes docs/safety.md of
# it: with `pytest -p promises` and GAZECHAIR_PROMISES set to a folder, each process of the tests
# writes its notes to a file there.

import sys

CORE = "core"  # the whole firmware, a scripted host and sensor around it
END_TO_END = "end to end"  # page, host, cable, firmware, chair, room and sensors

notes = []  # one dict per call, in order


# `cause` came about and the promise's action was there `ms` later, which must be within `limit_ms`
# (None: measured for information, nothing is promised).
def measured(rig, promise, cause, ms, limit_ms):
    late = f"{promise}, {cause}: {ms} ms, promised within {limit_ms} ms"
    assert limit_ms is None or ms <= limit_ms, late
    _note(rig, promise, cause, ms, limit_ms)


# A promise without a time in it was kept.
def kept(rig, promise, cause):
    _note(rig, promise, cause, None, None)


def _note(rig, promise, cause, ms, limit_ms):
    test = _test_name()
    if test:
        notes.append(
            {
                "rig": rig,
                "promise": promise,
                "cause": cause,
                "ms": ms,
                "limit_ms": limit_ms,
                "test": test,
            }
        )


def _test_name():
    if sys.implementation.name == "micropython":
        return ""
    frame = sys._getframe(2)
    while frame is not None:
        if frame.f_code.co_name.startswith("test_"):
            return frame.f_code.co_name
        frame = frame.f_back
    return ""


def pytest_sessionfinish(session):
    import json
    import os

    folder = os.environ.get("GAZECHAIR_PROMISES")
    if folder and notes:
        with open(f"{folder}/{os.getpid()}.json", "w") as f:
            json.dump(notes, f)
