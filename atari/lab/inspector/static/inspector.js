// The inspector: shows the frames of a session, and sends it commands. page.js and widget.js mount it.

import { BytePanel, Grid, NameList } from "./bytes.js";
import { button, h, setText } from "./dom.js";
import { ChangesPanel, ExportPanel, helpDialog, InterventionPanel, SearchPanel, Tabs, WatchPanel } from "./panels.js";
import { bytesOf, paletteOf, parse, Screen } from "./screen.js";
import { TouchStick } from "./touch.js";

const MOST_QUEUED = 3; // frames that came while the page drew none; older ones are left out
const LIT_MILLISECONDS = 100; // until the pixels that light up are computed again
const NOTICE_MILLISECONDS = 6000;
const GAP = 12; // pixels between the screens of a fork
const WIDEST = 658; // pixels of a stage beside the RAM
const NEARLY = 0.8;

export function mount(root, link, hello, { keys }) {
  return new Inspector(root, link, hello, keys);
}

class Inspector {
  constructor(root, link, hello, keys) {
    Object.assign(this, { root, hello, keys, queue: [], held: new Set(), objects: [], values: {}, mark: null });
    Object.assign(this, { showObjects: false, drawn: 0, callbacks: 0, zoomChoice: 0 }); // as large as fits
    this.send = (message) => link.send(message);
    this.state = { names: {}, frozen: {}, watched: [], changes: [], interventions: [], selected: null };
    this.names = (index) => [this.state.names[index], ...(hello.labels[index] ?? [])].filter(Boolean);
    this.#build(link);
    this.stop = new AbortController();
    const { signal } = this.stop;
    keys.addEventListener("keydown", (event) => this.#keyDown(event), { signal });
    keys.addEventListener("keyup", (event) => this.#keyUp(event), { signal });
    keys.addEventListener("keydown", () => { this.byPointer = false; }, { signal, capture: true });
    root.addEventListener("pointerdown", () => { this.byPointer = true; this.grid.hideTip(); }, { signal, capture: true });
    root.addEventListener("mousedown", (event) => this.#mouseDown(event), { signal });
    root.addEventListener("change", (event) => this.#changed(event), { signal });
    window.addEventListener("blur", () => this.#releaseKeys(), { signal });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#readColours(), { signal });
    this.resized = new ResizeObserver(() => this.#resize());
    this.resized.observe(this.stage);
    root.atariLab = this; // for tests and for the console
    const loop = (now) => {
      if (signal.aborted) return;
      requestAnimationFrame(loop);
      this.callbacks++;
      this.#draw(now);
    };
    requestAnimationFrame(loop);
  }

  close() {
    this.stop.abort();
    this.resized.disconnect();
  }

  frame(buffer) {
    this.newest = { buffer, objects: this.objects, values: this.values };
    this.queue.push(this.newest);
    if (this.queue.length > MOST_QUEUED) this.queue.shift();
  }

  message(message) {
    if (message.state) this.#setState(message.state);
    if (message.objects && this.newest) Object.assign(this.newest, { objects: message.objects, values: message.values });
    if (message.error) this.notify(message.error, true);
    if (message.notice) this.notify(message.notice);
    if (message.pixels) this.#light(message.pixels);
    if (message.bytes) this.#causes(message.bytes);
  }

  notify(text, wrong = false) {
    this.toast.textContent = text;
    this.toast.classList.toggle("wrong", wrong);
    this.toast.classList.add("shown");
    clearTimeout(this.toastTimer);
    this.toastTimer = setTimeout(() => this.toast.classList.remove("shown"), NOTICE_MILLISECONDS);
  }

  #build(link) {
    const { hello, send } = this;
    const palette = paletteOf(hello.palette);
    this.main = new Screen(hello.height, palette, `the screen of ${hello.title}`);
    this.fork = new Screen(hello.height, palette, "the screen of the fork");
    this.main.element.tabIndex = 0;
    for (const screen of [this.main, this.fork]) {
      screen.element.addEventListener("click", (event) => {
        this.mark = screen.pixelAt(event);
        send({ do: "bytes", ...this.mark });
      });
    }
    this.score = h("b");
    this.lives = h("b");
    this.pace = h("span", { class: "dim pace", title: "frames drawn a second" });
    this.previews = [0, 1].map(() => h("span", { class: "badge", hidden: true, title: "the next frame without input: RAM was changed, and nothing was played since" }, "preview"));
    this.mainFigure = h("figure", {}, this.main.element, h("figcaption", {}, h("span", { class: "which" }), this.previews[0]));
    this.forkFigure = h("figure", { hidden: true }, this.fork.element, h("figcaption", {}, h("span", { class: "which" }, "what if"), this.previews[1]));
    this.stage = h("div", { class: "stage" }, this.mainFigure, this.forkFigure);

    const step = (frames, text, title) => button(text, title, () => send({ do: "step", frames }), { "aria-label": title.replace(/ \(.*/, "") });
    this.playButton = button("▶ Play", "play or pause (P)", () => this.#toggle(), { class: "primary play" });
    this.slider = h("input", { type: "range", class: "time", min: 0, max: 0, value: 0, "aria-label": "time line, in frames" });
    this.slider.addEventListener("input", () => send({ do: "seek", frame: Number(this.slider.value) }));
    this.position = h("output", { class: "position" });
    this.speed = h("select", { "aria-label": "speed", onchange: () => send({ do: "speed", speed: Number(this.speed.value) }) },
      ...hello.speeds.map((speed) => h("option", { value: speed }, `${speed}×`)));
    this.speed.value = 1;
    this.zoom = h("select", { "aria-label": "zoom", onchange: () => this.#setZoom(Number(this.zoom.value)) },
      ...["fit", "1×", "2×", "3×", "4×"].map((text, value) => h("option", { value }, text)));
    this.takeButton = button("Take over", "drop what was recorded after this frame, and play on (T)", () => send({ do: "take_over" }), { disabled: true });
    this.objectsButton = button("Objects", "show the objects that labels know (O)", () => this.#toggleObjects(), { "aria-pressed": "false" });
    this.agentButton = button(hello.agent ?? "", "let the agent play, or the keyboard (M)", () => send({ do: "agent", on: !this.shown?.byAgent }), { hidden: !hello.agent, "aria-pressed": "false" });
    this.forkButton = button("What if …", "fork: play on in two copies; changes go to the second (V)", () => this.#toggleFork());
    this.keepButton = button("Keep the fork", "go on with the fork", () => send({ do: "close_fork", keep: true }), { hidden: true });
    this.differ = h("span", { class: "dim" });
    this.touch = new TouchStick(() => this.#stick());
    this.playCard = h("section", { class: "card play-card", "aria-label": "Screen" }, this.stage, this.touch.element,
      h("div", { class: "timeline" }, this.slider, this.position, this.speed),
      h("div", { class: "line transport" },
        step(-60, "◀◀", "a second back ([)"), step(-1, "❙◀", "a frame back (,)"), this.playButton, step(1, "▶❙", "a frame on (.)"), step(60, "▶▶", "a second on (])"),
        this.takeButton, button("New game", "begin a new game (R)", () => send({ do: "new_game" })),
        this.forkButton, this.objectsButton, this.agentButton, this.keepButton, this.differ));

    const choose = (index) => this.#choose(index);
    this.grid = new Grid(this.names, choose);
    this.list = new NameList(this.names, choose);
    this.byte = new BytePanel(send, this.names, hello.facts);
    this.byte.dark = () => this.#light(null);
    this.search = new SearchPanel(send, this.names, choose);
    this.watch = new WatchPanel(send, this.names, choose);
    this.interventions = new InterventionPanel(send, hello.interventions, hello.task_interventions);
    this.changes = new ChangesPanel(send, this.names);
    this.exports = new ExportPanel(link, (text, wrong) => this.notify(text, wrong));
    this.tabs = new Tabs([["Search", this.search], ["Changes", this.changes], ["Export", this.exports]]);
    this.help = helpDialog();
    this.toast = h("div", { class: "toast", role: "status", "aria-live": "polite" });
    const header = h("header", {}, h("h1", {}, hello.title), h("span", { class: "dim tag" }, "atari lab"),
      h("label", { class: "dim zoom" }, "zoom ", this.zoom),
      h("span", { class: "stat" }, "score ", this.score), h("span", { class: "stat" }, "lives ", this.lives), this.pace,
      button("?", "keyboard shortcuts (?)", () => this.help.showModal(), { class: "round", "aria-label": "keyboard shortcuts" }));
    this.root.replaceChildren(header,
      h("div", { class: "columns" },
        h("div", { class: "column" }, this.playCard, this.byte.element),
        h("div", { class: "column" }, h("section", { class: "card ram", "aria-label": "RAM" }, this.grid.element, this.list.element), this.tabs.element,
          this.interventions.element, this.watch.element)),
      this.help, this.toast);
    this.#readColours();
  }

  #setState(state) {
    const named = JSON.stringify(state.names) !== JSON.stringify(this.state.names);
    this.state = state;
    if (named) for (const each of [this.grid, this.list]) each.name();
    if (this.speed.value !== String(state.speed)) this.speed.value = state.speed;
    if (state.selected != null && this.byte.index == null) { // chosen in the tab before; later the page knows it first
      this.grid.select(state.selected, false);
      this.byte.select(state.selected);
    }
    for (const panel of [this.byte, this.interventions, this.watch, this.changes]) panel.state(state);
    this.search.state(state.search);
    this.tabs.count(1, Object.keys(state.frozen).length + state.interventions.length);
    this.#marks();
  }

  #marks() {
    const { search } = this.state;
    this.grid.mark({
      frozen: new Set(Object.keys(this.state.frozen).map(Number)),
      watched: new Set(this.state.watched),
      lit: this.found ?? new Set(),
      found: new Set(search?.candidates),
      differs: this.differing ?? new Set(),
    });
  }

  #choose(index) {
    const lit = this.byte.lit;
    this.grid.select(index, false);
    this.byte.select(index);
    this.byte.state(this.state);
    this.send({ do: "select", index });
    if (lit) this.byte.toggleLight();
  }

  #light(pixels) {
    if (pixels && (!this.byte.lit || pixels.index !== this.byte.index)) return; // the answer comes late
    const bits = pixels && bytesOf(pixels.bits);
    for (const screen of [this.main, this.fork]) screen.light(pixels?.count ? bits : null);
    const here = "of the next two frames depends on it in this state";
    this.byte.say(pixels == null ? "" : !pixels.count ? `No pixel ${here}: the game overwrites it, or does not draw it now.`
      : pixels.source === "state" ? `${pixels.count} pixels of the next two frames depend on it in this state.`
        : `No pixel ${here}. In others, by the causal map, these do.`);
  }

  #causes({ x, y, found, elsewhere }) {
    this.found = new Set(found);
    this.#marks();
    const names = (indices) => indices.slice(0, 6).map((index) => this.names(index)[0] ?? `byte ${index}`).join(", ");
    this.notify((found.length ? `Pixel ${x}, ${y} is caused by ${names(found)}.` : `No byte causes pixel ${x}, ${y} in this state.`)
      + (elsewhere.length ? ` In other states: ${names(elsewhere)}.` : ""));
    if (found.length) this.#choose(found[0]);
  }

  #toggle() {
    this.send({ do: this.shown?.playing ? "pause" : "play" });
  }

  #toggleFork() {
    this.send(this.shown?.fork ? { do: "close_fork", keep: false } : { do: "fork" });
  }

  #toggleObjects() {
    this.showObjects = !this.showObjects;
    this.objectsButton.setAttribute("aria-pressed", this.showObjects);
    if (this.showObjects && !this.objects.length) this.notify("No label knows where an object of this game is now.");
  }

  #setZoom(choice) {
    this.zoomChoice = Math.min(Math.max(choice, 0), 4);
    this.zoom.value = this.zoomChoice;
    this.#resize();
  }

  // One screen is enlarged by the whole number that fits. The screens of a fork are as large: beside each other where there
  // is nearly the room for that, otherwise one below the other.
  #resize() {
    const forked = !this.forkFigure.hidden;
    const width = this.stage.clientWidth;
    const room = forked ? Math.min(width, WIDEST) : width;
    const one = this.zoomChoice || Math.max(1, Math.min(Math.floor(room / 320), Math.floor((window.innerHeight - 210) / this.hello.height)));
    const beside = (width - GAP) / 640;
    const stacked = forked && beside < (this.zoomChoice ? one : NEARLY * one);
    const times = forked && !stacked ? Math.min(one, beside) : one;
    this.playCard.classList.toggle("stacked", stacked);
    if (times === this.times && window.devicePixelRatio === this.ratio) return;
    Object.assign(this, { times, ratio: window.devicePixelRatio });
    this.main.zoom(times);
    this.fork.zoom(times);
  }

  #readColours() {
    const style = getComputedStyle(this.root);
    this.colours = { accent: style.getPropertyValue("--accent"), line: style.getPropertyValue("--line") };
  }

