# The firmware's two loops: tick() every millisecond, service() as often as possible in between.

import gc
from binascii import hexlify, unhexlify

from gazeboard.core.motion import Motion
from gazeboard.core.obedience import Obedience
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.profile_check import ProfileCheck
from gazeboard.core.safety import Safety
from gazeboard.core.shared import Inbox, Outbox
from gazeboard.core.tick import PERIOD_US, Tick
from gazeboard.core.tick_clock import TickClock
from gazeboard.io import bootlog
from gazeboard.io.core_state import CoreState
from gazeboard.io.emergency_latch import EmergencyLatch
from gazeboard.io.imu import OFFSETS_SIZE, Imu
from gazeboard.io.joystick import Joystick
from gazeboard.io.link import Link
from gazeboard.io.settings import FILE as SETTINGS_FILE
from gazeboard.io.settings import Settings
from gazeboard.io.storage import sealed, unsealed
from gazeboard.io.telemetry import Telemetry
from gazeboard.io.trace import ODD, Trace
from gazeboard.turning.turn import turn_controller
from gazelink import codes
from gazelink.native import micropython
from gazelink.settings_table import TABLE as SETTINGS_TABLE

_GC_MS = 1000
_GC_ARMED_MS = 60000
_HEALTHY_MS = 3600000  # running so long, the board forgets its watchdog resets
_HEADING_FILE = "heading_offsets"

# LED: on for the first `on` of `period` ms. (condition order: see _blink)
_LED_FAULT = (100, 200)
_LED_NO_HOST = (50, 2000)
_LED_DISARMED = (500, 1000)
_LED_ARMED = (1000, 1000)


