// The obstacle line: three segments around the view (left, front, right); colour, shape and word.

/** Where each direction is shown; behind the chair it is a tag on Achteruit. */
const PLACES = {
  left: "line-left",
  forward: "line-front",
  right: "line-right",
  backward: "backward",
};

/** Shows the board's decision per direction. */
export class ObstacleLine {
  #strings;
  #shown = {};

  constructor(strings) {
    this.#strings = strings;
  }

  /** `decisions`: direction -> "free", "slow", "blocked" or "unknown". */
  update(decisions) {
    for (const [direction, place] of Object.entries(PLACES)) {
      const decision = decisions[direction];
      if (this.#shown[direction] === decision) continue;
      this.#shown[direction] = decision;
      const element = document.getElementById(place);
      element.dataset.decision = decision;
      element.querySelector(".word").textContent = this.#strings.label(decision);
    }
  }
}
