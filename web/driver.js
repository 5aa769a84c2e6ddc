// The driver's page: connects its parts; one timer drives them all.

import { AutoOff } from "./auto_off.js";
import { ClockWatch } from "./clock_watch.js";
import { byId, setData, setText } from "./dom.js";
import { Facts } from "./facts.js";
import { pressHelp, showHelp, WORDS_MS } from "./help.js";
import { Hint } from "./hint.js";
import { HitMap } from "./hit.js";
import { listen } from "./input.js";
import { ObstacleLine } from "./line.js";
import { Messages } from "./messages.js";
import { Picture } from "./picture.js";
import { Practice } from "./practice.js";
import { loadProfiles } from "./profile.js";
import { addRings, showChosen } from "./ring.js";
import { sentence } from "./sentence.js";
import { ControlSocket } from "./socket.js";
import { StopSeen } from "./stop_seen.js";
import { chosenLanguage, loadStrings, message } from "./strings.js";
import { Targets } from "./targets.js";
import { Tones } from "./tones.js";
import { keepAwake } from "./wakelock.js";
import { Eyes, LateMenu, Plugins, Scanning, showLate } from "./wanted.js";

const TICK_MS = 25;
/** After this many clicks without movement: gaze control that only clicks, so a click is a step. */
const CLICKS_MEAN_STEPS = 2;
/** The mode that follows each one; "more": the page of modes, if there is one. */
const AFTER = { continuous: "step", step: "more", more: "continuous" };

const profiles = await loadProfiles();
const strings = await loadStrings(chosenLanguage(location.search, profiles.current.language));
const { dataset } = document.body;
const nowMs = () => performance.now();

strings.fill("title");
message(byId("lost-words"), strings.label("lost_title"), strings.message("link_lost"));
const menu = new LateMenu(strings, profiles, {
  changed: (fields) => change({ save: { id: profiles.current.id, ...fields } }),
  choose: (id) => change({ choose: id }),
  practice: () => [practice.toggle(), open("drive")],
  eyes: () => eyes.begin(),
  closed: () => open("drive"),
  shown: () => measure(),
});
addRings();

const hits = new HitMap();
const measure = () =>
  hits.measure(document.querySelectorAll(".target"), profiles.current.growth_percent / 100);
const tones = new Tones((audible) => setData("audible", audible));
const messages = new Messages(strings, tones);
const notice = (...words) => messages.notice(...words);
const lacking = () => notice("refused", "part_missing");
const facts = new Facts(strings);
const hint = new Hint(strings, (reason) => notice("arm_refused", reason));
const line = new ObstacleLine(strings);
const practice = new Practice(strings);
const picture = new Picture(byId("picture"), (age) => setData("picture", age));
const autoOff = new AutoOff();
const used = () => autoOff.used(nowMs());
const clock = new ClockWatch();
const stopSeen = new StopSeen(strings);
const eyes = new Eyes(strings, {
  open,
  lacking,
  judged(result) {
    open("menu");
    menu.show("eyes", result); // it proposes the result, and applies it if the driver chooses so
  },
});

let state = null; // the host's newest state
let active = null; // the verb of the active press
let clicksAlone = 0;
let driving = false; // for the start tone
let armWordsMs = -WORDS_MS; // since when the label is "Rijden aan" or "Rijden uit"

const acts = {
  arm(since) {
    // Meant for the label before.
    if (since < armWordsMs || nowMs() - armWordsMs < WORDS_MS) return;
    if (practice.on) return [practice.arm(), showState(state, nowMs())];
    if (state?.state !== "disarmed") return socket.send("disarm");
    if (socket.sendFresh("arm")) hint.sent(nowMs());
  },
  mode() {
    const next = AFTER[dataset.mode];
    setMode(next === "more" && !plugins.more ? "continuous" : next);
  },
  async menu() {
    if (!(await menu.show("main"))) lacking();
    else if (dataset.state === "disarmed") open("menu");
  },
  help: pressHelp((on) => socket.send("call", { on }) || notice("refused", "no_answer")),
  back: () => dataset.view === "menu" && menu.back(),
};
for (let at = 1; at <= 5; at += 1) acts[`tile-${at}`] = () => menu.act(at);

const targets = new Targets({
  drive(verb, mode, edge) {
    active = verb;
    used();
    const held = plugins.part?.mode(verb);
    if (practice.on) practice.drive(held ?? verb, edge);
    else if (held) plugins.part.use(held, edge);
    else socket.sendFresh("cmd", { verb, mode, edge });
    if (driving || plugins.part?.picks(verb)) return;
    driving = true;
    if (practice.armed || state?.you) tones.play("start");
  },
  stop(chosen) {
    if (chosen) stopSeen.sent(socket.send("stop"), nowMs());
    // Another driver is stopped by looking at Stop, not by looking away from this page.
    else if (!plugins.part?.auto(active) && (state?.you ?? true)) socket.send("stop");
    ended();
  },
  act: (name, since) => [plugins.part?.act(name), acts[name]?.(since)],
  unable: () => notice("refused", "mode_unable"),
  tap(target) {
    if (plugins.part?.auto(target)) return; // needs no holding
    if (clicksAlone < CLICKS_MEAN_STEPS) return notice("tap_title", "tap");
    setMode("step");
    notice("clicks_title", "clicks");
  },
  view(dwelling, holding, dwellMs) {
    if (holding === null) ended();
    showChosen(dwelling, holding, dwellMs);
  },
});

const scan = new Scanning(targets, hits, {
  moving: () => targets.holding || (state?.motion ?? "stopped") !== "stopped",
  used,
  needs: (ms) => autoOff.scans(ms),
});

