// The model: one card per effect, one slider per value.
import { element, fill, number, range } from "/page/words.js";

const STEPS = 1000; // of a slider
const DECADES = 2; // range of a slider on each side of the fitted value

function slider(card, parameter, moved, released) {
  const signed = parameter.low_limit < 0;
  const centre = Math.abs(parameter.value) || 1e-6;
  const to = (x) => signed && parameter.value === 0 ? x : Math.sign(parameter.value || 1) * centre * 10 ** (DECADES * (x / STEPS));
  const limited = (value) => Math.min(Math.max(value, parameter.low_limit ?? -Infinity), parameter.high_limit ?? Infinity);
  const box = element("input", { type: "number", step: "any", value: Number(parameter.value.toPrecision(5)), "aria-label": `${parameter.name}, ${parameter.unit}` });
  const input = element("input", { type: "range", min: -STEPS, max: STEPS, value: 0, "aria-label": `${card.name}: ${parameter.name}` });
  input.addEventListener("input", () => { const value = limited(to(Number(input.value))); box.value = Number(value.toPrecision(5)); moved(value); });
  input.addEventListener("change", () => released(Number(box.value)));
  box.addEventListener("change", () => box.value.trim() && Number.isFinite(Number(box.value)) && released(Number(box.value)));
  const bar = element("div", { class: "interval" });
  if (parameter.low > 0 && parameter.high > 0 && parameter.value > 0) {
    const at = (value) => 50 + 50 * Math.max(-1, Math.min(1, Math.log10(value / centre) / DECADES));
    const mark = element("i");
    mark.style.left = `${at(parameter.low)}%`;
    mark.style.width = `${Math.max(0.5, at(parameter.high) - at(parameter.low))}%`;
    bar.append(mark);
  }
  return [element("label", {}, `${parameter.name.replaceAll("_", " ")}`), box, input, bar];
}

function value(card, parameter, actions) {
  const row = element("div", { class: "value" });
  if (typeof parameter.value === "string") {
    row.append(element("span", {}, parameter.name.replaceAll("_", " ")), element("b", {}, parameter.value));
    return row;
  }
  row.append(...slider(card, parameter, (v) => actions.moved(card, parameter, v), (v) => actions.released(card, parameter, v)));
  row.append(element("span", { class: "interval-text" }, `${range(parameter)} ${parameter.unit}`));
  return row;
}

// Effects whose values stay fixed when the others are fitted. Kind and order identify them across steps.
const locked = new Set();
const name = (view, one) => `${one.kind} ${view.cards.filter((other) => other.kind === one.kind && other.place < one.place).length}`;
export const held = (view) => view.cards.filter((one) => locked.has(name(view, one))).map((one) => one.place);

function lock(view, one) {
  const box = element("input", { type: "checkbox", checked: locked.has(name(view, one)), "aria-label": `hold ${one.name}` });
  box.onchange = () => (box.checked ? locked.add(name(view, one)) : locked.delete(name(view, one)));
  return element("label", { class: "hold", title: "Keep these values while the others are fitted" }, box, "hold");
}

function card(view, one, actions) {
  const toggle = element("input", { type: "checkbox", checked: true, "aria-label": `${one.name} is part of the model`, onchange: () => actions.off(one) });
  return element("article", { class: "card", "data-kind": one.kind },
    element("header", {}, toggle, element("h3", {}, one.name), lock(view, one)),
    element("p", {}, one.physics),
    one.loss === null ? null : element("p", {}, `Without it, the log-likelihood falls by ${number(one.loss)}, and the error is ${number(one.error_without)}.`),
    ...one.parameters.map((parameter) => value(one, parameter, actions)));
}

function switchedOff(one, place, actions) {
  return element("article", { class: "card off" }, element("header", {},
    element("input", { type: "checkbox", "aria-label": `${one.kind} is part of the model`, onchange: () => actions.on(one, place) }),
    element("h3", {}, one.kind.replaceAll("_", " "))));
}

export function draw(view, actions) {
  fill("stack", element("h2", {}, "Model"), ...view.cards.map((one) => card(view, one, actions)), ...view.off.map((one, place) => switchedOff(one, place, actions)));
}

// The card and size parameter of an effect's curve. Order distinguishes two effects of the same kind.
export function sized(view, effect) {
  const place = view.deviation.effects.filter((one) => one.kind === effect.kind).indexOf(effect);
  const found = view.cards.filter((one) => one.kind === effect.kind)[place], parameter = found?.parameters.find((one) => one.size);
  return parameter && parameter.value ? { card: found, parameter } : null;
}

// The model's curve with one size changed. Allan variances of stationary noise add, so the other effects stay unchanged.
export function withSize(view, card, parameter, size) {
  const d = view.deviation, own = d.effects.filter((one) => one.kind === card.kind)[view.cards.filter((c) => c.kind === card.kind && c.place < card.place).length];
  if (!own || !parameter.size) return null;
  const factor = (size / parameter.value) ** 2 - 1;
  return d.model.map((model, i) => Math.sqrt(Math.max(model ** 2 + factor * own.deviation[i] ** 2, 1e-30)));
}
