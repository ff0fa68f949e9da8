// The panel of the game: its players, modes and difficulties, with the words of its manual.

import { choice, fill } from "./controls.js";
import { button, h } from "./dom.js";
import { settingsOf } from "./play.js";

export class GamePanel {
  constructor(app) {
    this.app = app;
    this.players = choice("Players", [], () => this.#fill());
    this.mode = choice("Mode", [], () => {});
    this.difficulty = choice("Difficulty", [], () => {});
    this.text = h("div", { class: "manual" });
    this.element = h("details", { class: "card", id: "game" }, h("summary", {}, "Game"), this.text,
      h("div", { class: "line" }, this.players.element, this.mode.element, this.difficulty.element,
        button("Begin with these", "A new game", () => app.attempt(() => app.restart(this.#settings())))));
  }

  /** Shows another game. */
  show(entry) {
    this.entry = entry;
    fill(this.players.select, entry.two_players ? [[1, "1"], [2, "2"]] : [[1, "1"]]);
    const { manual, notes, title } = entry;
    const said = [manual?.description, ...notes].filter(Boolean);
    const head = [manual?.title ?? title, manual?.year, manual?.maker].filter(Boolean).join(", ");
    this.text.replaceChildren(h("h3", {}, head), ...said.map((text) => h("p", {}, text)));
    this.#fill();
  }

  #fill() {
    const { manual, two_players: two } = this.entry;
    const several = this.players.select.value === "2";
    const { modes, difficulties, default_mode: usual } = several ? two : this.entry;
    const named = (words) => (value) => [value, words?.[value] ? `${value}: ${words[value]}` : String(value)];
    fill(this.mode.select, modes.map(named(several ? manual?.multiplayer_modes : manual?.modes)));
    this.mode.select.value = String(usual);
    fill(this.difficulty.select, difficulties.map(named(manual?.difficulties)));
  }

  #settings() {
    const [players, mode, difficulty] = [this.players, this.mode, this.difficulty].map(({ select }) => Number(select.value));
    return settingsOf(this.entry, players, { mode, difficulty });
  }
}
