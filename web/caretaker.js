// The caretaker's page: connects its parts; one timer drives them all.

import { AlertList } from "./alert_list.js";
import { Alerts } from "./alerts.js";
import { Banner } from "./banner.js";
import { ChairSettings, PersonSettings } from "./care_settings.js";
import { CapSlider } from "./cap_slider.js";
import { ClockWatch } from "./clock_watch.js";
import { byId, setData, setText } from "./dom.js";
import { Facts } from "./facts.js";
import { Gamepads } from "./gamepad.js";
import { setHeartbeat } from "./heartbeat.js";
import { atTouch, HeldButton } from "./held_button.js";
import { WORDS_MS } from "./help.js";
import { Joystick } from "./joystick.js";
import { ObstacleLine } from "./line.js";
import { Pairing } from "./pairing.js";
import { Picture } from "./picture.js";
import { PluginList } from "./plugin_list.js";
import { loadProfiles } from "./profile.js";
import { sentence } from "./sentence.js";
import { ControlSocket } from "./socket.js";
import { StatusCorner } from "./status.js";
import { StopSeen } from "./stop_seen.js";
import { chosenLanguage, loadStrings } from "./strings.js";
import { Tones } from "./tones.js";
import { keepAwake } from "./wakelock.js";

const TICK_MS = 25;
const RESET_HOLD_MS = 2000;
const TABS = ["drive", "settings", "first", "maps", "modules", "pairing", "alarms"];

const strings = await loadStrings(chosenLanguage(location.search, navigator.language), "care");
const body = document.body;

strings.fill("care_title");

const tones = new Tones((audible) => setData("audible", audible));
const banner = new Banner(strings, tones);
const corner = new StatusCorner(strings);
const facts = new Facts(strings, {
  owner_driver: "care_owner_driver",
  owner_caretaker: "care_owner_caretaker",
});
const line = new ObstacleLine(strings);
const picture = new Picture(byId("picture"), (age) => setData("picture", age));
const alerts = new Alerts(tones);
const alertList = new AlertList(byId("alerts"), strings, (open) => {
  alerts.open(open, performance.now());
  setData("alerts", open.length > 0);
});
const stopSeen = new StopSeen(strings);
const clock = new ClockWatch();
const cap = new CapSlider(strings, (permille) => socket.send("cap", { permille }));
const refuse = (key) => banner.notice("refused", key, performance.now());
const persons = new PersonSettings(byId("profiles"), strings, await loadProfiles(), refuse);
const chair = new ChairSettings(byId("chair"), strings, refuse);
const plugins = new PluginList(byId("plugins"), strings.language);
const pairing = new Pairing(byId("invite"), byId("devices"), strings, refuse);

let state = null; // the host's newest state
let latched = []; // messages that only a reset clears
let away = false; // the person has left since the last request to take over
let edge = 0;
let youMs = -WORDS_MS; // since when this page drives, or does not
let comingMs = null; // since when a caretaker is reported as coming
let first = null; // the first drive, once opened
let maps = null; // the maps, once opened
const loading = {}; // promises of parts
let going = null; // the auto motion's part, once needed: a promise while it loads

const socket = new ControlSocket({
  message: (message) => receivers[message.k]?.(message, performance.now()),
  link(alive) {
    setData("link", alive ? "ok" : "lost");
    if (!alive) endAll();
    showMessage(performance.now());
  },
  closed: () => stopSeen.closed(),
});

const joystick = new Joystick(byId("pad"), byId("knob"), {
  drive(linear, turn, fresh) {
    if (fresh) edge += 1;
    socket.sendFresh("drive", { linear, turn, edge });
  },
  stop: () => socket.send("stop"),
});

const gamepads = new Gamepads({
  moveTo: (place, fresh) => joystick.moveTo(place, fresh),
  letGo: () => joystick.release(),
  stop,
});
/** Only a visible page with focus drives. */
function lookAtGamepads() {
  const ready = joystick.enabled && !document.hidden && document.hasFocus();
  gamepads.look([...(navigator.getGamepads?.() ?? [])], ready);
}

let bypassEdge = 0;
const bypass = new HeldButton(byId("bypass"), {
  begin: () => (bypassEdge = edge += 1),
  held: () => socket.sendFresh("bypass", { held: true, edge: bypassEdge }),
  end: () => socket.send("bypass", { held: false }),
});
const watching = new HeldButton(byId("watch"), {
  begin() {},
  held: () => socket.sendFresh("watch", {}),
  end() {},
});
let resetSince = null;
const reset = new HeldButton(byId("reset"), {
  begin: () => (resetSince = performance.now()),
  held() {
    if (resetSince === null || performance.now() - resetSince < RESET_HOLD_MS) return;
    resetSince = null;
    socket.sendFresh("reset");
  },
  end: () => (resetSince = null),
});
const holds = [joystick, bypass, watching, reset];

