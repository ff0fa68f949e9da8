// The 128 bytes as a grid, the list of their names, and the panel of the chosen byte.

import { button, h, hex, setText } from "./dom.js";
import { drawHistory } from "./screen.js";

const ACROSS = 16; // bytes of a row
const LEVELS = 6; // of heat
const MILLISECONDS_A_LEVEL = 130;

export class Grid {
  // `names(index)` are the names of a byte; `choose(index)` is called when a byte is chosen.
  constructor(names, choose) {
    Object.assign(this, { names, choose, current: 0 });
    this.shown = new Int16Array(128).fill(-1);
    this.changed = new Float64Array(128);
    this.levels = new Uint8Array(128);
    this.marks = Array.from({ length: 128 }, () => "");
    this.cells = Array.from({ length: 128 }, (_, index) => this.#cell(index));
    const head = (role, text, label) => h("span", { class: "address", role, "aria-label": label }, text);
    const columns = Array.from({ length: ACROSS }, (_, column) => head("columnheader", hex(column).slice(1), `column ${hex(column).slice(1)}`));
    const rows = Array.from({ length: 128 / ACROSS }, (_, row) =>
      h("div", { class: "row", role: "row" }, head("rowheader", hex(128 + ACROSS * row), `addresses from $${hex(128 + ACROSS * row)}`),
        ...this.cells.slice(ACROSS * row, ACROSS * row + ACROSS)));
    const grid = h("div", { class: "grid", role: "grid", "aria-label": "The 128 bytes of RAM" },
      h("div", { class: "row", role: "row" }, head("columnheader", "", "address"), ...columns), ...rows);
    this.tip = h("div", { class: "tip", hidden: true, "aria-hidden": "true" }); // cells have its text as their label
    this.element = h("div", { class: "memory" }, grid, this.tip);
    grid.addEventListener("keydown", (event) => this.#key(event));
    grid.addEventListener("focusin", () => this.#tipOfFocus());
    grid.addEventListener("focusout", () => this.hideTip());
    // A finger leaves the cell when it is lifted; `hideTip` is called at its next touch.
    grid.addEventListener("pointerleave", (event) => event.pointerType !== "touch" && this.#tipOfFocus());
    this.name();
  }

  #cell(index) {
    const cell = h("button", { type: "button", class: "cell", role: "gridcell", tabIndex: index ? -1 : 0 }, h("b"));
    cell.addEventListener("pointerenter", () => this.#showTip(index));
    cell.onclick = () => {
      this.select(index, true);
      this.#showTip(index);
    };
    return cell;
  }

  #text(index) {
    const names = this.names(index);
    return `byte ${index}, address $${hex(128 + index)}${names.length ? `: ${names.join(", ")}` : ""}`;
  }

  // A cell has no room for names. Its tip has them, at the pointer and at the focus.
  #showTip(index) {
    const { tip, element } = this;
    const cell = this.cells[index];
    setText(tip, this.#text(index));
    tip.hidden = false;
    const middle = cell.offsetLeft + (cell.offsetWidth - tip.offsetWidth) / 2;
    tip.style.left = `${Math.max(0, Math.min(middle, element.clientWidth - tip.offsetWidth))}px`;
    tip.style.top = `${cell.offsetTop - tip.offsetHeight - 5}px`;
  }

  #tipOfFocus() {
    const index = this.cells.findIndex((cell) => cell.matches(":focus-visible"));
    if (index < 0) this.hideTip();
    else this.#showTip(index);
  }

  hideTip() {
    this.tip.hidden = true;
  }

  name() {
    this.cells.forEach((cell, index) => {
      cell.setAttribute("aria-label", this.#text(index));
      cell.classList.toggle("named", this.names(index).length > 0);
    });
  }

  select(index, tell) {
    this.cells[this.current].tabIndex = -1;
    this.cells[this.current].classList.remove("chosen");
    this.current = index;
    this.cells[index].tabIndex = 0;
    this.cells[index].classList.add("chosen");
    if (tell) this.choose(index);
  }

  #key(event) {
    const moves = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -ACROSS, ArrowDown: ACROSS, PageUp: -32, PageDown: 32 };
    let next = this.current + (moves[event.key] ?? 0);
    if (event.key === "Home") next = this.current - (this.current % ACROSS);
    else if (event.key === "End") next = this.current - (this.current % ACROSS) + ACROSS - 1;
    else if (!(event.key in moves)) return;
    event.preventDefault();
    event.stopPropagation();
    if (next < 0 || next > 127) return;
    this.select(next, true);
    this.cells[next].focus();
  }

  // Marks are "frozen", "watched", "lit" and "found" sets of indices.
  mark(marks) {
    for (let index = 0; index < 128; index++) {
      const mark = Object.keys(marks).filter((name) => marks[name].has(index)).join(" ");
      if (mark === this.marks[index]) continue;
      for (const name of Object.keys(marks)) this.cells[index].classList.toggle(name, marks[name].has(index));
      this.marks[index] = mark;
    }
  }

  draw(ram, now, moved) {
    const { shown, changed, levels, cells } = this;
    for (let index = 0; index < 128; index++) {
      const value = ram[index];
      if (shown[index] !== value) {
        cells[index].firstChild.textContent = hex(value);
        if (shown[index] >= 0 && !moved) changed[index] = now;
        shown[index] = value;
      }
      const age = changed[index] ? (now - changed[index]) / MILLISECONDS_A_LEVEL : LEVELS;
      const level = age >= LEVELS ? 0 : LEVELS - Math.floor(age);
      if (level !== levels[index]) {
        cells[index].dataset.heat = level;
        levels[index] = level;
      }
    }
  }
}

// All names with their values: those of objects first, then series such as block_bits_0 to block_bits_35.
export class NameList {
  constructor(names, choose) {
    Object.assign(this, { names, choose });
    this.element = h("ul", { class: "names", "aria-label": "Names of bytes", tabIndex: 0 });
    this.name();
  }

