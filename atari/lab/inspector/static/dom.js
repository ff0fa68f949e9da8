// Elements of the page.

// An element with properties and children. `class`, `aria-*`, `role`, `for` and `data-*` are attributes.
export function h(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === "class") element.className = value;
    else if (/^(aria-|data-|role$|for$|list$)/.test(name)) element.setAttribute(name, value);
    else element[name] = value;
  }
  element.append(...children.filter((child) => child != null));
  return element;
}

export function button(text, title, onclick, properties = {}) {
  return h("button", { type: "button", title, onclick, ...properties }, text);
}

export const hex = (value) => value.toString(16).toUpperCase().padStart(2, "0");

// Set a text only where it changes: the page draws 60 times a second.
export function setText(element, text) {
  if (element.firstChild?.data !== text) element.textContent = text;
}
