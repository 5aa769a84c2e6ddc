"""Measures the hard tick under the worst load: allocation, instructions, jitter, telemetry.

Allocation is tested on 32-bit MicroPython with the heap locked; the rest is counted on the emulated
Cortex-M7, where 500 instructions are one microsecond and runs are reproducible to the instruction.
"""

from __future__ import annotations

import ast
import inspect
from pathlib import Path
from typing import Any

from gazeboard.boards import bank_layout
from gazeboard.core.motion import Motion
from gazeboard.core.obedience import Obedience
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.safety import Safety
from gazeboard.io.joystick import Joystick
from gazeboard.io.telemetry import Telemetry
from gazechair.service.flash import tree
from gazelink import frame, messages
from gazemeasure import allocation, emulation
from gazemeasure.report import Report
from gazesim.board_files import LIB, firmware_files

_INSTRUCTIONS = 80_000  # at most, in the worst tick
_RUN_MS = 60_000
_RUN_MS_QUICK = 10_000  # one garbage collection in it delays less than a frame in 1000
_STRETCH_US = 180
_LIMIT_S = 1500.0
_LATENCY_STEP_MS = 0.25
# Wire time of one tick at 400 kHz: a 3-byte write and a 2-byte read per wiper, 9 bits per byte,
# START and STOP.
_WIRE_US = 2 * (3 * 9 + 2 + 2 * 9 + 2) / 0.4
_SESSION = 77
# What the tick calls: attribute of App, its class, method.
_PARTS = (
    ("obstacles", Obstacles, "step"),
    ("safety", Safety, "step"),
    ("motion", Motion, "step"),
    ("motion", Motion, "stop"),
    ("profile_check", ProfileCheck, "step"),
    ("obedience", Obedience, "step"),
    ("joystick", Joystick, "write"),
    ("safety", Safety, "wipers_written"),
    ("telemetry", Telemetry, "capture"),
)
_ON_THE_WIRE = ("joystick.write", "tick")


def measure(quick: bool) -> Report:
    """Run everything; see Report."""
    run_ms = _RUN_MS_QUICK if quick else _RUN_MS
    report = Report(f"tick: {run_ms // 1000} s on the emulated Cortex-M7, instruction-counted")
    allocation.add_to(report, quick)
    result, states = _load(run_ms, state_period_ms=1)
    instructions = (result["worst_us"] - _WIRE_US) * emulation.INSTRUCTIONS_PER_US
    mean = (result["sum_us"] / result["ticks"] - _WIRE_US) * emulation.INSTRUCTIONS_PER_US
    report.add("worst tick, without wire time", instructions, "instr", _INSTRUCTIONS)
    report.add("mean tick, without wire time", mean, "instr")
    report.add("tick start jitter, p99.9", _jitter_us(result["phase"], 0.999), "us", 20)
    report.add("missed ticks", result["missed"], "", 0)
    report.add("ticks", result["ticks"], "", run_ms, at_least=True)
    report.add("frame decoded, p99.9", _latency_ms(result["latency"], 0.999), "ms", 10)
    report.add("frame decoded, max", result["latency_max_us"] / 1000, "ms")
    due = ((states[-1] - states[0]) & 0xFFFF_FFFF) + 1
    report.add("STATE requested at 1000 Hz", 1000 * len(states) / due, "Hz", 1000, at_least=True)
    report.add("STATE lost", due - len(states), "", 0)
    report.add("STATE arrived", len(states), "", 0.9 * run_ms, at_least=True)
    report.add("telemetry dropped by the board", result["tx_dropped"], "", 0)
    report.add("frames corrupt or refused", result["corrupt"] + result["bad"], "", 0)
    report.add("IMU samples", result["imu_samples"], "", run_ms / 10 * 0.9, at_least=True)
    report.add("service passes while moving", result["moved"], "", 100, at_least=True)
    result, _ = _load(_RUN_MS_QUICK, state_period_ms=10, traced=True)
    instructions = (result["worst_us"] - _WIRE_US) * emulation.INSTRUCTIONS_PER_US
    report.add("worst tick while it is traced", instructions, "instr", _INSTRUCTIONS)
    decoded_ms = _latency_ms(result["latency"], 0.999)
    report.add("frame decoded while traced, p99.9", decoded_ms, "ms", 10)
    report.note("load: a host frame every 5 ms, STATE every 1 ms, IMU at 100 Hz with its clock")
    report.note(f"stretched by {_STRETCH_US} us a byte, garbage made and collected, every motion,")
    report.note("override and heading fault in turn. QEMU counts instructions, not cycles.")
    _add_parts(report)
    return report