  name() {
    const known = Array.from({ length: 128 }, (_, index) => this.names(index).map((name) => ({ name, index }))).flat();
    const series = ({ name }) => name.replace(/\d+$/, "");
    const sizes = new Map();
    for (const one of known) sizes.set(series(one), (sizes.get(series(one)) ?? 0) + 1);
    known.sort((one, other) => (sizes.get(series(one)) > 4) - (sizes.get(series(other)) > 4) || one.index - other.index);
    this.rows = known.map(({ name, index }) => ({ name, index, value: h("output") }));
    this.element.hidden = !known.length;
    this.element.replaceChildren(...this.rows.map(({ name, index, value }) => h("li", {},
      button(name, `byte ${index}, address $${hex(128 + index)}`, () => this.choose(index), { class: "link" }), value)));
  }

  // The value of a label, "-" where its object is not on the screen; or the byte of a name without a value of its own.
  draw(ram, labels) {
    for (const { name, index, value } of this.rows) setText(value, `${(Object.hasOwn(labels, name) ? labels[name] : ram[index]) ?? "-"}`);
  }
}

export class BytePanel {
  constructor(send, names, facts) {
    Object.assign(this, { send, names, facts, index: null });
    this.dark = () => {}; // called when pixels no longer light up
    this.title = h("h2", {}, "Choose a byte");
    this.value = h("output", { class: "value" });
    this.range = h("span", { class: "dim" });
    this.chart = h("canvas", { class: "history", role: "img", "aria-label": "history of the byte, four seconds" });
    this.input = h("input", { type: "number", min: 0, max: 255, required: true, id: "poke-value", "aria-label": "new value of the byte" });
    this.freeze = button("Freeze", "hold the byte at its value after every frame (X)", () => this.toggleFreeze(), { "aria-pressed": "false" });
    this.watch = button("Watch", "put the byte on the watch list (K)", () => this.toggleWatch(), { "aria-pressed": "false" });
    this.light = button("Show pixels", "light up the pixels that this byte causes in this state (L)", () => this.toggleLight(), { "aria-pressed": "false" });
    this.nameInput = h("input", { type: "text", maxLength: 40, pattern: "[A-Za-z_][A-Za-z0-9_]*", "aria-label": "your name of the byte", placeholder: "your name for it" });
    this.note = h("p", { class: "dim note", role: "status" });
    const poke = h("form", { class: "line", onsubmit: (event) => this.#poke(event) },
      button("−", "one less", () => this.#add(-1), { "aria-label": "one less" }),
      this.input,
      button("+", "one more", () => this.#add(1), { "aria-label": "one more" }),
      h("button", { type: "submit", class: "primary", title: "write the value (Enter)" }, "Poke"),
      this.freeze, this.watch, this.light);
    const naming = h("form", { class: "line naming", onsubmit: (event) => this.#name(event) }, this.nameInput,
      h("button", { type: "submit", title: "an empty name removes it" }, "Name it"));
    this.fields = h("fieldset", { disabled: true, class: "bare" }, poke, naming);
    this.element = h("section", { class: "card byte", "aria-label": "The chosen byte" },
      h("div", { class: "head" }, this.title, this.value, this.range), this.chart, this.fields, this.note);
  }

  select(index) {
    this.index = index;
    if (this.lit) this.dark();
    this.fields.disabled = index == null;
    this.fresh = true;
    this.lit = false;
    this.light.setAttribute("aria-pressed", "false");
    this.say("");
    this.name();
  }

  // Show a sentence about the byte, and the sentence of the causal map.
  say(text) {
    setText(this.note, [text, this.facts[this.index]].filter(Boolean).join(" "));
  }

  name() {
    const { index } = this;
    if (index == null) return;
    const names = this.names(index);
    setText(this.title, names[0] ?? `byte ${index}`);
    this.subtitle = `${names[0] ? `byte ${index} · ` : ""}$${hex(128 + index)}`;
  }

  state(state) {
    const { index } = this;
    this.frozen = index != null && index in state.frozen;
    this.watched = state.watched.includes(index);
    this.freeze.setAttribute("aria-pressed", this.frozen);
    setText(this.freeze, this.frozen ? `Frozen at ${state.frozen[index]}` : "Freeze");
    this.watch.setAttribute("aria-pressed", this.watched);
    if (document.activeElement !== this.nameInput) this.nameInput.value = state.names[index] ?? "";
    this.name();
  }

  draw(ram, history, span, colours, labels) {
    const { index } = this;
    if (index == null) return;
    const value = ram[index];
    const label = this.names(index).find((name) => labels?.[name] != null && labels[name] !== value);
    setText(this.value, `${value}${label ? ` → ${labels[label]}` : ""}`);
    const bounds = drawHistory(this.chart, history, span, colours.accent, colours.line);
    setText(this.range, `${this.subtitle} · ${value.toString(2).padStart(8, "0")}${bounds ? ` · ${bounds.low}–${bounds.high}` : ""}`);
    if (this.fresh && document.activeElement !== this.input) {
      this.input.value = value;
      this.fresh = false;
    }
    this.now = value;
  }

  toggleFreeze() {
    if (this.index == null) return;
    this.send({ do: this.frozen ? "release" : "freeze", index: this.index });
  }

  toggleWatch() {
    if (this.index != null) this.send({ do: "watch", index: this.index, on: !this.watched });
  }

  toggleLight() {
    if (this.index == null) return;
    this.lit = !this.lit;
    this.light.setAttribute("aria-pressed", this.lit);
    if (this.lit) this.send({ do: "pixels", index: this.index });
    else this.dark();
  }

  #add(by) {
    this.input.value = (this.now + by + 256) % 256;
    this.#poke();
  }

  #poke(event) {
    event?.preventDefault();
    this.send({ do: "poke", index: this.index, value: Number(this.input.value) });
  }

  #name(event) {
    event.preventDefault();
    this.send({ do: "name", index: this.index, name: this.nameInput.value });
  }
}