const receivers = {
  welcome(welcome) {
    setData("role", welcome.role);
    setData("insecure", welcome.insecure);
    latched = welcome.latched;
    plugins.update(welcome.plugins ?? []);
    setHeartbeat(welcome.heartbeat_ms);
  },
  state(news, now) {
    if (news.you !== (state?.you ?? false)) youMs = now;
    if (news.message !== state?.message) reset.end(); // it means what was shown
    state = news;
    if (away && news.you) socket.send("release");
    setData("state", news.state);
    setData("you", news.you);
    setData("simulated", news.simulated);
    setData("call", news.coming ? "coming" : news.call);
    setText("call-title", strings.label(news.coming ? "care_coming" : "care_call"));
    comingMs = news.coming ? (comingMs ?? now) : null;
    setText("answer", strings.label(news.coming ? "care_there" : "care_answer"));
    setData("latched", news.level === "error" && latched.includes(news.message));
    facts.update(news, null);
    plugins.show(news.token);
    line.update(news);
    showMessage(now);
    stopSeen.update(news.stops, now);
    alerts.update(news, now);
    if (body.dataset.role === "caretaker") alertList.update(news.alerts);
    const ready = news.you && news.state === "armed" && body.dataset.role === "caretaker";
    joystick.enabled = ready;
    setText("take", strings.label(news.you ? "care_release" : "care_take"));
    setText("pad-word", ready ? "" : strings.label(news.you ? "arming" : "care_pad_off"));
    cap.update(news.cap_permille);
    setData("rides", Boolean(news.auto?.[0]));
    if (!news.auto?.[0]) watching.end();
    if (news.going) going ??= openGoing();
    going?.update?.(news.going, news.where, Boolean(news.auto?.[0]));
    const left = Math.ceil(news.bypass_ms / 1000);
    setText("bypass-left", left > 0 ? `${left} s` : "");
    persons.update(news.profile);
  },
  refused(refusal) {
    if (refusal.what === "step") first?.refused(refusal.reason);
    else refuse(refusal.reason);
    console.warn(`${refusal.what} refused: ${refusal.detail}`);
  },
};

/** One sentence about the state; a phone that does not drive shows overrides, too. */
function showMessage(now) {
  if (state === null && socket.alive) return;
  const about = sentence(state && { ...state, you: true }, socket.alive, false);
  const message = plugins.sentence(about, state?.token);
  corner.update(named(message));
  banner.steady(message.kind, message.words, now);
}

/** With the name of what the host's message is about, such as a lidar. */
function named(message) {
  if (message.texts || !state?.about || message.key !== state.message) return message;
  const texts = strings.message(message.key);
  return { ...message, texts: { ...texts, text: `${texts.text} (${state.about})` } };
}

function endAll() {
  for (const part of [...holds, first]) part?.end();
}

/** Loads a part on demand; undefined when it does not load. One that still loads is made once. */
function late(name, make) {
  loading[name] ??= loaded(name, make).finally(() => delete loading[name]);
  return loading[name];
}

async function loaded(name, make) {
  try {
    return await make(await import(`./${name}.js`));
  } catch (error) {
    console.warn(`${name}: ${error.message}`);
    return undefined;
  }
}

async function openFirst() {
  const on = {
    edge: () => (edge += 1),
    hold: (step, number) => socket.sendFresh("step", { step, held: true, edge: number }),
    letGo: () => socket.send("step", { held: false }),
    people: () => persons.people,
    choose: (id) => persons.choose(id),
  };
  const part = await late("first_drive", (made) => made.firstDrive(byId("first"), strings, on));
  first ??= part;
  if (!part) refuse("no_answer");
}

async function openMaps() {
  const part = await late("maps", (made) => made.maps(byId("maps"), strings));
  maps ??= part;
  if (!part) refuse("no_answer");
}

/** The auto motion; a part that does not load is retried with a later state. */
async function openGoing() {
  const on = { pause: () => stop(), tone: (shape) => tones.play(shape) };
  going = await late("care_going", (part) => part.careGoing(byId("drive"), strings, on));
}

/** The phone is put away: stop driving from here, even if the request to is still on its way. */
function leave() {
  endAll();
  away = true;
  if (state?.you) socket.send("release");
}

function openTab(name) {
  setData("tab", name);
  for (const tab of TABS) byId(`tab-${tab}`).ariaPressed = String(tab === name);
  if (name === "settings") chair.load();
  if (name === "pairing") pairing.load();
  if (name === "first" && !first) openFirst();
  if (name === "maps" && !maps) openMaps();
}

const press = (id, act) => byId(id).addEventListener("click", act);
/** A stop also ends everything held on this page, even by another finger. */
function stop(kind = "stop") {
  const sent = socket.send(kind);
  endAll();
  if (kind === "stop") stopSeen.sent(sent, performance.now());
}
for (const kind of ["stop", "emergency"]) atTouch(byId(kind), () => stop(kind));
press("take", () => {
  if (performance.now() - youMs < WORDS_MS) return; // meant for the label before
  away = false;
  if (state?.you) socket.send("release");
  else socket.sendFresh("take");
});
press("answer", () => {
  const there = comingMs !== null && performance.now() - comingMs > WORDS_MS;
  socket.send("call", { on: false, there });
  alertList.answerHelp();
});
for (const tab of TABS) press(`tab-${tab}`, () => openTab(tab));
addEventListener("keydown", (event) => {
  // A key that is held is one press of a button.
  const again = event.repeat && event.key === "Enter" && event.target.closest?.("button");
  if (again) event.preventDefault();
  if (event.key !== "Escape" && event.key !== " ") return;
  if (event.key === " " && event.target.closest?.("button, input, select")) return;
  event.preventDefault();
  stop();
});
addEventListener("blur", leave);
addEventListener("pagehide", leave);
addEventListener("gamepaddisconnected", () => gamepads.look([], false));
document.addEventListener("freeze", leave);
document.addEventListener("visibilitychange", () => document.hidden && leave());
addEventListener("contextmenu", (event) => event.preventDefault());
keepAwake();
setData("ready", true);
setInterval(() => {
  const now = performance.now();
  if (clock.jumped(now, Date.now())) leave();
  socket.tick(now);
  lookAtGamepads();
  for (const part of holds) part.tick(now);
  if (body.dataset.tab === "first") first?.tick(now);
  if (body.dataset.tab === "maps") maps?.tick(now);
  picture.tick(now);
  banner.tick(now);
  stopSeen.tick(now);
  alerts.tick(now);
  facts.ages(socket.alive ? socket.ageMs(now) : null, picture.ageMs(now), now);
}, TICK_MS);
