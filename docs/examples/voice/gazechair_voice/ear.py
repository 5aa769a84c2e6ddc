"""Cuts sound into what may be a word: louder than the room, and silence before and after it."""

from collections import deque

import numpy as np

FRAME_BYTES = 960  # 30 ms
LOUDER = 2.5  # than the room, 8 dB
QUIETEST = 20.0  # of 32768: what is below that is no speech in any room
TOO_LOUD = 1500.0
BEGIN, OF = 3, 5  # a word begins with so many loud frames of so many
END = 10  # and ends with so many that are not
BEFORE = 20  # frames that are handed out with it: an "s" is not loud
LONGEST = 67  # frames; what goes on for longer is talk, and no command
ROOM = 100  # frames by which the room is known
SHARE = 20  # percent of them are the room, whoever speaks


class Ear:
    """Takes sound as it comes: 16 kHz, 16 bit, mono."""

    def __init__(self):
        self.forget()

    def forget(self):
        """Sound is missing after what was heard so far."""
        self._rest = b""
        self._sound = deque(maxlen=BEFORE + LONGEST)
        self._loud = deque(maxlen=END)
        self._levels = deque(maxlen=ROOM)
        self._frames = 0  # of the present word, 0 for none
        self.room = 0.0

    @property
    def trouble(self):
        """Why no word can be heard; "" when one can."""
        return "it is too loud here to hear a word" if self.room > TOO_LOUD else ""

    def hear(self, data):
        """The sounds, as bytes, that may be words and whose end is in `data`."""
        data = self._rest + data
        whole = len(data) // FRAME_BYTES * FRAME_BYTES
        self._rest = data[whole:]
        frames = (data[at : at + FRAME_BYTES] for at in range(0, whole, FRAME_BYTES))
        return [sound for frame in frames if (sound := self._frame(frame))]

    def _frame(self, frame):
        # The difference of neighbours weakens rumble and engines more than speech.
        samples = np.frombuffer(frame, "<i2").astype(float)
        level = float(np.sqrt(np.mean(np.diff(samples) ** 2)))
        self._levels.append(level)
        self.room = float(np.percentile(self._levels, SHARE))
        self._sound.append(frame)
        self._loud.append(level > max(LOUDER * self.room, QUIETEST))
        if self._frames == 0:
            self._frames = OF if sum(list(self._loud)[-OF:]) >= BEGIN else 0
            return None
        self._frames += 1
        if any(self._loud):
            return None
        frames, self._frames = self._frames, 0
        if frames > LONGEST:
            return None
        return b"".join(list(self._sound)[-frames - BEFORE :])
