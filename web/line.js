// The obstacle line: three segments around the view (left, front, right); colour, shape and word.

const SEGMENTS = { left: "left", front: "forward", right: "right" };

/** Shows the board's decision per direction on the three segments. */
export class ObstacleLine {
  #strings;
  #shown = {};

  constructor(strings) {
    this.#strings = strings;
  }

  /** `decisions`: direction -> "free", "slow", "blocked" or "unknown". */
  update(decisions) {
    for (const [segment, direction] of Object.entries(SEGMENTS)) {
      const decision = decisions[direction];
      if (this.#shown[segment] === decision) continue;
      this.#shown[segment] = decision;
      const element = document.getElementById(`line-${segment}`);
      element.dataset.decision = decision;
      element.querySelector(".word").textContent = this.#strings.label(decision);
    }
  }
}
