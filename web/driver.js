// The driver's page: puts the parts together; one timer moves them all.

import { Banner } from "./banner.js";
import { EyeTest } from "./eyes.js";
import { Facts } from "./facts.js";
import { Hint } from "./hint.js";
import { HitMap } from "./hit.js";
import { listen } from "./input.js";
import { ObstacleLine } from "./line.js";
import { Menu } from "./menu.js";
import { Picture } from "./picture.js";
import { Practice } from "./practice.js";
import { loadProfiles } from "./profile.js";
import { ControlSocket } from "./socket.js";
import { StatusCorner } from "./status.js";
import { chosenLanguage, loadStrings } from "./strings.js";
import { Targets } from "./targets.js";
import { Tones } from "./tones.js";
import { keepAwake } from "./wakelock.js";
import { AutoOff, ClockWatch } from "./watch.js";

const TICK_MS = 25;
/** The label of "Rijden uit" counts down the last seconds before driving goes off by itself. */
const COUNTDOWN_MS = 5000;
/** So many clicks without any movement: the eyes only click, and a click can only be a step. */
const CLICKS_MEAN_STEPS = 2;

const profiles = await loadProfiles();
const strings = await loadStrings(chosenLanguage(location.search, profiles.current.language));
const body = document.body;
const byId = (id) => document.getElementById(id);
const setText = (id, text) => {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
};
const setData = (name, value) => {
  if (body.dataset[name] !== String(value)) body.dataset[name] = value;
};

document.documentElement.lang = strings.language;
document.title = strings.label("title");
strings.fill(document);
const ring = document.createElementNS(document.querySelector("svg").namespaceURI, "circle");
const shape = { class: "ring", cx: 50, cy: 50, r: 45, pathLength: 100 };
for (const [name, value] of Object.entries(shape)) ring.setAttribute(name, value);
const menu = new Menu(strings, profiles, {
  changed: (fields) => change({ save: { id: profiles.current.id, ...fields } }),
  choose: (id) => change({ choose: id }),
  practice() {
    practice.toggle();
    setData("practice", practice.on);
    open("drive");
  },
  eyes() {
    open("eyes");
    eyes.start(performance.now());
  },
  closed: () => open("drive"),
});
for (const mark of document.querySelectorAll(".mark")) mark.prepend(ring.cloneNode());

const hits = new HitMap();
const measure = () =>
  hits.measure(document.querySelectorAll(".target"), profiles.current.growth_percent / 100);
const tones = new Tones();
const banner = new Banner(strings, tones);
const corner = new StatusCorner(strings);
const facts = new Facts(strings);
const hint = new Hint(strings, (reason) => notice("arm_refused", reason));
const line = new ObstacleLine(strings);
const practice = new Practice(strings);
const picture = new Picture(byId("picture"), (age) => setData("picture", age));
const autoOff = new AutoOff();
const clock = new ClockWatch();
const eyes = new EyeTest((left) => setText("eyes-left", `${left} s`), judged);

let state = null; // the host's newest state
let asked = null; // the verb held
let clicksAlone = 0;
let driving = false; // told by the start tone
let reloading = false;

const acts = {
  arm() {
    if (practice.on) {
      practice.arm();
      return showState(state, performance.now());
    }
    if (state?.state !== "disarmed") return socket.send("disarm");
    hint.asked(performance.now());
    socket.sendFresh("arm");
  },
  mode: () => setMode(targets.mode === "step" ? "continuous" : "step"),
  menu() {
    menu.show("main");
    open("menu");
  },
  help() {
    if (!socket.send("call", { on: !state.call })) notice("refused", "no_answer");
  },
  back() {
    if (body.dataset.view === "menu") menu.back();
  },
};
for (let at = 1; at <= 5; at += 1) acts[`tile-${at}`] = () => menu.act(at);

const targets = new Targets({
  drive(verb, mode, edge) {
    asked = verb;
    autoOff.used(performance.now());
    if (practice.on) practice.drive(verb, edge);
    else socket.sendFresh("cmd", { verb, mode, edge });
    if (driving) return;
    driving = true;
    if (practice.armed || state?.you) tones.play("start");
  },
  stop(wished) {
    // Another's driving is stopped by looking at Stop, not by looking away from this page.
    if (wished || state === null || state.you) socket.send("stop");
    ended();
  },
  act: (name) => acts[name]?.(),
  tap() {
    if (clicksAlone < CLICKS_MEAN_STEPS) return notice("tap_title", "tap");
    setMode("step");
    notice("clicks_title", "clicks");
  },
  view(dwelling, holding, dwellMs) {
    if (dwelling) body.style.setProperty("--dwell", `${dwellMs}ms`);
    if (holding === null) ended();
    for (const target of document.querySelectorAll(".target")) {
      target.classList.toggle("dwelling", target.id === dwelling);
      target.classList.toggle("holding", target.id === holding);
    }
  },
});

