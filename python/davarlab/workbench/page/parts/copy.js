// A button that copies a text.
import { element } from "/page/words.js";

// text(): what it copies; shown(): the element that shows it, which is selected where the browser allows no copy.
export function copyButton(id, label, text, shown) {
    const button = element(
        "button",
        {
            id,
            onclick: async () => {
                button.style.minWidth = `${button.offsetWidth}px`;
                try {
                    await navigator.clipboard.writeText(text());
                    button.textContent = "Copied";
                } catch {
                    getSelection().selectAllChildren(shown());
                    button.textContent = "Selected: press Ctrl+C";
                }
            },
        },
        label,
    );
    return button;
}