  #draw(now) {
    const next = this.queue.shift();
    const before = this.shown;
    if (next) {
      this.drawn++;
      this.shown = parse(next.buffer, this.hello.history);
      this.current = next;
    }
    if (this.current) Object.assign(this, { objects: this.current.objects, values: this.current.values });
    const frame = this.shown;
    if (!frame) return;
    const ram = frame.fork?.ram ?? frame.ram;
    if (next) {
      this.main.draw(frame.screen);
      if (frame.fork) this.fork.draw(frame.fork.screen);
      const index = this.byte.index;
      this.byte.draw(ram, frame.histories.get(index), this.hello.history, this.colours, this.values);
      this.list.draw(ram, this.values);
      this.search.draw(ram);
      this.watch.draw(ram, frame.histories, this.hello.history, this.colours);
      this.#texts(frame, before);
    }
    if (this.byte.lit && frame.version !== this.litVersion && now - (this.litSince ?? 0) > LIT_MILLISECONDS) {
      this.send({ do: "pixels", index: this.byte.index });
      Object.assign(this, { litVersion: frame.version, litSince: now });
    }
    const moved = before && Math.abs(frame.at - before.at) > 30;
    this.grid.draw(ram, now, moved);
    const objects = this.showObjects ? this.objects : [];
    this.main.drawOverlay(frame.fork ? [] : objects, this.mark, now);
    if (frame.fork) this.fork.drawOverlay(objects, this.mark, now);
    this.#showPace(now, before);
  }

  // Show the frames drawn a second, or that the game is paused.
  #showPace(now, before) {
    const { playing } = this.shown;
    const switched = playing !== before?.playing;
    if (switched) setText(this.pace, playing ? "" : "paused");
    else if (now - this.paceSince <= 1000) return;
    else if (playing) setText(this.pace, `${Math.round((this.drawn - this.drawnBefore) * 1000 / (now - this.paceSince))} fps`);
    this.paceSince = now;
    this.drawnBefore = this.drawn;
  }

  #texts(frame, before) {
    const { fork } = frame;
    setText(this.score, fork ? `${frame.score.toLocaleString("en")} | ${fork.score.toLocaleString("en")}` : frame.score.toLocaleString("en"));
    setText(this.lives, `${frame.lives}`);
    setText(this.playButton, frame.playing ? "❚❚ Pause" : "▶ Play");
    this.slider.min = frame.first;
    this.slider.max = frame.end;
    if (document.activeElement !== this.slider || frame.playing || this.slider.value != frame.at) this.slider.value = frame.at;
    const seconds = (frames) => `${Math.floor(frames / 3600)}:${String(Math.floor(frames / 60) % 60).padStart(2, "0")}`;
    setText(this.position, `${frame.at.toLocaleString("en")} / ${frame.end.toLocaleString("en")}  ${seconds(frame.at)}`);
    this.exports.at = frame.at;
    this.exports.first = frame.first;
    this.takeButton.disabled = frame.at === frame.end;
    this.agentButton.setAttribute("aria-pressed", frame.byAgent);
    this.previews[0].hidden = !frame.preview;
    this.previews[1].hidden = !fork?.preview;
    if (!before || !!fork !== !!before.fork) {
      this.forkFigure.hidden = this.keepButton.hidden = !fork;
      setText(this.mainFigure.querySelector(".which"), fork ? "as it is" : "");
      setText(this.forkButton, fork ? "Close the fork" : "What if …");
      this.playCard.classList.toggle("forked", !!fork);
      this.#resize();
    }
    const differing = fork ? new Set([...fork.ram.keys()].filter((i) => fork.ram[i] !== frame.ram[i])) : null;
    if (fork || this.differing) {
      let pixels = 0;
      if (fork) for (let i = 0; i < fork.screen.length; i++) pixels += fork.screen[i] !== frame.screen[i];
      const count = (number, what) => `${number} ${what}${number === 1 ? "" : "s"}`;
      setText(this.differ, fork ? `${count(differing.size, "byte")} and ${count(pixels, "pixel")} differ` : "");
      this.differing = differing;
      this.#marks();
    }
  }

  #focusGame() {
    this.main.element.focus({ preventScroll: true });
  }

  // A button that is clicked does not take the focus: the next key is the game's, and Space is fire.
  #mouseDown(event) {
    if (!event.target.closest("button") || this.help.open) return;
    event.preventDefault();
    this.#focusGame();
  }

  // A list, a slider or a box that was set by the pointer gives the focus back.
  #changed({ target }) {
    if (this.byPointer && target.matches("select, input:is([type=range], [type=checkbox])")) this.#focusGame();
  }

  #stick() {
    const on = (...names) => names.some((name) => this.held.has(name));
    const { touch } = this;
    const vertical = on("w", "arrowup") - on("s", "arrowdown") || touch.vertical;
    const horizontal = on("d", "arrowright") - on("a", "arrowleft") || touch.horizontal;
    const message = { do: "hold", vertical, horizontal, fire: on("f", " ") || touch.fire };
    const key = JSON.stringify(message);
    if (key !== this.stick) this.send(message);
    this.stick = key;
  }

  #releaseKeys() {
    if (!this.held.size) return;
    this.held.clear();
    this.#stick();
  }

  #keyUp(event) {
    if (this.held.delete(event.key.toLowerCase())) this.#stick();
  }

  #keyDown(event) {
    const { target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || this.help.open) return;
    const typing = target.matches?.("input:not([type=range], [type=checkbox]), textarea, select");
    const control = target.matches?.("button, input, select");
    if (event.key === "Escape" && control) this.#focusGame();
    if (typing) return;
    const key = event.key.toLowerCase();
    const sticks = ["w", "a", "s", "d", "f", ...(control ? [] : ["arrowup", "arrowdown", "arrowleft", "arrowright", " "])];
    if (sticks.includes(key)) {
      event.preventDefault();
      this.held.add(key);
      this.#stick();
      return;
    }
    const { send } = this;
    const commands = {
      p: () => this.#toggle(), ".": () => send({ do: "step", frames: 1 }), ",": () => send({ do: "step", frames: -1 }),
      "]": () => send({ do: "step", frames: 60 }), "[": () => send({ do: "step", frames: -60 }), r: () => send({ do: "new_game" }),
      t: () => send({ do: "take_over" }), z: () => send({ do: "undo" }), v: () => this.#toggleFork(), o: () => this.#toggleObjects(),
      m: () => send({ do: "agent", on: !this.shown?.byAgent }), g: () => this.grid.cells[this.grid.current].focus(),
      e: () => this.byte.input.select(), x: () => this.byte.toggleFreeze(), k: () => this.byte.toggleWatch(), l: () => this.byte.toggleLight(),
      "/": () => { this.tabs.show(0); this.search.number.select(); }, "?": () => this.help.showModal(),
      "+": () => this.#setZoom(Math.floor(this.times) + 1), "=": () => this.#setZoom(Math.floor(this.times) + 1), "-": () => this.#setZoom(Math.max(1, Math.ceil(this.times) - 1)),
    };
    if (key in commands && (!event.repeat || ",.[]".includes(key))) {
      event.preventDefault();
      commands[key]();
    }
  }
}
