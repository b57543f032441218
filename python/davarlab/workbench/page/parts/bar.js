// A short bar of an error: before (hatched), after, and the floor as a line.
import { GOOD } from "/page/chart/gauge.js";
import { element, errorText } from "/page/words.js";

export function bar(before, after, floor, most) {
    const share = (value) => `${Math.max(0, Math.min(100, (100 * value) / most))}%`;
    const part = (name, style) => {
        const made = element("span", { class: name });
        Object.assign(made.style, style);
        return made;
    };
    return element(
        "div",
        {
            class: "bar",
            role: "img",
            "aria-label": `error ${errorText(before)} to ${errorText(after)}, floor ${errorText(floor)}`,
        },
        part("was", { width: share(before) }),
        part(`now${after <= GOOD * floor ? " ok" : ""}`, { width: share(after) }),
        part("fl", { left: share(floor) }),
    );
}
