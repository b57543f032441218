// The list of effects that may be missing, with a preview of their curves.
import { ask } from "/page/api.js";
import * as charts from "/page/charts.js";
import { acting, newest, now, refused, say } from "/page/now.js";
import { element, fill, number } from "/page/words.js";

const SHOWN = 9; // as many as there are keys
const list = (...rows) => fill("candidates", element("h2", {}, "What may be missing"), ...rows);
const hint = (text) => element("p", { class: "hint" }, text);

// Loads the candidates for the fitted model. This runs after a step is drawn, so that its curve appears first.
export async function rank(turn) {
  now.found = null;
  if (!now.view.fitted) {
    list(hint("These values are not fitted. Candidates are tested with fitted values: fit first."),
      element("button", { class: "main", id: "fit-first", onclick: () => acting("fitting all values", "refit") }, "Fit all values"));
    return;
  }
  list(hint("Trying every effect …"));
  try {
    const answer = await ask("candidates", { number: now.view.number });
    if (turn !== now.turn || answer.state !== now.view.state) return;
    if (answer.superseded) { setTimeout(() => turn === now.turn && rank(turn), 500); return; }
    now.found = answer.candidates;
    list(answer.nothing.length ? element("div", { id: "nothing" }, ...answer.nothing.map((said) => element("p", {}, said))) : null,
      ...now.found.slice(0, SHOWN).map(candidate));
    say("");
  } catch (why) {
    refused(why);
  }
}

// Shows the candidates found so far while the others are tested. They cannot be added yet.
export function partly(event) {
  if (now.found || !now.view || now.stale || event.ranking !== now.view.state) return;
  list(hint(`Trying ${event.trying} …`),
    ...event.candidates.slice(0, SHOWN).map((one) => element("div", { class: "candidate early" }, one.name, element("small", {}, one.why))));
}

function candidate(one) {
  const note = element("small", {}, one.why);
  const confirm = one.note ? element("small", one.alike ? { class: "alike" } : {}, one.note) : null;
  const button = element("button", { class: `candidate${one.beyond_chance ? " strong" : ""}`, "data-kind": one.kind, title: one.confirm,
    onclick: () => add(one.place) }, `${one.place + 1}. Add ${one.name}`, note, confirm);
  let wanted = null;
  const enter = () => { clearTimeout(wanted); wanted = setTimeout(() => ghost({ one, note }), 300); };
  const leave = () => { clearTimeout(wanted); ghost({}); };
  for (const name of ["pointerenter", "focus"]) button.addEventListener(name, enter);
  for (const name of ["pointerleave", "blur"]) button.addEventListener(name, leave);
  return button;
}

// Adds the candidate at a place to the model, if there is one.
export function add(place) {
  const one = now.found?.[place];
  return one && !now.stale ? acting(`adding ${one.name}`, "add", { place: one.place, kind: one.kind }) : null;
}

// Draws the curve with a candidate, or that of another step, next to the model's. Without either, only the model's.
export const ghost = newest(async ({ one, note, step }, still) => {
  const turn = now.turn;
  const answer = one ? await ask("ghost", { place: one.place, kind: one.kind, state: now.view.state }) : step ? await ask("step", { number: step.number }) : null;
  if (turn !== now.turn || !now.view) return;
  if (note) note.textContent = `${one.why} With it, the error would be ${number(answer.error)} (floor ${number(answer.floor)}).`;
  if (still()) await charts.deviation(now.view, answer && { name: one ? one.name : `step ${step.number + 1}`, deviation: answer.deviation });
});
