// The first page: the tutorial recording, a drop zone for a recording, and the form for its columns.
import { element, fill, number } from "/page/words.js";

const QUANTITIES = { time: "time", gyro: "gyro", accel: "accelerometer", temp: "temperature", other: "something else" };

export function first(all, actions) {
  const input = element("input", { type: "file", id: "file", "aria-label": "a recording", onchange: () => input.files[0] && actions.drop(input.files[0]) });
  const zone = element("div", { class: "drop", ondragover: (e) => { e.preventDefault(); zone.classList.add("over"); },
    ondragleave: () => zone.classList.remove("over"),
    ondrop: (e) => { e.preventDefault(); zone.classList.remove("over"); if (e.dataTransfer.files[0]) actions.drop(e.dataTransfer.files[0]); } },
    element("p", {}, "Drop a recording of your gyro here: CSV, ULog, DataFlash, ROS, MATLAB, NumPy, Parquet."), input);
  const source = element("input", { id: "source", placeholder: "can:can0 or slcan:/dev/ttyUSB0", required: true, size: 28 });
  fill("landing", element("h2", {}, "Where does your gyro model fail, and what is missing?"),
    element("p", {}, "All data stays on this machine."), zone,
    element("p", { class: "hint" }, `A dropped file and its session are saved in ${all.folder}.`),
    element("form", { class: "row", onsubmit: (event) => { event.preventDefault(); actions.listen(source.value); } },
      element("label", {}, "Or watch a live sensor: ", source), element("button", { id: "listen" }, "Listen")),
    element("p", {}, "No recording? ", element("button", { class: "main", id: "tutorial", onclick: actions.tutorial }, "Open the tutorial's sensor")));
}

// Selects one of several gyros in a log.
export function sensors(all, actions) {
  fill("landing", element("h2", {}, "Which sensor?"), element("p", {}, `${all.log.path} contains ${all.log.sensors.length} gyros.`),
    element("ul", { class: "choices" }, ...all.log.sensors.map((one) => element("li", {},
      element("button", { "data-sensor": one.name, onclick: () => actions.sensor(one.name) }, one.said)))),
    element("p", {}, element("button", { onclick: actions.close }, "Another file")));
}

function row(one, index, all) {
  const quantity = element("select", { "data-index": index, "data-key": "quantity", "aria-label": `${one.name}: quantity` },
    ...Object.entries(QUANTITIES).map(([key, name]) => element("option", { value: key, selected: key === one.quantity }, name)));
  const axis = element("select", { "data-index": index, "data-key": "axis", "aria-label": `${one.name}: axis` },
    ...["", "x", "y", "z"].map((name) => element("option", { value: name, selected: name === one.axis }, name)));
  const units = Object.keys(all.log.units[one.quantity] || {}).concat(["gyro", "accel"].includes(one.quantity) ? ["counts"] : []);
  const unit = element("select", { "data-index": index, "data-key": "unit", "aria-label": `${one.name}: unit` },
    ...(units.length ? units : [""]).map((name) => element("option", { value: name, selected: name === one.unit }, name)));
  const factor = element("input", { type: "number", step: "any", value: Number(one.factor.toPrecision(9)), "data-index": index, "data-key": "factor",
    "aria-label": `${one.name}: factor` });
  const name = all.log.named ? one.name : element("input", { class: "name", placeholder: one.name, size: 14, "aria-label": `${one.name}: name` });
  return element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, quantity), element("td", {}, axis), element("td", {}, unit),
    element("td", {}, factor), element("td", { class: one.sure ? "" : "unsure" }, one.sure ? "" : "a guess"),
    ...all.log.head.map((values) => element("td", { class: "number" }, number(values[index], 6))));
}

export function columns(all, actions) {
  const guesses = all.log.columns.map((one) => ({ ...one }));
  const titles = ["column", "quantity", "axis", "unit", "factor", "", "first rows"];
  const heads = titles.map((title, i) => element("th", i === titles.length - 1 ? { colspan: all.log.head.length } : {}, title));
  const table = element("table", {}, element("thead", {}, element("tr", {}, ...heads)),
    element("tbody", {}, ...guesses.map((one, index) => row(one, index, all))));
  table.addEventListener("change", (event) => {
    const { index, key } = event.target.dataset, one = guesses[index];
    if (!one) return; // a name
    one[key] = key === "factor" ? Number(event.target.value) : event.target.value;
    if (key === "quantity") one.unit = one.would[one.quantity] ?? "";
    if (key !== "factor") one.factor = (all.log.units[one.quantity] || {})[one.unit] ?? 1;
    one.sure = true;
    table.tBodies[0].rows[index].replaceWith(row(one, Number(index), all));
    readable();
  });
  const rate = element("input", { type: "number", step: "any", min: 0, id: "rate", placeholder: "from the time column" });
  const clock = all.log.rate_hz ? `${number(all.log.rate_hz, 6)} Hz, ${all.log.missing} samples missing` : "no time column";
  const read = element("button", { class: "main", id: "read", onclick: () => actions.read(guesses, Number(rate.value) || null, false) }, "Read the recording");
  const doubts = !all.log.doubts ? null : element("div", { id: "doubts", role: "alert" }, element("b", {}, "This recording is implausible. Nothing was fitted."),
    element("ul", {}, ...all.log.doubts.map((one) => element("li", {}, one))),
    element("p", {}, "Correct the unit or the factor in the table and read it again. If the recording is correct: ",
      element("button", { id: "confirm", onclick: () => actions.read(guesses, Number(rate.value) || null, true) }, "Read it unchanged")));
  const none = element("p", { id: "no-gyro" }, "No column is a gyro with an axis yet. Select one in the table. The workbench works with gyros only. For the noise of an accelerometer, use ",
    element("code", {}, "tools/davarlab fit REC --axes accel"), ".");
  const readable = () => { read.disabled = !guesses.some((one) => one.quantity === "gyro" && one.axis); none.hidden = !read.disabled; };
  readable();
  const names = () => [...table.querySelectorAll("input.name")].map((one) => one.value.trim());
  const unnamed = all.log.named ? null : element("p", { id: "unnamed" }, "The file has no names for its columns. Type them into the table, for example time_us and gyro_x_dps, then ",
    element("button", { id: "names", onclick: () => actions.names(names()) }, "use these names"), ". Or select the quantities.");
  fill("landing", element("h2", {}, "Columns of the recording"), element("p", {}, `${all.log.path}: ${all.log.rows} rows, ${clock}. `
      + "You can change the guesses."), all.log.said ? element("p", { class: "hint" }, `How it was read: ${all.log.said}.`) : null, unnamed, doubts,
    element("div", { class: "scroll" }, table),
    element("p", { class: "hint" }, "The factor converts the numbers of the file to s, deg/s, g or degC. For counts, take it from the data sheet."),
    element("p", {}, element("label", { for: "rate" }, "Samples per second, if there is no time column: "), rate),
    none, element("p", {}, read, " ",
      element("button", { onclick: actions.close }, "Another file")));
}
