// The right column: the next step. Candidates as cards, the best one first; what fits; what no known effect explains.
import { ask } from "/page/api.js";
import { bar } from "/page/parts/bar.js";
import { headline, settled } from "/page/parts/head.js";
import { open } from "/page/parts/own.js";
import { unknown } from "/page/parts/unknown.js";
import { acting, at, now, refused, say, show } from "/page/now.js";
import { capital, element, errorText, fill } from "/page/words.js";

const CARDS = 3,
    ALIKE = 3,
    NEAR = 30; // cards shown; in units of the log-likelihood
let foreseen = new Map(); // place -> error and curve with a candidate

// Loads the candidates for the fitted model. This runs after a step is drawn, so that its curve appears first.
export async function rank(turn) {
    [now.found, now.answer] = [null, null];
    foreseen = new Map();
    trying("the effects");
    try {
        const answer = await ask("candidates", { number: now.view.number });
        if (turn !== now.turn || answer.state !== now.view.state) return;
        if (answer.superseded) {
            await pause();
            return turn === now.turn ? rank(turn) : null;
        }
        [now.found, now.answer] = [answer.candidates, answer];
        say("");
        draw();
        headline();
        await foresee(turn);
    } catch (why) {
        if (wantedStill(turn)) refused(why);
    }
}

// Is the step still shown. The server refuses questions about another one, which nobody asks any more.
export const wantedStill = (turn) => turn === now.turn && !now.stale;

// Shows which effect is being tested, and what was found so far, which cannot be added yet.
export function partly(event) {
    if (now.found || !now.view || now.stale || event.ranking !== now.view.state) return;
    trying(event.trying, event.candidates);
}

function trying(what, found = []) {
    if (now.view.adequate) found = [];
    fill(
        "next",
        element(
            "div",
            { class: "card best panel waiting", id: "trying" },
            element("p", { class: "kicker" }, "Next"),
            element("p", { class: "soft" }, `Trying ${what} …`),
            element("progress", { "aria-label": "Testing effects" }),
        ),
        ...found
            .slice(0, CARDS)
            .map((one) =>
                element(
                    "article",
                    { class: "card panel early" },
                    element("h2", {}, capital(one.title)),
                ),
            ),
    );
}

// Is it known that the error does not fall, or by less than one sees, with a candidate.
const rises = (one) =>
    now.found?.includes(one) && foreseen.get(one.place)?.error > 0.99 * now.view.error;

// The candidates by cards: those of the same physics together, the best of them in front. First come those with which the error falls.
export function cards(found = now.found) {
    const beyond = found.filter((one) => one.beyond_chance),
        leaders = [...new Set(beyond.map((one) => one.leader))].map((place) =>
            beyond.find((one) => one.leader === place),
        );
    return [...leaders.filter((one) => !rises(one)), ...leaders.filter(rises)]
        .slice(0, CARDS)
        .map((one) => ({
            one,
            others: beyond.filter(
                (other) =>
                    other !== one && other.leader === one.leader && other.log_p - one.log_p < ALIKE,
            ),
        }));
}

export const titled = ({ one, others }) =>
    capital([one, ...others].map((other) => other.title).join(" or "));

function pips(gain) {
    const most = Math.max(...now.found.map((one) => one.gain)),
        count = most - gain < ALIKE ? 4 : most - gain < NEAR ? 3 : gain > NEAR ? 2 : 1;
    return element(
        "span",
        {
            class: "pips",
            role: "img",
            "aria-label": `evidence ${count} of 4`,
            title: `evidence ${count} of 4`,
        },
        ...[1, 2, 3, 4].map((i) => element("i", { class: i <= count ? "on" : null })),
    );
}

