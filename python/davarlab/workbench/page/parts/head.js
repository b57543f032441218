// The headline, always in this order: what fits and over which times, what was not tested, what speaks against it. Beside it, the error over
// its floor. Every sentence is the server's.
import { gauge, reach } from "/page/chart/gauge.js";
import { helps } from "/page/parts/next.js";
import { acting, at, now } from "/page/now.js";
import { element, errorText, fill } from "/page/words.js";

// Green: the model fits, the candidates are known, and nothing speaks against it.
export const settled = () =>
    now.view.adequate && Boolean(now.answer) && !now.answer.against.length && !contrary();
// What else speaks against it: the residual, and the recording that is held out.
const contrary = () => [now.view.against, now.fails].filter(Boolean).join("; ");
const MEANS =
    "The error is the rms of log10(measured / model) over every window and averaging time. The error of a true model scatters around the floor: below it, nothing is left to explain. The floor changes a little from step to step, because the scatter of an Allan deviation depends on the noise in the model.";

// Why the verdict is what it is.
function why() {
    const { p_value: p, said, observations, notes } = now.view;
    return element(
        "details",
        { id: "why", class: "why", open: at("why")?.open },
        element("summary", {}, "Why?"),
        element(
            "div",
            { class: "panel", tabindex: 0, role: "group", "aria-label": "Why" },
            element("p", { id: "said" }, [said, now.answer?.said].filter(Boolean).join(" ")),
            p === null || said.includes("(p ")
                ? null
                : element("p", {}, p < 1e-6 ? "p < 1e-6" : `p = ${p.toFixed(2)}`),
            ...[...observations.map((one) => one.said), ...notes].map((note) =>
                element("p", {}, note),
            ),
            element("p", {}, MEANS),
        ),
    );
}

// What speaks against the model. Of one that fits, the effect that is named first can be added here, if the error does not rise with it.
function against() {
    const { view, answer } = now,
        lacking = answer?.candidates.find(
            (one) => one.beyond_chance && !one.doubt && one.kind === answer.against[0],
        ),
        better = lacking && helps({ one: lacking }),
        said = [answer?.lacks, contrary()].filter(Boolean).join("; ");
    if (said)
        return [
            element("span", {}, `Against it: ${said}`),
            better &&
                element(
                    "button",
                    {
                        class: "small",
                        onclick: () =>
                            acting(`Fitting with ${lacking.title}`, "add", {
                                place: lacking.place,
                                kind: lacking.kind,
                            }),
                    },
                    `Add ${lacking.title}`,
                ),
        ];
    if (!view.adequate) return [];
    return answer
        ? ["Nothing speaks against it"]
        : [element("span", { class: "soft" }, "Trying what may speak against it …")];
}

export function headline() {
    const [before, strong, after] = now.answer?.headline || now.view.headline,
        held = now.answer ? at("held-out-error")?.textContent : ""; // of the same step
    const pending = now.view.adequate && !contrary() && !now.answer;
    at("head").className = `head ${settled() ? "settled" : pending ? "pending" : ""}`;
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
            element("span", { id: "untested", class: "soft" }, now.view.untested),
            why(),
            element("span", { id: "held-out-error", class: "soft" }, held),
        ),
    );
    const seen = now.view.observations.map((one) => one.kind.replaceAll("_", " "));
    fill(
        "evidence",
        element("p", { id: "contrary", class: "contrary" }, ...against().filter(Boolean)),
        seen.length
            ? element("p", { class: "observation" }, `In the recording: ${seen.join(", ")}`)
            : null,
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

// The bar alone, while a value moves. The words are of the step before and make room for a hint.
export function error() {
    const { drawn } = now;
    for (const id of ["headline", "evidence"])
        at(id).classList.toggle("moving", Boolean(drawn.moving));
    at("error-value").textContent = errorText(drawn.error);
    at("floor-value").textContent = errorText(drawn.floor);
    at("gauge").title = MEANS;
    gauge(at("gauge"), drawn, now.before, reach(now.all.steps), drawn.moving ? false : settled());
}
