// The steps: the position in the tree, undo and redo, and the error of each step.
import * as charts from "/page/charts.js";
import { ghost } from "/page/parts/candidates.js";
import { acting, at, now } from "/page/now.js";
import { element, fill, number } from "/page/words.js";

const undone = {}; // step -> the child that undo left, for redo

export function timeline() {
  const here = now.all.steps[now.all.current], children = now.all.steps.filter((step) => step.parent === here.number);
  const child = children.find((step) => step.number === undone[here.number]) || children.at(-1);
  at("undo").disabled = here.parent === null;
  at("redo").disabled = !child;
  at("undo").title = here.parent === null ? "u" : `Undo: ${here.did} (u)`;
  at("redo").title = child ? `Redo: ${child.did} (r)` : "r";
  at("undo").onclick = () => { undone[here.parent] = here.number; acting("undoing", "go", { number: here.parent }); };
  at("redo").onclick = () => child && acting("redoing", "go", { number: child.number });
  fill("timeline", element("h2", {}, "Steps"), element("ol", { class: "steps" }, ...now.all.steps.map((step) => element("li", {},
    element("button", { "aria-current": step.number === now.all.current ? "step" : null, onclick: () => acting("loading the step", "go", { number: step.number }),
      onpointerenter: () => ghost(step.number === now.all.current ? {} : { step }), onpointerleave: () => ghost({}) },
      `${step.number + 1}${step.parent === null || step.parent === step.number - 1 ? "" : ` (from ${step.parent + 1})`}. ${step.did}: ${number(step.error)}`)))),
    element("div", { id: "falling", class: "chart" }),
    now.all.commands.length ? element("details", {}, element("summary", {}, "The same steps in a terminal"), element("pre", {}, now.all.commands.join("\n"))) : null,
    element("p", { class: "hint" }, `Saved in ${now.all.session}.`));
}

export function falling() {
  const way = [];
  for (let step = now.all.steps[now.all.current]; step; step = step.parent === null ? null : now.all.steps[step.parent]) way.unshift(step);
  return charts.falling("falling", way);
}
