// What the page says to the server, and hears from it.
const token = new URLSearchParams(location.search).get("token") || "";
const headers = { "X-Davar-Token": token };

async function answered(response) {
  const text = await response.text();
  let data;
  try { data = JSON.parse(text); } catch { data = { error: text }; }
  if (!response.ok) throw new Error(data.error || response.statusText);
  return data;
}

let asked = new AbortController();

// What no server answers fails as "Gone": fetch() says only that it failed.
async function fetched(path, settings) {
  try {
    return await fetch(path, settings);
  } catch (why) {
    throw why.name === "AbortError" ? why : Object.assign(new Error("the server does not answer"), { name: "Gone" });
  }
}

export async function ask(what, given = {}) {
  return answered(await fetched(`/api/${what}?${new URLSearchParams(given)}`, { headers, signal: asked.signal }));
}

// What was asked and is not answered yet is not wanted any more: it fails as an AbortError, and so does all that is asked until recall().
export function forget() {
  asked.abort();
}

export function recall() {
  if (asked.signal.aborted) asked = new AbortController();
}

export async function act(what, given = {}) {
  return answered(await fetched(`/api/${what}`, {
    method: "POST", headers: { ...headers, "Content-Type": "application/json" }, body: JSON.stringify(given),
  }));
}

export async function drop(file, as = "recording") {
  return answered(await fetched(`/api/drop?${new URLSearchParams({ name: file.name, as })}`, { method: "POST", headers, body: file }));
}

export async function download(what, given, name) {
  const response = await fetched(`/api/${what}?${new URLSearchParams(given)}`, { headers });
  if (!response.ok) return answered(response);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await response.blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// Calls `heard` for every event, `lost` when the server has gone, and `back` when it answers again; it is tried every second.
export function listen(heard, lost, back) {
  const socket = new WebSocket(`ws://${location.host}/events?${new URLSearchParams({ token })}`);
  socket.onmessage = (message) => heard(JSON.parse(message.data));
  socket.onclose = () => { lost(); setTimeout(() => listen(heard, lost, back), 1000); };
  socket.onopen = () => { back(); heard({ changed: Infinity }); };
}
