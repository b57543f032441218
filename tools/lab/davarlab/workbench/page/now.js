// Where the page stands, and how anything is asked of it: one word at the top, one line where something was refused, the newest wish only.
import { act, forget } from "/page/api.js";

// all: what is open, and its steps; stale: does the page still show what is not so any more; view: the step that is shown; found: its candidates; turn: counts the steps that were begun to be shown.
export const now = { all: null, view: null, found: null, turn: 0, stale: false };
export const at = (id) => document.getElementById(id);
let busy = 0, missed = 0, refresh = null; // missed: the revision that came while something was done

export function shownBy(show) { refresh = show; }

const OF_A_STEP = ["undo", "redo", "refit", "save", "save-h", "report"]; // buttons above the bench

// A part of the page that shows what is not so any more can be read, dimmed, and does nothing.
export function dead(id, yes) {
  at(id).inert = yes;
  at(id).classList.toggle("stale", yes);
}

// The whole bench, or the first page, until what is so now has been computed; whoever draws it brings it back to life, and its buttons.
export function stale(yes) {
  now.stale = yes;
  dead("bench", yes);
  dead("landing", yes);
  at("bench").setAttribute("aria-busy", yes);
  if (yes) for (const id of OF_A_STEP) at(id).disabled = true;
}

export function say(text) { at("status").textContent = text; }

export function refused(why) {
  if (["AbortError", "Gone"].includes(why.name)) return; // not wanted any more; the server has stopped, which is shown by itself
  at("error").textContent = why.message;
  at("error").hidden = false;
}

// Runs what a person asked for; what goes wrong is said in one line. A change of another tab meanwhile is looked at behind it.
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
export function change(text, what, given) {
  stale(true);
  return doing(text, async () => { try { await act(what, given); } finally { await refresh(); } });
}

// An action that leaves the recording, or this sight of it: no picture of it is wanted any more.
export function leaving(text, what, given) {
  now.turn += 1;
  forget();
  return change(text, what, given);
}

// An action on what is shown; the server refuses it where that is not so any more.
export const acting = (text, what, given = {}) => (now.stale ? null : change(text, what, { ...given, state: now.view.state }));

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
