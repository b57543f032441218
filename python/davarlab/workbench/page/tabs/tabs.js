// The tabs over the chart: only the one that is shown is drawn, again when its size changes.
import { save } from "/page/chart/svg.js";
import { at, now, picture, refused } from "/page/now.js";
import { element } from "/page/words.js";

let tabs = [],
    shown = null;

// tabs: {id, of, title, picture (the title of a saved one), main (where its drawing is, if it has several), build(panel), draw(panel), zoom(factor or null to reset)}. of: the group; one without has its button elsewhere.
export function build(all) {
    tabs = all;
    const listed = tabs.filter((one) => one.of);
    const buttons = listed.map((one, i) =>
        element(
            "button",
            {
                role: "tab",
                id: `tab-${one.id}`,
                "aria-controls": `panel-${one.id}`,
                onkeydown: (event) => {
                    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
                    if (!by) return;
                    event.preventDefault();
                    const next = buttons[(i + by + listed.length) % listed.length];
                    next.focus();
                    next.click();
                },
            },
            one.title,
        ),
    );
    for (const name of new Set(listed.map((one) => one.of)))
        at("tablist").append(
            element("span", { class: "group", "aria-hidden": true }, name),
            element(
                "div",
                { role: "tablist", class: "row", "aria-label": name },
                ...buttons.filter((_, i) => listed[i].of === name),
            ),
        );
    for (const one of tabs) {
        at(`tab-${one.id}`).onclick = () => choose(one);
        const panel = element("section", {
            role: one.of ? "tabpanel" : "region",
            id: `panel-${one.id}`,
            class: "tabpanel",
            "aria-labelledby": `tab-${one.id}`,
            hidden: true,
        });
        at("panels").append(panel);
        one.build(panel);
    }
    new ResizeObserver(() => draw()).observe(at("panels"));
    at("zoom").onclick = () => {
        shown.zoom?.(0.5);
    };
    at("zoom-reset").onclick = () => {
        shown.zoom?.(null);
    };
    const drawing = () =>
        [shown.main, `#panel-${shown.id}`]
            .map((place) => place && document.querySelector(`${place} svg:not([hidden])`))
            .find(Boolean);
    for (const kind of ["svg", "png"])
        at(`save-${kind}`).onclick = () =>
            drawing() && save(drawing(), picture(shown.id, shown.picture || shown.title), kind);
    choose(tabs[0]);
}

function choose(one) {
    shown = one;
    for (const other of tabs) {
        const button = at(`tab-${other.id}`),
            here = other === one;
        button.setAttribute(other.of ? "aria-selected" : "aria-pressed", String(here));
        if (other.of) button.tabIndex = here || (!one.of && other === tabs[0]) ? 0 : -1;
        if (here) button.scrollIntoView({ block: "nearest", inline: "nearest" });
        at(`panel-${other.id}`).hidden = !here;
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
