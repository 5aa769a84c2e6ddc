"""The thread that recognises: it reads sound, and keeps the newest word for whoever asks."""

import threading
import time

OLD_S = 1.0  # a word that nobody asked for is forgotten
BUFFER_BYTES = 32_000  # 1 s of sound; more than that has waited too long
LOOK_S = 1.0  # between two looks for a microphone
HANGS_S = 3.0


class Listener:
    """Owns the thread `voice-recogniser` from start() to stop()."""

    def __init__(self, open_source, recogniser):
        """`open_source` and what it opens: see sources.py; `recogniser`: see words.py."""
        self._open = open_source
        self._recogniser = recogniser
        self._lock = threading.Lock()
        self._word, self._heard_s = "", 0.0
        self._alive_s = 0.0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="voice-recogniser", daemon=True)
        self.trouble = ""

    def start(self):
        """Begin to listen."""
        self._alive_s = time.monotonic()
        self._thread.start()

    def stop(self):
        """End the thread, and with it the source."""
        self._stopping.set()
        self._thread.join(HANGS_S)

    def take(self, now_s):
        """The newest word since the last call, "" for none. Raises RuntimeError when it hangs."""
        if not self._thread.is_alive() or now_s - self._alive_s > HANGS_S:
            raise RuntimeError("the recogniser has stopped working")
        with self._lock:
            word, self._word = self._word, ""
        return word if now_s - self._heard_s <= OLD_S else ""

    def _put(self, word):
        with self._lock:
            if self._word != "stop":  # no later word hides a stop
                self._word = word
            self._heard_s = time.monotonic()

    def _run(self):
        while not self._stopping.is_set():
            self._alive_s = time.monotonic()
            try:
                source = self._open()
            except OSError as error:
                self.trouble = str(error)
            else:
                try:
                    self._listen(source)
                except OSError as error:
                    self.trouble = str(error)
                finally:
                    source.close()
                    self._recogniser.forget()
            self._stopping.wait(LOOK_S)

    def _listen(self, source):
        while not self._stopping.is_set():
            data = source.read()
            self._alive_s = time.monotonic()
            if len(data) > BUFFER_BYTES:
                self._recogniser.forget()
                continue
            for word in self._recogniser.hear(data):
                self._put(word)
            self.trouble = self._recogniser.trouble
