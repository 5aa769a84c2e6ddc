// A map's picture on a MapView; one that does not come is asked for again.

const AGAIN_MS = 2000;

export class MapPicture {
  /** The id of the map, "" for none. */
  map = "";
  #view;
  #on;
  #failed = false;
  #askedMs = 0;

  /** `on(known)`: where the picture belongs is known; or it does not come. */
  constructor(view, on = () => {}) {
    [this.#view, this.#on] = [view, on];
  }

  /** Shows that map. Call it again and again. */
  show(map) {
    const again = this.#failed && performance.now() - this.#askedMs >= AGAIN_MS;
    if (map === this.map && !again) return;
    [this.map, this.#failed, this.#askedMs] = [map, false, performance.now()];
    this.#view.clear();
    if (map) this.#ask(map);
  }

  async #ask(map) {
    try {
      const answer = await fetch(`/maps/${map}`, { cache: "no-store" });
      if (!answer.ok) throw new Error(`the host answered ${answer.status}`);
      const { picture } = await answer.json();
      if (map !== this.map) return; // another map meanwhile
      this.#on(true);
      if (!(await this.#view.picture(`/maps/${map}.png`, picture))) throw new Error("no picture");
    } catch (error) {
      console.warn(`map ${map}: ${error.message}`);
      if (map !== this.map) return;
      this.#failed = true;
      this.#on(false);
    }
  }
}
