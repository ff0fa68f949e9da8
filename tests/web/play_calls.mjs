// Plays a game by a list of calls, and prints what each call shows or returns, as JSON.
import { Sums, base64Of, bytesOf, core, crc32, input } from "./node_tools.mjs";

const game = core.game(input.core, bytesOf(input.image));
const session = game.play(input.options);
const slots = [];

/** Check sums of RAM, screen and sound, and the numbers of a frame; with labels, also their values and the objects. */
function shown() {
  const { frame, episodeFrame, gameOver, truncated, mode, difficulty, reward, lives } = session.facts();
  const facts = [...new Sums().add(session).sums, reward, lives, gameOver, truncated, frame, episodeFrame, mode, difficulty];
  if (!input.labels) return facts;
  return [...facts, session.labels(input.labels), session.objects(input.objects)];
}

const CALLS = {
  act: (first, second = 0, strength = 1) => (session.act(first, second, strength), shown()),
  ahead: (frames, action) => [crc32(0, session.screenAhead(frames, action)), ...shown()],
  rgba: () => crc32(0, session.screen()),
  budget: (bytes) => session.budget(bytes),
  reset: () => (session.reset(), shown()),
  seed: (seed) => (session.seed(seed), shown()),
  mode: (mode) => session.setMode(mode),
  difficulty: (difficulty) => session.setDifficulty(difficulty),
  poke: (index, value) => (session.poke(index, value), shown()),
  addWrite: (definition, now) => (slots.push(session.addWrite(definition, now)), slots.at(-1)),
  removeWrite: (slot) => session.removeWrite(slot),
  byteOf: (label, value) => session.byteOf(label, value),
  snapshot: () => base64Of(session.snapshot()),
  restore: (bytes) => (session.restore(bytesOf(bytes)), shown()),
  remember: () => (session.remember(), session.facts().remembered),
  goBack: () => (session.goBack(), shown()),
  record: (release) => session.record(release),
  replay: () => base64Of(session.replay()),
};

/** The sentence of a call that failed, in place of its result. */
function attempt([name, ...values]) {
  try {
    return CALLS[name](...values) ?? null;
  } catch (error) {
    return { error: error.message };
  }
}

console.log(JSON.stringify(input.calls.map(attempt)));
