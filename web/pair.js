// The pairing page: sends a code, typed or from the address's fragment, to the host.

import { chosenLanguage, loadStrings } from "./strings.js";

const SECOND_MS = 1000;
/** An answer later than this counts as none. */
const ANSWER_MS = 8000;

const language = chosenLanguage(location.search, navigator.language);
const strings = await loadStrings(language, "care");
const byId = (id) => document.getElementById(id);

strings.fill("pair_title");

const say = (kind, text, advice = "") => {
  const answer = byId("answer");
  answer.dataset.kind = kind;
  answer.querySelector(".text").textContent = text;
  answer.querySelector(".do").textContent = advice;
};
const sayMessage = (key) => {
  const { text, do: advice } = strings.message(key);
  say("error", text, advice);
};

/** Shows the remaining wait after too many wrong codes; then sends the code by itself. */
function waitOut(seconds) {
  byId("go").disabled = true;
  const until = performance.now() + seconds * SECOND_MS;
  const count = () => {
    const left = Math.ceil((until - performance.now()) / SECOND_MS);
    if (left > 0) return say("error", strings.message("too_many_guesses").text, `${left} s`);
    clearInterval(timer);
    byId("go").disabled = false; // there may be no code any more
    pair();
  };
  const timer = setInterval(count, SECOND_MS);
  count();
}

async function pair() {
  const code = byId("code").value.trim();
  const name = byId("name").value.trim();
  if (code === "") {
    sayMessage("code_missing");
    return byId("code").focus();
  }
  byId("go").disabled = true;
  say("busy", strings.label("pair_busy"));
  let answer;
  try {
    answer = await fetch("/pair", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(name === "" ? { code } : { code, name }),
      signal: AbortSignal.timeout(ANSWER_MS),
    });
  } catch (error) {
    console.warn(`POST /pair: ${error.message}`);
    byId("go").disabled = false;
    return sayMessage("no_answer");
  }
  if (answer.ok) {
    say("done", strings.label("pair_done"));
    return location.replace(`/${location.search}`);
  }
  byId("go").disabled = false;
  const refusal = await answer.json().catch(() => ({ reason: "no_answer" }));
  if (refusal.wait_s) return waitOut(refusal.wait_s);
  sayMessage(refusal.reason);
  byId("code").select();
}

// A key that is held would send the code once more after each refusal: there are few guesses.
addEventListener("keydown", (event) => {
  if (event.repeat && event.key === "Enter") event.preventDefault();
});
byId("form").addEventListener("submit", (event) => {
  event.preventDefault();
  pair();
});

/** Uses a code in the address; opening such an address here again does not reload the page. */
function useGiven() {
  const given = decodeURIComponent(location.hash.slice(1));
  if (given === "") return;
  history.replaceState(null, "", location.pathname + location.search); // used once: not for history
  byId("code").value = given;
  pair();
}

document.body.dataset.ready = true;
byId("code").focus();
addEventListener("hashchange", useGiven);
useGiven();
