// A short tone for "the board overrules you"; silent until the browser allows sound.

const TONE_HZ = 440;
const TONE_S = 0.18;
const LOUDNESS = 0.15;

/** One audio context for the page, woken by the first press or key. */
export class Tone {
  #context = null;

  constructor() {
    const wake = () => {
      this.#context ??= new AudioContext();
      this.#context.resume();
    };
    addEventListener("pointerup", wake, { once: true });
    addEventListener("keydown", wake, { once: true });
  }

  play() {
    if (this.#context?.state !== "running") return;
    const start = this.#context.currentTime;
    const tone = this.#context.createOscillator();
    const volume = this.#context.createGain();
    tone.frequency.value = TONE_HZ;
    volume.gain.setValueAtTime(LOUDNESS, start);
    volume.gain.exponentialRampToValueAtTime(0.001, start + TONE_S);
    tone.connect(volume).connect(this.#context.destination);
    tone.start(start);
    tone.stop(start + TONE_S);
  }
}
