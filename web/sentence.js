// The only place that decides which sentence the pages show, so that no two contradict each other.

/** Messages that pass by themselves: only wait. */
const WAITS = [
  "link_lost",
  "not_connected",
  "neutral_not_proven",
  "host_silent",
  "service_stalled",
  "obstacle_data_old",
  "heading_reset",
  "tick_stalled",
  "board_starting",
  "board_busy",
  "lidar_starting",
  "lidar_power",
];
/** Reasons for being disarmed that end with a request to arm: they do not prevent it. */
const READY = ["none", "no_owner", "command_active"];

/**
 * From the host's state (`news`), whether the link is alive, and whether this is practice:
 * {level, key} for the corner, "ok", "wait", "warning" (somebody must act) or "error", and
 * {kind, words} for the middle: "none", "ready", "hindered" (`words` is also `key`), "override" or
 * "taken" (`words`: the label of who drives). At most one message is shown at a time.
 */
export function sentence(news, linked, practice) {
  if (!linked) return { level: "error", key: "link_lost", kind: "none" };
  const { level, message, state, you, owner, arm_reason: hindrance, override } = news;
  const say = (grade, key, kind) => {
    const passes = grade === "warning" && WAITS.includes(key);
    return { level: passes ? "wait" : grade, key, kind, words: key };
  };
  const off = state === "disarmed";
  const whole = { ...say(level, message, "none"), turned: news.turned };
  if (practice) return { ...whole, kind: off ? "ready" : "none", words: "ready" };
  const ready = { ...whole, kind: "ready", words: "ready" };
  const taken = !off && !you && owner !== "nobody";
  if (taken) return { ...whole, kind: "taken", words: `owner_${owner}` };
  const overruled = !off && override !== "none";
  const why = off ? "hindered" : overruled ? "override" : "none";
  if (level === "error") return { ...whole, kind: why };
  if (off) return READY.includes(hindrance) ? ready : say("warning", hindrance, "hindered");
  return overruled ? say("warning", override, "override") : whole;
}
