// The panel of RAM: a grid of all bytes, the labels with their values, a byte to write or to hold, interventions, objects
// on the screen, and a fork. All that it shows of a game is from the table and the core.

import { button, h, hex, setText } from "./dom.js";

const COLUMNS = 16, BYTES = 128;
const MOVES = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -COLUMNS, ArrowDown: COLUMNS };

export class RamPanel {
  chosen = 0;

  constructor(app) {
    this.app = app;
    this.cells = Array.from({ length: BYTES }, (_, index) => this.#cell(index));
    this.grid = h("div", { class: "grid", role: "group", "aria-label": "The 128 bytes of RAM" }, ...this.cells);
    this.grid.addEventListener("keydown", (event) => this.#move(event));
    this.title = h("h3", {});
    this.value = h("input", { type: "number", min: 0, max: 255, value: 0, "aria-label": "New value, 0 to 255" });
    const does = (text, title, call) => button(text, title, () => app.attempt(call));
    this.freeze = does("Freeze", "Hold the value", () => app.toggleFreeze(this.chosen, this.#number()));
    this.undo = does("Undo", "Undo the last change: Z", () => app.undo());
    this.objects = does("Objects", "Objects on the screen: O", () => app.toggleObjects());
    this.fork = does("Fork", "Go on beside this game, without later changes: V", () => app.toggleFork());
    this.form = h("form", { class: "line", onsubmit: (event) => this.#poke(event) }, this.value,
      h("button", { type: "submit" }, "Poke"), this.freeze, this.undo, this.objects, this.fork);
    this.missing = h("p", {});
    this.labels = h("tbody", {});
    this.interventions = h("div", { class: "interventions" });
    this.content = h("div", { class: "ram" },
      h("div", {}, this.grid, this.title, this.form, this.interventions),
      h("div", { class: "labels", tabIndex: 0, role: "region", "aria-label": "Labels" },
        h("table", {}, h("thead", {}, h("tr", {}, ...["Name", "Byte", "Value"].map((text) => h("th", {}, text)))),
          this.labels)));
    this.element = h("details", { class: "card", id: "ram" }, h("summary", {}, "RAM"), this.missing, this.content);
  }

  #cell(index) {
    return h("button", { type: "button", class: "cell", tabIndex: index ? -1 : 0, onclick: () => this.choose(index) }, "00");
  }

  #number() {
    const value = this.value.valueAsNumber;
    if (Number.isInteger(value) && value >= 0 && value <= 255) return value;
    throw new Error("The value of a byte is a number from 0 to 255.");
  }

  #poke(event) {
    event.preventDefault();
    this.app.attempt(() => this.app.poke(this.chosen, this.#number()));
  }

  #move(event) {
    const to = this.chosen + (MOVES[event.code] ?? NaN);
    if (!(to >= 0 && to < BYTES)) return;
    event.preventDefault();
    event.stopPropagation();
    this.choose(to);
    this.cells[to].focus();
  }

  /** Shows another game. */
  show(entry) {
    this.entry = entry;
    this.values = entry.labels.map(() => h("td", {}));
    this.labels.replaceChildren(...entry.labels.map(({ name, index }, i) => h("tr", {},
      h("td", {}, button(name, "Choose the byte", () => this.choose(index), { class: "link", disabled: index >= BYTES })),
      h("td", {}, String(index)), this.values[i])));
    const names = Array.from({ length: BYTES }, () => []);
    for (const { name, index } of entry.labels) if (index < BYTES) names[index].push(name);
    this.names = names.map((found) => found.join(", "));
    this.cells.forEach((cell, index) => {
      cell.title = this.names[index] ? `${index}: ${this.names[index]}` : String(index);
      cell.setAttribute("aria-label", `Byte ${cell.title}`);
      cell.classList.toggle("named", this.names[index] !== "");
    });
    this.boxes = entry.interventions.map(({ name, description, writes }) => {
      const box = h("input", { type: "checkbox" });
      box.addEventListener("change", () => this.app.attempt(() => this.app.toggleIntervention(name, writes)));
      return { name, box, element: h("label", { title: description }, box, h("span", {}, name.replaceAll("_", " "))) };
    });
    this.interventions.replaceChildren(...this.boxes.map(({ element }) => element));
    this.choose(this.chosen);
  }

  choose(index) {
    this.cells[this.chosen].tabIndex = -1;
    this.chosen = index;
    this.cells[index].tabIndex = 0;
    if (!this.app.play.isFilm) this.value.value = this.app.play.session.ram()[index];
    this.cells.forEach((cell, i) => cell.classList.toggle("chosen", i === index));
  }

  draw({ play, objectsShown }) {
    if (!this.element.open) return;
    this.missing.hidden = !play.isFilm;
    this.content.hidden = play.isFilm;
    if (play.isFilm) return setText(this.missing, `A film has no RAM: the page needs the ROM of ${play.entry.title} to show it.`);
    const ram = play.session.ram().slice();
    const { changes, isReplay } = play;
    ram.forEach((value, index) => {
      setText(this.cells[index], hex(value));
      this.cells[index].classList.toggle("frozen", changes.has(String(index)));
    });
    play.labels.forEach((value, i) => setText(this.values[i], value === null ? "-" : String(value)));
    const name = this.names[this.chosen];
    setText(this.title, `Byte ${this.chosen}${name ? ` (${name})` : ""}: ${ram[this.chosen]}`);
    setText(this.freeze, changes.has(String(this.chosen)) ? "Release" : "Freeze");
    setText(this.fork, play.fork ? "Close the fork" : "Fork");
    this.objects.setAttribute("aria-pressed", String(objectsShown));
    this.undo.disabled = !changes.canUndo;
    for (const element of [...this.form.elements, ...this.boxes.map(({ box }) => box)])
      if (element !== this.objects && element !== this.undo) element.disabled = isReplay;
    for (const { name: one, box } of this.boxes) box.checked = changes.has(one);
  }
}
