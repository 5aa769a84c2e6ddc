# Layout of the register bank, version 1.
#
# Devices, pins and flash are in one file shared by board and simulator. The emulated Teensy maps
# the same layout. Little-endian; (h) host writes, (g) guest (the board) writes.

SIZE = 16 << 20
MAGIC = 0x4252374D
VERSION = 1
USED_SIZE = 0x1FF000  # header's `size`: everything up to the end of flash

# Header, u32 unless stated otherwise
MAGIC_AT = 0x00
VERSION_AT = 0x04
SIZE_AT = 0x08
BOOT_COUNT_AT = 0x0C  # (g)
NEXT_CAUSE_AT = 0x10  # (g) before a reset: 3 watchdog, 5 software; (h) 0 for a power-on
RESET_CAUSE_AT = 0x14  # (g) of this boot: 1 power-on, 3 watchdog, 5 software
WDT_MS_AT = 0x18  # (g) 0: not started
WDT_FEEDS_AT = 0x1C  # (g)
WDT_FIRED_AT = 0x20  # (g)
TICK_MS_AT = 0x24  # (g) ticks since reset
VIRT_US_AT = 0x28  # (g) u64
EPOCH_S_AT = 0x30  # (h)
SCRIPT_LEN_AT = 0x34  # (h)
SCRIPT_DONE_AT = 0x38  # (g)
FLASH_ERASE_US_AT = 0x3C  # (h)
FLASH_PROG_US_AT = 0x40  # (h)
SEED_AT = 0x44  # (h)
LOG_HEAD_AT = 0x48  # (g)
SOFT_RESETS_AT = 0x4C  # (g)
HOST_FLAGS_AT = 0x50  # (h) 1: see the emulated board; 2: the time now being lost is a hang
WORLD_MS_AT = 0x54  # (h) the simulator's own time; 0: none. Only the virtual board looks at it

# Bus n at BUSES_AT + n * BUS_SIZE: flags (h; bit 0 SCL stuck low), transfers, collisions, aborted
# (g), u32 each
BUSES_AT = 0x80
BUS_SIZE = 16
BUS_COUNT = 3

# Pin n at PINS_AT + n * PIN_SIZE
PINS_AT = 0x100
PIN_SIZE = 16
PIN_COUNT = 64
PIN_MODE = 0  # (g) 0 in, 1 out, 2 open drain, 255 not configured
PIN_PULL = 1  # (g) 0 down, 1..3 up, 4 none, 5 keeper
PIN_OUT = 2  # (g) latch
PIN_LEVEL = 3  # (g) pad level when last read or written
PIN_HOST_DRIVE = 4  # (h)
PIN_HOST_LEVEL = 5  # (h)
PIN_OUT_COUNT = 8  # (g) u32, writes to the latch
PIN_OUT_US = 12  # (g) u32

# Slot of (bus, addr) at SLOTS_AT + (bus * 128 + addr) * SLOT_SIZE
SLOTS_AT = 0x1000
SLOT_SIZE = 512
SLOT_PRESENT = 0x00  # (h)
SLOT_STYLE = 0x01  # (h) 0 register file, 1 AD5282
SLOT_NAK = 0x02  # (h) NAK everything
SLOT_NAK_COUNT = 0x03  # (h) NAK that many; (g) counts down
SLOT_STRETCH_US = 0x04  # (h) u32, per byte, address included
SLOT_REGPTR = 0x08  # (g) register pointer; AD5282: last instruction byte
SLOT_SEL = 0x09  # (g) AD5282: RDAC last selected
SLOT_PINS = 0x0A  # (g) AD5282: bit 0 O1, bit 1 O2
SLOT_SD = 0x0B  # (g) AD5282: bit per RDAC shut down
SLOT_WSEQ = 0x0C  # (g) u32 writes
SLOT_RSEQ = 0x10  # (g) u32 reads
SLOT_NAKS = 0x14  # (g) u32
SLOT_HOST_SEQ = 0x18  # (h) u32 seqlock: odd while the host updates registers
SLOT_WRITE_US = 0x20  # (g) u64
SLOT_RO = 0x40  # (h) bitmap of 256 bits: registers the guest cannot write
SLOT_REGS = 0x100

STYLE_REGISTERS = 0
STYLE_AD5282 = 1

# Transfer log: a ring of LOG_ENTRIES entries of LOG_ENTRY_SIZE bytes
LOG_AT = 0x40000
LOG_ENTRIES = 4096
LOG_ENTRY_SIZE = 32  # u64 us, bus, addr, kind, len, 16 data bytes, u32 seq (written last)
LOG_WRITE = 0
LOG_READ = 1
LOG_NAK = 2
LOG_EIO = 3

SCRIPT_AT = 0x80000
SCRIPT_SIZE = 0x20000
FLASH_AT = 0x100000
FLASH_SIZE = 0xFF000
