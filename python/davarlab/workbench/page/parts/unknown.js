// Something is missing that no known effect explains: where, when, what moves with it, what to log next.
import { sections } from "/page/chart/cells.js";
import { at, now } from "/page/now.js";
import { way } from "/page/parts/own.js";
import { element, brief, number, section, timesText } from "/page/words.js";

// When the misfit is, along the recording.
function when(sections) {
    const marks = sections.map(({ start_s, stop_s }) => {
        const mark = element("i");
        Object.assign(mark.style, {
            left: `${(100 * start_s) / now.all.duration_s}%`,
            width: `${Math.max(1, (100 * (stop_s - start_s)) / now.all.duration_s)}%`,
        });
        return mark;
    });
    return element("div", { class: "when", "aria-hidden": true }, ...marks);
}

// What diagnoses the saved model in a terminal.
const diagnosis = () => now.all.commands.find((one) => one.includes(" diagnose "));

export function unknown(answer, rest) {
    const { where, next } = answer.unknown,
        proven = sections(now.view.map, where),
        bad = proven.length ? proven : [where],
        all = bad.some((one) => one.stop_s - one.start_s > 0.99 * now.all.duration_s);
    const facts = [
        [
            "Where",
            element("b", {}, brief(where.tau_s)),
            ` off by ${timesText(where.ratio)}`,
            where.frequency_hz === null
                ? null
                : element(
                      "div",
                      {},
                      element("b", {}, `${number(where.frequency_hz)} Hz`),
                      ` ${number(where.power_ratio, 2)}× the model's power`,
                  ),
        ],
        ["When", element("b", {}, all ? "throughout" : bad.map(section).join(", ")), when(bad)],
        [
            "Moves with",
            where.column === null
                ? element("span", { class: "soft" }, "no logged column")
                : element("b", {}, where.column),
            where.column === null ? null : ` correlation ${number(where.correlation, 2)}`,
        ],
        ["Log next", next[0]],
    ];
    return [
        element(
            "article",
            { class: "panel unknown", id: "nothing" },
            element(
                "dl",
                { class: "facts" },
                ...facts.flatMap(([name, ...said]) => [
                    element("dt", {}, name),
                    element("dd", {}, ...said),
                ]),
            ),
            element(
                "div",
                { class: "row tail" },
                element("button", { onclick: () => at("tab-where").click() }, "Show where"),
                now.all.columns.length
                    ? element(
                          "button",
                          { onclick: () => at("tab-columns").click() },
                          "Show the columns",
                      )
                    : null,
            ),
        ),
        element(
            "details",
            { class: "more soft" },
            element("summary", {}, "What was excluded, and more to try"),
            element(
                "div",
                { tabindex: 0, role: "group", "aria-label": "Excluded" },
                ...answer.nothing.slice(1).map((said) => element("p", {}, said)),
            ),
        ),
        element(
            "article",
            { class: "card panel" },
            element("h2", { class: "whole" }, "Do you know the cause?"),
            element("p", { class: "soft whole" }, "Ten lines of Python add it to the model."),
            element(
                "div",
                { class: "whole" },
                way(where.column, diagnosis() && `${diagnosis()} --effects effect.py`),
            ),
        ),
        rest,
    ];
}
