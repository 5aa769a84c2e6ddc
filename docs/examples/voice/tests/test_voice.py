"""The recogniser with synthetic speech, its thread, and sound that is broken or missing."""

import os
import struct
import threading
import time
import wave

import numpy as np
import pytest

from confusion import heard
from gazechair.plugins import NOTHING, STOP, Unusable, choose, step
from gazechair_voice import sources
from gazechair_voice.listener import Listener
from gazechair_voice.voice import Voice
from gazechair_voice.words import Recogniser
from speech import in_a_room, noise, say

VOICES = ("gmw/en-US", "gmw/en-US+m3", "gmw/en-US+m1")
PATIENCE_S = 20.0


@pytest.fixture(scope="module")
def recogniser():
    return Recogniser(["left", "right", "forward"])


def settings(**changed):
    return Voice.Settings(**{"source": "rehearsal", **changed})


def wav(path, sound, rate=16_000, width=2, channels=1):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(width)
        file.setframerate(rate)
        file.writeframes(sound)
    return str(path)


def until(condition):
    end_s = time.monotonic() + PATIENCE_S
    while not (found := condition()):
        assert time.monotonic() < end_s
        time.sleep(0.01)
    return found


def test_words_are_heard_and_stop_is_favoured(recogniser):
    right = {
        word: sum(heard(recogniser, word, voice, 160, 20, seed=n) == word for n in range(2))
        for voice in VOICES
        for word in ("stop",)
    }
    assert right["stop"] == 2
    for word in ("left", "right", "forward"):
        found = [heard(recogniser, word, voice, 160, None, 1) for voice in VOICES]
        assert found.count(word) >= 2
        assert set(found) <= {word, "-"}


def test_silence_noise_and_other_words_are_nothing(recogniser):
    recogniser.forget()
    assert recogniser.hear(bytes(5 * 32_000)) == []
    for strength in (10, 100, 1000, 8000):
        recogniser.forget()
        rough = np.clip(noise(5 * 16_000, strength, 1), -32768, 32767).astype("<i2")
        assert recogniser.hear(rough.tobytes()) == []
    assert recogniser.trouble == "it is too loud here to hear a word"
    for words in ("battery", "orange", "could you bring me a glass of water", "thirsty"):
        assert heard(recogniser, words, "gmw/en-US", 160, 20, 1) == "-"


