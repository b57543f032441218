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

export async function ask(what, given = {}) {
  return answered(await fetch(`/api/${what}?${new URLSearchParams(given)}`, { headers, signal: asked.signal }));
}

// What was asked and is not answered yet is not wanted any more: it fails as an AbortError.
export function forget() {
  asked.abort();
  asked = new AbortController();
}

export async function act(what, given = {}) {
  return answered(await fetch(`/api/${what}`, {
    method: "POST", headers: { ...headers, "Content-Type": "application/json" }, body: JSON.stringify(given),
  }));
}

export async function drop(file, as = "recording") {
  return answered(await fetch(`/api/drop?${new URLSearchParams({ name: file.name, as })}`, { method: "POST", headers, body: file }));
}

export async function download(what, given, name) {
  const response = await fetch(`/api/${what}?${new URLSearchParams(given)}`, { headers });
  if (!response.ok) return answered(response);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await response.blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// Calls `heard` for every event; when the server has gone it waits for it to come back.
export function listen(heard, lost) {
  const socket = new WebSocket(`ws://${location.host}/events?${new URLSearchParams({ token })}`);
  socket.onmessage = (message) => heard(JSON.parse(message.data));
  socket.onclose = () => { lost(); setTimeout(() => listen(heard, lost), 1000); };
  socket.onopen = () => heard({ changed: Infinity });
}
