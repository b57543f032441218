// The model: one row per effect, its value with a slider whose scale is its interval, and the values of its shape.
import { ask } from "/page/api.js";
import * as curve from "/page/curve.js";
import { acting, newest, now } from "/page/now.js";
import { open as edit } from "/page/parts/own.js";
import { capital, element, fill, number, unitText } from "/page/words.js";

const SHORT = {
    angle_random_walk: "ARW",
    bias_instability: "Bias instability",
    rate_random_walk: "Rate random walk",
};
export const titled = (card) =>
    (card.parameters[0]?.unit === "m/s/sqrt(h)" ? "VRW" : SHORT[card.kind]) || capital(card.title);
let moved = null; // draws a moving state

export function whenMoved(work) {
    moved = work;
}

// The middle 40 % of a slider is the 95 % interval, its ends are a third and 3 times the estimate; without an interval, a logarithm of it all.
// To the right is more, also of a negative value.
function valueAt(place, { value, low, high }) {
    if (value < 0) return -valueAt(1 - place, { value: -value, low: -high, high: -low });
    const ends = [value / 3, value * 3];
    if (!(low > 0 && high > 0 && value > 0 && low > ends[0] && high < ends[1]))
        return Math.sign(value || 1) * Math.abs(value || 1e-6) * 9 ** (2 * (place - 0.5));
    if (place < 0.3) return low * (ends[0] / low) ** ((0.3 - place) / 0.3);
    if (place > 0.7) return high * (ends[1] / high) ** ((place - 0.7) / 0.3);
    return place < 0.5
        ? low + ((value - low) * (place - 0.3)) / 0.2
        : value + ((high - value) * (place - 0.5)) / 0.2;
}

const limited = (value, { low_limit, high_limit }) =>
    Math.min(Math.max(value, low_limit ?? -Infinity), high_limit ?? Infinity);

// The curve of a changed shape cannot be computed here by adding variances: the server sends it.
const follow = newest(async (given, still) => {
    const { turn } = now,
        answer = await ask("preview", given);
    if (still() && turn === now.turn && document.activeElement?.type === "range")
        moved(curve.withModel(now.view, answer));
});

export const actions = {
    moved: (card, parameter, value) => {
        const state = curve.withSize(now.view, card, parameter, value);
        if (state) moved(state);
        else
            follow({
                place: card.place,
                kind: card.kind,
                name: parameter.name,
                value,
                state: now.view.state,
            });
    },
    released: (card, parameter, value) =>
        acting(`Testing ${capital(card.title)} = ${number(value * parameter.factor)}`, "set", {
            place: card.place,
            kind: card.kind,
            parameters: { [parameter.name]: value },
        }),
};

// Effects whose values stay fixed when the others are fitted. Kind and order identify them across steps.
const locked = new Set();
const key = (one) =>
    `${one.kind} ${now.view.cards.filter((other) => other.kind === one.kind && other.place < one.place).length}`;
export const held = () =>
    now.view.cards.filter((one) => locked.has(key(one))).map((one) => one.place);

// Without its interval, where the model fails.
const valid = (one, adequate) => (adequate ? one : { ...one, low: null, high: null });

// Numbers of a parameter with the digits of its interval: three, or as many more as tell its ends apart. Unlike toPrecision, all with one count of decimals.
function digits({ value, low, high, factor }) {
    const apart = low === null || low === undefined ? Infinity : Math.abs((high - low) * factor),
        size = Math.max(...[value, low, high].map((one) => Math.abs(one * factor))) || 1,
        least = Math.min(size / 100, apart > 0 ? apart / 2 : Infinity),
        power = size < 1e-3 || size >= 1e6 ? Math.floor(Math.log10(size)) : 0,
        decimals = Math.min(9, Math.max(0, Math.ceil(power - Math.log10(least) - 1e-9)));
    return {
        text: (shown) =>
            (shown / 10 ** power).toFixed(decimals).replace(/^-(0\.?0*)$/, "$1") +
            (power ? `e${power}` : ""),
        step: Number(`1e${power - decimals}`),
    };
}

