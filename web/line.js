// The obstacle line: three segments around the view (left, front, right); colour, shape and text.

/** Where each direction is shown; backward is a tag on Achteruit. */
const PLACES = {
  left: "line-left",
  forward: "line-front",
  right: "line-right",
  backward: "backward",
};
const TURNS = ["left", "right"];
/** Decisions that block a motion. */
const STOPS = ["blocked", "unknown"];

/** Shows the board's decision and the free distance per direction. */
export class ObstacleLine {
  #strings;
  #shown = {};

  constructor(strings) {
    this.#strings = strings;
  }

  /**
   * `decisions`: direction -> "free", "slow", "blocked" or "unknown". If the host sends them,
   * `clearance`: metres forward and backward, degrees left and right, null for not known; `view`:
   * direction -> "seen", "blind" or "unseen".
   */
  update({ decisions, clearance, view }) {
    for (const [direction, place] of Object.entries(PLACES)) {
      const seen = view?.[direction] ?? "seen";
      let decision = decisions[direction];
      let far = this.#far(direction, clearance?.[direction] ?? null);
      // "Not seen" is the reason for blocking; if the board still permits motion, show both.
      if (seen !== "seen" && STOPS.includes(decision)) [decision, far] = [seen, ""];
      else if (seen !== "seen") far = this.#strings.label(seen);
      if (this.#shown[direction] === `${decision} ${far} ${seen}`) continue;
      this.#shown[direction] = `${decision} ${far} ${seen}`;
      const element = document.getElementById(place);
      if (element.dataset.decision !== decision) element.dataset.decision = decision;
      if (element.dataset.seen !== seen) element.dataset.seen = seen;
      element.querySelector(".word").textContent = this.#strings.label(decision);
      element.querySelector(".far").textContent = far;
      // Replaced as a whole, so that no text moves because another grew.
      const tag = element.querySelector(".tag") ?? element;
      tag.replaceChildren(...[...tag.childNodes].map((node) => node.cloneNode(true)));
    }
  }

  #far(direction, free) {
    if (free === null) return "";
    if (TURNS.includes(direction)) return `${Math.floor(free / 5) * 5}°`;
    return `${this.#strings.number(Math.floor(free * 10) / 10, 1)} m`;
  }
}
