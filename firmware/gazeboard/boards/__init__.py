# Boards: the only place where firmware touches hardware.
# A board offers
#   name, simulated, hard_timer, boot_id (1..65535), reset_cause (1 power-on, 3 watchdog, 5 other)
#   joystick_i2c, imu_i2c: writeto(addr, buf), readfrom_into(addr, buf),
#       readfrom_mem_into(addr, reg, buf); OSError on NAK or a stuck bus, within the bus's time-out
#   enable_pin(level), led_pin(level); relay_pin(), emergency_pin(), button_pin() -> level: pins.py
#       defines what each level means
#   serial: read_byte() -> 0..255 or -1; write_some(buf, start, end) -> index of the first byte not
#       accepted; neither ever waits
#   draw_nonce(buf): 4 bytes of the best available entropy into buf, per session (os.urandom: on
#       the Teensy the processor's own generator)
#   ticks_us(), ticks_ms(), ticks_diff(a, b), feed_watchdog(), heap_free_kb()
#   load(name), store(name, text), remove(name): small files, see storage.py; the latter two raise
#       OSError when the flash rejects the write
#   open_repl(): let Ctrl-C interrupt again, before leaving for the REPL
#   run(app): call app.tick every ms and app.service in between, until service returns False
# In the tick's calls, nothing here may allocate; run() and the constructor may.
