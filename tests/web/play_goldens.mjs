// Plays the golden values of a game as tests/platforms/goldens.cpp does, and prints what it sees, as JSON.
import { Sums, bytesOf, core, generator, input } from "./node_tools.mjs";

const ACTIONS = 1000;
const game = core.game(input.core, bytesOf(input.image));
let session, chain, reward, resets;

function begin() {
  session?.close();
  session = game.play({ seed: 123, repeat_action_probability: 0, sound: true });
  chain = new Sums();
  reward = resets = 0;
}

function act(action) {
  session.act(action);
  reward += session.facts().reward;
  chain.add(session);
}

function described(withHistory) {
  const words = new Sums().add(session).words().concat(withHistory ? chain.words() : []);
  if (input.stand_in) return words;
  const { lives, gameOver } = session.facts();
  return words.concat([lives, Number(gameOver)], withHistory ? [reward] : []).map(String);
}

const seen = {};
begin();
if ("noop_0" in input.goldens) seen.noop_0 = described(false);
for (let frame = 1; frame <= ACTIONS; frame += 1) {
  act(0);
  if (`noop_${frame}` in input.goldens) seen[`noop_${frame}`] = described(true);
}
begin();
const random = generator(1);
for (let i = 0; i < ACTIONS; i += 1) {
  if (session.facts().gameOver) {
    session.reset();
    resets += 1;
  }
  act(input.actions[random(input.actions.length)]);
}
const { frame, episodeFrame } = session.facts();
seen.random = [...described(true), ...(input.stand_in ? [] : [resets]), frame, episodeFrame].map(String);
console.log(JSON.stringify(seen));
