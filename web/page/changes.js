// What the reader has changed in the RAM of a game: pokes, bytes that are held, interventions. The newest can be undone.

export class Changes {
  #writes = []; // {name, slots, from, until}: frames between which the session has the writes; until null, to the present
  #undo = []; // {frame, name} ends writes, {frame, index, value} restores a byte

  constructor(play) {
    Object.assign(this, { play, frame: 0 });
  }

  get #session() { return this.play.session; }

  poke(index, value) {
    const old = this.#session.ram()[index];
    this.#session.poke(index, value);
    this.#undo.push({ frame: this.frame, index, value: old });
  }

  /** Adds writes under a name: definitions in JSON. */
  add(name, definitions) {
    const slots = [];
    try {
      for (const definition of definitions) slots.push(this.#session.addWrite(definition, true));
    } catch (error) {
      for (const slot of slots) this.#session.removeWrite(slot);
      throw error;
    }
    this.#writes.push({ name, slots, from: this.frame, until: null });
    this.#undo.push({ frame: this.frame, name });
  }

  /** The names of the writes that are in force. */
  get inForce() { return this.#writes.filter(({ until }) => until === null).map(({ name }) => name); }

  /** All that is known of the changes, as values of JSON, which a later session of the same game takes over. */
  get kept() { return { frame: this.frame, writes: this.#writes, undo: this.#undo }; }

  takeOver({ frame, writes, undo }) {
    this.frame = frame;
    this.#writes = writes;
    this.#undo = undo;
  }

  has(name) { return this.#active(name) !== undefined; }

  /** Ends the writes of a name. */
  remove(name) {
    const write = this.#active(name);
    if (!write) return;
    for (const slot of write.slots) this.#session.removeWrite(slot);
    write.until = this.frame;
  }

  freeze(index, value) { this.add(String(index), [JSON.stringify({ to: index, value, when: "held" })]); }

  get canUndo() { return this.#undo.length > 0; }

  undo() {
    const last = this.#undo.pop();
    if (last?.name) this.remove(last.name);
    else if (last) this.#session.poke(last.index, last.value);
  }

  /** The play has taken a frame back, and its session has the writes of that time. */
  goBack() {
    this.frame -= 1;
    this.#writes = this.#writes.filter(({ from }) => from <= this.frame);
    for (const write of this.#writes) if (write.until > this.frame) write.until = null;
    this.#undo = this.#undo.filter(({ frame }) => frame <= this.frame);
  }

  #active(name) { return this.#writes.find((write) => write.name === name && write.until === null); }
}
