// Where the page stands, and how anything is asked of it: one word at the top, one line where something was refused, the newest wish only.
import { act, forget } from "/page/api.js";

// all: what is open, and its steps; view: the step that is shown; found: its candidates; turn: counts the steps that were begun to be shown.
export const now = { all: null, view: null, found: null, turn: 0 };
export const at = (id) => document.getElementById(id);
let busy = 0, missed = 0, refresh = null; // missed: the revision that came while something was done

export function shownBy(show) { refresh = show; }

export function say(text) { at("status").textContent = text; }

export function refused(why) {
  if (why.name === "AbortError") return;
  at("error").textContent = why.message;
  at("error").hidden = false;
}

// Runs what a person asked for; what goes wrong is said in one line and nothing is lost. A change of another tab meanwhile is looked at behind it.
export async function doing(text, work) {
  say(text);
  at("error").hidden = true;
  busy += 1;
  try {
    await work();
  } catch (why) {
    refused(why);
  }
  say("");
  busy -= 1;
  if (missed && !busy) {
    const revision = missed;
    missed = 0;
    changed(revision);
  }
}

// Somebody changed something: this page, which knows it by then, or another one. Without a revision: whatever is so now.
export function changed(revision) {
  if (busy) missed = Math.max(missed, revision); else if (!(now.all?.revision >= revision)) doing("", refresh);
}

// An action; refused or not, the page then shows what is so.
export const change = (text, what, given) => doing(text, async () => { try { await act(what, given); } finally { await refresh(); } });

// An action that leaves the recording, or this sight of it: no picture of it is wanted any more.
export function leaving(text, what, given) {
  now.turn += 1;
  forget();
  return change(text, what, given);
}

// An action on the step that is shown.
export const acting = (text, what, given = {}) => change(text, what, { ...given, number: now.view.number });

// Asks for what is wanted last; what is not wanted any more is neither asked nor drawn.
export function newest(work) {
  let wanted = null, running = false;
  return async (given) => {
    wanted = given;
    if (running) return;
    running = true;
    while (wanted) {
      const now = wanted;
      wanted = null;
      try { await work(now, () => wanted === null); } catch { /* a picture less */ }
    }
    running = false;
  };
}
