# Pin numbers and levels of every board (Teensy 4.0 names; see docs/wiring.md).

ENABLE = 2  # toggles every tick while enabled; the charge pump keeps the relay closed
RELAY_FEEDBACK = 3  # mirror contact: low is released, high is closed or a broken wire (pull-up)
EMERGENCY = 4  # normally closed to ground: low is well, high is emergency (pull-up)
BUTTON = 5  # low: pressed (pull-up)
LED = 13

JOYSTICK_BUS = 0
IMU_BUS = 1
JOYSTICK_TIMEOUT_US = 300
IMU_TIMEOUT_US = 3000
I2C_HZ = 400000