export const valueShown = (one, adequate) =>
    digits(valid(one, adequate)).text(one.value * one.factor);

// An interval assumes that the model fits: otherwise there is none.
export const intervalShown = (one, adequate, style) =>
    adequate ? element("span", { class: style }, interval(one)) : null;
const interval = (one) => {
    if (one.undetermined) return "not determined";
    if (one.low === null || one.low === undefined) return "as set";
    const { text } = digits(one),
        [low, high] = [one.low, one.high].map((end) => text(end * one.factor));
    return low === high ? "narrower than shown" : `[${low}, ${high}]`;
};

function row(card, parameter, label) {
    if (typeof parameter.value === "string")
        return element(
            "div",
            { class: "par" },
            element("span", { class: "soft" }, label),
            element("b", { class: "word" }, parameter.value),
        );
    const unit = unitText(parameter.unit),
        known = valid(parameter, now.view.adequate),
        { text, step } = digits(known),
        first = text(parameter.value * parameter.factor),
        box = element("input", {
            type: "number",
            step, // of the arrows: the last digit
            value: first,
            style: `width:${Math.max(8, first.length + 2)}ch`,
            "aria-label": `${label}, ${unit || parameter.name}`,
            onchange: () =>
                box.value.trim() &&
                Number.isFinite(Number(box.value)) &&
                actions.released(card, parameter, Number(box.value) / parameter.factor),
        });
    const slider = element("input", {
        type: "range",
        min: 0,
        max: 1,
        step: "any",
        value: 0.5,
        "aria-label": `${card.name}: ${parameter.name}`,
    });
    const at = () => limited(valueAt(Number(slider.value), parameter), parameter);
    slider.addEventListener("keydown", (event) => {
        // a step of "any" does not move with keys
        const by = {
            ArrowRight: 0.02,
            ArrowUp: 0.02,
            ArrowLeft: -0.02,
            ArrowDown: -0.02,
            PageUp: 0.1,
            PageDown: -0.1,
        }[event.key];
        if (!by) return;
        event.preventDefault();
        slider.value = Number(slider.value) + by;
        slider.dispatchEvent(new Event("input"));
        clearTimeout(slider.settled);
        slider.settled = setTimeout(() => slider.dispatchEvent(new Event("change")), 400);
    });
    slider.addEventListener("input", () => {
        box.value = text(at() * parameter.factor);
        actions.moved(card, parameter, at());
    });
    slider.addEventListener("change", () => actions.released(card, parameter, at()));
    return element(
        "div",
        { class: `par${known.low === null || known.low * known.high <= 0 ? " plain" : ""}` },
        element("span", {}, label),
        slider,
        element(
            "span",
            { class: "v" },
            box,
            ` ${unit}`,
            intervalShown(parameter, now.view.adequate, "soft interval"),
        ),
    );
}

const words = (name) => name.replace(/_(dps|s|hz|Hz|per_.*|degC)$/, "").replaceAll("_", " ");

const remover = (card) =>
    element(
        "button",
        {
            class: "link",
            "aria-label": `Remove ${card.name}`,
            onclick: () =>
                acting(`Fitting without ${card.name}`, "remove", {
                    place: card.place,
                    kind: card.kind,
                }),
        },
        "Remove",
    );

