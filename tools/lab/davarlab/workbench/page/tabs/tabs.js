// The tabs over the chart: only the one that is shown is drawn, again when its size changes.
import { save } from "/page/chart/svg.js";
import { at, now, refused } from "/page/now.js";
import { element } from "/page/words.js";

let tabs = [],
    shown = null;

// tabs: {id, title, build(panel), draw(panel), zoom(factor or null to reset)}.
export function build(all) {
    tabs = all;
    const buttons = tabs.map((one, i) =>
        element(
            "button",
            {
                role: "tab",
                id: `tab-${one.id}`,
                "aria-controls": `panel-${one.id}`,
                onclick: () => choose(one),
                onkeydown: (event) => {
                    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
                    if (!by) return;
                    event.preventDefault();
                    const next = buttons[(i + by + tabs.length) % tabs.length];
                    next.focus();
                    if (!tabs[(i + by + tabs.length) % tabs.length].leaves) next.click();
                },
            },
            one.title,
        ),
    );
    at("tablist").replaceChildren(...buttons);
    for (const one of tabs) {
        if (one.leaves) continue;
        const panel = element("section", {
            role: "tabpanel",
            id: `panel-${one.id}`,
            class: "tabpanel",
            "aria-labelledby": `tab-${one.id}`,
            hidden: true,
        });
        at("panels").append(panel);
        one.build?.(panel);
    }
    new ResizeObserver(() => draw()).observe(at("panels"));
    at("zoom").onclick = () => {
        shown.zoom?.(0.5);
    };
    at("zoom-reset").onclick = () => {
        shown.zoom?.(null);
    };
    const drawing = () => at(`panel-${shown.id}`).querySelector("svg:not([hidden])");
    at("save-svg").onclick = () => drawing() && save(drawing(), shown.id, "svg");
    at("save-png").onclick = () => drawing() && save(drawing(), shown.id, "png");
    choose(tabs[0]);
}

function choose(one) {
    if (one.leaves) {
        one.leaves();
        return;
    }
    shown = one;
    for (const other of tabs) {
        const button = at(`tab-${other.id}`),
            here = other === one;
        button.setAttribute("aria-selected", String(here));
        button.tabIndex = here ? 0 : -1;
        if (here) button.scrollIntoView({ block: "nearest", inline: "nearest" });
        if (at(`panel-${other.id}`)) at(`panel-${other.id}`).hidden = !here;
    }
    at("tab-tools").hidden = !one.zoom;
    draw();
}

export const select = (id) => at(`tab-${id}`).click();
export const showing = (id) => shown?.id === id;

// Draws the shown tab of the current step.
export async function draw() {
    if (!now.view || at("bench").hidden) return;
    const panel = at(`panel-${shown.id}`),
        { turn } = now,
        one = shown;
    panel.setAttribute("aria-busy", "true");
    try {
        await one.draw(panel);
    } catch (why) {
        if (turn === now.turn) refused(why);
    }
    if (turn === now.turn && one === shown) panel.setAttribute("aria-busy", "false");
}
