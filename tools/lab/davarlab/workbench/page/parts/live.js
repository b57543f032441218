// The live view of a sensor on CAN or a serial line.
import { ask } from "/page/api.js";
import * as charts from "/page/charts.js";
import { at, change, newest } from "/page/now.js";
import { element, fill, number } from "/page/words.js";

let kept = 0; // number of results that the server keeps per channel
let reasons = {}; // name -> why a result has no angle random walk
let rows = new Map(), count = 0, listening = null, standing = null, frozen = false;

let early = null; // events that arrived before the answer to `live`

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
  [listening, rows, count, standing, frozen] = [all.live?.number ?? null, new Map(), 0, null, false];
  if (listening === null) return;
  const missed = (early = []);
  let whole;
  try { whole = await ask("live"); } finally { early = null; }
  [standing, count, kept, reasons] = [whole, whole.count, whole.kept, whole.reasons];
  take(whole.rows);
  missed.forEach(heard);
  draw({});
}

// Adds new results. Some may already be in the answer to `live`.
export function heard(news) {
  if (early) early.push(news);
  if (early || !standing || news.count < count) return;
  take(news.rows.slice(Math.max(0, count - (news.count - news.rows.length))));
  [standing, count] = [news, news.count];
  at("live").dataset.count = count;
  if (!frozen) draw({});
}

const counts = (all) => Object.entries(all).map(([name, count]) => `${name.replaceAll("_", " ")} ${count}`).join(", ");

const TERMS = [["bi_deg_per_h", "BI", "deg/h"], ["rrw_deg_per_h_per_sqrt_h", "RRW", "deg/h/√h"], ["rr_deg_per_h2", "RR", "deg/h²"], ["qn_deg", "QN", "deg"]];
const resolved = (row) => TERMS.filter(([name]) => row[name]).map(([name, short, unit]) => `, ${short} ${number(row[name])} ${unit}`).join("");

const draw = newest(async () => {
  if (!rows.size && !standing.ended) fill("live-said", `${standing.source}: nothing received yet`);
  const chosen = Number(at("live-channel").value || [...rows.keys()][0]);
  fill("live-channel", ...[...rows.keys()].sort((a, b) => a - b).map((one) => element("option", { value: one, selected: one === chosen }, one)));
  const last = (rows.get(chosen) || []).at(-1), shown = (rows.get(chosen) || []).filter((row) => row.stretch === last.stretch); // only this run of the sender
  if (last) {
    const changed = shown.findLast((row) => row.alarm); // policy glr
    const arw = last.arw_deg_per_sqrt_h, health = counts(standing.health[chosen] || {});
    fill("live-said", element("b", { id: "live-arw" }, arw === undefined || arw === null ? "ARW absent" : `ARW ${number(arw, 4)}`),
      ` deg/√h${last.arw_low_deg_per_sqrt_h ? `, 95 %: ${number(last.arw_low_deg_per_sqrt_h)} to ${number(last.arw_high_deg_per_sqrt_h)}` : ""}`,
      element("span", { id: "live-terms" }, resolved(last)), `, epoch `, element("span", { id: "live-epoch" }, String(last.epoch)), `, window ${last.window_samples ?? "?"} samples`,
      last.unstable && last.alarm === undefined ? element("strong", { class: "alarm" }, " UNSTABLE") : "",
      changed ? element("strong", { class: "alarm", id: "live-changed" }, ` noise changed at epoch ${changed.epoch}${changed.change_older && changed.change_newer
        ? `, ${number(changed.change_older)} → ${number(changed.change_newer)} deg/s` : ""}`) : "",
      last.arw_withheld ? element("div", { id: "live-why" }, `No angle random walk (${last.arw_withheld}): ${reasons[last.arw_withheld]}.`) : "",
      element("div", {}, `received: ${counts(standing.faults) || "nothing"}; the device reports: ${health || "nothing lost"}`));
    const curve = standing.curves[chosen];
    at("live-curve").hidden = !curve;
    if (curve) await charts.curve("live-curve", curve);
    await charts.rolling("live-chart", shown);
    await charts.surface("live-surface", shown, curve);
  }
  fill("live-state", standing.ended ? "The source has ended. " : standing.said ? `${standing.said}. ` : "", `Saved in ${standing.path}.`);
  at("diagnose").hidden = !standing.raw.includes(chosen);
  at("freeze").textContent = frozen ? "Resume" : "Freeze";
});

at("live-channel").onchange = () => draw({});
at("freeze").onclick = () => { frozen = !frozen; draw({}); };
at("diagnose").onclick = () => change("reading the samples so far", "freeze", { channel: Number(at("live-channel").value) });
at("deafen").onclick = () => change("", "deafen");