function draw() {
    const focused = document.activeElement?.dataset?.kind,
        left = document.activeElement === at("page");
    if (now.answer.unknown) fill("next", ...unknown(now.answer, rest(now.found)));
    else if (settled()) fill("next", ...fits(), rest(now.found));
    else if (!cards().length) fill("next", nothing(), rest(now.found));
    else {
        const shown = cards(),
            first = shown[0],
            kept = new Set(shown.flatMap(({ one, others }) => [one, ...others]));
        fill(
            "next",
            ...shown.map((card) => article(card, card === first)),
            rest(now.found.filter((one) => !kept.has(one))),
        );
    }
    if (focused)
        document
            .querySelector(`#next button[data-kind="${focused}"]`)
            ?.focus({ preventScroll: true });
    else if (left) document.querySelector("#next .best button")?.focus({ preventScroll: true }); // a step left it behind
}

// No candidate, and no place of a misfit: the recording permits no verdict, or the rest is below chance.
const nothing = () =>
    element(
        "article",
        { class: "panel unknown", id: "nothing" },
        ...[...now.answer.nothing, ...now.view.observations.map((one) => one.said)].map((said) =>
            element("p", {}, said),
        ),
        element(
            "div",
            { class: "row tail" },
            element("button", { onclick: () => at("tab-where").click() }, "Show where"),
            element("button", { onclick: () => at("close").click() }, "Open another recording"),
        ),
    );

function article(card, best) {
    const made = element(
        "article",
        {
            class: `card panel${best ? " best" : ""}`,
            onpointerenter: () => preview(card),
            onpointerleave: () => preview(null),
        },
        button(card, "candidate"),
    );
    write(made, card, best);
    return made;
}

// Writes what is known of the candidates by now around their buttons, which stay if their order does: one may be pressed just now.
function redraw() {
    const shown = cards(),
        places = [...document.querySelectorAll("#next > .card > .candidate")].map((one) =>
            Number(one.dataset.place),
        );
    if (String(places) !== String(shown.map(({ one }) => one.place))) draw();
    else for (const [i, card] of shown.entries()) write(at("next").children[i], card, i === 0);
}

function write(made, card, best) {
    const { one, others } = card,
        later = foreseen.get(one.place),
        before = now.view.error,
        add = made.querySelector("button");
    const to =
        later &&
        element(
            "span",
            { class: "to" },
            best ? element("span", { class: "soft" }, `${errorText(before)} `) : null,
            `→ ${errorText(later.error)}`,
        );
    const falls = !rises(one);
    const say = !falls ? "The error does not fall." : best ? one.physics : "";
    for (const child of [...made.children]) if (child !== add) child.remove();
    add.className = best && falls ? "candidate go big" : "candidate";
    add.disabled = !later; // nobody adds an effect before its result is shown
    add.before(
        ...[
            best
                ? element(
                      "div",
                      { class: "kicker" },
                      element(
                          "span",
                          {},
                          falls
                              ? "Next: add"
                              : now.view.adequate
                                ? "Significant, but below 5 %"
                                : "Next",
                      ),
                      element(
                          "span",
                          { class: "row" },
                          element("span", { class: "soft small" }, "evidence"),
                          pips(one.gain),
                      ),
                  )
                : null,
            element("h2", {}, titled(card)),
            to || element("span", { class: "to soft" }, "…"),
            later ? bar(before, later.error, later.floor, top()) : element("div", { class: "bar" }),
            element(
                "p",
                {
                    class: `soft say${falls ? "" : " rises"}`,
                    title: others.length
                        ? others.map((other) => other.note || other.confirm).join(" ")
                        : one.confirm,
                },
                best ? null : pips(one.gain),
                say,
            ),
        ].filter(Boolean),
    );
}

// The right end of the bars of all cards.
const top = () => Math.max(0.02, now.view.error, ...[...foreseen.values()].map((one) => one.error));

function button(card, style) {
    const { one } = card;
    return element(
        "button",
        {
            class: style,
            "data-kind": one.kind,
            "data-place": one.place,
            "aria-label": `Add ${one.title}`,
            title: one.confirm,
            onclick: () => add(one.place),
            onfocus: () => preview(card),
            onblur: () => preview(null),
        },
        "Add",
    );
}

