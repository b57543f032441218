// All axes beside each other: verdict, missing effect and parameters. A click opens an axis.
import { ask } from "/page/api.js";
import { interval, titled } from "/page/parts/model.js";
import { cards, pause, titled as named, wantedStill } from "/page/parts/next.js";
import { at, leaving, now, refused } from "/page/now.js";
import { select } from "/page/tabs/tabs.js";
import { element, fill, number, unitText } from "/page/words.js";

let rows = new Map(), rowsOf = null, tried = {}; // column -> its row; of which session; what is being tried on an axis

export function build(panel) {
  panel.append(element("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "All axes" }, element("table", { id: "all-axes" })));
}

// Loads the rows, the displayed axis first. This runs after its own candidates are there, so that nothing waits for it.
export async function survey(turn) {
  for (const column of [now.all.column, ...now.all.gyros.filter((one) => one !== now.all.column)]) {
    let answer = null;
    while (wantedStill(turn) && (!answer || answer.superseded)) {
      if (answer) await pause();
      try { answer = await ask("axis", { column }); } catch (why) { if (wantedStill(turn)) refused(why); return; }
    }
    if (!wantedStill(turn)) return;
    keep().set(column, answer);
    draw();
  }
}

export function trying(event) {
  tried = event;
  draw();
}

// The rows, which are those of the open recording.
function keep() {
  if (rowsOf !== now.all.session) [rows, rowsOf] = [new Map(), now.all.session];
  return rows;
}

const missing = (row) => (row.adequate ? "Nothing" : row.unknown ? "No known effect" : cards(row.candidates).slice(0, 1).map(named).join("") || "Not determined");

function open(column) {
  select("fit");
  if (column !== now.all.column) leaving(`Analysing ${column}`, "sight", { column });
}

// A gyro and an accelerometer have other units of one effect.
const quantity = (card) => `${card.kind} ${card.parameters[0]?.unit}`;

// The effects of all rows, each once: a column of the table each.
function effects() {
  const found = new Map();
  for (const row of rows.values()) for (const card of row.cards || []) if (card.parameters.length) found.set(quantity(card), [titled(card), unitText(card.parameters[0].unit)]);
  return [...found];
}

function value(row, column) {
  const [one] = row.cards.find((card) => quantity(card) === column)?.parameters || [];
  return element("td", { class: "n" }, ...(!one ? ["–"] : typeof one.value === "string" ? [one.value] : [element("b", {}, number(one.value * one.factor)), element("br"), element("span", { class: "soft small" }, interval(one))]));
}

function line(column, kinds) {
  const row = rows.get(column), button = element("button", { class: "link", "data-axis": column, "aria-current": column === now.all.column ? "true" : null, onclick: () => open(column) }, column);
  const rest = !row ? [element("td", { colspan: 2 + kinds.length, class: "soft" }, tried.axis === column ? `Trying ${tried.trying} …` : "Waiting …")]
    : row.error ? [element("td", { colspan: 2 + kinds.length, class: "soft" }, row.error)]
    : [element("td", { class: row.adequate ? "good" : null }, row.headline.join(" ").replaceAll(" ,", ",")), element("td", {}, missing(row)), ...kinds.map(([kind]) => value(row, kind))];
  return element("tr", {}, element("th", { scope: "row" }, button), ...rest);
}

export function draw() {
  if (!now.view) return;
  keep();
  const kinds = effects(), focused = at("all-axes").contains(document.activeElement) ? document.activeElement.dataset.axis : null;
  fill("all-axes", element("thead", {}, element("tr", {}, ...["Axis", "Verdict", "Missing"].map((title) => element("th", {}, title)), ...kinds.map(([, [name, unit]]) => element("th", { class: "n" }, `${name}, `, element("span", { class: "soft" }, unit))))),
    element("tbody", {}, ...now.all.gyros.map((column) => line(column, kinds))));
  if (focused) document.querySelector(`[data-axis="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
}