const socket = new ControlSocket({
  message: (message) => receivers[message.k]?.(message, performance.now()),
  link(alive) {
    setData("link", alive ? "ok" : "lost");
    if (!alive) targets.cancel(performance.now());
  },
});

const receivers = {
  welcome(welcome) {
    targets.setHeartbeat(welcome.heartbeat_ms);
    setData("backward", welcome.backward);
    setData("insecure", welcome.insecure);
    measure();
  },
  state(news, now) {
    state = news;
    if (news.profile !== undefined && news.profile !== profiles.revision) reload();
    showState(news, now);
    if (!practice.on) banner.override(news.override, now);
  },
  refused(refusal, now) {
    if (refusal.what === "arm") hint.answered();
    banner.notice(refusal.what === "arm" ? "arm_refused" : "refused", refusal.reason, now);
    console.warn(`${refusal.what} refused: ${refusal.detail}`);
  },
};

function showState(news, now) {
  if (news === null) return;
  const armed = practice.on ? practice.armed : news.state === "armed" && news.you;
  const shown = practice.on ? (armed ? "armed" : "disarmed") : news.state;
  targets.setArmed(armed, now);
  if (!armed || targets.holding) autoOff.used(now);
  if (body.dataset.state !== shown) {
    if (shown === "armed") tones.play("armed");
    setData("state", shown);
    measure();
  }
  setData("simulated", news.simulated);
  setData("relay", news.relay_checked ?? true);
  setData("call", news.call ?? false);
  if (byId("help").ariaPressed !== body.dataset.call) byId("help").ariaPressed = body.dataset.call;
  setText("help-label", strings.label(news.call ? "help_asked" : "help"));
  setText("arm-label", strings.label(shown === "disarmed" ? "arm" : "disarm"));
  const left = Math.ceil(autoOff.leftMs(now) / 1000);
  const soon = armed && autoOff.leftMs(now) <= COUNTDOWN_MS;
  setText("arm-state", soon ? `${strings.label("off_in")} ${left} s` : strings.label(shown));
  facts.update(news, asked, now);
  hint.update(shown, practice.on ? "none" : news.arm_reason, now);
  line.update(news);
  corner.update(news.level, news.message);
}

function notice(title, key) {
  banner.notice(title, key, performance.now());
}

/** A held command is over. */
function ended() {
  asked = null;
  if (!driving) return;
  driving = false;
  tones.play("stop");
}

function setMode(mode) {
  targets.setMode(mode, performance.now());
  setData("mode", mode);
  setText("menu-state", strings.label(mode));
}

/** Shows "drive", "menu" or "eyes"; whatever was held ends. */
function open(view) {
  targets.cancel(performance.now());
  eyes.stop();
  setData("view", view);
  measure();
}

/** Driving goes off: nobody is known to be before the page, or nobody used it. */
function switchOff() {
  practice.armed = false;
  autoOff.used(performance.now()); // said once
  if (state?.you) socket.send("disarm");
}

/** The chair is this page's, or it practises so: only this page changes how it drives. */
function drives() {
  return Boolean(state?.you) || practice.armed || targets.holding;
}

async function change(wish) {
  const reason = await profiles.change(wish, drives);
  if (reason) notice("refused", reason);
  applyProfile();
}

/** What others have changed is taken over when this page does not drive. */
async function reload() {
  if (reloading || drives()) return;
  reloading = true;
  const taken = await profiles.reload(() => !drives());
  reloading = false;
  if (taken) applyProfile();
}

/** Takes over the chosen profile; another language is another page. */
function applyProfile() {
  const mine = profiles.current;
  if (mine.language !== strings.language && !new URLSearchParams(location.search).has("lang")) {
    return location.reload();
  }
  targets.configure(mine);
  autoOff.configure(mine.auto_off_s);
  tones.on = mine.tones;
  setData("contrast", mine.contrast);
  setData("mirrored", mine.mirrored);
  setMode(mine.mode);
  if (body.dataset.view === "menu") menu.show();
  measure();
}

/** The eye test is over: proposes, and takes over when the driver chooses so. */
function judged(result) {
  open("menu");
  menu.show("eyes", result);
}

applyProfile();
addEventListener("resize", measure);
listen(targets, hits, {
  shown: (name) => byId(name).offsetWidth > 0,
  away: switchOff,
  pressed: (alone) => (clicksAlone = alone ? clicksAlone + 1 : 0),
});
keepAwake();
setInterval(() => {
  const now = performance.now();
  if (clock.jumped(now, Date.now())) {
    targets.cancel(now);
    switchOff();
  }
  targets.tick(now);
  if (targets.holding) autoOff.used(now);
  else if (autoOff.leftMs(now) <= 0) switchOff();
  socket.tick(now);
  picture.tick(now);
  banner.tick(now);
  eyes.tick(now);
  facts.ages(socket.alive ? socket.ageMs(now) : null, picture.ageMs(now), now);
}, TICK_MS);
