"""Where sound comes from: a microphone, a named pipe, a WAV file. All give 16 kHz, 16 bit, mono.

read() returns what has arrived, after 0.1 s at the latest; it raises OSError, one plain line, when
the source is gone.
"""

import os
import select
import shutil
import stat
import subprocess
import tempfile
import time
import wave

import numpy as np

from gazechair.plugins import Unusable

RATE = 16_000
MOST_RATE = 192_000
WAIT_S = 0.1
SILENT_S = 1.0  # a microphone that sends nothing for so long is gone
CHUNK = 1 << 20
LONGEST_S = 600.0


def opener(source, device):
    """What opens `source`; it raises OSError when there is none now. Raises Unusable."""
    if source == "microphone":
        if shutil.which("arecord") is None:
            raise Unusable("arecord is missing: apt install alsa-utils")
        return lambda: Microphone(device)
    try:
        is_pipe = stat.S_ISFIFO(os.stat(source).st_mode)
    except (OSError, ValueError) as error:
        raise Unusable(f"no sound from {source}: {getattr(error, 'strerror', error)}") from None
    if is_pipe:
        return lambda: Pipe(os.open(source, os.O_RDONLY | os.O_NONBLOCK))
    recordings = iter([Recording(read_wav(source))])

    def play():
        recording = next(recordings, None)
        if recording is None:
            raise OSError("the recording has ended")
        recording.begin()
        return recording

    return play


class Pipe:
    """Raw sound from a file descriptor that does not block."""

    def __init__(self, fd):
        self._fd = fd
        self._last_s = time.monotonic()
        self._odd = b""
        self._begun = False

    def read(self):
        """What has arrived, whole samples."""
        ready = select.select([self._fd], [], [], WAIT_S)[0]
        now_s = time.monotonic()
        try:
            data = os.read(self._fd, CHUNK) if ready else b""
        except BlockingIOError:
            data = b""
        else:
            if ready and not data:
                return self.nothing_more()
        if data:
            self._last_s, self._begun = now_s, True
        elif now_s - self._last_s > SILENT_S:
            raise OSError("no sound arrives")
        data = self._odd + data
        whole = len(data) // 2 * 2
        self._odd = data[whole:]
        return data[:whole]

    def nothing_more(self):
        """The other end has left, or nobody has come yet."""
        if self._begun:
            raise OSError("the other end of the pipe has left")
        if time.monotonic() - self._last_s > SILENT_S:
            raise OSError("nobody writes to the pipe")
        time.sleep(WAIT_S)
        return b""

    def close(self):
        """Give it back."""
        os.close(self._fd)


class Microphone(Pipe):
    """A microphone of this machine, by the program arecord."""

    def __init__(self, device):
        words = ["arecord", "-q", "-D", device, "-t", "raw", "-f", "S16_LE", "-r", str(RATE)]
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed by close)
        self._process = subprocess.Popen(
            [*words, "-c", "1"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=self._errors,
        )
        os.set_blocking(self._process.stdout.fileno(), False)
        super().__init__(self._process.stdout.fileno())

    def nothing_more(self):
        """It was pulled out, or there was none."""
        self._process.wait()
        self._errors.seek(0)
        said = self._errors.read(4096).decode(errors="replace").strip().splitlines()
        raise OSError(f"no microphone: {said[-1] if said else 'arecord ended'}")

    def close(self):
        """End arecord."""
        self._process.kill()
        self._process.wait()
        self._process.stdout.close()
        self._errors.close()


class Recording:
    """Sound that is there already, played once at its own speed."""

    def __init__(self, sound):
        self._sound = sound
        self._at = 0
        self._begun_s = 0.0

    def begin(self):
        """Its first sample is now."""
        self._begun_s = time.monotonic()

    def read(self):
        """What has been played since the last call."""
        if self._at >= len(self._sound):
            raise OSError("the recording has ended")
        time.sleep(WAIT_S / 4)
        played = int((time.monotonic() - self._begun_s) * RATE) * 2
        data = self._sound[self._at : played]
        self._at = max(self._at, played)
        return data

    def close(self):
        """Nothing is open."""


def read_wav(path):
    """The file's sound: PCM of 8 to 32 bit, any channels, 16 kHz or more. Raises Unusable."""
    try:
        with wave.open(path, "rb") as file:
            width, channels, rate = file.getsampwidth(), file.getnchannels(), file.getframerate()
            if not RATE <= rate <= MOST_RATE:
                raise Unusable(f"{path} has {rate} samples a second, not {RATE} to {MOST_RATE}")
            data = file.readframes(int(LONGEST_S * rate))
    except (OSError, EOFError, wave.Error, ValueError) as error:
        raise Unusable(f"{path} is no WAV file of PCM sound: {error or 'it is cut off'}") from None
    return _resample(samples(data, width, channels), rate).astype("<i2").tobytes()


def samples(data, width, channels):
    """Mono, -32768..32767, of whole frames."""
    data = data[: len(data) // (width * channels) * width * channels]
    if width == 1:
        sound = (np.frombuffer(data, np.uint8).astype(float) - 128.0) * 256.0
    else:
        # The two most significant bytes of each sample: enough for a word.
        each = np.frombuffer(data, np.uint8).reshape(-1, width)[:, -2:]
        sound = np.ascontiguousarray(each).view("<i2").astype(float).ravel()
    return sound.reshape(-1, channels).mean(axis=1)


def _resample(sound, rate):
    """To 16 kHz; a running mean keeps what is too high from folding back."""
    if rate == RATE or not len(sound):
        return sound
    width = max(1, round(rate / RATE))
    smooth = np.convolve(sound, np.full(width, 1.0 / width), "same")
    at = np.arange(int(len(sound) * RATE / rate)) * (rate / RATE)
    return np.interp(at, np.arange(len(sound)), smooth)