const plugins = new Plugins(strings, {
  shown: measure,
  replaced: () => targets.replaced(nowMs(), false),
  unable: (names) => (targets.unable = names),
  ride: (kind, more) =>
    kind === "stop" ? socket.send(kind) : [used(), socket.sendFresh(kind, more)],
  tone: (shape) => tones.play(shape),
  open,
  dwellMs: () => profiles.current.button_dwell_ms,
  gone: () => dataset.mode === "more" && setMode(profiles.current.mode),
});

const socket = new ControlSocket({
  message: (news) => receivers[news.k]?.(news, nowMs()),
  link(alive) {
    setData("link", alive ? "ok" : "lost");
    if (!alive) targets.cancel(nowMs());
    report(nowMs());
  },
  closed: () => stopSeen.closed(),
});

const receivers = {
  welcome(welcome) {
    targets.setTimes(welcome.heartbeat_ms, welcome.command_ttl_ms);
    for (const name of ["backward", "insecure"]) setData(name, welcome[name]);
    plugins.update(welcome);
    measure();
  },
  state(news, now) {
    state = news;
    if ((news.profile ?? profiles.revision) !== profiles.revision) reload();
    showState(news, now);
    showLate(news, strings);
    stopSeen.update(news.stops, now);
  },
  refused({ what, reason, detail }) {
    if (what === "arm") hint.answered();
    notice(what === "arm" ? "arm_refused" : "refused", reason);
    console.warn(`${what} refused: ${detail}`);
  },
};

function showState(news, now) {
  if (news === null) return;
  const armed = practice.on ? practice.armed : news.state === "armed" && news.you;
  const shown = practice.on ? (armed ? "armed" : "disarmed") : news.state;
  targets.setArmed(armed, now);
  if (!armed || targets.holding || news.auto?.[0]) used();
  if (practice.on && news.you) socket.send("disarm"); // armed while practice began
  if (dataset.state !== shown) {
    if (shown === "armed") tones.play("armed");
    if (armed && /menu|eyes/.test(dataset.view)) open("drive");
    if ([shown, dataset.state].includes("disarmed")) armWordsMs = now;
    setData("state", shown);
    measure();
  }
  setData("simulated", news.simulated);
  setData("relay", news.relay_checked ?? true);
  showHelp(news, strings);
  setText("arm-label", strings.label(shown === "disarmed" ? "arm" : "disarm"));
  const left = armed && autoOff.countdown(now);
  setText("arm-state", left ? `${strings.label("off_in")} ${left} s` : strings.label(shown));
  facts.update(news, active);
  line.update(news);
  report(now);
  hint.update(messages.now.words, shown, practice.on ? "none" : news.arm_reason, now);
}

function report(now) {
  if (state === null && socket.alive) return;
  const news = state && { ...state, state: dataset.state };
  const shown = plugins.sentence(sentence(news, socket.alive, practice.on), state);
  if (messages.show(shown, now)) measure();
}

/** A held command has ended. */
function ended() {
  active = null;
  if (driving) tones.play("stop");
  driving = false;
}

function setMode(mode) {
  const now = nowMs();
  targets.setMode(mode, now);
  if (mode !== dataset.mode) targets.replaced(now, false);
  setData("mode", mode);
  setText("menu-state", strings.label(mode));
  measure();
}

/** Shows "drive", "menu" or "eyes"; ends every hold. */
function open(view) {
  targets.replaced(nowMs());
  eyes.stop();
  setData("view", view);
  measure();
}

/** Switches driving off: the page seems to be left alone, or is not used. */
function switchOff() {
  scan.cancel(nowMs());
  practice.armed = false;
  used(); // reported once
  if (state?.you || hint.asks) socket.send("disarm");
}

/** This page owns the chair, or practises: only this page changes how it drives. */
const drives = () => Boolean(state?.you) || practice.armed || targets.holding;

async function change(edit) {
  const reason = await profiles.change(edit, drives);
  if (reason) notice("refused", reason);
  applyProfile();
}

/** Takes over others' changes while this page does not drive. */
async function reload() {
  if (drives() || !(await profiles.reload(() => !drives()))) return;
  if (dataset.view === "menu") open("menu"); // a tile may now mean something else
  applyProfile();
}

/** Takes over the chosen profile; another language reloads the page. */
function applyProfile() {
  const mine = profiles.current;
  const fixed = new URLSearchParams(location.search).has("lang");
  if (mine.language !== strings.language && !fixed) return location.reload();
  targets.configure(mine);
  autoOff.configure(mine);
  hint.scans = mine.scan !== "off";
  tones.on = mine.tones;
  for (const name of ["tones", "contrast", "mirrored"]) setData(name, mine[name]);
  setMode(mine.mode);
  if (dataset.view === "menu") menu.show();
  scan.configure(mine);
}

applyProfile();
setData("ready", true);
report(nowMs());
addEventListener("resize", measure);
listen(targets, hits, {
  shown: (name) => hits.has(name),
  away: switchOff,
  pressed: (alone) => (clicksAlone = alone ? clicksAlone + 1 : 0),
});
keepAwake();
setInterval(() => {
  const now = nowMs();
  if (clock.jumped(now, Date.now())) {
    targets.cancel(now);
    switchOff();
  }
  targets.tick(now);
  if (targets.holding) used();
  else if (autoOff.leftMs(now) <= 0) switchOff();
  for (const part of [socket, picture, messages, stopSeen, eyes, scan]) part.tick(now);
  facts.ages(socket.alive ? socket.ageMs(now) : null, picture.ageMs(now), now);
}, TICK_MS);
