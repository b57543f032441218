// The live view of a sensor on CAN or a serial line.
import { ask } from "/page/api.js";
import { heat } from "/page/chart/heat.js";
import { xy } from "/page/chart/xy.js";
import { at, change, newest, now } from "/page/now.js";
import { duration, element, fill, number } from "/page/words.js";

let kept = 0; // number of results that the server keeps per channel
let reasons = {}; // name -> why a result has no angle random walk
let rows = new Map(),
    count = 0,
    listening = null,
    standing = null,
    frozen = false;

let early = null; // events that arrived before the answer to `live`

// The section is in the tab of an open recording, or on the first page.
export function build(panel) {
    panel.append(
        element(
            "div",
            { id: "deaf", class: "held" },
            element("h2", {}, "Watch a sensor"),
            element(
                "p",
                { class: "soft" },
                "Shows the angle random walk and the Allan curve while they arrive, and keeps them in a file.",
            ),
            element(
                "form",
                {
                    class: "row",
                    onsubmit: (event) => {
                        event.preventDefault();
                        change(`Listening to ${at("tab-source").value}`, "listen", {
                            source: at("tab-source").value,
                        });
                    },
                },
                element("input", {
                    id: "tab-source",
                    placeholder: "can:can0 or slcan:/dev/ttyUSB0",
                    required: true,
                    size: 28,
                    "aria-label": "a live sensor",
                }),
                element("button", {}, "Listen"),
            ),
        ),
        at("live"),
    );
}

// Out of the way of a first page that is drawn anew.
export const away = () => at("shelf").append(at("live"));

export function place() {
    const open = Boolean(now.all.recording),
        home = open ? at("panel-live") : at("demo-live");
    if (home && at("live").parentNode !== home) home.append(at("live"));
    at("deaf").hidden = Boolean(now.all.live);
    at("tab-live").classList.toggle("on", Boolean(now.all.live));
}

function take(more) {
    for (const row of more) {
        if (!rows.has(row.channel)) rows.set(row.channel, []);
        rows.get(row.channel).push(row);
        if (rows.get(row.channel).length > kept) rows.get(row.channel).shift();
    }
}

// Shows the live source, if there is one. A new source is loaded completely.
export async function live(all) {
    at("live").hidden = !all.live;
    if (listening === (all.live?.number ?? null)) return;
    [listening, rows, count, standing, frozen] = [
        all.live?.number ?? null,
        new Map(),
        0,
        null,
        false,
    ];
    if (listening === null) return;
    const missed = (early = []);
    let whole;
    try {
        whole = await ask("live");
    } finally {
        early = null;
    }
    [standing, count, kept, reasons] = [whole, whole.count, whole.kept, whole.reasons];
    take(whole.rows);
    missed.forEach(heard);
    draw();
}

// Adds new results. Some may already be in the answer to `live`.
export function heard(news) {
    if (early) early.push(news);
    if (early || !standing || news.count < count) return;
    take(news.rows.slice(Math.max(0, count - (news.count - news.rows.length))));
    [standing, count] = [news, news.count];
    at("live").dataset.count = String(count);
    if (!frozen) draw();
}

const counts = (all) =>
    Object.entries(all)
        .map(([name, count]) => `${name.replaceAll("_", " ")} ${count}`)
        .join(", ");

const TERMS = [
    ["bi_deg_per_h", "BI", "deg/h"],
    ["rrw_deg_per_h_per_sqrt_h", "RRW", "deg/h/√h"],
    ["rr_deg_per_h2", "RR", "deg/h²"],
    ["qn_deg", "QN", "deg"],
];
const resolved = (row) =>
    TERMS.filter(([name]) => row[name])
        .map(([name, short, unit]) => `, ${short} ${number(row[name])} ${unit}`)
        .join("");

function said(last, shown, chosen) {
    const changed = shown.findLast((row) => row.alarm); // law glr
    const arw = last.arw_deg_per_sqrt_h,
        health = counts(standing.health[chosen] || {});
    fill(
        "live-said",
        element(
            "b",
            { id: "live-arw" },
            arw === undefined || arw === null ? "ARW absent" : `ARW ${number(arw, 4)}`,
        ),
        ` deg/√h${last.arw_low_deg_per_sqrt_h ? ` [${number(last.arw_low_deg_per_sqrt_h)}, ${number(last.arw_high_deg_per_sqrt_h)}]` : ""}`,
        element("span", { id: "live-terms" }, resolved(last)),
        ", epoch ",
        element("span", { id: "live-epoch" }, String(last.epoch)),
        `, window ${last.window_samples ?? "?"} samples`,
        last.unstable && last.alarm === undefined
            ? element("strong", { class: "alarm" }, " UNSTABLE")
            : "",
        changed
            ? element(
                  "strong",
                  { class: "alarm", id: "live-changed" },
                  ` noise changed at epoch ${changed.epoch}${
                      changed.change_older && changed.change_newer
                          ? `, ${number(changed.change_older)} → ${number(changed.change_newer)} deg/s`
                          : ""
                  }`,
              )
            : "",
        last.arw_withheld
            ? element(
                  "div",
                  { id: "live-why" },
                  `No angle random walk (${last.arw_withheld}): ${reasons[last.arw_withheld]}.`,
              )
            : "",
        element(
            "div",
            { class: "soft" },
            `received: ${counts(standing.faults) || "nothing"}; the device reports: ${health || "nothing lost"}`,
        ),
    );
}

