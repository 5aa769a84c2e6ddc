// The driver's page: puts the parts together; one timer moves them all.

import { Banner } from "./banner.js";
import { HitMap } from "./hit.js";
import { listen } from "./input.js";
import { ObstacleLine } from "./line.js";
import { Picture } from "./picture.js";
import { ControlSocket } from "./socket.js";
import { Tone } from "./sound.js";
import { StatusCorner } from "./status.js";
import { chosenLanguage, loadStrings } from "./strings.js";
import { Targets } from "./targets.js";
import { keepAwake } from "./wakelock.js";

const TICK_MS = 25;
/** Arming tests the relay (200 ms); a board still disarmed after this has refused. */
const ARMING_MS = 600;
const LINK_AGE_EVERY_MS = 1000;
/** Reasons that pass by asking to arm, or by waiting a moment: no reason to hold back. */
const NO_HINDRANCE = ["none", "no_owner", "command_active"];

const language = chosenLanguage(location.search);
const strings = await loadStrings(language);
const body = document.body;
const byId = (id) => document.getElementById(id);
const setText = (id, text) => {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
};
const setData = (element, name, value) => {
  if (element.dataset[name] !== String(value)) element.dataset[name] = value;
};

document.documentElement.lang = language;
document.title = strings.label("title");
strings.fill(document);

const hits = new HitMap();
const measure = () => hits.measure(document.querySelectorAll(".target"));
const banner = new Banner(strings, new Tone());
const corner = new StatusCorner(strings, measure);
const line = new ObstacleLine(strings);
const picture = new Picture(byId("picture"), (age) => setData(body, "picture", age));

let state = null; // the host's newest state
let armAskedMs = null;
let worstAgeMs = 0;
let linkShownMs = 0;

const acts = {
  arm() {
    if (state?.state !== "disarmed") return socket.send("disarm");
    armAskedMs = performance.now();
    socket.sendFresh("arm");
  },
  mode() {
    targets.setMode(targets.mode === "step" ? "continuous" : "step", performance.now());
    setData(body, "mode", targets.mode);
  },
  reset: () => socket.send("reset"),
};

const targets = new Targets({
  drive: (verb, mode, edge) => socket.sendFresh("cmd", { verb, mode, edge }),
  stop: () => socket.send("stop"),
  act: (name) => acts[name](),
  tap: () => banner.notice("tap_title", "tap", performance.now()),
  view(dwelling, holding) {
    for (const target of document.querySelectorAll(".target")) {
      target.classList.toggle("dwelling", target.id === dwelling);
      target.classList.toggle("holding", target.id === holding);
    }
  },
});

const socket = new ControlSocket({
  message: (message) => receivers[message.k]?.(message, performance.now()),
  link(alive) {
    setData(body, "link", alive ? "ok" : "lost");
    if (!alive) targets.cancel(performance.now());
  },
});

const receivers = {
  welcome(welcome) {
    targets.configure(welcome);
    body.style.setProperty("--dwell", `${welcome.dwell_ms}ms`);
    setData(body, "backward", welcome.backward);
    setData(body, "simulated", welcome.simulated);
    measure();
  },
  state(news, now) {
    state = news;
    targets.setArmed(news.state === "armed" && news.you, now);
    setData(body, "state", news.state);
    setData(body, "simulated", news.simulated);
    setText("arm-label", strings.label(news.state === "disarmed" ? "arm" : "disarm"));
    setText("arm-state", strings.label(news.state));
    setText("motion", strings.label(`motion_${news.motion}`));
    setText("owner", strings.label(news.you ? "you" : `owner_${news.owner}`));
    showHint(news);
    line.update(news.decisions);
    corner.update(news.level, news.message);
    judgeArming(news, now);
    banner.override(news.override, now);
  },
  refused(refusal, now) {
    if (refusal.what === "arm") armAskedMs = null;
    banner.notice(refusal.what === "arm" ? "arm_refused" : "refused", refusal.reason, now);
    console.warn(`${refusal.what} refused: ${refusal.detail}`);
  },
};

/** What stands in the middle while driving is off: how to begin, or what is still in the way. */
function showHint(news) {
  const ready = NO_HINDRANCE.includes(news.arm_reason);
  const reason = strings.message(ready ? "ready" : news.arm_reason);
  setText("hint-title", strings.label(ready ? "hint_ready" : "hint_waiting"));
  setText("hint-text", reason.text);
  setText("hint-do", reason.do);
}

/** Says why, when the driver asked to arm and the board did not. */
function judgeArming(news, now) {
  if (armAskedMs === null) return;
  if (news.state === "armed") armAskedMs = null;
  if (news.state !== "disarmed" || now - armAskedMs < ARMING_MS) return;
  armAskedMs = null;
  if (news.arm_reason !== "none") banner.notice("arm_refused", news.arm_reason, now);
}

/** The link's worst age of the last second: a number that can be read. */
function showLinkAge(now) {
  worstAgeMs = Math.max(worstAgeMs, socket.ageMs(now));
  if (now - linkShownMs < LINK_AGE_EVERY_MS) return;
  if (socket.alive) setText("link-age", `${Math.round(worstAgeMs / 10) * 10} ms`);
  linkShownMs = now;
  worstAgeMs = 0;
}

const otherLanguage = new URL(location.href);
otherLanguage.searchParams.set("lang", language === "nl" ? "en" : "nl");
byId("language").href = otherLanguage.href;

measure();
addEventListener("resize", measure);
listen(targets, hits, (name) => name !== "backward" || body.dataset.backward === "true");
keepAwake();
setInterval(() => {
  const now = performance.now();
  targets.tick(now);
  socket.tick(now);
  picture.tick(now);
  banner.tick(now);
  showLinkAge(now);
}, TICK_MS);
