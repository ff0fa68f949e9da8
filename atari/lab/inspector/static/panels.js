// The panels below: search, interventions, watch list, changes, export.

import { button, h, hex, setText } from "./dom.js";
import { drawHistory } from "./screen.js";

export class Tabs {
  constructor(panels) {
    this.panels = panels;
    this.tabs = panels.map(([name], at) =>
      h("button", { type: "button", role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`, onclick: () => this.show(at) }, name));
    this.bodies = panels.map(([name, panel]) =>
      h("div", { role: "tabpanel", id: `panel-${name}`, "aria-labelledby": `tab-${name}`, class: "panel" }, panel.element));
    const list = h("div", { class: "tabs", role: "tablist", "aria-label": "Tools" }, ...this.tabs);
    list.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!by) return;
      event.preventDefault();
      event.stopPropagation();
      const next = (this.at + by + this.tabs.length) % this.tabs.length;
      this.show(next);
      this.tabs[next].focus();
    });
    this.element = h("section", { class: "card tools", "aria-label": "Tools" }, list, ...this.bodies);
    this.show(0);
  }

  show(at) {
    this.at = at;
    this.tabs.forEach((tab, i) => {
      tab.setAttribute("aria-selected", i === at);
      tab.tabIndex = i === at ? 0 : -1;
      this.bodies[i].hidden = i !== at;
    });
  }

  count(at, number) {
    setText(this.tabs[at], this.panels[at][0] + (number ? ` ${number}` : ""));
  }
}

export class SearchPanel {
  constructor(send, names, choose) {
    Object.assign(this, { names, choose });
    const filter = (name, ...inputs) => () => {
      if (inputs.every((input) => input.reportValidity())) {
        send({ do: "filter", name, ...(inputs[0] && { low: Number(inputs[0].value) }), ...(inputs[1] && { high: Number(inputs[1].value) }) });
      }
    };
    const number = (label) => h("input", { type: "number", min: 0, max: 255, required: true, value: 0, "aria-label": label });
    this.number = number("number");
    this.number.max = 99999999;
    this.upper = number("second number, for between");
    this.upper.value = 255;
    const simple = { changed: "≠ changed", unchanged: "= unchanged", increased: "↑ increased", decreased: "↓ decreased" };
    this.undo = button("Back", "take the last filter back", () => send({ do: "undo_filter" }), { "data-filter": "undo" });
    this.status = h("p", { class: "status", role: "status" });
    this.list = h("tbody");
    this.table = h("table", {}, h("thead", {}, h("tr", {}, ...["byte", "name", "before", "now"].map((text) => h("th", { scope: "col" } , text)))), this.list);
    this.element = h("div", {},
      h("div", { class: "line" }, ...Object.entries(simple).map(([name, text]) =>
        button(text, `keep the bytes that have ${name} since the last filter`, filter(name), { "data-filter": name }))),
      h("div", { class: "line" }, this.number,
        button("equals", "keep the bytes with this value", filter("equals", this.number), { "data-filter": "equals" }),
        button("BCD", "keep the decimal numbers that are this one, such as a score, in one or more bytes", filter("bcd", this.number), { "data-filter": "bcd" }),
        button("between", "keep the bytes from the first to the second number", filter("between", this.number, this.upper), { "data-filter": "between" }),
        this.upper,
        button("follows score", "keep the bytes that have followed the score over the filters so far, up or down", filter("correlates"), { "data-filter": "correlates" }),
        this.undo,
        button("New search", "all 128 bytes again", () => send({ do: "new_search" }), { "data-filter": "new" })),
      this.status, h("div", { class: "scroll" }, this.table));
  }

  state({ places, left, before, applied }) {
    this.places = applied.length ? places : [];
    setText(this.status, applied.length
      ? `${left} ${left === 1 ? "candidate" : "candidates"} left after ${applied.slice(-5).join(", ")}`
      : "Play, then say what has happened to the value that you look for.");
    this.table.hidden = !this.places.length;
    this.undo.disabled = !applied.length;
    this.list.replaceChildren(...this.places.map(([text, bytes]) => h("tr", {},
      h("td", {}, button(bytes.length > 1 ? text : `${bytes[0]}`, "choose it", () => this.choose(bytes[0]), { class: "link", "data-byte": bytes[0] })),
      h("td", {}, this.names(bytes[0])[0] ?? ""), h("td", {}, this.#value(bytes, before)), h("td", { class: "now" }))));
  }

  // A byte's value, or the digits of a decimal number of several bytes, whose lowest digits come first.
  #value(bytes, ram) {
    return bytes.length > 1 ? bytes.map((index) => hex(ram[index])).reverse().join("") : `${ram[bytes[0]]}`;
  }

  draw(ram) {
    this.places?.forEach(([, bytes], row) => setText(this.list.children[row].lastChild, this.#value(bytes, ram)));
  }
}

// The changes of the game that the package has. Those of the task stay on.
export class InterventionPanel {
  constructor(send, known, ofTask) {
    const row = (name, about, properties) => {
      const box = h("input", { type: "checkbox", ...properties });
      box.onchange = () => send({ do: "intervene", name, on: box.checked });
      return { name, box, element: h("label", {}, box, h("span", {}, h("b", {}, name), h("span", { class: "dim" }, ` ${about}`))) };
    };
    const fixed = Object.entries(ofTask).map(([name, about]) => row(name, about, { checked: true, disabled: true }));
    this.rows = Object.entries(known).map(([name, about]) => row(name, about, {}));
    this.element = h("section", { class: "card interventions", "aria-label": "Interventions", hidden: !fixed.length && !this.rows.length },
      h("h2", {}, "Interventions"), h("div", { class: "scroll" }, ...[...fixed, ...this.rows].map(({ element }) => element)));
  }

  state({ interventions }) {
    for (const { name, box } of this.rows) box.checked = interventions.includes(name);
  }
}

export class WatchPanel {
  constructor(send, names, choose) {
    Object.assign(this, { send, names, choose });
    this.rows = new Map();
    this.empty = h("p", { class: "status" }, "Choose a byte and press Watch (K): its history stays in sight here.");
    this.element = h("section", { class: "card watches", "aria-label": "Watch list" }, h("h2", {}, "Watch"), this.empty);
  }

  state({ watched, frozen }) {
    for (const [index, row] of this.rows) {
      if (!watched.includes(index)) {
        row.element.remove();
        this.rows.delete(index);
      }
    }
    for (const index of watched) {
      if (!this.rows.has(index)) {
        const row = { name: h("span"), value: h("output"), chart: h("canvas", { class: "spark", "aria-hidden": "true" }) };
        row.element = h("div", { class: "watch" },
          button("", "choose this byte", () => this.choose(index), { class: "link" }), row.chart, row.value,
          button("×", "take it off the list", () => this.send({ do: "watch", index, on: false }), { class: "bare-button", "aria-label": `do not watch byte ${index}` }));
        row.name = row.element.firstChild;
        this.rows.set(index, row);
        this.element.append(row.element);
      }
      setText(this.rows.get(index).name, `${this.names(index)[0] ?? `byte ${index}`}${index in frozen ? " ❄" : ""}`);
    }
    this.empty.hidden = watched.length > 0;
  }

  draw(ram, histories, span, colours) {
    for (const [index, row] of this.rows) {
      setText(row.value, `${ram[index]}`);
      if (row.chart.clientWidth) drawHistory(row.chart, histories.get(index), span, colours.accent, null);
    }
  }
}

export class ChangesPanel {
  constructor(send, names) {
    Object.assign(this, { send, names });
    this.list = h("ol", { class: "changes" });
    this.undo = button("Undo the last change", "Z", () => send({ do: "undo" }));
    this.frozen = h("div", { class: "line" });
    this.element = h("div", {}, this.frozen, this.list, h("div", { class: "line" }, this.undo));
  }

  state({ changes, frozen }) {
    const name = (index) => this.names(index)[0] ?? `byte ${index}`;
    this.undo.disabled = !changes.length;
    this.frozen.replaceChildren(...Object.entries(frozen).map(([index, value]) =>
      button(`${name(Number(index))} = ${value} ❄ ×`, "release", () => this.send({ do: "release", index: Number(index) }))));
    const say = {
      poke: (c) => `${c.old} → ${c.new}`, freeze: (c) => (c.new == null ? "released" : `frozen at ${c.new}`), intervention: (c) => (c.on ? "on" : "off"),
    };
    this.list.replaceChildren(...changes.slice().reverse().map((change) => h("li", {},
      h("span", { class: "dim" }, `frame ${change.frame}`), ` ${change.name ?? name(change.index)} `, h("b", {}, say[change.kind](change)))));
    if (!changes.length) this.list.append(h("li", { class: "status" }, "Nothing was changed yet."));
  }
}

export class ExportPanel {
  constructor(link, notify) {
    this.at = 0;
    const fetchFile = async (name, query) => {
      const response = await fetch(link.exportUrl(name, query));
      if (!response.ok) return notify(await response.text(), true);
      const url = URL.createObjectURL(await response.blob());
      const anchor = h("a", { href: url, download: /filename="(.*)"/.exec(response.headers.get("Content-Disposition"))?.[1] ?? name });
      anchor.click();
      setTimeout(() => URL.revokeObjectURL(url), 10_000);
    };
    const seconds = h("input", { type: "number", min: 1, max: 60, value: 10, required: true, "aria-label": "seconds of the clip" });
    const clip = () => {
      if (!seconds.reportValidity()) return;
      const start = Math.max(this.first, this.at - 60 * Number(seconds.value));
      fetchFile("clip.mp4", `start=${start}&stop=${this.at}`);
    };
    const file = (text, name, title) => button(text, title, () => fetchFile(name), { "data-export": name });
    this.element = link.exportUrl ? h("div", { class: "exports" },
      h("div", { class: "line" }, file("Labels", "labels.toml", "the names that you gave, for a game definition"), h("span", { class: "dim" }, "your names, TOML")),
      h("div", { class: "line" }, file("Interventions", "interventions.toml", "what you froze, poked and switched on"), h("span", { class: "dim" }, "what you froze, poked and switched on, TOML")),
      h("div", { class: "line" }, file("Replay", "replay.a26r", "what was played up to here"), h("span", { class: "dim" }, "all that was played up to here, .a26r")),
      h("div", { class: "line" }, button("Clip", "a video with sound", clip, { "data-export": "clip.mp4" }), "the last", seconds, h("span", { class: "dim" }, "seconds, MP4")))
      : h("p", { class: "status" }, "In a notebook: shown = show(env), then shown.export(folder).");
  }
}

export const HELP = [
  ["W A S D, arrows", "stick"], ["F, space", "fire"], ["P", "play or pause"], [", .", "a frame back, on"], ["[ ]", "a second back, on"],
  ["T", "take over: drop what was recorded after this frame"], ["R", "new game"], ["A key of the stick", "takes over, too"],
  ["G", "to the grid of bytes; arrows choose one"], ["/", "to the search"], ["E", "to the value of the byte; Enter pokes"],
  ["X", "freeze or release the byte"], ["K", "watch the byte"], ["L", "light up its pixels"], ["Z", "undo the last change"],
  ["V", "what if: fork, or close the fork"], ["O", "objects on the screen"], ["M", "agent or keyboard"], ["+ −", "zoom"], ["click", "a pixel: the bytes that cause it"], ["?", "this list"],
];

export function helpDialog() {
  const rows = HELP.map(([keys, text]) => h("tr", {}, h("th", { scope: "row" }, h("kbd", {}, keys)), h("td", {}, text)));
  const dialog = h("dialog", { class: "help", "aria-label": "Keyboard shortcuts" },
    h("h2", {}, "Keyboard"), h("table", {}, h("tbody", {}, ...rows)),
    h("p", { class: "dim" }, "After a click, the keys play the game. Tab moves the focus to the controls: Enter or Space presses a button there, and arrows move in lists, sliders and the grid. Escape returns to the game."),
    h("p", { class: "dim" }, `Addresses are in hexadecimal, a row's and a column's together: byte 49 is $${hex(128 + 49)}, in row B0 and column 1.`));
  dialog.append(button("Close", "Escape", () => dialog.close(), { class: "primary" }));
  return dialog;
}
