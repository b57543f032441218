// The headline: does the model fit, how far is it off, and the error over its floor. Every sentence is the server's.
import { gauge, reach } from "/page/chart/gauge.js";
import { at, now } from "/page/now.js";
import { element, errorText, fill, timesText } from "/page/words.js";

// Does the model fit, and does no candidate speak against it. Not before the candidates are known.
export const settled = () => now.view.adequate && Boolean(now.answer) && !now.answer.against.length;
const MEANS =
    "The error is the rms of log10(measured / model) over every window and averaging time. The error of a true model scatters around the floor: below it, nothing is left to explain. The floor changes a little from step to step, because the scatter of an Allan deviation depends on the noise in the model.";

export function headline() {
    const [before, strong, after] = now.answer?.headline || now.view.headline;
    const open = at("why")?.open,
        held = now.answer ? at("held-out-error")?.textContent : ""; // of the same step
    at("head").className = `head ${settled() ? "settled" : ""}`;
    const p = now.view.p_value;
    fill(
        "headline",
        element(
            "h1",
            {},
            `${before} `,
            element("em", { id: "headline-strong" }, strong),
            after && `${after.startsWith(",") ? "" : " "}${after}`,
        ),
        element(
            "div",
            { class: "under" },
            element(
                "details",
                { id: "why", class: "why", open },
                element("summary", {}, "Why?"),
                element(
                    "div",
                    { class: "panel", tabindex: 0, role: "group", "aria-label": "Why" },
                    element(
                        "p",
                        { id: "said" },
                        [now.view.said, now.answer?.said].filter(Boolean).join(" "),
                    ),
                    p === null || now.view.said.includes("(p ")
                        ? null
                        : element("p", {}, p < 1e-6 ? "p < 1e-6" : `p = ${p.toFixed(2)}`),
                    ...[...now.view.observations.map((one) => one.said), ...now.view.notes].map(
                        (note) => element("p", {}, note),
                    ),
                    element("p", {}, MEANS),
                ),
            ),
            element("span", { id: "held-out-error", class: "soft" }, held),
        ),
        ...now.view.observations.map((one) =>
            element("p", { class: "observation", title: one.said }, one.said),
        ),
    );
    error();
}

document.addEventListener("click", (event) => {
    if (at("why")?.open && !event.target.closest("#why")) at("why").open = false;
});
document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && at("why")?.open) {
        at("why").open = false;
        at("why").firstChild.focus();
    }
});

// The bar alone: while a value moves, while a step is animated.
export function error() {
    const { drawn } = now;
    at("error-value").textContent = errorText(drawn.error);
    at("floor-value").textContent = errorText(drawn.floor);
    at("gauge").title = MEANS;
    gauge(at("gauge"), drawn, now.before, reach(now.all.steps), drawn.moving ? false : settled());
    if (drawn.moving && !now.animated) follow();
}

// The number in the headline is the number in the chart, while a value moves too.
function follow() {
    const { worst, headline } = now.view,
        strong = at("headline-strong");
    const i = worst ? now.drawn.tau.findIndex((tau) => Math.abs(tau / worst.tau_s - 1) < 0.01) : -1;
    if (i >= 0 && headline[0].includes("off by"))
        strong.textContent = timesText(now.drawn.measured[i] / now.drawn.model[i]);
}
