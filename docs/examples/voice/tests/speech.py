"""Speech for the tests: made by espeak-ng, whose library comes in the package espeakng-loader."""

import ctypes
import functools

import espeakng_loader
import numpy as np

RATE = 16_000
LEVEL = 8000.0  # of the loudest sample
RETRIEVE = 1  # espeak_AUDIO_OUTPUT: the sound is for us
_SPEED, _PITCH = 1, 3
_UTF8 = 1
_Take = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.c_void_p
)


@functools.cache
def _espeak():
    library = ctypes.CDLL(espeakng_loader.get_library_path())
    rate = library.espeak_Initialize(RETRIEVE, 0, espeakng_loader.get_data_path().encode(), 0)
    return library, rate


@functools.cache
def say(text, voice="gmw/en-US", speed=160):
    """`text` as samples at 16 kHz; `voice` as espeak-ng names its files, +variant."""
    espeak, rate = _espeak()
    pieces = []

    def take(samples, count, _events):
        if samples:
            pieces.append(np.ctypeslib.as_array(samples, (count,)).astype(float))
        return 0

    keep = _Take(take)
    espeak.espeak_SetSynthCallback(keep)
    if espeak.espeak_SetVoiceByName(voice.encode()) != 0:
        raise ValueError(f"no voice {voice}")
    espeak.espeak_SetParameter(_SPEED, speed, 0)
    espeak.espeak_SetParameter(_PITCH, 50, 0)
    spoken = text.encode() + b"\0"
    espeak.espeak_Synth(spoken, len(spoken), 0, 1, 0, _UTF8, None, None)
    espeak.espeak_Synchronize()
    sound = np.convolve(np.concatenate(pieces), [0.25, 0.5, 0.25], "same")
    at = np.arange(int(len(sound) * RATE / rate)) * (rate / RATE)
    sound = np.interp(at, np.arange(len(sound)), sound)
    return sound * (LEVEL / np.abs(sound).max())


def noise(samples, strength, seed):
    """Room noise: less of it the higher it sounds. `strength`: standard deviation."""
    spectrum = np.fft.rfft(np.random.default_rng(seed).standard_normal(samples))
    spectrum /= np.sqrt(np.arange(1, len(spectrum) + 1) / 50 + 1)
    rough = np.fft.irfft(spectrum, samples)
    return rough * (strength / rough.std())


def in_a_room(sound, snr_db=None, seed=0, before_s=0.6, after_s=0.8):
    """With a moment before and after it, and noise; as bytes."""
    silent = np.concatenate([np.zeros(int(before_s * RATE)), sound, np.zeros(int(after_s * RATE))])
    strength = 8.0 if snr_db is None else np.sqrt((sound**2).mean()) / 10 ** (snr_db / 20)
    heard = silent + noise(len(silent), strength, seed)
    return np.clip(heard, -32768, 32767).astype("<i2").tobytes()