function rest(found) {
    const title = now.found.some((one) => one.beyond_chance)
        ? `${found.length} more`
        : `${found.length} tried, none beyond chance`;
    return element(
        "div",
        { class: "more soft" },
        found.length
            ? element(
                  "details",
                  {
                      id: "more",
                      ontoggle: (event) =>
                          event.target.open && event.target.scrollIntoView({ block: "start" }),
                  },
                  element("summary", {}, title),
                  element(
                      "div",
                      { role: "group", "aria-label": "Other effects" },
                      ...now.answer.nothing.map((said) => element("p", {}, said)),
                      ...found.map((one) =>
                          element(
                              "div",
                              { class: "row" },
                              element(
                                  "span",
                                  { class: "grow", title: one.why },
                                  capital(one.title),
                              ),
                              button({ one, others: [] }, "candidate small"),
                          ),
                      ),
                  ),
              )
            : null,
        now.all.code && !now.answer.unknown
            ? element("button", { class: "link write", onclick: () => open() }, "Write an effect")
            : null,
    );
}

function fits() {
    const held = now.all.held_out;
    return [
        element(
            "article",
            { class: "card best panel good" },
            element("div", { class: "kicker" }, "Next"),
            element(
                "h2",
                { class: "whole" },
                held ? "It is tested on a second recording" : "Check it on a second recording",
            ),
            element(
                "p",
                { class: "soft" },
                "Each step is then tested on data that it was not fitted to.",
            ),
            element(
                "button",
                {
                    class: "go big",
                    id: "to-held-out",
                    onclick: () => {
                        at("tab-held").click();
                        if (!held) at("hold").click();
                    },
                },
                held ? "Show" : "Choose",
            ),
        ),
        element(
            "article",
            { class: "card panel" },
            element("h2", {}, "Use the model"),
            element("span"),
            element("p", { class: "soft" }, "C table, kalibr, PX4, ROS, report."),
            element(
                "button",
                {
                    id: "use",
                    onclick: () => {
                        at("export").focus();
                        at("export").click();
                    },
                },
                "Export",
            ),
        ),
    ];
}

const RETRY_MS = 500; // until a question is asked again that gave way to an action
export const pause = () => new Promise((done) => setTimeout(done, RETRY_MS));

// Loads the error and the curve with the candidate of a card. false: nobody wants it any more.
async function candidatePreview({ one }, turn) {
    while (wantedStill(turn)) {
        const answer = await ask("candidate_preview", {
            place: one.place,
            kind: one.kind,
            state: now.view.state,
        });
        if (!wantedStill(turn)) return false;
        if (!answer.superseded) {
            foreseen.set(one.place, answer);
            return true;
        }
        await pause();
    }
    return false;
}

// The error and the curve with each candidate of a card, one after the other: the best one first. Those with which the error does not fall make room for the next ones.
async function foresee(turn) {
    if (settled() || now.answer.unknown) return;
    for (let card; (card = cards().find(({ one }) => !foreseen.has(one.place)));) {
        if (!(await candidatePreview(card, turn))) return;
        redraw();
        if (card.one === cards()[0].one) show("next", now.next || expected());
    }
}

const told = (card) => {
    const later = card && foreseen.get(card.one.place);
    return later ? { ...later, label: `+ ${card.one.title}` } : null;
};

// The step that the best card would make. It is outlined in the staircase while no other is looked at.
export const expected = () =>
    now.found && !now.view.adequate && !now.answer?.unknown && cards().length
        ? told(cards()[0])
        : null;

let wanted = null;
function preview(card) {
    wanted = card;
    const later = told(card);
    show("next", later ? { ...later, drawn: true } : expected());
    if (card && !later) setTimeout(() => wanted === card && look(card), 300);
}

async function look(card) {
    const { turn } = now;
    try {
        if (!(await candidatePreview(card, turn))) return;
        redraw();
        if (wanted === card) show("next", { ...told(card), drawn: true });
    } catch (why) {
        if (wantedStill(turn)) refused(why);
    }
}

// Adds the candidate at a place to the model, if there is one.
function add(place) {
    const one = now.found?.[place];
    return one && !now.stale
        ? acting(`Fitting with ${one.title}`, "add", { place: one.place, kind: one.kind })
        : null;
}
