// Requests to the server, and events from it.
const token = new URLSearchParams(location.search).get("token") || "";
const headers = { "X-Davar-Token": token };

async function answered(response) {
    const text = await response.text();
    let data;
    try {
        data = JSON.parse(text);
    } catch {
        data = { error: text };
    }
    if (!response.ok) throw new Error(data.error || response.statusText);
    return data;
}

let asked = new AbortController();

let away = false; // another program may have taken the port: nothing is sent there until it proves to be the server

// A request that no server answers fails with "Gone", because fetch() does not report the reason.
async function fetched(path, settings) {
    try {
        if (away) throw new Error();
        return await fetch(path, settings);
    } catch (why) {
        throw why.name === "AbortError"
            ? why
            : Object.assign(new Error("the server does not answer"), { name: "Gone" });
    }
}

// signal: null for a request that forget() does not cancel.
export async function ask(what, given = {}, signal = asked.signal) {
    return answered(
        await fetched(`/api/${what}?${new URLSearchParams(given)}`, { headers, signal }),
    );
}

// Cancels pending requests. They fail with an AbortError, as do new requests until recall().
export function forget() {
    asked.abort();
}

export function recall() {
    if (asked.signal.aborted) asked = new AbortController();
}

export async function act(what, given = {}) {
    return answered(
        await fetched(`/api/${what}`, {
            method: "POST",
            headers: { ...headers, "Content-Type": "application/json" },
            body: JSON.stringify(given),
        }),
    );
}

export async function drop(file, purpose = "recording") {
    return answered(
        await fetched(`/api/drop?${new URLSearchParams({ name: file.name, purpose })}`, {
            method: "POST",
            headers,
            body: file,
        }),
    );
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

const RETRY_MS = 1000,
    bytes = (text) => new TextEncoder().encode(text),
    hex = (data) => [...data].map((one) => one.toString(16).padStart(2, "0")).join("");

// Does the server that answers have the token of this tab. It is not sent before: another program may have taken the port. null: nobody answers.
async function ours() {
    const nonce = hex(crypto.getRandomValues(new Uint8Array(16)));
    let answer;
    try {
        answer = await (await fetch(`/proof?${new URLSearchParams({ nonce })}`)).text();
    } catch {
        return null;
    }
    const key = await crypto.subtle.importKey(
        "raw",
        bytes(token),
        { name: "HMAC", hash: "SHA-256" },
        false,
        ["sign"],
    );
    return answer === hex(new Uint8Array(await crypto.subtle.sign("HMAC", key, bytes(nonce))));
}

async function again(heard, lost, back) {
    const found = await ours();
    if (found) {
        listen(heard, lost, back);
        return;
    }
    lost(found === false);
    setTimeout(() => again(heard, lost, back), RETRY_MS);
}

// Calls `heard` for every event, `lost` when the server stops answering (true: another one answers), and `back` when it answers again. Retries every second.
export function listen(heard, lost, back) {
    const socket = new WebSocket(`ws://${location.host}/events?${new URLSearchParams({ token })}`);
    socket.onmessage = (message) => heard(JSON.parse(message.data));
    socket.onclose = () => {
        away = true;
        lost(false);
        setTimeout(() => again(heard, lost, back), RETRY_MS);
    };
    socket.onopen = () => {
        away = false;
        back();
        heard({ changed: Infinity });
    };
}