class App:
    # board: see boards/__init__.py for what it offers. boot_faults: bits found before this.

    def __init__(self, board, boot_faults=0):
        self._board = board
        s = Settings(board.load(SETTINGS_FILE))
        self.settings = s
        self.inbox = Inbox()
        self._imu = Imu(board.imu_i2c, board.ticks_diff, s.tilt_limit_q4_deg)
        if not self._restore_heading():
            boot_faults |= 1 << codes.STORAGE
        self.joystick = Joystick(board.joystick_i2c)
        if not board.hard_timer:
            boot_faults |= 1 << codes.NO_HARD_TIMER
        self._latch = EmergencyLatch(board)
        if self._latch.stored:
            boot_faults |= 1 << codes.EMERGENCY
        self._healthy = False  # has run for long without a reset
        self.safety = Safety(board.simulated, s.relay_fitted, boot_faults)
        self.obstacles = Obstacles(s)
        self.obedience = Obedience(s)
        self.core = Tick(self.safety, None, self.obstacles, self.obedience, None, TickClock())
        self.outbox = Outbox()
        self.telemetry = Telemetry(self.safety, self.joystick, self.obstacles)
        self.trace = self.inbox.trace = Trace(self.outbox)
        self.link = Link(board, self.inbox, self.outbox, self.safety, self.telemetry, self.trace)
        self._neutral = None  # as last applied
        self._setting_session = 0  # whose changes of the neutral count
        # What each tick uses: to find an attribute takes longer than to unpack all of these.
        self._used = (
            board,
            self.inbox,
            self.core,
            self.joystick,
            self.telemetry,
            self.outbox,
            self.trace,
        )
        self._apply_settings()
        self.inbox.publish()
        self._enable_level = 0  # as put out
        self._last_us = -1
        self._watched_at = 0
        self._fed_at = 0
        self._gc_at = 0
        self._saving_heading = False  # the request that waits has asked the sensor
        self._service_at_ms = 0
        self.service_max_ms = 0
        self.heap_free_kb = 0
        self.reset_cause = board.reset_cause

    # Settings into the parts that use them; only while disarmed.
    def _apply_settings(self):
        s = self.settings
        neutral = s.neutral()
        self.joystick.set_neutral(*neutral)
        if neutral != self._neutral:
            self._neutral = neutral
            self.safety.neutral_moved()
            self.telemetry.forget()
        self._imu.tilt.limit_q4_deg = s.tilt_limit_q4_deg
        self.obstacles.configure(s)
        self.link.outgoing.tell_zone(self.obstacles.zone)
        self.obedience.configure(s)
        turn = turn_controller(s)
        self.core.motion = self.motion = Motion(s, turn)
        self.core.profile_check = self.profile_check = ProfileCheck(turn.model)
        self.safety.set_relay_fitted(s.relay_fitted)
        self.safety.auto.configure(s)
        self.trace.follow(CoreState(self.core, self.joystick, s))
        self.inbox.back.calibrated = s.calibrated
        self.inbox.touch()

    # -- the tick: hard interrupt, heap locked, integers only ------------------------------------

    @micropython.native
    def tick(self, _timer=None):
        try:
            board, inbox, core, joystick, telemetry, o, trace = self._used
            i = inbox.front
            start_us = board.ticks_us()
            last_us = self._last_us
            self._last_us = start_us
            relay_closed = board.relay_pin() == 1
            emergency_open = board.emergency_pin() == 1
            button_pressed = board.button_pin() == 0
            core.decide(
                i,
                board.ticks_diff(start_us, last_us) if last_us >= 0 else PERIOD_US,
                relay_closed,
                emergency_open,
                button_pressed,
            )
            verified = joystick.write(core.linear_permille, core.turn_permille)
            level = core.written(verified, joystick.neutral)
            if level != self._enable_level:
                self._enable_level = level
                board.enable_pin(level)
            late = core.late
            missed_ms = core.missed_ms
            if late:
                o.late_ticks = (o.late_ticks + 1) & 0xFFFF
            spent_us = board.ticks_diff(board.ticks_us(), start_us)
            if spent_us > o.tick_max_us:
                o.tick_max_us = spent_us
            # Another 1 + missed_ms, counted from where it wraps: any sum stays a small integer.
            ticks = (o.ticks - 0x3FFFFFFF + missed_ms) & 0x3FFFFFFF
            telemetry.capture(ticks, core.motion.state, i.heading_q4)
            odd = emergency_open or button_pressed or missed_ms or late or not verified
            if relay_closed is not o.relay_closed:
                o.relay_closed = relay_closed
                odd = True
            traced = trace.on
            if traced:
                if i.taken_at < 0:
                    i.taken_at = ticks
                if odd or traced == ODD:
                    trace.on = trace.saw(
                        ticks,
                        relay_closed,
                        emergency_open,
                        button_pressed,
                        verified,
                        late,
                        missed_ms,
                    )
            o.ticks = ticks
        except Exception:
            self._let_go()

    # Enable off, both wipers neutral; again each time, each for itself.
    def _let_go(self):
        try:
            self._enable_level = 0
            self._board.enable_pin(0)
        except Exception:
            pass
        self.joystick.let_go()
        self.core.raised()
        self.trace.lose()

    # -- the service loop: everything that may wait or take a while --------------------------------

    # One short slice; False: exit to the REPL (maintenance requested, disarmed, everything sent).
    def service(self):
        board = self._board
        now_ms = board.ticks_ms()
        gap_ms = board.ticks_diff(now_ms, self._service_at_ms)
        self._service_at_ms = now_ms
        if gap_ms > self.service_max_ms:
            self.service_max_ms = gap_ms
        ticks = self.outbox.ticks
        self.inbox.beat()
        if self.trace.on:
            self.trace.beat(ticks)
        self.link.poll(self)
        self._sense(now_ms)
        if self.inbox.back.session_count != self._setting_session:
            self._setting_session = self.inbox.back.session_count
            self._drop_neutral()
        if self.link.incoming.setting_pending:
            self._answer_setting()
        self.inbox.publish()
        self._watchdog()
        self._keep()
        self._collect()
        self._blink()
        return not (self.link.maintenance and self.link.outgoing.flushed())

    # Heading and tilt into the inputs.
    def _sense(self, now_ms):
        imu = self._imu
        tilt = imu.tilt
        back = self.inbox.back
        state = self.safety.state
        if imu.poll(now_ms, state != codes.DISARMED):
            back.heading_q4 = imu.heading_q4
            back.rate_q4 = imu.rate_q4
            back.heading_count = imu.samples
            back.tilted = tilt.beyond
            self.inbox.touch()
        ticks = self.outbox.ticks
        elapsed_ms = (ticks - self._watched_at) & 0x3FFFFFFF
        self._watched_at = ticks
        moving = self.motion.state != codes.STOPPED
        tilt.watch(elapsed_ms, imu.tilt_lost(), moving, state == codes.ARMED)
        faults = 1 << codes.STORAGE if self._latch.failed else 0
        if tilt.unknown:
            faults |= 1 << codes.TILT_UNKNOWN
        if back.heading_faults != imu.faults or back.service_faults != faults:
            back.heading_faults = imu.faults
            back.service_faults = faults
            self.inbox.touch()

    # Reading is always allowed; changing and saving only while disarmed (a flash write stops the
    # tick).
    def _answer_setting(self):
        link = self.link
        asked = link.incoming
        request = asked.setting_request
        index = asked.setting_index
        reads = request == codes.SETTING_GET
        refused = codes.NO_REASON
        if not reads and self.safety.state != codes.DISARMED:
            refused = codes.SETTING_WHILE_ARMED
        elif reads and index >= len(SETTINGS_TABLE):
            refused = codes.SETTING_UNKNOWN
        elif request == codes.SETTING_SET:
            refused = self.settings.set(index, asked.setting_value)
        elif request == codes.SETTING_SET_NEUTRAL:
            refused = self.settings.set_neutral(index, asked.setting_value)
        elif request == codes.SETTING_DEFAULTS:
            self.settings.defaults()
        elif request == codes.SETTING_SAVE:
            refused = self._save_settings()
        elif request == codes.SETTING_SAVE_HEADING:
            refused = self._save_heading()
            if refused is None:
                return
        self._saving_heading = False
        if not reads and refused == codes.NO_REASON:
            self._apply_settings()
        link.answer_setting(self.settings.get(index) if index < len(SETTINGS_TABLE) else 0, refused)

    def _save_settings(self):
        refused = self.settings.store_refused()
        if refused:
            return refused
        try:
            self._board.store(SETTINGS_FILE, self.settings.text())
        except Exception:  # the flash refuses, or no memory
            return codes.SETTING_NOT_STORED
        self.settings.stored()
        return codes.NO_REASON

    # Another host has connected. A new session disarms with its first tick.
    def _drop_neutral(self):
        if not self.settings.calibrated and self.safety.state == codes.DISARMED:
            self.settings.drop_neutral()
            self._apply_settings()

    # Reads the sensor's offsets, then stores them; None: it has not answered yet.
    def _save_heading(self):
        imu = self._imu
        if not self._saving_heading:
            if not imu.calibrated():
                return codes.SENSOR_NOT_CALIBRATED
            imu.save()
            self._saving_heading = True
        if imu.offsets_new:
            try:
                self._board.store(_HEADING_FILE, sealed(hexlify(imu.offsets()).decode()))
            except Exception:  # the flash refuses, or no memory
                return codes.SETTING_NOT_STORED
            return codes.NO_REASON
        return None if imu.saving() else codes.SENSOR_NOT_CALIBRATED

    # False: the stored text is damaged; reported once, then deleted.
    def _restore_heading(self):
        text = self._board.load(_HEADING_FILE)
        if text is None:
            return True
        try:
            offsets = unhexlify(unsealed(text) or "")
        except ValueError:
            offsets = b""
        if len(offsets) == OFFSETS_SIZE:
            self._imu.restore(offsets)
            return True
        bootlog.removed(self._board, _HEADING_FILE)
        return False

    # Fed only while the tick lives.
    def _watchdog(self):
        ticks = self.outbox.ticks
        if ticks != self._fed_at:
            self._fed_at = ticks
            self._board.feed_watchdog()

    # What is stored while the board runs, written after the tick has disarmed.
    def _keep(self):
        disarmed = self.safety.state == codes.DISARMED
        ticks = self.outbox.ticks
        self._latch.keep(self.safety.faults & (1 << codes.EMERGENCY) != 0, disarmed, ticks)
        if not self._healthy and disarmed and ticks >= _HEALTHY_MS:
            self._healthy = True
            bootlog.forget(self._board)

    # Neither loop makes garbage, so there is none to collect while armed; a pass that does
    # collect takes some ms, as long as a frame may wait.
    def _collect(self):
        o = self.outbox
        period_ms = _GC_MS if self.safety.state == codes.DISARMED else _GC_ARMED_MS
        if (o.ticks - self._gc_at) & 0x3FFFFFFF >= period_ms:
            self._gc_at = o.ticks
            gc.collect()
            self.heap_free_kb = self._board.heap_free_kb()

    def _blink(self):
        faults = self.safety.faults
        if faults & ~(1 << codes.HOST_SILENT) & ~(1 << codes.OBSTACLE_DATA_OLD):
            pattern = _LED_FAULT
        elif faults & (1 << codes.HOST_SILENT):
            pattern = _LED_NO_HOST
        elif self.safety.state == codes.DISARMED:
            pattern = _LED_DISARMED
        else:
            pattern = _LED_ARMED
        self._board.led_pin(1 if self.outbox.ticks % pattern[1] < pattern[0] else 0)

    # What the link's statistics take from here.
    def imu_samples(self):
        return self._imu.samples

    def imu_errors(self):
        return self._imu.errors

    def imu_status(self):
        return (0 if self._imu.faults else 1) | (self._imu.calibration & 0x3C)

    # Upper bound of the forward or backward speed now.
    def speed_mm_s(self):
        return self.obstacles.speed_mm_s()

    # The selected profile; bit 7: the turn rate seen agrees with it.
    def profile_seen(self):
        return self.settings.profile | (self.profile_check.agreed << 7)

    # What is left of a bypass.
    def bypass_ms(self):
        return self.obstacles.bypass.left_ms

    # The board stops the tick first, then calls this: neutral, enable off.
    def shut_down(self):
        self._board.enable_pin(0)
        self.joystick.let_go()
