// Light or dark: as the system is, until somebody chooses.
const scheme = matchMedia("(prefers-color-scheme: dark)");
const kept = () => {
    try {
        return localStorage.getItem("davarlab-theme");
    } catch {
        return null;
    }
};

function apply() {
    document.documentElement.toggleAttribute(
        "data-dark",
        kept() ? kept() === "dark" : scheme.matches,
    );
}

export function other() {
    const dark = document.documentElement.hasAttribute("data-dark");
    try {
        localStorage.setItem("davarlab-theme", dark ? "light" : "dark");
    } catch {
        /* not allowed to keep it */
    }
    document.documentElement.toggleAttribute("data-dark", !dark);
}

apply();
scheme.addEventListener("change", apply);