def _add_parts(report: Report) -> None:
    """Add a table of each part's cost, from a separate run, because counting adds cost."""
    result, _ = _load(_RUN_MS_QUICK, state_period_ms=1, parts=True)
    *parts, whole = result["parts"]
    report.note("")
    report.note(f"{'instructions of each part':32}{'worst tick':>12}{'most':>10}{'mean':>10}")
    rest = [whole[column] - sum(part[column] for part in parts) for column in (1, 2, 3)]
    wire = _WIRE_US * emulation.INSTRUCTIONS_PER_US
    for name, *counts in [*parts, ("the rest", rest[0], "", rest[2]), whole]:
        words = [
            count if count == "" else f"{count - (wire if name in _ON_THE_WIRE else 0):,.0f}"
            for count in counts
        ]
        report.note(f"  {name:30}{words[0]:>12}{words[1]:>10}{words[2]:>10}")


def _words(part: type, method: str) -> int:
    """How many arguments the tick gives to this method."""
    return len(inspect.signature(getattr(part, method)).parameters) - 1


def _load(
    run_ms: int, state_period_ms: int, parts: bool = False, traced: bool = False
) -> tuple[dict[str, Any], list[int]]:
    """The results of board_load.py, and the stamps, ms, of the received STATE frames."""
    text = (Path(__file__).parent / "board_load.py").read_text()
    watched = [(name, method, _words(of, method)) for name, of, method in _PARTS] if parts else []
    values = f"RUN_MS={run_ms}\nSTATE_PERIOD_MS={state_period_ms}\nSTRETCH_US={_STRETCH_US}\n"
    values += f"PARTS={watched}\nTRACED={traced}\n"
    files = firmware_files()
    files[f"{LIB}/board_parts.py"] = (Path(__file__).parent / "board_parts.py").read_text()
    files[f"{LIB}/gazeboard/boards/bank_layout.py"] = Path(bank_layout.__file__).read_text()
    del files[tree.MAIN]
    output = emulation.run(values + text, files, _LIMIT_S)
    telemetry, _, words = output.rpartition(b"\nRESULT ")
    result: dict[str, Any] = ast.literal_eval(words.split(b"}")[0].decode() + "}")
    return result, _states(telemetry)


def _states(telemetry: bytes) -> list[int]:
    """Stamps, unwrapped, from the first two 1 ms apart: from there on 1000 Hz are requested."""
    decoder = frame.Decoder()
    decoder.session = keys = frame.Session()
    boot = 0
    stamps: list[int] = []
    for byte in telemetry:
        if not decoder.feed(byte):
            continue
        if decoder.buf[messages.TYPE_AT] == messages.HELLO.type_id:
            boot = messages.HELLO.unpack(decoder.buf)["boot"]
            continue
        stamp = frame.u16(decoder.buf, messages.STAMP_AT)
        if decoder.buf[messages.TYPE_AT] == messages.NONCE.type_id:
            begun = messages.NONCE.unpack(decoder.buf)
            if not keys.live:
                keys.begin(begun["session"], boot, begun["nonce"], begun["epoch"], stamp)
        keys.advance(stamp)
        if decoder.buf[messages.TYPE_AT] == messages.STATE.type_id:
            last = stamps[-1] if stamps else 0
            stamps.append(last + ((stamp - last) & 0xFFFF))
            if len(stamps) == 2 and stamps[1] - stamps[0] != 1:
                del stamps[0]
    return stamps


def _jitter_us(phase: list[int], share: float) -> float:
    """Distance of the tick's start from its most frequent phase on the grid, us."""
    base = phase.index(max(phase))
    return _share_below([(abs(at - base), count) for at, count in enumerate(phase)], share)


def _latency_ms(histogram: list[int], share: float) -> float:
    return _share_below(
        [((at + 1) * _LATENCY_STEP_MS, count) for at, count in enumerate(histogram)], share
    )


def _share_below(counted: list[tuple[float, int]], share: float) -> float:
    total = sum(count for _, count in counted)
    seen = 0
    for value, count in sorted(counted):
        seen += count
        if seen >= share * total:
            return value
    return float("nan")
