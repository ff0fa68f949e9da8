// Plays a replay: compares its hashes, shows some frames in any order, goes on by hand. Prints what it finds, as JSON.
import { Sums, base64Of, bytesOf, core, input } from "./node_tools.mjs";

/** The result of a call, or the sentence of its error. */
function attempt(call) {
  try {
    return call();
  } catch (error) {
    return { error: error.message };
  }
}

function seekTo(player, frame) {
  while (!player.seek(frame, 500));
}

function playAll(player) {
  for (;;) {
    const outcome = player.advance(1000);
    if (outcome === "end") return { frames: player.frame, difference: player.difference };
  }
}

function goOn(player, { frame, back = 0, actions }) {
  const recording = player.recorded("0.0.1", frame);
  seekTo(recording, frame);
  const session = recording.takeSession();
  for (let i = 0; i < back; i += 1) if (!session.goBack()) throw new Error("there is no older state");
  const from = new Sums().add(session).sums;
  for (const action of actions) session.act(action);
  return { from, replay: base64Of(session.replay()) };
}

function play(one) {
  const replay = core.replay(bytesOf(one.replay));
  const player = core.game(input.core, bytesOf(input.image)).playReplay(replay);
  const found = { header: replay.header, end: replay.end, ...playAll(player) };
  found.at = (one.at ?? []).map((frame) => (seekTo(player, frame), new Sums().add(player.session).sums));
  if (one.goOn) found.goneOn = goOn(player, one.goOn);
  return found;
}

console.log(JSON.stringify(input.replays.map((one) => attempt(() => play(one)))));