def test_sound_may_be_cut_anywhere_and_what_was_before_a_gap_counts_no_more(recogniser):
    sound = in_a_room(say("stop"))
    recogniser.forget()
    pieces = [sound[at : at + 333] for at in range(0, len(sound), 333)]
    assert [word for piece in pieces for word in recogniser.hear(piece)] == ["stop"]
    recogniser.hear(sound[: len(sound) // 2])
    recogniser.forget()
    assert recogniser.hear(bytes(32_000)) == []


def test_the_package_of_the_recogniser_is_named_when_it_is_missing(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pocketsphinx", None)
    with pytest.raises(Unusable, match="pip install pocketsphinx"):
        Recogniser([])


def test_a_word_that_it_does_not_know_is_refused():
    with pytest.raises(Unusable, match="'keukn' is not in the recogniser's English dictionary"):
        Recogniser(["keukn"])


class Words:
    """A listener without sound."""

    def __init__(self, *words):
        self.words = list(words)

    def take(self, _now_s):
        return self.words.pop(0) if self.words else ""


def test_a_word_is_an_intent_for_a_while_and_nothing_hides_a_stop():
    voice = Voice(settings(modes="ahead"))
    voice._intents["ahead"] = choose("ahead")
    voice._listener = Words("left")
    assert [voice.sense(at) for at in (1.0, 1.2, 1.4)] == [step("left"), step("left"), NOTHING]
    voice._listener = Words("stop", "left", "ahead")
    assert [voice.sense(at) for at in (2.0, 2.2, 2.9, 3.1)] == [STOP, STOP, STOP, NOTHING]
    voice._listener = Words("ahead", "", "stop")
    assert [voice.sense(at) for at in (4.0, 4.9, 4.95)] == [choose("ahead")] * 2 + [STOP]


class Source:
    """A source of given pieces; then it is pulled out."""

    def __init__(self, *pieces):
        self.pieces = list(pieces)
        self.closed = False

    def read(self):
        if not self.pieces:
            raise OSError("it was pulled out")
        return self.pieces.pop(0)

    def close(self):
        self.closed = True


class Echo:
    """A recogniser that hears what the bytes say."""

    trouble = ""

    def __init__(self):
        self.forgot = 0

    def hear(self, data):
        return data.decode().split()

    def forget(self):
        self.forgot += 1


def test_the_newest_word_counts_and_a_stop_is_kept_and_old_sound_is_dropped():
    source, echo = Source(b"left", b"stop", b"right", b"left " * 10_000), Echo()
    listener = Listener(lambda: source, echo)
    listener.start()
    until(lambda: source.closed and listener.trouble)
    assert listener.trouble == "it was pulled out"
    assert listener.take(time.monotonic()) == "stop"
    assert listener.take(time.monotonic()) == ""
    assert echo.forgot == 2  # what waited too long, and the end
    listener.stop()
    with pytest.raises(RuntimeError, match="has stopped working"):
        listener.take(time.monotonic())


def test_a_word_that_nobody_asked_for_is_forgotten_and_one_that_hangs_is_told():
    release = threading.Event()
    listener = Listener(lambda: Source(b"left") if not release.wait(5) else Source(), Echo())
    listener.start()
    listener._put("right")
    assert listener.take(time.monotonic() + 1.1) == ""
    with pytest.raises(RuntimeError):
        listener.take(time.monotonic() + 3.1)
    release.set()
    listener.stop()
    assert "voice-recogniser" not in [thread.name for thread in threading.enumerate()]


def test_every_kind_of_pcm_is_read(tmp_path):
    sound = say("stop")
    short = np.round(sound).astype("<i2")
    tone = wav(tmp_path / "mono.wav", short.tobytes())
    assert sources.read_wav(tone) == short.tobytes()
    stereo = wav(tmp_path / "2.wav", np.column_stack([short, short]).tobytes(), channels=2)
    assert sources.read_wav(stereo) == short.tobytes()
    wide = wav(tmp_path / "4.wav", (short.astype("<i4") << 16).tobytes(), width=4)
    assert sources.read_wav(wide) == short.tobytes()
    recogniser = Recogniser(["left"])
    for name, rate, width in (("8.wav", 16_000, 1), ("48.wav", 48_000, 2), ("44.wav", 44_100, 2)):
        at = np.arange(int(len(sound) * rate / 16_000)) * (16_000 / rate)
        other = np.interp(at, np.arange(len(sound)), sound)
        raw = (other / 256 + 128).astype(np.uint8) if width == 1 else other.astype("<i2")
        read = np.frombuffer(
            sources.read_wav(wav(tmp_path / name, raw.tobytes(), rate, width)), "<i2"
        )
        recogniser.forget()
        assert recogniser.hear(in_a_room(read.astype(float))) == ["stop"], name


def test_a_wav_file_that_is_none_is_refused_in_one_line(tmp_path):
    wav(tmp_path / "whole.wav", bytes(3200))
    whole = (tmp_path / "whole.wav").read_bytes()
    floats = bytearray(whole)
    floats[20:22] = struct.pack("<H", 3)
    bad = {"empty": b"", "text": b"hello", "cut": whole[:30], "float": bytes(floats)}
    for name, content in bad.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(Unusable) as refused:
            sources.read_wav(str(tmp_path / name))
        assert "is no WAV file of PCM sound" in str(refused.value)
        assert "\n" not in str(refused.value)
    for rate in (8000, 2_000_000_000):
        with pytest.raises(Unusable, match=f"{rate} samples a second, not 16000 to 192000"):
            sources.read_wav(wav(tmp_path / "rate.wav", bytes(320), rate=rate))
    assert sources.read_wav(wav(tmp_path / "none.wav", b"")) == b""
    (tmp_path / "truncated.wav").write_bytes(whole[:1001])
    assert len(sources.read_wav(str(tmp_path / "truncated.wav"))) == 956  # whole samples only
    for path in ("/no/such.wav", "a\0b", str(tmp_path)):
        with pytest.raises(Unusable):
            sources.opener(path, "")


def test_no_arecord_is_said_and_a_microphone_that_is_pulled_out(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(Unusable, match="apt install alsa-utils"):
        sources.opener("microphone", "default")
    program = tmp_path / "arecord"
    program.write_text("#!/bin/sh\nprintf abcd\necho 'arecord: main:831: no such device' >&2\n")
    program.chmod(0o755)
    microphone = sources.opener("microphone", "default")()
    heard_bytes = until(microphone.read)
    assert heard_bytes == b"abcd"
    with pytest.raises(OSError, match="no microphone: arecord: main:831: no such device"):
        until(microphone.read)
    microphone.close()


def test_a_pipe_with_nobody_and_one_whose_writer_leaves(tmp_path):
    path = str(tmp_path / "pipe")
    os.mkfifo(path)
    pipe = sources.opener(path, "")()
    assert pipe.read() == b""  # nobody has come yet
    writer = os.open(path, os.O_WRONLY)
    os.write(writer, b"abc")
    assert pipe.read() == b"ab"
    os.write(writer, b"d")
    assert pipe.read() == b"cd"
    os.close(writer)
    with pytest.raises(OSError, match="has left"):
        pipe.read()
    pipe.close()
    silent = sources.Pipe(os.open("/dev/zero", os.O_RDONLY))
    silent._fd, zero = os.pipe()[0], silent._fd
    silent._last_s -= 1.0
    with pytest.raises(OSError, match="no sound arrives"):
        silent.read()
    os.close(zero)
    silent.close()


def test_a_recording_is_played_once_at_its_own_speed_and_sense_never_waits(tmp_path):
    path = wav(tmp_path / "stop.wav", in_a_room(say("stop")))
    voice = Voice(settings(source=path))
    longest_s, said = 0.0, set()
    end_s = time.monotonic() + PATIENCE_S
    while "the recording has ended" not in voice.trouble():
        assert time.monotonic() < end_s
        began_s = time.thread_time()
        said.add(voice.sense(time.monotonic()).do)
        longest_s = max(longest_s, time.thread_time() - began_s)
        time.sleep(0.02)
    assert said == {"nothing", "stop"}
    assert longest_s < 0.02
    voice.close()