// More values, and what can be done with the effect.
function more(card) {
    const shape = card.parameters
        .filter((one, i) => i)
        .map((one) => row(card, one, words(one.name)));
    const hold = element("input", {
        type: "checkbox",
        checked: locked.has(key(card)),
        "aria-label": `hold ${card.name}`,
        onchange: () => (hold.checked ? locked.add(key(card)) : locked.delete(key(card))),
    });
    return element(
        "div",
        { class: "detail" },
        element("p", { class: "soft" }, card.physics, element("span", { class: "without" })),
        ...shape,
        element(
            "div",
            { class: "row" },
            element(
                "label",
                { title: "Keep these values while the others are fitted" },
                hold,
                " hold",
            ),
            element("span", { class: "grow" }),
            now.all.code &&
                now.all.own.includes(card.kind) &&
                element(
                    "button",
                    {
                        class: "link",
                        "aria-label": `Edit ${card.name}`,
                        onclick: () => edit(null, card),
                    },
                    "Edit",
                ),
            card.superfluous ? null : remover(card),
        ),
    );
}

// What the model loses without an effect, once its values are unfolded.
async function without(detail, { place, kind }) {
    const { state } = now.view,
        { loss, error } = await ask("without", { place, kind, state });
    if (loss !== undefined)
        detail.querySelector(".without").textContent =
            ` Without it, the log-likelihood falls by ${number(loss)}, and the error is ${number(error)}.`;
}

const unfolded = new Set();

// Folds what was unfolded for another recording.
export const fold = () => unfolded.clear();

function effect(card) {
    const open = unfolded.has(key(card)),
        [first] = card.parameters;
    const detail = more(card),
        button = element(
            "button",
            {
                class: "bare fold",
                "aria-expanded": String(open),
                "aria-label": `${titled(card)}: more`,
            },
            open ? "▾" : "▸",
        );
    const told = () => without(detail, card).catch(() => {}); // of a step that is not shown any more
    detail.hidden = !open;
    if (open) told();
    button.onclick = () => {
        detail.hidden = !detail.hidden;
        button.textContent = detail.hidden ? "▸" : "▾";
        button.setAttribute("aria-expanded", String(!detail.hidden));
        if (detail.hidden) unfolded.delete(key(card));
        else {
            unfolded.add(key(card));
            told();
        }
    };
    return element(
        "article",
        { class: `effect${card.superfluous ? " nothing" : ""}`, "data-kind": card.kind },
        button,
        first ? row(card, first, titled(card)) : element("span", {}, titled(card)),
        card.superfluous &&
            element(
                "div",
                { class: "row small absent" },
                element("span", { class: "soft grow" }, "May be absent"),
                remover(card),
            ),
        detail,
    );
}

const switchedOff = (one, place) =>
    element(
        "article",
        { class: "effect off" },
        element("span", { class: "grow soft" }, capital(one.kind.replaceAll("_", " "))),
        element(
            "button",
            {
                class: "link",
                "aria-label": `Restore ${one.kind.replaceAll("_", " ")}`,
                onclick: () =>
                    acting(`Fitting with ${one.kind.replaceAll("_", " ")} again`, "restore", {
                        place,
                        kind: one.kind,
                    }),
            },
            "Restore",
        ),
    );

export function draw() {
    const steps = now.all.steps,
        of = (number) => steps[number];
    let fit = of(now.all.current);
    while (!fit.fitted && fit.parent !== null) fit = of(fit.parent);
    const back =
        !now.view.fitted &&
        fit.fitted &&
        element(
            "button",
            {
                class: "link",
                id: "back",
                onclick: () => acting("Going back to the fit", "go", { number: fit.number }),
            },
            "Back to the fit",
        );
    fill(
        "model",
        element(
            "div",
            { class: "row" },
            element("h2", {}, "Model"),
            element(
                "span",
                { class: "grow soft small" },
                now.view.adequate || now.view.error === null
                    ? null
                    : "no intervals: the model does not fit",
            ),
            back,
            element(
                "button",
                {
                    class: `link${now.view.fitted ? " quiet" : ""}`,
                    id: "refit",
                    title: "Fit all values (f)",
                    onclick: () => acting("Fitting all values", "refit", { held: held() }),
                },
                "Fit all",
            ),
        ),
        element(
            "div",
            { class: "effects", tabindex: -1 },
            ...now.view.cards.map(effect),
            ...now.view.off.map(switchedOff),
        ),
    );
}
