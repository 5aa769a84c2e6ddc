# The numbers behind the safety promises: compiled in, settings can only be stricter.
from gazelink.const import const

# Times in ms, counted in ticks of 1 ms. MARGIN: a promise counts from the event; a tick may be up
# to 1 ms away and the wiper write belongs to it, so each deadline is judged this much early.
MARGIN_MS = const(2)
HOST_SILENT_MS = const(100)  # P2 neutral
HOST_LOST_MS = const(500)  # P2 disarm
COMMAND_TTL_MS = const(300)  # P3
CLEARANCE_OLD_MS = const(300)  # P6
CLEARANCE_FRESH_MS = const(250)  # P6 clears below this (hysteresis)
HEADING_OLD_MS = const(50)  # P7
WIPER_TRIES = const(3)  # P8
WIPER_DEBT = const(300)  # P8: +2 a failure, -3 a good write: two of three fail for 0.9 s
SERVICE_STALLED_MS = const(50)  # P9 neutral
SERVICE_LOST_MS = const(500)  # P9 disarm
TICK_STALLED_US = const(20000)  # P10
TICK_ON_TIME_US = const(1005)  # a tick no later than this is on time
TICK_BEHIND_US = const(10000)  # so far behind the microsecond clock is a stall, too
TICK_SLOW_US = const(50)  # of each tick: 5 % too slow goes unseen, and counts in the ages
TICK_STEADY_MS = const(500)  # P10 clears after this long without a stall
FRAME_STALE_MS = const(100)  # P12: motion frames whose echoed stamp is older are ignored
TILT_MS = const(100)  # P16
OBEYS_MS = const(2600)  # P21
# P21 (obedience.py): what was asked for may last so long, then falls to nothing within so long:
# the twin's weakest chair brakes with 51 degrees/s2 and a lag of 0.6 s. Coasted out in both axes, a
# chair that turns faster than the standing limit is being turned; until then, than the moving one:
# casters of 15 degrees never swing it that fast for longer than 0.42 s.
OBEY_HOLD_MS = const(300)
OBEY_FALL_MS = const(1500)
OBEY_COAST_MS = const(2000)
OBEY_STANDING_Q4_DPS = const(128)
OBEY_MOVING_Q4_DPS = const(320)
OBEY_MS = const(500)  # of it in one sense
TILT_UNSEEN_MS = const(5000)  # P16: most that a chair creeps whose tilt cannot be read
TILT_FORGOTTEN_MS = const(60000)  # and most that level ground is remembered

NEUTRAL_PROVEN_MS = const(500)  # arming: neutral read back this long
IDLE_MS = const(300)  # arming: nothing commanded this long
RELAY_CLOSE_MS = const(150)  # arming: contact must close within
RELAY_HOLD_MS = const(50)  # arming: and stay closed this long
RELAY_RELEASE_MS = const(25)  # armed: contact seen open this long is a fault
RELAY_STUCK_MS = const(100)  # enable off this long and still closed is a fault
RELAY_CLEAR_MS = const(500)
RESET_PRESS_MS = const(3000)  # P11: button at the chair

AGE_MAX_MS = const(60000)  # ages saturate here

# Wipers: counts 85..254 are 5..7 V, neutral near 6 V.
WIPER_MIN = const(85)
WIPER_MAX = const(254)
WIPER_NEUTRAL = const(170)
WIPER_SPAN = const(84)  # counts of deflection at 1000 permille

HEADING_TURN_Q4_DEG = const(5760)  # one turn
# No chair turns so fast: a gyro that says more is taken at this. 1000 degrees/s; times the longest
# age, or squared, it stays within 31 bits.
RATE_MAX_Q4_DPS = const(16000)
STEP_FORWARD_MAX_MS = const(5000)  # P4: longest step a setting can ask for
STEP_TURN_MAX_MS = const(10000)
TUNE_PULSE_MAX_MS = const(2000)  # P4: longest tuning pulse
AUTO_TTL_MS = const(150)  # P17: the planner's value lives no longer
SUPERVISION_MAX_MS = const(10000)  # P18: longest that a setting can ask for
AUTO_MM_S = const(350)  # P19
AUTO_OVERRULED_MS = const(10000)  # P20: an obstacle has overruled it for so long
AUTO_LIMIT_MAX_S = const(1800)  # P20
BYPASS_MAX_MS = const(20000)  # longest bypass of an obstacle; then the button must be pressed anew
BYPASS_PAUSE_MS = const(1000)  # before the next at least, and half as long as the last one was

# Obstacles (obstacles.py, stopping.py)
SLOW_AHEAD_MS = const(1000)  # slowing begins this much of the speed before the stop distance
ARC_AHEAD_MS = const(500)  # the same where both axes move
CLEAR_MS = const(300)  # a way must look better this long before more is allowed
BAND_MM = const(60)  # and this much better than needed: twice the lidar's noise
BAND_Q4_DEG = const(48)
OUTERMOST_MM = const(750)  # a turn's creep: drive axle to the footprint's farthest corner
CREEP_OVER_PERMILLE = const(30)  # least output above the dead zone that still moves the chair
# Creep, and any motion without a relay, never exceeds this, however much a chair needs to start:
# what needs more than that is blocked, or in a turn tried with this much first. In a turn: of the
# outermost point.
CREEP_MOST_MM_S = const(260)
# Nothing opens the relay of a wiper that got stuck when none is fitted: a person has to reach the
# chair's own button. At this speed that takes 20 cm a second.
NO_RELAY_MM_S = const(200)

# Trust in the selected profile (profile_check.py, stopping.py): the driver can turn the chair's own
# knob, while it stands and even while it drives.
TRUST_MS = const(30000)  # after the last turn that confirmed it
TRUST_STANDING_MS = const(3000)  # with so little put out that a chair may stand:
STANDING_PERMILLE = const(150)
# A turn at less says little: the deadband counts for too much. Auto turns reach 469 (P19).
TELLING_PERMILLE = const(450)
DEADBAND_MOST_PERMILLE = const(120)  # of a chair that turning has to tell from another
# A chair that stands while so much asks it to turn is none of the quick ones.
TRYING_PERMILLE = const(300)
TRYING_MS = const(1500)