export const draw = newestDraw();
function newestDraw() {
    const work = newest(async () => {
        if (!standing) return;
        if (!rows.size && !standing.ended)
            fill("live-said", `${standing.source}: nothing received yet`);
        const chosen = Number(at("live-channel").value || [...rows.keys()][0]);
        fill(
            "live-channel",
            ...[...rows.keys()]
                .sort((a, b) => a - b)
                .map((one) => element("option", { value: one, selected: one === chosen }, one)),
        );
        const last = (rows.get(chosen) || []).at(-1),
            shown = (rows.get(chosen) || []).filter((row) => row.stretch === last.stretch); // only this run of the sender
        if (last) {
            said(last, shown, chosen);
            pictures(shown, standing.curves[chosen]);
        }
        fill(
            "live-state",
            standing.ended ? "The source has ended. " : standing.said ? `${standing.said}. ` : "",
            `Saved in ${standing.path}.`,
        );
        at("diagnose").hidden = !standing.raw.includes(chosen);
        at("freeze").textContent = frozen ? "Resume" : "Freeze";
    });
    return () => work({});
}

function pictures(shown, curve) {
    at("live-curve").hidden = !curve;
    if (curve) allan(curve);
    rolling(shown);
    surface(shown, curve);
}

// Live results over time, or over the epoch while the rate is unknown.
function when(shown) {
    if (shown.some((row) => row.time_s === undefined))
        return [{ title: "epoch" }, shown.map((row) => row.epoch)];
    return [{ clock: true }, shown.map((row) => row.time_s)];
}

// Crosses: unstable windows, or alarms of law glr.
function rolling(shown) {
    const [axis, x] = when(shown),
        of = (name) => shown.map((row) => row[name] ?? null),
        marked = shown
            .map((row, i) => ((row.alarm ?? row.unstable) ? i : -1))
            .filter((i) => i >= 0),
        arw = of("arw_deg_per_sqrt_h");
    const top = Math.max(...arw, ...of("arw_high_deg_per_sqrt_h")) * 1.1 || 1;
    xy(
        at("live-chart"),
        [
            {
                x,
                y: arw,
                low: of("arw_low_deg_per_sqrt_h"),
                high: of("arw_high_deg_per_sqrt_h"),
                colour: "var(--model)",
                width: 2,
                name: "ARW, 95 %",
            },
            { x, y: of("window_samples"), right: true, colour: "var(--edge)", dash: "2 3" },
            {
                x: marked.map((i) => x[i]),
                y: marked.map((i) => arw[i]),
                points: "cross",
                colour: "var(--meas)",
                name: marked.length
                    ? shown.some((row) => row.alarm !== undefined)
                        ? "alarm"
                        : "unstable"
                    : null,
                ink: "var(--meas-ink)",
            },
        ],
        {
            x: axis,
            y: { title: "ARW, deg/√h. Dotted: window", range: [0, top] },
            label: "ARW and window over time",
        },
    );
    at("live-chart").dataset.arw = JSON.stringify(arw);
    at("live-chart").dataset.alarms = marked.length;
}

// The newest Allan curve. The axis has every cluster size, also those whose first deviation comes later.
function allan(one) {
    const x = one.tau_s ?? one.m,
        ends = [x[0] / 1.3, x.at(-1) * 1.3];
    const label = (m, i) =>
        `${one.tau_s ? duration(x[i]) : `${m} samples`}: ${number(one.adev[i])} deg/s${one.low[i] === null ? ", no interval" : `, 95 %: ${number(one.low[i])} to ${number(one.high[i])}`}`;
    xy(
        at("live-curve"),
        [
            { x, y: one.fitted, colour: "var(--model)", width: 2, name: "fitted terms" },
            {
                x,
                y: one.adev,
                low: one.low,
                high: one.high,
                bars: true,
                points: (i) => (one.low[i] === null ? "ring" : "dot"),
                colour: "var(--meas)",
                ink: "var(--meas-ink)",
                name: "measured, 95 %",
                texts: one.m.map(label),
            },
        ],
        {
            x: {
                log: true,
                time: Boolean(one.tau_s),
                title: one.tau_s ? null : "cluster, samples",
                range: ends,
            },
            y: { log: true, title: "Allan deviation, deg/s" },
            label: "Allan curve of the newest result",
        },
    );
    Object.assign(at("live-curve").dataset, {
        curve: JSON.stringify(one),
        range: JSON.stringify(ends),
    });
}

// The Allan deviation over time and cluster size.
function surface(shown, one) {
    const [axis, x] = when(shown),
        sizes = [...new Set(shown.flatMap((row) => Object.keys(row)))]
            .filter((name) => /^adev_\d+$/.test(name))
            .map((name) => Number(name.slice(5)))
            .sort((a, b) => a - b);
    const times = new Map((one?.tau_s ?? []).map((s, i) => [one.m[i], duration(s)])),
        timed = new Set(times.values()).size === sizes.length;
    const names = sizes.map((m) => (timed ? times.get(m) : String(m)));
    if (!sizes.length) return;
    heat(
        at("live-surface"),
        sizes.map((m) =>
            shown.map((row) => (row[`adev_${m}`] > 0 ? Math.log10(row[`adev_${m}`]) : null)),
        ),
        {
            x: { from: x[0], to: x.at(-1), ...axis },
            y: { names, title: timed ? "averaging time" : "cluster, samples" },
            unit: "deg/s",
            label: "Allan deviation over time",
        },
    );
}

at("live-channel").onchange = draw;
at("freeze").onclick = () => {
    frozen = !frozen;
    draw();
};
at("diagnose").onclick = () =>
    change("Reading the samples so far", "freeze", { channel: Number(at("live-channel").value) });
at("stop_listening").onclick = () => change("", "stop_listening");
