// Short tones: rising at the start, falling at the end, a buzz when the board overrides.

const LOUDNESS = 0.12;
const GAP_S = 0.02;

/** The shape of each tone: [Hz, seconds, wave] one after the other. */
const SHAPES = {
  start: [
    [520, 0.07, "sine"],
    [780, 0.1, "sine"],
  ],
  stop: [
    [520, 0.07, "sine"],
    [350, 0.12, "sine"],
  ],
  override: Array(3).fill([220, 0.11, "square"]),
  armed: [[660, 0.2, "triangle"]],
  alert: [
    [880, 0.16, "square"],
    [660, 0.16, "square"],
    [880, 0.16, "square"],
    [660, 0.16, "square"],
  ],
};

/** One audio context for the page; if the browser requires a press or key first, that wakes it. */
export class Tones {
  on = true;
  #context = new AudioContext();

  /** `changed(audible)` is called at once, and whenever it changes. */
  constructor(changed) {
    this.#context.onstatechange = () => changed(this.audible);
    changed(this.audible);
    for (const event of ["pointerup", "keydown"]) addEventListener(event, () => this.#wake());
  }

  /** True while the browser lets the page play sound. */
  get audible() {
    return this.#context.state === "running";
  }

  /** Plays the tone of this name (a key of SHAPES), or of a shape. */
  play(name) {
    if (!this.on || !this.audible) return;
    let at = this.#context.currentTime;
    for (const [hz, seconds, wave] of SHAPES[name] ?? name) {
      const tone = this.#context.createOscillator();
      const volume = this.#context.createGain();
      tone.type = wave;
      tone.frequency.value = hz;
      volume.gain.setValueAtTime(LOUDNESS, at);
      volume.gain.exponentialRampToValueAtTime(0.001, at + seconds);
      tone.connect(volume).connect(this.#context.destination);
      tone.start(at);
      tone.stop(at + seconds);
      at += seconds + GAP_S;
    }
  }

  #wake() {
    if (!this.audible) this.#context.resume();
  }
}
